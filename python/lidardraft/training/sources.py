"""Where pairs come from: folders, held in memory; streets that are made while a network trains; mixtures of both."""

from __future__ import annotations

import json
import math
import os
import warnings
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, Protocol, TypeVar

import numpy as np
import torch
from torch import Tensor

from lidardraft.errors import TrainingError
from lidardraft.formats.pairs import IMAGES, Pair, PairIndex
from lidardraft.scene.layout import Layout
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.raycast import Raycaster
from lidardraft.scene.sensor import Sensor
from lidardraft.streets import StreetConfig, streets
from lidardraft.training.loop import Data
from lidardraft.training.processes import ALONE, Processes
from lidardraft.training.sampled_sensor import sample_sensor
from lidardraft.training.stack import PairStack, as_tensors

CPU = torch.device("cpu")
_POSES = 2  # of a street: a network learns more from another street than from another look at one
_SENSOR_STREAM = 11  # random numbers of a step's sensor
NEAR, FAR = 2.0, 80.0  # m from the sensor along the ground: the lowest row and the highest of a top view
_CEILING = 12.0  # m over the sensor's origin: what is higher counts as that high
_HIGH = 200.0  # m over the sensor's origin, where the rays start
_CHOICE_STREAM = 5  # random numbers that choose a source
_MEMINFO = Path("/proc/meminfo")  # of Linux; other systems say it elsewhere, and are not asked
_PIXELS = 64 * 1024  # of the images that memory is counted in
PAIR_BYTES = sum(np.dtype(dtype).itemsize for dtype in IMAGES.values())  # a pixel


class PairSource(Data, Protocol):
    """Pairs to learn from, on disk (`PairFolder`) or made as they are asked for (`StreetSource`)."""

    @property
    def sensor(self) -> Sensor | None:
        """The sensor of all pairs, None where they are of many."""

    @property
    def sensors(self) -> tuple[Sensor, ...]:
        """Those that are known before the training begins."""

    def stack(self, step: int, scans: int, processes: Processes, device: torch.device) -> PairStack:
        """Those of a step, of one sensor, as many as `scans` of 64 x 1024 are worth; of several processes, this one's.
        The stack is on the device."""


class PairFolder:
    """The pairs of a prepared folder, held in memory: 0.66 MB for each pair of 64 x 1024.

    `folder[i]` is a `Pair` with depth to the millimetre and intensity, as `Pair.from_compact` gives it. `notes[i]` is
    what was noted of it, `checksum` that of all images. Raises `FormatError` naming the file that is missing, truncated
    or not ours.
    """

    def __init__(self, directory: str | os.PathLike[str]) -> None:
        folder = Path(directory)
        index = PairIndex.load(folder)
        self.sensor, self.source = index.sensor, index.source
        self.path = folder.resolve()
        self.checksum = zlib.crc32(self.sensor.to_json().encode())
        total, shape = sum(index.counts), self.sensor.shape
        check_memory(f"{folder} with its {total} pairs", total * math.prod(shape) * PAIR_BYTES)
        images = {name: np.empty((total, *shape), dtype) for name, dtype in IMAGES.items()}
        self.notes: list[dict[str, Any]] = []
        for number, count in enumerate(index.counts):
            shard, notes = index.shard(number)
            for name, rows in shard.items():
                images[name][len(self.notes) : len(self.notes) + count] = rows
                self.checksum = zlib.crc32(rows.tobytes(), self.checksum)
            self.notes += notes
        self._images, self._tensors, self._placed = images, as_tensors(images), CPU

    def __len__(self) -> int:
        return len(self.notes)

    @property
    def sensors(self) -> tuple[Sensor, ...]:
        """The one of all pairs."""
        return (self.sensor,)

    def stack(self, step: int, scans: int, processes: Processes = ALONE, device: torch.device = CPU) -> PairStack:
        """Pairs drawn at random, the same for a step (`PairSource.stack`). They are moved to a device once, if they fit
        there; else each batch is, and a `UserWarning` says so."""
        if self._placed != device:
            self._tensors, self._placed = placed(self._tensors, device), device
        drawn = np.random.default_rng([self.checksum, step]).integers(len(self), size=scans_of_step(scans, self.sensor))
        mine = torch.from_numpy(drawn[list(processes.share(len(drawn)))])
        at = mine.to(self._tensors["scan_label"].device)
        images = {name: rows[at].to(device, non_blocking=True) for name, rows in self._tensors.items()}
        return PairStack.of(self.sensor, images)

    def __getitem__(self, i: int) -> Pair:
        return Pair.from_compact(self.sensor, {name: images[i] for name, images in self._images.items()})


def scans_of_step(scans: int, sensor: Sensor) -> int:
    """How many scans of a sensor a step learns from that has room for so many of 64 x 1024."""
    return max(1, min(scans, scans * _PIXELS // math.prod(sensor.shape)))


def placed(images: dict[str, Tensor], device: torch.device) -> dict[str, Tensor]:
    """The images on a GPU if half of its free memory holds them; else in memory that it can read from."""
    if device.type != "cuda":
        return images
    needed, free = sum(rows.nbytes for rows in images.values()), torch.cuda.mem_get_info(device)[0]
    if needed < free / 2:
        return {name: rows.to(device) for name, rows in images.items()}
    held = f"the pairs take {needed / 1e9:.1f} GB, and {device} has {free / 1e9:.1f} GB free"
    warnings.warn(f"{held}: they stay in the memory of the host, which is slower", stacklevel=3)
    return {name: rows.pin_memory() for name, rows in images.items()}


def check_memory(what: str, needed: int) -> None:
    """Raise `TrainingError` where `what` needs more bytes than are free."""
    free = free_memory()
    if free is not None and needed > free:
        raise TrainingError(f"{what} needs {needed / 1e9:.1f} GB of memory; {free / 1e9:.1f} GB are free")


def free_memory() -> int | None:
    """Bytes that can be had without swapping; None where the system does not say."""
    try:
        lines = _MEMINFO.read_text().splitlines()
    except OSError:
        return None
    found = [line.split()[1] for line in lines if line.startswith("MemAvailable:")]
    return 1024 * int(found[0]) if found else None


@dataclass(frozen=True, kw_only=True)
class StreetSource:
    """The streets of a seed, seen by `sensor`, or by another one at each step (`sample_sensor`).

    With `from_above` the layout's top view stands in for its cast (`top_view`).
    """

    seed: int = 0
    sensor: Sensor | None = None
    from_above: bool = False
    path: Path = Path("streets")

    @property
    def sensors(self) -> tuple[Sensor, ...]:
        """The one that is given."""
        return () if self.sensor is None else (self.sensor,)

    @property
    def source(self) -> str:
        """Where the pairs come from, in words."""
        seen_by = "sensors drawn at random" if self.sensor is None else self.sensor.name
        return f"streets of seed {self.seed}, {seen_by}{', layouts from above' * self.from_above}"

    @property
    def checksum(self) -> int:
        """Of all that decides the pairs."""
        fields: dict[str, object] = {
            "seed": self.seed,
            "sensor": None if self.sensor is None else self.sensor.to_json(),
        }
        if self.from_above:
            fields["from_above"] = True
        return zlib.crc32(json.dumps(fields).encode())

    def stack(self, step: int, scans: int, processes: Processes = ALONE, device: torch.device = CPU) -> PairStack:
        """Pairs of one sensor, the same for a step (`PairSource.stack`)."""
        sensor = self.sensor or sample_sensor(np.random.default_rng([self.seed, step, _SENSOR_STREAM]))
        config = StreetConfig(sensor=sensor, poses_per_street=_POSES, simulated=True)
        pairs = []
        for number in processes.share(scans_of_step(scans, sensor)):
            pair = next(streets(seed=self.seed, config=config, start=step * scans + number))
            assert pair.simulated is not None
            image = top_view(pair.layout, sensor, pair.pose) if self.from_above else pair.condition_image
            pairs.append(Pair(pair.scan, image, pair.simulated).compact())
        images = as_tensors({name: np.stack([pair[name] for pair in pairs]) for name in IMAGES})
        return PairStack.of(sensor, {name: rows.to(device) for name, rows in images.items()})


SourceT = TypeVar("SourceT", bound=PairSource)


@dataclass(frozen=True)
class MixedSource(Generic[SourceT]):
    """Sources, each with how often it is drawn from, in shares of the sum of all."""

    sources: tuple[SourceT, ...]
    weights: tuple[float, ...]

    def __post_init__(self) -> None:
        if not self.sources:
            raise TrainingError("there are no pairs to learn from")
        if not all(0 < weight < float("inf") for weight in self.weights):
            raise TrainingError(f"the weights of the sources are {self.weights}; they must be positive numbers")

    @property
    def sensor(self) -> Sensor | None:
        """That of all sources, None where they differ."""
        sensors = [source.sensor for source in self.sources]
        return sensors[0] if all(sensor == sensors[0] for sensor in sensors) else None

    @property
    def sensors(self) -> tuple[Sensor, ...]:
        """Those of all sources."""
        return tuple(sensor for source in self.sources for sensor in source.sensors)

    @property
    def source(self) -> str:
        """Where the pairs come from, in words."""
        return "; ".join(
            f"{weight / sum(self.weights):.0%} {source.source}"
            for source, weight in zip(self.sources, self.weights, strict=True)
        )

    @property
    def path(self) -> Path:
        """Of the first source."""
        return self.sources[0].path

    @property
    def checksum(self) -> int:
        """Of all sources and their weights."""
        fields = [(source.checksum, weight) for source, weight in zip(self.sources, self.weights, strict=True)]
        return zlib.crc32(repr(fields).encode())

    def draw(self, random: np.random.Generator) -> SourceT:
        """A source, drawn by the weights."""
        shares = np.array(self.weights) / sum(self.weights)
        return self.sources[int(random.choice(len(self.sources), p=shares))]

    def stack(self, step: int, scans: int, processes: Processes = ALONE, device: torch.device = CPU) -> PairStack:
        """Those of one source: the same for a step."""
        return self.draw(np.random.default_rng([step, _CHOICE_STREAM])).stack(step, scans, processes, device)


def top_view(layout: Layout, sensor: Sensor, pose: np.ndarray) -> RangeImage:
    """What a layout shows from above around a sensor at world_from_sensor `pose` [4, 4], in images of its shape.

    A pixel looks straight down at a place of its own: its column's azimuth is the sensor's, and rows are the farther
    the higher, in equal ratios from 2 to 80 m. `depth` is how far below a ceiling of 12 m the surface is, `label` its
    class. The paper does not say how it projects; azimuths that agree with those of the scan are the best case for it.
    """
    rows, columns = sensor.shape
    azimuth = sensor.azimuth_start - (np.arange(columns) + 0.5) * sensor.azimuth_span / columns
    azimuth = azimuth + np.arctan2(pose[1, 0], pose[0, 0])
    distance = np.geomspace(FAR, NEAR, rows)[:, None]
    origins = np.empty((rows, columns, 3))
    origins[..., 0] = pose[0, 3] + distance * np.cos(azimuth)
    origins[..., 1] = pose[1, 3] + distance * np.sin(azimuth)
    origins[..., 2] = pose[2, 3] + _HIGH
    down = np.broadcast_to((0.0, 0.0, -1.0), (rows * columns, 3))
    hits = Raycaster(layout).cast(origins.reshape(-1, 3), down)
    depth = np.where(hits.valid, np.maximum(hits.distance - (_HIGH - _CEILING), 0.1), 0)
    return RangeImage(
        sensor=sensor,
        depth=depth.reshape(sensor.shape).astype(np.float32),
        label=hits.label.reshape(sensor.shape),
        instance=hits.instance.reshape(sensor.shape),
    )
