"""What stands beside roads and nobody asked for."""

import math

import numpy as np
import pytest
from random_layouts import random_layout

from lidardraft import Layout, Primitive, detail, layout_from_text
from lidardraft.scene.check import LayoutGround
from lidardraft.scene.edit import remove
from lidardraft.scene.layout import object_of, primitive_mesh
from lidardraft.scene.road import Road
from lidardraft.scene.solids import Solid, penetration
from lidardraft.semantics import BY_NAME, GROUND

STREET = "a crossroads with houses, gardens, trees and parked cars on both sides"


def clutter_of(given: Layout, amount: float, seed: int = 0) -> list[Primitive]:
    names = {object_of(p) for p in detail(given, seed=seed)}
    return [p for p in detail(given, seed=seed, clutter=amount) if object_of(p) not in names]


@pytest.mark.parametrize("sentence", [STREET, "a road curving to the left with trees", "a motorway"])
def test_clutter_stands_beside_the_road_and_touches_nothing_given(sentence: str) -> None:
    given = layout_from_text(sentence, seed=4)
    ground = LayoutGround(given)
    solids = [Solid.from_primitive(p) for p in given if p.label not in GROUND]
    made = clutter_of(given, 1.0)
    assert len({object_of(p) for p in made}) > 15
    for part in made:
        assert not any(penetration(Solid.from_primitive(part), other) for other in solids), part.id
        vertices = primitive_mesh(part).vertices
        for x, y, z in vertices[:: 1 + len(vertices) // 24].tolist():
            below = ground.at(x, y)
            assert below is not None
            assert below[1] != "road" or z > below[0] + 1.5, part.id
    assert not any(BY_NAME[p.label].is_thing for p in made)


def test_more_clutter_is_the_same_and_more() -> None:
    given = Layout(primitives=tuple(Road().surfaces()))
    few, many = ({p.id: p for p in clutter_of(given, amount)} for amount in (0.3, 0.9))
    assert 0 < len(few) < len(many)
    assert all(many[id] == part for id, part in few.items())
    assert not clutter_of(given, 0.0)


def test_an_edit_moves_no_clutter_elsewhere() -> None:
    given = layout_from_text(STREET, seed=2)
    name = next(p.id for p in given if p.label == "building")
    gone = given[name]
    before, after = ({p.id: p for p in clutter_of(one, 1.0)} for one in (given, remove(given, name)))
    assert before.items() <= after.items()
    for part in (after[id] for id in after.keys() - before.keys()):
        assert math.dist(part.center[:2], gone.center[:2]) < math.hypot(*gone.size[:2])


def test_clutter_stands_on_its_ground() -> None:
    given = Layout(primitives=tuple(Road().surfaces()))
    ground = LayoutGround(given)
    parts: dict[str, list[Primitive]] = {}
    for part in clutter_of(given, 1.0):
        parts.setdefault(object_of(part), []).append(part)
    for name, made in parts.items():
        low = min(float(primitive_mesh(p).vertices[:, 2].min()) for p in made)
        middle = np.mean([p.center[:2] for p in made], axis=0)
        assert -0.35 < low - ground.height(*middle.tolist()) < 0.25, name


def test_without_a_road_there_is_none_and_any_layout_is_fine() -> None:
    lawn = Primitive(shape="plane", center=(0, 0, 0), size=(50, 50, 0), label="terrain", id="lawn")
    assert not clutter_of(Layout(primitives=(lawn,)), 1.0)
    assert clutter_of(random_layout(3), 1.0)
