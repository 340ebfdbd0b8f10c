import dataclasses

import numpy as np

from lidardraft.diffusion.settle import settle
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


def settled(generated: RangeImage, simulated: RangeImage) -> RangeImage:
    return settle(generated, simulated, np.random.default_rng(0))


def test_ranges_that_agree_are_the_simulated_ones() -> None:
    depth = np.full(SENSOR.shape, 20.0)
    simulated = image(depth + 0.9 * np.sin(np.arange(16)))
    np.testing.assert_array_equal(settled(image(depth), simulated).depth, simulated.depth)


def test_other_ranges_get_the_noise_of_the_sensor() -> None:
    found = settled(image(np.full(SENSOR.shape, 10.0)), image(np.full(SENSOR.shape, 20.0))).depth
    assert 0.005 < (found - 10.0).std() < 0.02
    assert np.abs(found - 10.0).max() < 0.06


def test_a_return_in_the_air_becomes_the_simulated_one() -> None:
    depth = np.full(SENSOR.shape, 20.0)
    depth[3, 5], depth[6, 0] = 7.0, 9.0
    simulated = np.full(SENSOR.shape, 20.0)
    simulated[6, 0] = 0
    found = settled(image(depth), image(simulated, 0.2))
    assert found.depth[3, 5] == 20.0
    assert found.intensity is not None
    np.testing.assert_allclose(found.intensity[3, 4:7], [0.5, 0.2, 0.5])
    assert found.depth[6, 0] == found.intensity[6, 0] == 0
    assert found.valid.sum() == found.valid.size - 1


def test_neighbours_are_found_around_a_ring_alone() -> None:
    depth = np.zeros(SENSOR.shape)
    depth[4, [0, -1]] = 15.0
    nothing = np.zeros(SENSOR.shape)
    assert settled(image(depth), image(nothing)).valid.sum() == 2
    sector = dataclasses.replace(SENSOR, azimuth_start=1.0, azimuth_span=2.0)
    assert not settled(image(depth, sensor=sector), image(nothing, sensor=sector)).valid.any()


def test_ranges_stay_within_those_of_the_sensor() -> None:
    far = settled(image(np.full(SENSOR.shape, 100.0)), image(np.zeros(SENSOR.shape)))
    assert far.valid.all()
    assert far.depth.max() <= 100.0
