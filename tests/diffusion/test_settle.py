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


def test_a_return_that_both_have_keeps_the_simulated_range() -> None:
    depth = np.full(SENSOR.shape, 20.0)
    simulated = image(depth + 5 * np.sin(np.arange(16)), 0.2)
    found = settled(image(depth), simulated)
    np.testing.assert_array_equal(found.depth, simulated.depth)
    assert found.intensity is not None
    assert (found.intensity == 0.5).all()


def test_a_return_that_the_network_drops_is_none() -> None:
    depth = np.full(SENSOR.shape, 20.0)
    depth[2, 3] = 0
    found = settled(image(depth), image(np.full(SENSOR.shape, 20.0)))
    assert found.depth[2, 3] == 0
    assert found.valid.sum() == found.valid.size - 1


def test_added_returns_get_the_noise_of_the_sensor() -> None:
    simulated = np.full(SENSOR.shape, 20.0)
    simulated[:, :8] = 0
    found = settled(image(np.full(SENSOR.shape, 10.0)), image(simulated)).depth
    assert 0.005 < (found[:, :8] - 10.0).std() < 0.02
    assert np.abs(found[:, :8] - 10.0).max() < 0.06


def test_an_added_return_in_the_air_is_none() -> None:
    depth = np.full(SENSOR.shape, 20.0)
    depth[3, 5], depth[6, 0] = 7.0, 20.4
    simulated = np.full(SENSOR.shape, 20.0)
    simulated[3, 5] = simulated[6, 0] = 0
    found = settled(image(depth), image(simulated))
    assert found.intensity is not None
    assert found.depth[3, 5] == found.intensity[3, 5] == 0
    assert found.valid.sum() == found.valid.size - 1


def test_a_simulated_return_in_the_air_stays() -> None:
    simulated = np.full(SENSOR.shape, 20.0)
    simulated[3, 5] = 7.0
    assert settled(image(np.full(SENSOR.shape, 20.0)), image(simulated)).depth[3, 5] == 7.0


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
