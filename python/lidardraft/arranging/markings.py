"""Road markings: lane and edge lines, stop lines, arrows, zebra crossings, the lines of parking bays.

Widths and patterns are those of the German guide to road markings (RMS-1): lines of 0.12 m (0.15 m on motorways) and
0.25 to 0.30 m, 3 m of line and 6 m of gap in towns, 4 and 8 m outside, 6 and 12 m on motorways, stop lines of 0.5 m.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from lidardraft.arranging.car_parks import BAY_LENGTH, BAY_WIDTH, CarPark
from lidardraft.arranging.district import CALM, FAST
from lidardraft.arranging.sizes import Range
from lidardraft.scene.road import SIDES, Road
from lidardraft.scene.street import MAIN_ROAD, SIDE_ROAD, Path

Span = tuple[float, float, float, float]  # from and to along, from and to across [m]


@dataclass(frozen=True, slots=True)
class Pattern:
    """The pattern of a road's lines: m of line and gap, widths [m] of lane lines and edge lines."""

    dash: float
    gap: float
    lane_line: float
    edge_line: float


@dataclass(frozen=True, slots=True)
class Line:
    """A line along the road: `across` and `width`, and m of line and gap; solid with a gap of 0."""

    across: float
    width: float
    dash: float = 0.0
    gap: float = 0.0


# RMS-1
_THIN = 0.12
TOWN = Pattern(3.0, 6.0, _THIN, _THIN)
COUNTRY = Pattern(4.0, 8.0, _THIN, _THIN)
_MOTORWAY = Pattern(6.0, 12.0, 0.15, 0.3)
_STOP_WIDTH = 0.5
_MEDIAN_LINE = 0.15

# Estimates.
_LINED = 0.15  # share of calm streets with lines
_FIRST_DASH = (0.0, 9.0)  # m from the end of the street
EDGE_OFF, _MEDIAN_OFF = 0.25, 0.35  # m from edge lines to the edge of the road, and to the median
_CLEAR_ROUNDABOUT = 4.5  # m before a roundabout without lines
_STOP_AHEAD = 0.75  # m from the waiting traffic to the middle of the line
_STOP_LENGTH, _STOP_SHARE = 2.4, 0.48  # m, within the narrowest lane; of the half width of a side road at most
_ZEBRAS, _ZEBRA_PLACE, _ZEBRA_JUNCTION = 0.3, 0.35, 6.0  # share, of the half length at most, m to a junction
_EDGED, _CROSSED = 0.5, 0.6  # share of town roads with edge lines, of junctions with zebras
# An arrow straight ahead: m from the stop line to its tip, and from and to along, half widths of its parts [m].
_ARROW_AHEAD, _ARROW_SHAFT, _ARROW_HEAD = 4.0, (1.6, 5.0, 0.08), ((0.0, 0.5, 0.1), (0.5, 1.1, 0.25), (1.1, 1.6, 0.4))
# VwV-StVO: bars of 0.5 m with gaps of 0.5 m, 3 m long and more.
_BAR, _BAR_SPACING, _BAR_LENGTH = 0.5, 1.0, 4.0
_ZEBRA_EDGES = (0.3, 0.5)  # m to the first bar from the right kerb, and without the start of a bar at the left kerb
_ZEBRA_MEDIAN = 0.3  # m from the middle of a bar to a median
_BAY_END, _BAY_SIDE, _BAY_GATE = 0.1, 0.1, 3.0  # m to the ends of bays and of the area, from the middle of the gate


def road_markings(
    road: Road,
    lanes: tuple[Path, ...],
    car_park: CarPark | None,
    speed: float,
    rng: np.random.Generator,
) -> np.ndarray:
    """Painted rectangles [n, 4] in the road's frame: from and to along, from and to across [m]; of zebras only those
    at junctions.

    `speed` [m/s] is the limit on the road.
    """
    spans: list[Span] = []
    more = rng.spawn(1)[0]  # its draws leave the rest of a street as it is
    # quiet streets have no lines
    if speed > CALM or road.lanes > 1 or rng.random() < _LINED:
        for line in _lines(road, lanes, speed):
            spans += _pieces(road, line, rng.uniform(*_FIRST_DASH))
        spans += [_stop_line(road, lane) for lane in lanes if lane.stop is not None]
        spans += [part for lane in lanes if lane.stop is not None and lane.kind == MAIN_ROAD for part in _arrow(lane)]
        if CALM < speed <= FAST and more.random() < _EDGED:
            edge = road.edge - (road.parking or EDGE_OFF)
            spans += [piece for side in SIDES for piece in _pieces(road, Line(side * edge, _THIN), 0.0)]
    if car_park is not None:
        rows = [across for across, _ in car_park.rows]
        spans += bay_lines(car_park.paved_area.along, rows, car_park.gate)
    if road.junction is not None and not road.roundabout_radius and road.sidewalk > 0 and more.random() < _CROSSED:
        off = (road.edge + road.verge) / 2
        spans += [bar for side in SIDES for bar in _zebra(road, road.junction + side * off)]
    return np.array(spans).reshape(-1, 4)


def sample_zebras(road: Road, speed: float, rng: np.random.Generator) -> tuple[float, ...]:
    """The places of zebras [m along] on a road with a limit `speed` [m/s]: one or none."""
    if road.sidewalk == 0 or speed <= CALM or rng.random() >= _ZEBRAS:
        return ()
    place = float(rng.uniform(-_ZEBRA_PLACE, _ZEBRA_PLACE) * road.half_length)
    return () if road.in_junction(place, _ZEBRA_JUNCTION) else (place,)


def zebras(road: Road, places: Iterable[float]) -> np.ndarray:
    """The bars of zebras at places [m along], as `road_markings`."""
    return np.array([bar for along in places for bar in _zebra(road, along)]).reshape(-1, 4)


def _lines(road: Road, lanes: tuple[Path, ...], speed: float) -> list[Line]:
    """Dashed lines between the lanes; on fast roads solid ones along the edges and the median."""
    pattern = TOWN if speed <= FAST else _MOTORWAY if road.median > 0 else COUNTRY
    offsets = sorted({lane.at(0.0)[1] for lane in lanes if lane.kind == MAIN_ROAD})
    lines = []
    for low, high in itertools.pairwise(offsets):
        in_median = low * high < 0 and road.median > 0
        if not in_median:
            lines.append(Line((low + high) / 2, pattern.lane_line, pattern.dash, pattern.gap))
    if speed > FAST:
        edge = road.edge - (road.parking or EDGE_OFF)
        lines += [Line(side * edge, pattern.edge_line) for side in SIDES]
        if road.median > 0:
            lines += [Line(side * (road.median / 2 + _MEDIAN_OFF), _MEDIAN_LINE) for side in SIDES]
    return lines


def _pieces(road: Road, line: Line, first: float) -> list[Span]:
    """A line from end to end, except in the junction; dashes begin `first` [m] from the end."""
    low, high, end = line.across - line.width / 2, line.across + line.width / 2, road.half_length
    gap = road.verge
    if road.roundabout_radius is not None:
        gap = road.roundabout_radius + road.sidewalk + _CLEAR_ROUNDABOUT
    if line.gap == 0.0:
        if road.junction is None:
            return [(-end, end, low, high)]
        return [(-end, road.junction - gap, low, high), (road.junction + gap, end, low, high)]
    starts = np.arange(-end + first, end - line.dash, line.dash + line.gap)
    if road.junction is not None:
        starts = starts[np.abs(starts + line.dash / 2 - road.junction) > gap + line.dash / 2]
    return [(start, start + line.dash, low, high) for start in starts.tolist()]


def _stop_line(road: Road, lane: Path) -> Span:
    assert lane.stop is not None
    along, across, _ = lane.at(lane.stop + _STOP_AHEAD)
    half, thick = _STOP_LENGTH / 2, _STOP_WIDTH / 2
    if lane.kind == SIDE_ROAD:
        half = min(half, _STOP_SHARE / 2 * road.edge)
        return along - half, along + half, across - thick, across + thick
    return along - thick, along + thick, across - half, across + half


def _arrow(lane: Path) -> list[Span]:
    """An arrow straight ahead, before the stop line of a lane."""
    assert lane.stop is not None
    parts = []
    for near, far, half in (*_ARROW_HEAD, _ARROW_SHAFT):
        ends = [lane.at(lane.stop - _ARROW_AHEAD - off)[:2] for off in (far, near)]
        (low, high), across = sorted(along for along, _ in ends), ends[0][1]
        parts.append((low, high, across - half, across + half))
    return parts


def _zebra(road: Road, along: float) -> list[Span]:
    """Bars from kerb to kerb."""
    bars = np.arange(-road.edge + _ZEBRA_EDGES[0], road.edge - _ZEBRA_EDGES[1], _BAR_SPACING).tolist()
    half = _BAR_LENGTH / 2
    off = road.median / 2 + _ZEBRA_MEDIAN
    return [(along - half, along + half, low, low + _BAR) for low in bars if abs(low + _BAR / 2) > off]


def bay_lines(span: Range, rows: Iterable[float], gate: float = math.inf) -> list[Span]:
    """The lines between bays over a `span` [m along], except at the `gate`; `rows` are the rows' middles across [m]."""
    spans = []
    start, end = span
    half = BAY_LENGTH / 2 - _BAY_END
    for across in rows:
        for number in range(int((end - start) / BAY_WIDTH) + 1):
            along = start + number * BAY_WIDTH
            if start + _BAY_SIDE < along < end - _BAY_SIDE and abs(along - gate) > _BAY_GATE:
                spans.append((along - _THIN / 2, along + _THIN / 2, across - half, across + half))
    return spans
