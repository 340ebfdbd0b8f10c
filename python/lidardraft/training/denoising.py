"""Training the generator: pairs become a denoiser, or a ControlNet on one, on disk."""

from __future__ import annotations

import dataclasses
import itertools
import math
import os
from collections.abc import Generator, Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import Any

import numpy as np
import torch
from torch import Tensor

from lidardraft.diffusion.codec import HIDDEN, decode_scan, encode_condition, encode_rays, encode_scan
from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.diffusion.denoiser_config import DenoiserConfig
from lidardraft.diffusion.noise import training_levels
from lidardraft.diffusion.sampler import sample
from lidardraft.errors import TrainingError
from lidardraft.formats.pairs import Pair
from lidardraft.metrics.adherence import adherence
from lidardraft.networks.layers import reduced_precision
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.sensor import Sensor
from lidardraft.semantics import BY_NAME, CLASSES, GROUND
from lidardraft.streets import StreetConfig, streets
from lidardraft.training.learner import LearningConfig
from lidardraft.training.loop import Batch, Measures, Report, device_for_training, prefetched, train
from lidardraft.training.processes import Processes
from lidardraft.training.sources import PairSource, scans_of_step

OWN, OTHER = "objects", "objects of the other street"
_SEED = 2_000_000  # of streets that no training learns from
_STREETS = 2
_CALLS = 8  # of the network a scan, from noise
_DEADLINE = 1_000  # steps after which a network must heed its condition
BANDS = (0.0, 0.05, 0.2, 1.0, float("inf"))  # edges of the noise levels that are reported apart
_SKIPPED = "share of pairs skipped, not finite"
_SILENT = 20  # steps after which a zero convolution must have learned
# How often each is drawn: an azimuth sector, all but such a sector, all but objects, all but objects and the road, all
# that stands for nothing said (terrain, and where no shape is hit), everything. Estimates of ours of what people bring.
_SHARES = {"sector": 0.2, "all but a sector": 0.15, "all but objects": 0.15, "all but the road": 0.2, "filler": 0.2}
_SECTOR = (np.pi / 4, np.pi)  # rad, of open sectors
_VIEW = (np.pi / 3, 2 * np.pi / 3)  # rad, of what a camera sees
_FILLER = [BY_NAME[name].id for name in ("none", "terrain")]
_ROAD = [BY_NAME[name].id for name in GROUND if name != "terrain"]
_THINGS = [row.id for row in CLASSES if row.is_thing]
_KEPT_STUFF = 0.3  # how often a class of stuff is given all the same


class AdherenceWatch:
    """Two unseen streets, each sampled from the same noise.

    A scan is scored against its own condition image and against the other one: a network that ignores its condition
    makes one scan for both streets, so that both scores are equal.
    """

    def __init__(self, sensor: Sensor) -> None:
        config = StreetConfig(sensor=sensor, poses_per_street=1, simulated=True)
        pairs = list(itertools.islice(streets(seed=_SEED, config=config), _STREETS))
        self.sensor = sensor
        self.condition_images = [pair.condition_image for pair in pairs]
        encoded = [encode_condition(pair.condition_image, pair.simulated) for pair in pairs if pair.simulated]
        self.condition = torch.from_numpy(np.stack(encoded))

    @torch.no_grad()
    def measure(self, denoiser: Denoiser) -> dict[str, float]:
        """Mean adherence on objects, of the scans to their own condition images and to those of the other street."""
        seeds = [0] * len(self.condition)
        *_, states = sample(denoiser, self.sensor, seeds=seeds, condition=self.condition, steps=_CALLS, guidance=1)
        scans = [decode_scan(state, self.sensor) for state in states.cpu().numpy()]
        images = self.condition_images
        own = [adherence(scan, image).objects for scan, image in zip(scans, images, strict=True)]
        other = [adherence(scan, image).objects for scan, image in zip(scans, reversed(images), strict=True)]
        return {OWN: float(np.mean(np.nan_to_num(own))), OTHER: float(np.mean(np.nan_to_num(other)))}

    def check(self, measured: dict[str, float], step: int) -> None:
        """Raise `TrainingError` where the condition is still ignored after 1,000 steps: hours would be wasted."""
        if step >= _DEADLINE and not measured[OWN] > measured[OTHER]:
            raise TrainingError(
                f"the network ignores its condition after {step} steps: of its returns on objects "
                f"{measured[OWN]:.1%} agree with the layout, and {measured[OTHER]:.1%} with another one"
            )


@dataclass(frozen=True, kw_only=True)
class DenoisingConfig(LearningConfig):
    """All that decides the result of one stage, beside the pairs and, with a ControlNet, the base.

    A batch holds `batch` whole scans of 64 x 1024, fewer of larger ones, mirrored half the time. The first
    `zero_conv_steps` change the ControlNet's zero convolutions alone. Every `watch_every` steps (0: never) two fixed
    unseen streets are sampled, and a network that does not heed its condition is told (`AdherenceWatch`). A step
    learns from every beam and column, or from every n-th, where n is drawn from `thinnings`: n^2 times as many scans at
    the same cost. ln sigma is normal with `sigma_mean` and `sigma_std`: estimates of ours near the -1.2 and 1.2 of
    Karras et al. (NeurIPS 2022, Table 1), somewhat higher and wider. The other fields are those of `LearningConfig`.
    """

    denoiser: DenoiserConfig
    zero_conv_steps: int = 0
    watch_every: int = 0
    thinnings: tuple[int, ...] = (1,)
    sigma_mean: float = -0.8
    sigma_std: float = 1.6

    @property
    def watches(self) -> bool:
        """Whether adherence to a condition is measured."""
        return bool(self.watch_every and self.denoiser.condition)

    def check(self, sensors: Iterable[Sensor]) -> None:
        """Raise `TrainingError` where scans of one of these sensors cannot be trained on so."""
        self.check_counts()
        cell = tuple(max(self.thinnings) * side for side in self.denoiser.cell)
        for sensor in sensors:
            if any(size % whole for size, whole in zip(sensor.shape, cell, strict=True)):
                raise TrainingError(f"{sensor.name} is {sensor.shape}; this recipe needs multiples of {cell}")


def train_denoiser(
    config: DenoisingConfig,
    source: PairSource,
    run: str | os.PathLike[str],
    *,
    begin: Denoiser | None = None,
    device: str = "cpu",
    max_minutes: float = float("inf"),
) -> Iterator[Report]:
    """Train a denoiser on pairs, from fresh weights, those of `begin` or of the base of `begin`; or, where it has a
    ControlNet, that alone, on a frozen base.

    What the folder `run` receives, and how a run goes on, is said at `training.loop.train`; the loss is also reported
    by bands of noise. Raises `TrainingError` as that does, and where the pairs or the device do not fit.
    """
    config.check(source.sensors)
    on = device_for_training(device)
    processes = Processes.from_environment(on)
    denoiser = _beginning(config, begin)
    watch = AdherenceWatch(source.sensor or Sensor.preset("hdl64e")) if config.watches else None

    def watched(step: int) -> Measures:
        if watch is None or step % config.watch_every:
            return {}
        measured = watch.measure(denoiser)
        watch.check(measured, step)
        return {name: torch.tensor(value) for name, value in measured.items()}

    def batches(start: int) -> Generator[Batch, None, None]:
        return prefetched(partial(_batch, config, source, processes), start)

    def loss(step: int, batch: Batch) -> tuple[Tensor, Measures]:
        if denoiser.controlnet is not None:
            denoiser.controlnet.learn(everything=step >= config.zero_conv_steps)
        clean, sigma, noise, rays, condition, wraps, skipped = batch
        with reduced_precision(on):
            seen = condition if config.denoiser.condition else None
            losses = denoiser.loss(clean, sigma, noise, rays, seen, wraps=bool(wraps))
        return losses, _by_band(sigma, losses.detach()) | watched(step) | {_SKIPPED: skipped}

    for report in train(config, denoiser, batches, loss, source, run, device=on, max_minutes=max_minutes):
        _check_zero_convs(denoiser, report.step)
        yield report


def _beginning(config: DenoisingConfig, begin: Denoiser | None) -> Denoiser:
    """The denoiser before its first step."""
    needed = config.denoiser
    base = dataclasses.replace(needed, condition=(), controlnet=False)
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(config.seed)
        if begin is None:
            if needed.controlnet:
                raise TrainingError("a ControlNet needs a base, which learned without a condition")
            return Denoiser.from_config(needed)
        if begin.config != needed:
            begin = begin.base()
        if begin.config == needed:
            return begin
        if begin.config != base:
            raise TrainingError(f"the weights to begin with are of a {begin.config}; this recipe needs a {needed}")
        return begin.with_controlnet(needed) if needed.controlnet else begin.with_condition(needed)


def _by_band(sigma: Tensor, losses: Tensor) -> Measures:
    return {
        f"loss, sigma {low:g} to {high:g}": losses[(low <= sigma) & (sigma < high)]
        for low, high in itertools.pairwise(BANDS)
    }


def _check_zero_convs(denoiser: Denoiser, step: int) -> None:
    """Stop a run that has gone wrong, in words, rather than let it go on for days."""
    if denoiser.controlnet is not None and step >= _SILENT:
        for name, conv in denoiser.controlnet.zero_convs():
            if not conv.weight.any():
                raise TrainingError(f"zero convolution {name!r} is still zero after {step} steps")


def _batch(config: DenoisingConfig, source: PairSource, processes: Processes, step: int) -> Batch:
    """Clean states, noise levels, noise, rays, conditions, whether columns wrap, and the share of the pairs that are
    skipped as they hold what is not finite, of this process in a step."""
    random = np.random.default_rng((config.seed, step))
    generator = torch.Generator().manual_seed(int(random.integers(2**62)))
    every = int(random.choice(config.thinnings))
    pairs = source.pairs(step, config.batch * every**2, processes)
    scans = scans_of_step(config.batch * every**2, pairs[0].scan.sensor)
    if every > 1:
        pairs = [Pair(*(thinned(image, every) for image in pair)) for pair in pairs]
    sensor = pairs[0].scan.sensor
    share = list(processes.share(scans))
    rays = torch.from_numpy(encode_rays(sensor))
    # The mirror image of staggered beams is another sensor. A state is not mirrored, as it is filled from the left.
    if random.random() < 0.5 and not any(sensor.azimuth_offsets):
        pairs, rays = [Pair(*map(_mirrored, pair)) for pair in pairs], rays.flip(-1)
    clean = torch.from_numpy(np.stack([encode_scan(pair.scan) for pair in pairs]))
    hidden = rays[HIDDEN].bool().numpy()
    conditions = [_condition(config, pair, hidden, (step, number)) for number, pair in zip(share, pairs, strict=True)]
    condition = torch.from_numpy(np.stack(conditions))
    sigma = training_levels(scans, generator, mean=config.sigma_mean, std=config.sigma_std)
    noise = torch.randn((scans, *clean.shape[1:]), generator=generator)
    kept = clean.isfinite().flatten(1).all(1) & condition.isfinite().flatten(1).all(1)
    if not kept.any():
        raise TrainingError(f"no pair of step {step + 1} is finite")
    skipped = (~kept).float().mean()
    wraps = torch.tensor(sensor.wraps)
    return clean[kept], sigma[share][kept], noise[share][kept], rays, condition[kept], wraps, skipped


def _condition(config: DenoisingConfig, pair: Pair, hidden: np.ndarray, scan: tuple[int, int]) -> np.ndarray:
    """Of a step's scan of that number, whichever process learns from it."""
    if not config.denoiser.condition:
        return np.zeros(0, dtype=np.float32)
    opening = None
    if config.denoiser.completes:
        opening = sample_opening(pair.condition_image, np.random.default_rng((config.seed, *scan))) & ~hidden
    return encode_condition(pair.condition_image, pair.simulated, opening)


def thinned(image: RangeImage, every: int) -> RangeImage:
    """Every `every`-th beam and column of an image, as a sensor with these alone would have it."""
    images = {name: getattr(image, name) for name in ("depth", "label", "instance", "intensity")}
    kept = {name: x[::every, ::every].copy() for name, x in images.items() if x is not None}
    return RangeImage.unchecked(_thinned_sensor(image.sensor, every), **kept)


@lru_cache(maxsize=64)
def _thinned_sensor(sensor: Sensor, every: int) -> Sensor:
    tables: dict[str, Any] = {name: value[::every] for name, value in vars(sensor).items() if isinstance(value, tuple)}
    return dataclasses.replace(sensor, **tables, columns=math.ceil(sensor.columns / every), model=None)


def _mirrored(image: RangeImage) -> RangeImage:
    """What is encoded of an image, its columns from the last to the first."""
    images = {name: getattr(image, name) for name in ("depth", "label", "instance", "intensity")}
    return RangeImage.unchecked(image.sensor, **{name: x[:, ::-1] for name, x in images.items() if x is not None})


def sample_opening(condition_image: RangeImage, rng: np.random.Generator) -> np.ndarray:
    """Pixels, bool [H, W], that a draft of the place of a condition image may leave open."""
    kinds, label = list(_SHARES), condition_image.label
    kind = rng.choice([*kinds, "everything"], p=[*_SHARES.values(), 1 - sum(_SHARES.values())])
    if kind == "everything":
        return np.ones(label.shape, dtype=bool)
    if kind == "filler":
        return np.isin(label, _FILLER)
    if kind == "sector":
        return _sector(label.shape, condition_image.sensor.azimuth_span, rng.uniform(*_SECTOR), rng)
    if kind == "all but a sector":
        return ~_sector(label.shape, condition_image.sensor.azimuth_span, rng.uniform(*_VIEW), rng)
    given = _THINGS if kind == "all but objects" else [*_THINGS, *_ROAD]
    stuff = [id for id in np.unique(label).tolist() if id not in (*given, *_FILLER) and rng.random() < _KEPT_STUFF]
    return ~np.isin(label, [*given, *stuff])


def _sector(shape: tuple[int, ...], span: float, width: float, rng: np.random.Generator) -> np.ndarray:
    """The columns of a sector `width` [rad] wide, anywhere in an image that spans `span` [rad], of which it is at most
    three quarters."""
    columns = max(round(shape[1] * min(width / span, 0.75)), 1)
    inside = (np.arange(shape[1]) + rng.integers(shape[1])) % shape[1] < columns
    return np.broadcast_to(inside, shape)
