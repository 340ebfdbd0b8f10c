"""Arms of the generator learn and are scored, all by the same rules."""

import itertools
import math
import sys
from pathlib import Path

import pytest
import torch

import generator_arms
import rival_r2dm
from generator_arms import ARMS, SMALL, learned, rows_of
from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.evaluation import unseen_streets
from lidardraft.scene.sensor import Sensor
from lidardraft.training.pairs import Pair, PairFolder, write_pairs

SENSOR = Sensor(name="small", elevations=tuple(math.radians(2 - 1.7 * row) for row in range(16)), columns=128)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("pairs")
    pairs = unseen_streets(2, sensor=SENSOR, seed=5)
    assert list(write_pairs(path, [(Pair(p.scan, p.condition_image, p.simulated), {}) for p in pairs])) == [2]
    return path


def test_a_frozen_base_has_learned_before_and_stays(folder: Path) -> None:
    arm = ARMS["ControlNet on a frozen base"]
    network, steps = learned(arm, PairFolder(folder), 8, itertools.count().__next__)
    assert isinstance(network, Denoiser)
    assert network.controlnet is not None
    assert network.config.controlnet
    assert steps == 8
    torch.manual_seed(0)
    fresh = arm.make()
    assert not torch.equal(fresh.network.head.weight, network.network.head.weight)
    assert all(not weight.requires_grad for weight in network.network.parameters())
    assert all(conv.weight.any() for _, conv in network.controlnet.zero_convs())


def test_steps_are_those_of_the_time_and_the_loss_falls(folder: Path) -> None:
    pairs = PairFolder(folder)
    clean, condition = generator_arms._batch(pairs, 0)
    arm, sigma = ARMS["concatenated"], torch.full((4,), 0.3)
    noisy = clean + 0.3 * torch.randn(clean.shape, generator=torch.Generator().manual_seed(1))
    rays = torch.from_numpy(generator_arms.encode_rays(SENSOR))

    def loss(network: Denoiser) -> float:
        with torch.inference_mode():
            denoised = network.denoise(noisy, sigma, rays, condition, wraps=True)
            return arm.loss(denoised, clean, sigma, condition).mean().item()

    torch.manual_seed(0)
    network, steps = learned(arm, pairs, 12, itertools.count().__next__)
    assert steps == 12
    assert loss(network) < 0.9 * loss(arm.make().eval())


def test_every_arm_but_one_changes_something_of_the_first() -> None:
    first = ARMS["concatenated"]
    assert first.make().config == SMALL
    for name, arm in ARMS.items():
        config = arm.frozen or arm.make().config
        assert (config != SMALL or arm.loss is not first.loss) == (arm is not first), name
        assert ("no copy gate" in name) == (not config.copy_gate)
        assert ("ControlNet" in name) == config.controlnet


def test_rows_stand_beside_that_of_the_simulated_scans(folder: Path) -> None:
    rows = dict(rows_of({"ours": ARMS["concatenated"]}, PairFolder(folder), 0.1, 2))
    assert list(rows) == ["simulated scan", "ours; noise, 20 calls", "ours; 0.5, 4 calls"]
    assert set(generator_arms.COLUMNS) <= set(rows["ours; noise, 20 calls"])
    assert rows["ours; noise, 20 calls"]["million weights"] == pytest.approx(0.935, abs=0.001)


def test_the_command_prints_the_table(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    argv = ["rival_r2dm.py", "--pairs", str(folder), "--seconds", "0.05", "-n", "2", "--only", "16 wide"]
    monkeypatch.setattr(sys, "argv", argv)
    generator_arms.compare(rival_r2dm.RIVALS, rival_r2dm.__doc__)
    shown = capsys.readouterr().out
    assert "| R2DM, 16 wide; noise, 20 calls |" in shown
    assert "ours" not in shown
