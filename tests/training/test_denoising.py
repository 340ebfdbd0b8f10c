import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest
import torch
from box_pairs import SENSOR, make_pair, noted
from safetensors.torch import load_file

from lidardraft.diffusion.codec import DEPTH
from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.errors import TrainingError
from lidardraft.networks import weight_file
from lidardraft.training import denoising, recipes
from lidardraft.training.denoising import train_denoiser
from lidardraft.training.pairs import PairFolder, write_pairs

BASE = dataclasses.replace(recipes.tiny().base, crop=64, report_every=1, save_every=1000)
CONTROL = dataclasses.replace(recipes.tiny().control, crop=64, report_every=1, save_every=1000)


@pytest.fixture(scope="session")
def base(pairs: PairFolder, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Weights of a short first stage."""
    run = tmp_path_factory.mktemp("base")
    list(train_denoiser(BASE, pairs, run))
    return run / "weights.safetensors"


def test_the_loss_falls(pairs: PairFolder, tmp_path: Path) -> None:
    config = dataclasses.replace(BASE, steps=60, report_every=15, batch=8)
    reports = list(train_denoiser(config, pairs, tmp_path))
    assert [report.step for report in reports] == [15, 30, 45, 60]
    assert reports[-1].loss < 0.85 * reports[0].loss
    assert reports[-1].samples_per_second > 0
    log = [json.loads(line) for line in (tmp_path / "log.jsonl").read_text().splitlines()]
    assert [row["loss"] for row in log] == [report.loss for report in reports]
    assert weight_file.read_card(tmp_path / "weights.safetensors") == {
        "training": json.loads(json.dumps(dataclasses.asdict(config))),
        "step": 60,
        "data": pairs.source,
    }


def test_the_control_learns_and_the_base_stays(pairs: PairFolder, base: Path, tmp_path: Path) -> None:
    config = dataclasses.replace(CONTROL, steps=40, report_every=10, batch=8)
    reports = list(train_denoiser(config, pairs, tmp_path, base=weight_file.load(base, Denoiser)))
    assert reports[-1].loss < 0.85 * reports[0].loss
    before, after = load_file(base), load_file(tmp_path / "weights.safetensors")
    for name, weight in before.items():
        assert torch.equal(after[name], weight), name
    copied = {name: after[f"controlnet.{name.removeprefix('network.')}"] for name in before if "encoder" in name}
    assert any(not torch.equal(before[name], weight) for name, weight in copied.items())


def test_the_control_uses_the_condition(pairs: PairFolder, base: Path, tmp_path: Path) -> None:
    list(train_denoiser(dataclasses.replace(CONTROL, steps=20), pairs, tmp_path, base=weight_file.load(base, Denoiser)))
    denoiser = weight_file.load(tmp_path / "weights.safetensors", Denoiser)
    x, sigma, beams = torch.randn(1, 3, 16, 128), torch.ones(1), torch.zeros(2, 16)
    condition = torch.rand(1, 23, 16, 128)
    with torch.no_grad():
        denoised, mirrored, free = (
            denoiser.denoise(x, sigma, beams, given, wraps=True) for given in (condition, condition.flip(-1), None)
        )
    assert not torch.allclose(denoised, mirrored, atol=1e-4)
    assert not torch.allclose(denoised, free, atol=1e-4)


def test_at_first_only_the_zero_convolutions_learn(pairs: PairFolder, base: Path, tmp_path: Path) -> None:
    config = dataclasses.replace(CONTROL, steps=4, zero_conv_steps=4)
    list(train_denoiser(config, pairs, tmp_path, base=weight_file.load(base, Denoiser)))
    before, after = load_file(base), load_file(tmp_path / "weights.safetensors")
    for name in before:
        if name.startswith("network.encoder."):
            assert torch.equal(after[f"controlnet.{name.removeprefix('network.')}"], before[name]), name
    assert after["controlnet.leave.0.weight"].any()


@pytest.mark.parametrize("stage", ["base", "control"])
def test_a_run_in_slices_is_the_run_in_one(stage: str, pairs: PairFolder, base: Path, tmp_path: Path) -> None:
    config = dataclasses.replace(BASE if stage == "base" else CONTROL, steps=8, save_every=3)

    def denoiser() -> Denoiser | None:
        return None if stage == "base" else weight_file.load(base, Denoiser)

    whole = list(train_denoiser(config, pairs, tmp_path / "whole", base=denoiser()))
    first = []
    for report in train_denoiser(config, pairs, tmp_path / "sliced", base=denoiser()):
        first.append(report)
        if report.step == 5:  # interrupted two steps after the state was saved
            break
    rest = list(train_denoiser(config, pairs, tmp_path / "sliced", base=denoiser()))
    assert [report.step for report in rest] == [4, 5, 6, 7, 8]
    assert [report.loss for report in first[:3] + rest] == [report.loss for report in whole]
    one, other = (load_file(tmp_path / run / "weights.safetensors") for run in ("whole", "sliced"))
    assert all(torch.equal(one[name], other[name]) for name in one)
    assert list(train_denoiser(config, pairs, tmp_path / "sliced", base=denoiser())) == []


def test_a_control_does_not_go_on_with_another_base(pairs: PairFolder, base: Path, tmp_path: Path) -> None:
    list(train_denoiser(dataclasses.replace(CONTROL, steps=1), pairs, tmp_path, base=weight_file.load(base, Denoiser)))
    other = weight_file.load(base, Denoiser)
    with torch.no_grad():
        other.network.head.bias += 0.1
    with pytest.raises(TrainingError, match="is the state of a run with another base"):
        list(train_denoiser(CONTROL, pairs, tmp_path, base=other))


def test_zero_convolutions_that_stay_zero_are_reported(pairs: PairFolder, base: Path, tmp_path: Path) -> None:
    # A learning rate of 0 is the simplest way to a ControlNet that adds nothing.
    silent = dataclasses.replace(CONTROL, steps=20, batch=1, learning_rate=0.0)
    with pytest.raises(TrainingError, match="zero convolution 'enter' is still zero after 20 steps"):
        list(train_denoiser(silent, pairs, tmp_path, base=weight_file.load(base, Denoiser)))


def test_a_loss_that_is_not_finite_stops_the_run(pairs: PairFolder, tmp_path: Path) -> None:
    with pytest.raises(TrainingError, match=r"the loss is \S+ and its gradient nan at step"):
        list(train_denoiser(dataclasses.replace(BASE, learning_rate=1e30, warmup=0), pairs, tmp_path))
    assert not (tmp_path / "weights.safetensors").exists()


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"steps": 0}, "steps is 0; it must be at least 1"),
        ({"batch": 0}, "batch is 0; it must be at least 1"),
        ({"crop": 256}, "crop is 256; it must be 1 to 128, the columns of small"),
        ({"crop": 0}, "crop is 0; it must be 1 to 128"),
        ({"crop": 66}, "16 rows and crops of 66 columns must be whole cells of 2 x 4"),
    ],
)
def test_a_config_that_cannot_be_trained_is_refused(
    fields: dict[str, int], message: str, pairs: PairFolder, tmp_path: Path
) -> None:
    with pytest.raises(TrainingError, match=message):
        next(train_denoiser(dataclasses.replace(BASE, **fields), pairs, tmp_path / "run"))
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize(
    ("span", "crop", "wraps"), [(2 * np.pi, 128, True), (2 * np.pi, 64, False), (2.0, 128, False), (2.0, 64, False)]
)
def test_only_a_full_turn_is_trained_as_a_ring(
    span: float, crop: int, wraps: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sensor = dataclasses.replace(SENSOR, azimuth_start=span / 2, azimuth_span=span)
    list(write_pairs(tmp_path / "pairs", [noted(0, sensor)]))
    told, loss = [], Denoiser.loss

    def noticed(denoiser: Denoiser, *batch: torch.Tensor, wraps: bool) -> torch.Tensor:
        told.append(wraps)
        return loss(denoiser, *batch, wraps=wraps)

    monkeypatch.setattr(Denoiser, "loss", noticed)
    config = dataclasses.replace(BASE, steps=2, crop=crop)
    list(train_denoiser(config, PairFolder(tmp_path / "pairs"), tmp_path / "run"))
    assert told == [wraps] * 2


@pytest.mark.parametrize("span", [2 * np.pi, 2.0])
def test_a_crop_of_a_sector_does_not_go_around_its_end(span: float, tmp_path: Path) -> None:
    sensor = dataclasses.replace(SENSOR, azimuth_start=span / 2, azimuth_span=span)
    scan, condition_image = make_pair(0, sensor)
    ramp = np.broadcast_to(np.linspace(5, 50, 128, dtype=np.float32), sensor.shape)  # falls only at the seam
    scan = dataclasses.replace(scan, depth=ramp, intensity=None)
    list(write_pairs(tmp_path, [(scan, condition_image, {})]))
    config = dataclasses.replace(BASE, crop=96, batch=32)
    clean, *_ = denoising._batch(config, PairFolder(tmp_path), 0, conditional=False)
    torn = [len(row.diff().sign().unique()) > 1 for row in clean[:, DEPTH, 0]]
    assert any(torn) == (span > 6)


def test_a_base_of_another_shape_is_refused(pairs: PairFolder, tmp_path: Path) -> None:
    other = Denoiser.from_config(dataclasses.replace(BASE.denoiser, blocks=2))
    with pytest.raises(TrainingError, match=r"the base is a DenoiserConfig\(.*blocks=2.*needs a .*blocks=1"):
        next(train_denoiser(CONTROL, pairs, tmp_path, base=other))
