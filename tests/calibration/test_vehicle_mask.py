"""What a known vehicle hides is found again, and nothing else."""

import math
from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from recorded_streets import SENSOR, sweeps

from lidardraft import Layout, Primitive, Sensor, raycast
from lidardraft.calibration.vehicle_mask import fit_blocked
from lidardraft.metrics.sweep import Sweep

ROAD = Layout((Primitive(shape="plane", center=(0, 0, 0), size=(300, 300, 0), label="road", id="road"),))
OPEN = Sensor(name="roof", elevations=(-0.02, -0.15, -0.2, -0.3), columns=720)


@settings(max_examples=30, deadline=None)
@given(st.lists(st.tuples(st.floats(-7, 7), st.floats(0.05, 6.0)), min_size=2, max_size=2), st.integers(1, 4))
def test_intervals_are_found_to_a_column_or_two(intervals, scans):
    blocked = ((), *(((start, start + width),) for start, width in intervals), ())
    truth = replace(OPEN, blocked=blocked)
    sweep = Sweep.from_image(raycast(ROAD, truth))
    rng = np.random.default_rng(scans)
    dropped = [Sweep(sweep.points * (rng.random(sweep.depth.shape) > 0.05)[..., None]) for _ in range(scans)]
    found = fit_blocked(dropped, np.array(OPEN.elevations))
    differs = replace(OPEN, blocked=found).blocked_pixels != truth.blocked_pixels
    assert differs.sum(axis=1).max() <= 8
    assert all(end - start <= 2 * math.pi for row in found for start, end in row)


def test_sky_and_dropped_returns_are_no_vehicle():
    assert fit_blocked(sweeps(SENSOR, 4, seed=2), np.array(SENSOR.elevations)) == ()


def test_a_beam_that_never_returns_is_hidden_all_around():
    points = Sweep.from_image(raycast(ROAD, OPEN)).points.copy()
    points[3] = 0.0
    assert fit_blocked([Sweep(points)], np.array(OPEN.elevations)) == ((), (), (), ((-math.pi, math.pi),))
