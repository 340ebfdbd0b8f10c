"""Pairs from several sources, each step's from one of them."""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lidardraft.errors import TrainingError
from lidardraft.scene.sensor import Sensor
from lidardraft.training.denoising import PairSource
from lidardraft.training.pairs import Pair
from lidardraft.training.processes import ALONE, Processes

_CHOICE_STREAM = 5  # random numbers that choose a source


@dataclass(frozen=True)
class MixedSource:
    """Sources, each with how often it is drawn from, in shares of the sum of all."""

    sources: tuple[PairSource, ...]
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

    def pairs(self, step: int, scans: int, processes: Processes = ALONE) -> list[Pair]:
        """Those of one source, drawn by the weights: the same for a step."""
        shares = np.array(self.weights) / sum(self.weights)
        chosen = np.random.default_rng([step, _CHOICE_STREAM]).choice(len(self.sources), p=shares)
        return self.sources[int(chosen)].pairs(step, scans, processes)
