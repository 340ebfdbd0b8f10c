"""Models of sensors: the constants of optics, receiver and output, and those of known sensors."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, fields
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from lidardraft import _core
from lidardraft.errors import SensorError
from lidardraft.json_fields import check_fields, check_object, is_number

_TURN = 0.17  # rad: sub-rays of a ring are turned a little, so that no two have one elevation
_NULLABLE = ("compensation_range", "intensity_curve")  # null in a file is their default


@dataclass(frozen=True, kw_only=True)
class IntensityCurve:
    """Readings, 0 to 1, of responses: a curve for each beam, row 0 the highest, or one for all.

    Each of `readings` has a value for each of `responses`, which ascend. A reading is linear in the logarithm of the
    response between these knots, and constant beyond them. Responses are first multiplied by a row of `distance_gains`,
    one for each beam or one for all: optics have a focus. A row has a value for each of `distances` [m] and is linear
    in their logarithm in between. A reading below a beam's value of `cutoffs` becomes 0.

    Raises `SensorError` naming the invalid table; the core checks its values.
    """

    responses: tuple[float, ...]
    readings: tuple[tuple[float, ...], ...]
    distances: tuple[float, ...] = ()
    distance_gains: tuple[tuple[float, ...], ...] = ()
    cutoffs: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        for table in ("responses", "distances", "cutoffs"):
            object.__setattr__(self, table, _numbers(f"{table} of the intensity curve", getattr(self, table)))
        for table in ("readings", "distance_gains"):
            name, lists = f"{table} of the intensity curve", getattr(self, table)
            if not isinstance(lists, list | tuple | np.ndarray):
                raise SensorError(f"{name} is {lists!r:.50}; it must be a list of lists")
            object.__setattr__(self, table, tuple(_numbers(name, values) for values in lists))

    def check_beams(self, beams: int) -> None:
        """Raises `SensorError` if a table does not have one value a beam."""
        for table, others in (("readings", (1,)), ("distance_gains", (0, 1)), ("cutoffs", (0,))):
            if (found := len(getattr(self, table))) not in (beams, *others):
                raise SensorError(f"{table} of the intensity curve has {found} values; it needs {beams}")


@dataclass(frozen=True, kw_only=True)
class SensorModel:
    """The effects of one sensor; 0 (or the value in its comment) switches an effect off.

    A response of 1 is that of a white surface that faces the sensor; an echo of power 1 is just detected. Raises
    `SensorError` naming the invalid value.
    """

    # The one place that names the numbers and their defaults: checks, files and the core read the fields. Optics: a
    # pulse of light in a Gaussian beam.
    rays_per_beam: int = 3  # sub-rays of each beam: 3 to 19, or 1 for none
    divergence_h: float = 3.0e-3  # rad, the full width of a beam at 1 / e^2
    divergence_v: float = 1.5e-3  # rad
    pulse_duration: float = 5e-9  # s
    # Receiver. An echo of power P is dropped with probability 1 - exp(-2 / P^1.25 - drop_exponent - edge_drop).
    detection_threshold: float = 0.10 / 100.0**2  # 1/m2, the response over range squared of power 1; 0 detects all
    last_return: bool = False  # reports the last of several echoes, not the strongest
    # Scatter of the power.
    speckle: float = 0.08  # relative, from pulse to pulse
    texture: float = 0.32  # relative, of the response of surfaces from place to place, over 0.1 to 5 m
    material_noise: bool = True  # materials add their own grain and roughness
    dust: float = 0.0  # depth of the stains on the window
    fading: float = 1.6  # spread of the logarithm of 2 / P^1.25 from patch to patch of a surface
    drop_exponent: float = 0.0003
    edge_drop: float = 0.05  # only if the beam makes several echoes
    glass_transmission: bool = True  # rays pass through glass
    # Range.
    jitter: float = 0.07  # m, noise of an echo of power 1, on top of the sensor's `range_sigma`
    range_step: float = 0.002  # m, of rounding
    # Beams of one unit: the number `unit` decides how each differs from the sensor's table, with these deviations.
    unit: int = 0
    range_offsets: tuple[float, ...] = ()  # m, of each beam, if known
    offset_spread: float = 0.01  # m, of other range offsets
    gain_spread: float = 0.08  # relative
    tilt_spread: float = 2.2e-3  # rad, of elevations
    # Output.
    full_scale: float = 1.0  # the response that has an intensity of 1
    knee: float = 1.0  # the reading of a response of 1; brighter ones rise from there by their logarithm
    cutoff: float = 0.0  # a lower reading becomes 0
    cutoff_spread: float = 0.0  # of the cut-off, between the beams of a unit
    levels: int = 255  # steps of the intensity; 0 is smooth
    least_reading: float = 0.0  # of a return
    compensation_range: float = math.inf  # m, up to which intensity is corrected for range
    intensity_curve: IntensityCurve | None = None  # in place of `full_scale` and `knee`

    def __post_init__(self) -> None:
        for field in fields(self):
            if isinstance(field.default, bool | int | float):
                object.__setattr__(self, field.name, _as_kind_of(field.default, field.name, getattr(self, field.name)))
        object.__setattr__(self, "range_offsets", _numbers("range_offsets", self.range_offsets))
        for name in ("divergence_h", "divergence_v", "tilt_spread"):
            if getattr(self, name) < 0:
                raise SensorError(f"{name} is {getattr(self, name)}; it must be 0 or more")
        if self.rays_per_beam not in (1, *range(3, 20)):
            raise SensorError(f"rays_per_beam is {self.rays_per_beam}; it must be 1, or 3 to 19")
        if self.rays_per_beam > 1 and not min(self.divergence_h, self.divergence_v) > 0:
            raise SensorError(
                f"divergence is {self.divergence_h} by {self.divergence_v} rad; "
                "it must be greater than 0, or rays_per_beam 1"
            )
        _ = self.core  # it checks everything else

    @cached_property
    def core(self) -> _core.SensorModel:
        """The model as the core takes it."""
        return _core.SensorModel(self, beam_fan(self)[:, 2].tolist())

    def __getstate__(self) -> dict[str, Any]:
        # the core's model cannot go to another process; it is made again there
        return {name: value for name, value in vars(self).items() if name != "core"}

    def check_beams(self, beams: int) -> None:
        """Raises `SensorError` if a table does not have one value a beam."""
        if len(self.range_offsets) not in (0, beams):
            raise SensorError(
                f"range_offsets has {len(self.range_offsets)} values; it needs one for each of {beams} beams"
            )
        if self.intensity_curve is not None:
            self.intensity_curve.check_beams(beams)

    @property
    def pulse_length(self) -> float:
        """The distance [m] below which echoes merge: half the way of light in a pulse."""
        return self.core.pulse_length

    def to_dict(self) -> dict[str, Any]:
        """All fields as JSON types; an infinite range, which JSON does not have, is None."""
        return {name: None if value == math.inf else value for name, value in asdict(self).items()}

    @classmethod
    def from_dict(cls, value: Any) -> SensorModel:
        """The inverse of `to_dict`; missing fields have their defaults.

        Raises `FormatError` on an unknown field, `SensorError` on an invalid value.
        """
        given = check_object(value)
        check_fields(given, (), cls.__dataclass_fields__)
        given = {name: value for name, value in given.items() if value is not None or name not in _NULLABLE}
        if "intensity_curve" in given:
            curve = check_object(given["intensity_curve"])
            check_fields(curve, ("responses", "readings"), IntensityCurve.__dataclass_fields__)
            given["intensity_curve"] = IntensityCurve(**curve)
        return cls(**given)

    @classmethod
    def ideal(cls) -> SensorModel:
        """All effects off: each ray returns its first hit, with its response as intensity.

        The only noise left is the sensor's own `range_sigma`.
        """
        return cls(
            rays_per_beam=1,
            detection_threshold=0.0,
            speckle=0.0,
            texture=0.0,
            material_noise=False,
            fading=0.0,
            drop_exponent=0.0,
            edge_drop=0.0,
            glass_transmission=False,
            jitter=0.0,
            range_step=0.0,
            offset_spread=0.0,
            gain_spread=0.0,
            tilt_spread=0.0,
            levels=0,
        )


@lru_cache(maxsize=32)
def beam_fan(model: SensorModel) -> np.ndarray:
    """The sub-rays of a beam, f64 [S, 3]: azimuth and elevation from its axis [rad], share of its power; from above.

    The array is read-only.

    A cubature of a Gaussian beam: three rays of a ring match its second moments; a centre of one half and a ring at the
    1 / e^2 radius match its fourth as well.
    """
    rays = model.rays_per_beam
    if rays == 1:
        return _read_only(np.array([[0.0, 0.0, 1.0]]))
    ring = rays if rays == 3 else rays - 1
    angle = 2 * math.pi * np.arange(ring) / ring + math.pi / 2 + _TURN
    radius, share = (math.sqrt(0.5), 1.0) if rays == 3 else (1.0, 0.5)
    across = radius * np.stack([model.divergence_h * np.cos(angle), model.divergence_v * np.sin(angle)], axis=1) / 2
    fan = np.column_stack([across, np.full(ring, share / ring)])
    if rays > 3:
        fan = np.vstack([fan, [0.0, 0.0, 1.0 - share]])
    return _read_only(fan[np.argsort(-fan[:, 1])])


def _read_only(array: np.ndarray) -> np.ndarray:
    array.flags.writeable = False
    return array


def _numbers(name: str, values: object) -> tuple[float, ...]:
    if not isinstance(values, list | tuple | np.ndarray) or not all(map(is_number, values)):
        raise SensorError(f"{name} is {values!r:.50}; it must be a list of finite numbers")
    return tuple(map(float, values))


def _as_kind_of(default: float, name: str, value: Any) -> float:
    """The value of a field in the type of its default: bool, int or float, infinite only if the default is."""
    kind = type(default)
    if kind is bool:
        fits, needed = isinstance(value, bool), "true or false"
    elif kind is int:
        fits, needed = is_number(value) and value % 1 == 0 and abs(value) < 2**63, "a whole number below 2^63"
    else:
        fits, needed = is_number(value) or value == default, "a finite number"
    if not fits:
        raise SensorError(f"{name} is {value!r:.50}; it must be {needed}")
    return kind(value)


_FWHM = math.sqrt(2.0 / math.log(2.0))  # of a Gaussian: full width at 1 / e^2 over full width at half maximum

# Velodyne's calibrated reflectivity (HDL-32E, VLP-16, VLP-32C manuals): 0 to 100 is per cent of a diffuse surface, 101
# to 255 are retroreflectors. Ouster's (firmware user manual) is alike.
_REFLECTIVITY: dict[str, Any] = {"full_scale": 300.0, "knee": 100.0 / 255.0}


def _ouster(degrees: float, threshold: float, jitter: float, gain: float = 0.65, speckle: float = 0.17) -> SensorModel:
    """An Ouster sensor: 865 nm, a beam of `degrees` at half maximum (data sheets).

    `threshold` is set so that as few firings on the ground are lost as in Ouster's samples: a data sheet's range is
    that of one firing in ten, not of power 1. `gain` is that of the sample's readings on the manual's scale. `jitter`
    [m] and `speckle` reproduce the noise of the samples (benches/fit_sensor.py).
    """
    width = math.radians(degrees) * _FWHM
    return SensorModel(
        divergence_h=width,
        divergence_v=width,
        detection_threshold=threshold,
        range_step=0.001,
        offset_spread=0.003,
        edge_drop=0.0,  # the samples lose no more at edges than streets without
        tilt_spread=0.0,  # each unit's own table comes with it
        speckle=speckle,
        jitter=jitter,
        least_reading=1.0 / 255.0,  # no return of the samples reads 0
        **_REFLECTIVITY | {"knee": gain * _REFLECTIVITY["knee"]},
    )


_ROOT_KNOTS = tuple(10.0 ** (k / 3.0) for k in range(-12, 4))  # of responses
# HDL-64E S2 manual: 905 nm, 5 ns, 2 cm. Pavement of 0.10 is detected to 50 m from a roof: at 2 degrees, at which it
# returns two thirds and its echo is stretched over three sub-rays. Of the 2 cm, a part is noise (`Sensor`); the rest is
# constant for a laser, as the 1 to 3 cm of Glennie and Lichti (Remote Sensing 2, 2010), who give the divergence too.
# Its units of 2 mm disappear in a correction that differs along the range. Its intensity is corrected by a focal
# distance and slope for each laser, of 3 to 20 m in published calibrations (ros-drivers/velodyne), so not beyond some
# tens of metres; KITTI stores hundredths. Lasers set their own power (manual), so readings are compressed. By how much
# is not published: readings that grow with the root of the response, and 0.26 for roads, are near the known values of
# KITTI. In one calibration (64e_s2.1-sztaki, BSD) the least readings of the lasers are 0 to 90 of 255, 25 on average
# and 22 apart; and the corrections for focus are 8 to 13 apart at 8 to 15 m: of a road's reading of 66, 0.12 to 0.20,
# and of the response under the root 0.25 to 0.39, which is the spread of the gains.
_ROOT = IntensityCurve(
    responses=_ROOT_KNOTS, readings=(tuple(min(0.26 * math.sqrt(r / 0.1), 1.0) for r in _ROOT_KNOTS),)
)
_HDL64E = SensorModel(
    divergence_h=2.0e-3,
    divergence_v=2.0e-3,
    detection_threshold=0.10 * 0.67 / 3 / 50.0**2,
    range_step=0.0,
    offset_spread=0.018,
    gain_spread=0.3,
    intensity_curve=_ROOT,
    cutoff=25.0 / 255.0,
    cutoff_spread=22.0 / 255.0,
    levels=100,
    compensation_range=40.0,
)

MODELS: dict[str, SensorModel] = {
    "hdl64e": _HDL64E,
    "hdl64e-linear": _HDL64E,
    # Manuals: 3.0 by 1.5 mrad; 100 m, and 200 m of the VLP-32C, without a reflectance. ika's VLP-32C drops rays to the
    # ground as if that were 0.10 (benches/fit_sensor.py), so 0.10 serves for all three; and it drops 0.022 of them at
    # any range, some perhaps by the projection.
    "hdl32e": SensorModel(detection_threshold=0.10 / 100.0**2, **_REFLECTIVITY),
    "vlp16": SensorModel(detection_threshold=0.10 / 100.0**2, **_REFLECTIVITY),
    "vlp32c": SensorModel(
        detection_threshold=0.10 / 200.0**2,
        drop_exponent=0.022,
        jitter=0.04,
        range_step=0.004,
        tilt_spread=2.6e-3,
        speckle=0.05,
        **_REFLECTIVITY,
    ),
    # Pandar64 manual: 905 nm, 2 cm, 200 m at 0.10. Divergence: an estimate after sensors of its kind. Scale and noise
    # are fitted to PandaSet by benches/fit_sensor.py.
    "pandar64": SensorModel(
        detection_threshold=0.10 / 200.0**2,
        offset_spread=0.007,
        range_step=0.004,
        tilt_spread=1.8e-3,
        speckle=0.06,
        full_scale=255.0 / 66.0,
    ),
    # Samples of an OS0 and an OS1-32 of revision D, and of two OS1-128 of a later one. The others are assumed to be old
    # ones. There is no sample of an OS2: its sheet's range by the same factor as the OS1's.
    "os0-128": _ouster(0.35, 4.5e-5, 0.07),
    "os0-64": _ouster(0.35, 4.5e-5, 0.07),
    "os1-128": _ouster(0.18, 1.7e-6, 0.077, gain=0.53, speckle=0.07),
    "os1-128-d": _ouster(0.18, 1.3e-5, 0.077),
    "os1-64": _ouster(0.18, 1.3e-5, 0.077),
    "os1-32": _ouster(0.18, 1.3e-5, 0.077),
    "os2-128": _ouster(0.09, 2.5e-6, 0.077),
}
