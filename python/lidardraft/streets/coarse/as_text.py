"""Things as a sentence has them: the nearest to the real ones that the solver of sentences could have placed."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from lidardraft.objects.coarse_shapes import CoarseShape, box_of
from lidardraft.objects.kinds import Alignment, Kind, kind_of
from lidardraft.objects.placed_object import PlacedObject
from lidardraft.scene.road import Road
from lidardraft.streets.placement.district import PARKING_STRIP

_Size = tuple[float, float, float]

# Smallest and largest extents that `drafting.things` makes of each word [m]; strips are as long as they are.
_ANY = math.inf
RANGES: dict[str, tuple[_Size, _Size]] = {
    "car": ((3.78, 1.728, 1.38), (4.62, 1.872, 1.62)),
    "van": ((4.77, 1.92, 2.024), (5.83, 2.08, 2.376)),
    "truck": ((8.1, 2.4, 3.036), (9.9, 2.6, 3.564)),
    "bus": ((10.8, 2.448, 2.852), (13.2, 2.652, 3.348)),
    "tram": ((25.2, 2.544, 3.312), (30.8, 2.756, 3.888)),
    "motorcycle": ((1.932, 0.72, 1.222), (2.268, 0.88, 1.378)),
    "bicycle": ((1.656, 0.54, 1.034), (1.944, 0.66, 1.166)),
    "person": ((0.4, 0.45, 1.5), (0.8, 0.65, 1.9)),
    "house": ((8.0, 7.0, 5.0), (13.0, 10.0, 8.5)),
    "building": ((12.0, 10.0, 9.0), (22.0, 14.0, 20.0)),
    "tree": ((2.8, 2.8, 5.0), (5.0, 5.0, 10.0)),
    "bush": ((0.8, 0.8, 0.7), (2.2, 2.2, 1.8)),
    "hedge": ((0.0, 0.6, 0.9), (_ANY, 1.2, 2.0)),
    "fence": ((0.0, 0.06, 0.9), (_ANY, 0.15, 1.8)),
    "wall": ((0.0, 0.2, 1.5), (_ANY, 0.4, 3.0)),
    "pole": ((0.1, 0.1, 2.5), (0.2, 0.2, 5.0)),
    "street-light": ((0.18, 0.18, 6.0), (0.18, 0.18, 8.5)),
    "traffic-sign": ((0.0, 0.6, 2.0), (_ANY, 0.9, 2.6)),
    "bin": ((0.5, 0.5, 0.9), (0.8, 0.7, 1.2)),
    "bench": ((1.4, 0.5, 0.75), (1.9, 0.6, 0.9)),
}
_CLEAR = (1.6, 2.4)  # m under a crown
_GIRTH = (0.25, 0.5)  # m, a trunk
# What the solver cannot come nearer to than this it cannot mean: a drawing that is further off than a quarter would
# only teach that drawings lie.
_FURTHEST, _CLOSE = 0.25, 0.12  # of the size; m, which is as good as nothing
_ONE_BOX = {"house": "building", "truck": "truck"}  # a sentence knows no roofs, and one kind of lorry
_DRIFT = 0.15  # m that the solver leaves the middle of a lane by
_VEER = 0.03  # rad, three deviations of the solver's headings


def as_text(
    objects: Iterable[PlacedObject], road: Road, middles: Sequence[float]
) -> list[tuple[int, CoarseShape, tuple[float, float, float]]]:
    """What a sentence would draw of each thing: its index, a shape of it, and the place (x, y, yaw) it has that from.

    `middles` are those of the lanes across the road [m]. A block longer than the solver's is several side by side.
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
        place = _settled(standard, kind.alignment, road, rows)
        coarse += [(index, shape, place) for shape in _shapes(standard, kind)]
    return coarse


def _resized(placed: PlacedObject, kind: Kind) -> PlacedObject:
    """The object in the nearest size that its word has in `RANGES`; who rides keeps the size of both."""
    if kind.word not in RANGES or kind.instances > 1:
        return placed
    size = np.array(placed.size)
    if kind.word == "house":
        size[2] = (placed.clearance + size[2]) / 2
    most = np.maximum(_FURTHEST * size, _CLOSE)
    nearest = np.clip(np.clip(size, *RANGES[kind.word]), size - most, size + most)
    length, width, height = nearest.tolist()
    if kind.word == "tree":
        clearance = min(max(placed.clearance, _CLEAR[0]), _CLEAR[1], 0.6 * height)
        return replace(placed, size=((length + width) / 2, (length + width) / 2, height), clearance=clearance)
    if kind.word == "bush":
        return replace(placed, size=((length + width) / 2, (length + width) / 2, height))
    return replace(placed, size=(length, width, height))


def _shapes(placed: PlacedObject, kind: Kind) -> list[CoarseShape]:
    """What `drafting.things` draws by the word of a kind, at the size of the object."""
    length, width, height = placed.size
    if kind.word == "tree":
        girth = float(np.clip(0.05 * height, *_GIRTH))
        top = placed.clearance + 0.25 * (height - placed.clearance)
        crown = height - placed.clearance
        return [
            CoarseShape("cylinder", (0.0, 0.0, top / 2), (girth, girth, top), "trunk"),
            CoarseShape("ellipsoid", (0.0, 0.0, placed.clearance + crown / 2), (length, width, crown), "vegetation"),
        ]
    if kind.word == "building" and length > RANGES["building"][1][0]:
        count = math.ceil(length / RANGES["building"][1][0])
        step = length / count
        along = (np.arange(count) + 0.5) * step - length / 2
        return [
            CoarseShape("box", (float(x), 0.0, height / 2), (step - 0.25, width, height), "building") for x in along
        ]
    if kind.word == "traffic-sign":
        plate = CoarseShape("box", (-0.08, 0.0, height - width / 2), (0.05, width, width), "traffic-sign")
        return [CoarseShape("cylinder", (0.0, 0.0, height / 2), (0.08, 0.08, height), "pole"), plate]
    if kind.word == "traffic-light" and width <= 1.0:  # wider ones hang from an arm
        light = CoarseShape("box", (0.0, 0.0, placed.clearance + 0.45), (0.35, 0.35, 0.9), "traffic-light")
        return [
            CoarseShape("cylinder", (0.0, 0.0, placed.clearance / 2), (0.15, 0.15, placed.clearance), "pole"),
            light,
        ]
    if kind.word == "street-light":
        arm = CoarseShape("box", (0.0, -0.5, height), (0.3, 1.2, 0.15), "pole")
        return [CoarseShape("cylinder", (0.0, 0.0, height / 2), (0.18, 0.18, height), "pole"), arm]
    if kind.word in _ONE_BOX:
        return box_of(_ONE_BOX[kind.word])(placed)
    return kind.coarse(placed)


def _settled(placed: PlacedObject, alignment: Alignment, road: Road, rows: np.ndarray) -> tuple[float, float, float]:
    """x, y [m] and yaw [rad] of the thing along the road, near the middle of a row if it stands in one."""
    if alignment is Alignment.FREE:
        return placed.x, placed.y, placed.yaw
    along, across = _along_across(road, placed.x, placed.y)
    heading = road.curvature * along
    turn = math.remainder(placed.yaw - heading, math.tau)
    district = round(turn / (math.pi / 2)) * math.pi / 2
    if alignment is Alignment.SQUARE:
        return placed.x, placed.y, heading + district
    if abs(turn - district) > 0.2:
        return placed.x, placed.y, placed.yaw
    turn = district + float(np.clip(turn - district, -_VEER, _VEER))
    if alignment is Alignment.LANE and round(district / (math.pi / 2)) % 2 == 0:
        row = rows[int(np.argmin(np.abs(rows - across)))]
        if abs(row - across) < 0.5:
            across = float(np.clip(across, row - _DRIFT, row + _DRIFT))
    x, y, heading = road.at(along, across)
    return x, y, heading + turn


def _along_across(road: Road, x: float, y: float) -> tuple[float, float]:
    """The inverse of `Road.at`."""
    ego, bend = road.lane(road.ego_lane), road.curvature
    if abs(bend) < 1e-9:
        return x, y + ego
    sign = math.copysign(1.0, bend)
    inward = 1.0 / bend - (y + ego)
    return math.atan2(sign * x, sign * inward) / bend, 1.0 / bend - sign * math.hypot(x, inward)
