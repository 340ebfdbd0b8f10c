"""The whole fit, on scans of a sensor that is known and on recordings of real ones, and the rows that it moves."""

import itertools
import math
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from recorded_streets import SENSOR, recordings, sweeps, with_model

from lidardraft import Sensor
from lidardraft.calibration.fit import fit_sensor, judged, sweeps_of
from lidardraft.errors import FormatError
from lidardraft.formats.recording import read_recording, recording_of
from lidardraft.metrics.sweep import Sweep
from lidardraft.scene.sensor_model import IntensityCurve
from lidardraft.streets import StreetConfig, streets

CURVE = IntensityCurve(responses=(0.01, 0.1, 2.0), readings=((0.05, 0.3, 0.9),), cutoffs=(0.1,) * 12)
TRUTH = replace(
    with_model(intensity_curve=CURVE), blocked=((),) * 10 + (((2.0, 4.0),), ((2.0, 4.0), (-0.5, 0.2)))
)  # fmt: skip
DATA = os.environ.get("LIDARDRAFT_DATA")
needs_data = pytest.mark.skipif(not DATA, reason="LIDARDRAFT_DATA names no folder of recordings")


@pytest.fixture(scope="module")
def fitted():
    return fit_sensor(recordings(TRUTH, num=8, columns=False), "mine", num_streets=12)


def test_the_geometry_is_that_of_the_sensor(fitted):
    sensor = fitted.sensor
    np.testing.assert_allclose(sensor.elevations, TRUTH.elevations, atol=2e-3)
    assert sensor.columns == pytest.approx(TRUTH.columns, abs=10)
    assert sensor.columns == fitted.table.columns // 4 * 4  # as the generator needs them
    assert sensor.mount_height == pytest.approx(TRUTH.mount_height, abs=0.1)
    assert sensor.range_sigma == pytest.approx(TRUTH.range_sigma, rel=0.3)
    hidden = replace(sensor, columns=TRUTH.columns).blocked_pixels
    assert (hidden != TRUTH.blocked_pixels).mean() < 0.01
    assert fitted.table.residual < 0.01


def test_streets_by_the_fitted_sensor_read_and_hide_as_those_of_the_true_one(fitted):
    sensor = replace(fitted.sensor, columns=TRUTH.columns)
    scans = [
        pair.scan
        for pair in itertools.islice(streets(seed=3, config=StreetConfig(sensor=sensor, poses_per_street=1)), 6)
    ]
    reference = sweeps(TRUTH, 6, seed=3)
    found = np.concatenate([scan.intensity[scan.valid] for scan in scans])
    wanted = np.concatenate([sweep.intensity[sweep.valid] for sweep in reference])
    levels = np.linspace(0.05, 0.95, 10)
    np.testing.assert_allclose(np.quantile(found, levels), np.quantile(wanted, levels), atol=0.09)
    assert (found == 0).mean() == pytest.approx((wanted == 0).mean(), abs=0.04)
    rate = np.mean([scan.valid.mean() for scan in scans])
    assert rate == pytest.approx(np.mean([sweep.valid.mean() for sweep in reference]), abs=0.05)
    assert not np.any([scan.valid & sensor.blocked_pixels for scan in scans])


def test_a_fitted_sensor_is_a_file_that_says_everything(fitted, tmp_path):
    (tmp_path / "mine.json").write_text(fitted.sensor.to_json())
    sensor = Sensor.load(tmp_path / "mine.json")
    assert sensor == fitted.sensor
    assert sensor.assumed_model == fitted.sensor.model
    assert sensor.name == "mine"


def test_one_scan_three_beams_and_no_intensity_are_enough():
    three = replace(TRUTH, elevations=TRUTH.elevations[2::4], origin_heights=(), blocked=(), model=SENSOR.model)
    (one,) = recordings(three, num=1)
    found = fit_sensor([replace(one, intensity=None)], "few", num_streets=4)
    np.testing.assert_allclose(found.sensor.elevations, three.elevations, atol=5e-3)
    assert found.sensor.model.intensity_curve is None
    assert np.isnan(found.intensity_residual)
    (pair,) = itertools.islice(streets(seed=0, config=StreetConfig(sensor=found.sensor)), 1)
    assert pair.scan.valid.any()


def test_what_no_scan_tells_is_that_of_a_sensor_like_it_and_columns_can_be_chosen():
    like = replace(SENSOR, sweep_time=0.05, model=replace(SENSOR.model, divergence_h=7e-3, last_return=True))
    found = fit_sensor(recordings(SENSOR, num=2), "mine", like=like, columns=300, num_streets=4)
    assert (found.sensor.sweep_time, found.sensor.columns) == (0.05, 300)
    assert (found.sensor.model.divergence_h, found.sensor.model.last_return) == (7e-3, True)


def test_scans_without_a_road_are_refused():
    (one,) = recordings(SENSOR, num=1)
    sky = one.points[:, 2] > 0
    above = recording_of("sky", one.points[sky], ring=np.zeros(sky.sum()))
    with pytest.raises(FormatError, match="no return lies 1 m or more below the sensor"):
        fit_sensor([above], "mine")


def test_a_range_limit_is_one_that_many_returns_come_near_to(fitted):
    few = fit_sensor(recordings(replace(SENSOR, max_range=200.0), num=1), "few", num_streets=4).sensor
    assert few.max_range >= 120.0  # the usual one
    assert fitted.sensor.max_range == pytest.approx(TRUTH.max_range, abs=1.0)
    assert fitted.sensor.min_range <= 0.5


def test_sweeps_have_the_lasers_in_the_rows_of_the_table(fitted):
    one = recordings(TRUTH, num=1, columns=False)[0]
    (sweep,) = sweeps_of([one], fitted.table, TRUTH.columns)
    elevation = np.arctan2(sweep.points[..., 2], np.hypot(sweep.points[..., 0], sweep.points[..., 1]))
    far = sweep.depth > 20.0
    np.testing.assert_allclose(
        elevation[far], np.broadcast_to(np.array(TRUTH.elevations)[:, None], far.shape)[far], atol=0.01
    )


@pytest.mark.slow
@needs_data
def test_a_recorded_hdl64e_loses_no_point_to_another_laser():
    paths = sorted(Path(DATA).glob("kitti/object/*/velodyne/*.bin"))[:1]  # whose motion was not taken out
    if not paths:
        pytest.skip("no scans under kitti/object")
    scans = [read_recording(path) for path in paths]
    found = fit_sensor(scans, "mine", like=Sensor.preset("hdl64e"), columns=512, num_streets=4)
    assert len(found.table.rings) == 64
    assert found.table.residual < 5e-3
    assert found.sensor.max_range == pytest.approx(80.0, abs=1.0)
    for scan in scans:
        row, _, _ = found.sensor.pattern.project(scan.points.astype(np.float64))
        assert (row != found.table.rows(scan)).mean() < 0.01


@pytest.mark.slow
@needs_data
def test_the_rings_of_a_recorded_pandar64_are_those_of_its_table():
    paths = sorted(Path(DATA).glob("permissive/pjlab_pandar64/lidar2lidar*top.pcd"))[:1]
    if not paths:
        pytest.skip("no scans under permissive/pjlab_pandar64")
    found = fit_sensor(
        [read_recording(path, intensity_scale=255.0) for path in paths], "mine", columns=512, num_streets=4
    )
    table = Sensor.preset("pandar64").elevations
    apart = np.subtract(found.sensor.elevations, table)
    assert np.median(np.abs(apart - np.median(apart))) < 3e-3


STREETS = 4
BRIGHT = IntensityCurve(responses=(0.01, 1.0), readings=((0.3, 0.9),))
JUDGED = replace(with_model(intensity_curve=BRIGHT, drop_exponent=0.1), range_sigma=0.05)


@pytest.fixture(scope="module")
def scans() -> tuple[list[Sweep], list[Sweep]]:
    return sweeps(JUDGED, STREETS, seed=1), sweeps(JUDGED, STREETS, seed=2)


def test_the_true_sensor_brings_streets_nearer(scans):
    rows = {row.name: row for row in judged(SENSOR, JUDGED, *scans, STREETS)}
    moved = ("intensity (JSD)", "intensity by range", "return rate on surfaces by range", "intensity of road (JSD)")
    for name in moved:
        assert rows[name].after < 0.6 * rows[name].before
        assert rows[name].recorded < rows[name].before
    order = [abs(math.log(row.after / row.before)) for row in rows.values() if row.after > 0 and row.before > 0]
    assert order == pytest.approx(sorted(order, reverse=True), abs=0.01)


def test_what_is_equal_is_no_row_and_what_is_not_known_neither(scans):
    fitted_to, judging = scans
    assert judged(JUDGED, JUDGED, fitted_to, judging, 2) == []
    plain = [Sweep(sweep.points) for sweep in judging]
    names = {row.name for row in judged(SENSOR, JUDGED, fitted_to, plain, 2)}
    assert names
    assert not [name for name in names if "intensity" in name or "roughness" in name]
