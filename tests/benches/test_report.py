"""The report of streets beside recordings: on recordings where there are some, on streets where not."""

import os
from pathlib import Path

import numpy as np
import pytest

import recordings
import report_streets
from lidardraft.metrics.lifelike import Comparison
from lidardraft.metrics.sweep import Sweep
from lidardraft.scene.sensor import PRESETS
from lidardraft.semantics import BY_NAME
from lidardraft.streets import StreetConfig, streets
from recordings import Recordings

needs_recordings = pytest.mark.skipif(
    not os.environ.get("LIDARDRAFT_DATA") or not Path(os.environ["LIDARDRAFT_DATA"], "kitti/odometry_00").is_dir(),
    reason="LIDARDRAFT_DATA has no recordings",
)


def data() -> Path:
    return Path(os.environ["LIDARDRAFT_DATA"])


def street_sweeps(seed: int, count: int) -> list[Sweep]:
    pairs = streets(seed, StreetConfig(sensor=PRESETS["vlp16"], poses_per_street=count))
    return [Sweep.from_image(next(pairs).scan) for _ in range(count)]


def test_other_streets_are_as_lifelike_as_streets() -> None:
    groups = {"a": street_sweeps(1, 3), "b": street_sweeps(3, 3)}
    real = Recordings(sensor="vlp16", plain=groups, labelled=groups)
    lines, pooled = report_streets.report(real, PRESETS["vlp16"], 8)
    ratios = {line.name: line.ratio for line in lines}
    assert set(ratios) >= {"return rate by laser", "intensity (JSD)", "roughness of road (JSD)", "share of road"}
    assert 0.3 < np.nanmedian(list(ratios.values())) < 3.0
    known = [line.ratio for line in lines if not np.isnan(line.ratio)]
    assert known == sorted(known, reverse=True)
    assert set(pooled["range (JSD)"]) == {"a", "b", "streets"}


def test_the_table_says_what_was_compared() -> None:
    real = Recordings(sensor="vlp16", plain={"a": street_sweeps(1, 1)})
    text = report_streets.markdown(
        real,
        [
            Comparison(
                "range (JSD)",
                9.17,
                8.5,
                0.088,
                0.1188,
            )
        ],
        40,
    )
    assert "40 scans of streets beside a (1)." in text
    assert "| range (JSD) | 9.17 | 8.5 | 0.088 | 0.119 | 1.35 |" in text


def test_what_the_recording_car_hides_is_hidden() -> None:
    sensor = PRESETS["vlp16"]
    points = np.ones((*sensor.shape, 3), dtype=np.float32)
    points[15, 100:200] = 0  # down, always
    points[0, 300:400] = 0  # up: sky
    shown = report_streets.unhidden({"a": [Sweep(points)]}, sensor, None)
    assert not shown[15, 100:200].any()
    assert shown.sum() == shown.size - 100


@pytest.mark.parametrize(
    ("folder", "reason"),
    [
        (".", "no recordings under kitti/"),
        ("none", "no recordings; name their folder in LIDARDRAFT_DATA or --data"),
    ],
)
def test_reasons_are_given(folder: str, reason: str, capsys, monkeypatch, tmp_path: Path) -> None:
    monkeypatch.setattr("sys.argv", ["report", "--sensors", "hdl64e", "--data", str(tmp_path / folder), "--jobs", "1"])
    report_streets.main()
    assert f"### hdl64e\n\nSkipped: {reason}." in capsys.readouterr().out


@pytest.mark.parametrize("wrong", [["--sensors", "sonar"], ["--num", "1"], ["--jobs", "0"]])
def test_wrong_arguments(wrong: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.argv", ["report", *wrong])
    with pytest.raises(SystemExit):
        report_streets.main()


def test_a_group_is_left_out_wherever_it_is() -> None:
    sweep = Sweep(np.ones((2, 8, 3), dtype=np.float32))
    plain = {"a": [sweep], "b": [sweep]}
    real = Recordings(sensor="vlp16", plain=plain, labelled={"a": [sweep]}, shares={"c": np.ones(3)})
    left = report_streets.without_group(real, "a")
    assert (list(left.plain), list(left.labelled), list(left.shares)) == (["b"], [], ["c"])
    assert not report_streets.without_group(real, "c").shares
    with pytest.raises(SystemExit, match="--without is 'raw'; the groups are a, b, c"):
        report_streets.without_group(real, "raw")


def test_a_sensor_to_scan_with_has_as_many_pixels(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.argv", ["report", "--sensors", "hdl64e", "--scan-with", "vlp16"])
    with pytest.raises(SystemExit):
        report_streets.main()
    assert "vlp16 has 16 x 1800 pixels; hdl64e has 64 x 1024" in capsys.readouterr().err


@needs_recordings
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


@needs_recordings
def test_hesai_rows_are_those_of_the_laser_table() -> None:
    sweeps = recordings.pandar64(data(), 1800)
    assert len(sweeps.plain) == 3
    assert {name: len(group) for name, group in sweeps.labelled.items()} == {"PandaSet 001": 2, "PandaSet 002": 10}
    for sweep in sweeps.labelled["PandaSet 001"]:
        assert sweep.label is not None
        assert sweep.valid[48:60].mean() > 0.9  # the road; rows here are fitted


@needs_recordings
def test_ika_looks_ahead() -> None:
    sweeps = recordings.vlp32c(data(), 1800)
    assert sum(len(group) for group in sweeps.plain.values()) == 25
    assert sweeps.fov == pytest.approx(np.deg2rad(48))
