"""`lidardraft export`: folders of scans as other people's data sets."""

import json
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from lidardraft import Layout, RangeImage, Scan, Sensor
from lidardraft.cli import main as cli

TEXT = "a car 10 m ahead and a bus behind"
CAST = ["raycast", "--surroundings", "bare", "--sensor", "small.json"]
DRAFT = ["simulate", "--surroundings", "bare", "--text", TEXT, "--sensor", "small.json", "--no-picture"]


def test_folders_are_drives_of_one_data_set(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([*DRAFT, "--speed", "5", "-n", "2", "-o", "scans"]) == 0
    assert cli.main(["export", "scans", "scans", "--format", "semantickitti", "-o", "sets/one"]) == 0
    assert capsys.readouterr().out.endswith("sets/one: 4 scans as semantickitti\n")
    assert sorted(path.name for path in Path("sets/one/sequences").glob("*/velodyne/*")) == sorted(
        ["000000.bin", "000001.bin"] * 2
    )


def test_a_saved_scan_is_loaded_as_it_was() -> None:
    assert cli.main([*DRAFT, "--speed", "5", "-o", "scans"]) == 0
    scan = Scan.load("scans/000000")
    assert scan.speed == 5.0
    np.testing.assert_array_equal(
        scan.points().ravel(), np.fromfile("scans/000000.bin", "<f4").reshape(-1, 4)[:, :3].ravel()
    )
    assert scan.layout == Layout.load("scans/000000.layout.json")
    assert len(scan.frame().annotations) == 2


def test_observed_scans_have_the_objects_of_their_cast(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([*CAST, "--text", "a car ahead", "-o", "cast.npz"]) == 0
    assert cli.main(["observe", "cast.npz", "-o", "observed"]) == 0
    assert json.loads(Path("observed/casts.json").read_text()) == {"000000": "cast.npz"}
    assert cli.main(["export", "observed", "--format", "openpcdet", "-o", "out"]) == 0
    (car,) = Layout.load("cast.layout.json").boxes()
    found = Path("out/labels/000000.txt").read_text().split()
    seen = car.raised(-Sensor.load("small.json").mount_height)
    np.testing.assert_allclose(list(map(float, found[:3])), seen.center, atol=1e-4)
    assert found[7:] == ["car"]
    Path("cast.layout.json").unlink()
    assert cli.main(["observe", "cast.npz", "-o", "bare"]) == 0
    capsys.readouterr()
    assert cli.main(["export", "bare", "--format", "openpcdet", "-o", "none"]) == 0
    assert "none: no scan has a box; `observe` takes those of NAME.boxes.json or" in capsys.readouterr().err
    assert Path("none/labels/000000.txt").read_text() == ""
    image = RangeImage.load("observed/000000.npz")
    np.testing.assert_array_equal(np.load("out/points/000000.npy")[:, :3], image.points())


def test_bad_exports_are_one_line(refused: Callable[..., str], capsys: pytest.CaptureFixture[str]) -> None:
    Path("empty").mkdir()
    with pytest.raises(SystemExit):
        cli.main(["export", "empty", "--format", "kity", "-o", "out"])
    assert "'kity' is not one of kitti, " in capsys.readouterr().err
    said = refused("export", "empty", "--format", "kitti", "-o", "out")
    assert "empty holds no scans of `simulate`, `generate` or `observe`: no .sensor.json found" in said
    assert "nowhere is not a folder of scans" in refused("export", "nowhere", "--format", "kitti", "-o", "out")
    Sensor.load("small.json").save("empty/000000.sensor.json")
    assert "000000.npz: No such file" in refused("export", "empty", "--format", "kitti", "-o", "out")
    Path("full").mkdir()
    Path("full/notes.txt").write_text("mine")
    said = refused("export", "empty", "--format", "kitti", "-o", "full")
    assert "full exists already; write to a new or empty folder" in said
    assert "small.json/out cannot be written" in refused("export", "empty", "--format", "kitti", "-o", "small.json/out")


def test_a_library_that_is_missing_is_named(refused: Callable[..., str], monkeypatch: pytest.MonkeyPatch) -> None:
    assert cli.main([*DRAFT, "-o", "scans"]) == 0
    monkeypatch.setitem(sys.modules, "laspy", None)
    said = refused("export", "scans", "--format", "las", "-o", "out")
    assert "laspy is not installed; run: pip install 'lidardraft[export]'" in said
