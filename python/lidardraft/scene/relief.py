"""How the ground of a layout rises and falls: heights where lines meet, and triangles that follow them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lidardraft.errors import LayoutError, check_that
from lidardraft.files import named
from lidardraft.json_fields import check_fields, check_object, read_as
from lidardraft.scene.pose import Place, finite_array, in_frame, rotation

_UNITS = 1000  # a metre, of lines and heights
_NEAR = 1e-6  # m, or of a cell, by which what is not cut may be over a line
_FAR = 1e9  # m


@dataclass(frozen=True, slots=True, eq=False)
class Relief:
    """Heights f64 [X, Y] where the lines `x` [X] and `y` [Y], which increase, of a frame at `place` meet [m].

    Each cell between the lines is two triangles, which share the edge from its least x and y to its most. Beyond the
    outermost lines the ground goes on as high as it is there. All is rounded to millimetres. Raises `LayoutError` for
    lines that do not increase, and for other shapes.
    """

    x: np.ndarray
    y: np.ndarray
    heights: np.ndarray
    place: Place = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        for name, shape in (("x", ("X",)), ("y", ("Y",)), ("heights", ("X", "Y"))):
            rounded = np.rint(finite_array(f"relief: {name}", getattr(self, name), *shape) * _UNITS) / _UNITS
            object.__setattr__(self, name, rounded)
        for name, lines in (("x", self.x), ("y", self.y)):
            rises = len(lines) > 1 and bool((np.diff(lines) > 0.0).all())
            check_that(rises, f"relief: {name}", f"{len(lines)} numbers", "two or more that increase")
        if self.heights.shape != (len(self.x), len(self.y)):
            raise LayoutError(f"relief: heights are {self.heights.shape}; they must be {len(self.x)} by {len(self.y)}")

    @classmethod
    def read(cls, value: Any, name: str) -> Relief:
        """The inverse of `written`; raises `FormatError` and `LayoutError` naming the place in the JSON."""
        with named(name):
            check_fields(check_object(value), ("x", "y", "heights", "place"))
            x, y = (finite_array(one, value[one], "N") / _UNITS for one in ("x", "y"))
            heights = finite_array("heights", value["heights"], "X", "Y") / _UNITS
            return cls(x, y, heights, read_as(Place, value["place"], "place"))

    def written(self) -> dict[str, Any]:
        """As JSON types, lines and heights in whole millimetres."""
        rows = {name: np.rint(getattr(self, name) * _UNITS).astype(int).tolist() for name in ("x", "y", "heights")}
        return {**rows, "place": list(self.place)}

    def moved(self, place: Place) -> Relief:
        """That of a frame that stands at a place, as those around see it."""
        return replace(self, place=in_frame(self.place, place))

    def at(self, points: np.ndarray) -> np.ndarray:
        """The heights f64 [N] [m] at points [N, 2 or more] of the layout's frame."""
        own = self._own(points)
        return self._over(own, _cells(self.x, own[:, 0]), _cells(self.y, own[:, 1]))[0]

    def laid(self, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Triangles [T, 3, 3] of level ground, cut and raised as the ground rises: f64 [U, 3, 3], and the index [U] of
        the triangle that each is a piece of. What lies over something else lies as far over it as before."""
        own = self._own(triangles)
        owner, strips, whole = self._met(own)
        edges = [np.concatenate([[-_FAR], lines, [_FAR]]) for lines in (self.x, self.y)]
        low, high = (
            np.stack([edge[strip + k] for edge, strip in zip(edges, strips, strict=True)], axis=1) for k in (0, 1)
        )
        cells = [np.clip(strip - 1, 0, len(lines) - 2) for strip, lines in zip(strips, (self.x, self.y), strict=True)]
        # whole cells are two triangles each, with their heights over the plane of their owner
        square = np.stack([low[whole], high[whole]], axis=1)
        squares = np.stack([square[:, [0, 1, 1, 0], 0], square[:, [0, 0, 1, 1], 1]], axis=2)
        a, b, c = own[owner[whole]].transpose(1, 0, 2)
        turn = np.cross(b - a, c - a)
        rise = -((squares - a[:, None, :2]) @ (turn[:, :2] / turn[:, 2:])[..., None])
        squares = np.concatenate([squares, a[:, None, 2:] + rise], axis=2)
        squares[turn[:, 2] < 0.0] = squares[turn[:, 2] < 0.0][:, [0, 3, 2, 1]]
        # the others are what is left of their owner between four lines, on either side of the diagonal
        part = np.flatnonzero(~whole)
        pieces = own[owner[part]]
        for axis in (0, 1):
            pieces = _kept(pieces, pieces[..., axis] - low[part, None, axis])
            pieces = _kept(pieces, high[part, None, axis] - pieces[..., axis])
        _, off = self._over(pieces, cells[0][part, None], cells[1][part, None])
        both = (off.min(axis=1) < -_NEAR) & (off.max(axis=1) > _NEAR)
        halves = [pieces[~both], _kept(pieces[both], off[both]), _kept(pieces[both], -off[both])]
        rows = [part[~both], part[both], part[both]]
        fans = [_fanned(*one) for one in [(squares, np.flatnonzero(whole)), *zip(halves, rows, strict=True)]]
        made, row = (np.concatenate(some) for some in zip(*fans, strict=True))
        made[..., 2] += self._over(made, cells[0][row, None], cells[1][row, None])[0]
        x, y, yaw = self.place
        made[..., :2] = made[..., :2] @ rotation(yaw) + (x, y)
        return made, owner[row]

    def _met(self, own: np.ndarray) -> tuple[np.ndarray, list[np.ndarray], np.ndarray]:
        """The cells that triangles [T, 3, 3] lie over: of each the index of the triangle, the strips of its lines, from
        0 before the first, and whether all of it is covered."""
        first, count = [], []
        for axis, lines in enumerate((self.x, self.y)):
            values = own[..., axis]
            first.append(np.searchsorted(lines, values.min(axis=1) + _NEAR, side="right"))
            last = np.searchsorted(lines, values.max(axis=1) - _NEAR, side="left")
            count.append(np.maximum(last - first[axis] + 1, 1))
        owner = np.repeat(np.arange(len(own)), count[0] * count[1])
        total = np.cumsum(count[0] * count[1])
        number = np.arange(len(owner)) - (total - count[0] * count[1])[owner]
        strips = [first[0][owner] + number // count[1][owner], first[1][owner] + number % count[1][owner]]
        edges = [np.concatenate([[-_FAR], lines, [_FAR]]) for lines in (self.x, self.y)]
        spans = [(edge[strip], edge[strip + 1]) for edge, strip in zip(edges, strips, strict=True)]
        step = np.roll(own, -1, axis=1)[..., :2] - own[..., :2]
        area = step[:, 0, 0] * step[:, 1, 1] - step[:, 0, 1] * step[:, 1, 0]
        inward = np.stack([-step[..., 1], step[..., 0]], axis=2) * np.sign(area)[:, None, None]
        inward /= np.maximum(np.linalg.norm(step, axis=2, keepdims=True), _NEAR)
        start = (inward * own[..., :2]).sum(axis=2)
        whole, seen = np.abs(area[owner]) > _NEAR, np.ones(len(owner), dtype=bool)
        for k in range(3):
            reach = [np.multiply(inward[owner, k, axis], span) for axis, span in enumerate(spans)]
            whole &= sum(one.min(axis=0) for one in reach) > start[owner, k] - _NEAR
            seen &= (sum(one.max(axis=0) for one in reach) > start[owner, k] + _NEAR) | (area[owner] == 0.0)
        return owner[seen], [strip[seen] for strip in strips], whole[seen]

    def _own(self, points: np.ndarray) -> np.ndarray:
        """Points [..., 2 or more] in the frame of the lines."""
        x, y, yaw = self.place
        own = points.copy()
        own[..., :2] = (points[..., :2] - (x, y)) @ rotation(-yaw)
        return own

    def _over(self, points: np.ndarray, row: np.ndarray, column: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The heights [...] of the cells at a row and a column of lines, over points [..., 2 or more] of their frame,
        and on which side of the diagonal they are."""
        p = np.clip((points[..., 0] - self.x[row]) / (self.x[row + 1] - self.x[row]), 0.0, 1.0)
        q = np.clip((points[..., 1] - self.y[column]) / (self.y[column + 1] - self.y[column]), 0.0, 1.0)
        here, after = self.heights[row, column], self.heights[row + 1, column + 1]
        ahead, beside = self.heights[row + 1, column], self.heights[row, column + 1]
        first, last = here + p * (ahead - here) + q * (after - ahead), here + q * (beside - here) + p * (after - beside)
        return np.where(p >= q, first, last), p - q


def _cells(lines: np.ndarray, values: np.ndarray) -> np.ndarray:
    """The index of the line before each value, of the outermost cell for those beyond."""
    return np.clip(np.searchsorted(lines, values, side="right") - 1, 0, len(lines) - 2)


def _kept(polygons: np.ndarray, side: np.ndarray) -> np.ndarray:
    """What of convex polygons [N, K, 3] lies where `side` [N, K] is 0 or more, [N, K + 1, 3]: the last corner fills
    what is left of the row."""
    number, corners, _ = polygons.shape
    inside = side >= 0.0
    crosses = inside != np.roll(inside, -1, axis=1)
    share = np.where(crosses, side / np.where(crosses, side - np.roll(side, -1, axis=1), 1.0), 0.0)[..., None]
    met = polygons + share * (np.roll(polygons, -1, axis=1) - polygons)
    keep = np.stack([inside, crosses], axis=2).reshape(number, -1)
    found = np.stack([polygons, met], axis=2).reshape(number, -1, 3)
    slot = np.cumsum(keep, axis=1) - 1
    kept = np.empty((number, corners + 1, 3))
    kept[:] = found[np.arange(number), 2 * corners - 1 - np.argmax(keep[:, ::-1], axis=1)][:, None]
    row, column = np.nonzero(keep)
    kept[row, slot[row, column]] = found[row, column]
    return kept


def _fanned(polygons: np.ndarray, row: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The triangles [U, 3, 3] of convex polygons [N, K, 3], and the entry of `row` [N] of each."""
    ways = np.diff(polygons, axis=1)
    number, k = np.nonzero((ways[:, 1:] != 0.0).any(axis=-1))
    return np.stack([polygons[number, 0], polygons[number, k + 1], polygons[number, k + 2]], axis=1), row[number]
