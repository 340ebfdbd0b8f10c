import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lidardraft.diffusion.codec import (
    CONDITION_CHANNELS,
    CONDITION_PARTS,
    DEPTH,
    INTENSITY,
    MAX_DEPTH,
    VALIDITY,
    decode_scan,
    encode_condition,
    encode_rays,
    encode_scan,
)
from lidardraft.errors import SensorError
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.sensor import Sensor

SENSOR = Sensor(name="small", elevations=(0.1, 0.0, -0.1, -0.2), columns=8)


def image(depth: np.ndarray, label: int = 13, intensity: np.ndarray | None = None) -> RangeImage:
    return RangeImage(
        sensor=SENSOR,
        depth=depth.astype(np.float32),
        label=np.where(depth > 0, label, 0).astype(np.uint8),
        instance=np.zeros(SENSOR.shape, dtype=np.uint32),
        intensity=None if intensity is None else intensity.astype(np.float32),
    )


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=30, deadline=None)
def test_a_scan_survives_the_state(seed: int) -> None:
    rng = np.random.default_rng(seed)
    valid = rng.random(SENSOR.shape) < 0.7
    depth = np.where(valid, rng.uniform(0.6, 119.9, SENSOR.shape), 0)
    scan = image(depth, intensity=np.where(valid, rng.random(SENSOR.shape), 0))
    state = encode_scan(scan)
    assert state.dtype == np.float32
    assert np.abs(state).max() <= 1 + 1e-6
    decoded = decode_scan(state, SENSOR)
    np.testing.assert_array_equal(decoded.valid, scan.valid)
    np.testing.assert_allclose(decoded.depth, scan.depth, rtol=1e-4)
    assert decoded.intensity is not None
    assert scan.intensity is not None
    np.testing.assert_allclose(decoded.intensity, scan.intensity, atol=1e-6)
    assert not decoded.label.any()


def test_depth_is_logarithmic_and_reaches_both_ends() -> None:
    depth = np.full(SENSOR.shape, MAX_DEPTH)
    depth[0] = 10.0
    state = encode_scan(image(depth))
    np.testing.assert_allclose(state[DEPTH, 1:], 1.0, atol=1e-6)
    np.testing.assert_allclose(state[DEPTH, 0], 2 * np.log2(11) / np.log2(121) - 1, atol=1e-6)


def test_dropped_pixels_take_the_depth_to_their_left_around_the_ring() -> None:
    depth = np.full(SENSOR.shape, 20.0)
    depth[0] = [0, 0, 5, 0, 0, 7, 0, 9]
    depth[1] = 0
    state = encode_scan(image(depth))
    expected = encode_scan(image(np.broadcast_to([9, 9, 5, 5, 5, 7, 7, 9], SENSOR.shape)))[DEPTH, 0]
    np.testing.assert_array_equal(state[DEPTH, 0], expected)
    np.testing.assert_array_equal(state[DEPTH, 1], 1.0)
    np.testing.assert_array_equal(state[VALIDITY, 0], [-1, -1, 1, -1, -1, 1, -1, 1])


def test_dropped_pixels_of_a_sector_do_not_look_around_the_ring() -> None:
    sector = dataclasses.replace(SENSOR, name="sector", azimuth_start=1.0, azimuth_span=2.0)
    depth = np.full(SENSOR.shape, 20.0)
    depth[0] = [0, 0, 5, 0, 0, 7, 0, 9]
    depth[1] = 0
    state = encode_scan(dataclasses.replace(image(depth), sensor=sector))
    expected = encode_scan(image(np.broadcast_to([5, 5, 5, 5, 5, 7, 7, 9], SENSOR.shape)))[DEPTH, 0]
    np.testing.assert_array_equal(state[DEPTH, 0], expected)
    np.testing.assert_array_equal(state[DEPTH, 1], 1.0)


def test_rolling_the_scan_rolls_the_state() -> None:
    rng = np.random.default_rng(0)
    depth = np.where(rng.random(SENSOR.shape) < 0.5, rng.uniform(1, 100, SENSOR.shape), 0)
    rolled = encode_scan(image(np.roll(depth, 3, axis=1)))
    np.testing.assert_array_equal(rolled, np.roll(encode_scan(image(depth)), 3, axis=2))


def test_a_scan_without_intensities_has_intensity_zero() -> None:
    assert (encode_scan(image(np.ones(SENSOR.shape)))[INTENSITY] == -1).all()


def test_a_depth_out_of_the_sensors_range_is_no_return() -> None:
    near = Sensor(name="near", elevations=SENSOR.elevations, columns=8, max_range=30.0)
    state = np.zeros((3, 4, 8), dtype=np.float32)
    state[VALIDITY] = 1
    state[DEPTH, 0] = 1.7  # beyond the end of the scale: clipped to 120 m
    state[DEPTH, 1] = -1.0  # 0 m
    decoded = decode_scan(state, near)
    assert not decoded.valid[:2].any()
    assert decoded.valid[2:].all()
    assert decoded.intensity is not None
    assert not decoded.intensity[:2].any()


def test_a_state_of_another_sensor_is_refused() -> None:
    with pytest.raises(SensorError, match=r"state is \(3, 5, 8\); small needs \(3, 4, 8\)"):
        decode_scan(np.zeros((3, 5, 8), dtype=np.float32), SENSOR)


def test_what_the_vehicle_hides_is_no_return() -> None:
    hidden = dataclasses.replace(SENSOR, blocked=(((-0.5, 0.5),), (), (), ()))
    state = np.zeros((3, 4, 8), dtype=np.float32)
    state[VALIDITY] = 1
    np.testing.assert_array_equal(decode_scan(state, hidden).valid, ~hidden.blocked_pixels)
    assert hidden.blocked_pixels.any()


def test_the_condition_says_class_depth_hit_and_the_simulated_scan() -> None:
    depth = np.full(SENSOR.shape, 10.0)
    depth[2, 5] = 0
    simulated = image(np.full(SENSOR.shape, 12.0), intensity=np.full(SENSOR.shape, 0.4))
    condition = encode_condition(image(depth), simulated)
    assert condition.shape == (CONDITION_CHANNELS, 4, 8)
    kind, (far, hit) = condition[CONDITION_PARTS["class"]], condition[CONDITION_PARTS["depth"]]
    np.testing.assert_array_equal(kind.sum(axis=0), 1)
    assert kind[13, 0, 0] == 1
    assert kind[0, 2, 5] == 1
    assert hit[0, 0] == 1
    assert hit[2, 5] == -1
    assert far[2, 5] == 1
    np.testing.assert_array_equal(far[0], encode_scan(image(depth))[DEPTH, 0])
    np.testing.assert_array_equal(condition[CONDITION_PARTS["simulated"]], encode_scan(simulated))


@pytest.mark.parametrize("name", ["hdl64e", "hdl32e", "vlp16", "os1-128"])
def test_every_sensors_rays_are_of_order_one(name: str) -> None:
    rays = encode_rays(Sensor.preset(name))
    assert rays.shape == (4, *Sensor.preset(name).shape)
    assert np.abs(rays).max() < 3


def test_rays_say_what_the_vehicle_hides() -> None:
    hidden = dataclasses.replace(SENSOR, blocked=(((-0.5, 0.5),), (), (), ()))
    np.testing.assert_array_equal(encode_rays(hidden)[3], hidden.blocked_pixels)


def test_one_beam_has_a_spacing() -> None:
    assert np.isfinite(encode_rays(Sensor(name="one", elevations=(0.0,), columns=8))).all()
