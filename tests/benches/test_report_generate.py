"""The report of generated scans, with networks that have not learned."""

import dataclasses
import math
from pathlib import Path

import pytest
import torch

import report_generate
from cases import street_set
from generated_speed import in_process
from generated_streets import compare_seeds, completing_goals, spread, whole_scan_goals
from goals import Goal, goal_table
from lidardraft import Pipeline
from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.evaluation import unseen_streets
from lidardraft.networks import weight_file
from lidardraft.scene.sensor import Sensor
from lidardraft.training import recipes

SMALL = Sensor(name="small", elevations=tuple(math.radians(2 - 1.7 * row) for row in range(16)), columns=128)


@pytest.fixture(scope="module")
def completing() -> Pipeline:
    torch.manual_seed(0)
    return Pipeline(Denoiser.from_config(recipes.tiny().stages[-1].denoiser), steps=1)


@pytest.fixture(scope="module")
def whole() -> Pipeline:
    torch.manual_seed(0)
    config = dataclasses.replace(recipes.tiny().stages[-1].denoiser, condition=("depth", "class"))
    return Pipeline(Denoiser.from_config(config), steps=1)


def printed(
    pipeline: Pipeline, part: str, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> str:
    """What the command prints of one part."""
    weight_file.save(pipeline.denoiser, folder / "weights.safetensors", {})
    (folder / "small.json").write_text(SMALL.to_json())
    options = ["-n", "2", "--weights", str(folder / "weights.safetensors"), "--steps", "1", "--data", str(folder)]
    argv = ["report_generate.py", *options, "--only", part, "--sensor", str(folder / "small.json")]
    monkeypatch.setattr("sys.argv", argv)
    report_generate.main()
    return capsys.readouterr().out


def test_goals_are_met_within_their_bounds() -> None:
    goals = [Goal("few", {"a": 0.5, "b": 1.0}, most=0.9), Goal("many", {"a": 2.0}, least=1.0)]
    few, many = goal_table([*goals]).splitlines()[2:]
    assert few == "| few | <= 0.9 | a 0.5, b **1** | no |"
    assert many == "| many | >= 1 | a 2 | yes |"
    assert not Goal("unknown", {"a": math.nan}, least=0.0, most=1.0).met


def test_completed_halves_are_held_against_a_lawn_and_the_given_ones_against_simulated_scans() -> None:
    lawn = {"range": 0.4, "height": 0.2, "bev": 0.6, "classes": 0.8, "objects": 0.9}
    rows = {"bare": lawn, "simulated": lawn, "generated": {name: value / 2 for name, value in lawn.items()}}
    nearer, kept = completing_goals(rows)
    assert set(nearer.values.values()) == {0.5}
    assert nearer.met
    assert kept.values == {"objects": -0.45}
    assert not kept.met
    nearer, kept = completing_goals(rows | {"generated": lawn})
    assert not nearer.met
    assert kept.met


def test_whole_scans_are_to_keep_to_their_own_layouts_alone() -> None:
    good = {"objects": 0.5, "other": 0.1, "bev": 0.14}
    assert all(goal.met for goal in whole_scan_goals({"generated": good}))
    for name, bad in (("objects", 0.4), ("other", 0.2), ("bev", 0.2)):
        missed = [goal for goal in whole_scan_goals({"generated": good | {name: bad}}) if not goal.met]
        assert [set(goal.values) for goal in missed] == [{name}]


def test_spread_is_the_distance_of_top_views() -> None:
    first, second = (pair.scan for pair in unseen_streets(2, sensor=SMALL))
    assert spread([first, first]) == 0.0
    apart = spread([first, second])
    assert 0.1 < apart < math.sqrt(math.log(2))
    assert spread([first, first, second]) == pytest.approx(2 / 3 * apart)


def test_seeds_of_one_street_are_held_against_as_many_streets(
    completing: Pipeline, monkeypatch: pytest.MonkeyPatch
) -> None:
    text, goal = compare_seeds(completing, SMALL, 2)
    cells = [line.split(" | ") for line in text.splitlines() if line.startswith("| ")][1:]
    found = {name.strip("| "): float(value.strip("| ")) for name, value in cells}
    assert list(found) == ["other streets", "simulated", "generated", "untrained"]
    assert found["generated"] > 0
    assert 0 < found["simulated"] < 0.8 * found["other streets"]  # one layout, eight units of the sensor
    assert goal.values["BEV"] == pytest.approx(found["generated"] / found["other streets"], rel=0.01)
    monkeypatch.setattr(Pipeline, "generate", lambda _, __, simulated, *___, **____: simulated)
    _, goal = compare_seeds(completing, SMALL, 2)
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
    monkeypatch.setattr(report_generate, "recorded_sets", lambda _: [("small", lambda: street_set(3, SMALL))])
    said = "The layouts of recordings leave nothing open: these weights add nothing to the simulated scans.\n\n"
    assert printed(completing, "recordings", tmp_path, monkeypatch, capsys) == said
    out = printed(whole, "recordings", tmp_path, monkeypatch, capsys)
    assert "### small, 2 scans" in out
    assert "| cast | + sensor model | simulated | generated | untrained |" in out
    assert "| range (JSD) |" in out


def test_a_process_measures_itself(completing: Pipeline, tmp_path: Path) -> None:
    weight_file.save(completing.denoiser, tmp_path / "weights.safetensors", {})
    row = in_process(str(tmp_path / "weights.safetensors"), 1, "float32")
    assert 0 < row["least, s"] <= row["median, s"] < 20
    assert 0.1 < row["peak memory, GB"] < 4
