"""Motorcycles and scooters, parked and ridden: 17 and 12 inch wheels; other numbers are estimates."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from lidardraft.objects.cars import sample_paint
from lidardraft.objects.mesh import MeshTemplate, Triangles, box, join, loft, tube
from lidardraft.objects.object_builder import ObjectBuilder
from lidardraft.objects.placed_object import Vector
from lidardraft.objects.riders import Seat, add_rider

_LENGTH, _WIDTH = 2.10, 0.80  # m, of the motorcycle with all places below
_SCOOTER_P, _CASES_P = 0.35, 0.3
_SEAT = Seat(hip=(-0.22, 0.0, 0.84), foot=(0.0, 0.18, 0.32), hand=(0.42, 0.33, 1.03))
_LEAN = 0.25  # rad
_MUDGUARD = 0.06  # m, the excess of the length over the wheels
_PLACED = tuple[Vector, Vector]  # m: middle and extents
_CASES: _PLACED = ((-0.66, 0.0, 0.66), (0.42, 0.66, 0.30))
_SADDLE: _PLACED = ((-0.38, 0.0, 0.76), (0.76, 0.27, 0.13))
# A number plate, a tail light and their holder.
_TAIL: tuple[_PLACED, ...] = (
    ((-0.99, 0.0, 0.52), (0.02, 0.18, 0.20)),
    ((-0.90, 0.0, 0.72), (0.04, 0.16, 0.06)),
    ((-0.82, 0.0, 0.62), (0.30, 0.05, 0.05)),
)
_STEERING = (0.40, 0.0, 1.0)  # the joint of fork and handlebar
_FORK, _FORK_WIDTH = (0.06, 0.05), 0.09  # diameters above and below; from the middle
_HANDLE_END, _HANDLE = (0.36, 0.36, 1.05), (0.04, 0.05)  # of the left side; diameters
_MIRROR: _PLACED = ((0.30, 0.34, 1.12), (0.03, 0.12, 0.08))  # of the left side
_EXHAUST = ((0.0, -0.2, 0.30), (-0.75, -0.22, 0.42), (0.08, 0.11))  # start, end, diameters
# The profile of a tyre: shares of its radius and of half its width.
_TREAD = ((0.82, -1.0), (0.95, -0.8), (1.0, 0.0), (0.95, 0.8), (0.82, 1.0))


@dataclass(frozen=True, slots=True)
class _Form:
    """The differences of scooters [m]: wheels, the boxes of engine or footboard, and the ellipsoids of the cladding."""

    wheel_diameter: float
    tyre_width: float
    boxes: tuple[_PLACED, ...]
    cladding: tuple[_PLACED, ...]
    exhaust: bool


_MOTORCYCLE = _Form(
    wheel_diameter=0.63,
    tyre_width=0.15,
    boxes=(((0.05, 0.0, 0.45), (0.55, 0.36, 0.40)), ((-0.32, 0.0, 0.42), (0.40, 0.16, 0.12))),
    cladding=(((0.14, 0.0, 0.78), (0.60, 0.34, 0.30)), ((0.54, 0.0, 0.92), (0.30, 0.32, 0.40))),
    exhaust=True,
)
_SCOOTER = _Form(
    wheel_diameter=0.48,
    tyre_width=0.13,
    boxes=(((0.14, 0.0, 0.30), (0.72, 0.34, 0.10)),),
    cladding=(((-0.50, 0.0, 0.58), (0.80, 0.36, 0.42)), ((0.52, 0.0, 0.70), (0.24, 0.40, 0.70))),
    exhaust=False,
)


def motorcyclist(builder: ObjectBuilder, rng: np.random.Generator) -> None:
    """A motorcycle and its rider, who has the first of two instances."""
    add_rider(builder, _SEAT, _LEAN, rng, pedals=False)
    builder.next_instance()
    motorcycle(builder, rng)


def motorcycle(builder: ObjectBuilder, rng: np.random.Generator) -> None:
    """A motorcycle or a scooter without a rider."""
    length, width, _ = builder.placed.size
    scale = (length / _LENGTH, width / _WIDTH, 1.0)
    form = _SCOOTER if rng.random() < _SCOOTER_P else _MOTORCYCLE
    paint = sample_paint(rng)
    builder.add_mesh(_tyres(form), scale, "motorcycle", "rubber")
    builder.add_mesh(_engine(form), scale, "motorcycle", "metal" if form.exhaust else "plastic")
    builder.add_mesh(_saddle(), scale, "motorcycle", "rubber")
    builder.add_mesh(_tail(), scale, "motorcycle", "retroreflector")
    for center, size in form.cladding:
        builder.add("ellipsoid", center, size, "motorcycle", paint)
    if form is _MOTORCYCLE and rng.random() < _CASES_P:
        builder.add("box", *_CASES, "motorcycle", "plastic")


@lru_cache(maxsize=2)
def _tyres(form: _Form) -> MeshTemplate:
    axle = _axle(form)
    return MeshTemplate.from_triangles(*join(*(_tyre(x, form) for x in (-axle, axle))))


@lru_cache(maxsize=2)
def _engine(form: _Form) -> MeshTemplate:
    """Fork, handlebar, mirrors, engine or footboard, exhaust."""
    axle = _axle(form)
    solids = [tube(_STEERING, (axle, side * _FORK_WIDTH, form.wheel_diameter / 2), _FORK, 5) for side in (-1, 1)]
    x, y, z = _HANDLE_END
    solids += [tube(_STEERING, (x, side * y, z), _HANDLE, 5) for side in (-1, 1)]
    (x, y, z), size = _MIRROR
    solids += [box((x, side * y, z), size) for side in (-1, 1)]
    solids += [box(*row) for row in form.boxes]
    if form.exhaust:
        solids.append(tube(*_EXHAUST, 6))
    return MeshTemplate.from_triangles(*join(*solids))


@lru_cache(maxsize=1)
def _saddle() -> MeshTemplate:
    return MeshTemplate.from_triangles(*box(*_SADDLE))


@lru_cache(maxsize=1)
def _tail() -> MeshTemplate:
    return MeshTemplate.from_triangles(*join(*(box(*row) for row in _TAIL)))


def _axle(form: _Form) -> float:
    """The distance of the wheels from the middle [m]."""
    return _LENGTH / 2 - form.wheel_diameter / 2 - _MUDGUARD


def _tyre(x: float, form: _Form, count: int = 12) -> Triangles:
    """A wheel with a rounded tread."""
    diameter, width = form.wheel_diameter, form.tyre_width
    angle = 2 * np.pi * np.arange(count) / count
    circle = np.stack([np.cos(angle), np.zeros(count), np.sin(angle)], axis=1)
    rings = [radius * diameter / 2 * circle + (x, y * width / 2, diameter / 2) for radius, y in _TREAD]
    return loft(np.stack(rings))
