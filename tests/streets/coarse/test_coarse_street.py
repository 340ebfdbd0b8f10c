"""What the coarse layouts of a street have in common."""

import numpy as np
from scanned import EGO, OBJECTS, STREET

from lidardraft.scene.layout import SHAPES
from lidardraft.semantics import BY_NAME
from lidardraft.streets.coarse.coarse_street import ShapeColumns, place_of

COARSE = STREET.coarse


def test_columns_are_of_the_objects():
    assert len(COARSE.objects) == len(OBJECTS) == len(COARSE.places) == len(COARSE.families)
    assert {len(COARSE.exact.owners), len(COARSE.exact.ids), len(COARSE.exact.sizes)} == {len(COARSE.exact.owners)}
    for index, placed in enumerate(OBJECTS):
        of_it = COARSE.exact.ids[COARSE.exact.owners == index]
        assert {id.partition(".")[0] for id in of_it} <= {placed.id}


def test_crowns_have_the_same_ids_whatever_the_number_of_their_lobes():
    for columns in (COARSE.exact, COARSE.solved):
        for lobes in (1, 2, 3):
            kept = (columns.lobes == 0) | (columns.lobes == lobes)
            assert len(set(columns.ids[kept])) == kept.sum()


def test_the_plane_of_the_road_is_flat_and_relief_is_not():
    flat, relief = (COARSE.ground(EGO.pose, relief=relief) for relief in (False, True))
    assert not (flat.shapes == SHAPES.index("mesh")).any()
    assert (relief.shapes == SHAPES.index("mesh")).any()
    sidewalk = BY_NAME["sidewalk"].id
    assert (flat.labels == sidewalk).any()
    for relief in (False, True):
        assert not (COARSE.ground(EGO.pose, relief=relief, sidewalks=False).labels == sidewalk).any()


def test_objects_stand_where_they_are_seen_from():
    chosen = np.ones(len(OBJECTS), dtype=bool)
    here = COARSE.standing(COARSE.exact, chosen, EGO.pose, relief=False)
    x, y, yaw = place_of(EGO.pose)
    away = np.hypot(*here.centers[:, :2].T)
    middles = {placed.id: np.hypot(placed.x - x, placed.y - y) for placed in OBJECTS if placed.kind in ("pole", "bin")}
    row = {id: number for number, id in enumerate(here.ids)}
    assert middles
    for id, distance in middles.items():
        assert abs(away[row[id]] - distance) < 1e-9
    assert abs(np.remainder(here.yaws[row[OBJECTS[0].id]] - OBJECTS[0].yaw + yaw + np.pi, 2 * np.pi) - np.pi) < 1e-9


def test_errors_move_and_stretch():
    chosen = np.ones(len(OBJECTS), dtype=bool)
    off, scale = np.tile([1.0, 0.0, 0.0], (len(OBJECTS), 1)), np.full((len(OBJECTS), 3), 1.1)
    exact = COARSE.standing(COARSE.exact, chosen, np.eye(4), relief=False)
    moved = COARSE.standing(COARSE.exact, chosen, np.eye(4), relief=False, errors=(off, scale))
    np.testing.assert_allclose(moved.sizes, 1.1 * exact.sizes)
    only_moved = COARSE.standing(COARSE.exact, chosen, np.eye(4), relief=False, errors=(off, np.ones_like(scale)))
    np.testing.assert_allclose(
        only_moved.centers - exact.centers, np.tile([1.0, 0.0, 0.0], (len(exact.ids), 1)), atol=1e-9
    )


def test_no_rows_are_no_shapes():
    empty = ShapeColumns.from_rows([], [])
    assert empty.centers.shape == (0, 3)
