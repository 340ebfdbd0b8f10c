"""The rows that a fit moves: nearer with the sensor that recorded, further with one that did not."""

import math
from dataclasses import replace

import pytest
from recorded_streets import SENSOR, sweeps, with_model

from lidardraft.calibration.judge import judged
from lidardraft.metrics.sweep import Sweep
from lidardraft.scene.sensor_model import IntensityCurve

STREETS = 6
CURVE = IntensityCurve(responses=(0.01, 1.0), readings=((0.3, 0.9),))
TRUTH = replace(with_model(intensity_curve=CURVE, drop_exponent=0.1), range_sigma=0.05)


@pytest.fixture(scope="module")
def scans() -> tuple[list[Sweep], list[Sweep]]:
    return sweeps(TRUTH, STREETS, seed=1), sweeps(TRUTH, STREETS, seed=2)


def test_the_true_sensor_brings_streets_nearer(scans):
    rows = {row.name: row for row in judged(SENSOR, TRUTH, *scans, STREETS)}
    for name in (
        "intensity (JSD)",
        "intensity by range",
        "return rate on surfaces by range",
        "intensity of road (JSD)",
    ):
        assert rows[name].after < 0.6 * rows[name].before
        assert rows[name].recorded < rows[name].before
    order = [abs(math.log(row.after / row.before)) for row in rows.values() if row.after > 0 and row.before > 0]
    assert order == pytest.approx(sorted(order, reverse=True), abs=0.01)


def test_what_is_equal_is_no_row_and_what_is_not_known_neither(scans):
    fitted_to, judging = scans
    assert judged(TRUTH, TRUTH, fitted_to, judging, 2) == []
    plain = [Sweep(sweep.points) for sweep in judging]
    names = {row.name for row in judged(SENSOR, TRUTH, fitted_to, plain, 2)}
    assert names
    assert not [name for name in names if "intensity" in name or "roughness" in name]
