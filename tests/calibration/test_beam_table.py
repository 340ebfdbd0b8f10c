"""Lasers that are known are found again."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lidardraft import Layout, Primitive, Sensor, raycast
from lidardraft.calibration.beam_table import fit_beam_table
from lidardraft.errors import FormatError
from lidardraft.formats.recording import Recording, recording_of

# a road, and walls at several distances all around
ROOM = Layout((
    Primitive(shape="plane", center=(0, 0, 0), size=(300, 300, 0), label="road", id="road"),
    Primitive(shape="box", center=(14, 3, 4), size=(1, 30, 14), label="building", id="ahead"),
    Primitive(shape="box", center=(-5, -8, 4), size=(60, 1, 14), label="building", id="right"),
    Primitive(shape="box", center=(-30, 20, 4), size=(60, 1, 30), label="building", id="left"),
    Primitive(shape="box", center=(-25, 0, 4), size=(1, 40, 30), label="building", id="behind"),
))  # fmt: skip


def scan(sensor: Sensor, seed: int, order: np.ndarray, noise: float = 0.0) -> Recording:
    """A cast from somewhere in the room, `noise` [m] along the rays, its lasers numbered by `order`."""
    rng = np.random.default_rng(seed)
    image = raycast(ROOM, sensor, sensor.pose(x=rng.uniform(-8, 8), y=rng.uniform(-5, 5), yaw=rng.uniform(-3, 3)))
    depth = image.depth + rng.normal(0.0, noise, image.depth.shape) * (image.depth > 0)
    points = sensor.pattern.points(depth.astype(np.float32))[image.valid]
    row, column = np.nonzero(image.valid)
    return recording_of("scan", points, ring=order[row], column=column)


@st.composite
def sensors(draw: st.DrawFn) -> Sensor:
    beams = draw(st.integers(3, 24))
    steps = draw(st.lists(st.floats(0.3, 2.5), min_size=beams, max_size=beams))
    elevations = np.deg2rad(draw(st.floats(-2, 15)) - np.cumsum(steps))
    table = st.lists(st.floats(-1, 1), min_size=beams, max_size=beams)
    return Sensor(
        name="truth",
        elevations=tuple(elevations.tolist()),
        azimuth_offsets=tuple((0.15 * np.array(draw(table))).tolist()),
        origin_heights=tuple(np.linspace(draw(st.floats(-0.2, 0.2)), draw(st.floats(-0.2, 0.2)), beams).tolist()),
        columns=360,
        mount_height=draw(st.floats(1.2, 2.5)),
    )


@settings(max_examples=12, deadline=None)
@given(sensors(), st.integers(0, 1000))
def test_elevations_heights_and_azimuths_are_found(truth, seed):
    order = np.random.default_rng(seed).permutation(len(truth.elevations)) * 2 + 1
    scans = [scan(truth, seed + k, order, noise=0.005) for k in range(3)]
    table = fit_beam_table(scans)
    np.testing.assert_array_equal(table.rings, order)
    assert table.columns == 360
    assert table.residual < 0.01
    for beam, ring in enumerate(order):
        out = np.concatenate([np.hypot(*one.points[one.ring == ring, :2].T) for one in scans])
        elevation, height = truth.elevations[beam], truth.origin_heights[beam]
        at = np.median(out)
        assert table.heights[beam] + at * np.tan(table.elevations[beam]) == pytest.approx(
            height + at * np.tan(elevation), abs=0.02
        )
        if np.quantile(out, 0.8) > 1.5 * np.quantile(out, 0.2):  # one distance does not tell a height from an angle
            assert table.elevations[beam] == pytest.approx(elevation, abs=2e-3)
            assert table.heights[beam] == pytest.approx(height, abs=0.014)
    # what is known is by how much they differ
    apart = table.azimuth_offsets - truth.azimuth_offsets
    np.testing.assert_allclose(apart, apart.mean(), atol=2e-4)


def test_a_beam_with_one_distance_starts_where_its_neighbour_does():
    sensor = Sensor(name="truth", elevations=(0.05, -0.1, -0.5), origin_heights=(0.2, 0.1, 0.1), columns=360)
    table = fit_beam_table([scan(sensor, 0, np.arange(3))])  # the lowest sees the road alone
    np.testing.assert_allclose(table.heights, sensor.origin_heights, atol=0.007)
    np.testing.assert_allclose(table.elevations, sensor.elevations, atol=2e-3)


def test_heights_that_are_alike_are_one():
    heights = (0.209, 0.205, 0.199, 0.126, 0.118, 0.04)
    sensor = Sensor(
        name="truth", elevations=(0.03, 0.0, -0.03, -0.06, -0.1, -0.15), origin_heights=heights, columns=360
    )
    table = fit_beam_table([scan(sensor, k, np.arange(6)) for k in range(3)])
    np.testing.assert_allclose(table.heights, [0.204] * 3 + [0.122] * 2 + [0.04], atol=1e-3)
    assert table.residual < 0.006


def test_firings_are_counted_by_their_steps_where_they_are_not_numbered():
    truth = Sensor(name="truth", elevations=(0.02, -0.05, -0.1), columns=720)
    recording = replace(scan(truth, 0, np.arange(3)), column=None)
    table = fit_beam_table([recording])
    assert table.columns == pytest.approx(720, abs=8)
    np.testing.assert_array_equal(table.azimuth_offsets, 0.0)


def test_a_scan_without_a_return_of_one_laser_does_not_hide_its_azimuth():
    truth = Sensor(name="truth", elevations=(0.02, -0.05, -0.1), columns=360, azimuth_offsets=(0.1, 0.0, -0.1))
    whole, other = (scan(truth, seed, np.arange(3)) for seed in range(2))
    seen = other.ring != 0
    partly = replace(other, points=other.points[seen], ring=other.ring[seen], column=other.column[seen])
    np.testing.assert_allclose(fit_beam_table([whole, partly]).azimuth_offsets, truth.azimuth_offsets, atol=2e-4)


def test_columns_that_are_no_firings_give_no_azimuths():
    truth = Sensor(name="truth", elevations=(0.02, -0.05, -0.1), columns=360, azimuth_offsets=(0.1, 0.0, -0.1))
    recording = scan(truth, 0, np.arange(3))
    backwards = replace(recording, column=359 - recording.column)
    np.testing.assert_array_equal(fit_beam_table([backwards]).azimuth_offsets, 0.0)


def test_rows_need_known_rings_and_returns():
    truth = Sensor(name="truth", elevations=(0.02, -0.05, -0.1), columns=360)
    recording = scan(truth, 0, np.arange(3))
    table = fit_beam_table([recording])
    np.testing.assert_array_equal(table.rows(recording), recording.ring)
    other = replace(recording, name="other", ring=recording.ring + 1)
    with pytest.raises(FormatError, match="other has a ring 3, which the other scans do not have"):
        table.rows(other)
    few = replace(recording, ring=np.where(np.arange(len(recording.ring)) < 4, 9, recording.ring))
    with pytest.raises(FormatError, match="ring 9 has 4 returns; a laser needs 20 to be fitted"):
        fit_beam_table([few])
