"""Objects before they have details, builders' objects in given boxes, and whole layouts: what obeys and what stays."""

import math

import numpy as np
import pytest
from coarse_boxes import box
from random_layouts import random_layout

from lidardraft import Layout, Primitive, detail, layout_from_text
from lidardraft.errors import LayoutError
from lidardraft.objects.kinds import KINDS
from lidardraft.scene.check import check
from lidardraft.scene.edit import move, remove
from lidardraft.scene.layout import object_of, primitive_mesh
from lidardraft.scene.mesh import TriangleMesh
from lidardraft.semantics import BY_NAME, CLASSES, GROUND
from lidardraft.simulation.detail import fitting
from lidardraft.simulation.detail.coarse_object import CoarseObject, UprightBox, coarse_objects, generator_of
from lidardraft.simulation.detail.detail import RULES
from lidardraft.simulation.detail.fitting import _cut_mesh, fitted

MOST_PROUD = 0.36  # m: eaves; nothing stands out further
SENTENCES = (
    "a busy crossroads with pedestrians crossing, buildings along both sides and traffic lights",
    "a quiet residential street with houses, gardens, trees and parked cars on both sides, and a cyclist",
    "a motorway with three lanes, a truck, a bus, a tram behind and a motorcycle",
    "a road curving to the left with fences on the left, a wall on the right, street lights and traffic signs",
)
TINY, LARGE = (0.01, 0.01, 0.01), (80.0, 60.0, 50.0)


def parts_of(layout: Layout) -> dict[str, list[Primitive]]:
    parts: dict[str, list[Primitive]] = {}
    for primitive in layout:
        parts.setdefault(object_of(primitive), []).append(primitive)
    return parts


def owners(layout: Layout) -> dict[str, set[tuple[str, int]]]:
    return {name: {(p.label, p.instance) for p in parts} for name, parts in parts_of(layout).items()}


def proud(parts: list[Primitive], given: list[Primitive]) -> np.ndarray:
    """How far parts stand out of the box around what was given [m]: along, across, up and down."""
    yaw = max(given, key=lambda part: math.prod(part.size)).yaw
    turn = np.array([[math.cos(yaw), -math.sin(yaw), 0.0], [math.sin(yaw), math.cos(yaw), 0.0], [0.0, 0.0, 1.0]])
    low, high = bounds(given, turn)
    inner_low, inner_high = bounds(parts, turn)
    over = np.maximum(low - inner_low, inner_high - high)
    return np.array([over[0], over[1], inner_high[2] - high[2], low[2] - inner_low[2]])


def bounds(parts: list[Primitive], turn: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    vertices = np.concatenate([primitive_mesh(part).vertices for part in parts]) @ turn
    return vertices.min(axis=0), vertices.max(axis=0)


@pytest.mark.parametrize("seed", range(12))
def test_any_layout_keeps_its_objects_in_their_boxes(seed: int) -> None:
    given = random_layout(seed, headed=bool(seed % 2))
    made = detail(given, seed=seed)
    assert Layout.from_json(made.to_json()) == made
    assert owners(made) == owners(given)
    made_parts = parts_of(made)
    for name, parts in parts_of(given).items():
        if parts[0].label not in GROUND:
            along, across, up, down = proud(made_parts[name], parts)
            assert max(along, across) <= MOST_PROUD, name
            assert max(up, down) <= 1e-6, name


@pytest.mark.parametrize("sentence", SENTENCES)
def test_sentences_keep_their_objects_in_their_boxes(sentence: str) -> None:
    given = layout_from_text(sentence, seed=3)
    made = detail(given, seed=1)
    assert owners(made) == owners(given)
    made_parts = parts_of(made)
    for name, parts in parts_of(given).items():
        if parts[0].label not in GROUND:
            assert proud(made_parts[name], parts).max() <= MOST_PROUD, name
    assert len(made) > len(given) + 20
    assert not [finding for finding in check(made) if finding.check in ("overlap", "ego_clear")]


@pytest.mark.parametrize("headed", [True, False])
def test_an_edit_of_one_object_changes_no_other(headed: bool) -> None:
    given = random_layout(40, 40, headed=headed)
    before = parts_of(detail(given, seed=2))
    name = next(object_of(p) for p in given if p.label == "car")
    for edited in (move(given, name, (0.5, 0.2, 0.0)), remove(given, name)):
        after = parts_of(detail(edited, seed=2))
        assert before.keys() - {name} <= after.keys()
        assert all(after[other] == before[other] for other in before if other != name)


def test_the_ground_and_what_has_a_surface_of_its_own_stay() -> None:
    triangle = np.array([(5.0, 5.0, 0.0), (7.0, 5.0, 0.0), (6.0, 5.0, 2.0)])
    given = Layout(
        primitives=(
            Primitive(shape="plane", center=(0, 0, 0), size=(50, 50, 0), label="terrain", id="lawn"),
            Primitive(shape="box", center=(9, 0, 1), size=(4, 2, 1.5), label="car", id="a", material="chrome"),
            Primitive(shape="box", center=(9, 9, 1), size=(4, 2, 1.5), label="vegetation", id="b", extinction=0.3),
            Primitive.from_mesh(triangle, np.array([[0, 1, 2]]), label="building", id="c"),
            Primitive(shape="cylinder", center=(3, 3, 1), size=(0.1, 0.1, 2), label="pole", id="d.post"),
            Primitive(shape="box", center=(3, 3, 2), size=(0.1, 1, 1), label="other", id="d.flag", material="cloth"),
        )
    )
    assert detail(given) == given


def test_detail_of_a_detailed_layout_is_the_layout() -> None:
    made = detail(layout_from_text(SENTENCES[0], seed=2), seed=2)
    assert detail(made, seed=7) == made


def test_every_class_of_an_object_has_a_rule() -> None:
    assert set(RULES) == {row.name for row in CLASSES} - {"none", *GROUND}


def test_ids_that_look_like_new_ones_are_no_trouble() -> None:
    given = Layout(
        primitives=(
            Primitive(shape="box", center=(9, 0, 1.5), size=(0.3, 9, 3), label="building", id="b.1"),
            Primitive(shape="box", center=(9, 9, 0.2), size=(0.3, 1, 0.4), label="building", id="b"),
            Primitive(shape="plane", center=(0, 0, 0), size=(9, 9, 0), label="terrain", id="b.2"),
        )
    )
    assert {"b", "b.1", "b.2"} <= {p.id for p in detail(given)}


@pytest.mark.parametrize("seed", [-1, 1.5, True, "1"])
def test_a_seed_is_an_integer(seed: object) -> None:
    with pytest.raises(LayoutError, match=r"seed is .*; it must be an integer of 0 to 2"):
        detail(Layout(), seed=seed)  # type: ignore[arg-type]


def names(*parts: Primitive) -> list[list[str]]:
    return [[part.id for part in one.parts] for one in coarse_objects(Layout(primitives=parts), 0)]


def test_the_box_around_parts_holds_them_all() -> None:
    parts = [
        box("pole", (3.0, 0.5, 0.2), at=(1, 2, 6), yaw=0.7),
        box("pole", (0.2, 0.2, 6.0), shape="cylinder", id="p"),
    ]
    around = UprightBox.around(parts)
    cos, sin = math.cos(around.yaw), math.sin(around.yaw)
    points = np.concatenate([primitive_mesh(part).vertices for part in parts]) - (around.x, around.y, around.bottom)
    local = np.column_stack([cos * points[:, 0] + sin * points[:, 1], cos * points[:, 1] - sin * points[:, 0]])
    assert (np.abs(local) <= np.array(around.size[:2]) / 2 + 1e-9).all()
    assert points[:, 2].min() == pytest.approx(0.0)
    assert points[:, 2].max() == pytest.approx(around.size[2])


def test_parts_of_one_name_are_one_object_unless_they_are_several_things() -> None:
    trailer = [
        box("truck", (10, 2.5, 4), id="truck_1", instance=1),
        box("truck", (5, 2.5, 4), at=(23, 3, 0), id="truck_1.1", instance=1),
    ]
    assert names(*trailer) == [["truck_1", "truck_1.1"]]
    cars = [box("car", (4, 2, 1.5), at=(10 * k, 3, 0), id=f"car.{k}") for k in (1, 4)]
    assert names(*cars) == [["car.1"], ["car.4"]]
    numbered = [box("car", (4, 2, 1.5), at=(4 * k, 3, 0), id=f"car.{k}", instance=k) for k in (1, 2)]
    assert names(*numbered) == [["car.1"], ["car.2"]]


def test_a_rider_comes_with_the_nearest_machine() -> None:
    rider = box("rider", (0.7, 0.5, 1.0), id="rider_1")
    near, far = (box("bicycle", (1.8, 0.6, 1.1), at=(15 + off, 3, 0), id=f"bicycle_{off}") for off in (0.3, 2.0))
    assert names(far, rider, near) == [["bicycle_2.0"], ["rider_1", "bicycle_0.3"]]


def test_random_numbers_depend_on_seed_and_name_alone() -> None:
    # a fixed number: another machine, Python or process gives the same
    assert generator_of(1, "car_1").integers(10**9) == generator_of(1, "car_1").integers(10**9) == 717_818_439
    assert len({int(generator_of(seed, name).integers(10**9)) for seed in (1, 2) for name in ("car_1", "car_2")}) == 4


def coarse(label: str, size: tuple[float, float, float]) -> CoarseObject:
    return CoarseObject.of([box(label, size, at=(0, 0, 0))], 0, "it_1")


@pytest.mark.parametrize("kind", [name for name, kind in KINDS.items() if kind.extents])
@pytest.mark.parametrize("which", [0, 1, 2, 3])
def test_every_kind_fits_any_box(kind: str, which: int) -> None:
    size = (*KINDS[kind].extents, TINY, LARGE)[which]
    one = coarse(KINDS[kind].labels[0], size)
    clearance = 0.6 * size[2] if kind in ("house", "tree", "sign", "traffic_light") else 0.0
    parts = fitted(one, kind, UprightBox(0, 0, 0, 0.0, size), clearance=clearance, proud=(0.1, 0.1, 0.0))
    vertices = np.concatenate([primitive_mesh(part).vertices for part in parts])
    assert (np.abs(vertices[:, :2]) <= np.array(size[:2]) / 2 + 0.1 + 1e-6).all()
    assert vertices[:, 2].min() >= -1e-6
    assert vertices[:, 2].max() <= size[2] + 1e-6
    assert all(part.material is not None and part.label in one.owners for part in parts)
    assert {BY_NAME[part.label].name for part in parts} == {one.label}


def test_a_mesh_is_cut_where_the_ground_is_and_cut_once() -> None:
    square = TriangleMesh(
        np.array([(-0.5, 0, -0.5), (0.5, 0, -0.5), (0.5, 0, 0.5), (-0.5, 0, 0.5)]), np.array([[0, 1, 2], [0, 2, 3]])
    )
    cut = _cut_mesh(square, -0.25)
    assert cut.vertices[:, 2].min() == -0.5
    assert cut.vertices[:, 2].max() == 0.5
    assert _cut_mesh(square, -0.25) is cut
    assert _cut_mesh(square, 0.25) is not cut


def test_a_cut_is_whole_where_another_thread_clears_those_that_are_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    class Cleared(dict):  # as soon as it is written
        def __setitem__(self, key, value):
            super().__setitem__(key, value)
            self.clear()

    monkeypatch.setattr(fitting, "_cuts", Cleared())
    square = TriangleMesh(np.array([(-0.5, 0, -0.5), (0.5, 0, -0.5), (0.5, 0, 0.5)]), np.array([[0, 1, 2]]))
    assert _cut_mesh(square, -0.25).vertices[:, 2].min() == -0.5
