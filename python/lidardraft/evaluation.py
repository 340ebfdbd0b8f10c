"""How well generated scans of unseen streets obey their layouts, and how much they look like scans."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
import torch

from lidardraft.diffusion.codec import encode_condition, encode_rays, encode_scan
from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.diffusion.sampling_defaults import STEPS_FROM_NOISE
from lidardraft.metrics.adherence import Adherence, adherence
from lidardraft.metrics.bev import bev_jsd
from lidardraft.metrics.lifelike import CLASS_SETS, pooled_divergence
from lidardraft.metrics.profiles import intensity_histogram
from lidardraft.metrics.returns import lone_returns, near_holes
from lidardraft.metrics.sweep import Sweep
from lidardraft.networks.precision import reduced_precision
from lidardraft.pipeline import Pipeline
from lidardraft.scene.labelling import label_by_agreement
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.sensor import Sensor
from lidardraft.semantics import BY_NAME
from lidardraft.streets import StreetConfig, StreetPair, streets

_Item = TypeVar("_Item")
_FEWEST = 100  # returns of a class whose intensities are compared
_HEEDED_LEVELS = (0.1, 0.3, 1.0, 3.0)  # of noise: at lower ones the scan itself says all


@dataclass(frozen=True, kw_only=True)
class Scores:
    """Those of one kind of scan of the same streets: adherence to the condition images (means over the streets), the
    Jensen-Shannon distance of the top views from those of the detailed scans, and the shares of holes on near surfaces
    and of lone returns (`metrics/returns.py`); `intensity`, the Jensen-Shannon distance of the intensities of each
    class from those of the detailed scans, of classes that both have."""

    name: str
    objects: float
    overall: float
    drop: float
    jsd: float
    holes: float
    lone: float
    by_class: dict[str, float]
    intensity: dict[str, float]


def unseen_streets(
    num: int, *, sensor: Sensor, seed: int = 1_000_000, on_street: Callable[[], object] | None = None
) -> list[StreetPair]:
    """One pair of each of `num` streets, of a seed that no training used; `on_street` is called after each."""
    config = StreetConfig(sensor=sensor, poses_per_street=1, simulated=True)
    return list(_counted(itertools.islice(streets(seed, config), num), on_street))


def evaluate(
    pipeline: Pipeline, pairs: list[StreetPair], *, on_scan: Callable[[], object] | None = None
) -> Iterator[Scores]:
    """The detailed scans, the condition images, the simulated scans of the same layouts, the pipeline's scans, and
    those of the same network untrained; `on_scan` is called after each generated scan."""
    untrained = Pipeline(
        _random_weights(pipeline.denoiser), steps=pipeline.steps, start=pipeline.start, langevin=pipeline.langevin
    )
    yield score("detailed scan", pairs, (pair.scan for pair in pairs))
    yield score("condition image", pairs, (pair.condition_image for pair in pairs))
    yield score("simulated", pairs, (_simulated(pair) for pair in pairs))
    for name, generator in (("generated", pipeline), ("untrained", untrained)):
        yield score(name, pairs, _counted((_generated(generator, pair) for pair in pairs), on_scan))


def sample_scans(
    denoiser: Denoiser,
    condition_images: list[RangeImage],
    *,
    steps: int = STEPS_FROM_NOISE,
    on_scan: Callable[[], object] | None = None,
) -> list[RangeImage]:
    """What a denoiser that does not see simulated scans makes of each condition image, from noise."""
    pipeline = Pipeline(denoiser, steps=steps)
    scans = (pipeline.generate(image, image, seed=seed) for seed, image in enumerate(condition_images))
    return list(_counted(scans, on_scan))


@torch.inference_mode()
def loss_by_other_layouts(denoiser: Denoiser, scans: list[RangeImage], condition_images: list[RangeImage]) -> float:
    """The loss of scans, each by the condition image of the next one, over that by their own: 1 is a denoiser that does
    not heed what it is given. It shows long before scans do. Of a denoiser without gates: theirs can be below 0."""
    device = next(denoiser.parameters()).device
    losses = dict.fromkeys((0, 1), 0.0)
    for seed, scan in enumerate(scans):
        sigma = torch.tensor(_HEEDED_LEVELS, device=device)
        clean = torch.from_numpy(encode_scan(scan)).to(device).expand(len(sigma), -1, -1, -1)
        noise = torch.randn(clean.shape, generator=torch.Generator().manual_seed(seed)).to(device)
        rays = torch.from_numpy(encode_rays(scan.sensor)).to(device)
        for shift in losses:
            image = condition_images[(seed + shift) % len(scans)]
            condition = torch.from_numpy(encode_condition(image, image)).to(device).expand(len(sigma), -1, -1, -1)
            with reduced_precision(device):
                loss = denoiser.loss(clean, sigma, noise, rays, condition, wraps=scan.sensor.wraps)
            losses[shift] += loss.mean().item()
    return losses[1] / losses[0]


def _simulated(pair: StreetPair) -> RangeImage:
    assert pair.simulated is not None
    return pair.simulated


def _generated(pipeline: Pipeline, pair: StreetPair) -> RangeImage:
    """What the pipeline makes of a pair, with labels."""
    image = pipeline.generate(pair.condition_image, _simulated(pair), seed=pair.index)
    return label_by_agreement(image, (_simulated(pair), pair.condition_image), pair.layout, pair.poses())


def _counted(items: Iterable[_Item], on_item: Callable[[], object] | None) -> Iterator[_Item]:
    """The items, with a call after each."""
    for item in items:
        if on_item is not None:
            on_item()
        yield item


def _random_weights(denoiser: Denoiser) -> Denoiser:
    """A network of the same shape without any training; what starts at zero is random as well."""
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(0)
        network = Denoiser.from_config(denoiser.config)
        for module in network.modules():
            if isinstance(module, torch.nn.Conv2d | torch.nn.Linear):
                module.reset_parameters()
    return network.to(next(denoiser.parameters()).device)


def score(name: str, pairs: list[StreetPair], scans: Iterable[RangeImage]) -> Scores:
    """The scores of one scan for each pair."""
    images = list(scans)
    sweeps = [Sweep.by_azimuth(image) for image in images]
    scores = [adherence(image, pair.condition_image) for image, pair in zip(images, pairs, strict=True)]
    return Scores(
        name=name,
        objects=_mean([score.objects for score in scores]),
        overall=_mean([score.overall for score in scores]),
        drop=_mean([score.drop for score in scores]),
        jsd=bev_jsd((pair.scan.points() for pair in pairs), (image.points() for image in images)),
        holes=_share([near_holes(sweep) for sweep in sweeps]),
        lone=_share([lone_returns(sweep) for sweep in sweeps]),
        by_class=_by_class(scores),
        intensity=_intensity([Sweep.from_image(pair.scan) for pair in pairs], sweeps),
    )


def _intensity(detailed: list[Sweep], sweeps: list[Sweep]) -> dict[str, float]:
    """How far the intensities of each class are from those of the detailed scans; nothing where there are none."""
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
    return {name: _mean([score.by_class[name] for score in scores if name in score.by_class]) for name in names}


def _share(counts: list[np.ndarray]) -> float:
    """Of all that was counted, [part, whole] each; NaN of nothing."""
    part, whole = np.sum(counts, axis=0)
    return float(part / whole) if whole else float("nan")


def _mean(values: list[float]) -> float:
    """The mean of what is not NaN; NaN of nothing."""
    known = [value for value in values if not np.isnan(value)]
    return float(np.mean(known)) if known else float("nan")
