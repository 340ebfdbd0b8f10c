"""Outlines: the few solid shapes that a drawing has for a thing, with the class of each."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from lidardraft.objects.parts import PlacedObject
from lidardraft.objects.plants import trunk_diameter

# The class of things that are drawn as one box; what is not named anywhere here is a car body.
_BOXES = {
    "truck": "truck",
    "bus": "bus",
    "tram": "train",
    "person": "person",
    "bicycle": "bicycle",
    "motorcycle": "motorcycle",
    "block": "building",
    "shed": "building",
    "hedge": "vegetation",
    "fence": "fence",
    "mesh_fence": "fence",
    "barrier": "fence",
    "garden_wall": "wall",
    "wall": "wall",
    **dict.fromkeys(("bin", "bench", "shelter", "cone", "letterbox", "hydrant", "cabinet"), "other"),
}
POLES = ("lamp", "pole", "sign", "traffic_light", "gantry", "billboard")
SMALL = (
    *("lamp", "pole", "sign", "traffic_light", "bin", "bench", "bush", "bicycle"),
    *("cone", "letterbox", "hydrant", "cabinet", "barrier", "mesh_fence"),
)
OMITTED = ("grass",)  # a cover of the ground, not a thing
MOST_LOBES = 3  # ellipsoids of a crown
_BROKEN = 2.4  # rad, the golden angle: lobes of neighbours do not line up
_TRACTOR = 0.36  # of the length of a trailer truck: 6 of 16.5 m, Directive 96/53/EC


class CoarseShape(NamedTuple):
    """One shape of an outline: x forward, y left, z up from the ground under the middle of the thing [m].

    `rank` is what is added to the thing's instance. `lobes` is the number of ellipsoids in the crown that the shape is
    one of, 0 for what is drawn whatever that number is.
    """

    shape: str
    center: tuple[float, float, float]
    size: tuple[float, float, float]
    label: str
    rank: int = 0
    lobes: int = 0


def coarse_shapes(placed: PlacedObject) -> list[CoarseShape]:
    """The shapes that a drawing has for a thing; crowns in each of their numbers of lobes.

    All are solid, also for what is porous in the detailed scene: neither a sentence nor a clustering makes a medium.
    """
    if placed.kind in OMITTED:
        return []
    if placed.kind in _COMPOSED:
        return _COMPOSED[placed.kind](placed)
    return [_standing(placed.size, _BOXES.get(placed.kind, "car"))]


def _standing(size: tuple[float, float, float], label: str, x: float = 0.0, rank: int = 0) -> CoarseShape:
    return CoarseShape("box", (x, 0.0, size[2] / 2), size, label, rank)


def _post(girth: float, bottom: float, top: float, label: str = "pole", y: float = 0.0) -> CoarseShape:
    return CoarseShape("cylinder", (0.0, y, (bottom + top) / 2), (girth, girth, top - bottom), label)


def _plate(placed: PlacedObject, label: str, bottom: float) -> CoarseShape:
    length, width, height = placed.size
    return CoarseShape("box", (0.0, 0.0, (bottom + height) / 2), (length, width, height - bottom), label)


def _house(placed: PlacedObject) -> list[CoarseShape]:
    """A box to the middle of the roof."""
    length, width, height = placed.size
    return [_standing((length, width, (placed.stem + height) / 2), "building")]


def _tree(placed: PlacedObject) -> list[CoarseShape]:
    length, width, height = placed.size
    crown = height - placed.stem
    bare = placed.stem + 0.1 * crown
    marks = [_post(trunk_diameter(placed), 0.0, bare, "trunk")]
    turn = _BROKEN * placed.x
    for lobes in range(1, MOST_LOBES + 1):
        # two or three balls around the middle that reach as far out, down and up as the whole crown
        share = (1.0, 0.78, 0.72)[lobes - 1]
        for lobe in range(lobes):
            angle = turn + math.tau * lobe / lobes
            out = (1.0 - share) / 2
            up = 0.0 if lobes == 1 else (1.0 - 0.86) / 2 * (1 if lobe == 0 else -1)
            center = (out * length * math.cos(angle), out * width * math.sin(angle), placed.stem + crown * (0.5 + up))
            tall = crown if lobes == 1 else 0.86 * crown
            marks.append(
                CoarseShape("ellipsoid", center, (share * length, share * width, tall), "vegetation", 0, lobes)
            )
    return marks


def _bush(placed: PlacedObject) -> list[CoarseShape]:
    return [CoarseShape("ellipsoid", (0.0, 0.0, placed.size[2] / 2), placed.size, "vegetation")]


def _mast(placed: PlacedObject) -> list[CoarseShape]:
    return [_post(placed.size[0], 0.0, placed.size[2])]


def _sign(placed: PlacedObject) -> list[CoarseShape]:
    return [_post(0.08, 0.0, placed.stem), _plate(placed, "traffic-sign", placed.stem)]


def _traffic_light(placed: PlacedObject) -> list[CoarseShape]:
    return [_post(0.11, 0.0, placed.stem), _plate(placed, "traffic-light", placed.stem)]


def _gantry(placed: PlacedObject) -> list[CoarseShape]:
    """Two posts and the signs between them, from `stem` up."""
    _, width, height = placed.size
    bottom = placed.stem if 0.0 < placed.stem < height else 0.75 * height
    posts = [_post(0.3, 0.0, height, y=side * (width / 2 - 0.15)) for side in (-1, 1)]
    return [*posts, _plate(placed, "traffic-sign", bottom)]


def _billboard(placed: PlacedObject) -> list[CoarseShape]:
    """A board on its post, or down to the ground where it has no stem."""
    board = _plate(placed, "other", placed.stem)
    return [_post(0.2, 0.0, placed.stem, "other"), board] if placed.stem > 0.1 else [board]


def _trailer_truck(placed: PlacedObject) -> list[CoarseShape]:
    """A tractor and its trailer, half a metre apart, the cab not as high as the load."""
    length, width, height = placed.size
    tractor, gap = _TRACTOR * length, 0.5
    trailer = length - tractor
    cab = (tractor - gap, width, min(height, 3.6))
    return [
        _standing((trailer, width, height), "truck", x=(trailer - length) / 2),
        _standing(cab, "truck", x=(length - cab[0]) / 2),
    ]


def _ridden(label: str, top: float) -> Callable[[PlacedObject], list[CoarseShape]]:
    lap = 0.75  # m; the knees and feet of a rider are drawn with what is ridden

    def marks(placed: PlacedObject) -> list[CoarseShape]:
        length, width, height = placed.size
        rider = CoarseShape("box", (-0.02, 0.0, (lap + height) / 2), (0.75, width * 0.9, height - lap), "rider")
        return [rider, _standing((length, 0.5 * width, top), label, rank=1)]

    return marks


_COMPOSED: dict[str, Callable[[PlacedObject], list[CoarseShape]]] = {
    "house": _house,
    "tree": _tree,
    "bush": _bush,
    "lamp": _mast,
    "pole": _mast,
    "sign": _sign,
    "traffic_light": _traffic_light,
    "gantry": _gantry,
    "billboard": _billboard,
    "trailer_truck": _trailer_truck,
    "cyclist": _ridden("bicycle", 1.06),
    "motorcyclist": _ridden("motorcycle", 1.1),
}
