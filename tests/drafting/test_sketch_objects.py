"""Blobs and strokes become objects and surfaces: kinds, sizes, places and headings."""

import math

import numpy as np
import pytest

from lidardraft.drafting.sketch.objects import NotDrawnError, Placed, kind_of, objects_of_blob, objects_of_stroke
from lidardraft.drafting.sketch.shapes import Blob, Sketch, Stroke
from lidardraft.drafting.sketch.surfaces import Nearest, drawn_surfaces, ground_primitives, heading, height_at
from lidardraft.objects.coarse_shapes import extents
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.road import KERB_HEIGHT
from lidardraft.semantics import CLASSES, GROUND
from lidardraft.simulation.roads import road_strips

WOBBLY = [(x, 0.3 * math.sin(x / 3)) for x in np.arange(-40.0, 40.5, 0.5)]
BEND = [(60 * math.sin(t), 60 - 60 * math.cos(t)) for t in np.linspace(-0.6, 0.6, 60)]


def blob(label: str, length: float, width: float, *names: str, yaw: float = 0.0) -> Blob:
    return Blob(label, names, "", np.array([10.0, 5.0]), length, width, yaw)


def stroke(label: str, line: object, width: float, *names: str, closed: bool = False, grain: float = 0.0) -> Stroke:
    return Stroke(label, names, "here", np.array(line, dtype=np.float64), width, closed, grain)


def ring(radius: float, count: int = 80) -> np.ndarray:
    turns = np.linspace(0, math.tau, count)
    return radius * np.stack([np.cos(turns), np.sin(turns)], axis=1)


def of_blob(label: str, length: float, width: float, yaw: float = 0.0, *names: str) -> list[Placed]:
    return list(objects_of_blob(blob(label, length, width, *names, yaw=yaw), yaw, np.random.default_rng(0)))


def of_stroke(label: str, line: object, width: float, *names: str) -> list[Placed]:
    return list(objects_of_stroke(stroke(label, line, width, *names), np.random.default_rng(0)))


def size_of(placed: Placed) -> tuple[float, float, float]:
    return extents([part for part, _ in placed[1]])


def surfaces(*strokes: Stroke) -> list[Primitive]:
    return list(ground_primitives(drawn_surfaces(Sketch(1.0, False, strokes=list(strokes)))))


# Kinds


@pytest.mark.parametrize("label", [row.name for row in CLASSES[1:] if row.name not in GROUND])
def test_every_class_that_stands_on_the_ground_has_a_kind(label: str) -> None:
    assert kind_of(blob(label, 4.0, 2.0)).sizes is not None


@pytest.mark.parametrize(
    ("shape", "kind"),
    [
        (blob("building", 11, 9), "house"),
        (blob("building", 20, 14), "building"),
        (blob("building", 20, 14, "villa"), "house"),
        (blob("building", 8, 8, "office tower"), "building"),
        (blob("vegetation", 4, 4), "tree"),
        (blob("vegetation", 1.5, 1.5), "bush"),
        (blob("vegetation", 1.5, 1.5, "trees"), "tree"),
        (blob("car", 4.3, 1.8), "car"),
        (blob("car", 5.4, 2.0), "van"),
        (blob("car", 17.0, 1.8), "car"),  # a row of them
        (blob("car", 5.0, 1.8, "car-3"), "car"),
        (blob("car", 4.3, 1.8, "deliveryVan_2"), "van"),
        (blob("wall", 4.3, 0.2, "house wall"), "wall"),
        (blob("pole", 0.5, 0.5, "street lamp"), "street-light"),
        (blob("pole", 0.5, 0.5, "street lights"), "street-light"),
        (blob("other", 0.5, 0.5, "traffic cone"), "cone"),
        (blob("other", 0.5, 0.5), "bin"),
    ],
)
def test_names_come_before_sizes(shape: Blob, kind: str) -> None:
    assert kind_of(shape).name == kind


# Objects


def test_a_house_and_a_car_are_as_large_as_they_were_drawn() -> None:
    for label, length, width in (("building", 14.0, 9.0), ("car", 4.4, 1.9), ("bus", 12.0, 2.5)):
        (placed,) = of_blob(label, length, width, 0.4)
        assert size_of(placed)[:2] == pytest.approx((length, width))
        assert {yaw for _, yaw in placed[1]} == {0.4}
        assert placed[2].tolist() == [10.0, 5.0]


def test_a_dot_is_an_object_of_the_usual_size() -> None:
    assert 3.5 < size_of(*of_blob("car", 1.0, 1.0))[0] < 5.0
    assert size_of(*of_blob("pole", 0.9, 0.9))[0] < 0.3
    assert len(of_blob("person", 2.0, 2.0)) == 1


def test_a_long_stroke_of_cars_is_a_row_of_them() -> None:
    row = of_blob("car", 26.0, 1.8, math.pi / 2, "cars")
    places = np.array([place for _, _, place in row])
    np.testing.assert_allclose(places, [(10.0, 5.0 + 5.2 * k) for k in range(-2, 3)])
    assert max(size_of(placed)[0] for placed in row) < 4.3


@pytest.mark.parametrize(("label", "length", "width"), [("car", 30.0, 20.0), ("pole", 80.0, 7.0), ("person", 9.0, 1.0)])
def test_what_no_object_is_as_large_as_is_told(label: str, length: float, width: float) -> None:
    with pytest.raises(NotDrawnError, match=rf"{length} x {width} m is too large for a {label}"):
        of_blob(label, length, width)


def test_a_tree_is_as_wide_as_its_disc_and_a_wood_is_many_trees() -> None:
    side = 4.0 * math.sqrt(3) / 2  # of the square with the moments of a disc 4 m across
    assert size_of(*of_blob("vegetation", side, side))[:2] == pytest.approx((4.0, 4.0))
    wood = of_blob("vegetation", 36.0, 24.0, 0.3)
    assert len(wood) == 24
    along = (np.array([place for _, _, place in wood]) - (10.0, 5.0)) @ (math.cos(0.3), math.sin(0.3))
    assert np.abs(along).max() == pytest.approx(15.0)


def test_a_hedge_bends_with_its_stroke() -> None:
    ((kind, parts, place),) = of_stroke("vegetation", [(0, 0), (10, 0), (10, 8)], 1.0)
    assert kind == "hedge"
    assert [round(part.size[0]) for part, _ in parts] == [10, 8]
    for (part, yaw), middle in zip(parts, ((5, 0), (10, 4)), strict=True):
        cos, sin = math.cos(yaw), math.sin(yaw)
        x, y, z = part.center
        there = np.array([cos * x - sin * y, sin * x + cos * y])
        np.testing.assert_allclose(place + there, middle, atol=0.5)
        assert z == part.size[2] / 2
        assert part.size[1] == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("label", "drawn", "width"),
    [
        *(("wall", 0.3, 0.3), ("wall", 0.8, 0.8), ("fence", 0.3, 0.3), ("vegetation", 2.0, 2.0)),
        *(("wall", 0.05, 0.2), ("fence", 0.02, 0.06)),  # a line: as thin as such strips are
    ],
)
def test_a_straight_strip_is_one_box_as_thick_as_drawn(label: str, drawn: float, width: float) -> None:
    ((_, parts, place),) = of_stroke(label, [(0, 0), (12, 0.1)], drawn)
    ((part, _),) = parts
    assert part.name == ""
    assert part.size[:2] == pytest.approx((12.0, width), abs=0.001)
    np.testing.assert_allclose(place, (6, 0.05), atol=1e-6)
    if label != "vegetation":
        assert size_of(*of_blob(label, 3.0, drawn))[:2] == pytest.approx((3.0, width))


def test_a_wide_stroke_of_plants_is_a_row_of_trees_unless_it_is_called_a_hedge() -> None:
    row = of_stroke("vegetation", [(0, 0), (40, 0)], 5.0)
    assert [kind for kind, _, _ in row] == ["tree"] * 7
    assert [kind for kind, _, _ in of_stroke("vegetation", [(0, 0), (40, 0)], 5.0, "hedge")] == ["hedge"]


def test_a_stroke_of_no_length_is_told() -> None:
    with pytest.raises(NotDrawnError, match="no length"):
        of_stroke("fence", [(3, 3), (3, 3)], 0.2)
    sketch = Sketch(0.1, False, strokes=[stroke("road", ring(0.3, 12), 7.0, closed=True, grain=0.1)])
    assert drawn_surfaces(sketch) == []
    assert sketch.ignored == ["here: it has no length"]


# Surfaces


def test_a_wobbly_line_is_straight_and_a_bend_is_none() -> None:
    (road,) = surfaces(stroke("road", WOBBLY, 7.0))
    assert (road.shape, road.size) == ("plane", (pytest.approx(80, abs=0.2), 7.0, 0.0))
    assert abs(road.yaw) < 0.01
    (road,) = surfaces(stroke("road", BEND, 7.0))
    assert (road.shape, road.size[2]) == ("mesh", 0)


def test_a_short_arc_stays_bent_and_a_long_road_is_straight_whatever_its_ends_do() -> None:
    """The quarter of a ring between two of its exits, and a road that runs out of a corner of the sheet."""
    (arc,) = surfaces(stroke("road", ring(13.0, 160)[:40], 7.0, grain=0.1))
    assert arc.shape == "mesh"
    along = np.arange(-50.0, 51.0)
    off = np.maximum(np.abs(along) - 45, 0) * 0.8
    (road,) = surfaces(stroke("road", np.stack([along, off], axis=1), 9.0))
    assert road.shape == "plane"


def test_the_road_of_a_bend_is_one_that_simulate_knows() -> None:
    (strip,) = road_strips(Layout(tuple(surfaces(stroke("road", BEND, 7.0)))))
    assert strip.half == pytest.approx(3.5, abs=0.02)
    assert strip.line.length == pytest.approx(72, rel=0.01)
    assert np.abs(np.linalg.norm(strip.line.middle - (0, 60), axis=1) - 60).max() < 0.3


@pytest.mark.parametrize(("label", "width"), [("road", 7.0), ("sidewalk", 2.0)])
def test_a_thin_line_is_the_middle_of_a_usual_surface(label: str, width: float) -> None:
    assert surfaces(stroke(label, [(0, 0), (50, 0)], 0.1))[0].size[1] == width


def test_a_sidewalk_is_as_high_as_a_kerb_and_people_stand_on_it() -> None:
    lines = [stroke("sidewalk", [(0, 5), (30, 5)], 2.0), stroke("sidewalk", [(x, y - 30) for x, y in BEND], 2.0)]
    for walk in surfaces(*lines):
        assert walk.center[2] + walk.size[2] / 2 == pytest.approx(KERB_HEIGHT)
    drawn = Nearest(drawn_surfaces(Sketch(1.0, False, strokes=lines)), "sidewalk")
    assert height_at(drawn, np.array([10.0, 5.5])) == KERB_HEIGHT
    assert height_at(drawn, np.array([10.0, 7.0])) == 0.0


def test_a_ring_stays_closed() -> None:
    (road,) = surfaces(stroke("road", ring(20.0), 8.0, closed=True))
    assert road.mesh is not None
    corners = road.mesh.vertices * road.size + road.center
    np.testing.assert_allclose(corners[:2], corners[-2:], atol=1e-6)
    away = np.linalg.norm(corners[:, :2], axis=1)
    assert (away.min(), away.max()) == (pytest.approx(16, abs=0.5), pytest.approx(24, abs=0.5))


def test_a_blob_of_road_is_a_rectangle() -> None:
    (square,) = ground_primitives(drawn_surfaces(Sketch(1.0, False, blobs=[blob("road", 20.0, 15.0, yaw=0.5)])))
    assert square.size == pytest.approx((20, 15, 0))
    assert square.yaw == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("label", "y", "yaw", "looks"),
    [
        ("car", -1.8, 0.05, 0.05),
        ("car", -1.8, math.pi + 0.05, 0.05),
        ("car", 1.8, 0.05, math.pi + 0.05),  # right-hand traffic: what is on the left comes
        ("car", 1.8, math.pi / 2, math.pi / 2),  # across the road
        ("car", 60.0, math.pi - 0.1, -0.1),  # far from any road
        ("traffic-light", -6.0, 1.0, 0.0),
        ("traffic-light", 6.0, 1.0, math.pi),
        ("pole", -6.0, 1.0, math.pi),  # a lamp is on the right of its pole
    ],
)
def test_objects_look_as_they_do_beside_a_road(label: str, y: float, yaw: float, looks: float) -> None:
    road = Nearest(drawn_surfaces(Sketch(1.0, False, strokes=[stroke("road", [(-50, 0), (50, 0)], 7.0)])), "road")
    found = heading(Blob(label, (), "", np.array([10.0, y]), 4.0, 2.0, yaw), road)
    assert abs(math.remainder(found - looks, math.tau)) < 1e-6
    assert heading(Blob(label, (), "", np.array([10.0, y]), 4.0, 2.0, 3.0, points=True), road) == 3.0
