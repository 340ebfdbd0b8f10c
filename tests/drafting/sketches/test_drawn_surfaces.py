import math

import numpy as np
import pytest

from lidardraft.drafting.sketches.drawn_shapes import Blob, Sketch, Stroke
from lidardraft.drafting.sketches.drawn_surfaces import (
    Nearest,
    drawn_surfaces,
    ground_primitives,
    heading,
    height_at,
    smoothed,
)
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.road import KERB_HEIGHT
from lidardraft.simulation.surroundings import road_strips


def stroke(label: str, line: object, width: float, *, closed: bool = False) -> Stroke:
    return Stroke(label, (), "", np.array(line, dtype=np.float64), width, closed)


def surfaces(*strokes: Stroke) -> list[Primitive]:
    return list(ground_primitives(drawn_surfaces(Sketch(1.0, False, strokes=list(strokes)))))


def blob(label: str, x: float, y: float, yaw: float, *, points: bool = False) -> Blob:
    return Blob(label, (), "", np.array([x, y]), 4.0, 2.0, yaw, points)


WOBBLY = [(x, 0.3 * math.sin(x / 3)) for x in np.arange(-40.0, 40.5, 0.5)]
BEND = [(60 * math.sin(t), 60 - 60 * math.cos(t)) for t in np.linspace(-0.6, 0.6, 60)]


def test_a_wobbly_line_is_straight_and_a_bend_is_none() -> None:
    (road,) = surfaces(stroke("road", WOBBLY, 7.0))
    assert (road.shape, road.size) == ("plane", (pytest.approx(80, abs=0.2), 7.0, 0.0))
    assert abs(road.yaw) < 0.01
    (road,) = surfaces(stroke("road", BEND, 7.0))
    assert road.shape == "mesh"
    assert road.size[2] == 0


def test_a_short_arc_stays_bent() -> None:
    """The quarter of a ring between two of its exits: without its ends it is as straight as a hand draws."""
    turn = np.linspace(0.0, math.pi / 2, 40)
    stroke = Stroke("road", (), "", 13.0 * np.stack([np.cos(turn), np.sin(turn)], axis=1), 7.0, False, 0.1)
    (surface,) = drawn_surfaces(Sketch(0.1, False, strokes=[stroke]))
    assert len(surface.line) > 2


def test_a_long_road_whose_ends_are_bent_is_straight() -> None:
    """As where it runs out of a corner of the sheet."""
    along = np.arange(-50.0, 51.0)
    off = np.where(np.abs(along) > 45, (np.abs(along) - 45) * 0.8, 0.0)
    (surface,) = drawn_surfaces(Sketch(0.1, False, strokes=[stroke("road", np.stack([along, off], axis=1), 9.0)]))
    assert len(surface.line) == 2


def test_a_ring_that_smoothing_leaves_nothing_of_is_told() -> None:
    turn = np.linspace(0.0, math.tau, 12)
    ring = Stroke(
        "road", (), "road at pixel 1, 2", 0.3 * np.stack([np.cos(turn), np.sin(turn)], axis=1), 7.0, True, 0.1
    )
    sketch = Sketch(0.1, False, strokes=[ring])
    assert drawn_surfaces(sketch) == []
    assert sketch.ignored == ["road at pixel 1, 2: it has no length"]


def test_the_road_of_a_bend_is_one_that_simulate_knows() -> None:
    (strip,) = road_strips(Layout(tuple(surfaces(stroke("road", BEND, 7.0)))))
    assert strip.half == pytest.approx(3.5, abs=0.02)
    assert strip.length == pytest.approx(72, rel=0.01)
    assert np.abs(np.linalg.norm(strip.middle - (0, 60), axis=1) - 60).max() < 0.3


def test_a_thin_line_is_the_middle_of_a_usual_road() -> None:
    (road,) = surfaces(stroke("road", [(0, 0), (50, 0)], 0.1))
    assert road.size[1] == 7.0
    (walk,) = surfaces(stroke("sidewalk", [(0, 0), (50, 0)], 0.1))
    assert walk.size[1] == 2.0


def test_a_sidewalk_is_as_high_as_a_kerb_and_people_stand_on_it() -> None:
    lines = [stroke("sidewalk", [(0, 5), (30, 5)], 2.0), stroke("sidewalk", [(x, y - 30) for x, y in BEND], 2.0)]
    for walk in surfaces(*lines):
        assert walk.center[2] + walk.size[2] / 2 == pytest.approx(KERB_HEIGHT)
    drawn = Nearest(drawn_surfaces(Sketch(1.0, False, strokes=lines)), "sidewalk")
    assert height_at(drawn, np.array([10.0, 5.5])) == KERB_HEIGHT
    assert height_at(drawn, np.array([10.0, 7.0])) == 0.0


def test_a_ring_stays_closed() -> None:
    turns = np.linspace(0, math.tau, 80)
    ring = stroke("road", np.stack([20 * np.cos(turns), 20 * np.sin(turns)], axis=1), 8.0, closed=True)
    (road,) = surfaces(ring)
    assert road.mesh is not None
    corners = road.mesh.vertices * road.size + road.center
    np.testing.assert_allclose(corners[:2], corners[-2:], atol=1e-6)
    assert np.linalg.norm(corners[:, :2], axis=1).max() == pytest.approx(24, abs=0.5)
    assert np.linalg.norm(corners[:, :2], axis=1).min() == pytest.approx(16, abs=0.5)


def test_smoothing_keeps_the_ends() -> None:
    line = smoothed(stroke("road", WOBBLY, 7.0), 3.0, 1.0)
    np.testing.assert_allclose(line[[0, -1]], np.array(WOBBLY)[[0, -1]], atol=1e-9)
    assert np.abs(line[10:-10, 1]).max() < 0.2


@pytest.mark.parametrize(
    ("label", "x", "y", "yaw", "looks"),
    [
        ("car", 10, -1.8, 0.05, 0.05),
        ("car", 10, -1.8, math.pi + 0.05, 0.05),
        ("car", 10, 1.8, 0.05, math.pi + 0.05),  # right-hand traffic: what is on the left comes
        ("car", 10, 1.8, math.pi / 2, math.pi / 2),  # across the road
        ("car", 10, 60.0, math.pi - 0.1, -0.1),  # far from any road
        ("traffic-light", 10, -6.0, 1.0, 0.0),
        ("traffic-light", 10, 6.0, 1.0, math.pi),
        ("pole", 10, -6.0, 1.0, math.pi),  # a lamp is on the right of its pole
    ],
)
def test_objects_look_as_they_do_beside_a_road(label: str, x: float, y: float, yaw: float, looks: float) -> None:
    road = Nearest(drawn_surfaces(Sketch(1.0, False, strokes=[stroke("road", [(-50, 0), (50, 0)], 7.0)])), "road")
    found = heading(blob(label, x, y, yaw), road)
    assert abs(math.remainder(found - looks, math.tau)) < 1e-6


def test_what_was_drawn_with_a_direction_keeps_it() -> None:
    road = Nearest(drawn_surfaces(Sketch(1.0, False, strokes=[stroke("road", [(-50, 0), (50, 0)], 7.0)])), "road")
    assert heading(blob("car", 10, -1.8, 3.0, points=True), road) == 3.0


def test_a_blob_of_road_is_a_rectangle() -> None:
    sketch = Sketch(1.0, False, blobs=[Blob("road", (), "", np.array([9.0, 2.0]), 20.0, 15.0, 0.5)])
    (square,) = ground_primitives(drawn_surfaces(sketch))
    assert square.size == pytest.approx((20, 15, 0))
    assert square.yaw == pytest.approx(0.5)
