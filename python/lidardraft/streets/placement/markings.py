"""Road markings: lane and edge lines, stop lines, zebra crossings, the lines of parking bays.

Widths and patterns are those of the German guide to road markings (RMS-1): lines of 0.12 m (0.15 m on motorways) and
0.25 to 0.30 m, 3 m of line and 6 m of gap in towns, 4 and 8 m outside, 6 and 12 m on motorways, stop lines of 0.5 m.
"""

from __future__ import annotations

import itertools

import numpy as np

from lidardraft.scene.road import Road
from lidardraft.streets.placement.car_parks import BAY_LENGTH, BAY_WIDTH, CarPark
from lidardraft.streets.placement.lanes import Lane

_THIN = 0.12
_MOTORWAY = 25.0  # m/s, limits over this have the markings of motorways and country roads

Span = tuple[float, float, float, float]  # from and to along, from and to across [m]


def road_markings(
    road: Road, lanes: tuple[Lane, ...], car_park: CarPark | None, speed: float, rng: np.random.Generator
) -> np.ndarray:
    """Painted rectangles [n, 4] of the road's frame: from and to along, from and to across [m]."""
    spans: list[Span] = []
    fast = speed > _MOTORWAY
    # quiet streets have no lines
    if speed > 10.0 or rng.random() < 0.15:
        for across, dash, gap, width in _lines(road, lanes, fast):
            spans += _line(road, across, dash, gap, width, rng.uniform(0.0, 9.0))
        for lane in lanes:
            if lane.stop is not None:
                spans.append(_stop_line(road, lane))
    if car_park is not None:
        spans += _bays(car_park)
    if road.sidewalk > 0 and speed > 10.0 and rng.random() < 0.3:
        spans += _zebra(road, rng)
    return np.array(spans).reshape(-1, 4)


def _lines(road: Road, lanes: tuple[Lane, ...], fast: bool) -> list[tuple[float, float, float, float]]:
    """Across, dash, gap (0 for a solid line) and width of the lines along the road."""
    motorway = fast and road.median > 0
    dash, gap = (6.0, 12.0) if motorway else (4.0, 8.0) if fast else (3.0, 6.0)
    thin = 0.15 if motorway else _THIN
    offsets = sorted({lane.at(0.0)[1] for lane in lanes if lane.name == "road"})
    lines = []
    for low, high in itertools.pairwise(offsets):
        turned = low * high < 0 and road.median > 0
        if not turned:
            lines.append(((low + high) / 2, dash, gap, thin))
    if fast:
        wide = 0.3 if motorway else _THIN
        edge = road.edge - road.parking - (0.0 if road.parking else 0.25)
        lines += [(side * edge, 1.0, 0.0, wide) for side in (-1, 1)]
        if road.median > 0:
            lines += [(side * (road.median / 2 + 0.35), 1.0, 0.0, 0.15) for side in (-1, 1)]
    return lines


def _line(road: Road, across: float, dash: float, gap: float, width: float, first: float) -> list[Span]:
    """The dashes of a line from end to end, but for the junction."""
    low, high = across - width / 2, across + width / 2
    clear = (
        0.0
        if road.junction is None
        else (road.verge if road.roundabout_radius is None else road.roundabout_radius + road.sidewalk + 4.5)
    )
    if gap == 0.0:
        if road.junction is None:
            return [(-road.half_length, road.half_length, low, high)]
        return [
            (-road.half_length, road.junction - clear, low, high),
            (road.junction + clear, road.half_length, low, high),
        ]
    starts = np.arange(-road.half_length + first, road.half_length - dash, dash + gap).tolist()
    middle = 1e9 if road.junction is None else road.junction
    return [(s, s + dash, low, high) for s in starts if abs(s + dash / 2 - middle) > clear + dash / 2]


def _stop_line(road: Road, lane: Lane) -> Span:
    assert lane.stop is not None
    along, across, _ = lane.at(lane.stop + 0.75)
    half = 1.2  # within the narrowest lane
    if lane.name == "arm":
        half = min(half, 0.24 * road.edge)
        return along - half, along + half, across - 0.25, across + 0.25
    return along - 0.25, along + 0.25, across - half, across + half


def _zebra(road: Road, rng: np.random.Generator) -> list[Span]:
    """Bars of 0.5 m with gaps of 0.5 m, 4 m long (VwV-StVO: 3 m and more), from kerb to kerb."""
    along = rng.uniform(-0.35, 0.35) * road.half_length
    if road.in_junction(along, 6.0):
        return []
    bars = np.arange(-road.edge + 0.3, road.edge - 0.5, 1.0).tolist()
    return [(along - 2.0, along + 2.0, low, low + 0.5) for low in bars if abs(low + 0.25) > road.median / 2 + 0.3]


def _bays(car_park: CarPark) -> list[Span]:
    spans = []
    count = int((car_park.paved_area.along[1] - car_park.paved_area.along[0]) / BAY_WIDTH)
    half = BAY_LENGTH / 2 - 0.1
    for across, _ in car_park.rows:
        for number in range(count + 1):
            along = car_park.paved_area.along[0] + number * BAY_WIDTH
            if (
                car_park.paved_area.along[0] + 0.1 < along < car_park.paved_area.along[1] - 0.1
                and abs(along - car_park.gate) > 3.0
            ):
                spans.append((along - _THIN / 2, along + _THIN / 2, across - half, across + half))
    return spans
