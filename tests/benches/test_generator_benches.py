"""Arms of the generator and a rival learn and are scored by the same rules; the report of generated scans."""

import dataclasses
import itertools
import math
from dataclasses import replace
from pathlib import Path

import pytest
import torch

import generator_arms
import report_generate
from cases import street_set
from generated_streets import compare_seeds
from generator_arms import ARMS, OURS, learned
from lidardraft import Pipeline
from lidardraft.diffusion.codec import CONDITION_CHANNELS, STATE_CHANNELS, encode_rays
from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.evaluation import unseen_streets
from lidardraft.formats.pairs import Pair, write_pairs
from lidardraft.networks import weight_file
from lidardraft.scene.sensor import Sensor
from lidardraft.training import recipes
from lidardraft.training.sources import PairFolder
from rival_r2dm import R2DM

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


GRID = Sensor(name="small", elevations=tuple(math.radians(2 - 1.7 * row) for row in range(16)), columns=128)
RAYS = torch.from_numpy(encode_rays(GRID))
CONDITION = torch.zeros(1, CONDITION_CHANNELS, 16, 128)


def test_the_right_v_is_the_clean_state() -> None:
    clean, noise = torch.randn(2, 1, STATE_CHANNELS, 16, 128)
    sigma = torch.tensor([0.7])
    alpha = (1 + sigma**2).rsqrt()

    class Knowing(R2DM):
        def forward(self, x: torch.Tensor, log_snr: torch.Tensor, wraps: bool) -> torch.Tensor:
            assert wraps
            assert torch.allclose(x[:, :STATE_CHANNELS], alpha * (clean + sigma * noise))
            assert torch.allclose(log_snr, torch.log(alpha**2 / (alpha * sigma) ** 2))
            return alpha * noise - alpha * sigma * clean

    found = Knowing(16).denoise(clean + sigma * noise, sigma, RAYS, CONDITION, wraps=True)
    assert torch.allclose(found, clean, atol=1e-5)


@pytest.fixture(scope="module")
def completing() -> Pipeline:
    torch.manual_seed(0)
    return Pipeline(Denoiser.from_config(recipes.tiny()[-1].denoiser), steps=1)


@pytest.fixture(scope="module")
def whole() -> Pipeline:
    torch.manual_seed(0)
    config = dataclasses.replace(recipes.tiny()[-1].denoiser, condition=("depth", "class"))
    return Pipeline(Denoiser.from_config(config), steps=1)


def printed(
    pipeline: Pipeline, part: str, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> str:
    """What the command prints of one part."""
    weight_file.save(pipeline.denoiser, folder / "weights.safetensors", {})
    (folder / "small.json").write_text(GRID.to_json())
    options = ["-n", "2", "--weights", str(folder / "weights.safetensors"), "--steps", "1", "--data", str(folder)]
    argv = ["report_generate.py", *options, "--only", part, "--sensor", str(folder / "small.json")]
    monkeypatch.setattr("sys.argv", argv)
    report_generate.main()
    return capsys.readouterr().out


def test_seeds_of_one_street_are_held_against_as_many_streets(
    completing: Pipeline, monkeypatch: pytest.MonkeyPatch
) -> None:
    text, goal = compare_seeds(completing, GRID, 2)
    cells = [line.split(" | ") for line in text.splitlines() if line.startswith("| ")][1:]
    found = {name.strip("| "): float(value.strip("| ")) for name, value in cells}
    assert list(found) == ["other streets", "simulated", "generated", "untrained"]
    assert found["generated"] > 0
    assert 0 < found["simulated"] < 0.8 * found["other streets"]  # one layout, eight units of the sensor
    assert goal.values["BEV"] == pytest.approx(found["generated"] / found["other streets"], rel=0.01)
    monkeypatch.setattr(Pipeline, "generate", lambda _, __, simulated, *___, **____: simulated)
    _, goal = compare_seeds(completing, GRID, 2)
    assert goal.values == {"BEV": 0.0}  # eight times the same scan


@pytest.mark.parametrize(("kind", "passed_through"), [("completing", "bare"), ("whole", "condition image")])
def test_streets_are_scored_beside_what_is_passed_through(
    kind: str,
    passed_through: str,
    request: pytest.FixtureRequest,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    out = printed(request.getfixturevalue(kind), "streets", tmp_path, monkeypatch, capsys)
    names = [line.split(" | ")[0].strip("| ") for line in out.splitlines() if line.startswith("| ")]
    assert names[1:7] == ["detailed scan", "other streets", passed_through, "simulated", "generated", "untrained"]
    assert ("half of each open" in out) == (kind == "completing") == ("generated / bare | <= 0.5" in out)
    assert ("own layout | >= 0.5" in out) == (kind == "whole")
    assert "recordings" not in out


def test_whole_scans_alone_are_held_against_recordings(
    completing: Pipeline,
    whole: Pipeline,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(report_generate, "recorded_sets", lambda _: [("small", lambda: street_set(3, GRID))])
    said = "The layouts of recordings leave nothing open: these weights add nothing to the simulated scans.\n\n"
    assert printed(completing, "recordings", tmp_path, monkeypatch, capsys) == said
    out = printed(whole, "recordings", tmp_path, monkeypatch, capsys)
    assert "### small, 2 scans" in out
    assert "| cast | + sensor model | simulated | generated | untrained |" in out
    assert "| range (JSD) |" in out
