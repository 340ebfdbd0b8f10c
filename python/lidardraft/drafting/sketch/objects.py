"""Blobs become objects, and strokes of plants and walls rows of parts, with the places, sizes and turns of the drawing.

Values that a view from above does not give, heights above all, are drawn at random from the sizes of `SENTENCE_KINDS`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from lidardraft.drafting.sketch.shapes import Blob, Stroke
from lidardraft.objects.coarse_shapes import (
    CROWN_BASE,
    TRUNK_DIAMETER,
    CoarseShape,
    extents,
    resized,
    tree_parts,
)
from lidardraft.objects.kinds import SENTENCE_KINDS
from lidardraft.objects.sentence_kind import SentenceKind
from lidardraft.scene import class_names
from lidardraft.scene.check import SIZE_RANGES
from lidardraft.scene.pose import point_at

# The kind of a class if neither a name nor a size gives it, unless it has the name of the class.
_USUAL_KIND = {"building": "house", "vegetation": "tree", "trunk": "tree", "rider": "bicycle"}
_USUAL_KIND |= {"train": "tram", "other": "bin"}
_BUSH = 2.3  # m across, at most
_LONGEST_CAR = 4.7  # m; a longer one is a van, between the sizes of both, and a still longer one a row of cars
_AS_DRAWN = ("building", "vegetation", "wall", "fence")  # classes with footprints as large as drawn
_LEAST = 0.6  # of the smallest extent of a class: a smaller drawing is a mark of an object of usual size
_LARGEST_MARK = 8.0  # m across, of a mark for a person, a pole or a sign
_MOST_AREAS = 4.0  # times the largest footprint of a vehicle: the limit of a blob
_GAP = 1.0  # m between vehicles drawn as one stroke; an estimate
_ROUND = 2 / math.sqrt(3)  # diameters of a disc to a side of the square with the same moments
_CROWN = (1.0, 14.0)  # m across; wider vegetation is several trees
_STAND_CROWN = 6.0  # m across, of the trees of a stand
_TREE_HEIGHT = (4.0, 16.0)  # m
_HEIGHT_PER_CROWN = 1.9  # the middle of the range in `SENTENCE_KINDS`
_WIDEST_HEDGE = 2.2  # m; a wider stroke of vegetation is a row of trees
_TREE_SPACING = 1.15  # crowns from one tree of a row to the next
_CORNER = 0.4  # m, the largest distance of a hedge, fence or wall from its stroke
_SHORTEST_PART = 0.05  # m
_MOST_PARTS = 2_000  # of one stroke or stand

Placed = tuple[str, list[tuple[CoarseShape, float]], np.ndarray]  # kind, parts with the yaw of each, place [2]


class NotDrawnError(Exception):
    """A shape that stands for no object; gives the reason."""


def kind_of(blob: Blob) -> SentenceKind:
    """The kind of object of a blob: from its names, or else from its class and size."""
    if name := class_names.kind_of(blob.names, blob.label):
        return SENTENCE_KINDS[name]
    if blob.label == "vegetation" and math.sqrt(blob.length * blob.width) < _BUSH:
        return SENTENCE_KINDS["bush"]
    if blob.label == "car" and _LONGEST_CAR < blob.length <= SIZE_RANGES["car"][1][0]:
        return SENTENCE_KINDS["van"]
    house = SENTENCE_KINDS["house"].sizes
    assert house is not None
    if blob.label == "building" and blob.length * blob.width > house.largest[0] * house.largest[1]:
        return SENTENCE_KINDS["building"]
    return SENTENCE_KINDS[_USUAL_KIND.get(blob.label, blob.label)]


def objects_of_blob(blob: Blob, yaw: float, rng: np.random.Generator) -> Iterator[Placed]:
    """The objects of a blob with heading `yaw` [rad]: one, or a row of vehicles, or a stand of trees."""
    kind = kind_of(blob)
    if blob.label in ("wall", "fence"):
        yield _placed(kind.name, _resized(kind, (blob.length, _thickness(kind, blob.width)), rng), blob.center, yaw)
    elif kind.is_vehicle:
        yield from _vehicles(blob, kind, yaw, rng)
    elif kind.name == "tree":
        yield from _trees(blob, yaw, rng)
    elif blob.label in _AS_DRAWN:
        footprint = max(blob.length, 0.5), max(blob.width, 0.5)
        if kind.name == "bush":
            footprint = (_ROUND * math.sqrt(footprint[0] * footprint[1]),) * 2
        yield _placed(kind.name, _resized(kind, footprint, rng), blob.center, yaw)
    elif max(blob.length, blob.width) > _LARGEST_MARK:
        raise NotDrawnError(f"{blob.length:.1f} x {blob.width:.1f} m is too large for a {kind.name}")
    else:
        parts = kind.sample_parts(rng, parked=blob.label != "rider")
        yield _placed(kind.name, parts, blob.center, yaw)


def objects_of_stroke(stroke: Stroke, rng: np.random.Generator) -> Iterator[Placed]:
    """A hedge, wall or fence along a stroke, or a row of trees along a wide one."""
    name = stroke.label
    if name == "vegetation":
        name = class_names.kind_of(stroke.names, name) or ("hedge" if stroke.width <= _WIDEST_HEDGE else "tree")
    kind = SENTENCE_KINDS[name]
    if not kind.follows_road:
        yield from _tree_row(stroke, rng)
        return
    line = _cornered(_even(stroke), _CORNER)
    whole = _resized(kind, (1.0, _thickness(kind, stroke.width)), rng)[0]
    place = line.mean(axis=0)
    parts = []
    for a, b in pairwise(line):
        length, turn = float(np.linalg.norm(b - a)), math.atan2(*(b - a)[::-1])
        if length > _SHORTEST_PART:
            x, y = ((a + b) / 2 - place).tolist()
            center = (*point_at((0.0, 0.0, -turn), x, y), whole.center[2])
            parts.append((whole._replace(center=center, size=(length, *whole.size[1:])), turn))
    if not parts:
        raise NotDrawnError("it has no length")
    if len(parts) > 1:
        parts = [(part._replace(name=str(number)), turn) for number, (part, turn) in enumerate(parts, start=1)]
    yield kind.name, parts, place


def _placed(kind: str, parts: list[CoarseShape], place: np.ndarray, yaw: float) -> Placed:
    return kind, [(part, yaw) for part in parts], place


def _vehicles(blob: Blob, kind: SentenceKind, yaw: float, rng: np.random.Generator) -> Iterator[Placed]:
    smallest, largest = SIZE_RANGES[blob.label]
    if blob.length * blob.width > _MOST_AREAS * largest[0] * largest[1] and blob.width > 1.6 * largest[1]:
        raise NotDrawnError(f"{blob.length:.1f} x {blob.width:.1f} m is too large for a {blob.label}")
    usual = extents(kind.sample_parts(rng, parked=True))
    count = max(1, round(blob.length / (usual[0] + _GAP))) if blob.length > largest[0] else 1
    share = blob.length / count - (_GAP if count > 1 else 0.0)
    drawn = (share, blob.width)
    length, width = (
        usual[axis] if drawn[axis] < _LEAST * smallest[axis] else min(max(drawn[axis], smallest[axis]), largest[axis])
        for axis in (0, 1)
    )
    ahead = np.array([math.cos(yaw), math.sin(yaw)])
    for number in range(min(count, _MOST_PARTS)):
        place = blob.center + ((number + 0.5) / count - 0.5) * blob.length * ahead
        yield _placed(kind.name, _resized(kind, (length, width), rng), place, yaw)


def _trees(blob: Blob, yaw: float, rng: np.random.Generator) -> Iterator[Placed]:
    if max(blob.length, blob.width) <= _CROWN[1]:
        yield _placed("tree", _tree(_ROUND * math.sqrt(blob.length * blob.width), rng), blob.center, 0.0)
        return
    along, across = (max(1, round(extent / _STAND_CROWN)) for extent in (blob.length, blob.width))
    if along * across > _MOST_PARTS:
        raise NotDrawnError(f"{blob.length:.0f} x {blob.width:.0f} m of trees; up to {_MOST_PARTS} are made")
    turn = np.array([[math.cos(yaw), math.sin(yaw)], [-math.sin(yaw), math.cos(yaw)]])
    for k in range(along * across):
        share = np.array([(k % along + 0.5) / along, (k // along + 0.5) / across]) - 0.5
        place = blob.center + (share * (blob.length, blob.width)) @ turn
        crown = min(_STAND_CROWN, blob.length / along, blob.width / across)
        yield _placed("tree", _tree(crown, rng), place, 0.0)


def _tree_row(stroke: Stroke, rng: np.random.Generator) -> Iterator[Placed]:
    crown = min(max(stroke.width, 2.5), _CROWN[1])
    line = _even(stroke)
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    count = max(1, min(_MOST_PARTS, round(along[-1] / (_TREE_SPACING * crown))))
    for k in range(count):
        place = np.array([np.interp((k + 0.5) / count * along[-1], along, line[:, axis]) for axis in (0, 1)])
        yield _placed("tree", _tree(crown, rng), place, 0.0)


def _tree(across: float, rng: np.random.Generator) -> list[CoarseShape]:
    crown = min(max(across, _CROWN[0]), _CROWN[1])
    height = min(max(_HEIGHT_PER_CROWN * crown * float(rng.uniform(0.85, 1.15)), _TREE_HEIGHT[0]), _TREE_HEIGHT[1])
    base = min(float(rng.uniform(*CROWN_BASE)), 0.45 * height)
    return tree_parts(height, crown, float(rng.uniform(*TRUNK_DIAMETER)), base)


def _even(stroke: Stroke) -> np.ndarray:
    """The line [N, 2] of a stroke without the wobble of a hand."""
    return stroke.smoothed(max(0.5 * stroke.width, 2.0 * stroke.grain), 0.5)


def _thickness(kind: SentenceKind, width: float) -> float:
    """The thickness of a strip drawn with this width [m]; a finer line is a mark."""
    assert kind.sizes is not None
    return max(width, kind.sizes.smallest[1])


def _resized(kind: SentenceKind, footprint: tuple[float, float], rng: np.random.Generator) -> list[CoarseShape]:
    """The parts of an object with that footprint (length, width) [m] and the height of one of its kind."""
    parts = kind.sample_parts(rng, parked=True)
    size = extents(parts)
    return resized(parts, (footprint[0] / size[0], footprint[1] / size[1], 1.0))


def _cornered(line: np.ndarray, tolerance: float) -> np.ndarray:
    """The corners of a line [N, 2] within a tolerance [m] of all of its points.

    Douglas and Peucker, "Algorithms for the reduction of the number of points required to represent a digitized line",
    Cartographica 1973.
    """
    kept, waiting = {0, len(line) - 1}, [(0, len(line) - 1)]
    while waiting:
        a, b = waiting.pop()
        if b - a < 2:
            continue
        chord, off = line[b] - line[a], line[a + 1 : b] - line[a]
        length = float(np.linalg.norm(chord))
        away = np.linalg.norm(off, axis=1)
        if length > 1e-9:
            along = np.clip(off @ chord / length, 0.0, length)
            away = np.linalg.norm(off - along[:, None] * chord / length, axis=1)
        if away.max() > tolerance:
            corner = a + 1 + int(np.argmax(away))
            kept.add(corner)
            waiting += [(a, corner), (corner, b)]
    return line[sorted(kept)]
