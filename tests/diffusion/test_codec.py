"""Scans and conditions as a network sees them."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lidardraft.diffusion.channels import (
    CLASS,
    DEPTH,
    INTENSITY,
    STATE_CHANNELS,
    VALIDITY,
)
from lidardraft.diffusion.codec import MAX_DEPTH, decode_scan, encode_rays, encode_scan
from lidardraft.errors import SensorError
from lidardraft.formats.pairs import IMAGES
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.raycast import raycast
from lidardraft.scene.sensor import Sensor
from lidardraft.semantics import BY_NAME, NUM_CLASSES
from lidardraft.training.stack import PairStack, as_tensors

SENSOR = Sensor(name="small", elevations=(0.1, 0.0, -0.1, -0.2), columns=8)


def image(depth: np.ndarray, label: int | np.ndarray = 13, intensity: np.ndarray | None = None) -> RangeImage:
    return RangeImage(
        sensor=SENSOR,
        depth=depth.astype(np.float32),
        label=np.where(depth > 0, label, 0).astype(np.uint8),
        instance=np.zeros(SENSOR.shape, dtype=np.uint32),
        intensity=None if intensity is None else intensity.astype(np.float32),
    )


FAR = encode_scan(image(np.full(SENSOR.shape, MAX_DEPTH)))[DEPTH]  # what a row without returns has


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=30, deadline=None)
def test_a_scan_survives_the_state(seed: int) -> None:
    rng = np.random.default_rng(seed)
    valid = rng.random(SENSOR.shape) < 0.7
    depth = np.where(valid, rng.uniform(0.6, 119.9, SENSOR.shape), 0)
    label, intensity = rng.integers(1, NUM_CLASSES, SENSOR.shape), np.where(valid, rng.random(SENSOR.shape), 0)
    scan = image(depth, label, intensity)
    state = encode_scan(scan)
    assert state.dtype == np.float32
    decoded = decode_scan(state, SENSOR)
    np.testing.assert_array_equal(decoded.valid, scan.valid)
    np.testing.assert_allclose(decoded.depth, scan.depth, rtol=1e-4)
    assert decoded.intensity is not None
    assert scan.intensity is not None
    np.testing.assert_allclose(decoded.intensity, scan.intensity, atol=1e-6)
    np.testing.assert_array_equal(decoded.label, scan.label)
    assert not decoded.instance.any()


@pytest.mark.parametrize("height", [1.5, 3.0])
def test_flat_ground_is_zero_for_any_sensor_and_the_rays_say_how_far_it_is(height: float) -> None:
    elevations = (-0.2, -0.3, -0.5) if height > 2 else (-0.1, -0.25)
    sensor = Sensor(name="down", elevations=elevations, columns=8, mount_height=height)
    ground = Layout((Primitive(shape="plane", center=(0, 0, 0), size=(99, 99, 0), label="road", id="road"),))
    scan = raycast(ground, sensor)
    assert scan.valid.all()
    np.testing.assert_allclose(encode_scan(scan)[DEPTH], 0.0, atol=1e-5)
    np.testing.assert_allclose(encode_rays(sensor)[3], np.log2(scan.depth + 1) - 3, atol=1e-5)


def test_a_beam_that_sees_no_ground_nearby_is_compared_with_twenty_metres() -> None:
    depth = np.full(SENSOR.shape, 20.0)
    depth[1] = 41.0
    state = encode_scan(image(depth))
    np.testing.assert_allclose(state[DEPTH, 0], 0.0, atol=1e-6)
    np.testing.assert_allclose(state[DEPTH, 1], 1 / 1.2, atol=1e-6)  # twice as far, and one octave is 1 / 1.2


def test_a_class_is_the_bits_of_its_id_and_bits_of_no_class_are_other() -> None:
    state = encode_scan(image(np.full(SENSOR.shape, 5.0), label=0b10011))
    np.testing.assert_array_equal(state[CLASS, 0, 0], [0.5, 0.5, -0.5, -0.5, 0.5])
    state[CLASS, 0] = 0.1  # the bits of 31
    decoded = decode_scan(state, SENSOR)
    assert (decoded.label[0] == BY_NAME["other"].id).all()
    assert (decoded.label[1:] == 0b10011).all()
    assert 2 ** (CLASS.stop - CLASS.start) >= NUM_CLASSES


def test_dropped_pixels_take_the_depth_to_their_left_around_the_ring() -> None:
    depth = np.full(SENSOR.shape, 20.0)
    depth[0] = [0, 0, 5, 0, 0, 7, 0, 9]
    depth[1] = 0
    state = encode_scan(image(depth))
    expected = encode_scan(image(np.broadcast_to([9, 9, 5, 5, 5, 7, 7, 9], SENSOR.shape)))[DEPTH, 0]
    np.testing.assert_array_equal(state[DEPTH, 0], expected)
    np.testing.assert_array_equal(state[DEPTH, 1], FAR[1])
    np.testing.assert_array_equal(state[VALIDITY, 0], [-1, -1, 1, -1, -1, 1, -1, 1])


def test_dropped_pixels_of_a_sector_do_not_look_around_the_ring() -> None:
    sector = dataclasses.replace(SENSOR, name="sector", azimuth_start=1.0, azimuth_span=2.0)
    depth = np.full(SENSOR.shape, 20.0)
    depth[0] = [0, 0, 5, 0, 0, 7, 0, 9]
    depth[1] = 0
    state = encode_scan(dataclasses.replace(image(depth), sensor=sector))
    expected = encode_scan(image(np.broadcast_to([5, 5, 5, 5, 5, 7, 7, 9], SENSOR.shape)))[DEPTH, 0]
    np.testing.assert_array_equal(state[DEPTH, 0], expected)
    np.testing.assert_array_equal(state[DEPTH, 1], FAR[1])


def test_a_scan_without_intensities_has_the_mean_one() -> None:
    without = encode_scan(image(np.ones(SENSOR.shape)))[INTENSITY]
    assert not without.any()
    dark, bright = (encode_scan(image(np.ones(SENSOR.shape), intensity=np.full(SENSOR.shape, i))) for i in (0, 1))
    assert (dark[INTENSITY] < -1).all()
    assert (bright[INTENSITY] > 1).all()


def test_a_depth_out_of_the_sensors_range_is_no_return() -> None:
    near = Sensor(name="near", elevations=SENSOR.elevations, columns=8, max_range=30.0)
    state = np.zeros((STATE_CHANNELS, 4, 8), dtype=np.float32)
    state[VALIDITY] = 1
    state[DEPTH, 0] = 9.0  # beyond the end of the scale: clipped to 120 m
    state[DEPTH, 1] = -9.0  # 0 m
    decoded = decode_scan(state, near)
    assert not decoded.valid[:2].any()
    assert decoded.valid[2:].all()
    assert decoded.intensity is not None
    assert not decoded.intensity[:2].any()
    assert decoded.intensity[2:].all()


def test_a_state_of_another_sensor_is_refused() -> None:
    with pytest.raises(SensorError, match=r"state is \(8, 5, 8\); small needs \(8, 4, 8\)"):
        decode_scan(np.zeros((8, 5, 8), dtype=np.float32), SENSOR)


def test_what_the_vehicle_hides_is_no_return() -> None:
    hidden = dataclasses.replace(SENSOR, blocked=(((-0.5, 0.5),), (), (), ()))
    state = np.zeros((STATE_CHANNELS, 4, 8), dtype=np.float32)
    state[VALIDITY] = 1
    np.testing.assert_array_equal(decode_scan(state, hidden).valid, ~hidden.blocked_pixels)
    assert hidden.blocked_pixels.any()


def test_rays_say_what_the_vehicle_hides() -> None:
    hidden = dataclasses.replace(SENSOR, blocked=(((-0.5, 0.5),), (), (), ()))
    np.testing.assert_array_equal(encode_rays(hidden)[4], hidden.blocked_pixels)


def test_one_beam_has_a_spacing() -> None:
    assert np.isfinite(encode_rays(Sensor(name="one", elevations=(0.0,), columns=8))).all()


def state_by_hand(sensor: Sensor, depth: np.ndarray, label: np.ndarray, intensity: np.ndarray | None) -> np.ndarray:
    """The state of a scan, pixel by pixel in float64, as `encode_scans` says it in words."""
    state = np.zeros((STATE_CHANNELS, *sensor.shape))
    for row, column in np.ndindex(*sensor.shape):
        to_the_left = [depth[row, c] for c in range(column, -1, -1)]
        further = [depth[row, c] for c in range(sensor.columns - 1, column, -1)] if sensor.wraps else depth[row]
        found = next((d for d in [*to_the_left, *further] if d > 0), MAX_DEPTH)
        sine = np.sin(-sensor.elevations[row])
        ground = sensor.mount_height / sine if sine * 20 > sensor.mount_height else 20.0
        state[DEPTH, row, column] = (np.log2(min(found, MAX_DEPTH) + 1) - np.log2(ground + 1)) / 1.2
        if intensity is not None:
            state[INTENSITY, row, column] = 2.9 * np.sqrt(intensity[row, column]) - 1.65
        state[VALIDITY, row, column] = 1 if depth[row, column] > 0 else -1
        state[CLASS, row, column] = [0.5 if label[row, column] >> bit & 1 else -0.5 for bit in range(5)]
    return state


@pytest.mark.parametrize("span", [2 * np.pi, 2.0])
def test_stacks_of_compact_images_are_encoded_as_a_loop_over_pixels_would(span: float) -> None:
    rng = np.random.default_rng(0)
    elevations = tuple(np.linspace(0.05, -0.4, 16).tolist())
    sensor = Sensor(name="some", elevations=elevations, columns=48, azimuth_start=span / 2, azimuth_span=span)
    rows = {name: rng.integers(0, 256, (3, 16, 48)).astype(dtype) for name, dtype in IMAGES.items()}
    for part in ("scan", "condition"):
        rows[f"{part}_depth"] = rng.integers(0, 65536, (3, 16, 48)).astype(np.uint16)
        rows[f"{part}_depth"][rng.random((3, 16, 48)) < 0.4] = 0
    rows["scan_depth"][0, 3] = 0
    for name in ("scan_label", "condition_label"):
        rows[name] %= NUM_CLASSES
    stack = PairStack.of(sensor, as_tensors(rows))
    depths = {part: rows[f"{part}_depth"] * 0.002 for part in ("scan", "condition")}
    states, conditions = stack.states().numpy(), stack.conditions().numpy()
    for n in range(3):
        intensity = rows["scan_intensity"][n] / 255
        scan = state_by_hand(sensor, depths["scan"][n], rows["scan_label"][n], intensity)
        np.testing.assert_allclose(states[n], scan, rtol=0, atol=1e-6)
        cast = state_by_hand(sensor, depths["condition"][n], rows["condition_label"][n], None)
        np.testing.assert_allclose(conditions[n], cast, rtol=0, atol=1e-6)
