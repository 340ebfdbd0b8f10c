"""The receiver for single rays of a recorded scan: drop, noise, and intensities on the scan's own scale."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lidardraft.scene.effects import observe
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.raycast import Hits
from lidardraft.scene.sensor import Sensor
from lidardraft.scene.sensor_model import SensorModel
from lidardraft.scene.surfaces import Surfaces
from lidardraft.simulation.recorded.recorded_scan import RECORDED, RecordedScan

_ROAD = Primitive(shape="plane", center=(0.0, 0.0, 0.0), size=(1.0, 1.0, 0.0), label="road", id="road")
_JUDGED = (4.0, 30.0)  # m: ground whose intensities set the scale
_MOST_JUDGED = 2000
_SHARE = 0.9  # of them; paint and retroreflectors are brighter
_LARGEST_GAIN = 10.0


@dataclass(frozen=True)
class RayReceiver:
    """`sensor` with a model in which a beam is one ray; `gain` brings its intensities to those of a scan."""

    sensor: Sensor
    model: SensorModel
    gain: float = 1.0

    @classmethod
    def of_scan(cls, scan: RecordedScan) -> RayReceiver:
        """The receiver of a scan's sensor; its readings of a road have the mean of the scan's ground."""
        receiver = cls(scan.sensor, _of_one_beam(scan.sensor.assumed_model))
        low, high = _JUDGED
        ground = np.flatnonzero(scan.is_ground & (scan.made_up == RECORDED))
        ground = ground[(scan.distance[ground] > low) & (scan.distance[ground] < high)]
        ground = ground[:: max(1, len(ground) // _MOST_JUDGED)]
        incidence = np.abs(scan.directions[ground, 2])
        depth, read = receiver._reported(
            scan.distance[ground], np.zeros(len(ground), np.int32), incidence, Surfaces.from_layout(Layout((_ROAD,))), 0
        )
        usual, recorded = _usual(read[depth > 0]), _usual(scan.intensity[ground])
        return replace(receiver, gain=min(recorded / usual, _LARGEST_GAIN) if usual > 0 else 1.0)

    def report(self, hits: Hits, surfaces: Surfaces, seed: int) -> tuple[np.ndarray, np.ndarray]:
        """Range f32 [R] [m], 0 without a report, and intensity f32 [R] of the hits of rays."""
        lengths = np.linalg.norm(hits.directions, axis=1)
        incidence = np.abs(np.einsum("ni,ni->n", hits.normal, hits.directions)) / lengths
        depth, intensity = self._reported(hits.distance, hits.primitive, incidence, surfaces, seed)
        return depth, np.minimum(self.gain * intensity, np.float32(1.0))

    def _reported(
        self, distance: np.ndarray, primitive: np.ndarray, incidence: np.ndarray, surfaces: Surfaces, seed: int
    ) -> tuple[np.ndarray, np.ndarray]:
        count = len(distance)
        if not count:
            return np.zeros(0, np.float32), np.zeros(0, np.float32)
        # the rays lie in one row, as far apart as they are in the sensor's
        step = self.sensor.azimuth_span / self.sensor.columns
        row = replace(
            self.sensor, elevations=(0.0,), azimuth_offsets=(), origin_forwards=(), origin_lefts=(), origin_heights=(),
            columns=count, azimuth_span=min(count * step, math.tau), blocked=(), model=None,
        )  # fmt: skip
        images: dict[str, np.ndarray] = {
            "depth": distance.astype(np.float32)[None],
            "label": np.zeros((1, count), np.uint8),
            "instance": np.zeros((1, count), np.uint32),
            "incidence": incidence.astype(np.float32)[None],
            "primitive": primitive.astype(np.int32)[None],
        }
        seen = observe(RangeImage.unchecked(row, **images), surfaces, seed=seed, model=self.model)
        assert seen.intensity is not None
        return seen.depth[0], seen.intensity[0]


def _of_one_beam(model: SensorModel) -> SensorModel:
    """The model of a typical beam: tables of beams become their means, and all beams are alike."""
    curve = model.intensity_curve
    if curve is not None:
        tables = {name: getattr(curve, name) for name in ("readings", "distance_gains") if getattr(curve, name)}
        means: dict[str, Any] = {name: (tuple(np.mean(table, axis=0).tolist()),) for name, table in tables.items()}
        curve = replace(curve, **means, cutoffs=(float(np.mean(curve.cutoffs)),) if curve.cutoffs else ())
    return replace(
        model, rays_per_beam=1, range_offsets=(), offset_spread=0.0, gain_spread=0.0, tilt_spread=0.0,
        cutoff_spread=0.0, intensity_curve=curve,
    )  # fmt: skip


def _usual(intensity: np.ndarray) -> float:
    """The mean of all but the brightest; 0 without any."""
    kept = np.sort(intensity)[: math.ceil(_SHARE * len(intensity))]
    return float(kept.mean()) if len(kept) else 0.0
