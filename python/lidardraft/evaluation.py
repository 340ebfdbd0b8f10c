"""The quality of generated scans of unseen streets: their adherence to the layouts, and their likeness to scans."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
import torch

from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.metrics.adherence import Adherence, adherence
from lidardraft.metrics.comparisons import bev_histogram
from lidardraft.metrics.lifelike import CLASS_SETS, class_counts, mean_known, pooled_divergence
from lidardraft.metrics.profiles import height_histogram, intensity_histogram, range_histogram
from lidardraft.metrics.returns import lone_returns, near_holes
from lidardraft.metrics.sweep import Sweep
from lidardraft.pipeline import Pipeline
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.sensor import Sensor
from lidardraft.semantics import BY_NAME
from lidardraft.simulation.simulate import simulate
from lidardraft.streets import StreetConfig, StreetPair, streets

_Item = TypeVar("_Item")
_FEWEST = 100  # returns of a class for a comparison of intensities
OTHER_STREETS = 3_000_000  # a seed, neither for training nor for scores


@dataclass(frozen=True, kw_only=True)
class Scores:
    """The scores of one kind of scan of the same streets.

    `objects`, `overall`, `drop` and `by_class` are adherence to the condition images (means over the streets); `other`
    is that of the objects to the image of the next street. `range`, `height`, `bev` and `classes` are Jensen-Shannon
    distances from the detailed scans. `holes` and `lone` are the shares of holes on near surfaces and of lone returns
    (`metrics/returns.py`). `intensity` are the distances of intensities of each class from those of the detailed scans.
    """

    name: str
    objects: float
    other: float
    overall: float
    drop: float
    range: float
    height: float
    bev: float
    classes: float
    holes: float
    lone: float
    by_class: dict[str, float]
    intensity: dict[str, float]


def unseen_streets(
    num: int, *, sensor: Sensor, seed: int = 1_000_000, on_street: Callable[[], object] | None = None
) -> list[StreetPair]:
    """One pair of each of `num` streets, of a seed outside training; `on_street` is called after each."""
    config = StreetConfig(sensor=sensor, poses_per_street=1)
    return list(_counted(itertools.islice(streets(seed=seed, config=config), num), on_street))


def evaluate(
    pipeline: Pipeline, pairs: list[StreetPair], *, on_scan: Callable[[], object] | None = None
) -> Iterator[Scores]:
    """The scores of several kinds of scans; `on_scan` is called after each generated one.

    They are the detailed scans themselves, scans of other streets, the condition images, the simulated scans of the
    same layouts, the pipeline's scans, and those of the same network untrained.
    """
    others = (pair.scan for pair in unseen_streets(len(pairs), sensor=pairs[0].scan.sensor, seed=OTHER_STREETS))
    yield score("detailed scan", pairs, (pair.scan for pair in pairs))
    yield score("other streets", pairs, others)
    yield score("condition image", pairs, (pair.condition_image for pair in pairs))
    yield score("simulated", pairs, map(simulated, pairs))
    for name, generator in (("generated", pipeline), ("untrained", untrained(pipeline))):
        made = (generator.generate(pair.condition_image, seed=pair.index) for pair in pairs)
        yield score(name, pairs, _counted(made, on_scan))


def simulated(pair: StreetPair) -> RangeImage:
    """The simulated scan of the layout of a pair, by the unit of the sensor that made its only scan of the street."""
    sensor = pair.scan.sensor
    unit = replace(sensor.assumed_model, unit=pair.index)
    return simulate(
        pair.layout, sensor, seed=pair.index, model=unit, pose=pair.pose, speed=pair.speed, carrier=False
    ).image


def _counted(items: Iterable[_Item], on_item: Callable[[], object] | None) -> Iterator[_Item]:
    """The items, with a call after each."""
    for item in items:
        if on_item is not None:
            on_item()
        yield item


def untrained(pipeline: Pipeline) -> Pipeline:
    """The same pipeline with random weights."""
    return replace(pipeline, denoiser=untrained_weights(pipeline.denoiser), trained=None)


def untrained_weights(denoiser: Denoiser) -> Denoiser:
    """A network of the same form without any training; weights that start at zero are random as well."""
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(0)
        network = Denoiser.from_config(denoiser.config)
        for module in network.modules():
            if isinstance(module, torch.nn.Conv2d | torch.nn.Linear):
                module.reset_parameters()
    return network.to(next(denoiser.parameters()).device)


def score(name: str, pairs: Sequence[StreetPair], scans: Iterable[RangeImage]) -> Scores:
    """The scores of one scan for each pair."""
    images, given = list(scans), [pair.condition_image for pair in pairs]
    others = [*given[1:], *given[:1]]
    truth, sweeps = ([Sweep.by_azimuth(image) for image in some] for some in ([pair.scan for pair in pairs], images))
    scores = [adherence(image, own) for image, own in zip(images, given, strict=True)]

    def distance(of: Callable[[Sweep], np.ndarray]) -> float:
        return pooled_divergence([of(sweep) for sweep in truth], [of(sweep) for sweep in sweeps])

    return Scores(
        name=name,
        objects=mean_known([score.objects for score in scores]),
        other=mean_known([adherence(image, other).objects for image, other in zip(images, others, strict=True)]),
        overall=mean_known([score.overall for score in scores]),
        drop=mean_known([score.drop for score in scores]),
        range=distance(range_histogram),
        height=distance(lambda sweep: height_histogram(sweep, -pairs[0].scan.sensor.mount_height)),
        bev=distance(lambda sweep: bev_histogram(sweep.points[sweep.valid])),
        classes=distance(class_counts),
        holes=_share([near_holes(sweep) for sweep in sweeps]),
        lone=_share([lone_returns(sweep) for sweep in sweeps]),
        by_class=_by_class(scores),
        intensity=_intensity(truth, sweeps),
    )


def _intensity(detailed: list[Sweep], sweeps: list[Sweep]) -> dict[str, float]:
    """The distance of the intensities of each class from those of the detailed scans; empty without intensities."""
    if any(sweep.intensity is None for sweep in sweeps):
        return {}
    found = {}
    for name, members in CLASS_SETS.items():
        ids = tuple(BY_NAME[member].id for member in members)
        of_class = [[intensity_histogram(sweep, ids) for sweep in scans] for scans in (detailed, sweeps)]
        if min(np.sum(histograms) for histograms in of_class) >= _FEWEST:
            found[name] = pooled_divergence(*of_class)
    return found


def _by_class(scores: list[Adherence]) -> dict[str, float]:
    names = sorted({name for score in scores for name in score.by_class})
    return {name: mean_known([score.by_class[name] for score in scores if name in score.by_class]) for name in names}


def _share(counts: list[np.ndarray]) -> float:
    """The share in all counts, [part, whole] each; NaN if empty."""
    part, whole = np.sum(counts, axis=0)
    return float(part / whole) if whole else float("nan")
