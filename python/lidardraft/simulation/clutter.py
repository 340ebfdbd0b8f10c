"""What stands beside roads and nobody asks for: grass, plants, bins, signs and other small things."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from lidardraft.objects.kinds import kind_of
from lidardraft.objects.placed_object import PlacedObject, Vector
from lidardraft.scene.check import LayoutGround
from lidardraft.scene.layout import Layout, Primitive, object_of
from lidardraft.scene.solids import Solid, Solids
from lidardraft.semantics import GROUND
from lidardraft.simulation.coarse_object import generator_of
from lidardraft.simulation.surroundings import RoadStrip

_APART = 4.0  # m of road that each piece has for itself, on each side
_GAP = 0.3  # m to all that was given
_JUNCTION = 6.0  # m to another road
_FAR = 70.0  # m from the ego vehicle: what is further is hardly seen
_SEARCHED = (0.5, 1.0, 2.0, 3.0, 4.0, 6.0)  # m from the edge of a road, where a sidewalk is looked for


@dataclass(frozen=True, slots=True)
class _Piece:
    """A kind of clutter: how often, its smallest and largest extents and its clearance [m], and m from the kerb.

    What is `planted` stands on terrain, `off` from what is paved; the rest on a sidewalk, or on terrain without one.
    """

    share: float
    smallest: Vector
    largest: Vector
    off: tuple[float, float]
    clearance: float = 0.0
    planted: bool = False


# Estimates of ours; sizes are those of streets.
_PIECES: dict[str, _Piece] = {
    "grass": _Piece(0.34, (1.5, 0.5, 0.06), (4.0, 1.6, 0.35), (0.3, 2.5), planted=True),
    "bush": _Piece(0.24, (0.7, 0.6, 0.4), (1.8, 1.5, 1.4), (0.4, 3.0), planted=True),
    "bin": _Piece(0.14, (0.4, 0.4, 0.8), (0.6, 0.74, 1.1), (0.1, 0.4)),
    "pole": _Piece(0.08, (0.09, 0.09, 0.8), (0.14, 0.14, 1.1), (0.2, 0.3)),
    "sign": _Piece(0.07, (0.12, 0.42, 2.6), (0.12, 0.6, 2.9), (0.2, 0.4), clearance=2.0),
    "cabinet": _Piece(0.06, (0.3, 0.7, 1.0), (0.4, 1.4, 1.4), (0.2, 0.5)),
    "hydrant": _Piece(0.04, (0.35, 0.35, 0.8), (0.4, 0.4, 1.0), (0.2, 0.5)),
    "letterbox": _Piece(0.03, (0.35, 0.4, 1.2), (0.5, 0.5, 1.5), (0.2, 0.5)),
}
_NAMES = tuple(_PIECES)
_SHARES = np.cumsum([piece.share for piece in _PIECES.values()])


def clutter_around(layout: Layout, strips: tuple[RoadStrip, ...], seed: int, amount: float) -> list[Primitive]:
    """Clutter beside the roads of a layout, at a share `amount` of the places for it; it touches nothing given.

    Each place has random numbers of its own: what is moved away from one or to it changes no other.
    """
    ground = LayoutGround(layout)
    given = Solids(Solid.from_primitive(primitive) for primitive in layout if primitive.label not in GROUND)
    names = {object_of(primitive) for primitive in layout}
    made: list[Primitive] = []
    for strip in strips:
        others = [other for other in strips if other is not strip]
        for placed in _places(strip, ground, seed, amount):
            solid = Solid.box(*placed.place, placed.size[:2], placed.z, placed.z + placed.size[2])
            free = not any(given.touching(solid.widened(_GAP, _GAP)))
            if free and placed.id not in names and not _meets(others, placed.x, placed.y):
                made += kind_of(placed.kind).build(placed, generator_of(seed, placed.id))
    return made


def _places(strip: RoadStrip, ground: LayoutGround, seed: int, amount: float) -> Iterator[PlacedObject]:
    """What would stand along both sides of a road."""
    count = int(strip.length / _APART)
    chances = generator_of(seed, f"clutter {strip.id}").random((2, count, 7))
    for side in (-1, 1):
        for number, chance in enumerate(chances[(side + 1) // 2].tolist()):
            if chance[0] >= amount:
                continue
            kind = _NAMES[min(int(np.searchsorted(_SHARES, chance[1])), len(_NAMES) - 1)]
            along = (number + 0.25 + 0.5 * chance[2]) * _APART
            id = f"clutter_{strip.id.replace('.', '_')}_{'left' if side > 0 else 'right'}_{number}"
            placed = _placed(strip, ground, side, along, kind, id, chance[3:])
            if placed is not None:
                yield placed


def _placed(
    strip: RoadStrip, ground: LayoutGround, side: int, along: float, kind: str, id: str, chance: list[float]
) -> PlacedObject | None:
    """A piece on one side of a road, None where the ground beside it is not for it, or it is too far away."""
    piece = _PIECES[kind]
    length, width, height = (
        low + share * (high - low) for low, high, share in zip(piece.smallest, piece.largest, chance, strict=False)
    )
    low, high = piece.off
    off = low + chance[3] * (high - low) + max(length, width) / 2
    (edge,) = strip.at(np.array([along]), np.array([side * strip.half]))
    if math.hypot(*edge) > _FAR:
        return None
    if piece.planted:
        off += _walk(strip, ground, side, along)
    (ahead,) = strip.at(np.array([along + 0.1]), np.array([side * strip.half]))
    ((x, y),) = strip.at(np.array([along]), np.array([side * (strip.half + off)])).tolist()
    below = ground.at(x, y)
    if below is None or below[1] not in (("terrain",) if piece.planted else ("sidewalk", "terrain")):
        return None
    heading = math.atan2(ahead[1] - edge[1], ahead[0] - edge[0])
    # signs face who drives on their side
    yaw = heading if side > 0 else heading + math.pi
    z = below[0]
    return PlacedObject(
        kind=kind, id=id, x=x, y=y, z=z, level=z, yaw=yaw, size=(length, width, height), clearance=piece.clearance
    )


def _walk(strip: RoadStrip, ground: LayoutGround, side: int, along: float) -> float:
    """How far sidewalk reaches from the edge of the road [m]."""
    reach = 0.0
    for off in _SEARCHED:
        ((x, y),) = strip.at(np.array([along]), np.array([side * (strip.half + off)])).tolist()
        below = ground.at(x, y)
        if below is not None and below[1] == "sidewalk":
            reach = off
    return reach


def _meets(others: list[RoadStrip], x: float, y: float) -> bool:
    """Whether a place is near another road."""
    for other in others:
        along, across = other.along_across(np.array([(x, y)]))
        if abs(across[0]) < other.half + _JUNCTION and -_JUNCTION < along[0] < other.length + _JUNCTION:
            return True
    return False
