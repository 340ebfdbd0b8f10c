"""Whether a network heeds its condition: told while it learns, and what the smallest one learns in half a minute."""

import copy
import dataclasses
import itertools
import json
import math
from pathlib import Path

import pytest
import torch
from safetensors.torch import load_file

from ablation import loss_by_other_layouts
from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.diffusion.denoiser_config import DenoiserConfig
from lidardraft.errors import TrainingError
from lidardraft.evaluation import unseen_streets, untrained_weights
from lidardraft.formats.pairs import Pair, write_pairs
from lidardraft.networks import weight_file
from lidardraft.scene.sensor import Sensor
from lidardraft.streets import StreetConfig, streets
from lidardraft.training import recipes
from lidardraft.training.denoising import OTHER, OWN, AdherenceWatch, DenoisingConfig, train_denoiser
from lidardraft.training.sources import PairFolder

SENSOR = Sensor(name="small", elevations=tuple(math.radians(2 - 1.7 * row) for row in range(16)), columns=128)
BASE, CONTROL = recipes.tiny()


@pytest.fixture(scope="module")
def watch() -> AdherenceWatch:
    return AdherenceWatch(SENSOR)


@pytest.fixture
def fresh() -> Denoiser:
    """A ControlNet that adds nothing yet, on a base of random weights."""
    torch.manual_seed(0)
    base = Denoiser.from_config(BASE.denoiser)
    torch.nn.init.normal_(base.network.head.weight, std=0.05)
    return base.with_controlnet(CONTROL.denoiser)


def test_a_network_that_ignores_its_condition_is_told_after_a_thousand_steps(
    watch: AdherenceWatch, fresh: Denoiser
) -> None:
    measured = watch.measure(fresh)
    assert measured[OWN] == measured[OTHER]
    watch.check(measured, 999)
    with pytest.raises(TrainingError, match=r"ignores its condition after 1000 steps: .*% agree with the layout, and"):
        watch.check(measured, 1000)


def test_a_network_that_heeds_its_condition_is_not(watch: AdherenceWatch, fresh: Denoiser) -> None:
    obeying = copy.deepcopy(fresh)

    def denoise(_x: object, _sigma: object, _rays: object, condition: torch.Tensor, **_: object) -> torch.Tensor:
        return condition

    obeying.denoise = denoise  # type: ignore[method-assign, assignment]
    measured = watch.measure(obeying)
    assert measured[OWN] > measured[OTHER] + 0.2
    watch.check(measured, 1000)


def test_what_is_watched_is_in_the_log_and_changes_no_weight(pairs: PairFolder, tmp_path: Path) -> None:
    list(train_denoiser(BASE, pairs, tmp_path / "base"))
    weights = []
    for every in (0, 2):
        config = dataclasses.replace(CONTROL, steps=5, report_every=1, save_every=2, watch_every=every)
        base = weight_file.load(tmp_path / "base" / "weights.safetensors", Denoiser)
        run = tmp_path / f"watched-{every}"
        for report in train_denoiser(config, pairs, run, begin=base):
            if every and report.step == 3:  # interrupted after the state of step 2 was saved
                break
        if every:
            again = weight_file.load(tmp_path / "base" / "weights.safetensors", Denoiser)
            list(train_denoiser(config, pairs, run, begin=again))
            whole = tmp_path / "whole"
            again = weight_file.load(tmp_path / "base" / "weights.safetensors", Denoiser)
            list(train_denoiser(config, pairs, whole, begin=again))
            logs = [
                [json.loads(line)["measures"] for line in (folder / "log.jsonl").read_text().splitlines()]
                for folder in (run, whole)
            ]
            assert logs[0] == logs[1]
            assert [OWN in measures for measures in logs[0]] == [True, False, True, False, True]
        weights.append(load_file(run / "weights.safetensors"))
    assert all(torch.equal(weights[0][name], weights[1][name]) for name in weights[0])


def test_without_a_condition_there_is_nothing_to_watch(pairs: PairFolder, tmp_path: Path) -> None:
    config = dataclasses.replace(BASE, steps=1, watch_every=1)
    (report,) = train_denoiser(config, pairs, tmp_path)
    assert OWN not in report.measures


DENOISER = DenoiserConfig(
    cell=(2, 4),
    widths=(16, 16, 32, 32),
    strides=(1, 2, 2, 1),
    dilations=(1, 1, 1, 2),
    condition=("depth", "class"),
)
CONFIG = DenoisingConfig(denoiser=DENOISER, steps=100, batch=8, learning_rate=0.02, warmup=20)
HEEDS = 1.01  # of the loss by other layouts over that by their own


@pytest.mark.slow
def test_a_minute_of_training_is_enough_to_heed_layouts_of_unseen_streets(tmp_path: Path) -> None:
    found = itertools.islice(streets(seed=7, config=StreetConfig(sensor=SENSOR, poses_per_street=1)), 24)
    pairs = ((Pair(pair.scan, pair.condition_image), {}) for pair in found)
    list(write_pairs(tmp_path / "pairs", pairs))
    list(train_denoiser(CONFIG, PairFolder(tmp_path / "pairs"), tmp_path / "run"))
    trained = weight_file.load(tmp_path / "run" / "weights.safetensors", Denoiser)
    unseen = unseen_streets(6, sensor=SENSOR)
    scans, images = [pair.scan for pair in unseen], [pair.condition_image for pair in unseen]
    assert loss_by_other_layouts(trained, scans, images) > HEEDS
    assert loss_by_other_layouts(untrained_weights(trained), scans, images) <= HEEDS
