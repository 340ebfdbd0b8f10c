"""The space that things fill: upright boxes, kept in a coarse grid so that few need to be compared."""

from __future__ import annotations

import math

from lidardraft.streets.buildings import BALCONY, EAVES, STOREY
from lidardraft.streets.furniture import LAMP_ARM

# x, y, cosine and sine of the yaw, half length, half width, bottom and top over the ground [m]
Space = tuple[float, float, float, float, float, float, float, float]

_CELL = 8.0  # m
GANTRY_POST = 0.5  # m, how wide the posts of a gantry are


def box_space(x: float, y: float, yaw: float, size: tuple[float, float], bottom: float, top: float) -> Space:
    """The space of a box of that length and width [m]."""
    return (x, y, math.cos(yaw), math.sin(yaw), size[0] / 2, size[1] / 2, bottom, top)


def spaces_of(kind: str, x: float, y: float, yaw: float, size: tuple[float, float, float], stem: float) -> list[Space]:
    """The upright boxes a thing fills: a tree has its trunk's and its crown's, so that a car can stand under it."""
    length, width, height = size
    if kind == "tree":
        girth = 0.10 + height / 45  # as `plants.trunk_diameter`
        boxes = [((girth, girth), 0.0, stem), ((length, width), stem, height)]
    elif kind == "house":
        boxes = [((length, width), 0.0, height), ((length + 2 * EAVES, width + 2 * EAVES), stem - 0.2, height)]
    elif kind == "block":
        boxes = [((length, width), 0.0, height), ((length, width + 2 * BALCONY), 0.9 * STOREY, height)]
    elif kind == "lamp":
        # the arm reaches to its left
        left = (x - math.sin(yaw) * LAMP_ARM / 2, y + math.cos(yaw) * LAMP_ARM / 2)
        arm = box_space(*left, yaw, (0.3, LAMP_ARM + 0.3), height - 0.3, height)
        return [box_space(x, y, yaw, (length, width), 0.0, height), arm]
    elif kind == "billboard" or (kind == "sign" and width < 1.0):
        boxes = [((0.2, 0.2), 0.0, stem), ((length, width), stem, height)]
    elif kind == "gantry":
        cos, sin, out = math.cos(yaw), math.sin(yaw), (width - GANTRY_POST) / 2
        posts = [
            box_space(x - side * out * sin, y + side * out * cos, yaw, (length, GANTRY_POST), 0.0, height)
            for side in (-1, 1)
        ]
        return [*posts, box_space(x, y, yaw, (length, width), stem, height)]
    else:
        boxes = [((length, width), 0.0, height)]
    return [box_space(x, y, yaw, box, bottom, top) for box, bottom, top in boxes]


def touch(one: Space, two: Space, margin: float = 0.0) -> bool:
    """Whether two upright boxes come within `margin` [m]: separating axes, intervals in height."""
    x, y, cos, sin, length, width, bottom, top = one
    u, v, cos2, sin2, length2, width2, bottom2, top2 = two
    if bottom2 >= top or top2 <= bottom:
        return False
    dx, dy = u - x, v - y
    # cosine and sine of the angle between the two boxes
    c, s = abs(cos2 * cos + sin2 * sin), abs(sin2 * cos - cos2 * sin)
    if abs(cos * dx + sin * dy) >= length + c * length2 + s * width2 + margin:
        return False
    if abs(cos * dy - sin * dx) >= width + s * length2 + c * width2 + margin:
        return False
    if abs(cos2 * dx + sin2 * dy) >= length2 + c * length + s * width + margin:
        return False
    return abs(cos2 * dy - sin2 * dx) < width2 + s * length + c * width + margin


class Grid:
    """Spaces by the cells they lie in."""

    def __init__(self) -> None:
        self._cells: dict[tuple[int, int], list[Space]] = {}

    def add(self, space: Space) -> None:
        """Keep a space."""
        for cell in _cells(space, 0.0):
            self._cells.setdefault(cell, []).append(space)

    def touches(self, space: Space, margin: float = 0.0) -> bool:
        """Whether any of the spaces kept comes within `margin` [m] of one."""
        cells = self._cells
        return any(touch(space, other, margin) for cell in _cells(space, margin) for other in cells.get(cell, ()))


def _cells(space: Space, margin: float) -> list[tuple[int, int]]:
    x, y, cos, sin, length, width, _, _ = space
    wide = abs(cos) * length + abs(sin) * width + margin
    high = abs(sin) * length + abs(cos) * width + margin
    columns = range(math.floor((x - wide) / _CELL), math.floor((x + wide) / _CELL) + 1)
    rows = range(math.floor((y - high) / _CELL), math.floor((y + high) / _CELL) + 1)
    return [(column, row) for column in columns for row in rows]
