"""The content of a sketch of any source: blobs and strokes in metres; and the smoothing of lines."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from scipy import ndimage

from lidardraft.errors import FormatError

MOST_SHAPES = 1_500  # of one sketch
FURTHEST = 2_000.0  # m from the ego vehicle to the edge of a sketch
_MOST_POINTS = 10_000  # of a line


@dataclass(frozen=True, slots=True, eq=False)
class Blob:
    """A filled shape: the rectangle with its centre [2], area and moments, in the layout's frame.

    `label` is its class, `names` are its author's names for it, `where` identifies the shape for the author. `yaw` is
    that of its length. It is a heading if it `points`; else the object may face either way.
    """

    label: str
    names: tuple[str, ...]
    where: str
    center: np.ndarray
    length: float
    width: float
    yaw: float
    points: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Stroke:
    """A line [N, 2] of the layout's frame with a `width` [m]; a closed one ends at its start.

    Details finer than `grain` [m] are pixels of the painting, not shape.
    """

    label: str
    names: tuple[str, ...]
    where: str
    line: np.ndarray
    width: float
    closed: bool = False
    grain: float = 0.0

    def smoothed(self, sigma: float, step: float) -> np.ndarray:
        """Points [N, 2] of its line every `step` [m], without details shorter than some `sigma` [m]."""
        line, spacing = resampled(self.line, step)
        return smooth(line, min(sigma / spacing, len(line) / 6), self.closed)


@dataclass(slots=True, eq=False)
class Sketch:
    """Shapes of a sketch in the order in which they were found, a scale, and a line for each ignored item."""

    metres_per_unit: float
    ego_marked: bool
    blobs: list[Blob] = field(default_factory=list)
    strokes: list[Stroke] = field(default_factory=list)
    ignored: list[str] = field(default_factory=list)

    def add(self, shapes: Iterable[Blob | Stroke]) -> None:
        """Add shapes to their lists. Raises `FormatError` if there are too many."""
        for shape in shapes:
            if isinstance(shape, Blob):
                self.blobs.append(shape)
            else:
                self.strokes.append(shape)
            if len(self.blobs) + len(self.strokes) > MOST_SHAPES:
                raise FormatError(f"more than {MOST_SHAPES} shapes; sketches of up to so many are read")


@dataclass(frozen=True, slots=True, eq=False)
class SketchFrame:
    """The place of the ego vehicle on the sheet, right and down in its units, and the length of a unit in metres."""

    ego: np.ndarray
    metres_per_unit: float

    def to_layout(self, points: np.ndarray) -> np.ndarray:
        """x, y [..., 2] in metres of places right and down on the sheet [..., 2]: up is x, left is y."""
        off: np.ndarray = (self.ego - points)[..., ::-1] * self.metres_per_unit
        return off


def resampled(points: np.ndarray, step: float) -> tuple[np.ndarray, float]:
    """At least four evenly spaced points along a polyline [N, 2], about `step` apart, and their spacing."""
    off = np.linalg.norm(np.diff(points, axis=0), axis=1)
    along = np.concatenate([[0.0], np.cumsum(off)])
    kept = np.concatenate([[True], off > 0])
    count = max(4, min(_MOST_POINTS, math.ceil(along[-1] / step) + 1))
    places = np.linspace(0.0, along[-1], count)
    line = np.stack([np.interp(places, along[kept], points[kept, axis]) for axis in (0, 1)], axis=1)
    return line, max(float(along[-1]) / (count - 1), 1e-9)


def smooth(line: np.ndarray, deviation: float, closed: bool) -> np.ndarray:
    """A line [N, 2] convolved with a Gaussian, whose standard deviation is in points; its ends stay in place."""
    padded, more = _continued(line, math.ceil(4 * deviation), closed)
    wide = ndimage.gaussian_filter1d(padded, max(deviation, 1e-6), axis=0)
    return _ended(wide[more : more + len(line)], closed)


def without_bumps(line: np.ndarray, window: int, closed: bool) -> np.ndarray:
    """A line [N, 2] with each place the median of a window, an odd number of points: bumps shorter than half of it
    vanish."""
    padded, more = _continued(line, window // 2, closed)
    wide = ndimage.median_filter(padded, size=(window, 1))
    return _ended(wide[more : more + len(line)], closed)


def _continued(line: np.ndarray, more: int, closed: bool) -> tuple[np.ndarray, int]:
    """The line with up to `more` points before and behind it, and their number: a closed line continues around, another
    is turned about its ends, so that these stay in place."""
    more = min(len(line) - 1, more)
    if closed:
        ring = line[:-1]
        return np.concatenate([ring[len(ring) - more :], line, ring[1 : 1 + more]]), more
    begin, end = 2 * line[0] - line[more:0:-1], 2 * line[-1] - line[-2 : -2 - more : -1]
    return np.concatenate([begin, line, end]), more


def _ended(line: np.ndarray, closed: bool) -> np.ndarray:
    return np.concatenate([line[:-1], line[:1]]) if closed else line
