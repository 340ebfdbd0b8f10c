"""Power and intensity against closed forms."""

import math
from dataclasses import replace

import numpy as np
import pytest
from observed_walls import IDEAL, seen, wall

from lidardraft.errors import SensorError
from lidardraft.scene.intensity_curve import IntensityCurve
from lidardraft.scene.weather import Weather


def test_power_falls_with_the_square_of_range():
    # what is not corrected for range shows the power
    model = replace(IDEAL, compensation_range=1e-3, full_scale=1e-8)
    near, far = (seen(wall(distance), model).intensity for distance in (10.0, 20.0))
    np.testing.assert_allclose(near, 0.45 * (1e-3 / 10.0) ** 2 / 1e-8, rtol=0.01)
    np.testing.assert_allclose(far, near / 4, rtol=1e-5)


def test_fog_takes_its_share_there_and_back():
    model = replace(
        IDEAL, divergence_h=1e-6, divergence_v=1e-6, pulse_duration=1e-15
    )  # an echo of fog itself is of no power
    clear, fog = (seen(wall(30.0), model, weather=Weather(visibility=v)) for v in (math.inf, 150.0))
    np.testing.assert_allclose(fog.intensity / clear.intensity, np.exp(-2 * 3.91 / 150.0 * clear.depth), rtol=1e-5)


def test_intensity_is_calibrated_saturates_and_is_rounded():
    white = replace(IDEAL, full_scale=0.4)
    assert seen(wall(5.0, "plaster"), white).intensity.max() == 1.0
    tenths = replace(IDEAL, levels=10)
    np.testing.assert_allclose(np.unique(seen(wall(5.0, "brick"), tenths).intensity), [0.4])
    for distance in (5.0, 40.0):
        assert seen(wall(distance), IDEAL).intensity.mean() == pytest.approx(0.45, rel=0.01)
    # what is corrected to 40 m has half left there
    assert seen(wall(40.0), replace(IDEAL, compensation_range=40.0)).intensity.mean() == pytest.approx(0.225, rel=0.01)


def test_a_knee_keeps_the_upper_scale_for_retroreflectors():
    model = replace(IDEAL, knee=100 / 255, full_scale=300.0)
    assert seen(wall(10.0, "plaster"), model).intensity.mean() == pytest.approx(0.45 * 100 / 255, rel=0.01)
    bright = seen(wall(10.0, "retroreflector"), model).intensity
    assert bright.min() > 100 / 255
    assert bright.max() <= 1.0


def test_a_curve_is_linear_in_the_logarithm_and_each_beam_may_have_its_own():
    flat, steep, low, dark = (0.4, 0.4, 0.4), (0.0, 0.65, 1.0), (0.1, 0.4, 0.9), (0.0, 0.1, 0.2)
    curve = IntensityCurve(
        responses=(0.045, 0.45, 4.5), readings=(flat, steep, low, dark), cutoffs=(0.0, 0.7, 0.2, 0.11)
    )
    for model, expected in (
        (replace(IDEAL, intensity_curve=curve), [0.4, 0.0, 0.4, 0.0]),
        (replace(IDEAL, intensity_curve=replace(curve, readings=(low,), cutoffs=())), [0.4] * 4),
    ):
        np.testing.assert_allclose(seen(wall(10.0), model).intensity.T, np.tile(expected, (1024, 1)), atol=3e-3)
    third = replace(curve, responses=(0.45 / 10, 0.45 * 10, 45.0), readings=(low,), cutoffs=())
    np.testing.assert_allclose(seen(wall(10.0), replace(IDEAL, intensity_curve=third)).intensity, 0.25, atol=3e-3)


def test_a_curve_has_gains_by_distance():
    curve = IntensityCurve(
        responses=(0.0045, 0.45), readings=((0.0, 1.0),), distances=(10.0, 20.0), distance_gains=((0.1, 0.01),)
    )
    near, middle, far = (
        seen(wall(distance), replace(IDEAL, intensity_curve=curve)).intensity for distance in (5.0, 15.0, 40.0)
    )
    for read, expected in ((near, 0.5), (middle, 0.25), (far, 0.0)):
        np.testing.assert_allclose(read, expected, atol=2e-3)
    each = replace(curve, distance_gains=((0.1, 0.01), (1.0, 1.0), (0.01, 0.01), (0.1, 0.01)))
    read = seen(wall(5.0), replace(IDEAL, intensity_curve=each)).intensity
    np.testing.assert_allclose(read.T, np.tile([0.5, 1.0, 0.0, 0.5], (1024, 1)), atol=2e-3)


def test_a_curve_of_another_sensor_is_refused():
    curve = IntensityCurve(responses=(0.1,), readings=((0.5,),), cutoffs=(0.1, 0.1))
    with pytest.raises(SensorError, match="cutoffs of the intensity curve has 2 values; it needs 4"):
        seen(wall(10.0), replace(IDEAL, intensity_curve=curve))


def test_speckle_texture_and_grain_scatter_the_intensity():
    for change, spread in (({"speckle": 0.1}, 0.1), ({"texture": 0.1}, 0.1), ({"material_noise": True}, 0.08)):
        logarithm = np.log(seen(wall(10.0), replace(IDEAL, **change)).intensity / 0.45)
        assert logarithm.std() == pytest.approx(spread, rel=0.2)
        beside = np.corrcoef(logarithm[:, 1:].ravel(), logarithm[:, :-1].ravel())[0, 1]
        # patches of 3 columns on average
        assert beside == pytest.approx(2 / 3, abs=0.08) if "texture" in change else abs(beside) < 0.1
        assert abs(np.corrcoef(logarithm[1], logarithm[2])[0, 1]) < 0.15


def test_dust_darkens_the_same_places_in_every_scan():
    stained = [seen(wall(10.0), replace(IDEAL, dust=2.0), seed=seed).intensity for seed in (0, 1)]
    np.testing.assert_array_equal(*stained)
    dark = stained[0] < 0.44
    assert 0.01 < dark.mean() < 0.3
    assert (stained[0] <= 0.46).all()


def test_what_would_read_less_than_the_cutoff_reads_0():
    usual = seen(wall(12.0), IDEAL).intensity
    np.testing.assert_array_equal(seen(wall(12.0), replace(IDEAL, cutoff=0.4)).intensity, usual)
    assert not seen(wall(12.0), replace(IDEAL, cutoff=0.5)).intensity.any()
    differing = seen(wall(12.0), replace(IDEAL, cutoff=0.45, cutoff_spread=0.3, unit=2)).intensity
    assert set((differing > 0).mean(axis=1)) == {0.0, 1.0}  # whole beams


def test_the_cutoffs_of_one_unit_are_the_same_in_every_scan():
    model = replace(IDEAL, cutoff=0.45, cutoff_spread=0.3)
    zero = [[seen(wall(12.0), replace(model, unit=u), seed=s).intensity[:, 0] == 0 for s in (0, 1)] for u in (0, 2)]
    np.testing.assert_array_equal(zero[0][0], zero[0][1])
    np.testing.assert_array_equal(zero[1][0], zero[1][1])
