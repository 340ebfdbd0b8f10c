import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lidardraft.errors import LayoutError
from lidardraft.scene.layout import primitive_mesh
from lidardraft.scene.road import KERB_HEIGHT, LEFT, PavedArea, Road
from lidardraft.scene.road_surfaces import road_surfaces

roads = st.builds(
    Road,
    lanes=st.integers(2, 6),
    ego_lane=st.integers(0, 1),
    lane_width=st.floats(2, 6),
    parking=st.floats(0, 3),
    sidewalk=st.just(0.0) | st.floats(0.5, 5),
    curvature=st.floats(-0.02, 0.02),
)


@settings(max_examples=50, deadline=None)
@given(roads)
def test_the_ego_is_at_the_origin(road: Road) -> None:
    assert road.at(0.0, road.lane(road.ego_lane)) == pytest.approx((0, 0, 0), abs=1e-9)


@settings(max_examples=50, deadline=None)
@given(roads, st.floats(-60, 60), st.floats(-20, 20))
def test_the_frame_is_square_and_its_heading_true(road: Road, along: float, across: float) -> None:
    x, y, heading = road.at(along, across)
    step = 1e-4
    aside = np.subtract(road.at(along, across + step)[:2], (x, y)) / step
    np.testing.assert_allclose(aside, [-math.sin(heading), math.cos(heading)], atol=1e-5)
    ahead = np.subtract(road.at(along + step, 0.0)[:2], road.at(along, 0.0)[:2]) / step
    np.testing.assert_allclose(ahead, [math.cos(heading), math.sin(heading)], atol=1e-4)


@settings(max_examples=50, deadline=None)
@given(roads, st.lists(st.tuples(st.floats(-60, 60), st.floats(-20, 20)), min_size=1, max_size=5))
def test_many_places_are_those_of_each_and_lead_back(road: Road, places: list[tuple[float, float]]) -> None:
    along, across = np.array(places).T
    x, y, heading = road.at(along, across)
    assert np.stack([x, y, heading], axis=1) == pytest.approx(np.array([road.at(*place) for place in places]), abs=1e-9)
    assert road.points(along, across) == pytest.approx(np.stack([x, y], axis=1))
    assert np.stack(road.along_across(x, y), axis=1) == pytest.approx(np.array(places), abs=1e-7)
    assert road.along_across(*road.at(*places[0])[:2]) == pytest.approx(places[0], abs=1e-7)


def test_bends_turn_the_right_way() -> None:
    assert Road(curvature=0.01).at(50, 0)[1] > Road().at(50, 0)[1] > Road(curvature=-0.01).at(50, 0)[1]


def test_lanes() -> None:
    road = Road(lanes=3, lane_width=3.0, parking=2.0, sidewalk=1.5)
    assert [road.lane(n) for n in range(3)] == [-7.5, -4.5, -1.5]
    assert [road.lane(n, -1) for n in range(3)] == [7.5, 4.5, 1.5]
    assert (road.edge, road.verge) == (11.0, 12.5)


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"lanes": 0}, "lanes is 0; it must be 1 to 6"),
        ({"lanes": 2, "ego_lane": 2}, "ego_lane is 2; the road has 2 lanes"),
        ({"lane_width": 1.0}, "lane_width is 1.0; it must be 2 to 6"),
        ({"parking": -1.0}, "parking is -1.0; it must be 0 to 5"),
        ({"sidewalk": 11.0}, "sidewalk is 11.0; it must be 0 to 10"),
        ({"side_roads": ("left",)}, "side_roads is ('left',); sides are 1 (left) and -1 (right)"),
        ({"median": -1.0}, "median is -1.0; it must be 0 to 20"),
        ({"roundabout_radius": 20.0}, "a roundabout needs a junction on a straight road"),
        ({"roundabout_radius": 20.0, "junction": 0.0, "curvature": 0.01}, "a roundabout needs a junction on a"),
        ({"roundabout_radius": 9.0, "junction": 0.0}, "roundabout_radius is 9.0 m; for this road it must be over"),
        ({"half_length": 0.0}, "half_length is 0.0; it must be 1 to 10000"),
        ({"curvature": 0.1}, "curvature 0.1 over 80.0 m turns the road back on itself"),
    ],
)
def test_wrong_roads(fields: dict[str, float], message: str) -> None:
    with pytest.raises(LayoutError) as caught:
        Road(**fields)  # type: ignore[arg-type]
    assert message in str(caught.value)
    assert Road(curvature=0.025).half_length == 80.0  # the sharpest that does not turn back


def test_junctions() -> None:
    road = Road(junction=30.0, side_roads=(LEFT,))
    assert road.in_junction(30.0)
    assert road.in_junction(30.0 + road.verge + 0.5, margin=1.0)
    assert not road.in_junction(30.0 + road.verge + 0.5)
    assert not Road().in_junction(0.0)
    ids = [p.id for p in road_surfaces(road)]
    assert ids == ["terrain", "road", "sidewalk_1", "sidewalk_2", "sidewalk_3", "road_left"]
    assert [p.id for p in road_surfaces(road) if p.open] == ["terrain"]
    arm = road_surfaces(road)[-1]
    assert arm.center[1] - arm.size[0] / 2 == pytest.approx(road.edge - road.lane(0))


@settings(max_examples=20, deadline=None)
@given(roads)
def test_surfaces_reach_where_the_frame_says(road: Road) -> None:
    surfaces = {p.id: p for p in road_surfaces(road)}
    vertices = primitive_mesh(surfaces["road"]).vertices
    for along in (-road.half_length, road.half_length):
        for across in (-road.edge, road.edge):
            corner = np.array(road.at(along, across)[:2])
            assert np.hypot(*(vertices[:, :2] - corner).T).min() < 1e-6
    assert vertices[:, 2] == pytest.approx(0.0)
    if "sidewalk_1" in surfaces:
        assert primitive_mesh(surfaces["sidewalk_1"]).vertices[:, 2].max() == pytest.approx(KERB_HEIGHT)


def test_a_median_parts_the_carriageways() -> None:
    road = Road(lanes=2, lane_width=3.5, median=4.0)
    assert road.edge == 9.0
    assert [road.lane(n) for n in range(2)] == [-7.25, -3.75]
    surfaces = {p.id: p for p in road_surfaces(road)}
    for name, side in (("road", -1), ("road_back", 1)):
        assert surfaces[name].center[1] + road.lane(0) == pytest.approx(side * 5.5)
        assert surfaces[name].size[1] == 7.0


def test_a_roundabout_has_a_lane_around_an_island() -> None:
    road = Road(junction=20.0, roundabout_radius=18.0)
    assert road.island == 10.0
    assert road.in_junction(39.0)
    surfaces = {p.id: p for p in road_surfaces(road)}
    assert surfaces["island"].size[:2] == (20.0, 20.0)
    assert primitive_mesh(surfaces["roundabout"]).vertices[:, 0].max() == pytest.approx(38.0)
    sidewalks = [p for p in surfaces.values() if p.label == "sidewalk"]
    assert len(sidewalks) == 4
    assert all(abs(p.center[0] - 20.0) - p.size[0] / 2 >= 18.0 - 1e-9 for p in sidewalks)


def test_paved_areas_are_road() -> None:
    road = Road(paved_areas=(PavedArea((-10.0, 20.0), (6.0, 22.0)),))
    area = road_surfaces(road)[-1]
    assert (area.label, area.id, area.size) == ("road", "patch_1", (30.0, 16.0, 0.0))
    assert area.center == pytest.approx((5.0, 14.0 - road.lane(0), 0.0))
