"""Buses, after VDV 230, and low-floor trams, after BOStrab: 2.65 m wide at most."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from lidardraft.objects.cars import sample_paint
from lidardraft.objects.mesh import MeshTemplate, quads
from lidardraft.objects.object_builder import ObjectBuilder
from lidardraft.objects.vehicle_bodies import (
    VehicleBody,
    add_glazing,
    add_mirrors,
    add_number_plates,
    add_vehicle,
    body_mesh,
)

_BODY = VehicleBody(
    size=(12.0, 2.55, 3.1), cabin=(-0.5, 0.5), roof=(-0.497, 0.488), belt_line=0.37, nose=0.37, tail=0.37,
    axles=(-0.23, 0.27), wheel_diameter=0.96, side_windows=tuple(((k + 0.05) / 8, (k + 0.95) / 8) for k in range(8)),
    front_windows=((0.03, 0.97),), rear_windows=((0.12, 0.88),), window_rise=(0.02, 0.80), roof_width=0.96,
    clearance=0.30, taper=0.04,
)  # fmt: skip
# Estimates, in shares of the bus without a unit.
_BODY_HEIGHT = 0.955  # the rest is the air conditioner
_AIR_CONDITIONER = (2.6, 0.7, 0.06)  # length [m], width, height
_AIR_CONDITIONER_AT = ((-0.2, 0.1), 0.97)  # rearmost and foremost; middle
_MIRROR_AT = (0.02, 0.72)  # before the front [m]; height
_PLATE_HEIGHT = 0.55  # m
_SEAT_ROWS, _SEAT_BACK = 16, (0.34, 0.58)  # lowest and highest of a back
_SEATED = (-0.46, 0.40)  # last and first row
_SEAT_ASIDE, _SEAT_HALF = 0.26, 0.19  # from the middle; half of a double seat's width


def bus(builder: ObjectBuilder, rng: np.random.Generator) -> None:
    """A bus with bands of windows, seats behind them, an air conditioner on its roof."""
    length, width, height = builder.placed.size
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


_SECTION = VehicleBody(
    size=(7.0, 2.5, 3.4), cabin=(-0.5, 0.5), roof=(-0.5, 0.5), belt_line=0.34, nose=0.34, tail=0.34, axles=(),
    wheel_diameter=0.6, side_windows=tuple(((k + 0.06) / 4, (k + 0.94) / 4) for k in range(4)), front_windows=(),
    rear_windows=(), window_rise=(0.04, 0.78), roof_width=0.94, clearance=0.25, taper=0.0,
)  # fmt: skip
_HEAD = VehicleBody(
    size=(7.0, 2.5, 3.4), cabin=(-0.5, 0.48), roof=(-0.5, 0.36), belt_line=0.34, nose=0.30, tail=0.34, axles=(),
    wheel_diameter=0.6, side_windows=((0.02, 0.24), (0.27, 0.49), (0.52, 0.74), (0.78, 0.93)), rear_windows=(),
    window_rise=(0.04, 0.80), roof_width=0.92, clearance=0.25, taper=0.25,
)  # fmt: skip
# Estimates.
_SECTION_LENGTH = 7.5  # m, about
_JOINT = 0.35  # m between two sections
_TRAM_BODY_HEIGHT = 0.92  # of the tram, to the roof; the current collector is over it
_BELLOWS = (0.86, 0.88)  # shares: of the width, of the body's height
_BELLOWS_MIDDLE = (0.52, 0.1)  # share of the body's height, and m
_BOGIE = (1.9, 0.8, 0.28)  # m long, share of the width, m high
_COLLECTOR = (0.5, 0.6, 0.08)  # shares: of the section's length, of width and height; folded down
_COLLECTOR_MIDDLE = 0.96  # of the height


def tram(builder: ObjectBuilder, rng: np.random.Generator) -> None:
    """A tram: heads and middle sections with bellows between, and its current collector folded down."""
    length, width, height = builder.placed.size
    paint = sample_paint(rng)
    count = max(2, round(length / _SECTION_LENGTH))
    last, pitch = count - 1, length / count
    body = _TRAM_BODY_HEIGHT * height
    for number in range(count):
        x = (number + 0.5) * pitch - length / 2
        size = (pitch - (_JOINT if 0 < number < last else _JOINT / 2), width, body)
        form = _HEAD if number in (0, last) else _SECTION
        x += _JOINT / 4 * ((number == last) - (number == 0))
        # the rear head is the front one turned round
        backward = number == 0
        builder.add_mesh(body_mesh(form), size, "train", paint, at=(x, 0.0, 0.0), backward=backward)
        add_glazing(builder, form, size, "train", x=x, backward=backward)
    share, over = _BELLOWS_MIDDLE
    for number in range(1, count):
        at = (number * pitch - length / 2, 0.0, share * body + over)
        builder.add("box", at, (_JOINT, _BELLOWS[0] * width, _BELLOWS[1] * body), "train", "rubber")
    for number in range(0, count, 2):
        x = (number + 0.5) * pitch - length / 2
        long, wide, tall = _BOGIE
        builder.add("box", (x, 0.0, tall / 2), (long, wide * width, tall), "train", "rusty-metal")
        long, wide, tall = _COLLECTOR
        size = (long * pitch, wide * width, tall * height)
        builder.add("box", (x, 0.0, _COLLECTOR_MIDDLE * height), size, "train", "metal")
