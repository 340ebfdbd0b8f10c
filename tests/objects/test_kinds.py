"""The table of kinds: complete, consistent, and the only one."""

import ast
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

import lidardraft.objects
from lidardraft.errors import LayoutError
from lidardraft.objects.cars import BODIES
from lidardraft.objects.kinds import KINDS, Kind, kind_of
from lidardraft.scene.road import Road
from lidardraft.semantics import BY_NAME
from lidardraft.streets.ground.ground import Ground
from lidardraft.streets.placement.occupancy import Occupancy

ROOM = Path(lidardraft.objects.__file__).parent


def test_an_unknown_kind_is_an_error_and_never_a_car():
    with pytest.raises(LayoutError, match=r"kind is 'sallon'; it must be one of city_car, .*, cabinet"):
        kind_of("sallon")
    road = Road()
    with pytest.raises(LayoutError, match="kind is 'sallon'"):
        Occupancy(road, Ground(road, np.random.default_rng(0))).place("sallon", 0.0, 1.75, (4.0, 1.8, 1.5))


@pytest.mark.parametrize("name", [field.name for field in fields(Kind)])
def test_no_field_of_a_kind_can_be_forgotten(name: str):
    row = {field.name: getattr(KINDS["bin"], field.name) for field in fields(Kind)}
    del row[name]
    with pytest.raises(TypeError, match=name):
        Kind(**row)


def test_every_builder_is_that_of_a_kind():
    """A builder is a public function of an object and a generator that returns primitives."""
    builders = set()
    for path in ROOM.glob("*.py"):
        for node in ast.parse(path.read_text()).body:
            if isinstance(node, ast.FunctionDef) and not node.name.startswith("_"):
                arguments = [ast.unparse(a.annotation) for a in node.args.args if a.annotation]
                if arguments == ["PlacedObject", "np.random.Generator"] and node.returns:
                    assert ast.unparse(node.returns) == "list[Primitive]", node.name
                    builders.add(f"lidardraft.objects.{path.stem}.{node.name}")
    assert len(builders) > 30
    assert builders == {f"{kind.build.__module__}.{kind.build.__name__}" for kind in KINDS.values()}


def test_every_body_of_a_car_is_a_kind():
    assert {name for name, kind in KINDS.items() if kind.labels == ("car",)} == set(BODIES)


def test_who_is_counted_and_how_often():
    counts = {name: kind.instances for name, kind in KINDS.items()}
    assert {name for name, count in counts.items() if count == 2} == {"cyclist", "motorcyclist"}
    assert {counts[name] for name in (*BODIES, "bus", "tram", "truck", "bicycle", "person")} == {1}
    assert {counts[name] for name in ("house", "tree", "grass", "bin", "sign", "wall", "cabinet")} == {0}
    for kind in KINDS.values():
        assert set(kind.labels) <= set(BY_NAME)
        counted = [BY_NAME[label].is_thing for label in kind.labels]
        assert all(counted) or not any(counted)  # an object has instances or none
