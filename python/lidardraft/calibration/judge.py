"""How much nearer a fitted sensor brings streets to scans that it was not fitted to."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from lidardraft.calibration.street_casts import StreetCasts, with_rays_that_fit
from lidardraft.metrics import lifelike
from lidardraft.metrics.lifelike import Property
from lidardraft.metrics.sweep import Sweep
from lidardraft.scene.sensor import Sensor

STREETS = 24
SEED = 4_000_000  # other streets than those that sensors are fitted with


@dataclass(frozen=True)
class Row:
    """A property of the report of streets: how far scans of streets, by a sensor before and after its fit, are from
    the judging scans, and how far these are from the scans that it was fitted to; NaN where nothing is known."""

    name: str
    before: float
    after: float
    recorded: float


def judged(
    before: Sensor, after: Sensor, fitted_to: Sequence[Sweep], judging: Sequence[Sweep], num_streets: int = STREETS
) -> list[Row]:
    """The rows of the report that differ between two sensors, those that differ most first.

    The sensors have the lasers, and get the columns, of the sweeps; what the vehicle of `after` hides is hidden from
    both, as the sweeps do not show it either.
    """
    columns = judging[0].points.shape[1]
    made = [_sweeps(replace(one, columns=columns, blocked=after.blocked), num_streets) for one in (before, after)]
    rows = [_row(one, [*made, fitted_to], judging) for one in _properties([*fitted_to, *judging])]
    moved = [row for row in rows if abs(row.after - row.before) > 0]
    return sorted(moved, key=lambda row: -abs(math.log((row.after + 1e-6) / (row.before + 1e-6))))


def _sweeps(sensor: Sensor, num: int) -> list[Sweep]:
    model = with_rays_that_fit(sensor, sensor.assumed_model)
    return StreetCasts.from_sensor(sensor, model, num, seed=SEED).observed(model, sensor.range_sigma)


def _properties(sweeps: Sequence[Sweep]) -> list[Property]:
    """What can be measured of all of the sweeps."""
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
