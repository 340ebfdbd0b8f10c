"""A folder of pairs, held in memory to draw from at random."""

from __future__ import annotations

import math
import os
import zlib
from pathlib import Path
from typing import Any

import numpy as np

from lidardraft.errors import TrainingError
from lidardraft.formats.pairs import IMAGES, Pair, PairIndex
from lidardraft.scene.sensor import Sensor
from lidardraft.training.processes import ALONE, Processes

_MEMINFO = Path("/proc/meminfo")  # of Linux; other systems say it elsewhere, and are not asked
_PIXELS = 64 * 1024  # of the images that memory is counted in
_PAIR_BYTES = sum(np.dtype(dtype).itemsize for dtype in IMAGES.values())  # a pixel


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
        check_memory(f"{folder} with its {total} pairs", total * math.prod(shape) * _PAIR_BYTES)
        self._images = {name: np.empty((total, *shape), dtype) for name, dtype in IMAGES.items()}
        self.notes: list[dict[str, Any]] = []
        for number, count in enumerate(index.counts):
            shard, notes = index.shard(number)
            for name, images in shard.items():
                self._images[name][len(self.notes) : len(self.notes) + count] = images
                self.checksum = zlib.crc32(images.tobytes(), self.checksum)
            self.notes += notes

    def __len__(self) -> int:
        return len(self.notes)

    @property
    def sensors(self) -> tuple[Sensor, ...]:
        """The one of all pairs."""
        return (self.sensor,)

    def pairs(self, step: int, scans: int, processes: Processes = ALONE) -> list[Pair]:
        """Pairs drawn at random, as many as `scans` of 64 x 1024 are worth: the same for a step; of several processes,
        this one's."""
        drawn = np.random.default_rng([self.checksum, step]).integers(len(self), size=scans_of_step(scans, self.sensor))
        return [self[int(drawn[number])] for number in processes.share(len(drawn))]

    def __getitem__(self, i: int) -> Pair:
        return Pair.from_compact(self.sensor, {name: images[i] for name, images in self._images.items()})


def scans_of_step(scans: int, sensor: Sensor) -> int:
    """How many scans of a sensor a step learns from that has room for so many of 64 x 1024."""
    return max(1, min(scans, scans * _PIXELS // math.prod(sensor.shape)))


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
