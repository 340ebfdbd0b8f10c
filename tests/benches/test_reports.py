"""Reports beside recordings: on recordings where there are some, on streets and made layouts where not."""

import math
import os
from pathlib import Path

import numpy as np
import pytest

import recordings
import report_detail
import report_streets
import report_two_sample
import result_page
from cases import Case, CaseSet, Group, street_set
from lidardraft import Box, RangeImage, layout_from_cloud, layout_from_text, raycast, simulate
from lidardraft.metrics.lifelike import CLASS_SETS
from lidardraft.metrics.sweep import Sweep
from lidardraft.scene.sensor import PRESETS, Sensor
from lidardraft.semantics import BY_NAME, CLASSES, GROUND
from object_labels import LabelledBoxes, iou, recovered
from report_cloud import measure
from report_detail import SENTENCES, new_counts, of_sentences, of_streets
from report_simulate import EQUAL, losses, markdown, report, table_of
from tables import table

needs_recordings = pytest.mark.skipif(
    not os.environ.get("LIDARDRAFT_DATA") or not Path(os.environ["LIDARDRAFT_DATA"], "kitti/odometry_00").is_dir(),
    reason="LIDARDRAFT_DATA has no recordings",
)


def data() -> Path:
    return Path(os.environ["LIDARDRAFT_DATA"])


def counts(**by_set: float) -> np.ndarray:
    return np.array([by_set.get(name, 0.0) for name in CLASS_SETS])


def test_shares_are_of_the_classes_that_the_recordings_know() -> None:
    recorded = {"a": [counts(road=30, car=10)], "b": [counts(road=10, car=10)]}
    everything, *classes = report_streets.share_properties(recorded)
    assert [row.name for row in classes] == ["share of road", "share of car"]
    generated = [counts(road=10, car=30, fence=1000)]
    assert classes[0].summary(generated) == 0.25
    assert classes[0].distance(recorded["a"], generated) == pytest.approx(0.5)
    assert everything.distance(recorded["a"], generated) == pytest.approx(0.5)


@needs_recordings
@pytest.mark.slow
def test_kitti_fills_its_rows() -> None:
    sweeps = recordings.hdl64e(data(), 1024)
    assert set(sweeps.plain) == {"raw 0005", "odometry 00", "object"}
    every = [sweep for group in sweeps.plain.values() for sweep in group]
    for sweep in every:
        assert sweep.depth.shape == (64, 1024)
        elevation = np.arctan2(sweep.points[..., 2], np.hypot(sweep.points[..., 0], sweep.points[..., 1]))
        middle = [np.median(elevation[row][sweep.valid[row]]) for row in range(64)]
        assert np.all(np.diff(middle) < 0)
    # what looks at the road near by and is not hidden by the car returns
    assert np.mean([sweep.valid[36:42] for sweep in every]) > 0.95
    labels = sweeps.labelled["00, left"][0].label
    assert labels is not None
    assert np.isin([BY_NAME["road"].id, BY_NAME["building"].id], labels).all()
    assert sweeps.shares["all of SemanticKITTI"].sum() == pytest.approx(0.98, abs=0.02)


@pytest.mark.slow
@needs_recordings
def test_streets_are_told_from_recordings(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr("sys.argv", ["report_two_sample.py", "--num", "8", "--sensor", "hdl64e"])
    report_two_sample.main()
    table = capsys.readouterr().out.splitlines()
    assert table[0] == "| scans | all | content | drop | noise | shape | intensity |"
    assert table[2].startswith("| streets, hdl64e | ")


def test_a_page_keeps_what_is_below_its_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.argv", ["benches/report_x.py", "--num", "8", "--text", "a car", "--page"])
    result_page.write_page("x", "said.", "| 1 |", tmp_path)
    page = tmp_path / "x.md"
    page.write_text(page.read_text() + f"\n{result_page.KEPT}\n\n| old |\n")
    result_page.write_page("x", "said.", "| 2 |", tmp_path)
    head, *rest = page.read_text().split("\n\n")
    assert head.startswith("Measured 20")
    assert head.endswith("by `python benches/report_x.py --num 8 --text 'a car'`: said.")
    assert rest == ["| 2 |", result_page.KEPT, "| old |\n"]


SENSOR = PRESETS["hdl64e"]


def test_a_scan_held_against_itself_agrees_in_all_rows() -> None:
    layout = layout_from_text("a car 7 m ahead, another car, trees on the left and a building on the right", seed=3)
    recorded = Sweep.by_azimuth(simulate(layout, SENSOR, seed=0).image)
    cases = CaseSet(
        [Case(recorded, layout, SENSOR, SENSOR.pose())], Sweep.by_azimuth, np.ones(SENSOR.shape, bool), True
    )
    table = report(cases)
    for row, cells in table.items():
        assert cells["simulated"] == (pytest.approx(0.0, abs=1e-6) if "JSD" in row or "MMD" in row else 1.0) or (
            row.startswith("dropped")
        ), row
    assert {"near, on car", "IoU of vegetation", "intensity of building (JSD)", "drop recall"} <= set(table)
    assert table["dropped"]["simulated"] == table["dropped in recording"]["cast"] > 0.0
    assert table["IoU of car"]["+ sensor model"] < 0.8
    assert max(losses(table).values()) < EQUAL
    assert ", 0 worse." in markdown(table)


def test_scans_of_a_case_have_one_road() -> None:
    points = np.zeros((2, 400, 3), dtype=np.float32)
    points[..., 0] = 6.0
    points[0, :, 2], points[1, :, 2] = -1.72, -1.98
    label = np.ones((2, 400), dtype=np.uint8)

    def without(row: int) -> Sweep:
        return Sweep(np.where((np.arange(2) == row)[:, None, None] & (np.arange(400) < 9)[:, None], 0, points), label)

    # the commonest height is the one of either row: by a road of its own, all of a scan would lie 0.25 m off
    table = table_of([{"recorded": without(1), "cast": without(0), "simulated": without(0)}], firings=True)
    assert table["height over the road (JSD)"]["simulated"] < 0.02


@pytest.mark.slow
def test_details_bring_coarse_layouts_nearer_to_their_streets() -> None:
    table = report(street_set(12))
    assert table["IoU of car"]["simulated"] > table["IoU of car"]["+ sensor model"] + 0.05
    name = "intensity of vegetation (JSD)"
    assert table[name]["simulated"] < 0.5 * table[name]["+ sensor model"]


@needs_recordings
@pytest.mark.parametrize(
    ("images", "grid"),
    [
        (recordings.kitti_images, PRESETS["hdl64e-linear"]),
        (recordings.nuscenes_images, recordings.NUSCENES_GRID),
    ],
)
def test_images_of_recordings_are_on_their_grid(images: object, grid: Sensor) -> None:
    assert callable(images)
    for sweep in images(Path(os.environ["LIDARDRAFT_DATA"])):
        image = RangeImage.project(sweep.points[sweep.valid], grid)
        same = (image.valid & sweep.valid).sum() / sweep.valid.sum()
        assert same > 0.97
        assert set(np.unique(sweep.label[~sweep.valid])) <= {0}


OBJECTS = [row.id for row in CLASSES[1:] if row.name not in GROUND]


def test_details_obey_a_coarse_layout_as_well_as_the_street_that_it_is_of() -> None:
    counts = new_counts()
    for number in range(2):
        of_streets(counts, number)
    near, total = np.array([found[:, OBJECTS].sum(axis=1) for found in counts.values()]).T
    shares = dict(zip(counts, near / total, strict=True))
    for style in ("text", "cloud", "picture", "boxes"):
        assert shares[style] > shares[f"{style}: street"], style
        assert 0.6 < shares[style] < 0.95


def test_the_details_of_sentences_obey_and_the_table_says_so() -> None:
    counts = new_counts()
    times = of_sentences(counts, SENTENCES[2:3], 1)
    assert len(times) == 1
    found = counts["sentences"]
    assert found[0, OBJECTS].sum() / found[1, OBJECTS].sum() > 0.7
    lines = report_detail.report(counts).splitlines()
    assert lines[0] == "| | sentences | returns |"
    assert next(line for line in lines if line.startswith("| road")).split(" | ")[1] == "1.00"
    assert lines[-1].startswith("| all objects | 0.")


CAR = BY_NAME["car"].id


@pytest.fixture(scope="module")
def group() -> Group:
    layout = layout_from_text("a car 7 m ahead, another car, trees on the left and a building on the right", seed=3)
    sweep = Sweep.by_azimuth(raycast(layout, SENSOR))
    return Group([sweep], SENSOR, Sweep.by_azimuth, np.ones(SENSOR.shape, dtype=bool), firings=True)


def test_the_layout_of_a_cast_comes_near_it(group: Group) -> None:
    row = measure(group, "fine")
    assert row["near"] > 0.97
    assert 0.9 < row["near on objects"] < row["near"]
    assert row["holes"] == 0.0
    assert row["empty"] < 0.02
    assert abs(row["along rays"] - row["near"]) < 0.02
    assert measure(group, "objects")["primitives"] < row["primitives"]


def box(x: float, y: float, length: float = 4.0, width: float = 2.0, yaw: float = 0.0) -> Box:
    return Box("car", "car", 1, (x, y, 0.0), (length, width, 1.5), yaw)


@pytest.mark.parametrize(
    ("other", "expected"),
    [
        (box(0, 0), 1.0),
        (box(2, 0), 1 / 3),
        (box(0, 0, 2.0, 4.0, math.pi / 2), 1.0),
        (box(0, 0, 4.0, 2.0, math.pi / 2), 4 / 12),
        (box(30, 0), 0.0),
    ],
)
def test_intersection_over_union_from_above(other: Box, expected: float) -> None:
    assert iou(box(0, 0), other) == pytest.approx(expected, abs=0.02)


def test_a_car_is_found_where_its_points_make_a_box() -> None:
    side = [[x, 6.0, z] for x in np.arange(8, 12.2, 0.1) for z in np.arange(-1.6, -0.3, 0.1)]
    back = [[8.0, y, z] for y in np.arange(6, 7.8, 0.1) for z in np.arange(-1.6, -0.3, 0.1)]
    points = np.array(side + back)
    cars = [Box("car", "car", 1, (10.1, 6.9, -0.95), (4.2, 1.8, 1.5), math.pi)]
    frame = LabelledBoxes(points, np.full(len(points), CAR, dtype=np.uint8), cars, 1.73)
    assert recovered(frame, layout_from_cloud(points, frame.labels)) == (1, 1)
    assert recovered(frame, layout_from_cloud(points, np.full(len(points), BY_NAME["building"].id))) == (1, 0)
    assert recovered(frame, layout_from_cloud(points, frame.labels), least_points=10_000) == (0, 0)


def test_columns_are_those_of_all_rows() -> None:
    lines = table({"one": {"a": 1.0}, "two": {"b": 0.1234, "a": math.nan}}).splitlines()
    assert lines == ["| | a | b |", "|---|---:|---:|", "| one | 1 | - |", "| two | - | 0.123 |"]
