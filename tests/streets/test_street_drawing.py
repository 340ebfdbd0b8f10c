"""Drawings of a street in the styles of its inputs."""

import math
from dataclasses import replace

import numpy as np
import pytest

from lidardraft import CLASSES
from lidardraft.drafting.cloud import layout_from_cloud
from lidardraft.drafting.sentence_kinds import SENTENCE_KINDS
from lidardraft.errors import LayoutError
from lidardraft.objects.coarse_shapes import MOST_LOBES
from lidardraft.objects.kinds import KINDS as TABLE
from lidardraft.objects.kinds import kind_of
from lidardraft.objects.placed_object import PlacedObject
from lidardraft.scene.raycast import Raycaster
from lidardraft.scene.sensor import PRESETS
from lidardraft.scene.sensor_model import SensorModel
from lidardraft.scene.shape_table import ShapeTable
from lidardraft.scene.surfaces import Surfaces
from lidardraft.streets.coarse.style import ALWAYS_NAMED, FAMILIES, SOURCES, Style, sample_style
from lidardraft.streets.pairs import StreetScanner, scan_street
from lidardraft.streets.street import make_street

STREET = make_street(2)
DRAWN, THINGS = STREET.coarse, STREET.occupancy.objects
SENSOR = PRESETS["hdl64e"]
EYE = StreetScanner(
    SENSOR, SensorModel.from_sensor(SENSOR), Raycaster(STREET.scene), Surfaces.from_layout(STREET.scene), None
)
EGO, SIGHTING, _ = scan_street(STREET, EYE, 0)
SCAN, HERE = SIGHTING.scan, SIGHTING.place
NAMES = [row.name for row in CLASSES]


def draw(style: Style, seed: int = 0) -> ShapeTable:
    return DRAWN.draw(style, np.random.default_rng(seed), EGO.pose, SIGHTING)


def ids(style: Style) -> set[str]:
    return {id.partition(".")[0] for id in draw(style).ids}


def labels(style: Style) -> set[str]:
    return {NAMES[label] for label in draw(style).labels}


def in_street(table: ShapeTable) -> ShapeTable:
    """The table of the ego vehicle's frame in that of the road."""
    x, y, yaw = HERE
    back = table.seen_from(0.0, 0.0, -yaw)
    return replace(back, centers=back.centers + np.array([x, y, 0.0]))


def test_annotations_have_every_thing_at_its_place():
    table = in_street(draw(Style(source="boxes")))
    row = {id: number for number, id in enumerate(table.ids)}
    for placed in THINGS:
        assert table.centers[row[placed.id], :2] == pytest.approx((placed.x, placed.y), abs=0.1)
        if placed.instance and placed.kind not in ("cyclist", "motorcyclist"):
            assert table.sizes[row[placed.id]] == pytest.approx(placed.size)
            assert table.yaws[row[placed.id]] == pytest.approx(placed.yaw)
            assert table.instances[row[placed.id]] == placed.instance


def test_a_sentence_draws_the_nearest_that_its_solver_could_have_placed():
    table = in_street(draw(Style()))
    row = {id: number for number, id in enumerate(table.ids)}
    coarse = [placed for placed in THINGS if placed.id in row]
    assert len(coarse) > 0.9 * len(THINGS)
    for placed in coarse:
        off = np.hypot(*(table.centers[row[placed.id], :2] - (placed.x, placed.y)))
        assert off < 0.6, placed
        assert abs(math.sin(table.yaws[row[placed.id]] - placed.yaw)) < 0.1 or placed.kind in ("bin", "sign", "bench")
        assert (table.sizes[row[placed.id]] <= 1.25 * np.maximum(placed.size, 0.3)).all() or placed.kind == "person"
    assert (table.centers[:, 2] >= -0.05).all()


def test_what_a_style_leaves_out():
    everything = ids(Style())
    assert "sidewalk" in labels(Style())
    assert "sidewalk" not in labels(Style(sidewalks=False))
    assert "sidewalk" not in labels(Style(source="boxes", ground="patches", sidewalks=False))
    assert everything - ids(Style(posts=False)) >= {t.id for t in THINGS if t.kind in ("lamp", "sign", "pole")}
    assert "vegetation" not in labels(Style(named=("buildings",)))
    assert "building" in labels(Style(named=("buildings",)))
    assert "building" not in labels(Style(named=()))
    assert "car" in labels(Style(named=()))
    picture = Style(source="picture")
    small = {t.id for t in THINGS if kind_of(t.kind).is_small} & ids(picture)
    assert small
    assert not small & ids(replace(picture, omit=1.0))


def test_a_picture_shows_what_is_ahead_and_seen():
    table = draw(Style(source="picture", reach=40.0, view=1.5))
    objects = table.select(~np.isin(table.labels, [NAMES.index(name) for name in ("road", "sidewalk", "terrain")]))
    assert len(objects)
    middle = {placed.id: (placed.x, placed.y) for placed in THINGS}
    for id in {id.partition(".")[0] for id in objects.ids}:
        ahead = np.array(middle[id]) - HERE[:2]
        assert np.hypot(*ahead) <= 40.0
        assert abs(math.remainder(math.atan2(ahead[1], ahead[0]) - HERE[2], math.tau)) <= 0.75 + 1e-6
        assert SIGHTING.returns[[placed.id for placed in THINGS].index(id)].sum() >= 5


def test_a_picture_misjudges_a_little():
    exact, wrong = (draw(Style(source="picture", error=error, turn=error)) for error in (0.0, 0.02))
    assert exact.ids == wrong.ids
    off = np.hypot(*(exact.centers - wrong.centers)[:, :2].T)
    share = off / np.maximum(np.hypot(*exact.centers[:, :2].T), 5.0)
    assert 0.003 < np.median(share) < 0.03
    assert 0.003 < np.median(np.abs(exact.yaws - wrong.yaws)) < 0.04


def share_of_cars(table: ShapeTable) -> float:
    """How many of the returns from cars the cast drawing has within 0.5 m."""
    coarse = table.scan(SENSOR, SENSOR.poses_in_motion(SIGHTING.pose, (EGO.speed, 0.0, 0.0)))
    both = SCAN.valid & coarse.valid & (SCAN.label == NAMES.index("car"))
    return float((np.abs(coarse.depth - SCAN.depth)[both] < 0.5).mean())


def test_clusters_are_of_the_classes_of_real_clusters_and_where_they_were_seen():
    table = draw(Style(source="cloud", ground="patches"))
    numbers = set(SCAN.instance[SCAN.valid].tolist()) - {0}
    assert set(table.instances.tolist()) - {0} <= numbers
    # the drawing of what was seen agrees with it nearly as far as that of real clusters, as one street's few cars tell
    points, found = SCAN.points() @ SIGHTING.pose[:3, :3].T, SCAN.valid
    height = float(SIGHTING.pose[2, 3])
    labels, numbers = SCAN.label[found], SCAN.instance[found]
    real = ShapeTable.from_primitives(layout_from_cloud(points, labels, instances=numbers, sensor_height=height))
    assert {NAMES[k] for k in table.labels} == {NAMES[k] for k in real.labels}
    agreed = np.mean([share_of_cars(draw(Style(source="cloud", ground="patches"), seed)) for seed in range(5)])
    assert agreed == pytest.approx(share_of_cars(real), abs=0.1)
    assert agreed > 0.55


def test_points_without_numbers_merge_neighbours_and_lose_what_is_small():
    count, counted = {}, [NAMES.index("car"), NAMES.index("person")]
    for numbered in (True, False):
        tables = [draw(Style(source="cloud", ground="patches", numbered=numbered), seed) for seed in range(5)]
        count[numbered] = np.mean([np.isin(t.labels, counted).sum() for t in tables])
    assert 0.4 * count[True] < count[False] < 0.95 * count[True]


def test_ground_in_patches_follows_the_ground():
    rng = np.random.default_rng(0)
    along, across = rng.uniform(-30, 30, 60), rng.uniform(-1, 1, 60) * STREET.occupancy.road.edge
    caster = Raycaster(DRAWN.draw(Style(source="boxes", ground="patches"), rng, np.eye(4)).layout({}))
    places = np.array([STREET.occupancy.road.at(s, d)[:2] for s, d in zip(along, across, strict=True)])
    hits = caster.cast(np.column_stack([places, np.full(60, 60.0)]), np.tile([0.0, 0.0, -1.0], (60, 1)))
    bare = hits.label == NAMES.index("road")
    true = np.array([STREET.occupancy.ground.height(s, d) for s, d in zip(along, across, strict=True)])
    wrong = np.abs(60.0 - hits.distance - true)[bare]
    assert bare.mean() > 0.5
    assert np.median(wrong) < 0.03
    assert wrong.max() < 0.2


def test_what_was_seen_is_needed_for_what_draws_it():
    for source in ("cloud", "picture"):
        with pytest.raises(LayoutError, match=f"source '{source}' needs a sighting"):
            DRAWN.draw(Style(source=source), np.random.default_rng(0), EGO.pose)


def test_styles_are_of_every_kind():
    styles = [sample_style(np.random.default_rng(seed)) for seed in range(100)]
    assert {style.source for style in styles} == set(SOURCES)
    for name in ("ground", "sidewalks", "posts", "numbered"):
        assert len({getattr(style, name) for style in styles}) == 2, name
    assert {style.lobes for style in styles} == set(range(1, MOST_LOBES + 1))
    assert {family for style in styles for family in style.named} == set(FAMILIES)
    assert sample_style(np.random.default_rng(3)) == sample_style(np.random.default_rng(3))


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"source": "dream"}, "source is 'dream'; it must be one of text, cloud, picture, boxes"),
        ({"ground": "wet"}, "ground is 'wet'"),
        ({"omit": 1.5}, "omit is 1.5; it must be 0 to 1"),
        ({"lobes": 4}, "lobes is 4; it must be 1 to 3"),
        ({"named": ("ghosts",)}, "named holds 'ghosts'"),
        ({"error": float("nan")}, "error is nan"),
    ],
)
def test_style_errors(fields: dict, message: str):
    with pytest.raises(LayoutError, match=message):
        Style(**fields)


# Every kind of thing with the extents it usually has, and what is drawn of it.
KINDS = {
    "saloon": ((4.6, 1.8, 1.5), {"car"}),
    "truck": ((8.0, 2.5, 3.3), {"truck"}),
    "trailer_truck": ((16.5, 2.55, 4.0), {"truck"}),
    "bus": ((12.0, 2.55, 3.1), {"bus"}),
    "tram": ((28.0, 2.4, 3.5), {"train"}),
    "person": ((0.6, 0.5, 1.8), {"person"}),
    "cyclist": ((1.8, 0.6, 1.7), {"rider", "bicycle"}),
    "motorcyclist": ((2.1, 0.8, 1.6), {"rider", "motorcycle"}),
    "house": ((12.0, 9.0, 9.0), {"building"}),
    "tree": ((5.0, 5.0, 9.0), {"trunk", "vegetation"}),
    "hedge": ((6.0, 1.0, 1.6), {"vegetation"}),
    "barrier": ((4.0, 0.3, 0.8), {"fence"}),
    "mesh_fence": ((4.0, 0.05, 1.5), {"fence"}),
    "wall": ((8.0, 0.3, 3.0), {"wall"}),
    "gantry": ((0.4, 14.0, 7.0), {"pole", "traffic-sign"}),
    "billboard": ((0.3, 4.0, 4.0), {"other"}),
    "grass": ((5.0, 3.0, 0.2), set()),
    **dict.fromkeys(("shelter", "cone", "letterbox", "hydrant", "cabinet"), ((1.0, 0.5, 1.2), {"other"})),
}


@pytest.mark.parametrize("kind", sorted(KINDS))
def test_an_outline_fills_the_extents_of_its_thing(kind: str):
    size, classes = KINDS[kind]
    clearance = {"house": 6.0, "tree": 2.5, "gantry": 5.0, "billboard": 1.5}.get(kind, 0.0)
    placed = PlacedObject(
        kind=kind, id=kind, x=3.0, y=1.0, z=0.0, level=0.0, yaw=0.0, size=size, clearance=clearance, instance=4
    )
    marks = kind_of(kind).coarse(placed)
    assert {mark.label for mark in marks} == classes
    assert (kind == "grass") == (not marks)
    for lobes in range(1, MOST_LOBES + 1):
        chosen = [mark for mark in marks if mark.lobes in (0, lobes)]
        if not chosen or kind in ("cyclist", "motorcyclist", "house"):
            continue
        low = np.min([np.subtract(mark.center, np.array(mark.size) / 2) for mark in chosen], axis=0)
        high = np.max([np.add(mark.center, np.array(mark.size) / 2) for mark in chosen], axis=0)
        # the lobes of a crown lie around its middle, not all the way to every side
        slack = 0.15 * np.array(size) * (lobes > 1 and kind == "tree")
        assert (low >= [-size[0] / 2 - 1e-9, -size[1] / 2 - 1e-9, -1e-9]).all()
        assert (high <= [size[0] / 2 + 1e-9, size[1] / 2 + 1e-9, size[2] + 1e-9]).all()
        assert (high - low >= size - slack - 1e-9).all()


def test_a_rider_sits_on_what_is_ridden():
    objects = [t for seed in range(12) for t in make_street(seed).occupancy.objects if t.kind == "cyclist"]
    rider, bicycle = kind_of("cyclist").coarse(objects[0])
    assert (rider.label, bicycle.label) == ("rider", "bicycle")
    assert (rider.instance_offset, bicycle.instance_offset) == (0, 1)
    assert rider.center[2] > bicycle.center[2]


def test_every_word_of_a_kind_is_of_one_family_or_always_named():
    named = [*ALWAYS_NAMED, *(word for _, words in FAMILIES.values() for word in words)]
    assert len(named) == len(set(named))
    assert set(named) == {kind.word for kind in TABLE.values()} - {None}
    assert set(named) <= set(SENTENCE_KINDS)
    assert set(SENTENCE_KINDS) - set(named) <= {"vehicle", "garden"}  # a word for others, and one for several
