"""The quality of generated scans of unseen streets: their adherence to the layouts, and their likeness to scans."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
import torch

from lidardraft.diffusion.codec import encode_condition, encode_rays, encode_scan
from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.metrics.adherence import Adherence, adherence
from lidardraft.metrics.comparisons import bev_histogram
from lidardraft.metrics.lifelike import CLASS_SETS, class_counts, mean_known, pooled_divergence
from lidardraft.metrics.profiles import height_histogram, intensity_histogram, range_histogram
from lidardraft.metrics.returns import lone_returns, near_holes
from lidardraft.metrics.sweep import Sweep
from lidardraft.networks.layers import reduced_precision
from lidardraft.pipeline import Pipeline, merged
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.sensor import Sensor
from lidardraft.semantics import BY_NAME
from lidardraft.simulation.simulate import simulate
from lidardraft.streets import StreetConfig, StreetPair, streets

_Item = TypeVar("_Item")
_FEWEST = 100  # returns of a class for a comparison of intensities
_HEEDED_LEVELS = (0.1, 0.3, 1.0, 3.0)  # of noise: at lower ones the scan itself suffices
OTHER_STREETS = 3_000_000  # a seed, neither for training nor for scores
_LAWN = Layout((Primitive(shape="plane", center=(0, 0, 0), size=(400, 400, 0), label="terrain", id="lawn", open=True),))


@dataclass(frozen=True, kw_only=True)
class Scores:
    """The scores of one kind of scan of the same streets.

    `objects`, `overall`, `drop` and `by_class` are adherence to the condition images (means over the streets); `other`
    is that of the objects to the image of the next street. `range`, `height`, `bev` and `classes` are Jensen-Shannon
    distances from the detailed scans. `holes` and `lone` are the shares of holes on near surfaces and of lone returns
    (`metrics/returns.py`). `own` is the share of returns that are not the simulated scan's. `intensity` are the
    distances of intensities of each class in both. If halves of the streets are open, adherence is that of the given
    halves, and the rest is of the open ones.
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
    own: float
    by_class: dict[str, float]
    intensity: dict[str, float]


def unseen_streets(
    num: int, *, sensor: Sensor, seed: int = 1_000_000, on_street: Callable[[], object] | None = None
) -> list[StreetPair]:
    """One pair of each of `num` streets, of a seed outside training; `on_street` is called after each."""
    config = StreetConfig(sensor=sensor, poses_per_street=1, simulated=True)
    return list(_counted(itertools.islice(streets(seed=seed, config=config), num), on_street))


def evaluate(
    pipeline: Pipeline, pairs: list[StreetPair], *, on_scan: Callable[[], object] | None = None
) -> Iterator[Scores]:
    """The scores of several kinds of scans; `on_scan` is called after each generated one.

    They are the detailed scans themselves, scans of other streets, the condition images, the simulated scans of the
    same layouts, the pipeline's scans, and those of the same network untrained. Weights that complete get a half of
    each street; then the given half beside a lawn replaces the condition image.
    """
    opened = half_opened([pair.scan for pair in pairs]) if pipeline.denoiser.config.completes else None
    others = (pair.scan for pair in unseen_streets(len(pairs), sensor=pairs[0].scan.sensor, seed=OTHER_STREETS))
    yield score("detailed scan", pairs, (pair.scan for pair in pairs), opened)
    yield score("other streets", pairs, others, opened)
    if opened is None:
        yield score("condition image", pairs, (pair.condition_image for pair in pairs))
    else:
        bare = (merged(_simulated(pair), lawn(pair), part) for pair, part in zip(pairs, opened, strict=True))
        yield score("bare", pairs, bare, opened)
    yield score("simulated", pairs, (_simulated(pair) for pair in pairs), opened)
    for name, generator in (("generated", pipeline), ("untrained", untrained(pipeline))):
        made = (
            generator.generate(pair.condition_image, _simulated(pair), is_open, seed=pair.index)
            for pair, is_open in zip(pairs, opened or itertools.repeat(None), strict=opened is not None)
        )
        yield score(name, pairs, _counted(made, on_scan), opened)


def half_opened(scans: Sequence[RangeImage]) -> list[np.ndarray]:
    """Half of the columns of each scan, bool [H, W]; from scan to scan they move once around."""
    found = []
    for number, scan in enumerate(scans):
        rows, columns = scan.sensor.shape
        place = (np.arange(columns) + columns * number / len(scans)) % columns
        found.append(np.broadcast_to(place < columns / 2, (rows, columns)) & ~scan.sensor.blocked_pixels)
    return found


def sample_scans(
    denoiser: Denoiser, condition_images: list[RangeImage], *, on_scan: Callable[[], object] | None = None
) -> list[RangeImage]:
    """The scans that a denoiser generates from each condition image, without simulated scans."""
    pipeline = Pipeline(denoiser)
    scans = (pipeline.generate(image, image, seed=seed) for seed, image in enumerate(condition_images))
    return list(_counted(scans, on_scan))


@torch.inference_mode()
def loss_by_other_layouts(denoiser: Denoiser, scans: list[RangeImage], condition_images: list[RangeImage]) -> float:
    """The loss of scans by the next one's condition image over that by their own: 1 if a denoiser ignores its
    condition. It rises long before scans show it. Weights that complete get half of the columns."""
    device = next(denoiser.parameters()).device
    opened = half_opened(scans) if denoiser.config.completes else None
    losses = dict.fromkeys((0, 1), 0.0)
    for seed, scan in enumerate(scans):
        sigma = torch.tensor(_HEEDED_LEVELS, device=device)
        clean = torch.from_numpy(encode_scan(scan)).to(device).expand(len(sigma), -1, -1, -1)
        noise = torch.randn(clean.shape, generator=torch.Generator().manual_seed(seed)).to(device)
        rays = torch.from_numpy(encode_rays(scan.sensor)).to(device)
        for shift in losses:
            other = (seed + shift) % len(scans)
            encoded = encode_condition(condition_images[other], scans[other], None if opened is None else opened[seed])
            condition = torch.from_numpy(encoded).to(device).expand(len(sigma), -1, -1, -1)
            with reduced_precision(device):
                loss = denoiser.loss(clean, sigma, noise, rays, condition, wraps=scan.sensor.wraps)
            losses[shift] += loss.mean().item()
    return losses[1] / losses[0]


def _simulated(pair: StreetPair) -> RangeImage:
    assert pair.simulated is not None
    return pair.simulated


def lawn(pair: StreetPair) -> RangeImage:
    """The scan of an endless lawn by a sensor at the place of a pair."""
    sensor = pair.scan.sensor
    return simulate(_LAWN, sensor, pose=pair.pose, speed=pair.speed, seed=pair.index, carrier=False).image


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


def score(
    name: str, pairs: Sequence[StreetPair], scans: Iterable[RangeImage], opened: Sequence[np.ndarray] | None = None
) -> Scores:
    """The scores of one scan for each pair, with the `opened` pixels of each, bool [H, W]."""
    images = list(scans)
    detailed, judged, given = [pair.scan for pair in pairs], images, [pair.condition_image for pair in pairs]
    if opened is not None:
        detailed, judged = (
            [image.keep(o) for image, o in zip(some, opened, strict=True)] for some in (detailed, images)
        )
        given = [image.keep(~is_open) for image, is_open in zip(given, opened, strict=True)]
    others = [*given[1:], *given[:1]]
    truth, sweeps = ([Sweep.by_azimuth(image) for image in some] for some in (detailed, judged))
    scores = [adherence(image, own) for image, own in zip(images, given, strict=True)]

    def distance(of: Callable[[Sweep], np.ndarray]) -> float:
        return pooled_divergence([of(sweep) for sweep in truth], [of(sweep) for sweep in sweeps])

    changed = [
        (image.valid & ~_same(image, _simulated(pair)), image.valid) for image, pair in zip(judged, pairs, strict=True)
    ]
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
        own=_share([np.array([part.sum(), whole.sum()]) for part, whole in changed]),
        by_class=_by_class(scores),
        intensity=_intensity(truth, sweeps),
    )


def _same(image: RangeImage, other: RangeImage) -> np.ndarray:
    """The mask of returns at the same range in both, to the millimetre, bool [H, W]."""
    return other.valid & (np.abs(image.depth - other.depth) < 1e-3)


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
