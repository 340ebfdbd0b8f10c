"""The report of the two-sample test: on folders of scans, and on recordings where there are some."""

import os
from pathlib import Path

import numpy as np
import pytest

import report_two_sample
from lidardraft.metrics.sweep import Sweep
from lidardraft.metrics.two_sample import FeatureGap, TwoSample
from lidardraft.scan import save_observed
from lidardraft.scene.sensor import PRESETS
from lidardraft.streets import StreetConfig, streets

needs_recordings = pytest.mark.skipif(
    not os.environ.get("LIDARDRAFT_DATA") or not Path(os.environ["LIDARDRAFT_DATA"], "kitti/odometry_00").is_dir(),
    reason="LIDARDRAFT_DATA has no recordings",
)


def test_scans_of_a_folder_are_as_they_were_made(tmp_path: Path) -> None:
    image = next(streets(3, StreetConfig(sensor=PRESETS["hdl64e"], poses_per_street=1))).scan
    save_observed(image, tmp_path / "00")
    (read,) = report_two_sample.scans_in(tmp_path)
    made = Sweep.from_image(image)
    assert (read.valid == made.valid).mean() > 0.999
    both = read.valid & made.valid
    assert np.abs(read.points[both] - made.points[both]).max() < 1e-3


def test_a_row_is_blank_where_there_is_nothing() -> None:
    found = TwoSample({"all": 0.9, "content": 0.5}, {"content.range": FeatureGap(0.25, 1.0, 2.0)})
    assert report_two_sample.row("made", found) == "| made | 0.900 | 0.500 |  |  |  |  |"
    assert report_two_sample.telling("made", found, 3)[1:] == ["- content: range 0.25 (1, 2)"]


def test_frames_of_many_drives_are_parted() -> None:
    sweep = Sweep(np.zeros((1, 1, 3), np.float32))
    parts = report_two_sample.parted({"a": [sweep], "object": [sweep] * 7})
    assert {name: len(sweeps) for name, sweeps in parts.items()} == {
        "a": 1,
        "object 0": 3,
        "object 1": 2,
        "object 2": 2,
    }


def test_without_recordings_it_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.argv", ["report_two_sample.py", "--data", str(tmp_path)])
    report_two_sample.main()
    assert "no recordings under kitti/" in capsys.readouterr().out


@needs_recordings
def test_streets_are_told_from_recordings(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr("sys.argv", ["report_two_sample.py", "--num", "8", "--sensor", "hdl64e"])
    report_two_sample.main()
    table = capsys.readouterr().out.splitlines()
    assert table[0] == "| scans | all | content | drop | noise | shape | intensity |"
    assert table[2].startswith("| streets, hdl64e | ")
