"""The examples, run as a user runs them."""

import json
import os
import re
import runpy
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from lidardraft import Layout
from lidardraft.formats import kitti, semantickitti

EXAMPLES = Path(__file__).parents[2] / "examples"
DATA = os.environ.get("LIDARDRAFT_DATA", "")


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Callable[..., str]:
    def said(name: str, *argv: str) -> str:
        monkeypatch.setattr(sys, "argv", [name, *argv])
        runpy.run_path(str(EXAMPLES / name), run_name="__main__")
        return capsys.readouterr().out

    return said


def test_demo(run: Callable[..., str], tmp_path: Path) -> None:
    assert "labelled" in run("demo.py", "-o", str(tmp_path))
    scans = {f"{name}{ending}" for name in ("simulated", "generated") for ending in (".bin", ".label")}
    assert {path.name for path in tmp_path.iterdir()} == scans | {
        "layout.json",
        "condition.png",
        "boxes.json",
        "preview.png",
    }
    objects = {box.instance for box in Layout.load(tmp_path / "layout.json").boxes()}
    for name, least in (("simulated", 1.0), ("generated", 0.7)):
        points, _ = kitti.read_bin(tmp_path / f"{name}.bin")
        label, instance = semantickitti.read_label(tmp_path / f"{name}.label", len(points))
        assert len(points) > 30_000
        assert (label > 0).mean() >= least
        assert set(instance.tolist()) - {0} <= objects
    boxes = json.loads((tmp_path / "boxes.json").read_text())
    assert boxes["frame"] == "sensor"
    assert max(box["num_points"] for box in boxes["boxes"]) > 50


def test_planner(run: Callable[..., str]) -> None:
    said = run("planner.py")
    gap, speed = (float(said.split(word)[0].rsplit(maxsplit=1)[-1]) for word in (" m between", " m/s"))
    assert 5.5 < gap < 9.0  # of two cars that stand, one behind the other
    assert speed == 0.0
    assert said.strip().endswith("collisions: ()")


def test_own_renderer(run: Callable[..., str]) -> None:
    lines = run("own_renderer.py", "--seconds", "0.5").splitlines()
    assert [line.split(":")[0] for line in lines] == [f"0.{k} s" for k in range(1, 6)]
    for line in lines:
        assert int(re.search(r"(\d+)% within", line)[1]) >= 99
        assert "'car_1': 1" in line  # more than a hundred


@pytest.mark.skipif(
    not Path(DATA, "kitti/odometry_00").is_dir() or not DATA, reason="LIDARDRAFT_DATA has no recordings"
)
def test_cloud_to_scan(run: Callable[..., str], tmp_path: Path) -> None:
    scan = Path(DATA, "kitti/odometry_00")
    argv = [str(scan / "velodyne/000000.bin"), str(scan / "labels/000000.label"), "-o", str(tmp_path)]
    assert "simulated scan" in run("cloud_to_scan.py", *argv)
    assert (tmp_path / "comparison.png").stat().st_size > 10_000
