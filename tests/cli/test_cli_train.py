"""`lidardraft-train segmenter` and `ablation`, from pairs to weights and to the table."""

import re
from pathlib import Path

import numpy as np
import pytest
import torch

from lidardraft.cli import train
from lidardraft.cli.train import _show
from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.formats.pairs import Pair, write_pairs
from lidardraft.networks import weight_file
from lidardraft.perception.segmenter import Segmenter
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.raycast import raycast
from lidardraft.scene.sensor import Sensor
from lidardraft.training.ablation import ARMS
from lidardraft.training.loop import Report

ABLATION = ["ablation", "--sensor", "small.json", "--base-steps", "2", "--steps", "2", "-n", "1", "--work", "work"]


def test_pairs_become_a_segmenter(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    sensor = Sensor(name="small", elevations=tuple(np.linspace(0.03, -0.4, 16).tolist()), columns=64)
    road = Primitive(shape="plane", center=(0, 0, 0), size=(60, 60, 0), label="road", id="road")
    image = raycast(Layout(primitives=(road,)), sensor)
    list(write_pairs(tmp_path / "pairs", [(Pair(image, image, image), {})]))
    argv = ["segmenter", "--pairs", str(tmp_path / "pairs"), "--batch", "1", "-o", str(tmp_path / "run")]
    assert train.main([*argv, "--steps", "2", "--minutes", "1e-9"]) == 0
    assert train.main([*argv, "--steps", "2"]) == 0
    assert "2/2" in capsys.readouterr().err
    label = weight_file.load(tmp_path / "run" / "weights.safetensors", Segmenter).label(image)
    np.testing.assert_array_equal(label > 0, image.valid)
    assert train.main([*argv, "--steps", "2", "--seed", "1"]) == 2
    assert "another config: its seed is 0, not 1" in capsys.readouterr().err


@pytest.mark.parametrize("run", ["m.obj", "m.obj/run"])
def test_a_file_in_the_place_of_the_run_is_refused_before_the_pairs_are_read(
    run: str, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("m.obj").touch()
    assert train.main(["segmenter", "--pairs", "none", "-o", run]) == 2
    assert capsys.readouterr().err == "lidardraft-train: m.obj is a file; it must be a folder\n"


def test_the_table_has_a_row_for_each_arm(capsys: pytest.CaptureFixture[str]) -> None:
    assert train.main(ABLATION) == 0
    shown = capsys.readouterr().out
    assert shown.startswith("1 street, small; base 2 steps, each arm 2\n")
    number = r" +(?:\d+\.\d{3}|nan)"
    rows = re.findall(rf"^(\S.*?){number}{number} +\d\.\d{{3}} +\d+\.\d{{3}} +\d\.\d{{3}}$", shown, re.MULTILINE)
    assert rows == ["other streets", "no condition", *ARMS]
    base = weight_file.load("work/base/weights.safetensors", Denoiser)
    steps = {}
    for run in Path("work").iterdir():
        arm = weight_file.load(run / "weights.safetensors", Denoiser)
        steps[run.name] = weight_file.read_card(run / "weights.safetensors")["step"]
        if arm.controlnet is not None:
            pairs = zip(arm.network.parameters(), base.network.parameters(), strict=True)
            assert all(torch.equal(one, other) for one, other in pairs)
    assert steps.pop("condition-concatenated") == 4
    assert steps == dict.fromkeys(steps, 2)
    assert len(steps) == len(ARMS)
    assert weight_file.read_card("work/top-view-not-cast/weights.safetensors")["data"].endswith("from above")


def test_an_ablation_that_cannot_be_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert train.main([*ABLATION, "--device", "abacus"]) == 2
    assert "device is 'abacus'" in capsys.readouterr().err
    Path("work").write_text("")
    assert train.main(ABLATION) == 2
    assert "work is a file; it must be a folder" in capsys.readouterr().err


def test_the_bar_shows_the_last_report(capsys: pytest.CaptureFixture[str]) -> None:
    reports = [
        Report(step=step, loss=1 / step, gradient=0.0, measures={}, samples_per_second=3.0, minutes=0.0)
        for step in (2, 4)
    ]
    assert _show(iter(reports), 4, "stage") == 4
    shown = capsys.readouterr().err
    assert "stage: 100%" in shown
    assert "loss 0.250, 3.0 samples/s" in shown
    assert _show(iter([]), 4, "stage") is None
