"""Sensors: a table of beams, their columns, and the mount of the sensor. The trigonometry is in the core."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from lidardraft import _core
from lidardraft.errors import SensorError, one_of
from lidardraft.files import JsonFile, named
from lidardraft.json_fields import are_numbers, check_fields, is_number, parse_object
from lidardraft.scene import beam_tables
from lidardraft.scene.pose import finite_array, rotations, upright
from lidardraft.scene.sensor_model import MODELS, SensorModel

# The origin of a beam: the columns of the core's `origins` [H, 3].
_ORIGINS = ("origin_forwards", "origin_lefts", "origin_heights")
_QUANTITIES = ("azimuth_start", "azimuth_span", "min_range", "max_range", "mount_height", "range_sigma", "sweep_time")
_HIGHEST = 1e9  # m, the core's limit of coordinates
_LONGEST_NAME = 100  # characters; names appear in pictures
# Elevations closer than this [rad] are of the same beam: tables are rounded, and the beams of every preset are further
# apart.
_SAME_BEAM = 1e-3
# The largest width of a beam, over the distance to the next, at which sub-rays do not cross at any tilt of the beams.
_FILL = 0.6

Blocked = tuple[tuple[tuple[float, float], ...], ...]


@dataclass(frozen=True, kw_only=True)
class Sensor(JsonFile):
    """A spinning LiDAR: H beams, row 0 the highest, by `columns` firings.

    Angles in radians, lengths in metres. The azimuth of column w is `azimuth_start - (w + 1/2) * azimuth_span /
    columns` plus the beam's own of `azimuth_offsets`: pixel centres, decreasing, the seam behind the car. A beam starts
    `origin_forwards` ahead, `origin_lefts` to the left and `origin_heights` over the sensor's origin, relative to its
    azimuth: the lasers turn with the head. These tables hold one value a beam, or nothing for zeros.

    A sweep of all columns takes `sweep_time` [s]; 0 is a flash. `mount_height` is the height of the sensor's origin
    over the road; `range_sigma` the standard deviation of its range noise. `blocked` are, for each beam, intervals of
    azimuth [rad] from a start counter-clockwise to an end, without returns because the vehicle is in the way. `model`
    holds the optics and receiver of one unit, if known.

    Raises `SensorError` naming the invalid value.
    """

    name: str
    elevations: tuple[float, ...]
    columns: int
    azimuth_offsets: tuple[float, ...] = ()
    origin_forwards: tuple[float, ...] = ()
    origin_lefts: tuple[float, ...] = ()
    origin_heights: tuple[float, ...] = ()
    azimuth_start: float = math.pi
    azimuth_span: float = 2 * math.pi
    min_range: float = 0.5
    max_range: float = 120.0
    mount_height: float = 1.73
    range_sigma: float = 0.02
    sweep_time: float = 0.1
    blocked: Blocked = ()
    model: SensorModel | None = None

    def __post_init__(self) -> None:
        if not (isinstance(self.name, str) and 1 <= len(self.name) <= _LONGEST_NAME and self.name.isprintable()):
            limit = f"1 to {_LONGEST_NAME} printable characters"
            raise SensorError(f"name is {self.name!r:.80}; it must be a string of {limit}")
        for table in ("elevations", "azimuth_offsets", *_ORIGINS):
            object.__setattr__(self, table, self._checked_table(table))
        for quantity in _QUANTITIES:
            value = getattr(self, quantity)
            if not is_number(value):
                raise SensorError(f"{self.name}: {quantity} is {value!r}; it must be a finite number")
            if value < 0 and quantity in ("range_sigma", "sweep_time"):
                raise SensorError(f"{self.name}: {quantity} is {value}; it must be 0 or more")
            object.__setattr__(self, quantity, float(value))
        if abs(self.mount_height) > _HIGHEST:
            raise SensorError(f"{self.name}: mount_height is {self.mount_height} m; it must be up to {_HIGHEST:g} m")
        if isinstance(self.columns, bool) or not isinstance(self.columns, int | np.integer):
            raise SensorError(f"{self.name}: columns is {self.columns!r}; it must be a whole number")
        object.__setattr__(self, "columns", int(self.columns))
        beams = len(self.elevations)
        object.__setattr__(self, "blocked", _checked_blocked(self.name, self.blocked, beams))
        if self.model is not None:
            with named(self.name):
                self.model.check_beams(beams)
        try:
            _ = self.pattern  # the core checks everything else
        except OverflowError:
            raise SensorError(f"{self.name}: columns is {self.columns}; that is too many") from None

    def _checked_table(self, table: str) -> tuple[float, ...]:
        values = getattr(self, table)
        if not isinstance(values, list | tuple | np.ndarray) or not all(map(is_number, values)):
            raise SensorError(f"{self.name}: {table} is {values!r}; it must be a list of finite numbers")
        if len(values) not in (0, len(self.elevations)):
            beams = len(self.elevations)
            raise SensorError(f"{self.name}: {table} has {len(values)} values; it needs one for each of {beams} beams")
        return tuple(map(float, values))

    @cached_property
    def pattern(self) -> _core.SensorPattern:
        """The sensor's rays."""
        beams = len(self.elevations)
        return _core.SensorPattern(
            elevations=np.array(self.elevations, dtype=np.float64),
            azimuth_offsets=np.array(self.azimuth_offsets or [0.0] * beams),
            origins=np.array([getattr(self, table) or [0.0] * beams for table in _ORIGINS]).T.copy(),
            columns=self.columns,
            azimuth_start=self.azimuth_start,
            azimuth_span=self.azimuth_span,
            min_range=self.min_range,
            max_range=self.max_range,
        )

    def __getstate__(self) -> dict[str, Any]:
        # the core's pattern cannot go to another process; it is made again there
        return {name: value for name, value in vars(self).items() if name in self.__dataclass_fields__}

    def __repr__(self) -> str:
        return f"Sensor({self.name}, {len(self.elevations)} x {self.columns})"

    @cached_property
    def azimuths(self) -> np.ndarray:
        """The azimuth of each pixel, f64 [H, W], rad; read-only."""
        middles = self.azimuth_start - (np.arange(self.columns) + 0.5) * self.azimuth_span / self.columns
        azimuths: np.ndarray = np.add.outer(self.azimuth_offsets or np.zeros(len(self.elevations)), middles)
        azimuths.flags.writeable = False
        return azimuths

    @cached_property
    def blocked_pixels(self) -> np.ndarray:
        """Whether the vehicle hides each pixel, bool [H, W]; read-only."""
        pixels = np.zeros(self.shape, dtype=bool)
        for row, intervals, azimuths in zip(pixels, self.blocked or ((),) * len(pixels), self.azimuths, strict=True):
            for start, end in intervals:
                row |= (azimuths - start) % (2 * math.pi) < end - start
        pixels.flags.writeable = False
        return pixels

    def azimuth_grid(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Row and column [H, W'] of each pixel of a grid whose columns have one azimuth, and whether it is in the
        image.

        Beams with azimuth offsets differ by up to 10 degrees within one column of the image. If the sensor wraps, W' is
        W. Else the grid is wider by the largest offset in columns on either side, and parts of it are outside the
        image.
        """
        beams, width = self.shape
        offsets = np.array(self.azimuth_offsets or [0.0] * beams)
        shifts = np.rint(offsets / (self.azimuth_span / width)).astype(np.intp)
        more = 0 if self.wraps else int(np.abs(shifts).max())
        columns = np.arange(-more, width + more)[None, :] + shifts[:, None]
        inside = (columns >= 0) & (columns < width) | self.wraps
        return np.broadcast_to(np.arange(beams)[:, None], columns.shape), columns % width, inside

    @property
    def assumed_model(self) -> SensorModel:
        """The sensor's own model, that of its preset (`is_preset`), or typical values for any other.

        If the beams of another sensor are close together, they are narrower than typical ones, and stay apart.
        """
        if self.model is not None:
            return self.model
        if self.is_preset:
            return MODELS[self.name]
        closest = -np.diff(self.elevations).max(initial=-math.inf)
        return SensorModel(divergence_v=min(SensorModel.divergence_v, _FILL * closest))

    @property
    def is_preset(self) -> bool:
        """Whether it has the name and the beams of a preset, each within 1 mrad.

        Columns, azimuths, origins, range limits and mounting may differ: they are settings of a sensor, or calibrated
        for one unit.
        """
        preset = PRESETS.get(self.name)
        if preset is None or len(self.elevations) != len(preset.elevations):
            return False
        return bool(np.abs(np.subtract(self.elevations, preset.elevations)).max() <= _SAME_BEAM)

    @property
    def shape(self) -> tuple[int, int]:
        """(H, W) of this sensor's images."""
        return len(self.elevations), self.columns

    @property
    def wraps(self) -> bool:
        """Whether the columns make a full turn, so that the last one is next to the first."""
        return self.azimuth_span > 2 * math.pi - 1e-9  # the core's tolerance

    def pose(self, x: float = 0.0, y: float = 0.0, yaw: float = 0.0) -> np.ndarray:
        """`world_from_sensor` [4, 4] of the sensor on its mount, over the point (x, y) of a flat road."""
        return upright((x, y, self.mount_height), yaw)

    def column_times(self) -> np.ndarray:
        """The time [s] of each column after the first, f64 [W]: column w fires at w / W of `sweep_time`."""
        return np.arange(self.columns) / self.columns * self.sweep_time

    def poses_in_motion(
        self,
        pose: np.ndarray | None = None,
        velocity: Sequence[float] | np.ndarray = (0.0, 0.0, 0.0),
        angular_velocity: Sequence[float] | np.ndarray = (0.0, 0.0, 0.0),
    ) -> np.ndarray:
        """`world_from_sensor` of each column, [W, 4, 4], of a sensor that moves while it sweeps, for `Raycaster.scan`.

        It is at `pose` (by default on its mount) in the middle of the sweep, after half of `sweep_time`. It moves at
        `velocity` [m/s, in the world] and turns at `angular_velocity` [rad/s, about its own axes], both constant.
        Raises `LayoutError` on arrays of another shape or with numbers that are not finite.
        """
        pose = self.pose() if pose is None else finite_array("pose", pose, 4, 4)
        velocity = finite_array("velocity", velocity, 3)
        angular_velocity = finite_array("angular_velocity", angular_velocity, 3)
        since_middle = (self.column_times() - self.sweep_time / 2)[:, None]
        poses = np.tile(pose, (self.columns, 1, 1))
        if angular_velocity.any():
            poses[:, :3, :3] = pose[:3, :3] @ rotations(since_middle * angular_velocity)
        poses[:, :3, 3] += since_middle * velocity
        return poses

    def to_json(self) -> str:
        """All fields as JSON text, `blocked` and `model` if known; `from_json` gives an equal sensor."""
        fields = self.__getstate__() | {"model": self.model and self.model.to_dict()}
        return json.dumps({name: value for name, value in fields.items() if value or name not in ("blocked", "model")})

    @classmethod
    def from_json(cls, text: str) -> Sensor:
        """Raises `FormatError` if the text lacks a sensor's fields, `SensorError` if a value is invalid."""
        fields = parse_object(text)
        check_fields(fields, ("name", "elevations", "columns"), cls.__dataclass_fields__)
        if fields.get("model") is not None:
            fields["model"] = SensorModel.from_dict(fields["model"])
        return cls(**fields)

    @classmethod
    def presets(cls) -> tuple[str, ...]:
        """The names of all presets."""
        return tuple(PRESETS)

    @classmethod
    def preset(cls, name: str) -> Sensor:
        """The preset of that name (`presets`); raises `SensorError` if there is none."""
        if name not in PRESETS:
            raise SensorError(f"sensor is {name!r}; it must be {one_of(PRESETS, name)} (`Sensor.load` reads a file)")
        return PRESETS[name]


def _checked_blocked(name: str, blocked: Any, beams: int) -> Blocked:
    """The intervals of azimuth [rad] of each beam, from a start counter-clockwise to an end; () if there are none at
    all.

    Raises `SensorError` naming the sensor `name` and the invalid interval.
    """
    if not isinstance(blocked, list | tuple) or len(blocked) not in (0, beams):
        raise SensorError(
            f"{name}: blocked is {blocked!r:.50}; it must be a list of intervals for each of {beams} beams"
        )
    for beam, intervals in enumerate(blocked):
        if not isinstance(intervals, list | tuple):
            raise SensorError(f"{name}: blocked of beam {beam} is {intervals!r:.50}; it must be a list of intervals")
        for interval in intervals:
            if not are_numbers(interval, 2) or not 0.0 < interval[1] - interval[0] <= 2 * math.pi + 1e-9:
                raise SensorError(
                    f"{name}: blocked of beam {beam} has {interval!r:.50}; it must be a start and an end [rad], "
                    "which comes after it by a full turn or less"
                )
    found = tuple(tuple((float(start), float(end)) for start, end in intervals) for intervals in blocked)
    return found if any(found) else ()


def _beams(high: float, low: float, count: int) -> tuple[float, ...]:
    return _table(np.linspace(high, low, count))


def _turned(degrees: Sequence[float] | np.ndarray) -> tuple[float, ...]:
    """The azimuth offsets of a maker's table, which counts clockwise."""
    return _table(-np.array(degrees))


def _ouster(
    name: str,
    elevations: Sequence[float] | np.ndarray,
    azimuths: Sequence[float] | np.ndarray,
    forward: float,
    nearest: float,
    furthest: float,
) -> Sensor:
    """An Ouster sensor, with angles in degrees; its beams start `forward` [m] of the axis
    (lidar_origin_to_beam_origin_mm).

    Azimuths are rounded to a tenth of a degree, less than a third of a column: beams of one azimuth are cast together.
    """
    return Sensor(
        name=name,
        elevations=_table(elevations),
        azimuth_offsets=_turned(np.round(azimuths, 1)),
        origin_forwards=(forward,) * len(elevations),
        columns=1024,
        mount_height=1.8,
        min_range=nearest,
        max_range=furthest,
        range_sigma=0.0015,  # of strong echoes in a sample of an OS1 (benches/fit_sensor.py); OS0's has steps of 8 mm
    )


def _table(degrees: Sequence[float] | np.ndarray) -> tuple[float, ...]:
    return tuple(np.deg2rad(degrees).tolist())


PRESETS: dict[str, Sensor] = {
    sensor.name: sensor
    for sensor in (
        # Velodyne HDL-64E S2 manual: 32 upper beams 1/3 degree apart from +2, 32 lower ones 1/2 degree apart to -24.33;
        # 2 cm, mostly the lasers' own offsets: errors from firing to firing are "around +-25 mm" (Chen and Chien,
        # Sensors 12, 2012), here 3.5 standard deviations. The two blocks start 0.20 and 0.11 m over the origin: means
        # of a published calibration (64e_s2.1-sztaki of ros-drivers/velodyne, BSD). The range is 120 m, but
        # KITTI's files end at 80 m, and so do these scans. KITTI mounts it 1.73 m over the road (Geiger et al., IJRR
        # 2013); 64 x 1024 is the usual image of its scans.
        Sensor(
            name="hdl64e",
            elevations=_beams(2.0, -8.333, 32) + _beams(-8.833, -24.333, 32),
            origin_heights=(0.20,) * 32 + (0.11,) * 32,
            columns=1024,
            min_range=0.9,
            max_range=80.0,
            range_sigma=0.007,
        ),
        # The grid that LiDARGen, LiDM and R2DM project KITTI to: +3 to -25 degrees in equal steps, here pixel centres.
        Sensor(name="hdl64e-linear", elevations=_beams(3 - 14 / 64, -25 + 14 / 64, 64), columns=1024),
        # Velodyne HDL-32E manual: +10.67 to -30.67 degrees in steps of 4/3; 1 to 100 m; nuScenes mounts it 1.84 m over
        # the road.
        Sensor(
            name="hdl32e",
            elevations=_beams(10.667, -30.667, 32),
            columns=1024,
            min_range=1.0,
            max_range=100.0,
            mount_height=1.84,
        ),
        # Velodyne VLP-16 manual: +-15 degrees in steps of 2; 0.2 degrees of azimuth at 10 Hz.
        Sensor(name="vlp16", elevations=_beams(15, -15, 16), columns=1800, max_range=100.0, range_sigma=0.03),
        # Velodyne VLP-32C manual: 200 m, 3 cm, mostly offsets: its noise is 4 mm (benches/fit_sensor.py); 0.2
        # degrees of azimuth at 10 Hz.
        Sensor(
            name="vlp32c",
            elevations=_table(beam_tables.VLP32C_ELEVATIONS),
            azimuth_offsets=_turned(beam_tables.VLP32C_AZIMUTHS),
            columns=1800,
            min_range=1.0,
            max_range=200.0,
            mount_height=1.8,
            range_sigma=0.004,
        ),
        # Hesai Pandar64 manual: 0.3 to 200 m; 0.2 degrees of azimuth at 10 Hz. PandaSet's stands 2.1 m over the road;
        # its noise is 4.5 mm for strong echoes (benches/fit_sensor.py), the manual says 2 cm.
        Sensor(
            name="pandar64",
            elevations=_table(beam_tables.PANDAR64_ELEVATIONS),
            azimuth_offsets=_turned(beam_tables.PANDAR64_AZIMUTHS),
            columns=1800,
            min_range=0.3,
            max_range=200.0,
            mount_height=2.1,
            range_sigma=0.0045,
        ),
        # Ouster data sheets: ranges, precision; 1024 columns at 10 Hz.
        _ouster("os0-128", beam_tables.OS0_128_ELEVATIONS, beam_tables.OS0_128_AZIMUTHS, 0.02767, 0.5, 100.0),
        # No table of a sensor with 64 beams is at hand: nominal ones, every other beam of 128.
        _ouster("os0-64", beam_tables.OS0_128_ELEVATIONS[::2], beam_tables.OS0_128_AZIMUTHS[::2], 0.02767, 0.5, 100.0),
        # OS1-128: 45 degrees of elevation; the four columns of lasers are 2.82 degrees apart. The revision of the
        # sample, with a range of 200 m, and revision D.
        *(
            _ouster(name, np.linspace(22.5, -22.5, 128), np.resize([4.23, 1.41, -1.41, -4.23], 128), 0.015806, 0.5, far)
            for name, far in (("os1-128", 200.0), ("os1-128-d", 120.0))
        ),
        _ouster(
            "os1-64", np.linspace(22.5, -22.5, 64), np.resize([4.23, 1.41, -1.41, -4.23], 64), 0.015806, 0.5, 120.0
        ),
        _ouster("os1-32", beam_tables.OS1_32_ELEVATIONS, beam_tables.OS1_32_AZIMUTHS, 0.015806, 0.5, 120.0),
        _ouster("os2-128", beam_tables.OS2_128_ELEVATIONS, beam_tables.OS2_128_AZIMUTHS, 0.013762, 1.0, 240.0),
    )
}
