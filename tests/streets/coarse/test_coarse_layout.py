"""Styles at random, the layout in each, and what the coarse layouts of a street have in common."""

import math

import numpy as np
import pytest
from scanned import EGO, NAMES, OBJECTS, SCAN, SENSOR, STREET, VISIBLE, ids, in_street, labels, made

from lidardraft.objects.coarse_shapes import MOST_LOBES
from lidardraft.objects.kinds import FAMILIES, KINDS, SENTENCE_KINDS, kind_of
from lidardraft.scene.labelling import agrees
from lidardraft.scene.layout import SHAPES, object_of
from lidardraft.scene.raycast import Raycaster
from lidardraft.semantics import BY_NAME
from lidardraft.streets.coarse.coarse_layout import (
    BoxStyle,
    ClusterStyle,
    PictureStyle,
    Style,
    TextStyle,
    as_boxes,
    sample_style,
)
from lidardraft.streets.coarse.coarse_street import ShapeColumns, place_of

STYLES = [sample_style(np.random.default_rng(seed)) for seed in range(200)]


def test_styles_are_of_every_kind():
    assert {type(style) for style in STYLES} == {TextStyle, ClusterStyle, PictureStyle, BoxStyle}
    for kind, fields in (
        (TextStyle, ("sidewalks", "poles", "named")),
        (ClusterStyle, ("numbered",)),
        (PictureStyle, ("relief", "sidewalks", "poles", "omit")),
        (BoxStyle, ("relief",)),
    ):
        for name in fields:
            assert len({getattr(style, name) for style in STYLES if isinstance(style, kind)}) > 1, name
    assert {style.lobes for style in STYLES if isinstance(style, PictureStyle)} == set(range(1, MOST_LOBES + 1))
    assert {family for style in STYLES if isinstance(style, TextStyle) for family in style.named} == set(FAMILIES)


@pytest.mark.parametrize("style", [TextStyle(), ClusterStyle(), PictureStyle(error=0.02), BoxStyle()])
def test_a_layout_is_a_function_of_style_and_seed(style: Style):
    one, two = made(style, 1), made(style, 1)
    assert (one.centers == two.centers).all()
    assert one.ids == two.ids
    assert len(one.ids) > len(STREET.coarse.ground(EGO.pose, relief=isinstance(style, ClusterStyle)).ids)


@pytest.mark.parametrize("style", [TextStyle(), ClusterStyle(), PictureStyle(error=0.02), BoxStyle()])
def test_only_pictures_depend_on_the_seed(style: Style):
    tables = [made(style, seed) for seed in (1, 2)]
    same = tables[0].ids == tables[1].ids and (tables[0].centers == tables[1].centers).all()
    assert same != isinstance(style, PictureStyle)


def test_objects_are_the_nearest_that_the_solver_could_have_placed():
    table = in_street(made(TextStyle()))
    row = {id: number for number, id in enumerate(table.ids)}
    coarse = [placed for placed in OBJECTS if placed.id in row]
    assert len(coarse) > 0.85 * len(OBJECTS)  # sentences do not name beds of plants, crates and cabinets
    for placed in coarse:
        off = np.hypot(*(table.centers[row[placed.id], :2] - (placed.x, placed.y)))
        assert off < 0.6, placed
        assert abs(math.sin(table.yaws[row[placed.id]] - placed.yaw)) < 0.1 or placed.kind in ("bin", "sign", "bench")
        assert (table.sizes[row[placed.id]] <= 1.25 * np.maximum(placed.size, 0.3)).all() or placed.kind == "person"
    assert (table.centers[:, 2] >= -0.05).all()


def test_what_a_sentence_does_not_name_is_left_out():
    everything = ids(made(TextStyle()))
    assert "sidewalk" in labels(made(TextStyle()))
    assert "sidewalk" not in labels(made(TextStyle(sidewalks=False)))
    assert everything - ids(made(TextStyle(poles=False))) >= {
        t.id for t in OBJECTS if t.kind in ("lamp", "sign", "pole")
    }
    assert "vegetation" not in labels(made(TextStyle(named=("buildings",))))
    assert "building" in labels(made(TextStyle(named=("buildings",))))
    assert "building" not in labels(made(TextStyle(named=())))
    assert "car" in labels(made(TextStyle(named=())))


@pytest.mark.parametrize("numbered", [True, False])
def test_clusters_stand_where_the_scan_saw_them(numbered: bool):
    """Cast from where the scan was taken, beside the ego vehicle's middle and tilted, they agree with it."""
    table = made(ClusterStyle(numbered=numbered))
    coarse = table.scan(SENSOR, SENSOR.poses_in_motion(VISIBLE.pose, (EGO.speed, 0.0, 0.0)))
    good = agrees(SCAN, coarse)
    for name, least in {"road": 0.9, "building": 0.7, "car": 0.5, "vegetation": 0.5}.items():
        assert good[SCAN.label == BY_NAME[name].id].mean() > least, name
    assert {NAMES[k] for k in table.labels} <= {NAMES[k] for k in np.unique(SCAN.label)} | {"terrain"}


def test_points_without_numbers_merge_neighbours_and_lose_what_is_small():
    counted = [NAMES.index("car"), NAMES.index("person")]
    with_numbers, without = (np.isin(made(ClusterStyle(numbered=n)).labels, counted).sum() for n in (True, False))
    assert 0.4 * with_numbers < without < with_numbers


def test_a_picture_shows_what_is_ahead_and_seen():
    table = made(PictureStyle(reach=40.0, view=1.5))
    objects = table.select(~np.isin(table.labels, [NAMES.index(name) for name in ("road", "sidewalk", "terrain")]))
    assert len(objects)
    middle = {placed.id: (placed.x, placed.y) for placed in OBJECTS}
    for id in {id.partition(".")[0] for id in objects.ids}:
        ahead = np.array(middle[id]) - VISIBLE.place[:2]
        assert np.hypot(*ahead) <= 40.0
        assert abs(math.remainder(math.atan2(ahead[1], ahead[0]) - VISIBLE.place[2], math.tau)) <= 0.75 + 1e-6
        assert VISIBLE.returns()[[placed.id for placed in OBJECTS].index(id)] >= 5


def test_a_picture_misjudges_a_little():
    exact, wrong = (made(PictureStyle(error=error, turn=error)) for error in (0.0, 0.02))
    assert exact.ids == wrong.ids
    off = np.hypot(*(exact.centers - wrong.centers)[:, :2].T)
    share = off / np.maximum(np.hypot(*exact.centers[:, :2].T), 5.0)
    assert 0.003 < np.median(share) < 0.03
    assert 0.003 < np.median(np.abs(exact.yaws - wrong.yaws)) < 0.04


def test_small_objects_sidewalks_and_poles_may_be_left_out():
    small = {placed.id for placed in OBJECTS if kind_of(placed.kind).is_small} & ids(made(PictureStyle()))
    assert small
    assert not small & ids(made(PictureStyle(omit=1.0)))
    assert "sidewalk" in labels(made(PictureStyle(relief=True)))
    assert "sidewalk" not in labels(made(PictureStyle(relief=True, sidewalks=False)))
    poles = {placed.id for placed in OBJECTS if placed.kind in ("lamp", "sign", "pole")}
    assert poles & ids(made(PictureStyle()))
    assert not poles & ids(made(PictureStyle(poles=False)))


def test_a_picture_covers_its_view():
    assert PictureStyle().coverage is None
    assert PictureStyle(view=1.5).coverage == (-0.75, 0.75)


def test_annotations_have_every_thing_at_its_place():
    table = in_street(made(BoxStyle()))
    row = {id: number for number, id in enumerate(table.ids)}
    for placed in OBJECTS:
        assert table.centers[row[placed.id], :2] == pytest.approx((placed.x, placed.y), abs=0.1 + 1e-6)
        if placed.instance and placed.kind not in ("cyclist", "motorcyclist"):
            assert table.sizes[row[placed.id]] == pytest.approx(placed.size)
            assert table.yaws[row[placed.id]] == pytest.approx(placed.yaw)
            assert table.instances[row[placed.id]] == placed.instance


COARSE = STREET.coarse


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


def test_every_family_has_words_and_only_vehicles_have_none():
    words = {SENTENCE_KINDS[kind.word] for kind in KINDS.values() if kind.word}
    assert {word.family for word in words} == {*FAMILIES, ""}
    assert {word.name for word in words if not word.family} == {"car", "van", "truck", "bus", "tram"}


def test_the_mesh_follows_the_ground():
    rng = np.random.default_rng(0)
    along, across = rng.uniform(-30, 30, 60), rng.uniform(-1, 1, 60) * STREET.occupancy.road.edge
    caster = Raycaster(as_boxes(STREET.coarse, BoxStyle(relief=True), np.eye(4)).layout({}))
    places = np.array([STREET.occupancy.road.at(s, d)[:2] for s, d in zip(along, across, strict=True)])
    hits = caster.cast(np.column_stack([places, np.full(60, 60.0)]), np.tile([0.0, 0.0, -1.0], (60, 1)))
    bare = hits.label == NAMES.index("road")
    true = STREET.occupancy.ground.heights(np.array(along), np.array(across))
    wrong = np.abs(60.0 - hits.distance - true)[bare]
    assert bare.mean() > 0.5
    assert np.median(wrong) < 0.03
    assert wrong.max() < 0.2


def test_every_primitive_has_its_object_and_the_ground_has_none():
    owners = COARSE.owners
    assert owners[-1] == -1
    for primitive, owner in zip(STREET.scene, owners[:-1].tolist(), strict=True):
        if owner >= 0:
            assert object_of(primitive) == OBJECTS[owner].id
        else:
            assert object_of(primitive) not in {placed.id for placed in OBJECTS}


def test_returns_are_counted_by_object():
    returns = VISIBLE.returns()
    assert returns.shape == (len(OBJECTS),)
    on_ground = np.isin(SCAN.label, [NAMES.index(name) for name in ("road", "sidewalk", "terrain")])
    # plants of the ground are objects too, so all that is not ground is someone's
    assert returns.sum() >= (SCAN.valid & ~on_ground).sum()
    for number in np.flatnonzero([placed.kind == "saloon" for placed in OBJECTS]).tolist():
        car = SCAN.valid & (SCAN.instance == OBJECTS[number].instance)
        assert returns[number] == car.sum()
