"""A street: the road under the ego vehicle, as a frame to be filled, and the lanes that follow from it.

**The** lanes of a road are made here, for placed traffic, markings, drivers and planners alike.
"""

from __future__ import annotations

import itertools
import math
from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from lidardraft.errors import LayoutError, check_that
from lidardraft.scene.lane import Crossing, Junction, Lane, Pavement, Signal
from lidardraft.scene.line import Line
from lidardraft.scene.pose import Place, in_frame, rotation
from lidardraft.scene.road import KERB_HEIGHT, LEFT, PARKING_STRIP, RIGHT, RING, SIDES, TERRAIN_HEIGHT, Road

# Limits [m/s] of the German road code (StVO).
TOWN_SPEED = 50 / 3.6
_ROUNDABOUT_SPEED = 30 / 3.6  # the usual speed
_CAR_PARK_SPEED = 10 / 3.6  # walking speed
_ON_FOOT = 5 / 3.6
# Estimates [m].
_STOP = 1.5  # from the stop line at a light to the crossing road
_GIVES_WAY = 2.0  # from the line of traffic that gives way
_AISLE_END = 2.5  # at either end of an aisle, without traffic
_AISLE_OFF = 1.4  # from the middle of an aisle to that of each way
_JUNCTION_GAP = 2.0  # between the lane of a roundabout, or the road, and the lanes that lead to it
_ZEBRA = 4.0  # along the road
_CORNER = 1.0  # from the crossing road to the start and end of turns
_SHORTEST = 12.0  # a piece of the road before or behind a roundabout
_TWO_LANES = 6.0  # m, the least width of a one-way street with two lanes
_FOUR_LANES = 6.5  # m, the least half width of a side road with two lanes each way
_ONE_EACH_WAY, _TWO_EACH_WAY = (0.5,), (0.75, 0.25)  # middles of lanes in shares of the half width
_STATION, _RING_STATION = 2.0, 1.0  # between the points of a bent lane, and of a roundabout
_RELIEF, _SAME = 4.0, 0.05  # between the points of a lane with relief; and a distance that counts as none
_QUARTER = np.linspace(0.0, math.pi / 2, 17)
_WIDE = 1.5  # turns to the right, and in and out of a roundabout, are wider by this factor: a corner is beside them
_INTO_RING = 0.35  # rad on the ring beyond the lane by which traffic enters, and before the one by which it leaves
MAIN_ROAD, SIDE_ROAD, ROUNDABOUT, AISLE = "main", "side", "ring", "aisle"  # kinds of paths


@dataclass(frozen=True, slots=True)
class Path:
    """A path for placed traffic: it starts at (`along`, `across`) [m] of the road's frame, at `angle` [rad] to the
    road, bent to the left by `bend` [1/m] in that frame. `speed` [m/s] is the limit. `stop` is the distance from the
    start to the stop line at a light, or None. `number` counts the paths of its `way` from the outermost.
    """

    kind: str
    way: str
    along: float
    across: float
    angle: float
    length: float
    speed: float
    number: int = 0
    width: float = RING / 2
    bend: float = 0.0
    stop: float | None = None

    @property
    def outer(self) -> bool:
        """Whether it is the outermost path of its direction."""
        return self.number == 0

    def at(self, distance: float, left: float = 0.0) -> tuple[float, float, float]:
        """Along, across [m] and angle [rad] at a `distance` [m] from the start, `left` [m] of the middle."""
        angle = self.angle + self.bend * distance
        if self.bend == 0.0:
            along = self.along + distance * math.cos(angle)
            across = self.across + distance * math.sin(angle)
        else:
            along = self.along + (math.sin(angle) - math.sin(self.angle)) / self.bend
            across = self.across - (math.cos(angle) - math.cos(self.angle)) / self.bend
        return along - left * math.sin(angle), across + left * math.cos(angle), angle


class _Offset(NamedTuple):
    """Across [m], direction, number from the outermost, and width [m] of a lane of the road itself."""

    across: float
    direction: int
    number: int
    width: float


@dataclass(frozen=True, kw_only=True, slots=True)
class StreetFrame:
    """The road under the ego vehicle, with all that is needed to fill it as a street.

    The frame of the `road` is at `place` in the layout; the land around it is `plain` [m] high. `lacks` are its
    surfaces that the layout does not show: "sidewalk", "terrain", or with "road" all but those in the picture. Of a
    drawn road, `paved` is the other pavement, and `ends` how far [m] along it is drawn.

    `speed` [m/s] is its limit, None that of its surroundings. `parked` are the sides (`LEFT`, `RIGHT`) with cars parked
    in the outermost of several lanes or beside the only one; None if the lanes are those of `road`. With `one_way` all
    the room between them leads in the ego's direction. `aisles` are those of its car park: middle across, and from and
    to along [m]. `lights` is whether the junction has traffic lights, `zebras` are the places [m along] of crossings
    for people. `relief` holds, for each of its lanes and then of its ways, the height [m] and the slope to the left at
    even distances; empty on level ground.
    """

    road: Road
    place: Place = (0.0, 0.0, 0.0)
    plain: float = TERRAIN_HEIGHT
    lacks: tuple[str, ...] = ()
    paved: tuple[Pavement, ...] = ()
    ends: tuple[float, float] | None = None
    speed: float | None = None
    parked: tuple[int, ...] | None = None
    one_way: bool = False
    aisles: tuple[tuple[float, float, float], ...] = ()
    lights: bool = False
    zebras: tuple[float, ...] = ()
    relief: tuple[tuple[tuple[float, float], ...], ...] = ()

    def __post_init__(self) -> None:
        check_that(self.speed is None or self.speed > 0.0, "street: speed", self.speed, "over 0 m/s, or null")
        check_that(set(self.parked or ()) <= set(SIDES), "street: parked", self.parked, "of 1 (left) and -1 (right)")
        check_that(self.ends is None or self.ends[0] < self.ends[1], "street: ends", self.ends, "from less to more")

    def crossings(self) -> tuple[Crossing, ...]:
        """The zebras, in the frame of the layout."""
        own = [in_frame(self.road.at(along, 0.0), self.place) for along in self.zebras]
        size = (_ZEBRA, 2 * self.road.edge)
        return tuple(Crossing(id=f"zebra_{number}", place=place, size=size) for number, place in enumerate(own))

    def over(self, height: Callable[[np.ndarray], np.ndarray]) -> StreetFrame:
        """The street on ground with `height` f64 [N] at points [N, 2] of the layout's frame."""
        flat = replace(self, relief=())
        lines = [lane.line for lane in (*flat.lanes()[0], *flat.ways())]
        lines = [Line.through(line.spaced(max(len(line.along), 2 + int(line.length / _RELIEF)))) for line in lines]
        sides = [np.concatenate([line.middle + off * line.normals for line in lines]) for off in (0.5, -0.5)]
        left, right = height(np.concatenate(sides)).reshape(2, -1)
        rows = map(tuple, np.column_stack([(left + right) / 2, left - right]).round(4).tolist())
        return replace(self, relief=tuple(tuple(itertools.islice(rows, len(line.along))) for line in lines))

    def limit(self) -> float:
        """The speed [m/s] of its traffic; that of towns if none is known."""
        return TOWN_SPEED if self.speed is None else self.speed

    def _offsets(self) -> list[_Offset]:
        """The lanes of the road itself. Parked cars take the outermost of several, or a strip beside the only one."""
        road, parked = self.road, self.parked or ()
        strip = road.parking or PARKING_STRIP
        right = road.edge - (strip if RIGHT in parked or road.parking else 0.0)
        left = road.edge - (strip if LEFT in parked or road.parking else 0.0)
        if self.one_way:
            # all the room between the parked cars: one lane, or two if it is wide enough
            middle, width = (left - right) / 2, left + right
            if width < _TWO_LANES:
                return [_Offset(middle, 1, 0, width)]
            return [_Offset(middle - width / 4, 1, 0, width / 2), _Offset(middle + width / 4, 1, 1, width / 2)]
        if self.parked is not None and road.lanes == road.oncoming == 1 and not road.median:
            middle, width = (left - right) / 2, (left + right) / 2
            return [_Offset((middle - right) / 2, 1, 0, width), _Offset((middle + left) / 2, -1, 0, width)]
        offsets = []
        for direction, lanes in ((1, road.lanes), (-1, road.oncoming)):
            first = 1 if -direction in parked and lanes > 1 else 0
            offsets += [
                _Offset(road.lane(number, direction), direction, number - first, road.lane_width)
                for number in range(first, lanes)
            ]
        return offsets

    def side_offsets(self) -> list[float]:
        """The distances [m] of a side road's lanes from its middle, either way, from the outermost on."""
        if self.parked is None:
            return [-self.road.lane(number) for number in range(self.road.lanes)]
        shares = _ONE_EACH_WAY if self.road.edge < _FOUR_LANES else _TWO_EACH_WAY
        return [self.road.edge * share for share in shares]

    @property
    def gap(self) -> float:
        """The distance [m] from the middle of the junction to the ends of the lanes that lead to it."""
        radius = self.road.roundabout_radius
        return (self.road.edge if radius is None else radius) + _JUNCTION_GAP

    def _main_paths(self) -> Iterator[Path]:
        """Along the whole road, in two pieces if a roundabout divides it."""
        road, gap = self.road, self.gap
        for across, direction, number, width in self._offsets():
            start, length = -direction * road.half_length, 2 * road.half_length
            way, angle = ("with", 0.0) if direction > 0 else ("against", math.pi)
            whole = Path(MAIN_ROAD, way, start, across, angle, length, self.limit(), number, width)
            if road.junction is None:
                yield whole
                continue
            to_junction = direction * (road.junction - start)
            if road.roundabout_radius is None:
                yield replace(whole, stop=to_junction - road.verge - _STOP if self.lights else None)
                continue
            pieces = ((start, to_junction - gap), (road.junction + direction * gap, length - to_junction - gap))
            yield from (replace(whole, along=begin, length=piece) for begin, piece in pieces if piece > _SHORTEST)

    def _side_paths(self) -> Iterator[Path]:
        """The paths of each side road; right-hand traffic: outwards on the right as seen from the junction."""
        road, near = self.road, self.gap
        length, speed = road.half_length - near, min(self.limit(), TOWN_SPEED)
        stop = length - (road.verge - road.edge) - _STOP if self.lights and road.roundabout_radius is None else None
        if road.junction is None:
            return
        for side in road.side_roads:
            leg, angle, end = "left" if side == LEFT else "right", side * math.pi / 2, side * road.half_length
            for number, offset in enumerate(self.side_offsets()):
                width = road.lane_width if self.parked is None else road.edge / len(self.side_offsets())
                on, rest = side * offset, (length, speed, number, width)
                yield Path(SIDE_ROAD, f"{leg}.out", road.junction + on, side * near, angle, *rest)
                yield Path(SIDE_ROAD, f"{leg}.in", road.junction - on, end, -angle, *rest, stop=stop)

    def _ring(self) -> Iterator[Path]:
        """Once around a roundabout, counter-clockwise."""
        if self.road.roundabout_radius is not None and self.road.junction is not None:
            radius = self.road.roundabout_radius - RING / 2
            start = (self.road.junction + radius, 0.0, math.pi / 2)
            yield Path(ROUNDABOUT, "ring", *start, 2 * math.pi * radius, _ROUNDABOUT_SPEED, bend=1 / radius)

    def _aisles(self) -> Iterator[Path]:
        """One path each way in each aisle."""
        for number, (across, first, last) in enumerate(self.aisles):
            rest = (last - first - 2 * _AISLE_END, _CAR_PARK_SPEED)
            yield Path(AISLE, f"aisle_{number}.with", first + _AISLE_END, across - _AISLE_OFF, 0.0, *rest)
            yield Path(AISLE, f"aisle_{number}.against", last - _AISLE_END, across + _AISLE_OFF, math.pi, *rest)

    def ways(self) -> tuple[Lane, ...]:
        """The paths that drivers follow, in the frame of the layout: along the road and its side roads and over each
        turn from it. If cars are placed there, also around a roundabout and along aisles."""
        paths = () if self.parked is None else (*self._ring(), *self._aisles())
        crossed = None if self.road.roundabout_radius else self.road.junction
        crossing = () if crossed is None else (*self._side_ways(), *self._turning_ways(crossed))
        rows = [*self._through(), *crossing, *map(self._along_path, paths)]
        usual = {"width": self.road.lane_width, "speed": self.limit()}
        return tuple(
            Lane(id=f"way_{number}", line=self.line(points, number - len(rows)), **(usual | more))
            for number, (points, more) in enumerate(rows)
        )

    def line(self, points: np.ndarray, number: int) -> Line:
        """The line in the layout's frame through points [S, 2] of the road's frame, with the relief of that
        `number`."""
        x, y, yaw = self.place
        line = Line.through(points @ rotation(yaw) + (x, y))
        if not self.relief:
            return line
        if not -len(self.relief) <= number < len(self.relief):
            raise LayoutError(f"street: relief is of {len(self.relief)} lines; it must be of all lanes and ways")
        stations, rows = np.linspace(0.0, line.length, len(self.relief[number])), np.array(self.relief[number])
        bends = line.along[np.abs(line.along[:, None] - stations).min(axis=1) > _SAME]  # stations would cut these
        along = np.sort(np.concatenate([stations, bends]))
        heights, camber = (np.interp(along, stations, row) for row in rows.T)
        return Line.through(np.column_stack([line.at(along), heights]), camber)

    def pieces(self, gap: float | None) -> list[tuple[float, float]]:
        """From and to along the road [m]: all of it, or the pieces `gap` [m] or more from the middle of the
        junction."""
        low, high = self.ends or (-self.road.half_length, self.road.half_length)
        junction = self.road.junction
        pieces = [(low, high)] if gap is None or junction is None else [(low, junction - gap), (junction + gap, high)]
        return [(low, high) for low, high in pieces if high - low > _STATION]

    def along(self, across: float, low: float, high: float, direction: int) -> np.ndarray:
        """Points [S, 2] of the road's frame between two places along the road."""
        stations = np.linspace(low, high, 2 if not self.road.curvature else max(2, math.ceil((high - low) / _STATION)))
        return self.road.points(stations[::direction], np.array(across))

    def crossed(self) -> tuple[np.ndarray, np.ndarray]:
        """The middle of the junction [2] and the directions [2, 2] ahead and left there, in the road's frame."""
        assert self.road.junction is not None
        x, y, heading = self.road.at(self.road.junction, 0.0)
        return np.array([x, y]), rotation(heading)

    def _through(self) -> Iterator[_Points]:
        """Along the road; a roundabout ends the ways."""
        gap = None if self.road.roundabout_radius is None else self.gap
        for across, direction, _, width in self._offsets():
            for low, high in self.pieces(gap):
                ends = gap is not None and (high < (self.road.junction or 0.0)) == (direction > 0)
                yield self.along(across, low, high, direction), {"width": width, "closed": ends}

    def _side_ways(self) -> Iterator[_Points]:
        """Along the crossing road, whose traffic waits before the junction."""
        road = self.road
        middle, (ahead, left) = self.crossed()
        for direction, begins, goes_on in ((1, RIGHT, LEFT), (-1, LEFT, RIGHT)):
            start = road.half_length if begins in road.side_roads else road.edge
            end = road.half_length if goes_on in road.side_roads else road.edge
            across = direction * np.array([-start, end])
            stop = start - road.verge - _GIVES_WAY if begins in road.side_roads else None
            known = {"stop": stop, "closed": goes_on not in road.side_roads}
            for off in self.side_offsets():
                yield middle + direction * off * ahead + across[:, None] * left, known

    def _turning_ways(self, junction: float) -> Iterator[_Points]:
        """From each lane of the road over a quarter of an ellipse into the outer lane of the crossing road."""
        road = self.road
        middle, axes = self.crossed()
        far, outer = road.edge + _CORNER, self.side_offsets()[0]
        low, high = self.ends or (-road.half_length, road.half_length)
        for across, way, _, width in self._offsets():
            begin, own = low if way > 0 else high, way * across
            stations = np.linspace(begin, junction - way * far, max(2, math.ceil(road.half_length / _STATION)))[:-1]
            for turn, side in (("left", LEFT), ("right", RIGHT)):
                if side * way not in road.side_roads:
                    continue
                # forward and left relative to the driver
                forward = -far + (side * outer + far) * np.sin(_QUARTER)
                left = own + (side * far - own) * (1.0 - np.cos(_QUARTER))
                on = np.array([[side * outer, side * road.half_length]])
                bend = middle + way * np.concatenate([np.column_stack([forward, left]), on]) @ axes
                points = np.concatenate([road.points(stations, np.array(across)), bend])
                along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
                bends = float(along[len(stations)]), float(along[-2])
                yield points, {"turn": turn, "bend": bends, "width": width}

    def _along_path(self, path: Path) -> _Points:
        """Around a roundabout, or straight on; side roads of a bend are straight too."""
        steps = np.linspace(0.0, path.length, math.ceil(path.length / _STATION) if path.bend else 2)
        places = np.array([path.at(step)[:2] for step in steps.tolist()])
        more = {"kind": "aisle" if path.kind == AISLE else "driving", "width": path.width, "speed": path.speed}
        if path.kind in (AISLE, ROUNDABOUT):
            more["closed"] = True
        if path.kind == SIDE_ROAD and self.road.junction is not None:
            middle, axes = self.crossed()
            return middle + (places - (self.road.junction, 0.0)) @ axes, more
        return self.road.points(places[:, 0], places[:, 1]), more

    def lanes(self) -> tuple[tuple[Lane, ...], tuple[Junction, ...], tuple[Signal, ...]]:
        """Its lanes in the frame of the layout, those through its junction, and the lights there."""
        made = _Lanes(self)
        lanes = [made.lane(id, number) for number, id in enumerate(made.points)]
        through = tuple(lane.id for lane in lanes if lane.junction is not None)
        junctions = (Junction(id="junction", lanes=through),) if through else ()
        return tuple(lanes), junctions, tuple(made.signals())


_Points = tuple[np.ndarray, dict[str, Any]]  # the middle of a lane [S, 2], and other fields known of it


def paths_of(street: StreetFrame) -> tuple[Path, ...]:
    """The paths of placed traffic: along the road, its side roads, its roundabout and its car park.

    Side roads of a bend would widen in its frame, so they have none.
    """
    side_roads = () if street.road.curvature else street._side_paths()
    return (*street._main_paths(), *side_roads, *street._ring(), *street._aisles())


class _Lanes:
    """The lanes of a street under construction: `points` [S, 2] of the road's frame, and the other known fields of
    each; the `entries` and `exits` of the junction on each of its legs, from the outermost on."""

    def __init__(self, street: StreetFrame) -> None:
        self.street, self.road = street, street.road
        self.points: dict[str, np.ndarray] = {}
        self.known: dict[str, dict[str, Any]] = {}
        self.entries, self.exits = defaultdict[str, list[str]](list), defaultdict[str, list[str]](list)
        for path in street._main_paths():
            self._main(path)
        for path in (*street._side_paths(), *street._aisles()):
            points, more = street._along_path(path)
            leg, _, way = path.way.partition(".")
            if path.kind == SIDE_ROAD:
                (self.entries if way == "in" else self.exits)[leg].append(self._add(path, "", points, **more))
            else:
                self._add(path, "", points, **more)
        for beside in self.known.values():
            beside |= {side: id for side, id in beside.pop("beside").items() if id in self.known}
        self._turns() if self.road.roundabout_radius is None else self._around(self.road.roundabout_radius - RING / 2)
        self._beside()

    def lane(self, id: str, number: int) -> Lane:
        """The lane of an id; `number` is its place in the order of creation."""
        line, known = self.street.line(self.points[id], number), self.known[id]
        if known.get("kind") == "sidewalk" and not self.street.relief:
            line = Line.through(np.column_stack([line.middle, np.full(len(line.along), KERB_HEIGHT)]))
        if "stop" in known:
            known["stop"] = min(max(known["stop"], 0.0), line.length)
        return Lane(id=id, line=line, bend=(0.0, line.length if "turn" in known else 0.0), **known)

    def signals(self) -> Iterator[Signal]:
        """A light for each lane that leads to the junction."""
        for id in itertools.chain(*self.entries.values()) if self.street.lights else ():
            line = self.street.line(self.points[id], list(self.points).index(id))
            at = max(0.0, line.length - (self.road.sidewalk + _STOP - _JUNCTION_GAP))
            yield Signal(id=f"light.{id}", place=(*line.at(at).tolist(), float(line.heading(at))), lanes=(id,))

    def _add(self, path: Path, tail: str, points: np.ndarray, **more: Any) -> str:
        """The lane of a path; returns its id."""
        id, left, right = (f"{path.way}_{path.number + step}{tail}" for step in (0, 1, -1))
        leg, _, way = path.way.partition(".")
        known: dict[str, Any] = {"speed": path.speed, "width": path.width, "road": leg if way else "road", **more}
        if way == "in":
            known["stop"] = self.road.half_length - self.road.verge - _GIVES_WAY
        self.points[id], self.known[id] = points, {**known, "beside": {"left": left, "right": right}}
        return id

    def _main(self, path: Path) -> None:
        """The lane of the road itself, or its lanes before and behind the junction."""
        junction, direction = self.road.junction, 1 if path.angle == 0.0 else -1
        low, high = self.street.ends or tuple(sorted((path.along, path.along + direction * path.length)))
        if junction is None:
            self._add(path, "", self.street.along(path.across, low, high, direction))
            return
        for start, end in self.street.pieces(self.street.gap) if low < junction < high else [(low, high)]:
            enters, leg = (end < junction) == (direction > 0), "behind" if end < junction else "ahead"
            points = self.street.along(path.across, start, end, direction)
            legs = self.entries if enters else self.exits
            legs[leg].append(self._add(path, ".in" if enters else ".out", points))

    def _turns(self) -> None:
        """From each lane straight on into the lane of the same number, and into the outer lanes of the roads to either
        side."""
        for entries, exits in itertools.product(self.entries.values(), self.exits.values()):
            for number, start in enumerate(entries):
                into, away = self.points[start][-2:], self.points[exits[0]][:2]
                turned = math.remainder(_heading(away) - _heading(into), math.tau)
                turn = {} if abs(turned) < math.pi / 4 else {"turn": "left" if turned > 0 else "right"}
                out = exits[0 if turn else min(number, len(exits) - 1)]
                if abs(turned) < 3 * math.pi / 4:
                    known = {"width": self.road.lane_width, "speed": self.known[start]["speed"], **turn}
                    wide = _WIDE if turn.get("turn") == "right" else 1.0
                    self._through(f"{start}>{out}", _bent(into, self.points[out][:2], wide), out, **known)
                    self.known[start]["successors"] = (*self.known[start].get("successors", ()), f"{start}>{out}")

    def _around(self, radius: float) -> None:
        """The ring of a roundabout in pieces, counter-clockwise, and ways into it and out of it."""
        middle, _ = self.street.crossed()
        events = []
        for legs, end, way in ((self.entries, -1, 1), (self.exits, 0, -1)):
            for id in itertools.chain(*legs.values()):
                x, y = (self.points[id][end] - middle).tolist()
                events.append(((math.atan2(y, x) + way * _INTO_RING) % math.tau, way, id))
        events.sort()
        known = {"speed": _ROUNDABOUT_SPEED, "width": RING / 2}
        for number, (angle, way, id) in enumerate(events):
            after = (number + 1) % len(events)
            span = (events[after][0] - angle) % math.tau or math.tau
            turns = angle + np.linspace(0.0, span, 2 + math.ceil(span * radius / _RING_STATION))
            ring = middle + radius * np.stack([np.cos(turns), np.sin(turns)], axis=1)
            out = () if events[after][1] > 0 else (f"ring>{events[after][2]}",)
            self._through(f"ring_{number}", ring, f"ring_{after}", *out, **known)
            on = ring[0] + np.outer((0.0, 1.0), (-math.sin(angle), math.cos(angle)))
            if way > 0:
                self.known[id] |= {"successors": (f"{id}>ring",), "stop": math.inf}
                self._through(f"{id}>ring", _bent(self.points[id][-2:], on, _WIDE), f"ring_{number}", **known)
            else:
                into = on - np.diff(on, axis=0)
                self._through(f"ring>{id}", _bent(into, self.points[id][:2], _WIDE), id, **known)

    def _through(self, id: str, points: np.ndarray, *successors: str, **known: Any) -> None:
        """A lane through the junction."""
        self.points[id] = points
        self.known[id] = {"junction": "junction", "successors": successors, **known}

    def _beside(self) -> None:
        """Strips of parked vehicles, and sidewalks."""
        road, street = self.road, self.street
        strip = road.parking or PARKING_STRIP
        for side, name in ((LEFT, "left"), (RIGHT, "right")):
            if road.parking or side in (street.parked or ()):
                kind = "parking" if road.sidewalk or not road.median else "shoulder"
                for number, (low, high) in enumerate(street.pieces(street.gap)):
                    id = f"{kind}_{name}.{number}"
                    self.points[id] = street.along(side * (road.edge - strip / 2), low, high, -side)
                    self.known[id] = {"kind": kind, "width": strip, "speed": _CAR_PARK_SPEED}
        for number, ((low, high), (right, left)) in enumerate(road.sidewalks() if road.sidewalk else (), start=1):
            self.points[f"sidewalk_{number}"] = street.along((right + left) / 2, low, high, 1 if left < 0 else -1)
            self.known[f"sidewalk_{number}"] = {"kind": "sidewalk", "width": road.sidewalk, "speed": _ON_FOOT}


def _heading(points: np.ndarray) -> float:
    """The direction [rad] from the first point to the second."""
    return math.atan2(points[1, 1] - points[0, 1], points[1, 0] - points[0, 0])


def _bent(into: np.ndarray, away: np.ndarray, wide: float = 1.0) -> np.ndarray:
    """Points [S, 2] of the cubic curve from the end of one line [2, 2] to the start of another, tangent to both; it
    follows them further for a larger `wide`."""
    start, end, t = into[1], away[0], np.linspace(0.0, 1.0, 17)[:, None]
    reach = wide * np.linalg.norm(end - start)
    first, last = (reach * (line[1] - line[0]) / np.linalg.norm(line[1] - line[0]) for line in (into, away))
    points: np.ndarray = start + (3 * t**2 - 2 * t**3) * (end - start)
    points += (t**3 - 2 * t**2 + t) * first + (t**3 - t**2) * last
    return points
