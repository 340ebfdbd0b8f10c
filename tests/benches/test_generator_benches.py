"""The report of generated scans: seeds beside streets, scores beside what is passed through, recordings."""

import dataclasses
import math
from pathlib import Path

import pytest
import torch

import report_generate
from cases import street_set
from generated_streets import compare_seeds
from lidardraft import Pipeline
from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.networks import weight_file
from lidardraft.scene.sensor import Sensor
from lidardraft.training import recipes

GRID = Sensor(name="small", elevations=tuple(math.radians(2 - 1.7 * row) for row in range(16)), columns=128)


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
