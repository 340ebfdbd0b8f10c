import dataclasses
import math

import numpy as np
import pytest
from box_pairs import SENSOR, make_pair

from lidardraft.errors import FormatError
from lidardraft.scene.labelling import ABSOLUTE_TOLERANCE
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.sensor import Sensor
from lidardraft.training.recorded_pairs import LabelledCloud, beside_beams, on_grid, recorded_pair


def recorded(image: RangeImage) -> LabelledCloud:
    assert image.intensity is not None
    seen = image.valid
    return LabelledCloud(points=image.points(), intensity=image.intensity[seen], label=image.label[seen])


def test_a_recorded_scan_becomes_a_pair_of_one_place() -> None:
    scan = make_pair(3).scan
    pair = recorded_pair(recorded(scan), SENSOR)
    np.testing.assert_allclose(pair.scan.depth, scan.depth, rtol=1e-6)
    np.testing.assert_array_equal(pair.scan.label, scan.label)
    np.testing.assert_array_equal(pair.scan.intensity, scan.intensity)
    both = scan.valid & pair.condition_image.valid
    assert both.sum() > 0.8 * scan.valid.sum()
    off = np.abs(pair.condition_image.depth - scan.depth)[both]
    assert np.mean(off < max(ABSOLUTE_TOLERANCE, 0.5)) > 0.8


def test_a_firing_beside_its_column_is_no_dropped_one() -> None:
    depth = np.full(SENSOR.shape, 10.0, dtype=np.float32)
    middles = SENSOR.azimuth_start - (np.arange(SENSOR.columns) + 0.5) * SENSOR.azimuth_span / SENSOR.columns
    # firings as many as columns, up to most of a column off
    azimuth = middles + np.random.default_rng(0).uniform(-0.9, 0.9, SENSOR.shape) * SENSOR.azimuth_span / SENSOR.columns
    elevation = np.array(SENSOR.elevations)[:, None]
    flat = depth * np.cos(elevation)
    points = np.stack([flat * np.cos(azimuth), flat * np.sin(azimuth), depth * np.sin(elevation)], axis=-1)
    scan = LabelledCloud(
        points=points.reshape(-1, 3).astype(np.float32),
        intensity=np.full(depth.size, 0.5, np.float32),
        label=np.ones(depth.size, np.uint8),
    )
    lost = 1 - RangeImage.project(scan.points, SENSOR).valid.mean()
    image = on_grid(scan, SENSOR)
    assert lost > 0.15
    assert 1 - image.valid.mean() < lost / 3
    assert image.intensity is not None
    assert (image.intensity[image.valid] == 0.5).all()
    assert (image.label[image.valid] == 1).all()


def test_of_two_returns_in_a_pixel_the_further_one_takes_no_return_away() -> None:
    scan = recorded(make_pair(1).scan)
    twice = LabelledCloud(
        points=np.concatenate([scan.points, 1.5 * scan.points]),
        intensity=np.tile(scan.intensity, 2),
        label=np.tile(scan.label, 2),
    )
    once, both = on_grid(scan, SENSOR), on_grid(twice, SENSOR)
    np.testing.assert_array_equal(both.depth[once.valid], once.depth[once.valid])


def test_what_the_vehicle_hides_is_no_return() -> None:
    hidden = dataclasses.replace(SENSOR, blocked=(((0.0, 1.0),),) * len(SENSOR.elevations))
    image = on_grid(recorded(make_pair(2).scan), hidden)
    assert image.valid.any()
    assert not image.valid[hidden.blocked_pixels].any()


def test_a_scan_of_another_sensor_is_refused() -> None:
    scan = recorded(make_pair(0).scan)
    up = Sensor(name="up", elevations=(1.2, 1.0), columns=128)
    with pytest.raises(FormatError, match="100% of the points are where no beam of up looks"):
        recorded_pair(scan, up)
    fine = dataclasses.replace(SENSOR, name="fine", columns=65_536)
    with pytest.raises(FormatError, match=r"only 0\.\d% of the pixels of fine have a return"):
        recorded_pair(scan, fine)
    unlabelled = dataclasses.replace(scan, label=np.zeros_like(scan.label))
    with pytest.raises(FormatError, match="no point has a class"):
        recorded_pair(unlabelled, SENSOR)


def test_points_of_the_sensor_lie_on_its_beams_and_others_beside_them() -> None:
    scan = recorded(make_pair(0).scan)
    assert beside_beams(scan, SENSOR) < 0.01
    tilted = tuple(elevation + math.radians(0.6) for elevation in SENSOR.elevations)
    assert beside_beams(scan, dataclasses.replace(SENSOR, elevations=tilted)) > 0.2
