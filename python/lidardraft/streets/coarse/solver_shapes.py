"""Objects as in sentences: the nearest to the real ones that the solver of sentences could have placed."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from lidardraft.drafting.solver.poses import LANE_OFFSET, YAW_DEVIATION
from lidardraft.drafting.solver.scene import GAP
from lidardraft.objects.coarse_shapes import (
    CROWN_BASE,
    CoarseShape,
    standing,
    street_light_parts,
)
from lidardraft.objects.kinds import SENTENCE_KINDS, Kind, kind_of
from lidardraft.objects.placed_object import PlacedObject, Vector
from lidardraft.objects.sentence_kind import SentenceKind
from lidardraft.scene.road import PARKING_STRIP, Road

# Sizes are changed by no more than this: a network that learned from layouts further off would learn to ignore them.
_MOST_RESIZED, _ALWAYS_RESIZED = 0.25, 0.12  # share of the size; m that are always allowed
_MOST_YAW = 3 * YAW_DEVIATION  # rad
_CROOKED = 0.2  # rad; objects turned by more keep their place
_IN_LANE = 0.5  # m from the middle of a lane, within which an object is in it
_LEAST_CROWN = 0.6  # of the height of a tree, the highest that its crown begins


def _extents(kind: SentenceKind) -> tuple[Vector, Vector]:
    """The smallest and the largest extents [m] of a kind; strips have any length."""
    assert kind.sizes is not None
    smallest, largest = kind.sizes.smallest, kind.sizes.largest
    if kind.follows_road:
        return (0.0, *smallest[1:]), (math.inf, *largest[1:])
    return smallest, largest


# A traffic light keeps its size: an arm makes it wide, and its pole is as high as it is.
_EXTENTS = {
    name: _extents(kind) for name, kind in SENTENCE_KINDS.items() if kind.sizes is not None and name != "traffic-light"
}
_LONGEST_BUILDING = _EXTENTS["building"][1][0]


def solver_shapes(
    objects: Iterable[PlacedObject], road: Road, middles: Sequence[float]
) -> list[tuple[int, CoarseShape, tuple[float, float, float]]]:
    """The shapes of all objects that a sentence can name: index of the object, shape, and its place (x, y, yaw).

    `middles` are those of the lanes across the road [m]. Several blocks side by side replace one longer than the
    solver's.
    """
    rows = np.unique(
        np.concatenate([np.asarray(middles, dtype=float), (road.edge - PARKING_STRIP / 2) * np.array([-1.0, 1.0])])
    )
    coarse = []
    for index, placed in enumerate(objects):
        kind = kind_of(placed.kind)
        if kind.word is None:
            continue
        standard = _resized(placed, kind)
        place = _settled(standard, SENTENCE_KINDS[kind.word], road, rows)
        coarse += [(index, shape, place) for shape in _shapes(standard, kind)]
    return coarse


def _resized(placed: PlacedObject, kind: Kind) -> PlacedObject:
    """The object in the nearest size of its word in sentences; a rider with a machine keeps the size of both."""
    if kind.word not in _EXTENTS or kind.instances > 1:
        return placed
    length, width, height = placed.size
    if kind.word == "house":
        height = (placed.clearance + height) / 2
    length, width, height = map(_nearest, (length, width, height), *_EXTENTS[kind.word])
    if kind.word == "tree":
        clearance = min(max(placed.clearance, CROWN_BASE[0]), CROWN_BASE[1], _LEAST_CROWN * height)
        return replace(placed, size=((length + width) / 2, (length + width) / 2, height), clearance=clearance)
    if kind.word == "bush":
        return replace(placed, size=((length + width) / 2, (length + width) / 2, height))
    return replace(placed, size=(length, width, height))


def _nearest(extent: float, low: float, high: float) -> float:
    """The nearest value to an extent within the limits, as far as resizing is allowed."""
    most = max(_MOST_RESIZED * extent, _ALWAYS_RESIZED)
    return min(max(min(max(extent, low), high), extent - most), extent + most)


def _shapes(placed: PlacedObject, kind: Kind) -> list[CoarseShape]:
    """The parts of a kind's word in sentences, at the size of the object."""
    length, width, height = placed.size
    if kind.word == "building" and length > _LONGEST_BUILDING:
        count = math.ceil(length / _LONGEST_BUILDING)
        step = length / count
        along = (np.arange(count) + 0.5) * step - length / 2
        return [standing("box", (step - GAP, width, height), "building", x=x) for x in along.tolist()]
    if kind.word == "street-light":
        return street_light_parts(height)
    if kind.word in ("house", "truck"):  # a sentence knows no roofs, and one kind of lorry
        return [standing("box", placed.size, kind.labels[0])]
    return kind.coarse(placed)


def _settled(placed: PlacedObject, kind: SentenceKind, road: Road, rows: np.ndarray) -> tuple[float, float, float]:
    """x, y [m] and yaw [rad] of the object along the road, near the middle of a row if it stands in one."""
    if not (kind.is_vehicle or kind.is_square or kind.yaw_deviation):
        return placed.place
    along, across = road.along_across(placed.x, placed.y)
    heading = road.curvature * along
    turn = math.remainder(placed.yaw - heading, math.tau)
    square = round(turn / (math.pi / 2)) * math.pi / 2
    if kind.is_square:
        return placed.x, placed.y, heading + square
    if abs(turn - square) > _CROOKED:
        return placed.place
    turn = square + min(max(turn - square, -_MOST_YAW), _MOST_YAW)
    if kind.is_vehicle and round(square / (math.pi / 2)) % 2 == 0:
        row = rows[int(np.argmin(np.abs(rows - across)))]
        if abs(row - across) < _IN_LANE:
            across = min(max(across, row - LANE_OFFSET), row + LANE_OFFSET)
    x, y, heading = road.at(along, across)
    return x, y, heading + turn
