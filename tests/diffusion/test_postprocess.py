import dataclasses

import numpy as np

from lidardraft.diffusion.codec import MAX_DEPTH
from lidardraft.diffusion.postprocess import postprocess
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.sensor import Sensor

SENSOR = Sensor(name="small", elevations=tuple(-0.05 * np.arange(8)), columns=16, range_sigma=0.01, max_range=100.0)


def image(depth: np.ndarray, intensity: float = 0.5, sensor: Sensor = SENSOR) -> RangeImage:
    return RangeImage(
        sensor=sensor,
        depth=depth.astype(np.float32),
        label=np.zeros(sensor.shape, dtype=np.uint8),
        instance=np.zeros(sensor.shape, dtype=np.uint32),
        intensity=np.where(depth > 0, intensity, 0).astype(np.float32),
    )


NOTHING = np.zeros(SENSOR.shape)


def reported(generated: RangeImage, simulated: RangeImage, cast: RangeImage | None = None) -> RangeImage:
    """With no more surfaces than the simulated scan has returns, or those of `cast`."""
    return postprocess(generated, cast or simulated, simulated, np.random.default_rng(0))


def test_ranges_that_agree_are_the_simulated_ones() -> None:
    depth = np.full(SENSOR.shape, 20.0)
    simulated = image(depth + 0.9 * np.sin(np.arange(16)))
    np.testing.assert_array_equal(reported(image(depth), simulated).depth, simulated.depth)


def test_ranges_beyond_the_end_of_the_state_are_the_simulated_ones() -> None:
    sensor = dataclasses.replace(SENSOR, max_range=200.0)
    simulated = image(np.full(SENSOR.shape, 170.0), sensor=sensor)
    found = reported(image(np.full(SENSOR.shape, MAX_DEPTH), sensor=sensor), simulated)
    np.testing.assert_array_equal(found.depth, simulated.depth)


def test_nothing_is_added_at_the_end_of_the_state() -> None:
    sensor = dataclasses.replace(SENSOR, max_range=200.0)
    depth = np.full(SENSOR.shape, 119.9)
    depth[:, :8] = 110.0
    found = reported(image(depth, sensor=sensor), image(NOTHING, sensor=sensor))
    assert found.valid[:, :8].all()
    assert not found.valid[:, 8:].any()


def test_other_ranges_get_the_noise_of_the_sensor() -> None:
    found = reported(image(np.full(SENSOR.shape, 10.0)), image(np.full(SENSOR.shape, 20.0))).depth
    assert 0.005 < (found - 10.0).std() < 0.02
    assert np.abs(found - 10.0).max() < 0.06


def test_a_return_in_the_air_becomes_the_simulated_one() -> None:
    depth = np.full(SENSOR.shape, 20.0)
    depth[3, 5], depth[6, 0] = 7.0, 9.0
    simulated = np.full(SENSOR.shape, 20.0)
    simulated[6, 0] = 0
    found = reported(image(depth), image(simulated, 0.2))
    assert found.depth[3, 5] == 20.0
    assert found.intensity is not None
    np.testing.assert_allclose(found.intensity[3, 4:7], [0.5, 0.2, 0.5], atol=0.003)
    assert found.depth[6, 0] == found.intensity[6, 0] == 0
    assert found.valid.sum() == found.valid.size - 1


def test_what_is_lost_on_surfaces_is_what_the_simulated_scan_lost() -> None:
    surface = image(np.full(SENSOR.shape, 20.0))
    lost, taken = np.full(SENSOR.shape, 20.0), np.full(SENSOR.shape, 20.0)
    lost[2, 3:6], taken[5, 7:9] = 0, 0
    found = reported(image(taken), image(lost, 0.2), surface)
    np.testing.assert_array_equal(found.valid, lost > 0)
    assert found.intensity is not None
    np.testing.assert_allclose(found.intensity[5, 6:10], [0.5, 0.2, 0.2, 0.5], atol=0.003)


def test_where_the_layout_has_no_surface_returns_are_added() -> None:
    half = np.where(np.arange(16) < 8, 20.0, 0.0) * np.ones(SENSOR.shape)
    assert reported(image(np.full(SENSOR.shape, 20.0)), image(half)).valid.all()


def test_dark_readings_of_zero_stay_and_all_are_whole_steps() -> None:
    depth = np.full(SENSOR.shape, 20.0)
    simulated, generated = image(depth), image(depth)
    assert simulated.intensity is not None
    assert generated.intensity is not None
    simulated.intensity[0] = 0
    generated.intensity[0, :4], generated.intensity[0, 4:8] = 0.05, 0.3
    generated.intensity[1] = 0.1234
    read = reported(generated, simulated).intensity
    assert read is not None
    assert (read[0, :4] == 0).all()
    assert (read[0, 4:8] > 0.29).all()
    np.testing.assert_allclose(read * 255, np.round(read * 255), atol=1e-4)
    assert (read[1] > 0.12).all()


def test_neighbours_are_found_around_a_ring_alone() -> None:
    depth = np.zeros(SENSOR.shape)
    depth[4, [0, -1]] = 15.0
    assert reported(image(depth), image(NOTHING)).valid.sum() == 2
    sector = dataclasses.replace(SENSOR, azimuth_start=1.0, azimuth_span=2.0)
    assert not reported(image(depth, sensor=sector), image(NOTHING, sensor=sector)).valid.any()


def test_ranges_stay_within_those_of_the_sensor() -> None:
    far = reported(image(np.full(SENSOR.shape, 100.0)), image(NOTHING))
    assert far.valid.all()
    assert far.depth.max() <= 100.0
