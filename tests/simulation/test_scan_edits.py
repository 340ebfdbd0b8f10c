"""Edits of recorded scans: simulated ones, of which it is known what stands behind an object, and real ones."""

import math
import os
import warnings
from pathlib import Path

import numpy as np
import pytest

from lidardraft import Box, Layout, Primitive, Sensor, simulate
from lidardraft.errors import LayoutError
from lidardraft.formats.kitti import read_bin
from lidardraft.formats.kitti_object import read_label_2
from lidardraft.formats.recording import read_points
from lidardraft.scene.raycast import Raycaster
from lidardraft.semantics import BY_NAME
from lidardraft.simulation.recorded.object_sampling import ObjectSampling
from lidardraft.simulation.recorded.recorded_scan import FILLED, INSERTED, RECORDED, RecordedScan, ground_of
from lidardraft.simulation.recorded.scan_edits import Insert, Move, Remove, Replace, edit_scan
from lidardraft.simulation.recorded.solid_object import WORDS, SolidObject

SENSOR = Sensor.preset("hdl64e")
ROAD = Primitive(shape="plane", center=(0, 0, 0), size=(140, 140, 0), label="road", id="road")
WALL = Primitive(shape="box", center=(30, 0, 3), size=(1, 80, 6), label="building", id="wall")
CAR = Primitive(shape="box", center=(12, 2, 0.75), size=(4.2, 1.8, 1.5), yaw=0.4, label="car", id="car_1", instance=1)
BUS = Primitive(shape="box", center=(-14, 5, 1.5), size=(11, 2.5, 3.0), label="bus", id="bus_1", instance=2)


def recorded(*things: Primitive, labelled: bool = True, seed: int = 0) -> RecordedScan:
    scan = simulate(Layout((ROAD, WALL, *things)), SENSOR, seed=seed)
    fields = {"intensity": scan.intensities(), "label": scan.labels(), "instance": scan.instances()}
    if not labelled:
        del fields["label"], fields["instance"]
    return RecordedScan.from_points(scan.points(), SENSOR, boxes=scan.boxes(), ring=scan.image.beams(), **fields)


@pytest.fixture(scope="module")
def scan() -> RecordedScan:
    return recorded(CAR, BUS)


def rows(points: np.ndarray) -> set[bytes]:
    return {row.tobytes() for row in points}


@pytest.mark.parametrize("kind", ["car", "truck", "person", "cyclist", "cone", "tree"])
def test_an_inserted_object_hides_what_is_behind_it_and_nothing_else(scan: RecordedScan, kind: str) -> None:
    edited = edit_scan(scan, [Insert(kind, (9, -4), 0.3, id="new")], seed=5)
    box, solid = edited.box("new"), SolidObject.of_kind(kind, name="new", seed=5)
    assert box.center[2] - box.size[2] / 2 == pytest.approx(-SENSOR.mount_height, abs=0.05)
    hits = solid.cast((*box.center[:2], box.center[2] - box.size[2] / 2), box.yaw, scan.directions, 80.0, 5)
    # a medium, such as a crown, lets other rays through in another cast
    opaque = np.array([part.extinction is None for part in solid.caster.layout])
    shadow = hits.valid & opaque[hits.primitive]
    kept = rows(edited.points[edited.returned & (edited.made_up == RECORDED)])
    behind = scan.returned & shadow & (scan.distance > hits.distance + 1e-3)
    around = Primitive(
        shape="box", center=box.center, size=tuple(np.add(box.size, 1.0)), yaw=box.yaw, label="car", id="a"
    )
    aside = scan.returned & ~Raycaster(Layout((around,))).cast(np.zeros(3), scan.directions).valid
    assert behind.sum() > 5
    assert not kept & rows(scan.points[behind])
    assert rows(scan.points[aside]) <= kept
    mine = edited.made_up == INSERTED
    assert mine.sum() > 0.6 * behind.sum()
    assert box.contains(edited.points[mine], 0.5).mean() > 0.95


def test_an_inserted_car_is_seen_as_a_simulated_one() -> None:
    truth, bare = recorded(CAR), recorded()
    (box,) = truth.boxes
    edited = edit_scan(bare, [Insert("car", box.center[:2], box.yaw, box.size)])
    mine = edited.made_up == INSERTED
    there = truth.instance == 1
    assert 0.75 < mine.sum() / there.sum() < 1.35
    assert 0.6 < edited.intensity[mine].mean() / truth.intensity[there].mean() < 1.7
    assert set(edited.label[mine]) == {BY_NAME["car"].id}
    assert 0.9 < edited.returned.sum() / truth.returned.sum() < 1.1


@pytest.mark.parametrize("labelled", [True, False])
def test_a_removed_object_leaves_what_stands_behind_it(scan: RecordedScan, labelled: bool) -> None:
    scan = scan if labelled else recorded(CAR, BUS, labelled=False)
    edited = edit_scan(scan, [Remove("car_1")])
    assert [box.id for box in edited.boxes] == ["bus_1"]
    box = scan.box("car_1")
    left = edited.points[edited.returned & ~edited.is_ground]
    assert box.contains(left, 0.1).sum() == 0
    filled = np.flatnonzero(edited.made_up == FILLED)
    assert len(filled) > 0.8 * box.contains(scan.points[scan.returned]).sum()
    truth = Raycaster(Layout((ROAD, WALL))).cast(np.array([0, 0, SENSOR.mount_height]), edited.directions[filled])
    near = np.abs(edited.distance[filled] - truth.distance) < np.maximum(0.3, 0.05 * truth.distance)
    assert near.mean() > 0.9
    if labelled:
        assert (edited.label[filled] == truth.label).mean() > 0.9
        assert (edited.intensity[filled] > 0).mean() > 0.5


@pytest.mark.parametrize("seed", range(6))
def test_an_inserted_object_goes_with_all_its_returns(scan: RecordedScan, seed: int) -> None:
    """The noise of weak echoes puts some outside its box."""
    inserted = edit_scan(scan, [Insert("van", (10, -5), 1.0)], seed=seed)
    there = (inserted.made_up == INSERTED) & inserted.returned
    assert there.sum() > 500
    rest = edit_scan(inserted, [Remove("van_1")], seed=seed)
    assert not (rest.made_up == INSERTED).any()


def test_edits_are_values_and_touch_no_other_return(scan: RecordedScan) -> None:
    edits = [Remove("car_1"), Insert("van", (10, -5), 1.0), Move("bus_1", (-20, -8), 0.2), Replace("van_1", "truck")]
    first, again = (edit_scan(scan, edits, seed=3) for _ in range(2))
    assert all(np.array_equal(getattr(first, name), getattr(again, name)) for name in ("points", "intensity", "label"))
    assert [box.id for box in first.boxes] == ["bus_1", "truck_1"]
    undone = edit_scan(scan, edits[:-1], seed=3)
    assert [box.id for box in undone.boxes] == ["van_1", "bus_1"]
    assert not np.array_equal(undone.points, edit_scan(scan, edits[:-1], seed=4).points)
    recorded_ones = rows(first.points[first.returned & (first.made_up == RECORDED)])
    assert recorded_ones < rows(scan.points[scan.returned])
    assert first.box("bus_1").center[:2] == (-20, -8)
    assert len(first.source) == len(first.points)
    assert first.source.max() < scan.returned.sum()


@pytest.mark.parametrize("yaw", [None, 1.2])
def test_what_is_moved_keeps_its_heading_where_no_other_is_given(scan: RecordedScan, yaw: float | None) -> None:
    moved = edit_scan(scan, [Move("car_1", (10, -6), yaw)])
    box, heading = moved.box("car_1"), CAR.yaw if yaw is None else yaw
    assert (box.yaw, box.size) == (pytest.approx(heading), pytest.approx(CAR.size))
    new = moved.points[moved.made_up == INSERTED]
    stands = Box("car_1", "car", 1, (10, -6, 0.75 - SENSOR.mount_height), CAR.size, heading)
    assert len(new) > 300
    assert stands.contains(new, 0.2).mean() > 0.99  # mirrors, and noise of its ranges
    across = Box("car_1", "car", 1, stands.center, CAR.size, heading + 0.4)
    assert across.contains(new, 0.2).mean() < 0.9


def test_rays_that_had_no_return_meet_what_stands_in_the_sky() -> None:
    """The upper lasers look over the road: what is high enough returns them."""
    bare = recorded()
    edited = edit_scan(bare, [Insert("bus", (-12, 6), 0.0, (11.0, 2.5, 3.2))])
    new = edited.points[edited.made_up == INSERTED]
    assert (new[:, 2] > -0.2).sum() > 300
    assert (bare.points[bare.returned][:, 0] < -5).any()
    assert not (bare.points[bare.returned & (bare.points[:, 0] < -5)][:, 2] > -0.2).any()


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (Insert("zebra", (9, 0)), "'zebra' is no object that can be inserted; it must be"),
        (Insert("car", (9, -9), size=(4.0, math.nan, 1.5)), "car_2: size is (4.0, nan, 1.5); it must be three lengths"),
        (Insert("car", (9, -9), size=(4.0, 2.0)), "car_2: size is (4.0, 2.0); it must be three lengths"),
        (Insert("car", (12, 2)), "car_2 at 12, 2 would overlap car_1 by"),
        (Insert("car", (1, 0)), "would overlap the recording vehicle by"),
        (Insert("car", (300, 0)), "is 300 m away; hdl64e reaches 80 m"),
        (Insert("car", (float("nan"), 0)), "must be x, y [m] and an angle [rad], all finite"),
        (Insert("car", (9, -9), id="bus_1"), "bus_1: an object of the scan has this id already"),
        (Remove("car_9"), "no object has the id 'car_9'; the scan has car_1, bus_1"),
        (Move("bus_1", (12, 2)), "bus_1 at 12, 2 would overlap car_1"),
        (Replace("car_1", "boat"), "'boat' is no object"),
    ],
)
def test_edits_that_cannot_be(scan: RecordedScan, edit: Insert, message: str) -> None:
    with pytest.raises(LayoutError) as error:
        edit_scan(scan, [edit])
    assert message in str(error.value)


@pytest.mark.parametrize("word", WORDS)
def test_every_kind_stands_in_its_box(word: str) -> None:
    solid = SolidObject.of_kind(word, seed=1)
    place, reach = (-40.0, 0.0, -1.0), max(solid.size)
    grid = np.meshgrid([40.0], np.linspace(-reach, reach, 200), np.linspace(-reach, reach, 200))
    directions = -np.stack([axis.ravel() for axis in grid], axis=1)
    hits = solid.cast(place, 0.5, directions, 200.0, 0)
    points = hits.points()
    assert len(points) > 20
    assert -0.15 < points[:, 2].min() < 0.6
    assert np.abs(points[:, :2]).max() < math.hypot(*solid.size[:2]) / 2 + 0.35
    assert points[:, 2].max() < 1.1 * solid.size[2] + 0.2


def test_the_ground_of_a_scan_without_classes() -> None:
    scan = recorded(CAR, BUS)
    points, truth = scan.points[scan.returned], scan.label[scan.returned] == BY_NAME["road"].id
    below = [points[truth & (np.hypot(points[:, 0] - x, points[:, 1] + 4) < 0.4)] - (0, 0, 2) for x in (6, 17)]
    mirrored = np.concatenate(below)  # as wet roads and car bodies mirror
    found = ground_of(np.concatenate([points, mirrored]))
    assert found[: len(points)][truth].mean() > 0.9
    assert found[: len(points)][~truth].mean() < 0.1
    assert not found[len(points) :].any()


def test_an_edited_scan_is_saved_and_read_again(scan: RecordedScan, tmp_path: Path) -> None:
    edited = edit_scan(scan, [Remove("car_1"), Insert("person", (6, -2))])
    edited.save(tmp_path / "edited")
    points, fields = read_points(tmp_path / "edited.npz")
    assert np.array_equal(points, edited.points[edited.returned])
    assert np.array_equal(np.bincount(fields["made_up"]), np.bincount(edited.made_up[edited.returned]))
    raw = np.fromfile(tmp_path / "edited.label", "<u4")
    assert np.array_equal(raw == 1, fields["made_up"] == FILLED)  # SemanticKITTI's outliers
    again = RecordedScan.from_points(points, SENSOR, boxes=edited.boxes, **fields)
    assert (again.made_up == INSERTED).sum() == (edited.made_up == INSERTED).sum()
    assert edit_scan(again, [Remove("person_1")]).boxes == again.boxes[:-1]


@pytest.fixture(scope="module")
def sample(scan: RecordedScan) -> dict[str, np.ndarray]:
    there = scan.returned
    stamps = np.linspace(0, 0.1, there.sum())
    return {
        "points": np.column_stack([scan.points[there], 255 * scan.intensity[there], stamps]).astype(np.float32),
        "gt_boxes": np.array([(*box.center, *box.size, box.yaw) for box in scan.boxes], np.float32),
        "gt_names": np.array(["Car", "Bus"]),
        "frame_id": np.array(7),
    }


def test_sampling_fills_up_a_sample_with_objects_that_stand_free(sample: dict[str, np.ndarray]) -> None:
    counts = {"car": 6, "person": 5, "cyclist": 3}
    sampling = ObjectSampling(counts, SENSOR, models=3, seed=1, intensity_scale=255)
    found = sampling(sample)
    assert found["frame_id"] == 7
    names = found["gt_names"].tolist()
    assert {name: names.count(name) for name in set(names)} == {"Car": 6, "Pedestrian": 5, "Cyclist": 3, "Bus": 1}
    assert np.array_equal(found["gt_boxes"][:2], sample["gt_boxes"])
    assert found["points"].dtype == np.float32
    assert 1 < found["points"][:, 3].max() <= 255
    assert 0 <= found["points"][:, 4].min() <= found["points"][:, 4].max() <= np.float32(0.1)
    solids = [
        Box(str(k), "car", k, tuple(row[:3]), tuple(row[3:6]), row[6])
        for k, row in enumerate(found["gt_boxes"].tolist())
    ]
    for number, box in enumerate(solids):
        corners = np.concatenate([other.corners() for other in solids[:number]] or [np.zeros((0, 3))])
        assert not box.contains(corners, -0.35).any()
    seen = [int(box.contains(found["points"][:, :3], 0.1).sum()) for box in solids[2:]]
    assert np.mean(np.array(seen) > 5) > 0.7
    again = ObjectSampling(counts, SENSOR, models=3, seed=1, intensity_scale=255)(sample)
    assert np.array_equal(again["points"], found["points"])
    assert not np.array_equal(sampling(sample)["points"], found["points"])
    assert not np.array_equal(
        ObjectSampling(counts, SENSOR, models=3, seed=2, intensity_scale=255)(sample)["points"], found["points"]
    )


def test_sampling_takes_scans_without_boxes_and_refuses_unknown_kinds(sample: dict[str, np.ndarray]) -> None:
    bare = {
        "points": sample["points"][:, :4],
        "gt_boxes": np.zeros((0, 7), np.float32),
        "gt_names": np.array([], object),
    }
    found = ObjectSampling({"truck": 2}, SENSOR, models=1, intensity_scale=255)(
        bare | {"gt_boxes_mask": np.zeros(0, bool)}
    )
    assert found["gt_names"].tolist() == ["Truck", "Truck"]
    assert found["gt_boxes_mask"].tolist() == [True, True]
    for counts, models, message in (
        ({"boat": 1}, 1, "'boat' is no object"),
        ({"car": -3}, 1, "car: -3 is not a whole number from 0"),
        ({"car": 2.5}, 1, "car: 2.5 is not a whole number from 0"),
        ({"car": 2}, 0, "models: 0 is not a whole number from 1"),
    ):
        with pytest.raises(LayoutError, match=message):
            ObjectSampling(counts, SENSOR, models=models)


def test_what_is_no_sensor_and_no_scan(sample: dict[str, np.ndarray]) -> None:
    with pytest.raises(TypeError, match="sensor is a str"):
        RecordedScan.from_points(sample["points"][:, :3], "hdl64e")
    with pytest.raises(TypeError, match="sensor is a str"):
        ObjectSampling({"car": 1}, "hdl64e")
    with pytest.raises(TypeError, match="scan is a ndarray"):
        edit_scan(sample["points"], [Remove("car_1")])


def test_a_recorded_car_and_one_in_its_place() -> None:
    folder = Path(os.environ.get("LIDARDRAFT_DATA", "")) / "kitti" / "object" / "training"
    if not folder.is_dir():
        pytest.skip("no recordings: LIDARDRAFT_DATA is not set")
    points, intensity = read_bin(folder / "velodyne" / "000003.bin")
    boxes = read_label_2(folder / "label_2" / "000003.txt")
    scan = RecordedScan.from_points(points, SENSOR, boxes=boxes, intensity=intensity)
    assert 0.05 < (~scan.returned).mean() < 0.5  # rays without a return, found in the gaps of the rings
    assert scan.ground_height(10, 0) == pytest.approx(-1.75, abs=0.05)
    mine = scan.returned & ~scan.is_ground & boxes[0].contains(scan.points, 0.15)
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # nothing is left where the new one stands
        bare = edit_scan(scan, [Remove("car_1")])
        again = edit_scan(bare, [Insert("car", boxes[0].center[:2], boxes[0].yaw, boxes[0].size)], seed=1)
    filled = bare.points[bare.made_up == FILLED]
    assert len(filled) > 0.9 * mine.sum()
    assert np.hypot(*filled[:, :2].T).min() > 12
    assert 0.6 < (again.made_up == INSERTED).sum() / mine.sum() < 1.5
