"""What a sensor makes of light: the constants of its optics, receiver and output, one preset for each known sensor."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from lidardraft import _core
from lidardraft.errors import SensorError
from lidardraft.scene.intensity_curve import IntensityCurve

if TYPE_CHECKING:
    from lidardraft.scene.sensor import Sensor  # which has a model

T = TypeVar("T")
_FWHM = math.sqrt(2.0 / math.log(2.0))  # of a Gaussian: full width at 1 / e^2 over full width at half maximum
# The largest width of a beam, over the distance to the next, at which sub-rays do not cross however beams are tilted.
_FILL = 0.6
# Where the sub-rays of a ring stand: turned a little, as no two may have one elevation.
_TURN = 0.17


@dataclass(frozen=True, kw_only=True)
class SensorModel:
    """The effects of one sensor; a number at 0 (or as its line says) switches an effect off.

    Optics: `rays_per_beam` sub-rays stand for each beam (1 is off), whose full width at 1 / e^2 is `divergence_h` by
    `divergence_v` [rad]; a pulse lasts `pulse_duration` [s].

    Receiver: `detection_threshold` is the response over range squared [1/m2] of power 1 (0: everything is detected). A
    response of 1 is that of a white surface that faces the sensor. Return mode: of several echoes the strongest is
    reported, or with `last_return` the last one above the threshold. Ray drop: an echo of power P is dropped with
    probability 1 - exp(-1 / P - `drop_probability`); `fading` is by how much 1 / P differs from patch to patch of a
    surface (the spread of its logarithm).

    Scatter: `speckle` of the power from pulse to pulse, `texture` of it over patches of a surface (both relative),
    `material_noise` whether materials add their own grain and roughness, `dust` the depth of the stains on the window,
    `glass_transmission` whether rays pass through glass.

    Range: `jitter` [m] is the noise of an echo of power 1, on top of the sensor's `range_sigma`; `range_step` [m]
    rounds it. One unit differs from another: the number `unit` decides each beam's range offset, which has the standard
    deviation `offset_spread` [m], its gain, `gain_spread` (relative), and how far its elevation is off the sensor's
    table, `tilt_spread` [rad].

    Output: an intensity of 1 is a response of `full_scale`, in `levels` steps (0: smooth). With a `knee` below 1 the
    response 1 reads `knee`, and brighter ones climb from there by their logarithm. Intensity is corrected for range up
    to `compensation_range` [m] (inf: at all ranges). An `intensity_curve` of the unit takes the place of `full_scale`
    and `knee`.

    Raises `SensorError` naming the value that cannot be.
    """

    rays_per_beam: int = 3
    divergence_h: float = 3.0e-3
    divergence_v: float = 1.5e-3
    pulse_duration: float = 5e-9
    detection_threshold: float = 0.10 / 100.0**2
    last_return: bool = False
    speckle: float = 0.05
    texture: float = 0.06
    material_noise: bool = True
    dust: float = 0.0
    fading: float = 1.6
    drop_probability: float = 0.0003
    glass_transmission: bool = True
    jitter: float = 0.07
    range_step: float = 0.002
    unit: int = 0
    offset_spread: float = 0.01
    gain_spread: float = 0.08
    tilt_spread: float = 2.2e-3
    full_scale: float = 1.0
    knee: float = 1.0
    levels: int = 255
    compensation_range: float = math.inf
    intensity_curve: IntensityCurve | None = None

    def __post_init__(self) -> None:
        for name in ("divergence_h", "divergence_v", "tilt_spread"):
            if not 0 <= getattr(self, name) < math.inf:
                raise SensorError(f"{name} is {getattr(self, name)}; it must be finite and 0 or more")
        if self.rays_per_beam not in (1, *range(3, 20)):
            raise SensorError(f"rays_per_beam is {self.rays_per_beam}; it must be 1, or 3 to 19")
        if self.rays_per_beam > 1 and not min(self.divergence_h, self.divergence_v) > 0:
            raise SensorError(
                f"divergence is {self.divergence_h} by {self.divergence_v} rad; "
                "it must be greater than 0, or rays_per_beam 1"
            )
        _ = self.core  # which checks everything else

    @cached_property
    def core(self) -> _core.SensorModel:
        """The model as the core has it."""
        return _core.SensorModel(
            shares=beam_fan(self)[:, 2].tolist(),
            pulse_duration=self.pulse_duration,
            detection_threshold=self.detection_threshold,
            last_return=self.last_return,
            glass_transmission=self.glass_transmission,
            speckle=self.speckle,
            texture=self.texture,
            material_noise=self.material_noise,
            dust=self.dust,
            fading=self.fading,
            drop_probability=self.drop_probability,
            unit=self.unit,
            offset_spread=self.offset_spread,
            gain_spread=self.gain_spread,
            jitter=self.jitter,
            range_step=self.range_step,
            full_scale=self.full_scale,
            knee=self.knee,
            levels=self.levels,
            compensation_range=self.compensation_range,
            intensity_curve=None if self.intensity_curve is None else self.intensity_curve.tables,
        )

    def __getstate__(self) -> dict[str, Any]:
        # the core's model cannot go to another process; it is made again there
        return {name: value for name, value in vars(self).items() if name != "core"}

    @property
    def pulse_length(self) -> float:
        """Echoes closer than this are one [m]: half the way of light in a pulse."""
        return self.core.pulse_length

    @classmethod
    def from_sensor(cls, sensor: Sensor) -> SensorModel:
        """The sensor's own model, that of its preset (`Sensor.is_preset`), or typical values for any other.

        Beams of another sensor that are close together are as much narrower than typical ones as keeps them apart.
        """
        if sensor.model is not None:
            return sensor.model
        if sensor.is_preset:
            return MODELS[sensor.name]
        model = cls()
        closest = -np.diff(sensor.elevations).max(initial=-math.inf)
        return replace(model, divergence_v=min(model.divergence_v, _FILL * closest))

    @classmethod
    def ideal(cls) -> SensorModel:
        """Every effect off: each ray returns what it meets, with an intensity of its response.

        What noise there is is the sensor's own `range_sigma`.
        """
        return cls(
            rays_per_beam=1,
            detection_threshold=0.0,
            speckle=0.0,
            texture=0.0,
            material_noise=False,
            fading=0.0,
            drop_probability=0.0,
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

    A Gaussian beam as a cubature: three rays of a ring have its second moments, a centre of one half and a ring at the
    1 / e^2 radius its fourth as well.
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


@lru_cache(maxsize=32)
def sub_rays(sensor: Sensor, model: SensorModel) -> Sensor:
    """The sensor whose beams are the sub-rays of `sensor`: row h * S + s is sub-ray s of beam h.

    Cast this one, and give the image to `observe` with `sensor`. Sub-rays spread in azimuth, not across the beam, so
    that beams share their columns: at elevation e they are cos(e) closer. They look where the unit's beams look, which
    is not quite where the table says and `observe` puts the returns. Raises `SensorError` where the beams of `sensor`
    are so close that their sub-rays would cross.
    """
    if model.rays_per_beam == 1 and not model.tilt_spread:
        return sensor
    fan = beam_fan(model)
    beams = len(sensor.elevations)
    elevations = np.add.outer(sensor.elevations, fan[:, 1])
    elevations = (elevations + beam_tilts(sensor, model)[:, None]).ravel()
    if (np.diff(elevations) >= 0).any():
        closest = -np.diff(sensor.elevations).max()
        raise SensorError(
            f"{sensor.name}: beams {1e3 * closest:.2f} mrad apart overlap at a divergence of "
            f"{1e3 * model.divergence_v:.2f} mrad; rays_per_beam must be 1"
        )
    offsets = np.add.outer(sensor.azimuth_offsets or np.zeros(beams), fan[:, 0]).ravel()
    return replace(
        sensor,
        name=f"{sensor.name} x {model.rays_per_beam}",
        model=None,
        blocked=_repeated(sensor.blocked, model.rays_per_beam),
        elevations=tuple(elevations.tolist()),
        azimuth_offsets=tuple(offsets.tolist()),
        origin_forwards=_repeated(sensor.origin_forwards, model.rays_per_beam),
        origin_lefts=_repeated(sensor.origin_lefts, model.rays_per_beam),
        origin_heights=_repeated(sensor.origin_heights, model.rays_per_beam),
    )


def beam_tilts(sensor: Sensor, model: SensorModel) -> np.ndarray:
    """By how much each beam of this unit looks higher than the table of its sensor says, f64 [H], rad.

    `tilt_spread` is that of beams a degree or more apart; closer ones are less wrong in proportion.
    """
    steps = -np.diff(sensor.elevations)
    step = np.minimum(np.append(steps, np.inf), np.append(np.inf, steps))
    sampled = np.random.default_rng([model.unit, 3]).standard_normal(len(step))
    tilts: np.ndarray = np.clip(sampled, -2.5, 2.5) * model.tilt_spread * np.minimum(step / math.radians(1.0), 1.0)
    return tilts


def _repeated(values: tuple[T, ...], times: int) -> tuple[T, ...]:
    return tuple(value for value in values for _ in range(times))


# Velodyne's calibrated reflectivity (HDL-32E, VLP-16, VLP-32C manuals): 0 to 100 is per cent of a diffuse surface, 101
# to 255 are retroreflectors. Ouster's (firmware user manual) is alike.
_REFLECTIVITY: dict[str, Any] = {"full_scale": 300.0, "knee": 100.0 / 255.0}


def _ouster(degrees: float, reach: float, jitter: float) -> SensorModel:
    """Ouster's data sheets: 865 nm, a beam of `degrees` at half maximum, a range of `reach` [m] at 0.10.

    `jitter` [m] is such that their samples come out (benches/fit_sensor.py).
    """
    width = math.radians(degrees) * _FWHM
    return SensorModel(
        divergence_h=width,
        divergence_v=width,
        detection_threshold=0.10 / reach**2,
        range_step=0.001,
        offset_spread=0.003,
        tilt_spread=0.0,  # each unit's own table comes with it
        jitter=jitter,
        **_REFLECTIVITY,
    )


# HDL-64E S2 manual: 905 nm, 5 ns, 2 cm; pavement of 0.10 is seen to 50 m, from a roof: at 2 degrees, where it sends
# back two thirds and its echo is stretched over three sub-rays. Of the 2 cm, a part is noise (`Sensor`); the rest stays
# in a laser, as the 1 to 3 cm of Glennie and Lichti (Remote Sensing 2, 2010), who have the divergence too. Its units of
# 2 mm disappear in a correction that differs along the range. Its intensity is corrected by a focal distance and slope
# for each laser, of 3 to 20 m in published calibrations (ros-drivers/velodyne), so not beyond some tens of metres;
# KITTI stores hundredths.
_HDL64E = SensorModel(
    divergence_h=2.0e-3,
    divergence_v=2.0e-3,
    detection_threshold=0.10 * 0.67 / 3 / 50.0**2,
    range_step=0.0,
    offset_spread=0.018,
    gain_spread=0.12,
    levels=100,
    compensation_range=40.0,
)

MODELS: dict[str, SensorModel] = {
    "hdl64e": _HDL64E,
    "hdl64e-linear": _HDL64E,
    # Manuals: 3.0 by 1.5 mrad; 100 m, and 200 m of the VLP-32C, without a reflectance. ika's VLP-32C drops rays to the
    # ground as if that were 0.10 (benches/fit_sensor.py), so it is taken for all three; and 0.022 of them at any range,
    # some perhaps by the projection.
    "hdl32e": SensorModel(detection_threshold=0.10 / 100.0**2, **_REFLECTIVITY),
    "vlp16": SensorModel(detection_threshold=0.10 / 100.0**2, **_REFLECTIVITY),
    "vlp32c": SensorModel(
        detection_threshold=0.10 / 200.0**2,
        drop_probability=0.022,
        jitter=0.04,
        range_step=0.004,
        tilt_spread=2.6e-3,
        **_REFLECTIVITY,
    ),
    # Pandar64 manual: 905 nm, 2 cm, 200 m at 0.10. Divergence: an estimate after sensors of its kind. Scale and noise
    # are fitted to PandaSet by benches/fit_sensor.py.
    "pandar64": SensorModel(
        detection_threshold=0.10 / 200.0**2,
        offset_spread=0.007,
        range_step=0.004,
        tilt_spread=1.8e-3,
        full_scale=255.0 / 66.0,
    ),
    "os0-128": _ouster(0.35, 20.0, 0.03),
    "os1-128": _ouster(0.18, 40.0, 0.035),
    "os1-32": _ouster(0.18, 40.0, 0.035),
    "os2-128": _ouster(0.09, 90.0, 0.035),
}
