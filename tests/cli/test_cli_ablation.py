"""`lidardraft-train ablation`, from nothing to the table."""

import re
from pathlib import Path

import pytest
import torch

from lidardraft.cli import train
from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.networks import weight_file
from lidardraft.training.ablation import ARMS

ARGV = ["ablation", "--sensor", "small.json", "--base-steps", "2", "--steps", "2", "-n", "1", "--work", "work"]


def test_the_table_has_a_row_for_each_arm(capsys: pytest.CaptureFixture[str]) -> None:
    assert train.main(ARGV) == 0
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


def test_what_cannot_be_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert train.main([*ARGV, "--device", "abacus"]) == 2
    assert "device is 'abacus'" in capsys.readouterr().err
    Path("work").write_text("")
    assert train.main(ARGV) == 2
    assert "work is a file; it must be a folder" in capsys.readouterr().err
