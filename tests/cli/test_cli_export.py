"""`lidardraft export`: folders of scans as other people's data sets."""

import os
import shutil
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from lidardraft import Layout, RangeImage, Scan, Sensor
from lidardraft.cli import main as cli
from lidardraft.formats.frame import FORMATS

TEXT = "a car 10 m ahead and a bus behind"
DRAFT = ["simulate", "--surroundings", "bare", "--text", TEXT, "--sensor", "small.json", "--no-picture"]


def files(folder: str) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in Path(folder).rglob("*") if path.is_file()}


def test_every_format_by_a_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main([*DRAFT, "--speed", "5", "-n", "2", "-o", "scans"]) == 0
    for name in FORMATS:
        assert cli.main(["export", "scans", "scans", "--format", name, "-o", f"sets/{name}"]) == 0
        assert capsys.readouterr().out.endswith(f"sets/{name}: 4 scans as {name}\n")
        assert cli.main(["export", "scans", "scans", "--format", name, "-o", "again"]) == 0
        if name != "mcap":
            assert files("again") == files(f"sets/{name}")
        shutil.rmtree("again")
    assert sorted(os.listdir("sets")) == sorted(FORMATS)


def test_a_saved_scan_is_loaded_as_it_was() -> None:
    assert cli.main([*DRAFT, "--speed", "5", "-o", "scans"]) == 0
    scan = Scan.load("scans/000000")
    assert scan.speed == 5.0
    np.testing.assert_array_equal(
        scan.points().ravel(), np.fromfile("scans/000000.bin", "<f4").reshape(-1, 4)[:, :3].ravel()
    )
    assert scan.layout == Layout.load("scans/000000.layout.json")
    assert len(scan.frame().annotations) == 2


def test_what_is_exported_is_read_as_an_input() -> None:
    assert cli.main([*DRAFT, "-o", "scans"]) == 0
    for name in ("kitti", "pcd", "ply"):
        assert cli.main(["export", "scans", "--format", name, "-o", name]) == 0
    labels = "kitti/training/label_2/000000.txt"
    draft = ["draft", "--surroundings", "bare", "--boxes", labels, "--sensor", "small.json", "--no-preview"]
    assert cli.main([*draft, "-o", "a.json"]) == 0
    layout, seen = Layout.load("scans/000000.layout.json"), Scan.load("scans/000000").frame().seen()
    boxes = [next(box for box in layout.boxes() if box.id == each.box.id) for each in seen]
    for found, box in zip(Layout.load("a.json").boxes(), boxes, strict=True):
        np.testing.assert_allclose(found.corners(), box.corners(), atol=0.01)
    for file in ("pcd/000000.pcd", "ply/000000.ply"):
        assert cli.main(["draft", "--points", file, "-o", "b.json", "--no-preview"]) == 0
        assert {"car", "bus"} <= {primitive.label for primitive in Layout.load("b.json").primitives}


def test_observed_scans_have_no_boxes() -> None:
    assert cli.main(["raycast", "--text", "a car ahead", "--sensor", "small.json", "-o", "cast.npz"]) == 0
    assert cli.main(["observe", "cast.npz", "-o", "observed"]) == 0
    assert cli.main(["export", "observed", "--format", "openpcdet", "-o", "out"]) == 0
    assert Path("out/labels/000000.txt").read_text() == ""
    image = RangeImage.load("observed/000000.npz")
    np.testing.assert_array_equal(np.load("out/points/000000.npy")[:, :3], image.points())


def test_bad_exports_are_one_line(refused: Callable[..., str], capsys: pytest.CaptureFixture[str]) -> None:
    Path("empty").mkdir()
    with pytest.raises(SystemExit):
        cli.main(["export", "empty", "--format", "kity", "-o", "out"])
    assert "'kity' is not one of kitti, " in capsys.readouterr().err
    said = refused("export", "empty", "--format", "kitti", "-o", "out")
    assert "empty holds no scans of `simulate`, `generate` or `observe`: there is no .sensor.json" in said
    assert "nowhere is not a folder of scans" in refused("export", "nowhere", "--format", "kitti", "-o", "out")
    Sensor.load("small.json").save("empty/000000.sensor.json")
    assert "000000.npz: No such file" in refused("export", "empty", "--format", "kitti", "-o", "out")
    Path("full").mkdir()
    Path("full/notes.txt").write_text("mine")
    said = refused("export", "empty", "--format", "kitti", "-o", "full")
    assert "full is there already; write to a new or empty folder" in said
    assert "small.json/out cannot be written" in refused("export", "empty", "--format", "kitti", "-o", "small.json/out")


@pytest.mark.parametrize(("name", "library"), [("las", "laspy"), ("mcap", "foxglove")])
def test_a_library_that_is_missing_is_named(
    name: str, library: str, refused: Callable[..., str], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert cli.main([*DRAFT, "-o", "scans"]) == 0
    monkeypatch.setitem(sys.modules, library, None)
    said = refused("export", "scans", "--format", name, "-o", "out")
    assert f"{library} is not installed; run: pip install 'lidardraft[export]'" in said
