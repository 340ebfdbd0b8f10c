import json
import math
import re
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from lidardraft import Sensor
from lidardraft.calibration.street_casts import StreetCasts
from lidardraft.cli import main as cli
from lidardraft.formats.kitti import write_bin
from lidardraft.formats.recording import read_recording
from lidardraft.metrics.sweep import Sweep
from lidardraft.scene.sensor_model import SensorModel


@cache
def sweeps() -> list[Sweep]:
    sensor = Sensor(name="truth", elevations=tuple(np.deg2rad(np.linspace(2, -20, 8)).tolist()), columns=256)
    model = SensorModel(tilt_spread=0.0, gain_spread=0.0)
    return StreetCasts.from_sensor(sensor, model, 3, seed=0).observed(model, 0.01)


@pytest.fixture
def scans(folder: Path) -> list[str]:
    """Three scans of streets in KITTI's order: laser by laser, once around to the left from straight ahead."""
    names = []
    for number, sweep in enumerate(sweeps()):
        row, _ = np.nonzero(sweep.valid)
        points, intensity = sweep.points[sweep.valid], sweep.intensity[sweep.valid]
        order = np.lexsort((np.arctan2(points[:, 1], points[:, 0]) % (2 * np.pi), row))
        names.append(f"{number}.bin")
        write_bin(folder / names[-1], points[order], intensity[order])
    return names


def test_scans_become_a_sensor_that_other_commands_take(scans: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["fit", *scans, "-o", "mine.json", "--streets", "4"]) == 0
    captured = capsys.readouterr()
    said = captured.out
    assert "fitted to one scan alone" not in captured.err
    assert "lasers: 8, returns " in said
    assert "points lost in projection: 0.0" in said
    assert "more where a beam has several echoes\n" in said
    assert "from patch to patch, " in said
    assert "| intensity (JSD) |" in said
    assert said.endswith("mine.json: fitted to 2 scans\n")
    sensor = Sensor.load("mine.json")
    strong, weak = map(
        float, re.search(r"range noise: (\S+) mm of strong echoes, (\S+) mm of a surface 30 m", said).groups()
    )
    power = 0.10 / 30**2 / sensor.model.detection_threshold
    assert (strong, weak) == pytest.approx(
        (1e3 * sensor.range_sigma, 1e3 * math.hypot(sensor.range_sigma, sensor.model.jitter / power**0.5)), abs=0.5
    )
    assert (sensor.name, len(sensor.elevations)) == ("mine", 8)
    assert sensor.model is not None
    assert sensor.model.intensity_curve is not None
    assert cli.main(["raycast", "--text", "a car ahead", "--sensor", "mine.json", "-o", "a.npz"]) == 0
    assert cli.main(["simulate", "--text", "a car ahead", "--sensor", "mine.json", "-o", "scans"]) == 0
    assert cli.main(["streets", "--sensor", "mine.json", "-n", "1", "--workers", "1", "-o", "pairs"]) == 0


def test_scans_to_judge_by_are_named_and_all_others_are_fitted_to(
    scans: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["fit", *scans[:2], "--judge", scans[2], "-o", "mine.json", "--streets", "4", "--columns", "200"]
    assert cli.main([*command, "--like", "vlp16"]) == 0
    said = capsys.readouterr().out
    assert "beside 1 scan that nothing was fitted to" in said
    assert said.endswith("mine.json: fitted to 2 scans\n")
    assert json.loads(Path("mine.json").read_text())["columns"] == 200


def test_lasers_that_are_mixed_up_are_told(scans: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    recording = read_recording(scans[0])
    np.savez("mixed.npz", xyz=recording.points, ring=recording.ring + (recording.points[:, 1] < 0))
    assert cli.main(["fit", "mixed.npz", "-o", "mine.json", "--streets", "4"]) == 0
    said = capsys.readouterr()
    assert "% of the points look like those of other lasers" in said.err
    assert said.err.count("fitted to one scan alone") == 1


def test_a_constant_at_the_limit_of_its_search_is_told(scans: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    recording = read_recording(scans[0])
    noisy = np.random.default_rng(0).normal(1.0, 0.05, (len(recording.points), 1))  # more than any sensor has
    np.savez("noisy.npz", xyz=recording.points * noisy, ring=recording.ring)
    assert cli.main(["fit", "noisy.npz", "-o", "mine.json", "--streets", "4"]) == 0
    assert " is at the limit of its search, " in capsys.readouterr().err


def test_scans_that_are_odd_are_named_and_left_out(scans: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    Path("drive").mkdir()
    for name in scans:
        Path(name).rename(Path("drive", name))
    Path("drive", "cut.bin").write_bytes(Path("drive", "0.bin").read_bytes()[:-3])
    recording = read_recording("drive/0.bin")
    np.savez("drive/half.npz", xyz=recording.points, ring=recording.ring // 2, intensity=recording.intensity)
    stray = np.where(np.arange(len(recording.ring)) < 4, 160, recording.ring)
    np.savez("drive/stray.npz", xyz=recording.points, ring=stray, intensity=recording.intensity)
    assert cli.main(["fit", "drive", "-o", "mine.json", "--streets", "4", "--json"]) == 0
    said = capsys.readouterr()
    assert said.err.splitlines()[:3] == [
        f"lidardraft: left out: drive/cut.bin has {Path('drive/cut.bin').stat().st_size} bytes; a KITTI scan has 16 a "
        "point, so it is truncated",
        "lidardraft: left out: drive/half.npz: it has 4 lasers, drive/0.bin has 8",
        "lidardraft: left out: rings 160, each with fewer than 20 returns in all of the scans together",
    ]
    constants, rows, last = map(json.loads, said.out.splitlines())
    assert (constants["lasers"], rows["judged_on"], last) == (8, 1, {"output": "mine.json", "scans": 3})
    assert {"name", "before", "after", "recorded"} == rows["properties"][0].keys()


def test_bad_input_is_one_line(refused: Callable[..., str], scans: list[str]) -> None:
    assert "nowhere.bin: no such file or folder" in refused("fit", "nowhere.bin", "-o", "mine.json")
    Path("scan.xyz").write_text("1 2 3")
    assert "scan.xyz: a recorded scan is one of .bin, .pcd.bin, .pcd, .ply, .npz, .npy, .las" in refused(
        "fit", "scan.xyz", "-o", "mine.json"
    )
    assert "mine.txt: a sensor file ends in .json" in refused("fit", scans[0], "-o", "mine.txt")
    assert "sensor is 'hdl65e'; it must be a .json file or one of hdl64e, " in refused(
        "fit", scans[0], "--like", "hdl65e", "-o", "mine.json"
    )
    Path("empty.bin").write_bytes(b"")
    assert "empty.bin is empty" in refused("fit", "empty.bin", "-o", "mine.json")
