"""Heavy vehicles: trucks, articulated trucks, buses, trams.

Limits are those of Council Directive 96/53/EC: 2.55 m wide, 4 m high, 12 m (a rigid truck) and 16.5 m (articulated)
long; a semi-trailer measures 13.6 m. Buses after VDV 230, trams after BOStrab (2.65 m wide at most).
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from lidardraft.objects.cars import sample_paint
from lidardraft.objects.mesh import box, frustum, frustum_corners, join, loft, quads
from lidardraft.objects.mesh_template import MeshTemplate
from lidardraft.objects.object_builder import ObjectBuilder
from lidardraft.objects.placed_object import PlacedObject
from lidardraft.objects.vehicle_bodies import VehicleBody, add_axle, add_glazing, add_vehicle, body_mesh
from lidardraft.scene.layout import Primitive

_WHEEL = 1.0  # m, 315/80 R22.5
_LOADS = ("box", "tarpaulin", "tank", "flatbed", "tipper")

_CAB = VehicleBody(
    size=(2.3, 2.5, 3.0), cabin=(-0.5, 0.5), roof=(-0.49, 0.42), belt_line=0.56, nose=0.56, tail=0.56, axles=(0.10,),
    wheel_diameter=_WHEEL, side_windows=((0.42, 0.90),), rear_windows=(), window_rise=(0.05, 0.68), roof_width=0.96, clearance=0.38, taper=0.06,
)  # fmt: skip
_BUS = VehicleBody(
    size=(12.0, 2.55, 3.1), cabin=(-0.5, 0.5), roof=(-0.497, 0.488), belt_line=0.37, nose=0.37, tail=0.37,
    axles=(-0.23, 0.27), wheel_diameter=0.96, side_windows=tuple(((k + 0.05) / 8, (k + 0.95) / 8) for k in range(8)),
    front_windows=((0.03, 0.97),), rear_windows=((0.12, 0.88),), window_rise=(0.02, 0.80), roof_width=0.96, clearance=0.30, taper=0.04,
)  # fmt: skip
_SECTION = VehicleBody(
    size=(7.0, 2.5, 3.4), cabin=(-0.5, 0.5), roof=(-0.5, 0.5), belt_line=0.34, nose=0.34, tail=0.34, axles=(),
    wheel_diameter=0.6, side_windows=tuple(((k + 0.06) / 4, (k + 0.94) / 4) for k in range(4)), front_windows=(), rear_windows=(), window_rise=(0.04, 0.78),
    roof_width=0.94, clearance=0.25, taper=0.0,
)  # fmt: skip
_HEAD = VehicleBody(
    size=(7.0, 2.5, 3.4), cabin=(-0.5, 0.48), roof=(-0.5, 0.36), belt_line=0.34, nose=0.30, tail=0.34, axles=(),
    wheel_diameter=0.6, side_windows=((0.02, 0.24), (0.27, 0.49), (0.52, 0.74), (0.78, 0.93)), rear_windows=(), window_rise=(0.04, 0.80), roof_width=0.92,
    clearance=0.25, taper=0.25,
)  # fmt: skip


def truck(placed: PlacedObject, rng: np.random.Generator) -> list[Primitive]:
    """A rigid truck: cab, a gap, a load area (box, tarpaulin, tank, flatbed or tipper), two or three axles."""
    length, width, height = placed.size
    builder = ObjectBuilder(placed)
    front, cab = length / 2, min(2.3, 0.27 * length)
    small = height < 3.1
    floor = 0.85 if small else 1.1
    _cab(builder, front - cab / 2, cab, min(height, 2.45 if small else float(rng.uniform(2.8, 3.3))), sample_paint(rng))
    load = length - cab - 0.25
    _load(builder, str(rng.choice(_LOADS, p=(0.38, 0.22, 0.1, 0.16, 0.14))), load / 2 - front, load, floor, rng)
    _chassis(builder, -front + 0.05, front - 0.5 * cab, floor)
    axles = [-0.27 * length] if length < 9.0 else [-0.22 * length, -0.22 * length - 1.35]
    for axle in axles:
        add_axle(builder, "truck", (axle, 0.0), width, 0.8 if small else _WHEEL)
    _guards(builder, (axles[0] + 0.7, front - cab - 0.35))
    return builder.primitives


def trailer_truck(placed: PlacedObject, rng: np.random.Generator) -> list[Primitive]:
    """A tractor and a semi-trailer with three axles; the trailer is what the length leaves behind the cab."""
    length, width, height = placed.size
    builder = ObjectBuilder(placed)
    front, cab, floor = length / 2, 2.3, 1.25
    _cab(builder, front - cab / 2, cab, min(height, float(rng.uniform(3.2, 3.9))), sample_paint(rng))
    load = length - cab - 0.6
    rear = -front
    _load(builder, str(rng.choice(_LOADS, p=(0.34, 0.4, 0.1, 0.08, 0.08))), rear + load / 2, load, floor, rng)
    _chassis(builder, rear + 0.05, front - 0.5 * cab, floor)
    # the tractor's wheelbase is 3.7 m; the trailer's axles are 1.31 m apart
    for axle in (front - 1.4 - 3.7, rear + 4.6, rear + 3.29, rear + 1.98):
        add_axle(builder, "truck", (axle, 0.0), width, _WHEEL)
    _guards(builder, (rear + 5.3, front - 6.2))
    return builder.primitives


def bus(placed: PlacedObject, rng: np.random.Generator) -> list[Primitive]:
    """A bus with bands of windows, seats behind them, an air conditioner on its roof."""
    length, width, height = placed.size
    builder = ObjectBuilder(placed)
    body = 0.955 * height
    add_vehicle(builder, _BUS, (length, width, body), "bus", sample_paint(rng))
    builder.add_mesh(_seats(16, 0.34, 0.58), (length, width, body), "bus", "dark-cloth")
    builder.add(
        "box",
        (rng.uniform(-0.2, 0.1) * length, 0.0, 0.97 * height),
        (2.6, 0.7 * width, 0.06 * height),
        "bus",
        "plastic",
    )
    _mirrors(builder, "bus", length / 2 + 0.02, 0.72 * height)
    _plates(builder, "bus", 0.55)
    return builder.primitives


def tram(placed: PlacedObject, rng: np.random.Generator) -> list[Primitive]:
    """A low-floor tram: heads and middle sections with bellows between, and its current collector folded down."""
    length, width, height = placed.size
    builder = ObjectBuilder(placed)
    lacquer = sample_paint(rng)
    count = max(2, round(length / 7.5))
    pitch, joint = length / count, 0.35
    body = 0.92 * height
    for number in range(count):
        x = (number + 0.5) * pitch - length / 2
        size = (pitch - (joint if 0 < number < count - 1 else joint / 2), width, body)
        form = _HEAD if number in (0, count - 1) else _SECTION
        x += joint / 4 * ((number == count - 1) - (number == 0))
        # the rear head is the front one seen the other way round
        way = -1 if number == 0 else 1
        builder.add_mesh(body_mesh(form), size, "train", lacquer, at=(x, 0.0, 0.0), backward=way < 0)
        add_glazing(builder, form, size, "train", x=x, way=way)
    for number in range(1, count):
        x = number * pitch - length / 2
        builder.add("box", (x, 0.0, 0.52 * body + 0.1), (joint, 0.86 * width, 0.88 * body), "train", "rubber")
    for number in range(0, count, 2):
        x = (number + 0.5) * pitch - length / 2
        builder.add("box", (x, 0.0, 0.14), (1.9, 0.8 * width, 0.28), "train", "rusty-metal")  # a bogie
        builder.add("box", (x, 0.0, 0.96 * height), (0.5 * pitch, 0.6 * width, 0.08 * height), "train", "metal")
    return builder.primitives


def _cab(builder: ObjectBuilder, x: float, length: float, height: float, lacquer: str) -> None:
    width = 0.98 * builder.placed.size[1]
    add_vehicle(builder, _CAB, (length, width, height), "truck", lacquer, at=(x, 0.0, 0.0))
    _mirrors(builder, "truck", x + 0.38 * length, 0.68 * height)
    builder.add("box", (x + length / 2, 0.0, 0.62), (0.04, 0.8 * width, 0.3), "truck", "plastic")


def _load(builder: ObjectBuilder, kind: str, x: float, length: float, floor: float, rng: np.random.Generator) -> None:
    """What stands on a chassis between `floor` and the top."""
    _, width, height = builder.placed.size
    tall = height - floor
    if kind in ("box", "tarpaulin"):
        material = "cloth" if kind == "tarpaulin" else ("light-paint", "mid-paint")[int(rng.random() < 0.25)]
        builder.add("box", (x, 0.0, floor + tall / 2), (length, width, tall), "truck", material)
        return
    if kind == "tank":
        tall = min(tall, 0.85 * width)
        middle, extents = (x, 0.0, floor + tall / 2), (length, 0.94 * width, tall)
        builder.add_mesh(_tank(), extents, "truck", "chrome" if rng.random() < 0.4 else "light-paint", at=middle)
        builder.add("box", (x, 0.0, floor + tall), (0.8 * length, 0.5, 0.08), "truck", "metal")
    elif kind == "tipper":
        tall = min(tall, 1.7)
        builder.add_mesh(_trough(), (length, width, 0.85 * tall), "truck", sample_paint(rng), at=(x, 0.0, floor))
        heap = (0.85 * length, 0.8 * width, 0.7 * tall)
        builder.add("ellipsoid", (x, 0.0, floor + 0.65 * tall), heap, "truck", "gravel")
    else:
        builder.add("box", (x, 0.0, floor + 0.08), (length, width, 0.16), "truck", "wood")
        top = min(tall, 1.9)
        builder.add("box", (x + length / 2 - 0.05, 0.0, floor + top / 2), (0.1, width, top), "truck", "metal")
        for share, at in ((0.42, 0.2), (0.3, -0.22)):
            high = float(rng.uniform(0.3, 0.9)) * top
            goods = (share * length, float(rng.uniform(0.6, 0.92)) * width, high)
            cargo = str(rng.choice(("wood", "concrete", "metal", "rusty-metal", "plastic")))
            builder.add("box", (x + at * length, 0.0, floor + 0.16 + high / 2), goods, "truck", cargo)


@lru_cache(maxsize=1)
def _tank() -> MeshTemplate:
    angle = 2 * np.pi * (np.arange(10) + 0.5) / 10
    circle = 0.5 / np.cos(np.pi / 10) * np.stack([np.zeros(10), np.cos(angle), np.sin(angle)], axis=1)
    circle = np.clip(circle, -0.5, 0.5)
    ends = ((-0.5, 0.6), (-0.485, 0.9), (-0.46, 1.0), (0.46, 1.0), (0.485, 0.9), (0.5, 0.6))
    return MeshTemplate.from_triangles(*loft(np.stack([diameter * circle + (x, 0.0, 0.0) for x, diameter in ends])))


@lru_cache(maxsize=1)
def _trough() -> MeshTemplate:
    """A tipping body: sides that lean outward, open above."""
    corners = frustum_corners((-0.46, 0.48, 0.8, 0.0), (-0.5, 0.5, 1.0, 1.0))
    vertices, faces = frustum(corners)
    return MeshTemplate.from_triangles(vertices, np.delete(faces, [2, 3], axis=0))


def _chassis(builder: ObjectBuilder, rear: float, front: float, floor: float) -> None:
    width = builder.placed.size[1]
    builder.add("box", ((rear + front) / 2, 0.0, floor - 0.2), (front - rear, 0.36 * width, 0.4), "truck", "metal")
    # rear underrun protection (UN Regulation 58), and the reflecting contour marking of UN Regulation 104 over it
    builder.add("box", (rear + 0.05, 0.0, 0.55), (0.1, 0.92 * width, 0.14), "truck", "metal")
    builder.add("box", (rear - 0.04, 0.0, floor - 0.1), (0.03, 0.95 * width, 0.14), "truck", "retroreflector")
    builder.add("box", (rear + 0.05, 0.0, floor - 0.25), (0.06, 0.06, floor - 0.5), "truck", "metal")


def _guards(builder: ObjectBuilder, span: tuple[float, float]) -> None:
    """Lateral protection between the axles, required by UN Regulation 73, and tanks behind it."""
    length = span[1] - span[0]
    if length < 0.5:
        return
    width = builder.placed.size[1]
    mesh = _rails()
    builder.add_mesh(mesh, (length, width, 1.0), "truck", "metal", at=((span[0] + span[1]) / 2, 0.0, 0.0))


@lru_cache(maxsize=1)
def _rails() -> MeshTemplate:
    bars = [box((0.0, side * 0.48, z), (1.0, 0.02, 0.14)) for side in (-1, 1) for z in (0.48, 0.78)]
    posts = [box((x, side * 0.46, 0.75), (0.03, 0.02, 0.66)) for side in (-1, 1) for x in (-0.35, 0.35)]
    return MeshTemplate.from_triangles(*join(*bars, *posts, box((0.2, 0.0, 0.72), (0.35, 0.84, 0.5))))


def _mirrors(builder: ObjectBuilder, label: str, x: float, z: float) -> None:
    builder.add_mesh(_ears(), (1.0, builder.placed.size[1], 1.0), label, "plastic", at=(x, 0.0, z))


@lru_cache(maxsize=1)
def _ears() -> MeshTemplate:
    return MeshTemplate.from_triangles(*join(*(box((0.0, side * 0.52, 0.0), (0.16, 0.08, 0.5)) for side in (-1, 1))))


def _plates(builder: ObjectBuilder, label: str, z: float) -> None:
    """Number plates (520 x 113 mm) at both ends."""
    for end in (-0.5, 0.5):
        builder.add("box", (end * builder.placed.size[0], 0.0, z), (0.03, 0.52, 0.113), label, "retroreflector")


@lru_cache(maxsize=4)
def _seats(rows: int, low: float, high: float) -> MeshTemplate:
    """Backs of seats in two columns."""
    x = np.repeat(np.linspace(-0.46, 0.40, rows), 2)
    y = np.tile([-0.26, 0.26], rows)
    across, tall = 0.19 * np.array([-1, 1, 1, -1]), np.array([low, low, high, high])
    corners = np.stack(
        [np.repeat(x[:, None], 4, axis=1), y[:, None] + across, np.broadcast_to(tall, (2 * rows, 4))], axis=2
    )
    return MeshTemplate.from_triangles(*quads(corners))
