"""The few solid shapes that a coarse layout has for an object, with the class of each.

All are solid, also for what is porous in the detailed scene: neither a sentence nor a clustering makes a medium.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from lidardraft.objects.placed_object import PlacedObject
from lidardraft.objects.plants import trunk_diameter

MOST_LOBES = 3  # ellipsoids of a crown
# A crown of one, two and three ellipsoids: their width, and their height where there are several, as shares of it.
_LOBE_WIDTHS, _LOBE_HEIGHT = (1.0, 0.78, 0.72), 0.86
_LOBE_TURN = 2.4  # rad per m of x, the golden angle: lobes of neighbours do not line up
_TRUNK_INTO_CROWN = 0.1  # share of the crown
# Diameters of posts [m] and what else an annotator would see: estimates.
_SIGN_POST, _LIGHT_POST, _GANTRY_POST, _BOARD_POST = 0.08, 0.11, 0.3, 0.2
_LOWEST_BOARD = 0.1  # m: boards with less clearance stand on the ground
_GANTRY_SIGNS = 0.75  # of the height, where they begin if nothing else is known
_TRACTOR = 0.36  # of the length of a trailer truck: 6 of 16.5 m, Directive 96/53/EC
_TRACTOR_GAP, _CAB_HEIGHT = 0.5, 3.6  # m between tractor and trailer; m at most
_BICYCLE_HEIGHT, _MOTORCYCLE_HEIGHT = 1.06, 1.1  # m, when ridden
_RIDER_FROM = 0.75  # m; the knees and feet of a rider belong to what is ridden
_RIDER_X, _RIDER_LENGTH = -0.02, 0.75  # m
_RIDER_WIDTH, _RIDDEN_WIDTH = 0.9, 0.5  # of the extents


class CoarseShape(NamedTuple):
    """One shape of an object: x forward, y left, z up from the ground under the object's middle [m].

    `instance_offset` is added to the object's instance. A crown is there once for each number of ellipsoids it may
    have: `lobes` is that number for its ellipsoids, and 0 for all other shapes.
    """

    shape: str
    center: tuple[float, float, float]
    size: tuple[float, float, float]
    label: str
    instance_offset: int = 0
    lobes: int = 0


def nothing(_placed: PlacedObject) -> list[CoarseShape]:
    """Nothing, for what only covers the ground."""
    return []


def box_of(label: str) -> Callable[[PlacedObject], list[CoarseShape]]:
    """What makes one box of a class, as large as the object."""

    def shapes(placed: PlacedObject) -> list[CoarseShape]:
        return [_standing(placed.size, label)]

    return shapes


def _standing(size: tuple[float, float, float], label: str, x: float = 0.0, instance_offset: int = 0) -> CoarseShape:
    return CoarseShape("box", (x, 0.0, size[2] / 2), size, label, instance_offset)


def _post(diameter: float, bottom: float, top: float, label: str = "pole", y: float = 0.0) -> CoarseShape:
    return CoarseShape("cylinder", (0.0, y, (bottom + top) / 2), (diameter, diameter, top - bottom), label)


def _plate(placed: PlacedObject, label: str, bottom: float) -> CoarseShape:
    length, width, height = placed.size
    return CoarseShape("box", (0.0, 0.0, (bottom + height) / 2), (length, width, height - bottom), label)


def house(placed: PlacedObject) -> list[CoarseShape]:
    """A box to the middle of the roof."""
    length, width, height = placed.size
    return [_standing((length, width, (placed.clearance + height) / 2), "building")]


def tree(placed: PlacedObject) -> list[CoarseShape]:
    """A trunk, and the crown as one, two and three ellipsoids: `lobes` says which belong together."""
    length, width, height = placed.size
    crown = height - placed.clearance
    bare = placed.clearance + _TRUNK_INTO_CROWN * crown
    shapes = [_post(trunk_diameter(height), 0.0, bare, "trunk")]
    turn = _LOBE_TURN * placed.x
    for lobes in range(1, MOST_LOBES + 1):
        # two or three balls around the middle that reach as far out, down and up as the whole crown
        share = _LOBE_WIDTHS[lobes - 1]
        for lobe in range(lobes):
            angle = turn + math.tau * lobe / lobes
            out = (1.0 - share) / 2
            up = 0.0 if lobes == 1 else (1.0 - _LOBE_HEIGHT) / 2 * (1 if lobe == 0 else -1)
            center = (
                out * length * math.cos(angle),
                out * width * math.sin(angle),
                placed.clearance + crown * (0.5 + up),
            )
            tall = crown if lobes == 1 else _LOBE_HEIGHT * crown
            shapes.append(
                CoarseShape("ellipsoid", center, (share * length, share * width, tall), "vegetation", 0, lobes)
            )
    return shapes


def bush(placed: PlacedObject) -> list[CoarseShape]:
    """One ellipsoid."""
    return [CoarseShape("ellipsoid", (0.0, 0.0, placed.size[2] / 2), placed.size, "vegetation")]


def mast(placed: PlacedObject) -> list[CoarseShape]:
    """A cylinder as thick as the extents are long."""
    return [_post(placed.size[0], 0.0, placed.size[2])]


def sign(placed: PlacedObject) -> list[CoarseShape]:
    """A post up to `clearance`, and the plate over it."""
    return [_post(_SIGN_POST, 0.0, placed.clearance), _plate(placed, "traffic-sign", placed.clearance)]


def traffic_light(placed: PlacedObject) -> list[CoarseShape]:
    """A post up to `clearance`, and the signal over it."""
    return [_post(_LIGHT_POST, 0.0, placed.clearance), _plate(placed, "traffic-light", placed.clearance)]


def gantry(placed: PlacedObject) -> list[CoarseShape]:
    """Two posts and the signs between them, from `clearance` up."""
    _, width, height = placed.size
    bottom = placed.clearance if 0.0 < placed.clearance < height else _GANTRY_SIGNS * height
    posts = [_post(_GANTRY_POST, 0.0, height, y=side * (width / 2 - _GANTRY_POST / 2)) for side in (-1, 1)]
    return [*posts, _plate(placed, "traffic-sign", bottom)]


def billboard(placed: PlacedObject) -> list[CoarseShape]:
    """A board on its post, or down to the ground where it has no clearance."""
    board = _plate(placed, "other", placed.clearance)
    return [_post(_BOARD_POST, 0.0, placed.clearance, "other"), board] if placed.clearance > _LOWEST_BOARD else [board]


def trailer_truck(placed: PlacedObject) -> list[CoarseShape]:
    """A tractor and its trailer, half a metre apart, the cab not as high as the load."""
    length, width, height = placed.size
    tractor = _TRACTOR * length
    trailer = length - tractor
    cab = (tractor - _TRACTOR_GAP, width, min(height, _CAB_HEIGHT))
    return [
        _standing((trailer, width, height), "truck", x=(trailer - length) / 2),
        _standing(cab, "truck", x=(length - cab[0]) / 2),
    ]


def cyclist(placed: PlacedObject) -> list[CoarseShape]:
    """A rider, and a bicycle as the next instance."""
    return _ridden(placed, "bicycle", _BICYCLE_HEIGHT)


def motorcyclist(placed: PlacedObject) -> list[CoarseShape]:
    """A rider, and a motorcycle as the next instance."""
    return _ridden(placed, "motorcycle", _MOTORCYCLE_HEIGHT)


def _ridden(placed: PlacedObject, label: str, top: float) -> list[CoarseShape]:
    length, width, height = placed.size
    rider = (_RIDER_LENGTH, width * _RIDER_WIDTH, height - _RIDER_FROM)
    return [
        CoarseShape("box", (_RIDER_X, 0.0, (_RIDER_FROM + height) / 2), rider, "rider"),
        _standing((length, _RIDDEN_WIDTH * width, top), label, instance_offset=1),
    ]
