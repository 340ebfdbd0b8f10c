"""Arms of the generator learn and are scored, all by the same rules."""

import itertools
import math
import sys
from dataclasses import replace

import pytest
import torch
from torch import nn

import generator_arms
import rival_r2dm
from generator_arms import ARMS, CONFIG, OURS, Arm, learned, rows_of
from lidardraft.diffusion import denoiser as denoiser_module
from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.evaluation import unseen_streets
from lidardraft.formats.pairs import Pair, write_pairs
from lidardraft.scene.sensor import Sensor
from lidardraft.training import denoising
from lidardraft.training.pairs import PairFolder
from lidardraft.training.processes import ALONE

SENSOR = Sensor(name="small", elevations=tuple(math.radians(2 - 0.8 * row) for row in range(32)), columns=256)


@pytest.fixture(scope="module")
def pairs(tmp_path_factory: pytest.TempPathFactory) -> PairFolder:
    path = tmp_path_factory.mktemp("pairs")
    found = unseen_streets(2, sensor=SENSOR, seed=5)
    assert list(write_pairs(path, [(Pair(p.scan, p.condition_image, p.simulated), {}) for p in found])) == [2]
    return PairFolder(path)


@pytest.fixture(autouse=True)
def narrow(monkeypatch: pytest.MonkeyPatch) -> None:
    """Networks an eighth as wide, so that steps are quick."""
    monkeypatch.setattr(generator_arms, "OURS", replace(OURS, widths=(8, 16, 16, 16)))


def loss(network: nn.Module, pairs: PairFolder) -> float:
    """The mean loss of a batch that no arm begins with."""
    clean, sigma, noise, rays, condition, *_ = denoising._batch(CONFIG, pairs, ALONE, 999)
    with torch.inference_mode():
        return network.loss(clean, sigma, noise, rays, condition, wraps=True).mean().item()


@pytest.mark.parametrize("arm", [ARMS["ours"], ARMS["AdamW in place of Muon"], rival_r2dm.r2dm_arm(16, (2, 4))])
def test_steps_are_those_of_the_time_and_the_loss_falls(arm: Arm, pairs: PairFolder) -> None:
    network, steps = learned(arm, pairs, 25, itertools.count().__next__)
    assert steps == 25
    torch.manual_seed(0)
    assert loss(network, pairs) < 0.98 * loss(arm.stages[0](None).eval(), pairs)


def test_an_arm_has_its_own_optimiser_levels_and_rate_which_is_gone_as_the_time_is_over(
    pairs: PairFolder, monkeypatch: pytest.MonkeyPatch
) -> None:
    rates, levels = [], []

    def step(learner: generator_arms.Learner, number: int, _: torch.Tensor) -> None:
        assert isinstance(learner.optimiser, torch.optim.AdamW)
        rates.append(learner.config.rate(number))

    def doubled(sigma: torch.Tensor) -> torch.Tensor:
        levels.append(2 * sigma)
        return levels[-1]

    def given(_: Denoiser, clean: torch.Tensor, sigma: torch.Tensor, *__: object, **___: object) -> torch.Tensor:
        assert sigma is levels[-1]
        return clean.sum(dim=(1, 2, 3))

    monkeypatch.setattr(generator_arms.Learner, "step", step)
    monkeypatch.setattr(Denoiser, "loss", given)
    learned(replace(ARMS["AdamW in place of Muon"], levels=doubled), pairs, 60, itertools.count().__next__)
    assert len(levels) == len(rates) == 60
    assert rates[0] == pytest.approx(generator_arms.ADAM_RATE / CONFIG.warmup)
    assert max(rates) == generator_arms.ADAM_RATE
    assert rates[-1] == pytest.approx(generator_arms.ADAM_RATE / (CONFIG.decay * 60))


def test_a_frozen_base_has_learned_before_and_stays(pairs: PairFolder) -> None:
    arm = ARMS["ControlNet on a frozen base"]
    network, steps = learned(arm, pairs, 8, itertools.count().__next__)
    assert isinstance(network, Denoiser)
    assert network.controlnet is not None
    assert steps == 8
    torch.manual_seed(0)
    base, _ = generator_arms._learned(arm.stages[0](None), arm, pairs, 4, itertools.count().__next__)
    assert torch.equal(base.network.head.weight, network.network.head.weight)
    assert base.network.head.weight.any()  # which begins at zero
    assert all(not weight.requires_grad for weight in network.network.parameters())
    assert all(conv.weight.any() for _, conv in network.controlnet.zero_convs())


def test_the_noise_level_at_which_it_turns_is_that_of_the_arm(
    pairs: PairFolder, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen = []

    def row(*_: object) -> dict[str, float]:
        seen.append(denoiser_module.SIGMA_TURN)
        return {}

    monkeypatch.setattr(generator_arms, "_row", row)
    list(rows_of({name: ARMS[name] for name in ("sigma turn 0.5 (Karras)", "ours")}, pairs, 1e-9, 1))
    assert seen == [0.5, 0.1, 0.1]


def test_the_command_prints_the_table(
    pairs: PairFolder, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    argv = ["rival_r2dm.py", "--pairs", str(pairs.path), "--seconds", "0.05", "-n", "2", "--only", "16 wide"]
    monkeypatch.setattr(sys, "argv", argv)
    monkeypatch.setattr(generator_arms, "STEPS", 2)
    generator_arms.compare(rival_r2dm.RIVALS, rival_r2dm.__doc__)
    shown = capsys.readouterr().out
    header, _, rival, untrained, image = shown.splitlines()[-5:]
    columns = ("million weights", "GFLOP a call", "steps", "objects", "other", "heeded", "range", "BEV", "lone %")
    assert header == f"| | {' | '.join(columns)} |"
    assert rival.startswith("| R2DM, 16 wide | 1.79 | ")
    assert rival.split(" | ")[6] == "-"  # it has no loss like ours
    assert untrained.startswith("| ours, untrained | ")
    assert float(untrained.split(" | ")[6]) > 0
    assert image.split(" | ")[4] == "1"  # it agrees with itself
