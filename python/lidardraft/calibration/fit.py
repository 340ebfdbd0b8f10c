"""A sensor fitted to its recordings: lasers, vehicle, receiver and intensity; and a report of
streets' distances, before and after the fit, from scans that it was not fitted to."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from lidardraft.calibration.beam_table import BeamTable, fit_beam_table, fit_blocked, fit_range_offsets
from lidardraft.calibration.intensity import Readings, fit_intensity
from lidardraft.calibration.receiver import fit_receiver, fit_speckle, fit_texture
from lidardraft.calibration.street_casts import StreetCasts, with_rays_that_fit
from lidardraft.errors import FormatError
from lidardraft.formats.recording import Recording
from lidardraft.metrics import lifelike
from lidardraft.metrics.lifelike import Property
from lidardraft.metrics.profiles import road_level
from lidardraft.metrics.sweep import Sweep
from lidardraft.scene.sensor import Sensor
from lidardraft.scene.sensor_model import SensorModel

_MOST_COLUMNS = 1024  # of sweeps compared with streets; more take time and add no information
STREETS = 32
_LAST, _MANY = 0.95, 15  # so many returns in the last twentieth of all ranges show a limit
SEED = 3_000_000  # not the streets of training, nor those of the reports that judge a fit
JUDGING_SEED = 4_000_000


@dataclass(frozen=True)
class Fit:
    """The fitted `sensor` with its model, its `table`, and the residual of intensities (of 1; NaN without any)."""

    sensor: Sensor
    table: BeamTable
    intensity_residual: float


def fit_sensor(
    recordings: Sequence[Recording],
    name: str,
    *,
    like: Sensor | None = None,
    columns: int | None = None,
    num_streets: int = STREETS,
) -> Fit:
    """The sensor that took `recordings`, called `name`.

    Properties that no recording shows (divergence, return mode, time of a sweep) are those of `like`, or typical.
    `columns` are by default the firings of a turn or up to three fewer: in fours, for the packaged network. Raises
    `FormatError` without anything to fit to.
    """
    table = fit_beam_table(recordings)
    columns = columns or max(table.columns // 4 * 4, 4)
    recorded = sweeps_of(recordings, table, columns)
    sensor = _geometry(name, table, recorded, like or Sensor(name=name, elevations=(0.0,), columns=1))
    typical = (like or sensor).assumed_model
    # the lasers are known, one by one
    known = replace(
        typical,
        range_offsets=tuple(fit_range_offsets(recorded, table).tolist()),
        offset_spread=0.0,
        tilt_spread=0.0,
        gain_spread=0.0,
        intensity_curve=None,
        cutoff=0.0,
        cutoff_spread=0.0,
    )
    model = with_rays_that_fit(sensor, known)
    casts = StreetCasts.from_sensor(sensor, model, num_streets, seed=SEED)
    model, sigma = fit_receiver(recorded, casts, model)
    left = math.nan
    if all(sweep.intensity is not None for sweep in recorded):
        model, left = _with_intensity(recorded, casts, model, sigma)
    return Fit(replace(sensor, columns=columns, range_sigma=sigma, model=model), table, left)


def _with_intensity(
    recorded: Sequence[Sweep], casts: StreetCasts, model: SensorModel, sigma: float
) -> tuple[SensorModel, float]:
    """The model with its texture, intensity curve and speckle, and the residual between the quantiles."""

    readings = Readings.from_sweeps(recorded)

    def with_texture(texture: float) -> SensorModel:
        scattered = replace(model, texture=texture)
        found = fit_intensity(readings, casts.responses(scattered, sigma))
        residuals[texture] = found.residual
        return replace(scattered, compensation_range=math.inf, intensity_curve=found.curve)

    residuals: dict[float, float] = {}
    model = fit_texture(recorded, casts, with_texture, sigma, otherwise=model.texture)
    return fit_speckle(recorded, casts, model, sigma), residuals[model.texture]


def sweeps_of(recordings: Sequence[Recording], table: BeamTable, columns: int) -> list[Sweep]:
    """The scans as sweeps, with rows in the order of a table's lasers and `columns`, up to 1024."""
    columns = min(columns, _MOST_COLUMNS)
    return [
        Sweep.from_points(
            one.points,
            table.rows(one),
            height=len(table.rings),
            columns=columns,
            label=one.label,
            intensity=one.intensity,
        )
        for one in recordings
    ]


def _geometry(name: str, table: BeamTable, recorded: Sequence[Sweep], like: Sensor) -> Sensor:
    depth = np.concatenate([sweep.depth[sweep.valid] for sweep in recorded])
    offsets = tuple(table.azimuth_offsets.tolist()) if table.azimuth_offsets.any() else ()
    if not any((sweep.points[..., 2] < -1.0).any() for sweep in recorded):
        raise FormatError("no return lies 1 m or more below the sensor; without a road there is nothing to fit to")
    levels = [road_level(sweep) for sweep in recorded if (sweep.points[..., 2] < -1.0).any()]
    height = -float(np.median(levels))
    return replace(
        like,
        name=name,
        elevations=tuple(table.elevations.tolist()),
        azimuth_offsets=offsets,
        origin_forwards=(),
        origin_lefts=(),
        origin_heights=tuple(table.heights.tolist()),
        columns=recorded[0].points.shape[1],
        azimuth_start=math.pi,
        azimuth_span=2 * math.pi,
        min_range=min(like.min_range, math.floor(10 * float(depth.min())) / 10),
        max_range=_max_range(depth, like.max_range),
        mount_height=height,
        blocked=fit_blocked(recorded, table.elevations, height),
        model=None,
    )


def _max_range(depth: np.ndarray, usual: float) -> float:
    """The largest range, if enough returns lie just below it to be a limit; else at least the usual one."""
    end = float(math.ceil(float(depth.max())))
    return end if (depth > _LAST * end).sum() >= _MANY else max(usual, end)


@dataclass(frozen=True)
class Row:
    """A property in the report of streets. `before` and `after` are the distances of streets, scanned by a sensor
    before and after its fit, from the judging scans; `recorded` is that of the scans it was fitted to. NaN is
    unknown."""

    name: str
    before: float
    after: float
    recorded: float


def judged(
    before: Sensor, after: Sensor, fitted_to: Sequence[Sweep], judging: Sequence[Sweep], num_streets: int
) -> list[Row]:
    """The rows of the report that differ between two sensors, largest differences first.

    The sensors have the lasers, and get the columns, of the sweeps. Views that the vehicle of `after` hides are hidden
    from both, as they are missing in the sweeps.
    """
    columns = judging[0].points.shape[1]
    made = [_sweeps(replace(one, columns=columns, blocked=after.blocked), num_streets) for one in (before, after)]
    rows = [_row(one, [*made, fitted_to], judging) for one in _properties([*fitted_to, *judging])]
    moved = [row for row in rows if abs(row.after - row.before) > 0]
    return sorted(moved, key=lambda row: -abs(math.log((row.after + 1e-6) / (row.before + 1e-6))))


def _sweeps(sensor: Sensor, num: int) -> list[Sweep]:
    model = with_rays_that_fit(sensor, sensor.assumed_model)
    return StreetCasts.from_sensor(sensor, model, num, seed=JUDGING_SEED).observed(model, sensor.range_sigma)


def _properties(sweeps: Sequence[Sweep]) -> list[Property]:
    """The properties that all of the sweeps allow to measure."""
    found = list(lifelike.PROPERTIES)
    if all(sweep.intensity is not None for sweep in sweeps):
        found += lifelike.INTENSITY_PROPERTIES
        if all(sweep.label is not None for sweep in sweeps):
            found += lifelike.class_properties()
    return found


def _row(one: Property, others: Sequence[Sequence[Sweep]], judging: Sequence[Sweep]) -> Row:
    measured = [one.measure(sweep) for sweep in judging]
    before, after, recorded = (one.distance([one.measure(s) for s in sweeps], measured) for sweeps in others)
    return Row(one.name, before, after, recorded)
