"""Vehicles: cars with bonnet, cabin and glass, vans, trucks, buses, motorcycles and bicycles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lidardraft.scene.layout import Primitive
from lidardraft.scene.mesh import TriangleMesh
from lidardraft.streets.people import rider
from lidardraft.streets.solids import hull, hull_panes, hull_solid, prism, quads
from lidardraft.streets.thing import Parts, Thing


@dataclass(frozen=True, slots=True)
class Body:
    """The side view of a car body, in shares of length (rear -0.5, front 0.5) and height.

    `cabin` is where the cabin meets the body (rear, front), `roof` where the roof begins and ends, `belt` the height of
    the window sill, `nose` that of the bonnet's front edge. `panes` are the side windows in shares of the cabin.
    """

    size: tuple[float, float, float]
    cabin: tuple[float, float]
    roof: tuple[float, float]
    belt: float
    nose: float
    panes: tuple[tuple[float, float], ...] = ((0.06, 0.46), (0.52, 0.92))


# Sizes [m] are common European dimensions, estimates of ours.
BODIES: dict[str, Body] = {
    "hatchback": Body((3.95, 1.72, 1.48), (-0.48, 0.26), (-0.42, 0.08), 0.62, 0.50),
    "saloon": Body((4.60, 1.82, 1.45), (-0.36, 0.20), (-0.22, 0.04), 0.64, 0.52),
    "estate": Body(
        (4.60, 1.82, 1.50), (-0.49, 0.20), (-0.42, 0.05), 0.62, 0.50, ((0.05, 0.3), (0.35, 0.62), (0.66, 0.94))
    ),
    "suv": Body((4.45, 1.84, 1.68), (-0.48, 0.25), (-0.42, 0.10), 0.62, 0.54),
    "minivan": Body(
        (4.50, 1.83, 1.70), (-0.49, 0.34), (-0.45, 0.14), 0.58, 0.46, ((0.05, 0.3), (0.35, 0.62), (0.66, 0.94))
    ),
    "coupe": Body((4.30, 1.80, 1.32), (-0.40, 0.18), (-0.20, -0.02), 0.66, 0.50, ((0.35, 0.9),)),
    "pickup": Body((5.25, 1.85, 1.80), (-0.12, 0.25), (-0.08, 0.10), 0.60, 0.56),
    "van": Body((5.20, 1.95, 2.05), (-0.50, 0.38), (-0.49, 0.22), 0.52, 0.44, ((0.72, 0.95),)),
}
SHARES = {
    "hatchback": 0.27,
    "saloon": 0.13,
    "estate": 0.14,
    "suv": 0.23,
    "minivan": 0.09,
    "coupe": 0.02,
    "pickup": 0.02,
    "van": 0.10,
}


def car_body(rng: np.random.Generator) -> tuple[str, tuple[float, float, float]]:
    """The name of a body and the extents of one car of it [m]."""
    name = str(rng.choice(list(SHARES), p=list(SHARES.values())))
    length, width, height = np.array(BODIES[name].size) * rng.normal(1.0, (0.035, 0.015, 0.02))
    return name, (float(length), float(width), float(height))


def _paint(rng: np.random.Generator) -> str:
    # about two in five new cars in Germany are black or dark grey (KBA, new registrations by colour)
    return "dark-paint" if rng.random() < 0.4 else "light-paint"


def car(thing: Thing, rng: np.random.Generator) -> list[Primitive]:
    """A car, its body named by `thing.kind`; body and wheels fill the thing's extents."""
    body = BODIES[thing.kind]
    length, width, height = thing.size
    parts, paint = Parts(thing), _paint(rng)
    clearance = 0.15  # usual for cars
    belt, nose = body.belt * height, body.nose * height
    profile = np.array(
        [
            (-0.5 * length, clearance + 0.06),
            (-0.5 * length, 0.92 * belt),
            (-0.48 * length, belt),
            (body.cabin[1] * length, belt),
            (0.46 * length, nose),
            (0.5 * length, 0.85 * nose),
            (0.5 * length, clearance + 0.06),
            (0.42 * length, clearance),
            (-0.42 * length, clearance),
        ]
    )
    parts.add_mesh(*prism(profile, 0.98 * width), "car", paint)
    slab = 0.92 if thing.kind == "van" else 0.82
    corners = hull(
        (body.cabin[0] * length, body.cabin[1] * length, 0.95 * width, belt),
        (body.roof[0] * length, body.roof[1] * length, slab * width, height),
    )
    parts.add_mesh(*hull_solid(corners), "car", paint)
    rise = (0.10, 0.86)
    panes = [hull_panes(corners, 0, [(0.07, 0.93)], (0.06, 0.92))]
    panes += [hull_panes(corners, 1, [(1 - b, 1 - a) for a, b in body.panes], rise)]
    panes += [hull_panes(corners, 3, list(body.panes), rise)]
    if thing.kind != "van":
        panes += [hull_panes(corners, 2, [(0.1, 0.9)], (0.15, 0.85))]
    parts.add_mesh(*quads(np.concatenate(panes)), "car", "glass")
    _wheels(parts, "car", (0.31 * length, -0.29 * length), width, 0.62 if height < 1.6 else 0.70)
    for end in (-0.5, 0.5):
        # EU number plate, 520 x 113 mm, retroreflecting
        parts.add(
            "box",
            (end * length, 0.0, 0.45 if end > 0 else 0.7 * belt + 0.1),
            (0.03, 0.52, 0.113),
            "car",
            "retroreflector",
        )
    return parts.primitives


def truck(thing: Thing, rng: np.random.Generator) -> list[Primitive]:
    """A rigid truck: cab with windscreen, a gap, a load area (box, tank or open platform), axles."""
    length, width, height = thing.size
    parts, paint = Parts(thing), _paint(rng)
    cab, floor = 0.24 * length, 1.05
    cab_height = min(height, 2.9)
    front = length / 2
    corners = hull((front - cab, front, width, 0.4), (front - cab, front - 0.15, 0.97 * width, cab_height))
    parts.add_mesh(*hull_solid(corners), "truck", paint)
    panes = [hull_panes(corners, 0, [(0.06, 0.94)], (0.50, 0.84))]
    panes += [hull_panes(corners, 1, [(0.12, 0.6)], (0.52, 0.84)), hull_panes(corners, 3, [(0.4, 0.88)], (0.52, 0.84))]
    parts.add_mesh(*quads(np.concatenate(panes)), "truck", "glass")
    load = length - cab - 0.35
    middle = -front + load / 2
    if rng.random() < 0.75:
        cover = "light-paint" if rng.random() < 0.7 else "cloth"  # a hard box or a tarpaulin
        parts.add("box", (middle, 0.0, (floor + height) / 2), (load, width, height - floor), "truck", cover)
    else:
        parts.add("box", (middle, 0.0, floor + 0.3), (load, width, 0.6), "truck", paint)
        parts.add(
            "box", (middle, 0.0, (floor + height) / 2), (0.7 * load, 0.8 * width, height - floor), "truck", "wood"
        )
    parts.add("box", (middle, 0.0, 0.85), (length - cab, 0.8, 0.4), "truck", "metal")
    for side in (-1, 1):
        # lateral protection between the axles, required by UN Regulation 73
        parts.add("box", (0.02 * length, side * (width / 2 - 0.05), 0.75), (0.36 * length, 0.06, 0.6), "truck", "metal")
    _wheels(parts, "truck", (front - 0.6 * cab, -0.22 * length, -0.34 * length), width, 1.0)
    parts.add("box", (-front - 0.01, 0.0, 0.7), (0.03, 0.9 * width, 0.14), "truck", "retroreflector")
    return parts.primitives


def bus(thing: Thing, rng: np.random.Generator) -> list[Primitive]:
    """A bus with a band of windows, doors and wheels."""
    return _coach(thing, "bus", _paint(rng), step=1.5, floor=0.3)


def tram(thing: Thing, rng: np.random.Generator) -> list[Primitive]:
    """A tram of three sections with a band of windows."""
    return _coach(thing, "train", _paint(rng), step=1.8, floor=0.2)


def _coach(thing: Thing, label: str, paint: str, *, step: float, floor: float) -> list[Primitive]:
    length, width, height = thing.size
    parts = Parts(thing)
    corners = hull((-length / 2, length / 2, width, floor), (-length / 2 + 0.1, length / 2 - 0.2, 0.96 * width, height))
    parts.add_mesh(*hull_solid(corners), label, paint)
    count = round(length / step)
    spans = [((k + 0.06) / count, (k + 0.94) / count) for k in range(count)]
    panes = [hull_panes(corners, side, spans, (0.32, 0.80)) for side in (1, 3)]
    panes += [hull_panes(corners, 0, [(0.05, 0.95)], (0.25, 0.85)), hull_panes(corners, 2, [(0.15, 0.85)], (0.45, 0.8))]
    parts.add_mesh(*quads(np.concatenate(panes)), label, "glass")
    _wheels(parts, label, (0.28 * length, -0.25 * length), width, 0.95)
    return parts.primitives


def bicycle(thing: Thing, rng: np.random.Generator) -> list[Primitive]:
    """A bicycle without a rider."""
    parts = Parts(thing)
    _bicycle(parts, 0, rng)
    return parts.primitives


def cyclist(thing: Thing, rng: np.random.Generator) -> list[Primitive]:
    """A bicycle and its rider, who has the first of two instances."""
    parts = Parts(thing)
    rider(parts, seat=0.92, lean=0.22, rng=rng)
    _bicycle(parts, 1, rng)
    return parts.primitives


def motorcycle(thing: Thing, rng: np.random.Generator) -> list[Primitive]:
    """A motorcycle without a rider."""
    parts = Parts(thing)
    _motorcycle(parts, 0, rng)
    return parts.primitives


def motorcyclist(thing: Thing, rng: np.random.Generator) -> list[Primitive]:
    """A motorcycle and its rider, who has the first of two instances."""
    parts = Parts(thing)
    rider(parts, seat=0.78, lean=0.18, rng=rng)
    _motorcycle(parts, 1, rng)
    return parts.primitives


def _bicycle(parts: Parts, rank: int, rng: np.random.Generator) -> None:
    length, width, _ = parts.thing.size
    wheel = 0.68  # 28 inch with its tyre
    axle = length / 2 - wheel / 2
    for x in (-axle, axle):
        parts.add("mesh", (x, 0.0, wheel / 2), (wheel, 0.04, wheel), "bicycle", "rubber", mesh=_RIM, rank=rank)
    parts.add("box", (-0.02, 0.0, 0.80), (0.62, 0.05, 0.06), "bicycle", rank=rank)
    parts.add("box", (0.0, 0.0, 0.42), (0.85, 0.06, 0.07), "bicycle", rank=rank)
    parts.add("box", (-0.22, 0.0, 0.65), (0.06, 0.05, 0.55), "bicycle", rank=rank)
    parts.add("box", (0.36, 0.0, 0.72), (0.06, 0.05, 0.55), "bicycle", rank=rank)
    parts.add("ellipsoid", (-0.25, 0.0, 0.94), (0.28, 0.18, 0.08), "bicycle", "rubber", rank=rank)
    parts.add("box", (0.34, 0.0, 1.02), (0.06, width, 0.06), "bicycle", rank=rank)
    if rng.random() < 0.5:
        parts.add("box", (-0.55, 0.0, 0.55), (0.34, 0.38, 0.34), "bicycle", "cloth", rank=rank)  # panniers
    if rng.random() < 0.3:
        parts.add("box", (0.62, 0.0, 0.85), (0.28, 0.36, 0.24), "bicycle", rank=rank)  # a basket


def _motorcycle(parts: Parts, rank: int, rng: np.random.Generator) -> None:
    length, width, _ = parts.thing.size
    wheel = 0.62
    axle = length / 2 - wheel / 2
    for x in (-axle, axle):
        parts.add("ellipsoid", (x, 0.0, wheel / 2), (wheel, 0.16, wheel), "motorcycle", "rubber", rank=rank)
    paint = _paint(rng)
    parts.add("box", (0.0, 0.0, 0.45), (0.75, 0.38, 0.45), "motorcycle", "metal", rank=rank)
    parts.add("ellipsoid", (0.22, 0.0, 0.82), (0.62, 0.34, 0.34), "motorcycle", paint, rank=rank)
    parts.add("box", (-0.42, 0.0, 0.76), (0.70, 0.28, 0.14), "motorcycle", "rubber", rank=rank)
    parts.add("ellipsoid", (0.58, 0.0, 0.92), (0.34, 0.36, 0.46), "motorcycle", paint, rank=rank)
    parts.add("box", (0.46, 0.0, 1.08), (0.08, width, 0.06), "motorcycle", "metal", rank=rank)
    parts.add("box", (-0.5 * length + 0.1, 0.0, 0.62), (0.03, 0.2, 0.2), "motorcycle", "retroreflector", rank=rank)


def _wheels(parts: Parts, label: str, axles: tuple[float, ...], width: float, diameter: float) -> None:
    for x in axles:
        for side in (-1, 1):
            parts.add(
                "ellipsoid", (x, side * (width / 2 - 0.11), diameter / 2), (diameter, 0.22, diameter), label, "rubber"
            )


def _rim(count: int = 14, inner: float = 0.86) -> TriangleMesh:
    angle = 2 * np.pi * np.arange(count) / count
    ring = 0.5 * np.stack([np.cos(angle), np.zeros(count), np.sin(angle)], axis=1)
    here, after = np.arange(count), (np.arange(count) + 1) % count
    faces = [np.stack([here, after, after + count], axis=1), np.stack([here, after + count, here + count], axis=1)]
    return TriangleMesh(np.concatenate([ring, inner * ring]), np.concatenate(faces))


_RIM = _rim()
