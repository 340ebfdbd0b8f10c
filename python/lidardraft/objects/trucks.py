"""Trucks: rigid and articulated, with a cab, a chassis, and what they carry.

Limits are those of Council Directive 96/53/EC: 2.55 m wide, 4 m high, 12 m (a rigid truck) and 16.5 m (articulated)
long; a semi-trailer measures 13.6 m.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from lidardraft.objects.cars import sample_paint
from lidardraft.objects.mesh import MeshTemplate, box, frustum, frustum_corners, join, loft
from lidardraft.objects.object_builder import ObjectBuilder, sample_name
from lidardraft.objects.vehicle_bodies import VehicleBody, add_axle, add_mirrors, add_vehicle

_WHEEL = 1.0  # m, 315/80 R22.5
_CAB = VehicleBody(
    size=(2.3, 2.5, 3.0), cabin=(-0.5, 0.5), roof=(-0.49, 0.42), belt_line=0.56, nose=0.56, tail=0.56, axles=(0.10,),
    wheel_diameter=_WHEEL, side_windows=((0.42, 0.90),), rear_windows=(), window_rise=(0.05, 0.68), roof_width=0.96,
    clearance=0.38, taper=0.06,
)  # fmt: skip
# What a rigid and an articulated truck carry, and how often: estimates.
_LOADS = {
    "rigid": {"box": 0.38, "tarpaulin": 0.22, "tank": 0.1, "flatbed": 0.16, "tipper": 0.14},
    "articulated": {"box": 0.34, "tarpaulin": 0.4, "tank": 0.1, "flatbed": 0.08, "tipper": 0.08},
}
_GOODS = ("wood", "concrete", "metal", "rusty-metal", "plastic")  # materials of what lies on a flatbed


@dataclass(frozen=True, slots=True)
class _Rigid:
    """Rigid trucks, small and large ones [m]; estimates."""

    small_below: float = 3.1
    floor: tuple[float, float] = (0.85, 1.1)  # height of the load's floor, of small and large ones
    wheel: tuple[float, float] = (0.8, _WHEEL)
    cab: tuple[float, float] = (2.3, 0.27)  # its length at most; in shares of the truck's
    small_cab: float = 2.45  # height at most
    large_cab: tuple[float, float] = (2.8, 3.3)  # heights at most, lowest and highest
    gap: float = 0.25  # between cab and load
    two_axles_below: float = 9.0
    rear_axle: tuple[float, float] = (0.27, 0.22)  # shares of the length behind the middle, of one axle and of two
    axle_apart: float = 1.35
    guard_from_axle: float = 0.7
    guard_from_cab: float = 0.35


@dataclass(frozen=True, slots=True)
class _Articulated:
    """Tractors with semi-trailers [m]; estimates."""

    floor: float = 1.25
    cab: float = 2.3  # its length
    cab_height: tuple[float, float] = (3.2, 3.9)  # at most, lowest and highest
    gap: float = 0.6
    front_overhang: float = 1.4
    wheelbase: float = 3.7  # of the tractor
    trailer_axles: tuple[float, ...] = (4.6, 3.29, 1.98)  # from the rear; 1.31 m apart
    guard: tuple[float, float] = (5.3, 6.2)  # from the rear; from the front


@dataclass(frozen=True, slots=True)
class _Chassis:
    """Frames and what is on them [m], `*_share` of the width; protection and markings after UN Regulations 58 and 104.

    Other numbers are estimates.
    """

    inset: float = 0.05  # from the rear
    frame_share: float = 0.36
    frame: float = 0.4  # height
    underrun: tuple[float, float, float] = (0.1, 0.14, 0.55)  # depth, height, middle over the ground
    underrun_share: float = 0.92
    marking: tuple[float, float, float] = (0.03, 0.14, 0.1)  # depth, height, middle under the floor
    marking_share: float = 0.95
    marking_behind: float = 0.04
    bracket: float = 0.06  # thickness of what holds the underrun protection
    bracket_middle: float = 0.25  # under the floor
    bracket_short: float = 0.5  # shorter than the floor is high
    cab_share: float = 0.98
    mirror_at: tuple[float, float] = (0.38, 0.68)  # shares of the cab: before its middle, of its height
    bumper: tuple[float, float, float] = (0.04, 0.3, 0.62)  # depth, height, middle over the ground
    bumper_share: float = 0.8
    shortest_guard: float = 0.5


@dataclass(frozen=True, slots=True)
class _Loads:
    """What stands on a chassis [m], `*_share` of the load's length, width or height; estimates."""

    coloured_p: float = 0.25  # boxes that are not white
    tank_height: float = 0.85  # share of the width, at most
    tank_width_share: float = 0.94
    steel_tank_p: float = 0.4
    walkway: tuple[float, float] = (0.5, 0.08)  # width and height, on top of a tank
    walkway_share: float = 0.8
    tipper: float = 1.7  # height at most
    tipper_share: float = 0.85  # of it the body, the heap is higher
    heap_shares: tuple[float, float, float] = (0.85, 0.8, 0.7)
    heap_middle: float = 0.65  # share of the height
    flatbed: float = 0.16  # thickness
    headboard: tuple[float, float] = (0.1, 1.9)  # thickness, height at most
    goods_at: tuple[tuple[float, float], ...] = ((0.42, 0.2), (0.3, -0.22))  # shares: length, middle
    goods_height: tuple[float, float] = (0.3, 0.9)  # shares of the headboard
    goods_width: tuple[float, float] = (0.6, 0.92)  # shares of the width


_RIGID, _ARTICULATED, _CHASSIS, _LOAD = _Rigid(), _Articulated(), _Chassis(), _Loads()


def truck(builder: ObjectBuilder, rng: np.random.Generator) -> None:
    """A rigid truck: cab, a gap, a load (box, tarpaulin, tank, flatbed or tipper), two or three axles."""
    length, width, height = builder.placed.size
    front, cab = length / 2, min(_RIGID.cab[0], _RIGID.cab[1] * length)
    large = int(height >= _RIGID.small_below)
    floor = _RIGID.floor[large]
    tallest = float(rng.uniform(*_RIGID.large_cab)) if large else _RIGID.small_cab
    _add_cab(builder, front - cab / 2, cab, min(height, tallest), sample_paint(rng))
    load = length - cab - _RIGID.gap
    _add_load(builder, sample_name(_LOADS["rigid"], rng), load / 2 - front, load, floor, rng)
    _add_chassis(builder, -front + _CHASSIS.inset, front - 0.5 * cab, floor)
    one, two = _RIGID.rear_axle
    axles = [-one * length] if length < _RIGID.two_axles_below else [-two * length, -two * length - _RIGID.axle_apart]
    for axle in axles:
        add_axle(builder, "truck", (axle, 0.0), width, _RIGID.wheel[large])
    _add_guards(builder, axles[0] + _RIGID.guard_from_axle, front - cab - _RIGID.guard_from_cab)


def trailer_truck(builder: ObjectBuilder, rng: np.random.Generator) -> None:
    """A tractor and a semi-trailer with three axles; the trailer is what the length leaves behind the cab."""
    length, width, height = builder.placed.size
    rear, front = -length / 2, length / 2
    cab, floor = _ARTICULATED.cab, _ARTICULATED.floor
    _add_cab(
        builder, front - cab / 2, cab, min(height, float(rng.uniform(*_ARTICULATED.cab_height))), sample_paint(rng)
    )
    load = length - cab - _ARTICULATED.gap
    _add_load(builder, sample_name(_LOADS["articulated"], rng), rear + load / 2, load, floor, rng)
    _add_chassis(builder, rear + _CHASSIS.inset, front - 0.5 * cab, floor)
    drive = front - _ARTICULATED.front_overhang - _ARTICULATED.wheelbase
    for axle in (drive, *(rear + at for at in _ARTICULATED.trailer_axles)):
        add_axle(builder, "truck", (axle, 0.0), width, _WHEEL)
    _add_guards(builder, rear + _ARTICULATED.guard[0], front - _ARTICULATED.guard[1])


def _add_cab(builder: ObjectBuilder, x: float, length: float, height: float, paint: str) -> None:
    width = _CHASSIS.cab_share * builder.placed.size[1]
    add_vehicle(builder, _CAB, (length, width, height), "truck", paint, at=(x, 0.0, 0.0))
    ahead, up = _CHASSIS.mirror_at
    add_mirrors(builder, "truck", x + ahead * length, up * height)
    depth, tall, middle = _CHASSIS.bumper
    size = (depth, _CHASSIS.bumper_share * width, tall)
    builder.add("box", (x + length / 2, 0.0, middle), size, "truck", "plastic")


def _add_load(
    builder: ObjectBuilder, load: str, x: float, length: float, floor: float, rng: np.random.Generator
) -> None:
    """What stands on a chassis between `floor` and the top, its middle at `x`."""
    _, width, height = builder.placed.size
    tall = height - floor
    if load in ("box", "tarpaulin"):
        painted = "cloth"
        if load == "box":
            painted = "mid-paint" if rng.random() < _LOAD.coloured_p else "light-paint"
        builder.add("box", (x, 0.0, floor + tall / 2), (length, width, tall), "truck", painted)
    elif load == "tank":
        tall = min(tall, _LOAD.tank_height * width)
        size = (length, _LOAD.tank_width_share * width, tall)
        steel = "chrome" if rng.random() < _LOAD.steel_tank_p else "light-paint"
        builder.add_mesh(_tank(), size, "truck", steel, at=(x, 0.0, floor + tall / 2))
        walkway = (_LOAD.walkway_share * length, *_LOAD.walkway)
        builder.add("box", (x, 0.0, floor + tall), walkway, "truck", "metal")
    elif load == "tipper":
        tall = min(tall, _LOAD.tipper)
        size = (length, width, _LOAD.tipper_share * tall)
        builder.add_mesh(_tipper(), size, "truck", sample_paint(rng), at=(x, 0.0, floor))
        a, b, c = _LOAD.heap_shares
        heap = (a * length, b * width, c * tall)
        builder.add("ellipsoid", (x, 0.0, floor + _LOAD.heap_middle * tall), heap, "truck", "gravel")
    else:
        _add_flatbed(builder, x, (length, width, tall), floor, rng)


def _add_flatbed(
    builder: ObjectBuilder, x: float, size: tuple[float, float, float], floor: float, rng: np.random.Generator
) -> None:
    length, width, tall = size
    builder.add("box", (x, 0.0, floor + _LOAD.flatbed / 2), (length, width, _LOAD.flatbed), "truck", "wood")
    thick, most = _LOAD.headboard
    top = min(tall, most)
    at = (x + length / 2 - thick / 2, 0.0, floor + top / 2)
    builder.add("box", at, (thick, width, top), "truck", "metal")
    for share, middle in _LOAD.goods_at:
        high = float(rng.uniform(*_LOAD.goods_height)) * top
        goods = (share * length, float(rng.uniform(*_LOAD.goods_width)) * width, high)
        material = str(rng.choice(_GOODS))
        builder.add("box", (x + middle * length, 0.0, floor + _LOAD.flatbed + high / 2), goods, "truck", material)


def _add_chassis(builder: ObjectBuilder, rear: float, front: float, floor: float) -> None:
    """A frame between two places, and the protection and the reflecting marking at its rear."""
    width = builder.placed.size[1]
    size = (front - rear, _CHASSIS.frame_share * width, _CHASSIS.frame)
    builder.add("box", ((rear + front) / 2, 0.0, floor - _CHASSIS.frame / 2), size, "truck", "metal")
    depth, tall, middle = _CHASSIS.underrun
    at = (rear + depth / 2, 0.0, middle)
    builder.add("box", at, (depth, _CHASSIS.underrun_share * width, tall), "truck", "metal")
    depth, tall, under = _CHASSIS.marking
    at = (rear - _CHASSIS.marking_behind, 0.0, floor - under)
    builder.add("box", at, (depth, _CHASSIS.marking_share * width, tall), "truck", "retroreflector")
    at = (rear + _CHASSIS.underrun[0] / 2, 0.0, floor - _CHASSIS.bracket_middle)
    bracket = (_CHASSIS.bracket, _CHASSIS.bracket, floor - _CHASSIS.bracket_short)
    builder.add("box", at, bracket, "truck", "metal")


def _add_guards(builder: ObjectBuilder, rear: float, front: float) -> None:
    """Lateral protection between the axles, required by UN Regulation 73, and tanks behind it."""
    if front - rear < _CHASSIS.shortest_guard:
        return
    size, at = (front - rear, builder.placed.size[1], 1.0), ((rear + front) / 2, 0.0, 0.0)
    builder.add_mesh(_guard_rails(), size, "truck", "metal", at=at)


@lru_cache(maxsize=1)
def _tank() -> MeshTemplate:
    angle = 2 * np.pi * (np.arange(10) + 0.5) / 10
    circle = 0.5 / np.cos(np.pi / 10) * np.stack([np.zeros(10), np.cos(angle), np.sin(angle)], axis=1)
    circle = np.clip(circle, -0.5, 0.5)
    ends = ((-0.5, 0.6), (-0.485, 0.9), (-0.46, 1.0), (0.46, 1.0), (0.485, 0.9), (0.5, 0.6))
    return MeshTemplate.from_triangles(*loft(np.stack([diameter * circle + (x, 0.0, 0.0) for x, diameter in ends])))


@lru_cache(maxsize=1)
def _tipper() -> MeshTemplate:
    """A tipping body: sides that lean outward, open above."""
    vertices, faces = frustum(frustum_corners((-0.46, 0.48, 0.8, 0.0), (-0.5, 0.5, 1.0, 1.0)))
    return MeshTemplate.from_triangles(vertices, np.delete(faces, [2, 3], axis=0))


@lru_cache(maxsize=1)
def _guard_rails() -> MeshTemplate:
    """Rails and posts on both sides and a tank between, in shares of length and width, and in metres of height."""
    bars = [box((0.0, side * 0.48, z), (1.0, 0.02, 0.14)) for side in (-1, 1) for z in (0.48, 0.78)]
    posts = [box((x, side * 0.46, 0.75), (0.03, 0.02, 0.66)) for side in (-1, 1) for x in (-0.35, 0.35)]
    return MeshTemplate.from_triangles(*join(*bars, *posts, box((0.2, 0.0, 0.72), (0.35, 0.84, 0.5))))
