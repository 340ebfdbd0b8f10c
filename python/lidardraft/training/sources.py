"""Sources of pairs: folders, held in memory; streets, made as needed or in the background by worker processes; mixtures
of these."""

from __future__ import annotations

import math
import os
import threading
import time
import warnings
import zlib
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any, Generic, TypeVar

import numpy as np
import torch
from torch import Tensor

from lidardraft.errors import TrainingError
from lidardraft.formats.pairs import IMAGES, Pair, PairIndex
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.sensor import Sensor
from lidardraft.streets import StreetConfig, StreetPair, streets
from lidardraft.training.processes import ALONE, Processes
from lidardraft.training.sampled_sensor import sample_sensor
from lidardraft.training.stack import PairStack, as_tensors

CPU = torch.device("cpu")
_POSES = 2  # of a street: a network learns more from another street than from another view of one
_POSES_MEANWHILE = 4  # of a street that workers make: the higher rate of pairs is worth more
_MOST = 16_000  # pairs kept in a bank
_LEAST = 16  # batches' worth of pairs in a bank before the first step
_SENSOR_STREAM = 11  # random numbers of a step's sensor
_CHOICE_STREAM = 5  # random numbers that choose a source
_MEMINFO = Path("/proc/meminfo")  # of Linux; other systems are not asked
_PIXELS = 64 * 1024  # of the images that memory is counted in
_PAIR_BYTES = sum(np.dtype(dtype).itemsize for dtype in IMAGES.values())  # a pixel


class PairSource:
    """A source of training pairs.

    `source` describes their origin, `path` is their place; `checksum` covers everything that decides them. `sensors`
    are those known before the training begins; `sensor` is that of all pairs, None if there are several.
    """

    def __init__(self, sensor: Sensor | None, source: str, checksum: int, path: Path = Path("streets")) -> None:
        self.sensor, self.source, self.checksum, self.path = sensor, source, checksum, path
        self.sensors: tuple[Sensor, ...] = () if sensor is None else (sensor,)

    @contextmanager
    def running(self, processes: Processes, device: torch.device) -> Iterator[None]:
        """A context in which pairs can be requested."""
        del processes, device
        yield

    def stack(self, step: int, scans: int, processes: Processes = ALONE, device: torch.device = CPU) -> PairStack:
        """The pairs of a step, of one sensor, as many as `scans` of 64 x 1024 are worth; with several processes, those
        of this one. The stack is on the device."""
        raise NotImplementedError


class PairFolder(PairSource):
    """The pairs of a prepared folder, held in memory: 0.46 MB for each pair of 64 x 1024.

    `folder[i]` is a `Pair` with depth to the millimetre and intensity, as `Pair.from_compact` gives it. `notes[i]` is
    its note, `checksum` that of all images. Raises `FormatError` naming a file that is missing, truncated or not from
    lidardraft.
    """

    sensor: Sensor

    def __init__(self, directory: str | os.PathLike[str]) -> None:
        folder = Path(directory)
        index = PairIndex.load(folder)
        checksum = zlib.crc32(index.sensor.to_json().encode())
        total, shape = sum(index.counts), index.sensor.shape
        needed, free = total * math.prod(shape) * _PAIR_BYTES, free_memory()
        if free is not None and needed > free:
            there = f"{needed / 1e9:.1f} GB of memory; {free / 1e9:.1f} GB are free"
            raise TrainingError(f"{folder} with its {total} pairs needs {there}")
        images = {name: np.empty((total, *shape), dtype) for name, dtype in IMAGES.items()}
        self.notes: list[dict[str, Any]] = []
        for number, count in enumerate(index.counts):
            shard, notes = index.shard(number)
            for name, rows in shard.items():
                images[name][len(self.notes) : len(self.notes) + count] = rows
                checksum = zlib.crc32(rows.tobytes(), checksum)
            self.notes += notes
        super().__init__(index.sensor, index.source, checksum, folder.resolve())
        self._images, self._tensors, self._placed = images, as_tensors(images), CPU

    def __len__(self) -> int:
        return len(self.notes)

    def __getitem__(self, i: int) -> Pair:
        return Pair.from_compact(self.sensor, {name: images[i] for name, images in self._images.items()})

    def stack(self, step: int, scans: int, processes: Processes = ALONE, device: torch.device = CPU) -> PairStack:
        """Pairs drawn at random, the same for a step (`PairSource.stack`). They are moved to a device once, if they fit
        there; else each batch is, with a `UserWarning`."""
        if self._placed != device:
            self._tensors, self._placed = placed(self._tensors, device), device
        drawn = np.random.default_rng([self.checksum, step]).integers(len(self), size=scans_of_step(scans, self.sensor))
        return PairStack.of_rows(self.sensor, self._tensors, drawn[list(processes.share(len(drawn)))], device)


class StreetSource(PairSource):
    """The streets of a seed, scanned by `sensor`, or by another one at each step (`sample_sensor`)."""

    def __init__(self, *, seed: int = 0, sensor: Sensor | None = None) -> None:
        seen_by = "sensors drawn at random" if sensor is None else sensor.name
        decisive = [seed, None if sensor is None else sensor.to_json()]
        super().__init__(sensor, f"streets of seed {seed}, {seen_by}", zlib.crc32(repr(decisive).encode()))
        self.seed = seed

    def stack(self, step: int, scans: int, processes: Processes = ALONE, device: torch.device = CPU) -> PairStack:
        """Pairs of one sensor, the same for a step (`PairSource.stack`)."""
        sensor = self.sensor or sample_sensor(np.random.default_rng([self.seed, step, _SENSOR_STREAM]))
        config = StreetConfig(sensor=sensor, poses_per_street=_POSES)
        pairs = []
        for number in processes.share(scans_of_step(scans, sensor)):
            pair = next(streets(seed=self.seed, config=config, start=step * scans + number))
            pairs.append(Pair(pair.scan, self.condition_image(pair)).compact())
        images = as_tensors({name: np.stack([pair[name] for pair in pairs]) for name in IMAGES})
        return PairStack.of(sensor, {name: rows.to(device) for name, rows in images.items()})

    def condition_image(self, pair: StreetPair) -> RangeImage:
        """The condition image to learn from: the cast of the layout."""
        return pair.condition_image


class StreetBank(PairSource):
    """The newest pairs of the streets of a seed, made by `workers` processes and held on the training device. It is for
    devices that learn faster than streets are made.

    A step draws from the pairs made so far, so a run is not reproducible, nor is a run in slices equal to one without.
    `running` starts the processes and ends them.
    """

    sensor: Sensor

    def __init__(self, seed: int, sensor: Sensor, workers: int) -> None:
        super().__init__(sensor, f"streets of seed {seed}, {sensor.name}, made meanwhile", seed)
        self.seed, self.workers, self.made = seed, workers, 0
        self._images: dict[str, Tensor] = {}
        self._lock, self._ended = threading.Lock(), threading.Event()
        self._filling: Future[None] | None = None

    @contextmanager
    def running(self, processes: Processes, device: torch.device) -> Iterator[None]:
        """A context in which worker processes make the share of this one of several `processes`."""
        pair = _PAIR_BYTES * math.prod(self.sensor.shape)
        free = free_memory(device)
        kept = _MOST if free is None else min(_MOST, free // 2 // pair)
        if kept < 1:
            raise TrainingError(f"{device} has no room for pairs of {self.sensor.name}, of {pair / 1e6:.1f} MB each")
        empty = {name: np.zeros((1, *self.sensor.shape), dtype) for name, dtype in IMAGES.items()}
        self._images = {
            name: rows.new_zeros((kept, *self.sensor.shape), device=device) for name, rows in as_tensors(empty).items()
        }
        self.made = 0
        self._ended.clear()
        with ThreadPoolExecutor(1) as thread:
            self._filling = thread.submit(self._fill, kept, processes)
            try:
                yield
            finally:
                self._ended.set()

    def _fill(self, kept: int, processes: Processes) -> None:
        config = StreetConfig(sensor=self.sensor, poses_per_street=_POSES_MEANWHILE)
        shard = (processes.rank, processes.count)
        with closing(streets(seed=self.seed, config=config, shard=shard, workers=self.workers)) as made:
            for pair in made:
                if self._ended.is_set():
                    return
                images = as_tensors(Pair(pair.scan, pair.condition_image).compact())
                with self._lock:
                    for name, image in images.items():
                        self._images[name][self.made % kept].copy_(image)
                    self.made += 1

    def stack(self, step: int, scans: int, processes: Processes = ALONE, device: torch.device = CPU) -> PairStack:
        """Pairs drawn at random from those made so far (`PairSource.stack`)."""
        assert self._filling is not None, "the bank is not running"
        count = len(processes.share(scans_of_step(scans, self.sensor)))
        kept = len(self._images["scan_label"])
        while self.made < min(_LEAST * count, kept):
            if self._filling.done():
                self._filling.result()  # raises the error that ended it
            time.sleep(0.05)
        with self._lock:
            drawn = np.random.default_rng([self.seed, step, processes.rank]).integers(min(self.made, kept), size=count)
            return PairStack.of_rows(self.sensor, self._images, drawn, device)


SourceT = TypeVar("SourceT", bound=PairSource)


class MixedSource(PairSource, Generic[SourceT]):
    """Several sources, each drawn in proportion to its weight."""

    def __init__(self, sources: tuple[SourceT, ...], weights: tuple[float, ...]) -> None:
        if not sources:
            raise TrainingError("there are no pairs to learn from")
        if not all(0 < weight < float("inf") for weight in weights):
            raise TrainingError(f"the weights of the sources are {weights}; they must be positive numbers")
        self.sources, self.weights = sources, weights
        self.shares = np.array(weights) / sum(weights)
        words = (f"{share:.0%} {source.source}" for source, share in zip(sources, self.shares, strict=True))
        decisive = [(source.checksum, weight) for source, weight in zip(sources, weights, strict=True)]
        sensor = sources[0].sensor if len({source.sensor for source in sources}) == 1 else None
        super().__init__(sensor, "; ".join(words), zlib.crc32(repr(decisive).encode()), sources[0].path)
        self.sensors = tuple(sensor for source in sources for sensor in source.sensors)

    def draw(self, random: np.random.Generator) -> SourceT:
        """A source, drawn by the weights."""
        return self.sources[int(random.choice(len(self.sources), p=self.shares))]

    def stack(self, step: int, scans: int, processes: Processes = ALONE, device: torch.device = CPU) -> PairStack:
        """The pairs of one source, the same for a step."""
        return self.draw(np.random.default_rng([step, _CHOICE_STREAM])).stack(step, scans, processes, device)


def scans_of_step(scans: int, sensor: Sensor) -> int:
    """The number of scans of a sensor in a step that has room for `scans` of 64 x 1024."""
    return max(1, min(scans, scans * _PIXELS // math.prod(sensor.shape)))


def placed(images: dict[str, Tensor], device: torch.device) -> dict[str, Tensor]:
    """The images on a GPU if they fit in half of its free memory; else in pinned memory of the host."""
    needed, free = sum(rows.nbytes for rows in images.values()), free_memory(device)
    if device.type != "cuda" or free is None:
        return images
    if needed < free / 2:
        return {name: rows.to(device) for name, rows in images.items()}
    held = f"the pairs take {needed / 1e9:.1f} GB, and {device} has {free / 1e9:.1f} GB free"
    warnings.warn(f"{held}: they stay in the memory of the host, which is slower", stacklevel=3)
    return {name: rows.pin_memory() for name, rows in images.items()}


def free_memory(device: torch.device = CPU) -> int | None:
    """The bytes available on a device, without swapping; None if the system does not tell."""
    if device.type == "cuda":
        return torch.cuda.mem_get_info(device)[0]
    try:
        lines = _MEMINFO.read_text().splitlines()
    except OSError:
        return None
    return next((1024 * int(line.split()[1]) for line in lines if line.startswith("MemAvailable:")), None)
