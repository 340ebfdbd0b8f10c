"""Sub-rays become echoes: what is one, and which counts."""

import numpy as np
import pytest

from lidardraft.scene.receiver import receive, winners


def echo(depth: list[float], power: list[float], primitive: list[int] | None = None, **options: bool):
    """The range, power and winning sub-ray of one beam."""
    stacked = [np.array(values)[None, :, None] for values in (depth, power, primitive or list(range(len(depth))))]
    ranges, powers, primitives = stacked[0].astype(np.float32), stacked[1].astype(np.float32), stacked[2]
    echoes = receive(ranges, powers, primitives, pulse_length=0.75, **options)
    return echoes.depth.item(), echoes.power.item(), winners(np.arange(len(depth))[None, :, None], echoes).item()


def test_echoes_within_a_pulse_are_one_at_their_mean_weighted_by_power():
    assert echo([10.0, 10.0, 10.6], [1.0, 1.0, 2.0]) == (pytest.approx(10.3), 4.0, 2)


def test_of_echoes_apart_the_strongest_counts_though_a_single_ray_is_brighter():
    assert echo([10.0, 30.0, 30.0], [3.0, 2.0, 2.5]) == (30.0, 4.5, 2)
    assert echo([10.0, 30.0, 30.0], [5.0, 2.0, 2.5]) == (10.0, 5.0, 0)


def test_the_last_echo_counts_if_it_is_loud_enough():
    assert echo([10.0, 30.0, 30.0], [5.0, 0.6, 0.7], last=True) == pytest.approx((30.0, 1.3, 2))
    assert echo([10.0, 30.0, 30.0], [5.0, 0.2, 0.3], last=True) == (10.0, 5.0, 0)


def test_sub_rays_that_meet_nothing_only_take_power_away():
    assert echo([0.0, 20.0, 0.0], [0.0, 1.5, 0.0], [-1, 4, -1]) == (20.0, 1.5, 1)
    assert echo([0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [-1, -1, -1])[:2] == (0.0, 0.0)


def test_a_single_ray_is_its_own_echo():
    assert echo([12.0], [0.5]) == (12.0, 0.5, 0)


def test_the_quick_way_and_the_careful_way_agree():
    rng = np.random.default_rng(0)
    depth = rng.uniform(10.0, 10.7, (16, 5, 64)).astype(np.float32)
    power = rng.uniform(0.1, 2.0, depth.shape).astype(np.float32)
    one, many = np.zeros(depth.shape, int), np.arange(5)[None, :, None] + np.zeros(depth.shape, int)
    quick, careful = (receive(depth, power, primitive, pulse_length=0.75) for primitive in (one, many))
    assert len(quick.mixed) == 0
    assert len(careful.mixed) == 16 * 64
    np.testing.assert_allclose(quick.depth, careful.depth, rtol=1e-6)
    np.testing.assert_allclose(quick.power, careful.power, rtol=1e-6)
    of_rays = np.arange(depth.size).reshape(depth.shape)
    brightest = np.take_along_axis(of_rays, power.argmax(axis=1)[:, None], axis=1)[:, 0]
    np.testing.assert_array_equal(winners(of_rays, careful), brightest)
