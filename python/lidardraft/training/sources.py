"""Where pairs come from that no folder holds: streets made while a network trains, and mixtures of sources."""

from __future__ import annotations

import json
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, TypeVar

import numpy as np

from lidardraft.errors import TrainingError
from lidardraft.formats.pairs import Pair
from lidardraft.scene.layout import Layout
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.raycast import Raycaster
from lidardraft.scene.sensor import Sensor
from lidardraft.streets import StreetConfig, streets
from lidardraft.training.denoising import PairSource
from lidardraft.training.pairs import scans_of_step
from lidardraft.training.processes import ALONE, Processes
from lidardraft.training.sampled_sensor import sample_sensor

_POSES = 2  # of a street: a network learns more from another street than from another look at one
_SENSOR_STREAM = 11  # random numbers of a step's sensor
NEAR, FAR = 2.0, 80.0  # m from the sensor along the ground: the lowest row and the highest of a top view
_CEILING = 12.0  # m over the sensor's origin: what is higher counts as that high
_HIGH = 200.0  # m over the sensor's origin, where the rays start
_CHOICE_STREAM = 5  # random numbers that choose a source


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

    def pairs(self, step: int, scans: int, processes: Processes = ALONE) -> list[Pair]:
        """Pairs of one sensor, as many as `scans` of 64 x 1024 are worth: the same for a step; of several processes,
        this one's."""
        sensor = self.sensor or sample_sensor(np.random.default_rng([self.seed, step, _SENSOR_STREAM]))
        config = StreetConfig(sensor=sensor, poses_per_street=_POSES, simulated=True)
        pairs = []
        for number in processes.share(scans_of_step(scans, sensor)):
            pair = next(streets(self.seed, config, start=step * scans + number))
            assert pair.simulated is not None
            image = top_view(pair.layout, sensor, pair.pose) if self.from_above else pair.condition_image
            pairs.append(Pair(pair.scan, image, pair.simulated))
        return pairs


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

    def pairs(self, step: int, scans: int, processes: Processes = ALONE) -> list[Pair]:
        """Those of one source: the same for a step."""
        return self.draw(np.random.default_rng([step, _CHOICE_STREAM])).pairs(step, scans, processes)


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
