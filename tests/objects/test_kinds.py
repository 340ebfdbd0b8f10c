"""The table of kinds: complete, consistent, the only one; and what holds for objects of every kind."""

import ast
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from built_objects import SIZES, build, is_closed, placed, vertices

import lidardraft.objects
from lidardraft import CLASSES
from lidardraft.errors import LayoutError
from lidardraft.objects.buildings import BALCONY, EAVES
from lidardraft.objects.cars import BODIES
from lidardraft.objects.coarse_shapes import MOST_LOBES
from lidardraft.objects.collision_boxes import CROWN_CORE
from lidardraft.objects.kinds import KINDS, SENTENCE_KINDS, kind_of
from lidardraft.scene import class_names
from lidardraft.scene.materials import MATERIAL_BY_NAME
from lidardraft.semantics import BY_NAME

ROOM = Path(lidardraft.objects.__file__).parent
THINGS = {row.name for row in CLASSES if row.is_thing}
# How far something sticks out of the extents [m], (length, width, height); 0.06 m is allowed to all.
OUT: dict[str, tuple[float, float, float]] = {
    **dict.fromkeys(BODIES, (0.03, 0.12, 0.0)),  # plates, mirrors
    "truck": (0.08, 0.16, 0.1),
    "trailer_truck": (0.08, 0.16, 0.1),
    "bus": (0.11, 0.16, 0.0),
    "bicycle": (0.1, 0.12, 0.05),
    "cyclist": (0.1, 0.12, 0.0),
    "motorcycle": (0.1, 0.1, 0.1),
    "motorcyclist": (0.1, 0.1, 0.0),
    "person": (0.25, 0.12, 0.0),  # a rucksack, the swing of arms and legs
    "house": (EAVES, EAVES, 0.55),  # a chimney
    "block": (0.0, BALCONY, 0.75),
    "shed": (0.1, 0.1, 0.0),
    "lamp": (0.2, 1.95, 0.0),
    "sign": (0.05, 0.0, 0.0),
    "traffic_light": (0.32, 0.2, 0.0),
    "gantry": (0.1, 0.0, 0.0),
    "billboard": (0.03, 0.0, 0.0),
    "barrier": (0.0, 0.0, 0.1),
}
# The kinds whose meshes are all closed; bodies of vehicles, facades, plates and palings are sheets.
CLOSED = ("motorcycle", "motorcyclist", "person", "tree", "mesh_fence", "wall", "shelter", "bin", "cone")


def test_an_unknown_kind_is_an_error_that_suggests_what_was_meant():
    with pytest.raises(LayoutError, match=r"kind is 'sallon'; .* did you mean 'saloon'\?"):
        kind_of("sallon")


def test_every_builder_is_that_of_a_kind():
    """A builder is a public function that adds to an object with a generator."""
    builders = set()
    for path in ROOM.glob("*.py"):
        for node in ast.parse(path.read_text()).body:
            if isinstance(node, ast.FunctionDef) and not node.name.startswith("_"):
                arguments = [ast.unparse(a.annotation) for a in node.args.args if a.annotation]
                if arguments == ["ObjectBuilder", "np.random.Generator"]:
                    builders.add(f"lidardraft.objects.{path.stem}.{node.name}")
    assert len(builders) > 30
    assert builders == {f"{kind.add.__module__}.{kind.add.__name__}" for kind in KINDS.values()}


def test_every_kind_is_tested_and_every_class_is_that_of_a_kind_or_of_the_ground():
    assert set(SIZES) == set(KINDS)
    labels = {label for kind in KINDS.values() for label in kind.labels}
    assert {row.name for row in CLASSES} == labels | {"none", "road", "sidewalk"}


def test_who_is_counted_and_how_often():
    counts = {name: kind.instances for name, kind in KINDS.items()}
    assert {name for name, count in counts.items() if count == 2} == {"cyclist", "motorcyclist"}
    assert {counts[name] for name in (*BODIES, "bus", "tram", "truck", "bicycle", "person")} == {1}
    assert {counts[name] for name in ("house", "tree", "grass", "bin", "sign", "wall", "cabinet")} == {0}
    for kind in KINDS.values():
        counted = [BY_NAME[label].is_thing for label in kind.labels]
        assert all(counted) or not any(counted)  # an object has instances or none


def test_what_a_sentence_calls_a_kind_is_of_its_classes():
    """The class of the word and those of the builder are given separately: a kind in another's row differs."""
    of_words = {name: SENTENCE_KINDS[kind.word].label for name, kind in KINDS.items() if kind.word}
    assert all(label in KINDS[name].labels for name, label in of_words.items())
    things = {name: label for name, label in of_words.items() if label in THINGS}
    assert all(KINDS[name].labels[-1] == label for name, label in things.items())  # the cyclist's word is the bicycle's
    furniture = {"letterbox", "hydrant", "cabinet", "billboard", "gantry", "crate", "plant_tub", "cafe_table"}
    assert set(KINDS) - of_words.keys() == furniture | {"shed", "grass", "ground_cover", "shelter", "cone"}


def test_names_of_models_say_kinds_of_the_table() -> None:
    said = [meaning.split(" ") for meaning in class_names._MEANING.values() if " " in meaning]
    assert len(said) > 20
    assert all(SENTENCE_KINDS[kind].label == label for label, kind in said)


@pytest.mark.parametrize("kind", KINDS)
def test_objects_of_many_seeds_keep_to_their_extents_classes_instances_and_materials(kind: str):
    seen: set[str] = set()
    for seed in range(100):
        made = placed(kind, seed)
        primitives = build(made, seed)
        # unit shapes lie within [-1/2, 1/2]^3: their boxes hold them
        for p in primitives:
            turned = abs(math.sin(p.yaw)) > 0.5
            half = np.array(p.size)[[1, 0, 2] if turned else [0, 1, 2]] / 2
            reach = np.abs(p.center[:2]) + half[:2] - np.array(made.size[:2]) / 2
            out = OUT.get(kind, (0.0, 0.0, 0.0))
            if not (kind == "tree" and p.label == "trunk"):
                assert (reach < np.array(out[:2]) + 0.06).all(), (p.id, reach)
            assert p.center[2] + half[2] < made.size[2] + out[2] + 0.06, p.id
            assert replace(p) == p  # which checks every field
            assert p.material is None or p.material in MATERIAL_BY_NAME
            # the classes of a kind are in the order of its instances
            assert p.instance == (5 + KINDS[kind].labels.index(p.label) if p.label in THINGS else 0)
        seen |= {p.label for p in primitives}
        assert len({p.id for p in primitives}) == len(primitives)
        assert {p.id.partition(".")[0] for p in primitives} == {made.id}
    assert seen == set(KINDS[kind].labels)


@pytest.mark.parametrize("kind", KINDS)
def test_objects_are_turned_and_moved_as_a_whole_and_the_same_each_time(kind: str):
    yaw, at = 0.7, (12.0, -3.0, 0.4)
    for seed in range(3):
        straight, moved = build(placed(kind, seed), seed), build(placed(kind, seed, yaw, at), seed)
        assert build(placed(kind, seed), seed) == straight
        cos, sin = math.cos(yaw), math.sin(yaw)
        turn = np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
        for one, two in zip(straight, moved, strict=True):
            assert vertices(two) == pytest.approx(vertices(one) @ turn + at, abs=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_nothing_floats(kind: str):
    """Parts whose boxes touch, to 6 cm, hang together, and the lowest of them reach the ground."""
    for seed in range(15):
        made = placed(kind, seed)
        primitives = build(made, seed)
        corners = [vertices(p) for p in primitives]
        low = np.array([v.min(axis=0) for v in corners]) - 0.03
        high = np.array([v.max(axis=0) for v in corners]) + 0.03
        near = ((low[:, None] <= high) & (high[:, None] >= low)).all(axis=2)
        held = low[:, 2] <= 0.02
        assert held.any()
        for _ in corners:
            held = (near & held).any(axis=1)
        floating = [p.id for p, ok in zip(primitives, held, strict=True) if not ok]
        assert not floating, (seed, floating)


@pytest.mark.parametrize("kind", CLOSED)
def test_meshes_are_closed(kind: str):
    meshes = [p.mesh for seed in range(20) for p in build(placed(kind, seed), seed) if p.mesh is not None]
    assert meshes
    assert all(is_closed(mesh) for mesh in meshes)


@pytest.mark.parametrize("kind", KINDS)
def test_every_detail_lies_in_a_box_of_its_object(kind: str):
    for seed in range(12):
        made = placed(kind, seed)
        solids = KINDS[kind].solids(made.place, made.size, made.clearance)
        boxes = np.array([(s.x, s.y, 2 * s.half_length, 2 * s.half_width, s.bottom, s.top) for s in solids])
        # mirrors, chimneys, tips of leaves and of limbs stick out
        slack = 0.16 + 0.02 * max(made.size[:2]) + 0.1 * (kind in ("tree", "person"))
        slack += (1.0 - CROWN_CORE) / 2 * max(made.size[:2]) * (kind == "tree")  # so do the rims of crowns
        low = np.column_stack([boxes[:, :2] - boxes[:, 2:4] / 2 - slack, boxes[:, 4] - 1.3])
        high = np.column_stack([boxes[:, :2] + boxes[:, 2:4] / 2 + slack, boxes[:, 5] + 0.8])
        for p in build(made, seed):
            corners = vertices(p)
            inside = ((corners[:, None] >= low) & (corners[:, None] <= high)).all(axis=2).any(axis=1)
            assert inside.all(), (p.id, corners[~inside][0])


def test_something_may_stand_under_a_crown_a_board_and_a_gantry():
    for kind in ("tree", "sign", "billboard", "gantry"):
        made = placed(kind, 1)
        boxes = KINDS[kind].boxes(made.size, made.clearance)
        low = [box for box in boxes if box.bottom < made.clearance]
        assert sum(4 * box.half_length * box.half_width for box in low) < 0.6 * made.size[0] * made.size[1]
        assert max(box.top for box in boxes) == made.size[2]


def test_the_arm_of_a_lamp_is_on_its_left():
    post, arm = KINDS["lamp"].boxes((0.2, 0.2, 8.0), 0.0)
    assert post.y == 0.0
    assert arm.y - arm.half_width <= 0.0 < arm.y
    assert arm.bottom > 7.0


@pytest.mark.parametrize("kind", KINDS)
def test_coarse_shapes_have_the_classes_and_instances_of_the_kind_and_fill_its_extents(kind: str):
    labels = KINDS[kind].labels
    for variant in range(len(SIZES[kind])):
        made = placed(kind, variant)
        shapes = KINDS[kind].coarse(made)
        assert {shape.label for shape in shapes} <= set(labels)
        assert bool(shapes) == (kind != "grass")
        for shape in shapes:
            assert shape.instance_offset == (labels.index(shape.label) if shape.label in THINGS else 0)
        for lobes in range(1, MOST_LOBES + 1):
            chosen = [shape for shape in shapes if shape.lobes in (0, lobes)]
            if not chosen:
                continue
            size = np.array(made.size)
            low = np.min([np.subtract(shape.center, np.array(shape.size) / 2) for shape in chosen], axis=0)
            high = np.max([np.add(shape.center, np.array(shape.size) / 2) for shape in chosen], axis=0)
            # the posts of a sign are thicker than its plate
            assert (low >= [-size[0] / 2 - 0.06, -size[1] / 2 - 0.06, -1e-9]).all()
            assert (high <= [size[0] / 2 + 0.06, size[1] / 2 + 0.06, size[2] + 1e-9]).all()
            if kind not in ("cyclist", "motorcyclist", "house", "sign", "lamp", "pole"):
                # the lobes of a crown lie around its middle, not all the way to every side
                slack = 0.25 * size * (lobes > 1 and kind == "tree")
                assert (high - low >= size - slack - 1e-9).all()


def test_a_rider_sits_on_what_is_ridden():
    rider, bicycle = KINDS["cyclist"].coarse(placed("cyclist"))
    assert (rider.label, bicycle.label) == ("rider", "bicycle")
    assert rider.center[2] > bicycle.center[2]
    # the knees and feet belong to what is ridden
    assert 0.6 < rider.center[2] - rider.size[2] / 2 < bicycle.size[2]
