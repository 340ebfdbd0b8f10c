"""Rain, fog and snow between sensor and target: extinction of light, and backscatter from the air.

Extinction per metre follows ITU-R P.1814 (2007): fog by visibility (Koschmieder's law with the wavelength law of Kruse
as Kim amends it), rain after Carbonneau, snow wet or dry. Backscatter of fog is that of Hahner et al. (ICCV 2021). Rays
meet raindrops and snowflakes one by one, in the numbers that Marshall and Palmer (1948) and Gunn and Marshall (1958)
counted, as Hahner et al. (CVPR 2022) sample snow. Their light is that of a small target near by. A receiver with a
distant focus sees it blurred: only a part falls on its detector (the form factor of the lidar equation).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np

from lidardraft.errors import SensorError
from lidardraft.json_fields import is_number

_WAVELENGTH = 905.0  # nm
_PER_DECIBEL_KM = math.log(10.0) / 10.0 / 1000.0  # dB/km to 1/m
_OVERLAP = 0.95  # m; the receiver does not see the beam before (Hahner et al., 2021: 0.9 to 1.0)
_APERTURE = 0.011  # m, width of the beam at the window (12.7 x 9.5 mm in Velodyne's VLP-16 manual, 9.5 mm of an OS1)
_LENS = 0.025  # m, width of the receiver's: an estimate
_REACH = 40.0  # m; no single raindrop or snowflake beyond is bright enough
# Light that comes straight back, over that of a white disc of the same width. A raindrop reflects at its front and,
# focused by the drop, at its back: R / 4 and R (1 - R)^2 (n / (2 - n))^2 / 4 with n = 1.33, R = 0.02. The value of a
# snowflake is an estimate.
_WATER, _ICE = 0.024, 0.8


@dataclass(frozen=True, kw_only=True, slots=True)
class Weather:
    """`rain` and `snow` [mm/h of water], `visibility` in fog [m] (inf: none), `wetness` of the ground, 0 to 1.

    Raises `SensorError` naming the invalid value.
    """

    rain: float = 0.0
    snow: float = 0.0
    visibility: float = math.inf
    wetness: float = 0.0

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            most = {"visibility": math.inf, "wetness": 1.0}.get(field.name, 200.0)
            if not (isinstance(value, float) or is_number(value)) or not 0.0 <= value <= most:  # inf is no `is_number`
                raise SensorError(f"{field.name} is {value!r}; it must be 0 to {most:g}")
        if self.visibility == 0.0:
            raise SensorError(f"visibility is {self.visibility}; it must be more than 0")

    @property
    def extinction(self) -> float:
        """Light lost per metre of the way [1/m]; twice that there and back."""
        return fog_extinction(self.visibility) + rain_extinction(self.rain) + snow_extinction(self.snow)

    @property
    def scatters(self) -> bool:
        """Whether anything in the air sends light back."""
        return self.rain > 0 or self.snow > 0 or not math.isinf(self.visibility)


# The weather words of sentences. Rates are in the middle of the classes of the American Meteorological Society (light
# rain is less than 2.5 mm/h, heavy rain more than 7.6 mm/h). Visibilities are below those of mist and fog of the World
# Meteorological Organization (5 km, 1 km), and show within the range of a sensor.
WEATHERS = {
    "light-rain": Weather(rain=2.0, wetness=0.5),
    "rain": Weather(rain=5.0, wetness=0.8),
    "heavy-rain": Weather(rain=20.0, wetness=1.0),
    "light-snow": Weather(snow=0.5),
    "snow": Weather(snow=1.5),
    "heavy-snow": Weather(snow=4.0),
    "mist": Weather(visibility=800.0),
    "fog": Weather(visibility=200.0),
    "dense-fog": Weather(visibility=60.0),
    "wet": Weather(wetness=1.0),
}


def weather_of(name: str | None) -> Weather:
    """The weather of that name in WEATHERS; clear and dry if it is None."""
    return Weather() if name is None else WEATHERS[name]


def fog_extinction(visibility: float) -> float:
    """Extinction [1/m] in fog of a visibility [m]: 3.91 / V at 550 nm, corrected for the wavelength."""
    if math.isinf(visibility):
        return 0.0
    kilometres = visibility / 1000.0
    if kilometres > 6.0:
        power = 1.6 if kilometres > 50.0 else 1.3
    elif kilometres > 1.0:
        power = 0.16 * kilometres + 0.34
    else:
        power = max(kilometres - 0.5, 0.0)
    return 3.91 / visibility * (_WAVELENGTH / 550.0) ** -power


def rain_extinction(rate: float) -> float:
    """Extinction [1/m] in rain of a rate [mm/h]."""
    return float(1.076 * rate**0.67 * _PER_DECIBEL_KM)


def snow_extinction(rate: float) -> float:
    """Extinction [1/m] in wet snow of a rate [mm/h of water]."""
    return float((1.023e-4 * _WAVELENGTH + 3.7855) * rate**0.72 * _PER_DECIBEL_KM)


def particles(weather: Weather) -> tuple[float, float, float, float]:
    """Raindrops or snowflakes: their number in a cubic metre, least diameter [m], mean excess over it [m], and the
    share of light that one returns.

    Diameters are exponentially distributed, N0 exp(-L D), cut at half a millimetre for raindrops and one for
    snowflakes; a smaller one alone is never detected. In sleet the snowflakes count.
    """
    if weather.snow > 0:
        slope = 2550.0 * weather.snow**-0.48  # 1/m
        return _exponential(3.8e6 * weather.snow**-0.87, slope, 1e-3, _ICE)
    if weather.rain > 0:
        return _exponential(8.0e6, 4100.0 * weather.rain**-0.21, 0.5e-3, _WATER)
    return 0.0, 0.0, 0.0, 0.0


def _exponential(most: float, slope: float, least: float, share: float) -> tuple[float, float, float, float]:
    return most / slope * math.exp(-slope * least), least, 1.0 / slope, share


def first_particle(
    weather: Weather, width: tuple[float, float], shape: tuple[int, ...], rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Range [m] of the first raindrop or snowflake in each beam and its response, f32 [*shape]; 0 and 0 without one.

    `width` is the divergence of the beam [rad], and so the field of view of its detector. A particle returns its share
    of the beam's cross-section; the detector gets its share of the blur.
    """
    density, least, larger, share = particles(weather)
    steps = np.linspace(_OVERLAP, _REACH, 256)
    area = math.pi / 4 * (_APERTURE + width[0] * steps) * (_APERTURE + width[1] * steps)
    met = np.concatenate([[0.0], np.cumsum((area[1:] + area[:-1]) / 2 * np.diff(steps))]) * density
    path = rng.standard_exponential(shape, np.float32)
    range_ = np.interp(path, met, steps, right=0.0).astype(np.float32)
    diameter = least + larger * rng.standard_exponential(shape, np.float32)
    seen = np.minimum(width[0] * steps / _LENS, 1.0) * np.minimum(width[1] * steps / _LENS, 1.0)
    response = share * np.minimum(math.pi / 4 * diameter**2 / np.interp(range_, steps, area), 1.0)
    response *= np.interp(range_, steps, seen)
    return range_, np.where(range_ > 0, response, 0.0).astype(np.float32)


def fog_echo(
    weather: Weather, pulse_length: float, shape: tuple[int, ...], rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Range [m] and response of the fog just in front of each beam, f32 [*shape]; response 0 without fog.

    A pulse lights its own length of fog, whose backscatter is 0.046 / V per metre and steradian, against the 1 / pi of
    a white surface. The range is sampled like the light that returns, 1 / r^2 from the overlap on.
    """
    if math.isinf(weather.visibility):
        return np.zeros(shape, np.float32), np.zeros(shape, np.float32)
    range_ = np.float32(_OVERLAP) / (1.0 - np.float32(0.9) * rng.random(shape, np.float32))
    response = math.pi * 0.046 / weather.visibility * pulse_length
    return range_, np.full(shape, response, np.float32)
