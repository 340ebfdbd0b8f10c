"""Scores of generated scans, with a network that has not learned."""

import dataclasses
import math

import numpy as np
import pytest
import torch

from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.evaluation import evaluate, loss_by_other_layouts, score, unseen_streets
from lidardraft.pipeline import Pipeline
from lidardraft.scene.sensor import Sensor
from lidardraft.streets import StreetPair
from lidardraft.training import recipes

SENSOR = Sensor(name="small", elevations=tuple(math.radians(2 - 1.7 * row) for row in range(16)), columns=128)


@pytest.fixture(scope="module")
def pairs() -> list[StreetPair]:
    return unseen_streets(2, sensor=SENSOR)


@pytest.fixture
def denoiser() -> Denoiser:
    torch.manual_seed(0)
    return Denoiser.from_config(recipes.tiny().stages[0].denoiser)


def test_scans_are_scored_between_the_detailed_ones_and_random_weights(
    pairs: list[StreetPair], denoiser: Denoiser
) -> None:
    detailed, condition, simulated, generated, random = evaluate(Pipeline(denoiser, steps=2), pairs)
    assert [scores.name for scores in (detailed, condition, simulated, generated, random)] == [
        *("detailed scan", "condition image", "simulated", "generated", "untrained")
    ]
    assert detailed.jsd == 0
    assert 0.3 < detailed.objects < 1
    assert (condition.objects, condition.overall, condition.drop) == (1, 1, 0)
    assert 0.3 < simulated.objects < 1
    assert 0 <= random.overall <= 1
    assert generated != random
    assert condition.holes < 0.02
    assert 0 < detailed.holes < 0.2
    assert 0 < detailed.lone < 0.2
    assert set(condition.by_class.values()) == {1.0}
    assert set(detailed.intensity.values()) == {0.0}
    assert condition.intensity == {}  # a cast has none
    for scores in (simulated, generated):
        assert 0 < scores.intensity["road"] < 0.3
    bright = [dataclasses.replace(pair.scan, intensity=np.sqrt(pair.scan.intensity)) for pair in pairs]
    assert score("brighter", pairs, bright).intensity["road"] > 0.6


def test_the_untrained_network_is_sampled_as_the_trained_one(pairs: list[StreetPair], denoiser: Denoiser) -> None:
    fast, langevin = (list(evaluate(Pipeline(denoiser, steps=2, langevin=n), pairs[:1]))[-1] for n in (None, 1))
    assert fast.name == langevin.name == "untrained"
    assert fast != langevin


def test_scans_are_generated_where_the_weights_are(pairs: list[StreetPair], denoiser: Denoiser) -> None:
    scores = evaluate(Pipeline(denoiser.to("meta"), steps=1), pairs)
    assert [next(scores).name for _ in range(3)] == ["detailed scan", "condition image", "simulated"]
    with pytest.raises(RuntimeError, match=r"unsupported|meta tensor"):  # nothing is computed on that device
        next(scores)


def test_a_network_that_heeds_its_layout_does_worse_by_another(pairs: list[StreetPair], denoiser: Denoiser) -> None:
    scans, images = [pair.scan for pair in pairs], [pair.condition_image for pair in pairs]
    assert loss_by_other_layouts(denoiser, scans, images) > 1.05  # of an open copy gate
    base, control = recipes.tiny_paper().stages
    fresh = Denoiser.from_config(base.denoiser).with_controlnet(control.denoiser)
    assert loss_by_other_layouts(fresh, scans, images) == 1.0  # its zero convolutions are zero
