"""What a sketch holds, whatever it was drawn with: blobs and strokes in metres, and what of it was ignored."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from lidardraft.errors import FormatError

MOST_SHAPES = 1_500  # of one sketch
FURTHEST = 2_000.0  # m from the ego vehicle to the edge of a sketch


@dataclass(frozen=True, slots=True, eq=False)
class Blob:
    """A filled shape: the rectangle with the same centre [2], area and moments as it has, in the layout's frame.

    `label` is its class, `names` are what its author called it, `where` tells an author which shape it is. `yaw` is
    that of its length; it is a heading if it `points`, else the object may as well look the other way.
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
    """A line [N, 2] of the layout's frame with a `width` [m]; the end of a closed one is its begin.

    What is finer than `grain` [m] is no shape, but the pixels that it was painted with.
    """

    label: str
    names: tuple[str, ...]
    where: str
    line: np.ndarray
    width: float
    closed: bool = False
    grain: float = 0.0


@dataclass(slots=True, eq=False)
class Sketch:
    """Shapes of a sketch in the order in which they were found, a scale, and a line for all that was ignored."""

    metres_per_unit: float
    ego_marked: bool
    blobs: list[Blob] = field(default_factory=list)
    strokes: list[Stroke] = field(default_factory=list)
    ignored: list[str] = field(default_factory=list)

    def add(self, shapes: Iterable[Blob | Stroke]) -> None:
        """Put shapes to their like. Raises `FormatError` where there are too many."""
        for shape in shapes:
            if isinstance(shape, Blob):
                self.blobs.append(shape)
            else:
                self.strokes.append(shape)
        if len(self.blobs) + len(self.strokes) > MOST_SHAPES:
            raise FormatError(f"more than {MOST_SHAPES} shapes; sketches of up to so many are read")


@dataclass(frozen=True, slots=True, eq=False)
class SketchFrame:
    """Where the ego vehicle is on the sheet, right and down in its units, and how many metres a unit has."""

    ego: np.ndarray
    metres_per_unit: float

    def to_layout(self, points: np.ndarray) -> np.ndarray:
        """x, y [..., 2] in metres of places right and down on the sheet [..., 2]: up is x, left is y."""
        off: np.ndarray = (self.ego - points)[..., ::-1] * self.metres_per_unit
        return off
