"""Bicycles and motorcycles, parked and ridden.

A bicycle has 28 inch wheels (622 mm rims, ISO 5775: 0.68 m with the tyre) and a frame and pedals as DIN EN ISO 4210
measures them; motorcycles and scooters have 17 and 12 inch wheels. Tubes are a little thicker than steel's 32 mm.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from lidardraft.objects.cars import sample_paint
from lidardraft.objects.mesh import Triangles, box, join, loft, quads, tube
from lidardraft.objects.mesh_template import MeshTemplate
from lidardraft.objects.object_builder import ObjectBuilder
from lidardraft.objects.pedestrians import rider
from lidardraft.objects.placed_object import PlacedObject
from lidardraft.scene.layout import Primitive

_BICYCLE = (1.78, 0.60, 1.06)  # m, for which pieces are drawn
_MOTORCYCLE = (2.10, 0.80, 1.15)
_AXLE = 0.55  # m, of a bicycle's wheels from its middle
_SPOKES = 9  # blades of 8 mm that cover as much as 36 spokes of 2 mm


def bicycle(placed: PlacedObject, rng: np.random.Generator) -> list[Primitive]:
    """A bicycle without a rider."""
    builder = ObjectBuilder(placed)
    _bicycle(builder, rng)
    return builder.primitives


def cyclist(placed: PlacedObject, rng: np.random.Generator) -> list[Primitive]:
    """A bicycle and its rider, who has the first of two instances."""
    builder = ObjectBuilder(placed)
    lean = float(rng.choice((0.15, 0.35, 0.6)))
    rider(builder, (-0.22, 0.0, 0.98), (0.03, 0.13, 0.28), (0.33, 0.24, 1.04), lean, rng)
    builder.next_instance()
    _bicycle(builder, rng)
    return builder.primitives


def motorcycle(placed: PlacedObject, rng: np.random.Generator) -> list[Primitive]:
    """A motorcycle or a scooter without a rider."""
    builder = ObjectBuilder(placed)
    _motorcycle(builder, rng)
    return builder.primitives


def motorcyclist(placed: PlacedObject, rng: np.random.Generator) -> list[Primitive]:
    """A motorcycle and its rider, who has the first of two instances."""
    builder = ObjectBuilder(placed)
    rider(builder, (-0.22, 0.0, 0.84), (0.0, 0.18, 0.32), (0.42, 0.33, 1.03), 0.25, rng)
    builder.next_instance()
    _motorcycle(builder, rng)
    return builder.primitives


def _bicycle(builder: ObjectBuilder, rng: np.random.Generator) -> None:
    length, width, _ = builder.placed.size
    scale = (length / _BICYCLE[0], width / _BICYCLE[1], 1.0)
    tyres, spokes = _spoked()
    frame, saddle, reflectors = _diamond()
    builder.add_mesh(tyres, scale, "bicycle", "rubber")
    builder.add_mesh(spokes, scale, "bicycle", "metal")
    builder.add_mesh(frame, scale, "bicycle", sample_paint(rng))
    builder.add_mesh(saddle, scale, "bicycle", "rubber")
    builder.add_mesh(reflectors, scale, "bicycle", "retroreflector")
    if rng.random() < 0.4:  # panniers
        builder.add("box", (-0.56, 0.0, 0.55), (0.32, 0.36, 0.32), "bicycle", "cloth")
    if rng.random() < 0.3:  # a basket
        builder.add("box", (0.60, 0.0, 0.86), (0.26, 0.36, 0.22), "bicycle", "metal")


@lru_cache(maxsize=1)
def _spoked() -> tuple[MeshTemplate, MeshTemplate]:
    """Tyres of two wheels; spokes and hubs between which rays go through."""
    tyres, blades = [], []
    count = 14
    angle = 2 * np.pi * np.arange(count) / count
    ring = np.stack([np.cos(angle), np.zeros(count), np.sin(angle)], axis=1)
    for x in (-_AXLE, _AXLE):
        hub = np.array([x, 0.0, 0.34])
        for side in (-1, 1):
            outer, inner = hub + 0.34 * ring, hub + 0.295 * ring + (0.0, side * 0.02, 0.0)
            tyres.append(np.stack([outer, np.roll(outer, -1, 0), np.roll(inner, -1, 0), inner], axis=1))
        turn = 2 * np.pi * (np.arange(_SPOKES) + 0.3) / _SPOKES
        out = np.stack([np.cos(turn), np.zeros(_SPOKES), np.sin(turn)], axis=1)
        across = 0.004 * np.stack([-np.sin(turn), np.zeros(_SPOKES), np.cos(turn)], axis=1)
        blades.append(np.stack([hub + across, hub - across, hub + 0.3 * out - across, hub + 0.3 * out + across], 1))
    hubs = [tube((x, -0.05, 0.34), (x, 0.05, 0.34), (0.07, 0.07), 5) for x in (-_AXLE, _AXLE)]
    return MeshTemplate.from_triangles(*quads(np.concatenate(tyres))), MeshTemplate.from_triangles(
        *join(quads(np.concatenate(blades)), *hubs)
    )


@lru_cache(maxsize=1)
def _diamond() -> tuple[MeshTemplate, MeshTemplate, MeshTemplate]:
    """Frame, fork, handlebar, cranks and mudguards; saddle and grips; reflectors (required by StVZO, section 67)."""
    rear, front = (-_AXLE, 0.0, 0.34), (_AXLE, 0.0, 0.34)
    bottom, seat, head, neck = (0.0, 0.0, 0.28), (-0.19, 0.0, 0.86), (0.36, 0.0, 0.83), (0.40, 0.0, 0.68)
    bars = [
        (bottom, (-0.21, 0.0, 0.95), 0.035), (bottom, neck, 0.045), ((-0.17, 0.0, 0.80), head, 0.035),
        (bottom, rear, 0.04), (seat, rear, 0.03), ((0.34, 0.0, 0.96), neck, 0.045), (neck, front, 0.045),
        ((0.34, -0.02, 0.98), (0.34, 0.02, 0.98), 0.05), ((0.0, 0.06, 0.28), (0.17, 0.10, 0.28), 0.03),
        ((0.0, -0.06, 0.28), (-0.17, -0.10, 0.28), 0.03), ((-0.24, 0.0, 0.72), (-0.62, 0.0, 0.73), 0.05),
    ]  # fmt: skip
    frame: list[Triangles] = [tube(a, b, (diameter, diameter), 4) for a, b, diameter in bars]
    frame += [tube((0.34, 0.0, 0.98), (0.30, side * 0.28, 1.02), (0.03, 0.03), 4) for side in (-1, 1)]
    saddle = [box((-0.22, 0.0, 0.965), (0.26, 0.16, 0.06))]
    saddle += [tube((0.30, side * 0.20, 1.02), (0.24, side * 0.29, 1.03), (0.035, 0.035), 4) for side in (-1, 1)]
    marks = [box((-0.66, 0.0, 0.70), (0.02, 0.08, 0.05)), box((0.44, 0.0, 0.86), (0.02, 0.07, 0.06))]
    return (
        MeshTemplate.from_triangles(*join(*frame)),
        MeshTemplate.from_triangles(*join(*saddle)),
        MeshTemplate.from_triangles(*join(*marks)),
    )


def _motorcycle(builder: ObjectBuilder, rng: np.random.Generator) -> None:
    length, width, _ = builder.placed.size
    scale = (length / _MOTORCYCLE[0], width / _MOTORCYCLE[1], 1.0)
    scooter = bool(rng.random() < 0.35)
    tyres, engine, seat, marks = _machine(scooter)
    lacquer = sample_paint(rng)
    builder.add_mesh(tyres, scale, "motorcycle", "rubber")
    builder.add_mesh(engine, scale, "motorcycle", "plastic" if scooter else "metal")
    builder.add_mesh(seat, scale, "motorcycle", "rubber")
    builder.add_mesh(marks, scale, "motorcycle", "retroreflector")
    if scooter:
        builder.add("ellipsoid", (-0.50, 0.0, 0.58), (0.80, 0.36, 0.42), "motorcycle", lacquer)
        builder.add("ellipsoid", (0.52, 0.0, 0.70), (0.24, 0.40, 0.70), "motorcycle", lacquer)
    else:
        builder.add("ellipsoid", (0.14, 0.0, 0.78), (0.60, 0.34, 0.30), "motorcycle", lacquer)
        builder.add("ellipsoid", (0.54, 0.0, 0.92), (0.30, 0.32, 0.40), "motorcycle", lacquer)
        if rng.random() < 0.3:  # cases
            builder.add("box", (-0.66, 0.0, 0.66), (0.42, 0.66, 0.30), "motorcycle", "plastic")


@lru_cache(maxsize=2)
def _machine(scooter: bool) -> tuple[MeshTemplate, MeshTemplate, MeshTemplate, MeshTemplate]:
    """Tyres; engine, fork, handlebar and exhaust; seat; number plate and reflectors."""
    wheel, diameter = (0.48, 0.13) if scooter else (0.63, 0.15)
    axle = _MOTORCYCLE[0] / 2 - wheel / 2 - 0.06
    tyres = [_roller(x, wheel, diameter) for x in (-axle, axle)]
    top = (0.40, 0.0, 1.0)
    rest = [tube(top, (axle, side * 0.09, wheel / 2), (0.06, 0.05), 5) for side in (-1, 1)]
    rest += [tube(top, (0.36, side * 0.36, 1.05), (0.04, 0.05), 5) for side in (-1, 1)]
    rest += [box((0.30, side * 0.34, 1.12), (0.03, 0.12, 0.08)) for side in (-1, 1)]  # mirrors
    if scooter:
        rest += [box((0.14, 0.0, 0.30), (0.72, 0.34, 0.10))]
    else:
        rest += [box((0.05, 0.0, 0.45), (0.55, 0.36, 0.40)), box((-0.32, 0.0, 0.42), (0.40, 0.16, 0.12))]
        rest += [tube((0.0, -0.2, 0.30), (-0.75, -0.22, 0.42), (0.08, 0.11), 6)]
    seat = [box((-0.38, 0.0, 0.76), (0.76, 0.27, 0.13))]
    marks = [box((-0.99, 0.0, 0.52), (0.02, 0.18, 0.20)), box((-0.90, 0.0, 0.72), (0.04, 0.16, 0.06))]
    marks += [box((-0.82, 0.0, 0.62), (0.30, 0.05, 0.05))]
    return tuple(MeshTemplate.from_triangles(*join(*solids)) for solids in (tyres, rest, seat, marks))  # type: ignore[return-value]


def _roller(x: float, wheel: float, diameter: float, count: int = 12) -> Triangles:
    """A wheel with a rounded tread."""
    angle = 2 * np.pi * np.arange(count) / count
    circle = np.stack([np.cos(angle), np.zeros(count), np.sin(angle)], axis=1)
    rings = [
        radius * wheel / 2 * circle + (x, y * diameter / 2, wheel / 2)
        for radius, y in ((0.82, -1.0), (0.95, -0.8), (1.0, 0.0), (0.95, 0.8), (0.82, 1.0))
    ]
    return loft(np.stack(rings))
