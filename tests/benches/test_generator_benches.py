"""The reports of generated scans: beside what is passed through, recordings, and procedural streets."""

import math
from pathlib import Path

import pytest
import torch

import pictures
import report_generate
from cases import street_set
from lidardraft import Pipeline
from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.networks import weight_file
from lidardraft.scene.sensor import Sensor
from lidardraft.training import recipes

GRID = Sensor(name="small", elevations=tuple(math.radians(2 - 1.7 * row) for row in range(16)), columns=128)


@pytest.fixture(scope="module")
def whole() -> Pipeline:
    torch.manual_seed(0)
    return Pipeline(Denoiser.from_config(recipes.tiny()[-1].denoiser), steps=1)


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


def test_streets_are_scored_beside_what_is_passed_through(
    whole: Pipeline, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    out = printed(whole, "streets", tmp_path, monkeypatch, capsys)
    names = [line.split(" | ")[0].strip("| ") for line in out.splitlines() if line.startswith("| ")]
    assert names[1:7] == ["detailed scan", "other streets", "condition image", "simulated", "generated", "untrained"]
    assert "own layout | >= 0.66" in out
    assert "recordings" not in out


def test_scans_are_held_against_recordings(
    whole: Pipeline, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(report_generate, "recorded_sets", lambda _: [("small", lambda: street_set(3, GRID))])
    out = printed(whole, "recordings", tmp_path, monkeypatch, capsys)
    assert "### small, 2 scans" in out
    assert "| cast | + sensor model | simulated | generated | untrained |" in out
    assert "| range (JSD) |" in out


def test_a_picture_has_a_row_each_layout_and_a_column_each_weights(
    whole: Pipeline, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Sensor, "preset", lambda _: GRID)
    for columns, pipelines in ((3, {"one": whole}), (4, {"one": whole, "two": whole})):
        rows = list(pictures.generated(pipelines, [2, 1]))
        assert [len(row) for row in rows] == [columns, columns]
