"""Markings and kerbs."""

import numpy as np
import pytest

from lidardraft import Layout, Primitive, detail, layout_from_text
from lidardraft.scene.layout import primitive_mesh
from lidardraft.scene.road import KERB_HEIGHT, PavedArea, Road
from lidardraft.simulation.ground import _lanes
from lidardraft.simulation.surroundings import road_strips


def of(road: Road) -> dict[str, Primitive]:
    return {p.id: p for p in detail(Layout(primitives=tuple(road.surfaces()))).primitives}


def across(road: Road, part: Primitive) -> np.ndarray:
    vertices = primitive_mesh(part).vertices
    return road.along_across(vertices[:, 0], vertices[:, 1])[1]


@pytest.mark.parametrize("lanes", [1, 2, 3])
@pytest.mark.parametrize("ego_lane", [0, 1])
@pytest.mark.parametrize("parking", [0.0, 2.2, 3.0])
@pytest.mark.parametrize("width", [3.3, 3.5, 3.75])
def test_the_lanes_of_the_solver_are_found(lanes: int, ego_lane: int, parking: float, width: float) -> None:
    road = Road(lanes=lanes, ego_lane=min(ego_lane, lanes - 1), parking=parking, lane_width=width)
    (strip,) = road_strips(Layout(primitives=tuple(road.surfaces())))
    assert _lanes(strip) == (lanes, pytest.approx(width), pytest.approx(parking, abs=1e-9), True)


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


def test_the_ground_itself_stays() -> None:
    given = layout_from_text("a crossroads", seed=1)
    made = {p.id: p for p in detail(given)}
    assert all(made[p.id] == p for p in given)


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
