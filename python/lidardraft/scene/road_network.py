"""The roads of a layout: lanes, junctions, crossings and signals, and the queries of planners."""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np

from lidardraft.errors import LayoutError, UnknownNameError, did_you_mean
from lidardraft.json_fields import check_fields, read_as, write_as
from lidardraft.scene.lane import Crossing, Junction, Lane, Pavement, Signal
from lidardraft.scene.line import Line
from lidardraft.scene.pose import Place, in_frame
from lidardraft.scene.relief import Relief
from lidardraft.scene.street import StreetFrame

MEETS = 0.5  # m, the largest distance from the end of a lane to the start of its successor
_STRAIGHT_ON, _BACK = math.pi / 4, 3 * math.pi / 4  # rad, the least angles of a turn and of a U-turn
_CHANGE = 20.0  # m, the cost of a lane change in a route


@dataclass(frozen=True, slots=True)
class Drawn:
    """A primitive that shows a road: its lowest and highest corner [m]."""

    id: str
    low: tuple[float, float, float]
    high: tuple[float, float, float]


_FIELDS: dict[str, Any] = {
    "street": StreetFrame | None,
    "lanes": tuple[Lane, ...],
    "junctions": tuple[Junction, ...],
    "crossings": tuple[Crossing, ...],
    "signals": tuple[Signal, ...],
    "paved": tuple[Pavement, ...],
    "drawn": tuple[Drawn, ...] | None,
    "relief": Relief | None,
}


class RoadNetwork:
    """The roads of a layout, in its frame: a `street`, which determines its lanes, or all elements of a map.

    `lanes`, `junctions`, `crossings`, `signals` and `paved` areas refer to each other by ids, and may overlap on
    several levels. `drawn` are the primitives that show the roads; None means those of `street.road`
    (`scene.road_surfaces`). A street follows its `ground`, a function from points [N, 2] to heights f64 [N], called
    when needed. A `relief` says how the ground of a level layout rises and falls in scans (`on_relief`). Networks are
    immutable.

    Raises `LayoutError` for an unknown or repeated id, for lanes that do not meet their successors, and for a street
    with other lanes.
    """

    def __init__(
        self,
        *,
        street: StreetFrame | None = None,
        lanes: tuple[Lane, ...] = (),
        junctions: tuple[Junction, ...] = (),
        crossings: tuple[Crossing, ...] = (),
        signals: tuple[Signal, ...] = (),
        paved: tuple[Pavement, ...] = (),
        drawn: tuple[Drawn, ...] | None = None,
        relief: Relief | None = None,
        ground: Callable[[np.ndarray], np.ndarray] | None = None,
    ) -> None:
        self._flat, self.paved, self.drawn, self.relief, self._ground = street, paved, drawn, relief, ground
        self._given, self._crossings = (lanes, junctions, signals), crossings
        if street is None:
            self._check()
        elif any(self._given):
            raise LayoutError("the network has a street and other lanes; those of a street follow from it")

    @cached_property
    def street(self) -> StreetFrame | None:
        """The street, or None for a map."""
        return self._flat if self._flat is None or self._ground is None else self._flat.over(self._ground)

    def __reduce__(self) -> tuple[Any, ...]:
        return partial(RoadNetwork, **self._fields()), ()

    @cached_property
    def _made(self) -> tuple[tuple[Lane, ...], tuple[Junction, ...], tuple[Signal, ...]]:
        return self._given if self.street is None else self.street.lanes()

    @property
    def lanes(self) -> tuple[Lane, ...]:
        """All lanes."""
        return self._made[0]

    @property
    def junctions(self) -> tuple[Junction, ...]:
        """The meetings of lanes."""
        return self._made[1]

    @property
    def signals(self) -> tuple[Signal, ...]:
        """The lights and signs."""
        return self._made[2]

    @property
    def crossings(self) -> tuple[Crossing, ...]:
        """The crossings for people, with the zebras of a street."""
        return self._crossings if self._flat is None else (*self._crossings, *self._flat.crossings())

    def _check(self) -> None:
        for what in ("lanes", "junctions", "crossings", "signals"):
            ids = [one.id for one in getattr(self, what)]
            if len(set(ids)) < len(ids):
                twice = next(id for id in ids if ids.count(id) > 1)
                raise LayoutError(f"two {what} have the id {twice!r}; ids must be distinct")
        junctions = {junction.id for junction in self.junctions}
        for id, lanes in ((one.id, one.lanes) for some in (self.junctions, self.signals) for one in some):
            self._known(id, lanes, self._by_id)
        for lane in self.lanes:
            self._known(lane.id, (*lane.successors, *filter(None, (lane.left, lane.right))), self._by_id)
            self._known(lane.id, filter(None, (lane.junction,)), junctions)
            end = lane.line.middle[-1]
            for id in lane.successors:
                apart = math.dist(end, self._by_id[id].line.middle[0])
                if apart > MEETS:
                    raise LayoutError(f"lane {lane.id} ends {apart:.1f} m from its successor {id}; {MEETS} m at most")

    def _known(self, owner: str, ids: Iterable[str], known: Iterable[str]) -> None:
        for id in ids:
            if id not in known:
                raise LayoutError(f"{owner} refers to {id!r}, which the network does not have{did_you_mean(known, id)}")

    @cached_property
    def _by_id(self) -> dict[str, Lane]:
        return {lane.id: lane for lane in self.lanes}

    @cached_property
    def _bounds(self) -> np.ndarray:
        """The lowest and highest x, y of each lane's line, [L, 2, 2]."""
        return np.array([(lane.line.middle.min(axis=0), lane.line.middle.max(axis=0)) for lane in self.lanes])

    def __eq__(self, other: object) -> bool:
        return isinstance(other, RoadNetwork) and self.to_dict() == other.to_dict()

    def lane(self, id: str) -> Lane:
        """The lane with that id; raises `UnknownNameError`, a `KeyError`, if there is none."""
        if id not in self._by_id:
            raise UnknownNameError(f"no lane has the id {id!r}{did_you_mean(self._by_id, id)}")
        return self._by_id[id]

    def nearest_lane(
        self,
        x: float,
        y: float,
        z: float | None = None,
        yaw: float | None = None,
        *,
        kinds: Iterable[str] | None = ("driving",),
    ) -> tuple[Lane, float, float]:
        """The lane nearest to x, y [m], and the place's distances along it and to the left of its middle [m].

        If lanes overlap, `z` [m] picks the level. With a `yaw` [rad], lanes whose direction differs by more than a
        quarter turn do not count. Raises `LayoutError` if the network has no lane of one of `kinds`.
        """
        wanted, place = None if kinds is None else set(kinds), np.array([[x, y]])
        away = np.hypot(*np.maximum(self._bounds[:, 0] - place, place - self._bounds[:, 1]).clip(0.0).T)
        best, least = None, math.inf
        for number in np.argsort(away, kind="stable").tolist():
            lane, line = self.lanes[number], self.lanes[number].line
            if away[number] > least or (wanted is not None and lane.kind not in wanted):
                continue
            (along,), (left,) = (one.tolist() for one in line.along_across(place, beyond=False))
            if yaw is not None and math.cos(yaw - line.heading(along)) < 0.0:
                continue
            near = line.at(along)
            level = 0.0 if z is None else z - float(line.height(along, left))
            distance = math.hypot(x - near[0], y - near[1], level)
            if distance < least:
                best, least = (lane, along, left), distance
        if best is None:
            raise LayoutError(f"the network has no lane of {', '.join(kinds or ('any kind',))} that leads there")
        return best

    def successors(self, lane: Lane) -> tuple[Lane, ...]:
        """The lanes that begin at the end of this one."""
        return tuple(self._by_id[id] for id in lane.successors)

    def route(self, start: str, end: str) -> tuple[Lane, ...]:
        """The shortest route over successors and adjacent lanes from one lane to another, by id, both included.

        Raises `UnknownNameError` for an unknown id, and `LayoutError` if there is no route.
        """
        first, last = self.lane(start), self.lane(end)
        before, open_ends = dict[str, str](), [(0.0, first.id, "")]
        while open_ends:
            length, id, came = heapq.heappop(open_ends)
            if id in before:
                continue
            before[id] = came
            if id == last.id:
                ids = [id]
                while before[ids[-1]]:
                    ids.append(before[ids[-1]])
                return tuple(self._by_id[one] for one in reversed(ids))
            lane = self._by_id[id]
            for after in lane.successors:
                heapq.heappush(open_ends, (length + lane.line.length, after, id))
            for beside in filter(None, (lane.left, lane.right)):
                heapq.heappush(open_ends, (length + _CHANGE, beside, id))
        raise LayoutError(f"no way leads from lane {start} to lane {end}")

    def height(self, x: float, y: float, z: float | None = None) -> float:
        """The height [m] of the road at x, y, on the level nearest to `z`: that of the nearest lane of any kind."""
        lane, along, left = self.nearest_lane(x, y, z, kinds=None)
        return float(lane.line.height(along, min(max(left, -lane.width / 2), lane.width / 2)))

    def normal(self, x: float, y: float, z: float | None = None) -> np.ndarray:
        """The upward unit normal [3] of the road at x, y, on the level nearest to `z`."""
        lane, along, _ = self.nearest_lane(x, y, z, kinds=None)
        return lane.line.normal(along)

    def ways(self) -> tuple[Lane, ...]:
        """The paths that drivers follow: straight on through junctions, and one over each turn; each joins several
        lanes.

        Those of a street are sampled as in its sequences; in other networks, lanes are joined at their ends.
        """
        if self.street is not None:
            ring = self.street.road.roundabout_radius is not None
            return (*self.street.ways(), *(self._around() if ring else self._from_side_roads()))
        before = {after: lane for lane in self.lanes for after in lane.successors}
        ways, covered = list[Lane](), set[str]()
        for lane in sorted(self.lanes, key=lambda lane: lane.junction is None):
            if lane.kind in ("driving", "aisle") and (lane.junction is not None or lane.id not in covered):
                chain = self._chain(lane, before)
                covered |= {one.id for one in chain}
                ways.append(_joined(chain, lane))
        return tuple(ways)

    def _from_side_roads(self) -> Iterator[Lane]:
        """The ways of a street that turn into its road."""
        for start in (lane for lane in self.lanes if lane.road != "road"):
            for turn in (after for after in self.successors(start) if after.turn is not None):
                yield _joined([start, turn, *self.successors(turn)], turn)

    def _around(self) -> Iterator[Lane]:
        """The ways of a street through its roundabout and out of it."""
        through = {lane.id for lane in self.lanes if lane.junction is not None}
        exits = {self._by_id[lane.successors[0]].id: lane for lane in self.lanes if lane.id.startswith("ring>")}
        for start in (lane for lane in self.lanes if through.intersection(lane.successors)):
            if start.junction is None:
                for out, leaves in exits.items():
                    turned = _turned(start.line, self._by_id[out].line)
                    beside = (start.right is None) == (self._by_id[out].right is None)
                    if abs(turned) < _BACK and beside:
                        chain = [start, *self._along(self.successors(start)[0], leaves), self._by_id[out]]
                        turn = None if abs(turned) < _STRAIGHT_ON else "left" if turned > 0.0 else "right"
                        yield replace(_joined(chain, chain[1], *chain[2:-1]), turn=turn, speed=start.speed)
        for out, leaves in exits.items():
            (last,) = (lane for lane in self.lanes if leaves.id in lane.successors)
            ring = self._along(self._by_id[last.successors[0]], leaves)
            yield replace(_joined([*ring, self._by_id[out]], *ring), speed=self._by_id[out].speed)

    def _along(self, first: Lane, last: Lane) -> list[Lane]:
        """The lanes from one in a roundabout to one that leaves it, both included."""
        lanes = [first]
        while lanes[-1] is not last:
            after = lanes[-1].successors
            lanes.append(last if last.id in after else self._by_id[after[0]])
        return lanes

    def _chain(self, middle: Lane, before: Mapping[str, Lane]) -> list[Lane]:
        """The lanes that lead on from `middle`, straight if possible, and those that lead to it."""
        chain = [middle]
        while (lane := before.get(chain[0].id)) is not None and lane not in chain:
            chain.insert(0, lane)
        while after := sorted(self.successors(chain[-1]), key=lambda lane: lane.turn is not None):
            if after[0] in chain:
                break
            chain.append(after[0])
        return chain

    def moved(self, place: Place) -> RoadNetwork:
        """The network of a frame that is at `place`, in the frame around it; `drawn` stays in its own frame."""
        relief = self.relief and self.relief.moved(place)
        if self.street is not None:
            return self.but(street=replace(self.street, place=in_frame(self.street.place, place)), relief=relief)
        parts = {
            name: tuple(replace(part, place=in_frame(part.place, place)) for part in getattr(self, name))
            for name in ("crossings", "signals", "paved")
        }
        return self.but(
            lanes=tuple(replace(lane, line=lane.line.moved(place)) for lane in self.lanes), relief=relief, **parts
        )

    def but(self, **fields: Any) -> RoadNetwork:
        """The network with some of its fields replaced."""
        return RoadNetwork(**{**self._fields(), **fields})

    def _fields(self) -> dict[str, Any]:
        """The fields that make the network: a street without the lanes derived from it."""
        lanes, junctions, signals = self._given
        given = {"lanes": lanes, "junctions": junctions, "signals": signals, "crossings": self._crossings}
        return {name: given[name] if name in given else getattr(self, name) for name in _FIELDS}

    def to_dict(self) -> dict[str, Any]:
        """The network as JSON types."""
        return {
            name: write_as(value) for name, value in self._fields().items() if value or (name, value) == ("drawn", ())
        }

    @classmethod
    def from_dict(cls, fields: Mapping[str, Any]) -> RoadNetwork:
        """The inverse of `to_dict`; raises `FormatError` for a missing or unknown field, `LayoutError` for a value."""
        check_fields(fields, (), _FIELDS)
        return cls(**{name: read_as(_FIELDS[name], value, name) for name, value in fields.items()})


def _turned(before: Line, after: Line) -> float:
    """The change of heading [rad] from the end of a line to the start of another."""
    return math.remainder(float(after.heading(0.0) - before.heading(before.length)), math.tau)


def _joined(chain: Sequence[Lane], middle: Lane, *more: Lane) -> Lane:
    """The lanes of a chain as one lane, with the turn of the middle one, or that of several in a row."""
    lines = [np.array(lane.line.written()["points"]) for lane in chain]
    starts = np.cumsum([0.0, *(lane.line.length for lane in chain)]).tolist()
    stops = [start + lane.stop for start, lane in zip(starts, chain, strict=False) if lane.stop is not None]
    begin = starts[chain.index(middle)]
    return replace(
        middle,
        id=f"way.{middle.id}",
        line=Line.through(np.concatenate([lines[0], *(line[1:] for line in lines[1:])])),
        successors=(),
        stop=stops[0] if stops else None,
        bend=(begin, begin + sum(one.line.length for one in (middle, *more))) if middle.turn or more else (0.0, 0.0),
    )
