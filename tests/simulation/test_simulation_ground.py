"""Markings and kerbs; what a rule learns of the roads, fronts and backs around an object."""

import math

import numpy as np
import pytest
from coarse_boxes import box

from lidardraft import Layout, Primitive, detail, layout_from_cloud, layout_from_text
from lidardraft.scene import edit
from lidardraft.scene.layout import primitive_mesh
from lidardraft.scene.road import KERB_HEIGHT, PavedArea, Road
from lidardraft.scene.road_surfaces import road_surfaces
from lidardraft.semantics import BY_NAME
from lidardraft.simulation.detail.coarse_object import CoarseObject, UprightBox
from lidardraft.simulation.detail.surroundings import Surroundings
from lidardraft.simulation.roads import RoadStrip, lanes_of, road_strips
from spec_checker import road_of


def of(road: Road) -> dict[str, Primitive]:
    return {p.id: p for p in detail(Layout(primitives=tuple(road_surfaces(road)))).primitives}


def across(road: Road, part: Primitive) -> np.ndarray:
    vertices = primitive_mesh(part).vertices
    return road.along_across(vertices[:, 0], vertices[:, 1])[1]


@pytest.mark.parametrize("lanes", [1, 2, 3])
@pytest.mark.parametrize("ego_lane", [0, 1])
@pytest.mark.parametrize("parking", [0.0, 2.2, 3.0])
@pytest.mark.parametrize("width", [3.3, 3.5, 3.75])
def test_the_lanes_of_the_solver_are_found(lanes: int, ego_lane: int, parking: float, width: float) -> None:
    road = Road(lanes=lanes, ego_lane=min(ego_lane, lanes - 1), parking=parking, lane_width=width)
    (strip,) = road_strips(Layout(primitives=tuple(road_surfaces(road))))
    assert lanes_of(strip) == (lanes, pytest.approx(width), pytest.approx(parking, abs=1e-9), True)


@pytest.mark.parametrize("curvature", [0.0, 0.01])
def test_lines_lie_between_the_lanes_on_the_road(curvature: float) -> None:
    road = Road(lanes=2, curvature=curvature)
    lines = of(road)["road.markings"]
    assert (lines.label, lines.material) == ("road", "road-paint")
    off = across(road, lines)
    nearest = np.abs(off[:, None] - np.array([-3.5, 0.0, 3.5])).min(axis=1)
    assert nearest.max() < 0.09
    assert {round(float(v) / 3.5) for v in off} == {-1, 0, 1}
    assert primitive_mesh(lines).vertices[:, 2] == pytest.approx(0.005)


def test_roads_without_sidewalks_have_edge_lines_and_narrow_ones_none() -> None:
    road = Road(sidewalk=0.0)
    assert np.abs(across(road, of(road)["road.markings"])).max() == pytest.approx(road.edge - 0.25 + 0.06)
    lane = Primitive(shape="plane", center=(0, 0, 0), size=(60, 4, 0), label="road", id="lane")
    assert len(detail(Layout(primitives=(lane,)))) == 1


def test_no_line_crosses_a_crossing_road() -> None:
    road = Road(junction=30.0)
    parts = of(road)
    for name in ("road.markings", "road_left.markings", "road_right.markings"):
        vertices = primitive_mesh(parts[name]).vertices
        assert not ((np.abs(vertices[:, 0] - 30.0) < road.edge) & (np.abs(vertices[:, 1] - 1.75) < road.edge)).any()


@pytest.mark.parametrize("curvature", [0.0, 0.01])
def test_kerbstones_line_the_sidewalks_on_the_side_of_the_road(curvature: float) -> None:
    road = Road(curvature=curvature)
    parts = of(road)
    for name, side in (("sidewalk_1.kerb", -1), ("sidewalk_2.kerb", 1)):
        off = side * across(road, parts[name])
        assert off.min() == pytest.approx(road.edge, abs=0.01)
        assert off.max() == pytest.approx(road.edge + 0.15, abs=0.01)
        assert primitive_mesh(parts[name]).vertices[:, 2].max() == pytest.approx(KERB_HEIGHT + 0.003)
        assert (parts[name].label, parts[name].material) == ("sidewalk", "concrete")


@pytest.mark.parametrize(("lanes", "lines"), [(1, 0), (2, 1), (3, 2)])
def test_lines_of_one_way_roads_lie_between_their_lanes(lanes: int, lines: int) -> None:
    for ego_lane in range(lanes):
        road = Road(lanes=lanes, ego_lane=ego_lane, one_way=True)
        parts = of(road)
        assert ("road.markings" in parts) == (lines > 0)
        if lines:
            off = across(road, parts["road.markings"])
            places = (np.arange(1, lanes) - lanes / 2) * 3.5
            assert np.abs(off[:, None] - places).min(axis=1).max() < 0.07


def test_no_line_crosses_a_roundabout_and_a_car_park_has_no_lanes() -> None:
    road = Road(junction=40.0, roundabout_radius=18.0, paved_areas=(PavedArea((-40.0, -5.0), (3.5, 20.0)),))
    parts = of(road)
    assert "patch_1.markings" not in parts
    vertices = primitive_mesh(parts["road.markings"]).vertices
    assert np.hypot(vertices[:, 0] - 40.0, vertices[:, 1] - 1.75).min() > 18.0


def test_the_cars_of_a_parking_lot_stand_between_the_lines_of_its_bays() -> None:
    layout = layout_from_text("a parking lot with parked cars on both sides", seed=4)
    lines = primitive_mesh({p.id: p for p in detail(layout)}["road.markings"]).vertices
    cars = [p for p in layout if p.label == "car" and abs(math.sin(p.yaw)) > 0.9]
    assert len(cars) > 4
    for car in cars:
        near = lines[np.abs(lines - car.center)[:, 1] < 4.0, 0] - car.center[0]
        assert 0.9 < np.abs(near).min() < 1.4


def marked(layout: Layout) -> tuple[Road, np.ndarray]:
    """The road of a sentence, and along and across of its paint [N, 2]."""
    road = road_of(layout)
    vertices = primitive_mesh({p.id: p for p in detail(layout)}["road.markings"]).vertices
    return road, np.column_stack(road.along_across(vertices[:, 0], vertices[:, 1]))


def test_traffic_waits_behind_a_line_where_a_crossroads_has_lights() -> None:
    for sentence, lines in (("a crossroads downtown with traffic lights", True), ("a crossroads downtown", False)):
        layout = layout_from_text(sentence, seed=3)
        road, paint = marked(layout)
        assert road.junction is not None
        before = road.junction - road.verge - paint[:, 0]
        own = (before > 0.4) & (before < 1.1) & (paint[:, 1] < 0.0)
        assert own.any() == lines
        if lines:
            assert np.ptp(paint[own, 1]) > 2.0  # across a lane


@pytest.mark.parametrize("sentence", ["two pedestrians cross the street", "a crossroads, a child crosses the street"])
def test_people_cross_on_a_zebra(sentence: str) -> None:
    layout = layout_from_text(sentence, seed=2)
    road, paint = marked(layout)
    (x, y, _), *_ = (p.center for p in layout if p.label == "person")
    along, _ = road.along_across(x, y)
    bars = paint[np.abs(paint[:, 0] - along) < 3.5]  # a bar a metre, with two sides
    assert len({round(float(across), 1) for across in bars[:, 1]}) > 2 * (2 * road.edge - 2.0)
    if road.junction is not None:
        assert (np.abs(bars[:, 0] - road.junction) > road.edge).all()


def test_a_road_that_was_moved_is_marked_where_it_is_now() -> None:
    layout = layout_from_text("two cars ahead on a road with two lanes in each direction", seed=1)
    moved = edit.move(layout, "road", by=(0.0, 30.0, 0.0))
    off = [primitive_mesh({p.id: p for p in detail(one)}["road.markings"]).vertices[:, 1] for one in (layout, moved)]
    assert off[1].mean() - off[0].mean() == pytest.approx(30.0, abs=1.0)


def test_only_clusterings_know_no_front_from_back() -> None:
    points = np.array([[12.0, 0, 0.1 * k] for k in range(8)] + [[x, 2, -1.7] for x in range(5, 25)])
    labels = np.array([BY_NAME["car"].id] * 8 + [BY_NAME["road"].id] * 20)
    clustered = layout_from_cloud(points, labels, sensor_height=1.7)
    assert Surroundings.of(clustered).clustered
    assert Surroundings.of(Layout.from_json(clustered.to_json())).clustered
    assert not Surroundings.of(layout_from_text("a car ahead")).clustered
    assert not Surroundings.of(Layout()).clustered


def test_across_the_road_either_heading_is_as_likely() -> None:
    around = Surroundings((), clustered=True)
    heads = 0
    for seed in range(200):
        coarse = CoarseObject.of([box("car", (4, 2, 1.5), yaw=math.pi / 2)], seed, "car_1")
        heads += around.headed(coarse, coarse.box()).yaw > math.pi
    assert 70 < heads < 130


def test_the_road_side_is_that_of_the_nearest_road_or_of_the_ego() -> None:
    roads = [
        Primitive(shape="plane", center=(0, y, 0), size=(100, 8, 0), label="road", id=f"road_{y}") for y in (0, 60)
    ]
    around = Surroundings.of(Layout(primitives=tuple(roads)))
    assert around.road_side(UprightBox(30, 20, 0, 0.0, (9, 9, 6)))[1] < 0
    assert around.road_side(UprightBox(30, 45, 0, 0.0, (9, 9, 6)))[1] > 0
    assert Surroundings.of(Layout()).road_side(UprightBox(30, 20, 0, 0.0, (9, 9, 6))) == (-30, -20)


def strips(*primitives: Primitive) -> list[RoadStrip]:
    return list(road_strips(Layout(primitives=primitives)))


@pytest.mark.parametrize("curvature", [0.0, 0.01, -0.01])
def test_the_frame_of_a_road_is_found(curvature: float) -> None:
    road = Road(curvature=curvature, lanes=2, parking=2.2)
    (strip,) = strips(*road_surfaces(road))
    assert strip.half == pytest.approx(road.edge)
    assert strip.top == 0.0
    assert strip.line.length == pytest.approx(160.0, abs=0.1)
    along, across = np.array([-50.0, 0.0, 33.0]), np.array([3.0, -2.0, 7.0])
    places = road.points(along, across)
    found = strip.line.along_across(places)
    assert found[0] - 80.0 == pytest.approx(along, abs=0.2)
    assert found[1] == pytest.approx(across, abs=0.02)
    assert strip.line.at(*found) == pytest.approx(places, abs=0.03)
    x, y = strip.line.nearest(*places[2].tolist())
    assert math.hypot(x - places[2, 0], y - places[2, 1]) == pytest.approx(7.0, abs=0.1)


@pytest.mark.parametrize("yaw", [0.0, 0.4, math.pi / 2, 3.0])
def test_a_rectangle_is_a_road_along_its_longer_side(yaw: float) -> None:
    for size, turn in (((60, 7, 0), 0.0), ((7, 60, 0), math.pi / 2)):
        (strip,) = strips(Primitive(shape="plane", center=(9, 1, 0.2), size=size, label="road", id="a", yaw=yaw - turn))
        assert (strip.line.length, strip.half, strip.top) == pytest.approx((60.0, 3.5, 0.2))
        (x, y), (u, v) = strip.line.middle.tolist()
        assert abs(math.sin(math.atan2(v - y, u - x) - yaw)) == pytest.approx(0.0, abs=1e-9)


def test_squares_puddles_painted_surfaces_and_fields_of_triangles_are_no_roads() -> None:
    vertices = np.array([(x, y, 0.05 * x) for x in range(5) for y in range(5)], dtype=float) * 4
    faces = np.array([(a, a + 1, a + 6) for a in range(18)])
    assert not strips(
        Primitive(shape="plane", center=(0, 0, 0), size=(20, 20, 0), label="road", id="a"),
        Primitive(shape="plane", center=(0, 0, 0), size=(4, 2, 0), label="road", id="b"),
        Primitive(shape="plane", center=(0, 0, 0), size=(60, 7, 0), label="road", id="c", material="gravel"),
        Primitive.from_mesh(vertices, faces, label="road", id="d"),
        Primitive(shape="plane", center=(0, 0, 0), size=(1e8, 40, 0), label="road", id="f"),
        Primitive(shape="cylinder", center=(0, 0, 0), size=(60, 7, 1), label="road", id="e"),
    )
