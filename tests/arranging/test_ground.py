"""How the land lies, and the surface of a street: its classes, its heights, and the meshes that have them."""

import math

import numpy as np
import pytest

from lidardraft import Layout, Primitive, Raycaster
from lidardraft.arranging.ground import Ground, RoundaboutMesh, cut
from lidardraft.arranging.occupancy import Occupancy
from lidardraft.arranging.relief import SECTION, Land, Relief
from lidardraft.scene.layout import primitive_mesh
from lidardraft.scene.road import LEFT, PavedArea, Road
from lidardraft.scene.road_surfaces import road_surfaces
from planned import FLAT, frame_corners, occupancies, surface


def test_the_road_rises_and_falls():
    rise = [
        float(np.ptp(occupancy.ground.heights(np.linspace(-80, 80, 81), np.zeros(81)))) for occupancy in occupancies()
    ]
    assert np.median(rise) > 0.5
    assert max(rise) < 8.0
    for occupancy in occupancies():
        grades = [occupancy.ground.grade(float(along)) for along in np.linspace(-90, 90, 31)]
        assert max(map(abs, grades)) < 0.061


def horizon(occupancy: Occupancy) -> np.ndarray:
    """Elevation [rad] of the land's edge around a sensor over the middle of the street."""
    along, across = np.meshgrid(np.linspace(-80, 80, 41), np.linspace(-60, 60, 31), indexing="ij")
    heights = occupancy.ground.heights(along.ravel(), across.ravel())
    distance = np.hypot(along.ravel(), across.ravel())
    far = distance > 15.0
    elevation = np.arctan2(heights[far] - occupancy.ground.heights(np.zeros(1), np.zeros(1))[0] - 1.73, distance[far])
    sector = ((np.arctan2(across.ravel(), along.ravel())[far] + math.pi) / (2 * math.pi) * 24).astype(int) % 24
    return np.array([elevation[sector == number].max() for number in range(24)])


def test_the_horizon_is_no_flat_line():
    spread = [float(np.ptp(horizon(occupancy))) for occupancy in occupancies()]
    # a flat plane of this extent has a horizon between -0.029 and -0.015 rad
    assert np.median(spread) > 0.02
    assert max(spread) > 0.1


def test_heights_are_the_same_from_all_sides():
    for occupancy in occupancies()[::6]:
        rng = np.random.default_rng(1)
        along, across = rng.uniform(-80, 80, 300), rng.uniform(-50, 50, 300)
        step = 1e-4
        jump = np.abs(
            occupancy.ground.relief.heights(along + step, across + step)
            - occupancy.ground.relief.heights(along, across)
        )
        assert jump.max() < 1e-2


def test_ditches_and_banks_are_beside_the_road_only_where_the_land_has_them():
    road = Road(sidewalk=0.0)
    flat, cut = Land(grade=0.0, hillside=0.0, rolling=0.0), Land(grade=0.0, hillside=0.0, rolling=0.0, ditch=1.0)
    across = road.verge + np.array([0.0, *SECTION])
    along = np.zeros(len(across))
    plain = Relief(road, flat, np.random.default_rng(3)).heights(along, across)
    ditched = Relief(road, cut, np.random.default_rng(3)).heights(along, across)
    assert np.ptp(plain) < 0.1
    assert -0.7 < ditched.min() < -0.25
    assert across[int((ditched - plain).argmin())] - road.verge == pytest.approx(SECTION[1])


def test_the_island_of_a_roundabout_rises_to_its_middle():
    road = Road(junction=10.0, roundabout_radius=18.0)
    relief = Relief(road, Land(grade=0.0, rolling=0.0), np.random.default_rng(0))
    heights = relief.heights(10.0 + np.array([0.0, 5.0, road.island]), np.zeros(3))
    assert heights[0] > heights[1] > heights[2]


LONG = {"fence", "garden_wall", "mesh_fence", "wall", "barrier"}


def test_the_ground_has_kerbs_and_covers_the_street():
    road = Road(junction=20.0, side_roads=(LEFT,))
    ground = Ground(road, np.random.default_rng(2))
    assert surface(ground, 0.0, 0.0) == "road"
    assert surface(ground, 0.0, road.edge + 0.5) == "sidewalk"
    assert surface(ground, 0.0, road.verge + 5.0) == "terrain"
    assert surface(ground, 20.0, road.verge + 5.0) == "road"
    assert surface(ground, 20.0, -road.verge - 5.0) == "terrain"
    surfaces: dict[str, Primitive] = {p.id: p for p in ground.surfaces()}
    assert set(surfaces) == {"far", "road", "sidewalk", "terrain"}


def kerb(ground: Ground, along: float) -> float:
    """How high the kerb on the left is there [m]."""
    low, high = ground.heights(np.full(2, along), ground.road.edge + np.array([-1e-3, 1e-3]))
    return float(high - low)


def test_kerbs_are_as_high_as_their_street_has_them_and_dropped_at_crossings_and_drives():
    road = Road(junction=20.0, side_roads=(LEFT,))
    grounds = [Ground(road, np.random.default_rng(seed)) for seed in range(12)]
    usual = [kerb(ground, -40.0) for ground in grounds]
    assert min(usual) < 0.04 < 0.08 < max(usual) < 0.125
    for ground, high in zip(grounds, usual, strict=True):
        assert kerb(ground, 20.0 - road.edge - 1.0) < 0.04
        ground.add_driveway(PavedArea((-1.4, 1.4), (road.verge, road.verge + 6.0)))
        assert kerb(ground, 0.0) < 0.04
        assert kerb(ground, -40.0) == high


def test_gardens_lie_about_as_high_as_the_sidewalk():
    beside = np.array([-1e-3, 1e-3])
    steps = [
        float(np.diff(Ground(road, np.random.default_rng(seed), FLAT).heights(np.full(2, 9.0), road.verge + beside))[0])
        for seed, road in enumerate([Road()] * 24)
    ]
    assert -0.045 < min(steps) < 0.0 < 0.04 < max(steps) < 0.085


def test_the_road_falls_to_its_kerbs_and_has_short_waves():
    for seed in range(8):
        ground, along = Ground(Road(), np.random.default_rng(seed), FLAT), np.linspace(-60.0, 60.0, 600)
        middle = ground.heights(along, np.zeros(600))
        fall = middle - ground.heights(along, np.full(600, ground.road.edge - 0.01))
        assert 0.018 < fall.mean() / ground.road.edge < 0.032
        assert 0.002 < middle.std() < 0.06


def test_paint_lies_on_the_road():
    for occupancy in occupancies()[::10]:
        paint = next((p for p in occupancy.ground.surfaces() if p.id == "markings"), None)
        if paint is None:
            continue
        corners = primitive_mesh(paint).vertices[primitive_mesh(paint).faces]
        shares = np.random.default_rng(0).dirichlet(np.ones(3), len(corners))
        places = (corners * shares[..., None]).sum(axis=1)
        under = occupancy.ground.heights(*occupancy.road.along_across(*places[:, :2].T))
        over = places[:, 2] - under
        assert (over > 0.0).mean() > 0.995
        assert np.quantile(over, 0.99) < 0.01


def test_heights_and_classes_are_those_of_the_mesh():
    down = np.tile([0.0, 0.0, -1.0], (500, 1))
    for occupancy in occupancies()[::4]:
        rng = np.random.default_rng(2)
        along, across = rng.uniform(-100, 100, 500), rng.uniform(-40, 40, 500)
        bare = [p for p in occupancy.ground.surfaces() if p.id not in ("drives", "markings")]
        origins = np.column_stack([occupancy.road.points(along, across), np.full(500, 30.0)])
        hits = Raycaster(Layout(primitives=tuple(bare))).cast(origins, down)
        off = np.abs(30.0 - hits.distance - occupancy.ground.heights(along, across))
        # chords of circles and bends move a kerb by some centimetres, and the island of a roundabout is made of facets
        assert np.quantile(off, 0.95) < (0.02 if occupancy.road.roundabout_radius is None else 0.07)
        assert off.max() < 0.21
        labels = np.array([1, 2, 10, 10])[occupancy.ground.kinds(along, across)]
        assert (labels == hits.label).mean() > 0.99


def test_the_ground_has_few_triangles():
    for occupancy in occupancies()[::4]:
        meshes = [p.mesh for p in occupancy.ground.surfaces() if p.mesh is not None]
        assert sum(len(mesh.faces) for mesh in meshes) <= 12_000


def test_levels_are_those_of_the_coarse_ground():
    for occupancy in occupancies()[::3]:
        rng = np.random.default_rng(5)
        along, across = rng.uniform(-80, 80, 400), rng.uniform(-30, 30, 400)
        coarse = Raycaster(Layout(primitives=tuple(road_surfaces(occupancy.road))))
        origins = np.column_stack([occupancy.road.points(along, across), np.full(400, 10.0)])
        top = 10.0 - coarse.cast(origins, np.tile([0.0, 0.0, -1.0], (400, 1))).distance
        # but for the chords of bends and circles, and the sidewalk that a coarse layout has across a way in
        assert (np.abs(top - occupancy.ground.levels(along, across)) < 1e-3).mean() > 0.97, occupancy.road


def test_spans_are_cut_where_lines_cross_them():
    spans = np.array([(0.0, 10.0, 0.0, 1.0), (3.5, 4.5, 2.0, 3.0)])
    pieces = cut(spans, np.array([-5.0, 2.0, 3.0, 10.0]), 0)
    assert pieces.tolist() == [[0, 2, 0, 1], [2, 3, 0, 1], [3, 10, 0, 1], [3.5, 4.5, 2, 3]]
    assert cut(spans, np.array([2.5]), 1).tolist() == [[0, 10, 0, 1], [3.5, 4.5, 2, 2.5], [3.5, 4.5, 2.5, 3]]


def test_long_objects_follow_the_ground():
    off = []
    for occupancy in occupancies():
        for index, placed in enumerate(occupancy.objects):
            if placed.kind in LONG:
                corners = frame_corners(occupancy, index)
                off.append(np.abs(occupancy.ground.heights(*corners.T) - placed.z).max())
    assert np.quantile(off, 0.9) < 0.2
    assert max(off) < 0.75


def test_level_pieces_are_shorter_in_bends_and_on_slopes():
    straight, bent = (Ground(Road(curvature=bend), np.random.default_rng(0)) for bend in (0.0, 0.01))
    assert straight.level_length(0.0, 5.0) <= 5.0
    assert bent.level_length(0.0, 12.0) <= 7.0
    lengths = [straight.level_length(float(along), 1000.0) for along in range(-60, 61, 5)]
    grades = [abs(straight.grade(float(along))) for along in range(-60, 61, 5)]
    assert int(np.argmin(lengths)) == int(np.argmax(grades))
    assert min(lengths) >= 3.0


@pytest.mark.parametrize("sidewalk", [0.0, 2.5])
def test_rings_are_circles_between_the_middle_and_the_square(sidewalk: float):
    road = Road(junction=10.0, roundabout_radius=18.0, sidewalk=sidewalk)
    mesh = RoundaboutMesh(road)
    radius = np.hypot(mesh.along - 10.0, mesh.across)
    assert np.allclose(radius[0], 0.0)
    for ring, wanted in enumerate((0.5 * road.island, road.island, 18.0), start=1):
        assert np.allclose(radius[ring], wanted)
    square = np.maximum(np.abs(mesh.along[-1] - 10.0), np.abs(mesh.across[-1]))
    assert np.allclose(square, mesh.half)
    # rings lie outside one another, so that no cell is folded
    assert (np.diff(radius, axis=0) > -1e-9).all()


def test_kinds_are_those_of_an_island_a_lane_and_a_sidewalk():
    road = Road(junction=0.0, roundabout_radius=18.0, sidewalk=2.0)
    mesh = RoundaboutMesh(road)
    diagonal = np.array([5.0, 14.0, 19.0, 25.0]) / np.sqrt(2.0)
    land = np.full(4, 2)
    assert mesh.kinds(diagonal, diagonal, land).tolist() == [3, 0, 1, 2]


def test_it_covers_its_square_and_fits_the_lines_of_the_ground():
    road = Road(junction=10.0, roundabout_radius=18.0)
    mesh = RoundaboutMesh(road)
    inside = mesh.half - 0.01
    assert mesh.covers(np.array([10.0 + inside, 10.0]), np.array([0.0, -inside])).all()
    assert not mesh.covers(np.array([10.0 + mesh.half + 0.01]), np.array([0.0])).any()
    assert min(mesh.lines_along()) == pytest.approx(10.0 - mesh.half)
    assert {road.edge, road.verge} <= set(mesh.offsets)
