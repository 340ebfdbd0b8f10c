"""What a sensor makes of light: the constants of its optics, receiver and output."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from lidardraft import _core
from lidardraft.errors import SensorError
from lidardraft.json_fields import is_number
from lidardraft.scene.intensity_curve import IntensityCurve

if TYPE_CHECKING:
    from lidardraft.scene.sensor import Sensor  # which has a model

T = TypeVar("T")
# The largest width of a beam, over the distance to the next, at which sub-rays do not cross however beams are tilted.
_FILL = 0.6
# Where the sub-rays of a ring stand: turned a little, as no two may have one elevation.
_TURN = 0.17
_TILT_STREAM = 3  # random numbers of the tilts of a unit


@dataclass(frozen=True, kw_only=True)
class SensorModel:
    """The effects of one sensor; a number at 0 (or as its line says) switches an effect off.

    Optics: `rays_per_beam` sub-rays stand for each beam (1 is off), whose full width at 1 / e^2 is `divergence_h` by
    `divergence_v` [rad]; a pulse lasts `pulse_duration` [s].

    Receiver: `detection_threshold` is the response over range squared [1/m2] of power 1 (0: everything is detected). A
    response of 1 is that of a white surface that faces the sensor. Return mode: of several echoes the strongest is
    reported, or with `last_return` the last one above the threshold. Ray drop: an echo of power P is dropped with
    probability 1 - exp(-2 / P^1.25 - `drop_exponent`), to which `edge_drop` is added in the exponent where the beam
    makes several echoes; `fading` is by how much the first term differs from patch to patch of a surface (the spread of
    its logarithm).

    Scatter: `speckle` of the power from pulse to pulse, `texture` of it from patch to patch of what a beam looks at,
    3 / 1024 of a turn long on average (both relative), `material_noise` whether materials add their own grain and
    roughness, `dust` the depth of the stains on the window, `glass_transmission` whether rays pass through glass.

    Range: `jitter` [m] is the noise of an echo of power 1, on top of the sensor's `range_sigma`; `range_step` [m]
    rounds it. One unit differs from another: the number `unit` decides each beam's range offset, which has the standard
    deviation `offset_spread` [m], its gain, `gain_spread` (relative), and how far its elevation is off the sensor's
    table, `tilt_spread` [rad]. `range_offsets` are those of a unit that is known, for each beam [m], or nothing.

    Output: an intensity of 1 is a response of `full_scale`, in `levels` steps (0: smooth). With a `knee` below 1 the
    response 1 reads `knee`, and brighter ones climb from there by their logarithm. Intensity is corrected for range up
    to `compensation_range` [m] (inf: at all ranges). An `intensity_curve` takes the place of `full_scale` and `knee`.
    What would read less than `cutoff` reads 0; the beams of a unit differ in it by `cutoff_spread`.

    Raises `SensorError` naming the value that cannot be.
    """

    rays_per_beam: int = 3
    divergence_h: float = 3.0e-3
    divergence_v: float = 1.5e-3
    pulse_duration: float = 5e-9
    detection_threshold: float = 0.10 / 100.0**2
    last_return: bool = False
    speckle: float = 0.05
    texture: float = 0.15
    material_noise: bool = True
    dust: float = 0.0
    fading: float = 1.6
    drop_exponent: float = 0.0003
    edge_drop: float = 0.05
    glass_transmission: bool = True
    jitter: float = 0.07
    range_step: float = 0.002
    unit: int = 0
    range_offsets: tuple[float, ...] = ()
    offset_spread: float = 0.01
    gain_spread: float = 0.08
    tilt_spread: float = 2.2e-3
    full_scale: float = 1.0
    knee: float = 1.0
    cutoff: float = 0.0
    cutoff_spread: float = 0.0
    levels: int = 255
    compensation_range: float = math.inf
    intensity_curve: IntensityCurve | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.range_offsets, list | tuple) or not all(map(is_number, self.range_offsets)):
            raise SensorError(f"range_offsets is {self.range_offsets!r:.50}; it must be a list of finite numbers")
        object.__setattr__(self, "range_offsets", tuple(map(float, self.range_offsets)))
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
            drop_exponent=self.drop_exponent,
            edge_drop=self.edge_drop,
            unit=self.unit,
            range_offsets=list(self.range_offsets),
            offset_spread=self.offset_spread,
            gain_spread=self.gain_spread,
            jitter=self.jitter,
            range_step=self.range_step,
            full_scale=self.full_scale,
            knee=self.knee,
            cutoff=self.cutoff,
            cutoff_spread=self.cutoff_spread,
            levels=self.levels,
            compensation_range=self.compensation_range,
            intensity_curve=None if self.intensity_curve is None else self.intensity_curve.tables,
        )

    def __getstate__(self) -> dict[str, Any]:
        # the core's model cannot go to another process; it is made again there
        return {name: value for name, value in vars(self).items() if name != "core"}

    def check_beams(self, beams: int) -> None:
        """Raises `SensorError` where a table is not of so many beams."""
        if len(self.range_offsets) not in (0, beams):
            raise SensorError(
                f"range_offsets has {len(self.range_offsets)} values; it needs one for each of {beams} beams"
            )
        if self.intensity_curve is not None:
            self.intensity_curve.check_beams(beams)

    @property
    def pulse_length(self) -> float:
        """Echoes closer than this are one [m]: half the way of light in a pulse."""
        return self.core.pulse_length

    @classmethod
    def from_sensor(cls, sensor: Sensor) -> SensorModel:
        """The sensor's own model, that of its preset (`Sensor.is_preset`), or typical values for any other.

        Beams of another sensor that are close together are as much narrower than typical ones as keeps them apart.
        """
        from lidardraft.scene.sensor_model_presets import MODELS  # which are of this class

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
    sampled = np.random.default_rng([model.unit, _TILT_STREAM]).standard_normal(len(step))
    tilts: np.ndarray = np.clip(sampled, -2.5, 2.5) * model.tilt_spread * np.minimum(step / math.radians(1.0), 1.0)
    return tilts


def _repeated(values: tuple[T, ...], times: int) -> tuple[T, ...]:
    return tuple(value for value in values for _ in range(times))
