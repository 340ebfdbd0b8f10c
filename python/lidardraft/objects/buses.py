"""Buses, after VDV 230."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from lidardraft.objects.cars import sample_paint
from lidardraft.objects.mesh import quads
from lidardraft.objects.mesh_template import MeshTemplate
from lidardraft.objects.object_builder import ObjectBuilder
from lidardraft.objects.placed_object import PlacedObject
from lidardraft.objects.vehicle_bodies import VehicleBody, add_mirrors, add_number_plates, add_vehicle
from lidardraft.scene.layout import Primitive

_BODY = VehicleBody(
    size=(12.0, 2.55, 3.1), cabin=(-0.5, 0.5), roof=(-0.497, 0.488), belt_line=0.37, nose=0.37, tail=0.37,
    axles=(-0.23, 0.27), wheel_diameter=0.96, side_windows=tuple(((k + 0.05) / 8, (k + 0.95) / 8) for k in range(8)),
    front_windows=((0.03, 0.97),), rear_windows=((0.12, 0.88),), window_rise=(0.02, 0.80), roof_width=0.96,
    clearance=0.30, taper=0.04,
)  # fmt: skip
# Estimates of ours; in shares of the bus, where it is not said.
_BODY_HEIGHT = 0.955  # the rest is the air conditioner's
_AIR_CONDITIONER = (2.6, 0.7, 0.06)  # length [m], width, height
_AIR_CONDITIONER_AT = ((-0.2, 0.1), 0.97)  # rearmost and foremost; middle
_MIRROR_AT = (0.02, 0.72)  # before the front [m]; height
_PLATE_HEIGHT = 0.55  # m
_SEAT_ROWS, _SEAT_BACK = 16, (0.34, 0.58)  # lowest and highest of a back
_SEATED = (-0.46, 0.40)  # last and first row
_SEAT_ASIDE, _SEAT_HALF = 0.26, 0.19  # from the middle; half of a double seat's width


def bus(placed: PlacedObject, rng: np.random.Generator) -> list[Primitive]:
    """A bus with bands of windows, seats behind them, an air conditioner on its roof."""
    length, width, height = placed.size
    builder = ObjectBuilder(placed)
    size = (length, width, _BODY_HEIGHT * height)
    add_vehicle(builder, _BODY, size, "bus", sample_paint(rng))
    builder.add_mesh(_seats(), size, "bus", "dark-cloth")
    (low, high), middle = _AIR_CONDITIONER_AT
    long, wide, tall = _AIR_CONDITIONER
    at = (rng.uniform(low, high) * length, 0.0, middle * height)
    builder.add("box", at, (long, wide * width, tall * height), "bus", "plastic")
    ahead, up = _MIRROR_AT
    add_mirrors(builder, "bus", length / 2 + ahead, up * height)
    add_number_plates(builder, "bus", _PLATE_HEIGHT)
    return builder.primitives


@lru_cache(maxsize=1)
def _seats() -> MeshTemplate:
    """Backs of seats in two columns."""
    low, high = _SEAT_BACK
    x = np.repeat(np.linspace(*_SEATED, _SEAT_ROWS), 2)
    y = np.tile([-_SEAT_ASIDE, _SEAT_ASIDE], _SEAT_ROWS)
    across, tall = _SEAT_HALF * np.array([-1, 1, 1, -1]), np.array([low, low, high, high])
    corners = np.stack(
        [np.repeat(x[:, None], 4, axis=1), y[:, None] + across, np.broadcast_to(tall, (2 * _SEAT_ROWS, 4))], axis=2
    )
    return MeshTemplate.from_triangles(*quads(corners))
