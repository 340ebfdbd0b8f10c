"""How the ground of a layout rises and falls: heights where lines meet, and triangles that follow them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lidardraft import _core
from lidardraft.errors import LayoutError
from lidardraft.files import named
from lidardraft.json_fields import check_fields, check_object, read_as
from lidardraft.scene.mesh import TriangleMesh
from lidardraft.scene.pose import Place, finite_array, in_frame, rotation

_UNITS = 1000  # a metre, of lines and heights


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
            if len(lines) < 2 or (np.diff(lines) <= 0.0).any():
                raise LayoutError(f"relief: {name} has {len(lines)} lines; it must have two or more that increase")
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
        (row, p), (column, q) = _cells(self.x, own[:, 0]), _cells(self.y, own[:, 1])
        here, after = self.heights[row, column], self.heights[row + 1, column + 1]
        ahead, beside = self.heights[row + 1, column], self.heights[row, column + 1]
        first, last = here + p * (ahead - here) + q * (after - ahead), here + q * (beside - here) + p * (after - beside)
        return np.where(p >= q, first, last)

    def laid(self, mesh: TriangleMesh) -> TriangleMesh:
        """Level ground in the layout's frame, cut and raised as the ground rises. What lies over something else lies as
        far over it as before."""
        vertices, faces = _core.lay((self._own(mesh.vertices), mesh.faces), self.x, self.y, self.heights)
        x, y, yaw = self.place
        if any(self.place):
            vertices[:, :2] = vertices[:, :2] @ rotation(yaw) + (x, y)
        return TriangleMesh.unchecked(vertices, faces)

    def _own(self, points: np.ndarray) -> np.ndarray:
        """Points [N, 2 or more] in the frame of the lines."""
        if not any(self.place):
            return points
        x, y, yaw = self.place
        own = points.copy()
        own[:, :2] = (points[:, :2] - (x, y)) @ rotation(-yaw)
        return own


def _cells(lines: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The index of the line before each value, of the outermost cell for those beyond, and the share of the cell."""
    row = np.clip(np.searchsorted(lines, values, side="right") - 1, 0, len(lines) - 2)
    return row, np.clip((values - lines[row]) / (lines[row + 1] - lines[row]), 0.0, 1.0)
