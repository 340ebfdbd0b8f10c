"""The surface of a street: its classes, its heights, and the mesh that has them."""

import numpy as np
import pytest
from planned import frame_corners, occupancies

from lidardraft import Layout, Primitive, Raycaster
from lidardraft.scene.road import LEFT, Road
from lidardraft.streets.ground.ground import Ground, _cut

LONG = {"fence", "garden_wall", "mesh_fence", "wall", "barrier"}


def test_the_ground_has_kerbs_and_covers_the_street():
    road = Road(junction=20.0, side_roads=(LEFT,))
    ground = Ground(road, np.random.default_rng(2))
    assert ground.surface(0.0, 0.0) == "road"
    assert ground.surface(0.0, road.edge + 0.5) == "sidewalk"
    assert ground.surface(0.0, road.verge + 5.0) == "terrain"
    assert ground.surface(20.0, road.verge + 5.0) == "road"
    assert ground.surface(20.0, -road.verge - 5.0) == "terrain"
    assert ground.height(0.0, road.edge + 0.01) - ground.height(0.0, road.edge - 0.01) == pytest.approx(0.12, abs=0.01)
    surfaces: dict[str, Primitive] = {p.id: p for p in ground.surfaces()}
    assert set(surfaces) == {"far", "road", "sidewalk", "terrain"}


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
        assert sum(len(mesh.faces) for mesh in meshes) <= 6000


def test_levels_are_those_of_the_coarse_ground():
    for occupancy in occupancies()[::3]:
        rng = np.random.default_rng(5)
        along, across = rng.uniform(-80, 80, 400), rng.uniform(-30, 30, 400)
        coarse = Raycaster(Layout(primitives=tuple(occupancy.road.surfaces())))
        origins = np.column_stack([occupancy.road.points(along, across), np.full(400, 10.0)])
        top = 10.0 - coarse.cast(origins, np.tile([0.0, 0.0, -1.0], (400, 1))).distance
        # but for the chords of bends and circles, and the sidewalk that a coarse layout has across a way in
        assert (np.abs(top - occupancy.ground.levels(along, across)) < 1e-3).mean() > 0.97, occupancy.road


def test_spans_are_cut_where_lines_cross_them():
    spans = np.array([(0.0, 10.0, 0.0, 1.0), (3.5, 4.5, 2.0, 3.0)])
    pieces = _cut(spans, np.array([-5.0, 2.0, 3.0, 10.0]), 0)
    assert pieces.tolist() == [[0, 2, 0, 1], [2, 3, 0, 1], [3, 10, 0, 1], [3.5, 4.5, 2, 3]]
    assert _cut(spans, np.array([2.5]), 1).tolist() == [[0, 10, 0, 1], [3.5, 4.5, 2, 2.5], [3.5, 4.5, 2.5, 3]]


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
