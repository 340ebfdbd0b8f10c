import dataclasses
import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lidardraft.errors import FormatError, LayoutError, SensorError
from lidardraft.scene.range_image import RangeImage, images_of, new_images
from lidardraft.scene.sensor import PRESETS, Sensor

SMALL = Sensor(name="small", elevations=(0.2, 0.1, 0.0, -0.1), columns=16)
SPREAD = dataclasses.replace(
    SMALL,
    name="spread",
    azimuth_offsets=(0.05, -0.05, 0.02, 0.0),
    origin_forwards=(0.05, 0.06, -0.02, 0.0),
    origin_lefts=(0.0, 0.03, -0.04, 0.01),
    origin_heights=(0.06, 0.03, 0.0, -0.03),
)


def filled(sensor, seed):
    """A random image in which about one ray in four has no return."""
    random = np.random.default_rng(seed)
    hit = random.random(sensor.shape) < 0.75
    return RangeImage(
        sensor=sensor,
        depth=np.where(hit, random.uniform(2, 60, sensor.shape), 0).astype(np.float32),
        label=np.where(hit, random.integers(1, 21, sensor.shape), 0).astype(np.uint8),
        instance=np.where(hit, random.integers(0, 9, sensor.shape), 0).astype(np.uint32),
        intensity=np.where(hit, random.random(sensor.shape), 0).astype(np.float32),
    )


@settings(max_examples=2, deadline=None)
@given(st.integers(0, 1000))
@pytest.mark.parametrize("sensor", [*PRESETS.values(), SMALL, SPREAD], ids=lambda sensor: sensor.name)
def test_projecting_the_points_gives_the_image_back(sensor, seed):
    image = filled(sensor, seed)
    valid = image.valid
    again = RangeImage.project(
        image.points(),
        image.sensor,
        label=image.label[valid],
        instance=image.instance[valid],
        intensity=image.intensity[valid],
    )
    np.testing.assert_allclose(again.depth, image.depth, rtol=1e-5)
    np.testing.assert_array_equal(again.label, image.label)
    np.testing.assert_array_equal(again.instance, image.instance)
    np.testing.assert_array_equal(again.intensity, image.intensity)


def test_points_come_row_by_row_in_the_sensor_frame():
    depth = np.zeros(SMALL.shape, np.float32)
    depth[2, 7], depth[0, 8] = 10.0, 5.0
    image = RangeImage(
        sensor=SMALL, depth=depth, label=np.zeros(SMALL.shape, np.uint8), instance=np.zeros(SMALL.shape, np.uint32)
    )
    step = np.pi / 16
    expected = [
        [5 * np.cos(0.2) * np.cos(step), -5 * np.cos(0.2) * np.sin(step), 5 * np.sin(0.2)],
        [10 * np.cos(step), 10 * np.sin(step), 0.0],
    ]
    np.testing.assert_allclose(image.points(), expected, atol=1e-5)
    assert image.points().dtype == np.float32


def test_the_nearest_point_wins_a_pixel_whatever_the_order():
    near, far = [5.0, 0.1, 0.0], [10.0, 0.2, 0.0]
    for points, labels in (([near, far], [1, 2]), ([far, near], [2, 1])):
        image = RangeImage.project(np.array(points), SMALL, label=np.array(labels))
        assert image.valid.sum() == 1
        assert image.label[image.valid] == [1]


def test_points_outside_the_field_of_view_are_left_out():
    points = np.array([[10.0, 0, 9], [10, 0, -9], [0.1, 0, 0], [500, 0, 0], [0, 0, 0]])
    image = RangeImage.project(points, SMALL)
    assert not image.valid.any()
    assert image.intensity is None


def test_no_points_make_an_empty_image():
    image = RangeImage.project(np.zeros((0, 3)), SMALL, label=np.zeros(0))
    assert not image.valid.any()
    assert image.points().shape == (0, 3)


@pytest.mark.parametrize(
    ("points", "label", "message"),
    [
        (np.zeros((3, 2)), None, r"points have shape \(3, 2\); they must be \[N, 3\]"),
        (np.array([[1.0, 0, 0], [np.nan, 0, 0]]), None, r"point 1 is not finite"),
        (np.array([[1.0, 0, np.inf]]), None, r"point 0 is not finite"),
        (np.ones((3, 3)), np.ones(2), r"label has 2 values for 3 points"),
    ],
)
def test_points_that_cannot_be_projected(points, label, message):
    with pytest.raises(LayoutError, match=message):
        RangeImage.project(points, SMALL, label=label)
    with pytest.raises(LayoutError, match="instance holds -1; it must be whole numbers of 0 to 4294967295"):
        RangeImage.project(np.ones((2, 3)), SMALL, instance=np.array([-1, 2]))


def test_saving_and_loading(tmp_path):
    normal = np.random.default_rng(0).random((*SPREAD.shape, 3), np.float32)
    empty = RangeImage.empty(SPREAD, primitive=True, incidence=True, normal=True)
    for image in (filled(SMALL, 1), dataclasses.replace(empty, normal=normal)):
        image.save(tmp_path / "a.npz")
        again = RangeImage.load(tmp_path / "a.npz")
        assert again.sensor == image.sensor
        assert images_of(again).keys() == images_of(image).keys()
        for name, array in images_of(image).items():
            np.testing.assert_array_equal(getattr(again, name), array)


def test_times_and_beams_come_in_the_order_of_the_points():
    image = filled(dataclasses.replace(SMALL, sweep_time=0.4), 3)
    beams, times = image.beams(), image.times()
    assert (beams.dtype, times.dtype) == (np.uint16, np.float32)
    assert beams.shape == times.shape == (len(image.points()),)
    rows, columns = np.nonzero(image.valid)
    np.testing.assert_array_equal(beams, rows)
    np.testing.assert_allclose(times, columns * 0.4 / 16)
    elevation = np.arcsin(image.points()[:, 2] / np.linalg.norm(image.points(), axis=1))
    np.testing.assert_allclose(elevation, np.array(SMALL.elevations)[beams], atol=1e-6)
    assert RangeImage.empty(SMALL).times().shape == (0,)


def test_images_must_fit_the_sensor():
    image = filled(SMALL, 1)
    with pytest.raises(SensorError, match=r"label is uint8 \(3, 16\); small needs uint8 \(4, 16\)"):
        dataclasses.replace(image, label=image.label[1:])
    with pytest.raises(SensorError, match="depth holds "):
        dataclasses.replace(image, depth=-image.depth)


def test_files_that_are_no_range_image(tmp_path):
    np.savez(tmp_path / "b.npz", depth=np.zeros((4, 16), np.float32))
    with pytest.raises(FormatError, match=r"b.npz: 'sensor' is missing"):
        RangeImage.load(tmp_path / "b.npz")
    np.save(tmp_path / "c.npy", np.zeros(3))
    with pytest.raises(FormatError, match=r"c.npy: not a whole .npz file"):
        RangeImage.load(tmp_path / "c.npy")


@pytest.mark.parametrize("name", ["hdl64e", "os1-128"])
def test_returns_at_the_range_limits_survive_projection(name: str) -> None:
    sensor = Sensor.preset(name)
    for limit in (sensor.min_range, sensor.max_range):
        depth = np.full(sensor.shape, limit, dtype=np.float32)
        blank = {"label": np.zeros(sensor.shape, np.uint8), "instance": np.zeros(sensor.shape, np.uint32)}
        image = RangeImage(sensor=sensor, depth=depth, **blank)
        again = RangeImage.project(image.points(), sensor)
        assert again.valid.all()
        np.testing.assert_allclose(again.depth, depth, rtol=1e-5)


def test_images_begin_with_a_line_of_the_cache():
    for columns in (1, 16, 100, 2048):
        images = new_images((3, columns), primitive=True, incidence=False, normal=True)
        assert images["depth"].ctypes.data % 64 == 0
        spans = sorted((image.ctypes.data, image.nbytes) for image in images.values())
        assert all(first + size == second for (first, size), (second, _) in itertools.pairwise(spans))
