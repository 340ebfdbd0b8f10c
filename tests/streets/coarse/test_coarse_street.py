"""What the coarse layouts of a street have in common."""

import numpy as np
from scanned import EGO, NAMES, OBJECTS, SCAN, STREET, VISIBLE

from lidardraft.drafting.solver.sentence_kinds import SENTENCE_KINDS
from lidardraft.objects.kinds import KINDS
from lidardraft.scene.layout import SHAPES, object_of
from lidardraft.scene.raycast import Raycaster
from lidardraft.semantics import BY_NAME, NUM_CLASSES
from lidardraft.streets.coarse.coarse_layout import BoxStyle, as_boxes
from lidardraft.streets.coarse.coarse_street import ALWAYS_NAMED, FAMILIES, FAMILY_OF, ShapeColumns, place_of
from lidardraft.streets.coarse.visible import owners_of

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


def test_every_word_of_a_kind_is_of_one_family_or_always_named():
    named = [*ALWAYS_NAMED, *(word for _, words in FAMILIES.values() for word in words)]
    assert len(named) == len(set(named))
    assert set(named) == {kind.word for kind in KINDS.values()} - {None}
    assert set(named) <= set(SENTENCE_KINDS)
    # a word for others, one for several, one left out, one that streets call a fence
    assert set(SENTENCE_KINDS) - set(named) <= {"vehicle", "garden", "cone", "barrier"}
    assert set(FAMILY_OF) == {*named, None}


def test_the_mesh_follows_the_ground():
    rng = np.random.default_rng(0)
    along, across = rng.uniform(-30, 30, 60), rng.uniform(-1, 1, 60) * STREET.occupancy.road.edge
    caster = Raycaster(as_boxes(STREET.coarse, BoxStyle(relief=True), np.eye(4)).layout({}))
    places = np.array([STREET.occupancy.road.at(s, d)[:2] for s, d in zip(along, across, strict=True)])
    hits = caster.cast(np.column_stack([places, np.full(60, 60.0)]), np.tile([0.0, 0.0, -1.0], (60, 1)))
    bare = hits.label == NAMES.index("road")
    true = np.array([STREET.occupancy.ground.height(s, d) for s, d in zip(along, across, strict=True)])
    wrong = np.abs(60.0 - hits.distance - true)[bare]
    assert bare.mean() > 0.5
    assert np.median(wrong) < 0.03
    assert wrong.max() < 0.2


def test_every_primitive_has_its_object_and_the_ground_has_none():
    owners = owners_of(STREET.scene, OBJECTS)
    assert owners[-1] == -1
    for primitive, owner in zip(STREET.scene, owners[:-1].tolist(), strict=True):
        if owner >= 0:
            assert object_of(primitive) == OBJECTS[owner].id
        else:
            assert object_of(primitive) not in {placed.id for placed in OBJECTS}


def test_returns_are_counted_by_object_and_class():
    assert VISIBLE.returns.shape == (len(OBJECTS), NUM_CLASSES)
    on_ground = np.isin(SCAN.label, [NAMES.index(name) for name in ("road", "sidewalk", "terrain")])
    # plants of the ground are objects too, so all that is not ground is someone's
    assert VISIBLE.returns.sum() >= (SCAN.valid & ~on_ground).sum()
    cars = [number for number, placed in enumerate(OBJECTS) if placed.kind == "saloon"]
    assert VISIBLE.returns[cars][:, NAMES.index("building")].sum() == 0


def test_points_are_an_even_share_of_the_returns():
    points, keys = VISIBLE.points()
    kept = np.bincount(keys, minlength=len(OBJECTS) * NUM_CLASSES).reshape(-1, NUM_CLASSES)
    returns = VISIBLE.returns
    few = returns <= 200
    assert (kept[few] == returns[few]).all()
    some = (returns > 200) & (returns <= 1200)
    assert some.any()
    assert (np.abs(kept[some] / returns[some] - 1 / 4) < 0.06).all()
    # in the frame of the ego vehicle the sensor looks from its height over the road
    assert points[:, 2].min() > -3.0
