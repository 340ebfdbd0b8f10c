"""Trucks: rigid and articulated, with a cab, a chassis, and a load.

Limits are those of Council Directive 96/53/EC: 2.55 m wide, 4 m high, 12 m (a rigid truck) and 16.5 m (articulated)
long; a semi-trailer measures 13.6 m.
"""

from __future__ import annotations

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
# Loads of rigid and articulated trucks, and their frequencies: estimates.
_LOADS = {
    "rigid": {"box": 0.38, "tarpaulin": 0.22, "tank": 0.1, "flatbed": 0.16, "tipper": 0.14},
    "articulated": {"box": 0.34, "tarpaulin": 0.4, "tank": 0.1, "flatbed": 0.08, "tipper": 0.08},
}
_GOODS = ("wood", "concrete", "metal", "rusty-metal", "plastic")  # materials of goods on a flatbed

# Rigid trucks, small and large ones [m]; estimates.
_RIGID_SMALL_BELOW = 3.1
_RIGID_FLOOR = (0.85, 1.1)  # height of the load's floor, of small and large ones
_RIGID_WHEEL = (0.8, _WHEEL)
_RIGID_CAB = (2.3, 0.27)  # its length at most; in shares of the truck's
_RIGID_SMALL_CAB = 2.45  # height at most
_RIGID_LARGE_CAB = (2.8, 3.3)  # heights at most, lowest and highest
_RIGID_GAP = 0.25  # between cab and load
_RIGID_TWO_AXLES_BELOW = 9.0
_RIGID_REAR_AXLE = (0.27, 0.22)  # shares of the length behind the middle, of one axle and of two
_RIGID_AXLE_APART = 1.35
_RIGID_GUARD_FROM_AXLE = 0.7
_RIGID_GUARD_FROM_CAB = 0.35

# Tractors with semi-trailers [m]; estimates.
_ARTICULATED_FLOOR = 1.25
_ARTICULATED_CAB = 2.3  # its length
_ARTICULATED_CAB_HEIGHT = (3.2, 3.9)  # at most, lowest and highest
_ARTICULATED_GAP = 0.6
_ARTICULATED_FRONT_OVERHANG = 1.4
_ARTICULATED_WHEELBASE = 3.7  # of the tractor
_ARTICULATED_TRAILER_AXLES: tuple[float, ...] = (4.6, 3.29, 1.98)  # from the rear; 1.31 m apart
_ARTICULATED_GUARD = (5.3, 6.2)  # from the rear; from the front

# Frames and their fittings [m], `_SHARE` of the width; protection and markings after UN Regulations 58 and 104. Other
# numbers are estimates.
_CHASSIS_INSET = 0.05  # from the rear
_CHASSIS_FRAME_SHARE = 0.36
_CHASSIS_FRAME = 0.4  # height
_CHASSIS_UNDERRUN = (0.1, 0.14, 0.55)  # depth, height, middle over the ground
_CHASSIS_UNDERRUN_SHARE = 0.92
_CHASSIS_MARKING = (0.03, 0.14, 0.1)  # depth, height, middle under the floor
_CHASSIS_MARKING_SHARE = 0.95
_CHASSIS_MARKING_BEHIND = 0.04
_CHASSIS_BRACKET = 0.06  # thickness of the holder of the underrun protection
_CHASSIS_BRACKET_MIDDLE = 0.25  # under the floor
_CHASSIS_BRACKET_SHORT = 0.5  # shorter than the height of the floor
_CHASSIS_CAB_SHARE = 0.98
_CHASSIS_MIRROR_AT = (0.38, 0.68)  # shares of the cab: before its middle, of its height
_CHASSIS_BUMPER = (0.04, 0.3, 0.62)  # depth, height, middle over the ground
_CHASSIS_BUMPER_SHARE = 0.8
_CHASSIS_SHORTEST_GUARD = 0.5

# Loads on a chassis [m], `_SHARE` of the load's length, width or height; estimates.
_LOAD_COLOURED_P = 0.25  # boxes that are not white
_LOAD_TANK_HEIGHT = 0.85  # share of the width, at most
_LOAD_TANK_WIDTH_SHARE = 0.94
_LOAD_STEEL_TANK_P = 0.4
_LOAD_WALKWAY = (0.5, 0.08)  # width and height, on top of a tank
_LOAD_WALKWAY_SHARE = 0.8
_LOAD_TIPPER = 1.7  # height at most
_LOAD_TIPPER_SHARE = 0.85  # of it is the body; the heap is higher
_LOAD_HEAP_SHARES = (0.85, 0.8, 0.7)
_LOAD_HEAP_MIDDLE = 0.65  # share of the height
_LOAD_FLATBED = 0.16  # thickness
_LOAD_HEADBOARD = (0.1, 1.9)  # thickness, height at most
_LOAD_GOODS_AT: tuple[tuple[float, float], ...] = ((0.42, 0.2), (0.3, -0.22))  # shares: length, middle
_LOAD_GOODS_HEIGHT = (0.3, 0.9)  # shares of the headboard
_LOAD_GOODS_WIDTH = (0.6, 0.92)  # shares of the width


def truck(builder: ObjectBuilder, rng: np.random.Generator) -> None:
    """A rigid truck: cab, a gap, a load (box, tarpaulin, tank, flatbed or tipper), two or three axles."""
    length, width, height = builder.placed.size
    front, cab = length / 2, min(_RIGID_CAB[0], _RIGID_CAB[1] * length)
    large = int(height >= _RIGID_SMALL_BELOW)
    floor = _RIGID_FLOOR[large]
    tallest = float(rng.uniform(*_RIGID_LARGE_CAB)) if large else _RIGID_SMALL_CAB
    _add_cab(builder, front - cab / 2, cab, min(height, tallest), sample_paint(rng))
    load = length - cab - _RIGID_GAP
    _add_load(builder, sample_name(_LOADS["rigid"], rng), load / 2 - front, load, floor, rng)
    _add_chassis(builder, -front + _CHASSIS_INSET, front - 0.5 * cab, floor)
    one, two = _RIGID_REAR_AXLE
    axles = [-one * length] if length < _RIGID_TWO_AXLES_BELOW else [-two * length, -two * length - _RIGID_AXLE_APART]
    for axle in axles:
        add_axle(builder, "truck", (axle, 0.0), width, _RIGID_WHEEL[large])
    _add_guards(builder, axles[0] + _RIGID_GUARD_FROM_AXLE, front - cab - _RIGID_GUARD_FROM_CAB)


def trailer_truck(builder: ObjectBuilder, rng: np.random.Generator) -> None:
    """A tractor and a semi-trailer with three axles; the trailer takes the length behind the cab."""
    length, width, height = builder.placed.size
    rear, front = -length / 2, length / 2
    cab, floor = _ARTICULATED_CAB, _ARTICULATED_FLOOR
    _add_cab(
        builder, front - cab / 2, cab, min(height, float(rng.uniform(*_ARTICULATED_CAB_HEIGHT))), sample_paint(rng)
    )
    load = length - cab - _ARTICULATED_GAP
    _add_load(builder, sample_name(_LOADS["articulated"], rng), rear + load / 2, load, floor, rng)
    _add_chassis(builder, rear + _CHASSIS_INSET, front - 0.5 * cab, floor)
    drive = front - _ARTICULATED_FRONT_OVERHANG - _ARTICULATED_WHEELBASE
    for axle in (drive, *(rear + at for at in _ARTICULATED_TRAILER_AXLES)):
        add_axle(builder, "truck", (axle, 0.0), width, _WHEEL)
    _add_guards(builder, rear + _ARTICULATED_GUARD[0], front - _ARTICULATED_GUARD[1])


def _add_cab(builder: ObjectBuilder, x: float, length: float, height: float, paint: str) -> None:
    width = _CHASSIS_CAB_SHARE * builder.placed.size[1]
    add_vehicle(builder, _CAB, (length, width, height), "truck", paint, at=(x, 0.0, 0.0))
    ahead, up = _CHASSIS_MIRROR_AT
    add_mirrors(builder, "truck", x + ahead * length, up * height)
    depth, tall, middle = _CHASSIS_BUMPER
    size = (depth, _CHASSIS_BUMPER_SHARE * width, tall)
    builder.add("box", (x + length / 2, 0.0, middle), size, "truck", "plastic")


def _add_load(
    builder: ObjectBuilder, load: str, x: float, length: float, floor: float, rng: np.random.Generator
) -> None:
    """Add a load on a chassis between `floor` and the top, with its middle at `x`."""
    _, width, height = builder.placed.size
    tall = height - floor
    if load in ("box", "tarpaulin"):
        painted = "cloth"
        if load == "box":
            painted = "mid-paint" if rng.random() < _LOAD_COLOURED_P else "light-paint"
        builder.add("box", (x, 0.0, floor + tall / 2), (length, width, tall), "truck", painted)
    elif load == "tank":
        tall = min(tall, _LOAD_TANK_HEIGHT * width)
        size = (length, _LOAD_TANK_WIDTH_SHARE * width, tall)
        steel = "chrome" if rng.random() < _LOAD_STEEL_TANK_P else "light-paint"
        builder.add_mesh(_tank(), size, "truck", steel, at=(x, 0.0, floor + tall / 2))
        walkway = (_LOAD_WALKWAY_SHARE * length, *_LOAD_WALKWAY)
        builder.add("box", (x, 0.0, floor + tall), walkway, "truck", "metal")
    elif load == "tipper":
        tall = min(tall, _LOAD_TIPPER)
        size = (length, width, _LOAD_TIPPER_SHARE * tall)
        builder.add_mesh(_tipper(), size, "truck", sample_paint(rng), at=(x, 0.0, floor))
        a, b, c = _LOAD_HEAP_SHARES
        heap = (a * length, b * width, c * tall)
        builder.add("ellipsoid", (x, 0.0, floor + _LOAD_HEAP_MIDDLE * tall), heap, "truck", "gravel")
    else:
        _add_flatbed(builder, x, (length, width, tall), floor, rng)


def _add_flatbed(
    builder: ObjectBuilder, x: float, size: tuple[float, float, float], floor: float, rng: np.random.Generator
) -> None:
    length, width, tall = size
    builder.add("box", (x, 0.0, floor + _LOAD_FLATBED / 2), (length, width, _LOAD_FLATBED), "truck", "wood")
    thick, most = _LOAD_HEADBOARD
    top = min(tall, most)
    at = (x + length / 2 - thick / 2, 0.0, floor + top / 2)
    builder.add("box", at, (thick, width, top), "truck", "metal")
    for share, middle in _LOAD_GOODS_AT:
        high = float(rng.uniform(*_LOAD_GOODS_HEIGHT)) * top
        goods = (share * length, float(rng.uniform(*_LOAD_GOODS_WIDTH)) * width, high)
        material = str(rng.choice(_GOODS))
        builder.add("box", (x + middle * length, 0.0, floor + _LOAD_FLATBED + high / 2), goods, "truck", material)


def _add_chassis(builder: ObjectBuilder, rear: float, front: float, floor: float) -> None:
    """Add a frame between two places, with the underrun protection and the reflective marking at its rear."""
    width = builder.placed.size[1]
    size = (front - rear, _CHASSIS_FRAME_SHARE * width, _CHASSIS_FRAME)
    builder.add("box", ((rear + front) / 2, 0.0, floor - _CHASSIS_FRAME / 2), size, "truck", "metal")
    depth, tall, middle = _CHASSIS_UNDERRUN
    at = (rear + depth / 2, 0.0, middle)
    builder.add("box", at, (depth, _CHASSIS_UNDERRUN_SHARE * width, tall), "truck", "metal")
    depth, tall, under = _CHASSIS_MARKING
    at = (rear - _CHASSIS_MARKING_BEHIND, 0.0, floor - under)
    builder.add("box", at, (depth, _CHASSIS_MARKING_SHARE * width, tall), "truck", "retroreflector")
    at = (rear + _CHASSIS_UNDERRUN[0] / 2, 0.0, floor - _CHASSIS_BRACKET_MIDDLE)
    bracket = (_CHASSIS_BRACKET, _CHASSIS_BRACKET, floor - _CHASSIS_BRACKET_SHORT)
    builder.add("box", at, bracket, "truck", "metal")


def _add_guards(builder: ObjectBuilder, rear: float, front: float) -> None:
    """Lateral protection between the axles, required by UN Regulation 73, and tanks behind it."""
    if front - rear < _CHASSIS_SHORTEST_GUARD:
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
    """Rails and posts on both sides and a tank between them, in shares of length and width, and in metres of height."""
    bars = [box((0.0, side * 0.48, z), (1.0, 0.02, 0.14)) for side in (-1, 1) for z in (0.48, 0.78)]
    posts = [box((x, side * 0.46, 0.75), (0.03, 0.02, 0.66)) for side in (-1, 1) for x in (-0.35, 0.35)]
    return MeshTemplate.from_triangles(*join(*bars, *posts, box((0.2, 0.0, 0.72), (0.35, 0.84, 0.5))))
