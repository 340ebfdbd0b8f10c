"""The few solid shapes of an object in a layout, each with its class. In streets they are made for an object at its
place and size; in sentences and sketches, in the usual sizes of such objects.

All are solid, even for objects that are porous in the detailed scene: neither a sentence nor a clustering makes a
medium. Numbers without a source are estimates.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import NamedTuple

from lidardraft.objects.placed_object import PlacedObject, Vector
from lidardraft.objects.plants import trunk_diameter
from lidardraft.scene.layout import Primitive
from lidardraft.scene.pose import Place, point_at

STANDING = 0.5  # m over the ground: lower parts stand on it
_SEGMENT = 4.0  # m; the chord of a 90 m bend leaves the arc by 2 cm

# Of streets.
MOST_LOBES = 3  # ellipsoids of a crown
# A crown of one, two and three ellipsoids: their width, and for several ones their height, as shares of it.
_LOBE_WIDTHS, _LOBE_HEIGHT = (1.0, 0.78, 0.72), 0.86
_LOBE_TURN = 2.4  # rad per m of x, the golden angle: lobes of neighbours do not line up
_TRUNK_IN_CROWN = 0.25  # of the height of the crown: the reach of the trunk into it
# Diameters of posts [m] and other visible sizes.
_POSTS = {"traffic-sign": 0.08, "traffic-light": 0.15}
_GANTRY_POST, _BOARD_POST = 0.3, 0.2
_LOWEST_BOARD = 0.1  # m: boards with less clearance stand on the ground
_GANTRY_SIGNS = 0.75  # of the height: their default lower edge
_TRACTOR = 0.36  # of the length of a trailer truck: 6 of 16.5 m, Directive 96/53/EC
_TRACTOR_GAP, _CAB_HEIGHT = 0.5, 3.6  # m between tractor and trailer; m at most
_BICYCLE_HEIGHT, _MOTORCYCLE_HEIGHT = 1.06, 1.1  # m, when ridden
_SADDLE = 0.6  # of the height of a two-wheeler; the knees and feet of a rider belong to it
_RIDER_X, _RIDER_LENGTH, RIDER_WIDTH = -0.1, 0.7, 0.55  # m
_RIDER_SHARE, _RIDDEN_SHARE = 0.9, 0.5  # of the width of both

# Of sentences.
TRUNK_DIAMETER = (0.25, 0.5)  # m, smallest and largest
CROWN_BASE = (1.6, 2.4)  # m from the ground to where a crown begins, smallest and largest


class CoarseShape(NamedTuple):
    """One shape of an object: x forward, y left, z up from the ground under the object's middle [m].

    `instance_offset` is added to the object's instance. A crown has one version for each possible number of ellipsoids:
    `lobes` is that number for its ellipsoids, and 0 for all other shapes. `name` is that of the part in an id, empty
    for a single one.
    """

    shape: str
    center: Vector
    size: Vector
    label: str
    instance_offset: int = 0
    lobes: int = 0
    name: str = ""

    def placed(self, place: Place, level: float, id: str, instance: int = 0) -> Primitive:
        """The shape for an object at `place`, on ground at that `level` [m]."""
        x, y, z = self.center
        center, yaw = (*point_at(place, x, y), level + z), place[2]
        return Primitive(
            shape=self.shape, center=center, size=self.size, label=self.label, id=id, yaw=yaw, instance=instance
        )


def standing(
    shape: str, size: Vector, label: str, name: str = "", *, x: float = 0.0, y: float = 0.0, instance_offset: int = 0
) -> CoarseShape:
    """A shape of that size on the ground."""
    return CoarseShape(shape, (x, y, size[2] / 2), size, label, instance_offset, name=name)


def extents(parts: Sequence[CoarseShape]) -> Vector:
    """Length, width and height [m] of the upright box around all parts, about the middle of their footprint."""
    length, width = (2 * max(abs(part.center[axis]) + part.size[axis] / 2 for part in parts) for axis in (0, 1))
    return length, width, max(part.center[2] + part.size[2] / 2 for part in parts)


def resized(parts: list[CoarseShape], by: Vector) -> list[CoarseShape]:
    """The parts of an object stretched along each of its axes."""

    def scaled(extents: Vector) -> Vector:
        return extents[0] * by[0], extents[1] * by[1], extents[2] * by[2]

    return [part._replace(center=scaled(part.center), size=scaled(part.size)) for part in parts]


def in_segments(strip: CoarseShape) -> list[CoarseShape]:
    """A long box as several short ones, which can follow a bend."""
    length, thickness, height = strip.size
    count = math.ceil(length / _SEGMENT)
    step, size = length / count, (length / count, thickness, height)
    centers = [((number + 0.5) * step - length / 2, 0.0, height / 2) for number in range(count)]
    return [strip._replace(name=str(k), center=center, size=size) for k, center in enumerate(centers, start=1)]


def tree_parts(height: float, crown: float, trunk: float, base: float) -> list[CoarseShape]:
    """A tree `height` high with a crown `crown` wide from `base` up, and a trunk `trunk` thick [m]."""
    top, center = base + _TRUNK_IN_CROWN * (height - base), (0.0, 0.0, (base + height) / 2)
    return [
        _post(trunk, top, "trunk", name="trunk"),
        CoarseShape("ellipsoid", center, (crown, crown, height - base), "vegetation", name="crown"),
    ]


def street_light_parts(height: float) -> list[CoarseShape]:
    """A mast `height` [m] high with its lamp over the road, to the right."""
    lamp = CoarseShape("box", (0.0, -0.5, height), (0.3, 1.2, 0.15), "pole", name="lamp")
    return [_post(0.18, height, name="mast"), lamp]


def on_post(label: str, size: Vector, clearance: float) -> list[CoarseShape]:
    """A plate or a signal of a class, `size` [m] with its post; the post ends at `clearance` [m], the head is above
    it."""
    length, width, height = size
    head = CoarseShape("box", (0.0, 0.0, (clearance + height) / 2), (length, width, height - clearance), label)
    return [_post(_POSTS[label], clearance, name="pole"), head._replace(name=label.rpartition("-")[2])]


def rider_on(machine: CoarseShape, top: float, width: float = RIDER_WIDTH, name: str = "") -> CoarseShape:
    """The rider of a two-wheeler, up to `top` [m]."""
    saddle = _SADDLE * machine.size[2]
    size = _RIDER_LENGTH, width, top - saddle
    return CoarseShape("box", (_RIDER_X, 0.0, (saddle + top) / 2), size, "rider", name=name)


def _post(diameter: float, top: float, label: str = "pole", *, y: float = 0.0, name: str = "") -> CoarseShape:
    return standing("cylinder", (diameter, diameter, top), label, name, y=y)


def _plate(placed: PlacedObject, label: str, bottom: float) -> CoarseShape:
    length, width, height = placed.size
    return CoarseShape("box", (0.0, 0.0, (bottom + height) / 2), (length, width, height - bottom), label)


def house(placed: PlacedObject) -> list[CoarseShape]:
    """A box to the middle of the roof."""
    length, width, height = placed.size
    return [standing("box", (length, width, (placed.clearance + height) / 2), "building")]


def tree(placed: PlacedObject) -> list[CoarseShape]:
    """A trunk, and the crown as one, two and three ellipsoids: `lobes` tells which belong together."""
    length, width, height = placed.size
    crown = height - placed.clearance
    shapes = tree_parts(height, length, trunk_diameter(height), placed.clearance)[:1]
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
    return [standing("ellipsoid", placed.size, "vegetation")]


def mast(placed: PlacedObject) -> list[CoarseShape]:
    """A cylinder as thick as the extents are long."""
    return [_post(placed.size[0], placed.size[2])]


def sign(placed: PlacedObject) -> list[CoarseShape]:
    """A plate on its post."""
    return on_post("traffic-sign", placed.size, placed.clearance)


def traffic_light(placed: PlacedObject) -> list[CoarseShape]:
    """A signal on its post."""
    return on_post("traffic-light", placed.size, placed.clearance)


def gantry(placed: PlacedObject) -> list[CoarseShape]:
    """Two posts and the signs between them, from `clearance` up."""
    _, width, height = placed.size
    bottom = placed.clearance if 0.0 < placed.clearance < height else _GANTRY_SIGNS * height
    posts = [_post(_GANTRY_POST, height, y=side * (width / 2 - _GANTRY_POST / 2)) for side in (-1, 1)]
    return [*posts, _plate(placed, "traffic-sign", bottom)]


def billboard(placed: PlacedObject) -> list[CoarseShape]:
    """A board on its post, or down to the ground without a clearance."""
    board = _plate(placed, "other", placed.clearance)
    return [_post(_BOARD_POST, placed.clearance, "other"), board] if placed.clearance > _LOWEST_BOARD else [board]


def trailer_truck(placed: PlacedObject) -> list[CoarseShape]:
    """A tractor and its trailer, half a metre apart, the cab not as high as the load."""
    length, width, height = placed.size
    tractor = _TRACTOR * length
    trailer = length - tractor
    cab = (tractor - _TRACTOR_GAP, width, min(height, _CAB_HEIGHT))
    return [
        standing("box", (trailer, width, height), "truck", x=(trailer - length) / 2),
        standing("box", cab, "truck", x=(length - cab[0]) / 2),
    ]


def _ridden(label: str, top: float, placed: PlacedObject) -> list[CoarseShape]:
    """A rider, and the bicycle or motorcycle as the next instance."""
    length, width, height = placed.size
    machine = standing("box", (length, _RIDDEN_SHARE * width, top), label, instance_offset=1)
    return [rider_on(machine, height, _RIDER_SHARE * width), machine]


cyclist = partial(_ridden, "bicycle", _BICYCLE_HEIGHT)
motorcyclist = partial(_ridden, "motorcycle", _MOTORCYCLE_HEIGHT)
