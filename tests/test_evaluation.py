"""Scores of generated scans, with a network that has not learned."""

import dataclasses
import math

import numpy as np
import pytest
import torch

from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.evaluation import (
    evaluate,
    score,
    unseen_streets,
    untrained_weights,
)
from lidardraft.pipeline import Pipeline
from lidardraft.scene.sensor import Sensor
from lidardraft.streets import StreetPair
from lidardraft.training import recipes

SENSOR = Sensor(name="small", elevations=tuple(math.radians(2 - 1.7 * row) for row in range(16)), columns=128)

NAMES = ("detailed scan", "other streets", "simulated", "generated", "untrained")


@pytest.fixture(scope="module")
def pairs() -> list[StreetPair]:
    return unseen_streets(2, sensor=SENSOR)


@pytest.fixture
def papers() -> Denoiser:
    torch.manual_seed(0)
    base, control = recipes.tiny()
    return Denoiser.from_config(base.denoiser).with_controlnet(control.denoiser)


def test_scans_are_scored_between_those_of_other_streets_and_random_weights(
    pairs: list[StreetPair], papers: Denoiser
) -> None:
    rows = list(evaluate(Pipeline(papers, steps=2), pairs))
    _, others, condition, simulated, generated, random = rows
    assert [row.name for row in rows] == [*NAMES[:2], "condition image", *NAMES[2:]]
    assert (condition.objects, condition.overall, condition.drop) == (1, 1, 0)
    assert condition.holes < 0.02
    assert set(condition.by_class.values()) == {1.0}
    assert condition.intensity == {}  # a cast has none
    assert 0.3 < simulated.objects < 1
    assert simulated.objects > simulated.other + 0.1
    assert simulated.objects > others.objects + 0.1
    assert 0 < simulated.intensity["road"] < 0.5
    assert 0 <= random.overall <= 1
    assert generated != random


def test_the_detailed_scans_are_at_no_distance_from_themselves(pairs: list[StreetPair]) -> None:
    detailed = score("detailed", pairs, [pair.scan for pair in pairs])
    assert (detailed.range, detailed.height, detailed.bev, detailed.classes) == (0, 0, 0, 0)
    assert set(detailed.intensity.values()) == {0.0}
    assert 0.3 < detailed.objects < 1
    assert 0 < detailed.holes < 0.2
    assert 0 < detailed.lone < 0.2
    bright = [dataclasses.replace(pair.scan, intensity=np.sqrt(pair.scan.intensity)) for pair in pairs]
    assert score("brighter", pairs, bright).intensity["road"] > 0.6
    near = [dataclasses.replace(pair.scan, depth=pair.scan.depth / 2) for pair in pairs]
    changed = score("nearer", pairs, near)
    assert min(changed.range, changed.height, changed.bev) > 0.1
    assert changed.classes == 0


def test_untrained_weights_are_random_wherever_training_starts_from_zero(papers: Denoiser) -> None:
    torch.manual_seed(5)
    expected = torch.rand(3)
    torch.manual_seed(5)
    one, again = untrained_weights(papers), untrained_weights(papers)
    assert torch.equal(torch.rand(3), expected)  # and no random number of others is taken
    assert one.config == papers.config
    assert one.controlnet is not None
    assert all(torch.equal(a, b) for a, b in zip(one.parameters(), again.parameters(), strict=True))
    assert one.network.head.weight.any()
    assert all(conv.weight.any() for _, conv in one.controlnet.zero_convs())
