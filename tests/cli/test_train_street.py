"""`lidardraft-train street`, from nothing to a weight file."""

import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
import torch

from lidardraft import evaluation
from lidardraft.cli import main as cli
from lidardraft.cli import train
from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.networks import weight_file
from lidardraft.pipeline import Pipeline
from lidardraft.scene.sensor import Sensor
from lidardraft.streets import StreetPair

ARGV = ["street", "--recipe", "tiny", "--num", "2", "--sensor", "hdl32e", "--work", "work", "-o", "tiny.safetensors"]
SHORT = ["--base-steps", "2", "--control-steps", "2", "--evaluate", "1"]


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An empty working directory with a small sensor."""
    monkeypatch.chdir(tmp_path)
    sensor = Sensor(name="small", elevations=tuple(np.deg2rad(np.linspace(2, -24, 16)).tolist()), columns=128)
    Path("small.json").write_text(sensor.to_json())


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (["--device", "nonsense"], "device is 'nonsense'"),
        (["--sensor", "small.json"], "crop is 256; it must be 1 to 128, the columns of small"),
        (["-o", "."], ". is a folder; the weights are a file"),
        (["--work", "small.json"], "small.json is a file; it must be a folder"),
    ],
)
def test_what_cannot_be_is_refused_before_any_work(
    wrong: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert train.main([*ARGV, *SHORT, *wrong]) == 2
    assert message in capsys.readouterr().err
    assert not Path("work").exists()


def test_what_ships_is_scored_on_the_device_that_was_asked_for(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    devices: list[str] = []
    scored: list[dict[str, torch.Tensor]] = []
    from_pretrained, evaluate = Pipeline.from_pretrained, evaluation.evaluate

    def on_a_device(name: Path, *, device: str = "cpu", steps: int = 20) -> Pipeline:
        devices.append(device)
        return from_pretrained(name, device=device, steps=steps)

    def scores(
        pipeline: Pipeline, pairs: list[StreetPair], *, on_scan: Callable[[], object]
    ) -> Iterator[evaluation.Scores]:
        scored.append(pipeline.denoiser.state_dict())
        return evaluate(pipeline, pairs, on_scan=on_scan)

    with monkeypatch.context() as noticed:
        noticed.setattr(Pipeline, "from_pretrained", on_a_device)
        noticed.setattr(evaluation, "evaluate", scores)
        noticed.setattr(sys.stderr, "isatty", lambda: True)
        assert train.main([*ARGV, *SHORT, "--device", "cpu:0"]) == 0
    assert devices == ["cpu:0"]
    shown = capsys.readouterr().err
    assert "making streets:" in shown
    assert "generating:" in shown
    shipped = weight_file.load("tiny.safetensors", Denoiser).state_dict()
    assert all(torch.equal(scored[0][name], weight) for name, weight in shipped.items())

    card = weight_file.read_card("tiny.safetensors")
    assert card["control"]["step"] == 2
    assert card["sensors"] == ["hdl32e"]
    names = [scores["name"] for scores in card["scores"]]
    assert names == ["detailed scan", "condition image", "generated", "random weights"]
    assert train.main([*ARGV, "--seed", "5"]) == 2  # the folder holds pairs of another seed
    assert "seed 0" in capsys.readouterr().err
    generate = ["generate", "--text", "a car ahead", "--sensor", "small.json", "--steps", "2"]
    assert cli.main([*generate, "--weights", "tiny.safetensors", "-o", "out"]) == 0
