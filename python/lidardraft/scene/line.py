"""A line that places on a road, a lane or a drawn strip are measured from: along it, and to its left."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from lidardraft.errors import LayoutError
from lidardraft.files import named
from lidardraft.json_fields import check_fields, check_object
from lidardraft.scene.pose import finite_array, rotation


@dataclass(frozen=True, slots=True, eq=False)
class Line:
    """A polyline through `middle` f64 [S, 2] [m], with S of 2 or more.

    `normals` f64 [S, 2] point to its left, `along` f64 [S] are the distances [m] of the points from the first.
    `heights` f64 [S] [m] are those of the surface on the line, `camber` f64 [S] is the slope of the surface to the
    left.
    """

    middle: np.ndarray
    normals: np.ndarray
    along: np.ndarray
    heights: np.ndarray
    camber: np.ndarray

    @classmethod
    def through(cls, points: Any, camber: Any = None) -> Line:
        """The line through points [S, 2 or 3], level if they are 2D; raises `LayoutError` if they do not form one."""
        points = finite_array("points", points, "S", "2 or 3")
        if len(points) < 2 or points.shape[1] not in (2, 3):
            raise LayoutError(f"points has shape {points.shape}; it must be [S, 2] or [S, 3], with S of 2 or more")
        middle, level = points[:, :2], np.zeros(len(points))
        lengths = np.linalg.norm(np.diff(middle, axis=0), axis=1)
        if not lengths.min() > 0.0:
            raise LayoutError(f"points {int(np.argmin(lengths))} and {int(np.argmin(lengths)) + 1} are the same place")
        steps = np.gradient(middle, axis=0)
        normals = np.stack([-steps[:, 1], steps[:, 0]], axis=1) / np.linalg.norm(steps, axis=1, keepdims=True)
        along = np.concatenate([[0.0], np.cumsum(lengths)])
        heights = points[:, 2] if points.shape[1] == 3 else level
        return cls(
            middle, normals, along, heights, level if camber is None else finite_array("camber", camber, len(level))
        )

    @classmethod
    def read(cls, value: Any, name: str) -> Line:
        """The inverse of `written`; raises `FormatError` and `LayoutError` naming the place in the JSON."""
        with named(name):
            check_fields(check_object(value), ("points",), ("camber",))
            return cls.through(value["points"], value.get("camber"))

    def written(self) -> dict[str, Any]:
        """The line as JSON types."""
        camber = {"camber": self.camber.tolist()} if self.camber.any() else {}
        return {"points": np.column_stack([self.middle, self.heights]).tolist(), **camber}

    @property
    def length(self) -> float:
        """The length in plan [m]."""
        return float(self.along[-1])

    def at(self, along: Any, across: Any = 0.0) -> np.ndarray:
        """x, y [..., 2] of places along and across [m], numbers or arrays of one shape."""
        place = [np.interp(along, self.along, self.middle[:, k]) for k in (0, 1)]
        normal = [np.interp(along, self.along, self.normals[:, k]) for k in (0, 1)]
        return np.stack([p + across * n for p, n in zip(place, normal, strict=True)], axis=-1)

    def along_across(self, points: np.ndarray, *, beyond: bool = True) -> tuple[np.ndarray, np.ndarray]:
        """Along and across [N] [m] of points [N, 2]; the line goes on before its start and, with `beyond`, past its
        end."""
        lengths = np.diff(self.along)
        ahead, left = (np.diff(self.middle, axis=0) / lengths[:, None]).T
        x, y = (points[:, None, k] - self.middle[None, :-1, k] for k in (0, 1))
        share = x * ahead + y * left
        clipped = np.clip(share, 0.0, lengths)
        if beyond:
            clipped[:, 0] = np.minimum(share[:, 0], lengths[0])
            clipped[:, -1] = np.maximum(share[:, -1], clipped[:, -1])
        across = y * ahead - x * left
        best = np.argmin((share - clipped) ** 2 + across**2, axis=1)
        row = np.arange(len(points))
        return self.along[best] + clipped[row, best], across[row, best]

    def nearest(self, x: float, y: float) -> tuple[float, float]:
        """The point nearest to x, y [m]: of the line if it is straight, else one of its vertices."""
        if len(self.middle) == 2:
            (a, b), (c, d) = self.middle.tolist()
            length = self.length
            share = min(max(((x - a) * (c - a) + (y - b) * (d - b)) / length**2, 0.0), 1.0)
            return a + share * (c - a), b + share * (d - b)
        nearest = np.argmin(((self.middle - (x, y)) ** 2).sum(axis=1))
        return float(self.middle[nearest, 0]), float(self.middle[nearest, 1])

    def heading(self, along: Any) -> Any:
        """The direction [rad] at places along the line, a number or an array."""
        x, y = (np.interp(along, self.along, self.normals[:, k]) for k in (0, 1))
        return np.arctan2(-x, y)

    def height(self, along: Any, across: Any = 0.0) -> Any:
        """The height [m] of the surface along and across [m], numbers or arrays."""
        return np.interp(along, self.along, self.heights) + across * np.interp(along, self.along, self.camber)

    def normal(self, along: float) -> np.ndarray:
        """The unit normal [3] of the surface at a place along the line, upwards."""
        k = int(np.clip(np.searchsorted(self.along, along, side="right") - 1, 0, len(self.along) - 2))
        grade = (self.heights[k + 1] - self.heights[k]) / (self.along[k + 1] - self.along[k])
        a, b = (float(np.interp(along, self.along, self.normals[:, j])) for j in (0, 1))
        slope = float(np.interp(along, self.along, self.camber))
        normal = np.array([-grade * b - slope * a, grade * a - slope * b, 1.0])
        return normal / np.linalg.norm(normal)

    def spaced(self, count: int) -> np.ndarray:
        """`count` evenly spaced points f64 [count, 2], from end to end."""
        return self.at(np.linspace(0.0, self.length, count))

    def moved(self, place: tuple[float, float, float]) -> Line:
        """The line of a frame that is at `place`, in the frame around it."""
        x, y, yaw = place
        turn = rotation(yaw)
        return Line(self.middle @ turn + (x, y), self.normals @ turn, self.along, self.heights, self.camber)
