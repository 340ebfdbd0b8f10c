"""The lines of sight from the ego vehicle to the objects that were asked for, and the share of them that is open."""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Collection, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from lidardraft.scene.check import objects
from lidardraft.scene.layout import AROUND, Layout, Primitive, object_of
from lidardraft.scene.pose import Place
from lidardraft.scene.raycast import Raycaster
from lidardraft.semantics import BY_NAME, GROUND

SENSOR = (1.5, 2.2)  # m over the road, lowest and highest: estimates, as are those below
_EYE = (0.0, 0.0, sum(SENSOR) / 2)
_SEEN_WIDTH = 4.0  # of a building, a hedge and the like that stays in sight
_UNSEEN, _LEVEL_SEEN = 0.2, 2.5  # m over the ground that may be hidden, and up to where most rays go
_PIECE, _BEGINS, _MOST = 8.0, 1.5, 200  # m of a piece, m from the ego, objects
_ASIDE = (0.0, -1 / 3, 1 / 3, -2 / 3, 2 / 3, -1.0, 1.0)  # points of a wide object, in shares of half its width
_GRID = np.array([(a, b) for a in (-0.7, 0.0, 0.7) for b in (0.15, 0.5, 0.85)])  # lines, in shares of width and height


class _View(NamedTuple):
    """The part of an object to be seen: x and y of its middle, distance, half its width, lowest and highest z [m]."""

    x: float
    y: float
    distance: float
    half: float
    low: float
    high: float

    def moved(self, aside: float) -> _View:
        """The view moved `aside` [m] to the left, as seen from the ego vehicle."""
        x, y = self.x - aside * self.y / self.distance, self.y + aside * self.x / self.distance
        return self._replace(x=x, y=y, distance=math.hypot(x, y))

    def ways(self) -> np.ndarray:
        """The lines [9, 3] from the sensor to it [m]."""
        aside = _GRID[:, :1] * self.half * np.array([-self.y, self.x]) / self.distance
        up = self.low + _GRID[:, 1] * (min(self.high, self.low + _LEVEL_SEEN) - self.low)
        return np.column_stack([self.x + aside[:, 0], self.y + aside[:, 1], up]) - _EYE


class LinesOfSight:
    """The lines of sight to the objects `names` of a layout, as far as its other objects leave them open.

    `hidden` maps each object without an open line to the object that hides most of it.
    """

    def __init__(self, layout: Layout, names: Collection[str]) -> None:
        found = {name: parts for name, parts in objects(layout).items() if name in names}
        views = {name: list(_views(parts)) for name, parts in found.items()}
        self._views, self.hidden = dict[str, _View](), dict[str, str]()
        blockers = iter(_first_hits(layout, [view for some in views.values() for view in some]))
        for name, some in views.items():
            before = [[hit for hit in next(blockers) if hit not in ("", name)] for _ in some]
            self._views[name] = some[min(range(len(some)), key=lambda k: len(before[k]))]
            if all(len(hits) == len(_GRID) for hits in before):
                self.hidden[name] = Counter(itertools.chain.from_iterable(before)).most_common(1)[0][0]

    def spaces(self, reach: float) -> Iterator[tuple[Place, tuple[float, float], float, float]]:
        """The space between the ego vehicle and each object, in pieces that widen towards it, up to `reach` [m]: the
        place of each, its length and width, bottom and top [m]."""
        for x, y, distance, half, low, high in sorted(self._views.values(), key=lambda view: view.distance)[:_MOST]:
            begin = _BEGINS
            while begin < min(distance, reach):
                stop = min(begin + _PIECE, distance)
                near, far, ahead = begin / distance, stop / distance, (begin + stop) / 2 / distance
                bottom = min(SENSOR[0] * (1 - share) + low * share for share in (near, far))
                top = max(SENSOR[1] * (1 - share) + high * share for share in (near, far))
                place = (ahead * x, ahead * y, math.atan2(y, x))
                yield place, (stop - begin, 2 * half * far + 0.2), bottom, top
                begin = stop

    def share_open(self, whole: Layout) -> float:
        """The share of the lines that the surroundings of a layout leave open."""
        hits = _first_hits(whole, list(self._views.values()))
        closed = [hit.startswith(AROUND) for some in hits for hit in some]
        return round(1.0 - sum(closed) / max(len(closed), 1), 3)


def _views(parts: Sequence[Primitive]) -> Iterator[_View]:
    """The views of the largest part of an object, the nearest of equal ones: all of a thing, or pieces of a wide
    object, in its middle and aside."""
    body = max(parts, key=lambda part: (round(math.prod(part.size), 3), -math.hypot(*part.center[:2])))
    x, y, _ = body.center
    turn = body.yaw - math.atan2(y, x)
    half = (abs(math.sin(turn)) * body.size[0] + abs(math.cos(turn)) * body.size[1]) / 2
    seen = half if BY_NAME[body.label].is_thing else min(half, _SEEN_WIDTH / 2)
    low = min(part.center[2] - part.size[2] / 2 for part in parts)
    high = max(part.center[2] + part.size[2] / 2 for part in parts)
    middle = _View(x, y, max(math.hypot(x, y), 1e-6), seen, low + min(0.1 * (high - low), _UNSEEN), high)
    for share in _ASIDE if half > seen else (0.0,):
        yield middle.moved(share * (half - seen))


def _first_hits(layout: Layout, views: Sequence[_View]) -> list[list[str]]:
    """The name of the first object in each line to each view; "" if only ground is before its end."""
    if not views:
        return []
    ways = np.concatenate([view.ways() for view in views])
    lengths = np.linalg.norm(ways, axis=1)
    hits = Raycaster(layout).cast(np.tile(_EYE, (len(ways), 1)), ways / lengths[:, None], threads=1)
    names = np.array([*("" if part.label in GROUND else object_of(part) for part in layout), ""], dtype=object)
    before = np.where(hits.valid & (hits.distance < lengths), names[hits.primitive], "")
    rows: list[list[str]] = before.reshape(len(views), -1).tolist()
    return rows
