"""Weather against the closed forms of its sources."""

import math

import numpy as np
import pytest

from lidardraft.errors import SensorError
from lidardraft.scene.weather import (
    Weather,
    first_particle,
    fog_echo,
    fog_extinction,
    particles,
    rain_extinction,
    snow_extinction,
)


def test_koschmieder_at_550_nm_and_in_thick_fog_at_any_wavelength():
    # at the visibility 2 per cent of the contrast is left; below 500 m the wavelength does not matter (Kim)
    for visibility in (50.0, 200.0, 500.0):
        assert math.exp(-fog_extinction(visibility) * visibility) == pytest.approx(0.02, rel=0.01)
    # Kruse: 3.91 / V (905 / 550)^-1.3 in clear air of 20 km
    assert fog_extinction(20_000.0) == pytest.approx(3.91 / 20_000 * (905 / 550) ** -1.3)
    assert fog_extinction(math.inf) == 0.0


def test_rain_and_snow_as_itu_p_1814_has_them():
    decibels = 10 / math.log(10) * 1000
    assert rain_extinction(10.0) * decibels == pytest.approx(1.076 * 10**0.67)
    assert snow_extinction(2.0) * decibels == pytest.approx((1.023e-4 * 905 + 3.7855) * 2**0.72)
    assert rain_extinction(0.0) == snow_extinction(0.0) == Weather().extinction == 0.0


def test_extinctions_add_up():
    weather = Weather(rain=5.0, snow=1.0, visibility=300.0)
    assert weather.extinction == pytest.approx(fog_extinction(300.0) + rain_extinction(5.0) + snow_extinction(1.0))


def test_marshall_and_palmer_count_the_drops():
    # the integral of 8000 exp(-4.1 R^-0.21 D) per m3 and mm over half a millimetre and more
    slope = 4.1 * 10.0**-0.21
    density, least, larger, _ = particles(Weather(rain=10.0))
    assert density == pytest.approx(8000 / slope * math.exp(-slope * 0.5))
    assert least == 0.5e-3
    assert larger == pytest.approx(1e-3 / slope)
    assert particles(Weather()) == (0.0, 0.0, 0.0, 0.0)


def test_the_first_drop_is_met_as_often_as_the_beam_has_room_for_drops():
    weather = Weather(snow=1.0)
    met, _ = first_particle(weather, (3e-3, 1.5e-3), (40_000,), np.random.default_rng(0))
    steps = np.linspace(0.95, 10.0, 20_001)
    volume = np.trapezoid(math.pi / 4 * (0.011 + 3e-3 * steps) * (0.011 + 1.5e-3 * steps), steps)
    share = ((met > 0) & (met < 10.0)).mean()
    assert share == pytest.approx(1 - math.exp(-particles(weather)[0] * volume), rel=0.03)


def test_no_drop_without_rain_and_no_fog_in_clear_air():
    rng = np.random.default_rng(0)
    for depth, response in (
        first_particle(Weather(), (3e-3, 1e-3), (100,), rng),
        fog_echo(Weather(), 0.75, (100,), rng),
    ):
        assert not response.any()
        assert not depth.any()


def test_fog_sends_light_back_from_near_the_sensor_and_more_so_the_thicker_it_is():
    thick, thin = (fog_echo(Weather(visibility=v), 0.75, (1000,), np.random.default_rng(0)) for v in (50.0, 200.0))
    assert thick[1][0] == pytest.approx(math.pi * 0.046 / 50 * 0.75)
    assert thick[1][0] == pytest.approx(4 * thin[1][0])
    assert 0.95 <= thick[0].min() <= thick[0].max() <= 9.5 + 1e-5
    assert np.median(thick[0]) < 2.0


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"rain": "a"}, r"rain is 'a'; it must be 0 to 200"),
        ({"snow": None}, r"snow is None; it must be 0 to 200"),
        ({"wetness": True}, r"wetness is True; it must be 0 to 1"),
        ({"visibility": [100.0]}, r"visibility is \[100\.0\]; it must be 0 to inf"),
        ({"rain": -1.0}, r"rain is -1\.0; it must be 0 to 200"),
        ({"snow": math.nan}, "snow is nan; it must be 0 to 200"),
        ({"visibility": 0.0}, r"visibility is 0\.0; it must be more than 0"),
        ({"wetness": 2.0}, r"wetness is 2\.0; it must be 0 to 1"),
    ],
)
def test_weather_that_cannot_be(wrong, message):
    with pytest.raises(SensorError, match=message):
        Weather(**wrong)
