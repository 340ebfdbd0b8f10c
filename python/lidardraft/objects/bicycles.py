"""Bicycles, parked and ridden.

A bicycle has 28 inch wheels (622 mm rims, ISO 5775: 0.68 m with the tyre), and a frame and pedals by DIN EN ISO 4210;
tubes are a little thicker than steel's 32 mm. Other numbers are estimates.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from lidardraft.objects.cars import sample_paint
from lidardraft.objects.mesh import MeshTemplate, Triangles, box, join, quads, tube
from lidardraft.objects.object_builder import ObjectBuilder
from lidardraft.objects.placed_object import Vector
from lidardraft.objects.riders import Seat, add_rider

_LENGTH, _WIDTH = 1.78, 0.60  # m, of the bicycle with all places below
_AXLE = 0.55  # m, of the wheels from the middle
_RADIUS, _RIM = 0.34, 0.295  # m, of a wheel with and without its tyre
_TYRE = 0.02  # m, half its thickness
_HUB_WIDTH, _HUB = 0.05, 0.07  # m, half as wide as the fork; diameter
_SPOKES, _BLADE, _SPOKE = 9, 0.004, 0.3  # blades of 8 mm cover as much as 36 spokes of 2 mm; m, half width and length
_FIRST_SPOKE = 0.3  # of the angle between two
_SEAT = Seat(hip=(-0.22, 0.0, 0.98), foot=(0.03, 0.13, 0.28), hand=(0.33, 0.24, 1.04))
_LEANS = (0.15, 0.35, 0.6)  # rad: upright on a roadster, on a trekking bicycle, on a racer
_PANNIERS_P, _BASKET_P = 0.4, 0.3
_PANNIERS = ((-0.56, 0.0, 0.55), (0.32, 0.36, 0.32))  # m: middle and extents
_BASKET = ((0.60, 0.0, 0.86), (0.26, 0.36, 0.22))

_REAR, _FRONT, _BOTTOM = (-_AXLE, 0.0, _RADIUS), (_AXLE, 0.0, _RADIUS), (0.0, 0.0, 0.28)
_HEAD, _NECK, _STEM = (0.36, 0.0, 0.83), (0.40, 0.0, 0.68), (0.34, 0.0, 0.98)
# Bars of the frame [m]: start, end, diameter.
_BARS: tuple[tuple[Vector, Vector, float], ...] = (
    (_BOTTOM, (-0.21, 0.0, 0.95), 0.035),  # seat tube and post
    (_BOTTOM, _NECK, 0.045),  # down tube
    ((-0.17, 0.0, 0.80), _HEAD, 0.035),  # top tube
    (_BOTTOM, _REAR, 0.04),  # chain stays
    ((-0.19, 0.0, 0.86), _REAR, 0.03),  # seat stays
    ((0.34, 0.0, 0.96), _NECK, 0.045),  # head tube
    (_NECK, _FRONT, 0.045),  # fork
    ((0.34, -0.02, 0.98), (0.34, 0.02, 0.98), 0.05),  # clamp of the handlebar
    ((0.0, 0.06, 0.28), (0.17, 0.10, 0.28), 0.03),  # cranks
    ((0.0, -0.06, 0.28), (-0.17, -0.10, 0.28), 0.03),
    ((-0.24, 0.0, 0.72), (-0.62, 0.0, 0.73), 0.05),  # carrier
)
# Of both sides [m], y to the left: the halves of the handlebar, and their grips.
_HANDLE: tuple[Vector, Vector, float] = (_STEM, (0.30, 0.28, 1.02), 0.03)
_GRIP: tuple[Vector, Vector, float] = ((0.30, 0.20, 1.02), (0.24, 0.29, 1.03), 0.035)
_SADDLE = ((-0.22, 0.0, 0.965), (0.26, 0.16, 0.06))  # m: middle and extents
# Required by StVZO, section 67.
_REFLECTORS = (((-0.66, 0.0, 0.70), (0.02, 0.08, 0.05)), ((0.44, 0.0, 0.86), (0.02, 0.07, 0.06)))


def cyclist(builder: ObjectBuilder, rng: np.random.Generator) -> None:
    """A bicycle and its rider, who has the first of two instances."""
    lean = float(rng.choice(_LEANS))
    add_rider(builder, _SEAT, lean, rng, pedals=True)
    builder.next_instance()
    bicycle(builder, rng)


def bicycle(builder: ObjectBuilder, rng: np.random.Generator) -> None:
    """A bicycle without a rider."""
    length, width, _ = builder.placed.size
    scale = (length / _LENGTH, width / _WIDTH, 1.0)
    builder.add_mesh(_tyres(), scale, "bicycle", "rubber")
    builder.add_mesh(_spokes(), scale, "bicycle", "metal")
    builder.add_mesh(_frame(), scale, "bicycle", sample_paint(rng))
    builder.add_mesh(_saddle_and_grips(), scale, "bicycle", "rubber")
    builder.add_mesh(_reflectors(), scale, "bicycle", "retroreflector")
    if rng.random() < _PANNIERS_P:
        builder.add("box", *_PANNIERS, "bicycle", "cloth")
    if rng.random() < _BASKET_P:
        builder.add("box", *_BASKET, "bicycle", "metal")


@lru_cache(maxsize=1)
def _tyres(count: int = 14) -> MeshTemplate:
    """Both sides of the tyres of both wheels."""
    angle = 2 * np.pi * np.arange(count) / count
    ring = np.stack([np.cos(angle), np.zeros(count), np.sin(angle)], axis=1)
    sides = []
    for x in (-_AXLE, _AXLE):
        hub = np.array([x, 0.0, _RADIUS])
        for side in (-1, 1):
            outer, inner = hub + _RADIUS * ring, hub + _RIM * ring + (0.0, side * _TYRE, 0.0)
            sides.append(np.stack([outer, np.roll(outer, -1, 0), np.roll(inner, -1, 0), inner], axis=1))
    return MeshTemplate.from_triangles(*quads(np.concatenate(sides)))


@lru_cache(maxsize=1)
def _spokes() -> MeshTemplate:
    """Blades with gaps for rays, and hubs."""
    angle = 2 * np.pi * (np.arange(_SPOKES) + _FIRST_SPOKE) / _SPOKES
    out = np.stack([np.cos(angle), np.zeros(_SPOKES), np.sin(angle)], axis=1)
    across = _BLADE * np.stack([-np.sin(angle), np.zeros(_SPOKES), np.cos(angle)], axis=1)
    blades = []
    for x in (-_AXLE, _AXLE):
        hub = np.array([x, 0.0, _RADIUS])
        rim = hub + _SPOKE * out
        blades.append(np.stack([hub + across, hub - across, rim - across, rim + across], 1))
    hubs = [tube((x, -_HUB_WIDTH, _RADIUS), (x, _HUB_WIDTH, _RADIUS), (_HUB, _HUB), 5) for x in (-_AXLE, _AXLE)]
    return MeshTemplate.from_triangles(*join(quads(np.concatenate(blades)), *hubs))


@lru_cache(maxsize=1)
def _frame() -> MeshTemplate:
    """Frame, fork, handlebar, cranks and carrier."""
    bars = [_bar(*row) for row in _BARS]
    return MeshTemplate.from_triangles(*join(*bars, *(_bar(*_HANDLE, side) for side in (-1, 1))))


@lru_cache(maxsize=1)
def _saddle_and_grips() -> MeshTemplate:
    return MeshTemplate.from_triangles(*join(box(*_SADDLE), *(_bar(*_GRIP, side) for side in (-1, 1))))


@lru_cache(maxsize=1)
def _reflectors() -> MeshTemplate:
    return MeshTemplate.from_triangles(*join(*(box(*row) for row in _REFLECTORS)))


def _bar(start: Vector, end: Vector, diameter: float, side: int = 1) -> Triangles:
    """A tube with four sides, mirrored for the right side, -1."""
    (a, b, c), (u, v, w) = start, end
    return tube((a, side * b, c), (u, side * v, w), (diameter, diameter), 4)
