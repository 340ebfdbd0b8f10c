"""Roads and sidewalks of a sketch become surfaces, as in `scene.road`; objects get headings along them."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from lidardraft.drafting.sketch.shapes import Blob, Sketch, Stroke
from lidardraft.scene.layout import Primitive
from lidardraft.scene.road import KERB_HEIGHT
from lidardraft.scene.road_surfaces import profile_of, ribbon, slab

_NARROWEST = {"road": 2.0, "sidewalk": 0.5}  # m; a thinner stroke is a centre line of a road of usual width
_USUAL = {"road": 7.0, "sidewalk": 2.0}  # m, two lanes of 3.5 m; as in `Road`
_WIDEST = 60.0  # m
_SHORTEST = 0.3  # m
_STRAIGHT = 0.5, 0.12  # m, and of the width: the wobble of a straight line drawn by hand
_BENT = 0.35  # of the width: the largest offset of the ends of a straight line, unless it goes on
_GOES_ON = 3.0  # widths of straight line between the ends
_STEP = 2.0  # m between the stations of a bend, as in `Road`
_BESIDE = 12.0  # m from the edge of a road: nearer objects drive along it, park beside it or face it
_ACROSS = math.radians(50)  # an object turned further against a road does not go along it
_FACING_ROAD = ("pole", "traffic-light", "traffic-sign")
_WOBBLE = 0.5  # of the width: shorter details along a stroke are wobble


@dataclass(frozen=True, slots=True, eq=False)
class DrawnSurface:
    """A road or sidewalk `width` [m] wide along a centre line [N, 2], of two points if it is straight."""

    label: str
    line: np.ndarray
    width: float


class Nearest:
    """The nearest of some surfaces, from the middle lines of all of them."""

    def __init__(self, surfaces: list[DrawnSurface], label: str) -> None:
        lines = [(each.line, each.width) for each in surfaces if each.label == label]
        self._begins = np.concatenate([line[:-1] for line, _ in lines] or [np.zeros((0, 2))])
        self._steps = np.concatenate([np.diff(line, axis=0) for line, _ in lines] or [np.zeros((0, 2))])
        self._halves = np.concatenate([np.full(len(line) - 1, width / 2) for line, width in lines] or [np.zeros(0)])
        self._squares = np.maximum((self._steps**2).sum(axis=1), 1e-12)

    def to(self, place: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        """The distance [m] of a place [2] from the nearest edge, negative on the surface; the offset [2] from the
        centre line, and the direction [2] there. The distance is infinite without surfaces."""
        if not len(self._begins):
            return math.inf, np.zeros(2), np.array([1.0, 0.0])
        share = np.clip(((place - self._begins) * self._steps).sum(axis=1) / self._squares, 0.0, 1.0)
        off = place - self._begins - share[:, None] * self._steps
        away = np.hypot(off[:, 0], off[:, 1]) - self._halves
        best = int(np.argmin(away))
        return float(away[best]), off[best], self._steps[best] / math.sqrt(self._squares[best])


def drawn_surfaces(sketch: Sketch) -> list[DrawnSurface]:
    """The roads and sidewalks of a sketch; one that is hardly longer than wide was drawn as a blob."""
    surfaces = []
    for stroke in sketch.strokes:
        if stroke.label in _USUAL:
            line = _middle_line(stroke)
            if np.ptp(line, axis=0).max() < _SHORTEST:
                sketch.ignored.append(f"{stroke.where}: it has no length")
            else:
                surfaces.append(DrawnSurface(stroke.label, line, _strip_width(stroke)))
    for blob in sketch.blobs:
        if blob.label in _USUAL:
            half = blob.length / 2 * np.array([math.cos(blob.yaw), math.sin(blob.yaw)])
            line = np.array([blob.center - half, blob.center + half])
            surfaces.append(DrawnSurface(blob.label, line, max(blob.width, 0.1)))
    return surfaces


def ground_primitives(surfaces: list[DrawnSurface]) -> Iterator[Primitive]:
    """The shapes of surfaces, with the ids road_1, road_2, ..., sidewalk_1, ..."""
    numbers: Counter[str] = Counter()
    for each in surfaces:
        numbers[each.label] += 1
        yield _surface(each.label, each.line, each.width, f"{each.label}_{numbers[each.label]}")


def height_at(walks: Nearest, place: np.ndarray) -> float:
    """The height over the road [m] of an object at a place [2]: that of a kerb on a sidewalk, else 0."""
    return KERB_HEIGHT if walks.to(place)[0] < 0 else 0.0


def heading(blob: Blob, roads: Nearest) -> float:
    """The yaw of a blob's object: along its length, and forwards in right-hand traffic on the nearest road.

    Objects that are not along a road face ahead rather than back. Those without a length, such as a lamp or a sign,
    stand as usual beside a road: facing oncoming traffic, or with the right to the road for a pole.
    """
    if blob.points:
        return blob.yaw
    away, off, ahead = roads.to(blob.center)
    if away > _BESIDE:
        return _forwards(blob.yaw, 0.0)
    if math.hypot(*off.tolist()) > 0.1:
        ahead = ahead if ahead[0] * off[1] - ahead[1] * off[0] <= 0 else -ahead  # the road is on its left
    elif ahead[0] < 0:
        ahead = -ahead
    along = math.atan2(ahead[1], ahead[0])
    if blob.label in _FACING_ROAD:
        return along + math.pi if blob.label == "pole" else along
    if abs(math.sin(blob.yaw - along)) > math.sin(_ACROSS):
        return _forwards(blob.yaw, 0.0)
    return _forwards(blob.yaw, along)


def _forwards(yaw: float, along: float) -> float:
    """The yaw or its opposite, whichever is nearer to `along`."""
    turned = yaw if math.cos(yaw - along) >= 0 else yaw + math.pi
    return math.remainder(turned, math.tau)


def _strip_width(stroke: Stroke) -> float:
    """The width [m] of the surface of a stroke."""
    width = stroke.width if stroke.width >= _NARROWEST[stroke.label] else _USUAL[stroke.label]
    return min(width, _WIDEST)


def _middle_line(stroke: Stroke) -> np.ndarray:
    """The centre line [N, 2] of a surface: two points if it is straight except for the wobble of a hand."""
    width = _strip_width(stroke)
    line = stroke.smoothed(max(_WOBBLE * width, 1.5 * stroke.grain), _STEP)
    away = [np.linalg.norm(line - end, axis=1) > width for end in (line[0], line[-1])]
    inner = line[away[0] & away[1]]  # hands and junctions bend the ends
    chord = _chord(inner if len(inner) > 2 else line)
    if stroke.closed or chord is None:
        return line
    middle, ahead, deviation = chord
    bent = np.abs((line[[0, -1]] - middle) @ np.array([-ahead[1], ahead[0]])).max() > _BENT * width
    short = np.ptp(inner @ ahead) < _GOES_ON * width if len(inner) else True
    if deviation > max(_STRAIGHT[0], _STRAIGHT[1] * width) or (bent and short):
        return line
    places = (line[[0, -1]] - middle) @ ahead
    straight: np.ndarray = middle + places[:, None] * ahead
    return straight if ahead[0] >= 0 else straight[::-1]


def _chord(line: np.ndarray) -> tuple[np.ndarray, np.ndarray, float] | None:
    """The middle and the direction of a line, and its deviation from straight [m]; None if it has no length."""
    middle = line.mean(axis=0)
    off = line - middle
    ahead = np.linalg.eigh(off.T @ off)[1][:, 1]
    if not off.any():
        return None
    ahead = ahead if (line[-1] - line[0]) @ ahead >= 0 else -ahead
    return middle, ahead, float(np.abs(off @ np.array([-ahead[1], ahead[0]])).max())


def _surface(label: str, line: np.ndarray, width: float, id: str) -> Primitive:
    """The surface of a width [m] along a centre line [N, 2]: a plane or box if it is straight, else a mesh."""
    top = KERB_HEIGHT if label == "sidewalk" else 0.0
    if len(line) == 2:
        (x, y), (dx, dy) = line.mean(axis=0).tolist(), (line[1] - line[0]).tolist()
        return slab(x, y, math.hypot(dx, dy), width, math.atan2(dy, dx), top, label, id)
    ahead = np.gradient(line, axis=0)
    if np.array_equal(line[0], line[-1]):  # the ends of a ring have one direction
        ahead[0] = ahead[-1] = line[1] - line[-2]
    ahead /= np.maximum(np.linalg.norm(ahead, axis=1, keepdims=True), 1e-9)
    left = np.stack([-ahead[:, 1], ahead[:, 0]], axis=1) * width / 2
    rows = [np.column_stack([line + side * left, np.full(len(line), z)]) for side, z in profile_of(-1.0, 1.0, top)]
    return ribbon(np.stack(rows, axis=1), label, id)
