"""Lasers, their offsets and what the vehicle hides are found again."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from recorded_streets import SENSOR, sweeps

from lidardraft import Layout, Primitive, Sensor, raycast
from lidardraft.calibration.beam_table import BeamTable, fit_beam_table, fit_blocked, fit_range_offsets
from lidardraft.calibration.odd_scans import odd_scans, without_rare_lasers
from lidardraft.errors import FormatError
from lidardraft.formats.recording import Recording, read_recording, recording_of
from lidardraft.metrics.sweep import Sweep
from lidardraft.scan import Scan
from lidardraft.scene.sensor import PRESETS

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


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.slow if n % 2 else ()) for n, name in enumerate(PRESETS)]
)
def test_scans_of_ours_tell_their_lasers_by_any_preset(tmp_path, name):
    truth = Sensor.preset(name)
    recordings = []
    for number in range(2):
        image = raycast(ROOM, truth, truth.pose(x=3.0 * number, yaw=2.0 * number))
        image = replace(image, intensity=image.depth / 1000)
        Scan(image=image, layout=Layout(), pose=truth.pose(), seed=0).save(tmp_path / f"{number}", picture=False)
        recordings.append(read_recording(tmp_path / f"{number}.bin"))
        np.testing.assert_array_equal(recordings[-1].ring, image.beams())
    assert odd_scans(recordings) == {}
    sound, rare = without_rare_lasers(recordings)
    table = fit_beam_table(sound)
    assert sorted([*table.rings, *rare]) == sorted(set(np.concatenate([one.ring for one in recordings]).tolist()))
    np.testing.assert_allclose(table.elevations, np.array(truth.elevations)[table.rings], atol=1e-2)


def test_lasers_of_a_file_that_start_aside_of_one_another_are_not_guessed():
    truth = Sensor.preset("os1-128")
    points = raycast(ROOM, truth, truth.pose()).points()
    with pytest.raises(FormatError, match="the lasers of the points are unknown"):
        recording_of("scan", points)


def test_scans_of_another_sensor_are_odd():
    truth = Sensor(name="truth", elevations=tuple(np.linspace(0.05, -0.3, 16).tolist()), columns=360)
    other = replace(truth, elevations=tuple(np.linspace(0.2, -0.15, 16).tolist()))
    half = replace(truth, elevations=truth.elevations[::2])
    usual, again, aside, fewer = (
        replace(scan(sensor, seed, np.arange(len(sensor.elevations))), name=f"scan {seed}")
        for seed, sensor in enumerate([truth, truth, other, half])
    )
    mixed = replace(usual, ring=np.random.default_rng(0).integers(0, 2, len(usual.ring)))
    unnumbered = replace(usual, column=None)
    found = odd_scans([fewer, usual, aside, again, mixed, unnumbered])
    assert found == {
        0: "it has 8 lasers, scan 0 has 16",
        2: "its lasers look 8.6 degrees past those of scan 0",
        4: found[4],
        5: "it has no column of each point, scan 0 has one",
    }
    assert "degrees off the cones of 2 lasers" in found[4]
    assert odd_scans([fewer, usual]) == {1: "it has 16 lasers, scan 3 has 8"}
    assert odd_scans([]) == {}


def test_a_laser_of_few_returns_is_left_out_of_all_scans():
    truth = Sensor(name="truth", elevations=(0.02, -0.05, -0.1), columns=360)
    recording = scan(truth, 0, np.arange(3))
    few = replace(recording, ring=np.where(np.arange(len(recording.ring)) < 4, 9, recording.ring))
    (first, second), rare = without_rare_lasers([few, recording])
    assert rare == [9]
    assert (len(first.points), len(second.points)) == (len(few.points) - 4, len(few.points))
    assert set(first.ring.tolist()) == {0, 1, 2}


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


LASERS = 24
CLOSE = Sensor(
    name="truth",
    elevations=tuple(np.deg2rad(np.linspace(4.0, -20.0, LASERS)).tolist()),
    origin_heights=(0.1,) * (LASERS // 2) + (0.0,) * (LASERS // 2),
    columns=512,
    mount_height=1.8,
)
TABLE = BeamTable(
    rings=np.arange(LASERS),
    elevations=np.array(CLOSE.elevations),
    heights=np.array(CLOSE.origin_heights),
    azimuth_offsets=np.zeros(LASERS),
    columns=512,
    residual=0.0,
    angle_residual=0.0,
)


def offset_sweeps(offsets: np.ndarray, *, sensor: Sensor = CLOSE) -> list[Sweep]:
    """Scans from four places in a room, each laser off by its offset, with 5 mm of noise."""
    rng, found = np.random.default_rng(0), []
    for x, y in ((0, 0), (3, 2), (-6, 4), (6, -4)):
        image = raycast(ROOM, sensor, sensor.pose(x=x, y=y, yaw=x))
        off = offsets[:, None] + rng.normal(0.0, 0.005, sensor.shape)
        depth = (image.depth + off * image.valid).astype(np.float32)
        found.append(Sweep.from_image(replace(image, depth=depth)))
    return found


def smooth(values: np.ndarray) -> np.ndarray:
    rows = np.arange(len(values))
    return np.polyval(np.polyfit(rows, values, 3), rows)


def test_offsets_between_neighbours_are_found():
    truth = np.random.default_rng(1).normal(0.0, 0.03, LASERS)
    truth -= smooth(truth)
    found = fit_range_offsets(offset_sweeps(truth), TABLE)
    left = found - truth
    assert np.std(left - smooth(left)) < 0.004
    assert np.corrcoef(found, truth)[0, 1] > 0.97


def test_without_offsets_none_is_found():
    assert np.abs(fit_range_offsets(offset_sweeps(np.zeros(LASERS)), TABLE)).max() < 0.006


def test_lasers_that_saw_nothing_have_none():
    sees = np.arange(LASERS)[:, None, None] >= 8
    found = fit_range_offsets(
        [Sweep(np.where(sees, sweep.points, 0)) for sweep in offset_sweeps(np.zeros(LASERS))], TABLE
    )
    assert (found[:8] == 0).all()
    assert found[8:].any()


def test_fewer_lasers_than_a_patch_has_none():
    table = replace(TABLE, elevations=TABLE.elevations[:3], heights=TABLE.heights[:3], rings=TABLE.rings[:3])
    three = [Sweep(sweep.points[:3]) for sweep in offset_sweeps(np.zeros(LASERS))]
    assert fit_range_offsets(three, table) == pytest.approx(np.zeros(3))


def test_scans_in_which_nothing_is_flat_tell_no_offsets():
    torn = [
        Sweep(np.where(np.arange(512)[:, None] % 2 == 0, one.points, 0.0))
        for one in offset_sweeps(np.full(LASERS, 0.05))
    ]
    np.testing.assert_array_equal(fit_range_offsets(torn, TABLE), 0.0)


FLAT = Layout((Primitive(shape="plane", center=(0, 0, 0), size=(300, 300, 0), label="road", id="road"),))
OPEN = Sensor(name="roof", elevations=(-0.02, -0.15, -0.2, -0.3), columns=720)


@settings(max_examples=30, deadline=None)
@given(st.lists(st.tuples(st.floats(-7, 7), st.floats(0.05, 6.0)), min_size=2, max_size=2), st.integers(1, 4))
def test_intervals_are_found_to_a_column_or_two(intervals, scans):
    blocked = ((), *(((start, start + width),) for start, width in intervals), ())
    truth = replace(OPEN, blocked=blocked)
    sweep = Sweep.from_image(raycast(FLAT, truth))
    rng = np.random.default_rng(scans)
    dropped = [Sweep(sweep.points * (rng.random(sweep.depth.shape) > 0.05)[..., None]) for _ in range(scans)]
    found = fit_blocked(dropped, np.array(OPEN.elevations), 1.73)
    differs = replace(OPEN, blocked=found).blocked_pixels != truth.blocked_pixels
    assert differs.sum(axis=1).max() <= 8
    assert all(end - start <= 2 * math.pi for row in found for start, end in row)


def test_sky_and_dropped_returns_are_no_vehicle():
    assert fit_blocked(sweeps(SENSOR, 4, seed=2), np.array(SENSOR.elevations), 1.73) == ()


def test_a_beam_that_never_returns_is_hidden_all_around():
    points = Sweep.from_image(raycast(FLAT, OPEN)).points.copy()
    points[3] = 0.0
    assert fit_blocked([Sweep(points)], np.array(OPEN.elevations), 1.73) == ((), (), (), ((-math.pi, math.pi),))


def test_returns_of_the_vehicle_itself_hide_the_ground_and_those_of_others_do_not():
    bonnet = Primitive(shape="box", center=(1.5, 0, 1.0), size=(1.0, 1.6, 0.1), label="car", id="ego")
    others = [
        Primitive(shape="box", center=(0, 1.6 + 0.1 * k, 0.7), size=(2, 0.5, 1.4), label="car", id="o")
        for k in range(6)
    ]
    steep = replace(OPEN, elevations=(-0.02, -0.3, -0.4, -0.5))
    sweeps = [Sweep.from_image(raycast(Layout((*FLAT, bonnet, other)), steep)) for other in others]
    own = raycast(Layout((bonnet,)), steep).valid
    found = replace(steep, blocked=fit_blocked(sweeps, np.array(steep.elevations), 1.73)).blocked_pixels
    assert own.any()
    assert (found != own).sum(axis=1).max() <= 8
    assert fit_blocked(sweeps[:2], np.array(steep.elevations), 1.73) == ()  # two places do not tell
