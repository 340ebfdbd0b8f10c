"""Things as a sentence has them: the nearest to the real ones that the solver of sentences could have placed."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from lidardraft.scene.road import Road
from lidardraft.streets.outline import Mark, outline
from lidardraft.streets.quarter import BAY
from lidardraft.streets.style import UNSPOKEN
from lidardraft.streets.thing import Thing
from lidardraft.streets.vehicles import BODIES

_Size = tuple[float, float, float]

# Smallest and largest extents that `drafting.things` makes [m]; strips are as long as they are.
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
    "block": ((12.0, 10.0, 9.0), (22.0, 14.0, 20.0)),
    "tree": ((2.8, 2.8, 5.0), (5.0, 5.0, 10.0)),
    "bush": ((0.8, 0.8, 0.7), (2.2, 2.2, 1.8)),
    "hedge": ((0.0, 0.6, 0.9), (_ANY, 1.2, 2.0)),
    "fence": ((0.0, 0.06, 0.9), (_ANY, 0.15, 1.8)),
    "garden_wall": ((0.0, 0.2, 1.5), (_ANY, 0.4, 3.0)),
    "pole": ((0.1, 0.1, 2.5), (0.2, 0.2, 5.0)),
    "lamp": ((0.18, 0.18, 6.0), (0.18, 0.18, 8.5)),
    "sign": ((0.0, 0.6, 2.0), (_ANY, 0.9, 2.6)),
    "bin": ((0.5, 0.5, 0.9), (0.8, 0.7, 1.2)),
    "bench": ((1.4, 0.5, 0.75), (1.9, 0.6, 0.9)),
}
_RANGE_OF = {
    **{body: "van" if body == "van" else "car" for body in BODIES},
    "trailer_truck": "truck",
    "mesh_fence": "fence",
    "barrier": "fence",
    "wall": "garden_wall",
}
_CLEAR = (1.6, 2.4)  # m under a crown
_GIRTH = (0.25, 0.5)  # m, a trunk
# What the solver cannot come nearer to than this it cannot mean: a drawing that is further off than a quarter would
# only teach that drawings lie.
_FURTHEST, _CLOSE = 0.25, 0.12  # of the size; m, which is as good as nothing
_DRIFT = 0.15  # m that the solver leaves the middle of a lane by
_VEER = 0.03  # rad, three deviations of the solver's headings
_SQUARE = ("sign", "traffic_light", "bin", "bench")  # looks up the road or across it
_ALONG = (*BODIES, "truck", "trailer_truck", "bus", "tram", "motorcycle", "motorcyclist", "house", "block", *_SQUARE)


def spoken(
    things: Iterable[Thing], road: Road, middles: Sequence[float]
) -> list[tuple[int, Mark, tuple[float, float, float]]]:
    """What a sentence would draw of each thing: its index, a shape of it, and the place (x, y, yaw) it has that from.

    `middles` are those of the lanes across the road [m]. A block longer than the solver's is several side by side.
    """
    rows = np.unique(np.concatenate([np.asarray(middles, dtype=float), (road.edge - BAY / 2) * np.array([-1.0, 1.0])]))
    drawn = []
    for index, thing in enumerate(things):
        if thing.kind in UNSPOKEN or thing.kind == "shed":
            continue
        standard = _resized(thing)
        place = _settled(standard, road, rows) if thing.kind in _ALONG else (thing.x, thing.y, thing.yaw)
        drawn += [(index, mark, place) for mark in _marks(standard)]
    return drawn


def _resized(thing: Thing) -> Thing:
    """The thing in the nearest size that its kind has in `RANGES`."""
    kind = _RANGE_OF.get(thing.kind, thing.kind)
    if kind not in RANGES:
        return thing
    size = np.array(thing.size)
    if kind == "house":
        size[2] = (thing.stem + size[2]) / 2
    most = np.maximum(_FURTHEST * size, _CLOSE)
    nearest = np.clip(np.clip(size, *RANGES[kind]), size - most, size + most)
    length, width, height = nearest.tolist()
    if kind == "tree":
        stem = min(max(thing.stem, _CLEAR[0]), _CLEAR[1], 0.6 * height)
        return replace(thing, size=((length + width) / 2, (length + width) / 2, height), stem=stem)
    if kind == "bush":
        return replace(thing, size=((length + width) / 2, (length + width) / 2, height))
    if kind == "house":
        return replace(thing, kind="shed", size=(length, width, height))
    # a sentence knows one kind of lorry
    return replace(thing, kind="truck" if kind == "truck" else thing.kind, size=(length, width, height))


def _marks(thing: Thing) -> list[Mark]:
    length, width, height = thing.size
    if thing.kind == "tree":
        girth = float(np.clip(0.05 * height, *_GIRTH))
        top = thing.stem + 0.25 * (height - thing.stem)
        crown = height - thing.stem
        return [
            Mark("cylinder", (0.0, 0.0, top / 2), (girth, girth, top), "trunk"),
            Mark("ellipsoid", (0.0, 0.0, thing.stem + crown / 2), (length, width, crown), "vegetation"),
        ]
    if thing.kind == "block" and length > RANGES["block"][1][0]:
        count = math.ceil(length / RANGES["block"][1][0])
        step = length / count
        along = (np.arange(count) + 0.5) * step - length / 2
        return [Mark("box", (float(x), 0.0, height / 2), (step - 0.25, width, height), "building") for x in along]
    if thing.kind == "sign":
        plate = Mark("box", (-0.08, 0.0, height - width / 2), (0.05, width, width), "traffic-sign")
        return [Mark("cylinder", (0.0, 0.0, height / 2), (0.08, 0.08, height), "pole"), plate]
    if thing.kind == "traffic_light" and width <= 1.0:  # wider ones hang from an arm
        light = Mark("box", (0.0, 0.0, thing.stem + 0.45), (0.35, 0.35, 0.9), "traffic-light")
        return [Mark("cylinder", (0.0, 0.0, thing.stem / 2), (0.15, 0.15, thing.stem), "pole"), light]
    if thing.kind == "lamp":
        arm = Mark("box", (0.0, -0.5, height), (0.3, 1.2, 0.15), "pole")
        return [Mark("cylinder", (0.0, 0.0, height / 2), (0.18, 0.18, height), "pole"), arm]
    return [mark for mark in outline(thing) if mark.lobes < 2]


def _settled(thing: Thing, road: Road, rows: np.ndarray) -> tuple[float, float, float]:
    """x, y [m] and yaw [rad] of the thing along the road, near the middle of a row if it stands in one."""
    along, across = _along_across(road, thing.x, thing.y)
    heading = road.curvature * along
    turn = math.remainder(thing.yaw - heading, math.tau)
    quarter = round(turn / (math.pi / 2)) * math.pi / 2
    if thing.kind in _SQUARE:
        return thing.x, thing.y, heading + quarter
    if abs(turn - quarter) > 0.2:
        return thing.x, thing.y, thing.yaw
    turn = quarter + float(np.clip(turn - quarter, -_VEER, _VEER))
    if thing.kind not in ("shed", "block") and round(quarter / (math.pi / 2)) % 2 == 0:
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
