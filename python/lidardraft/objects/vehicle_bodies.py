"""Bodies of vehicles: a shell with wheel arches, pillars and a roof around windows, glass, wheels and number plates.

A body is shaped once, in the unit box, and stretched to all vehicles that have it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from lidardraft.objects.mesh import MeshTemplate, Triangles, box, frustum_corners, join, quads, window_frame
from lidardraft.objects.object_builder import ObjectBuilder
from lidardraft.objects.placed_object import Vector

TYRE = 0.125  # of the width: 0.22 m of 1.8 m (cars), 0.31 m of 2.5 m (trucks)
PLATE = (0.52, 0.113)  # m, width and height of a number plate in the EU
_PLATE_DEPTH = 0.03  # m
# Estimates.
_BELT_WIDTH = 0.94  # of the vehicle, the width of the cabin at its foot
_ARCH = 0.05  # m between a tyre and its arch
_ROOF_EDGE = 0.965  # of the height; the middle of a roof is higher
_CEILING = 0.95  # of the height, the upper end of glazing
_SLANTED = 0.15  # of the length: the glazing of a cabin that narrows upwards by more is stepped
_MARGIN = 0.04  # m between glazing and the frame around it
_RIM = 0.33  # of a wheel's diameter, the radius of its rim
_ARCH_STEPS = (-1.0, -0.92, -0.5, 0.0, 0.5, 0.92, 1.0)  # of an arch's half length
_SPANS = tuple[tuple[float, float], ...]
# Rays that enter a cabin end at its panes: the sensor model handles the inside, at one distance behind all of a pane.
GLAZING = 30.0  # 1/m


@dataclass(frozen=True, kw_only=True, slots=True)
class VehicleBody:
    """The side view of a body in shares of length (rear -0.5, front 0.5) and height, for a vehicle of `size` [m].

    `cabin` is the joint of cabin and body (rear, front), `roof` the start and end of the roof, `roof_width` its share
    of the width, `belt_line` the height of the window sill, `nose` that of the bonnet's front edge, `tail` that of the
    rear. `side_windows` are shares of the cabin from the rear, `front_windows` and `rear_windows` of its width;
    `window_rise` is their lower and upper edge in shares of the cabin's height. `axles` are shares of the length.
    `wheel_diameter` and `clearance`, the height of the sill, are in metres; `taper` is the narrowing of the ends.
    """

    size: Vector
    cabin: tuple[float, float]
    roof: tuple[float, float]
    belt_line: float
    nose: float
    tail: float
    axles: tuple[float, ...]
    wheel_diameter: float
    side_windows: _SPANS = ((0.06, 0.46), (0.52, 0.92))
    front_windows: _SPANS = ((0.06, 0.94),)
    rear_windows: _SPANS = ((0.09, 0.91),)
    window_rise: tuple[float, float] = (0.06, 0.88)
    roof_width: float = 0.80
    clearance: float = 0.18
    taper: float = 0.14


def add_vehicle(
    builder: ObjectBuilder, body: VehicleBody, size: Vector, label: str, paint: str, *, at: Vector = (0.0, 0.0, 0.0)
) -> None:
    """Add a body stretched to `size` [m], its glass, and wheels that stay round at any length."""
    builder.add_mesh(body_mesh(body), size, label, paint, at=at)
    add_glazing(builder, body, size, label, x=at[0])
    for axle in body.axles:
        add_axle(builder, label, (at[0] + axle * size[0], at[1]), size[1], body.wheel_diameter)


def add_axle(builder: ObjectBuilder, label: str, at: tuple[float, float], width: float, diameter: float) -> None:
    """Add the tyres and rims of an axle to a body of that width [m]."""
    center = (at[0], at[1], diameter / 2)
    extents = (diameter, width, diameter)
    builder.add_mesh(_tyres(), extents, label, "rubber", at=center)
    builder.add_mesh(_rims(), extents, label, "metal", at=center)


def add_number_plates(builder: ObjectBuilder, label: str, height: float) -> None:
    """Add a plate at each end, with its middle at that height [m]."""
    for end in (-0.5, 0.5):
        size = (_PLATE_DEPTH, *PLATE)
        builder.add("box", (end * builder.placed.size[0], 0.0, height), size, label, "retroreflector")


def add_mirrors(builder: ObjectBuilder, label: str, x: float, height: float) -> None:
    """Add the mirrors of a heavy vehicle, one on each side, at that place and height [m]."""
    builder.add_mesh(_mirrors(), (1.0, builder.placed.size[1], 1.0), label, "plastic", at=(x, 0.0, height))


@lru_cache(maxsize=1)
def _mirrors() -> MeshTemplate:
    return MeshTemplate.from_triangles(*join(*(box((0.0, side * 0.52, 0.0), (0.16, 0.08, 0.5)) for side in (-1, 1))))


@lru_cache(maxsize=128)
def body_mesh(body: VehicleBody) -> MeshTemplate:
    """All painted parts: shell, pillars and roof."""
    return MeshTemplate.from_triangles(*join(_shell(body), _frame(body)))


def _shell(body: VehicleBody) -> Triangles:
    """The lower body: sides with wheel arches, bonnet, boot, ends and the floor; open under the cabin."""
    length, _, height = body.size
    sill, arch = body.clearance / height, body.wheel_diameter / 2 + _ARCH
    reach, tall = arch / length, arch / height
    step = np.array(_ARCH_STEPS)
    bow = np.concatenate([[0.0], np.sqrt(1.0 - step[1:-1] ** 2), [0.0]])
    hub = body.wheel_diameter / 2 / height
    under_x, under_z = [-0.5, -0.47], [sill + 0.06, sill]
    for axle in sorted(body.axles):
        under_x += (axle + reach * step).tolist()
        under_z += [sill, *(hub + tall * bow[1:-1]).tolist(), sill]
    under_x, under_z = [*under_x, 0.47, 0.5], [*under_z, sill, sill + 0.06]
    rear, front = body.cabin
    over_x = [-0.5, -0.485, rear, front, 0.47, 0.5]
    over_z = [0.93 * body.tail, body.tail, body.belt_line, body.belt_line, body.nose, 0.85 * body.nose]
    x = np.unique(np.concatenate([under_x, over_x, [-0.42, 0.40]]))
    low, high = np.interp(x, under_x, under_z), np.interp(x, over_x, over_z)
    half = np.interp(x, [-0.5, -0.42, 0.40, 0.5], np.array([1 - 0.6 * body.taper, 1, 1, 1 - body.taper]) * 0.5)

    def line(across: np.ndarray, z: np.ndarray) -> np.ndarray:
        return np.stack([x, across, z], axis=1)

    skins = []
    for side in (-1, 1):
        foot, edge = line(side * half, low), line(0.95 * side * half, high)
        skins.append(np.stack([foot[:-1], foot[1:], edge[1:], edge[:-1]], axis=1))
        top = edge
    bottom = line(half, low)
    closed = (x[1:] <= rear + 1e-9) | (x[:-1] >= front - 1e-9)
    mirror = np.array([1.0, -1.0, 1.0])
    skins.append(np.stack([top[:-1], top[1:], top[1:] * mirror, top[:-1] * mirror], axis=1)[closed])
    skins += [np.stack([bottom[e], top[e], top[e] * mirror, bottom[e] * mirror])[None] for e in (0, -1)]
    floor = min(hub + tall, 0.9 * body.belt_line)
    inner = box((0.0, 0.0, (floor + sill) / 2), (0.92, 1.0 - 2.2 * TYRE, floor - sill))
    return join(quads(np.concatenate(skins)), inner)


def _cabin(body: VehicleBody) -> np.ndarray:
    return frustum_corners(
        (body.cabin[0], body.cabin[1], _BELT_WIDTH, body.belt_line),
        (body.roof[0], body.roof[1], body.roof_width, _ROOF_EDGE),
    )


def _frame(body: VehicleBody) -> Triangles:
    """Pillars, rails and a roof that is a little higher in its middle."""
    corners = _cabin(body)
    mirrored = tuple((1 - b, 1 - a) for a, b in reversed(body.side_windows))
    sides = [
        window_frame(corners, side, spans, body.window_rise)
        for side, spans in ((0, body.front_windows), (1, mirrored), (2, body.rear_windows), (3, body.side_windows))
    ]
    x = np.interp([0.0, 0.25, 0.75, 1.0], [0.0, 1.0], body.roof)
    half = body.roof_width / 2 * np.array([1.0, 0.93, 0.93, 1.0])
    ridge = np.array([_ROOF_EDGE, 1.0, 1.0, _ROOF_EDGE])
    crown = np.stack([x, half, ridge], axis=1)
    edge = np.stack([x, np.full(4, body.roof_width / 2), np.full(4, _ROOF_EDGE)], axis=1)
    mirror = np.array([1.0, -1.0, 1.0])
    roof = [np.stack([crown[:-1], crown[1:], crown[1:] * mirror, crown[:-1] * mirror], axis=1)]
    flank = np.stack([edge[:-1], edge[1:], crown[1:], crown[:-1]], axis=1)
    roof += [flank, flank * mirror]
    return quads(np.concatenate([*sides, *roof]))


def add_glazing(
    builder: ObjectBuilder, body: VehicleBody, size: Vector, label: str, *, x: float = 0.0, backward: bool = False
) -> None:
    """Add the panes of the cabin, and everything else in it that stops a ray, as a porous box, or two under slanted
    panes.

    The body's middle is at `x` [m]; `backward` turns it round.
    """
    length, width, height = size
    way = -1 if backward else 1
    middle = (body.belt_line + _CEILING) / 2
    slanted = body.roof[0] - body.cabin[0] + body.cabin[1] - body.roof[1] > _SLANTED
    tiers = ((1.0, middle, _CEILING), (0.5, body.belt_line, middle)) if slanted else ((1.0, body.belt_line, _CEILING),)
    for share, low, high in tiers:
        # each as long and wide as the top of the cabin
        rear, front = (share * roof + (1 - share) * cabin for roof, cabin in zip(body.roof, body.cabin, strict=True))
        wide = share * body.roof_width + (1 - share) * _BELT_WIDTH
        builder.add(
            "box",
            (x + way * (rear + front) / 2 * length, 0.0, (low + high) / 2 * height),
            ((front - rear) * length - _MARGIN, wide * width - _MARGIN, (high - low) * height),
            label,
            "car-glass",
            extinction=GLAZING,
        )


@lru_cache(maxsize=128)
def wheel_meshes(body: VehicleBody) -> tuple[MeshTemplate, MeshTemplate]:
    """Tyres and rims of all axles, in shares of the vehicle."""
    shares = np.array([body.wheel_diameter / body.size[0], 1.0, body.wheel_diameter / body.size[2]])

    def at_axles(mesh: MeshTemplate) -> MeshTemplate:
        wheel = mesh.mesh.vertices * mesh.size * shares + np.array([0.0, 0.0, shares[2] / 2])
        return MeshTemplate.from_triangles(
            *join(*((wheel + np.array([axle, 0.0, 0.0]), mesh.mesh.faces) for axle in body.axles))
        )

    return at_axles(_tyres()), at_axles(_rims())


@lru_cache(maxsize=1)
def _tyres(sides: int = 10) -> MeshTemplate:
    """Treads and outer faces of the two wheels of an axle, their lowest edges on the ground."""
    angle = 2 * np.pi * (np.arange(sides) + 0.5) / sides
    # the sides, not the corners, touch the circle
    ring = 0.5 / np.cos(np.pi / sides) * np.stack([np.cos(angle), np.zeros(sides), np.sin(angle)], axis=1)
    ring = np.clip(ring, -0.5, 0.5)
    after, fan = np.roll(np.arange(sides), -1), np.arange(1, sides - 1)
    solids = []
    for side in (-1, 1):
        face, inner = (ring + np.array([0.0, side * y, 0.0]) for y in (0.5, 0.5 - TYRE))
        here = np.arange(sides)
        faces = [
            np.stack([here, after, after + sides], axis=1),
            np.stack([here, after + sides, here + sides], axis=1),
            np.stack([np.zeros(sides - 2, dtype=np.int64), fan, fan + 1], axis=1),
        ]
        solids.append((np.concatenate([face, inner]), np.concatenate(faces)))
    return MeshTemplate.from_triangles(*join(*solids))


@lru_cache(maxsize=1)
def _rims() -> MeshTemplate:
    """A hexagon on each wheel of an axle."""
    angle = np.pi * np.arange(6) / 3
    disc = _RIM * np.stack([np.cos(angle), np.zeros(6), np.sin(angle)], axis=1)
    hexagons = [disc + np.array([0.0, side * 0.503, 0.0]) for side in (-1, 1)]
    return MeshTemplate.from_triangles(*quads(np.concatenate([h[[[0, 1, 2, 3], [0, 3, 4, 5]]] for h in hexagons])))
