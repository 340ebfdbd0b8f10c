"""The upright boxes that an object occupies, in its frame; placement keeps them apart."""

from __future__ import annotations

from lidardraft.objects.buildings import BALCONY, EAVES, STOREY
from lidardraft.objects.placed_object import Vector
from lidardraft.objects.plants import trunk_diameter
from lidardraft.objects.poles import LAMP_ARM
from lidardraft.objects.signs import GANTRY_POST, billboard_posts
from lidardraft.scene.solids import Solid

# Estimates.
CROWN_CORE = 0.7  # of the extents of a crown: its rim gives way, and overhangs neighbours
_POST = 0.2  # m, the room for a post
_ARM = 0.3  # m, thickness and height of a lamp's arm, with its luminaire
_UNDER_EAVES = 0.2  # m, the start of a roof under its eaves
_LOWEST_BALCONY = 0.9  # storeys over the ground
_NARROW_SIGN = 1.0  # m; wider signs stand on two posts


def whole(size: Vector, _clearance: float) -> list[Solid]:
    """The full extents, from the ground up."""
    length, width, height = size
    return [_box(length, width, 0.0, height)]


def tree(size: Vector, clearance: float) -> list[Solid]:
    """A trunk and the core of a crown, so that a car can stand under it and its rim overhang a wall."""
    length, width, height = size
    diameter = trunk_diameter(height)
    crown = (CROWN_CORE * length, CROWN_CORE * width, height)
    return [_box(diameter, diameter, 0.0, clearance), _above(crown, clearance)]


def house(size: Vector, clearance: float) -> list[Solid]:
    """Walls, and a roof that overhangs on all sides."""
    length, width, height = size
    roof = _box(length + 2 * EAVES, width + 2 * EAVES, clearance - _UNDER_EAVES, height)
    return [*whole(size, clearance), roof]


def block(size: Vector, clearance: float) -> list[Solid]:
    """Walls, and balconies from the first floor up."""
    length, width, height = size
    return [
        *whole(size, clearance),
        _box(length, width + 2 * BALCONY, _LOWEST_BALCONY * STOREY, height),
    ]


def lamp(size: Vector, clearance: float) -> list[Solid]:
    """A mast, and the longest arm to its left (+y)."""
    height = size[2]
    return [*whole(size, clearance), _box(_ARM, LAMP_ARM + _ARM, height - _ARM, height, y=LAMP_ARM / 2)]


def billboard(size: Vector, clearance: float) -> list[Solid]:
    """A post or two, and a board from `clearance` to the top."""
    posts = [_box(_POST, _POST, 0.0, clearance, y=y) for y in billboard_posts(size[1], clearance)]
    return [*posts, _above(size, clearance)]


def sign(size: Vector, clearance: float) -> list[Solid]:
    """A post and a plate; a wide sign has two posts, and nothing passes between them."""
    if size[1] >= _NARROW_SIGN:
        return whole(size, clearance)
    return [_box(_POST, _POST, 0.0, clearance), _above(size, clearance)]


def gantry(size: Vector, clearance: float) -> list[Solid]:
    """Two posts and the part between them, above `clearance`."""
    length, width, height = size
    out = (width - GANTRY_POST) / 2
    posts = [_box(length, GANTRY_POST, 0.0, height, y=side * out) for side in (-1, 1)]
    return [*posts, _above(size, clearance)]


def _box(length: float, width: float, bottom: float, top: float, *, y: float = 0.0) -> Solid:
    return Solid.box(0.0, y, 0.0, (length, width), bottom, top)


def _above(size: Vector, clearance: float) -> Solid:
    length, width, height = size
    return _box(length, width, clearance, height)
