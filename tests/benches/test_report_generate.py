"""The report of generated scans, with a network that has not learned."""

import math
from dataclasses import replace

import numpy as np
import pytest
import torch

import report_generate
from cases import street_set, sweeps_of
from generated_recordings import FEWEST, goals, told_apart
from generated_streets import KINDS, SENSOR, UNSEEN_SENSORS, generate, scores_by_kind, spread
from goals import Goal, goal_table
from lidardraft import Pipeline
from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.evaluation import unseen_streets
from lidardraft.metrics.sweep import Sweep
from lidardraft.networks import weight_file
from lidardraft.scene.sensor import Sensor
from lidardraft.semantics import BY_NAME
from lidardraft.training import recipes
from scan_scores import scores

SMALL = Sensor(name="small", elevations=tuple(math.radians(2 - 1.7 * row) for row in range(16)), columns=128)


@pytest.fixture(scope="module")
def pipeline() -> Pipeline:
    torch.manual_seed(0)
    return Pipeline(Denoiser.from_config(recipes.tiny().stages[0].denoiser), steps=1)


def test_goals_are_met_within_their_bounds() -> None:
    goals = [Goal("few", {"a": 0.5, "b": 1.0}, most=0.9), Goal("many", {"a": 2.0}, least=1.0)]
    few, many = goal_table([*goals]).splitlines()[2:]
    assert few == "| few | <= 0.9 | a 0.5, b **1** | no |"
    assert many == "| many | >= 1 | a 2 | yes |"
    assert not Goal("unknown", {"a": math.nan}, least=0.0, most=1.0).met


def test_scans_of_streets_are_scored_by_kind(pipeline: Pipeline) -> None:
    pairs = unseen_streets(2, sensor=SMALL)
    rows = scores_by_kind(pairs, [pair.scan for pair in pairs])
    assert list(rows) == ["detailed", "simulated", "generated", "generated / simulated"]
    exact = rows["generated"]  # which are the detailed scans themselves
    assert exact["agreeing"] == exact["objects"] == exact["drop F1"] == 1.0
    assert exact["BEV"] == exact["drop runs"] == exact["range"] == 0.0
    same = ("kept", "kept on objects", "dropped", "holes in 1,000", "lone %")
    assert [exact[name] for name in same] == [rows["detailed"][name] for name in same]
    assert rows["simulated"]["agreeing"] < 1.0
    made = scores_by_kind(pairs, [generate(pipeline, pair) for pair in pairs])["generated"]
    assert 0.0 < made["agreeing"] < 1.0


def test_a_class_that_one_kind_lacks_does_not_count_for_any() -> None:
    scans = [Sweep.by_azimuth(pair.scan) for pair in unseen_streets(2, sensor=SMALL)]
    road = BY_NAME["road"].id
    simulated = [replace(sweep, intensity=sweep.intensity / 2) for sweep in scans]
    generated = [replace(sweep, label=np.where(sweep.label == road, 0, sweep.label)) for sweep in simulated]
    rows = scores(
        [
            {"recorded": recorded, "cast": recorded, "simulated": first, "generated": second}
            for recorded, first, second in zip(scans, simulated, generated, strict=True)
        ],
        KINDS,
        firings=True,
    )
    assert 0.0 < rows["simulated"]["intensity by class"] == rows["generated"]["intensity by class"]


def test_recordings_are_told_from_what_is_made(pipeline: Pipeline) -> None:
    cases = street_set(FEWEST, SMALL)
    found = list(sweeps_of(cases, pipeline))
    rows = {"streets": scores(found, KINDS, firings=True)}
    rows["streets"]["+ sensor model"] = rows["streets"]["simulated"]
    told = {f"streets, {kind}": auc for kind, auc in told_apart(found).items()}
    assert all(0.0 <= value <= 1.0 for auc in told.values() for value in auc.values())
    named = {goal.name: goal for goal in goals(rows, told)}
    assert {name.split(", ")[0] for name in named["two-sample AUC by family, generated minus simulated"].values} == {
        "streets"
    }
    assert named["JSD of drop runs to recordings, generated / simulated"].values.keys() == {"streets"}
    assert not told_apart(found[: FEWEST - 1])


def test_spread_is_the_share_that_does_not_agree() -> None:
    first, second = (pair.scan for pair in unseen_streets(2, sensor=SMALL))
    assert spread([first, first]) == 0.0
    assert 0.1 < spread([first, second]) <= 1.0
    assert spread([first, first, second]) == pytest.approx(2 / 3 * spread([first, second]))


def test_unseen_sensors_are_ones_that_the_network_can_serve() -> None:
    cell = recipes.small().stages[0].denoiser.cell
    for sensor in (SENSOR, *UNSEEN_SENSORS):
        assert np.all(np.remainder(sensor.shape, cell) == 0), sensor.name


def test_parts_are_chosen_by_name(
    pipeline: Pipeline, tmp_path: object, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path = f"{tmp_path}/weights.safetensors"
    weight_file.save(pipeline.denoiser, path, {})
    options = ["-n", "2", "--weights", path, "--steps", "1", "--only", UNSEEN_SENSORS[2].name]
    monkeypatch.setattr("sys.argv", ["report_generate.py", *options])
    report_generate.main()
    printed = capsys.readouterr().out
    assert "| 24 uneven, 120 degrees (2) |" in printed
    assert "| dropped, generated / detailed | 0.8 to 1.25 | 24 uneven, 120 degrees (2) " in printed
    assert "Told from" not in printed
