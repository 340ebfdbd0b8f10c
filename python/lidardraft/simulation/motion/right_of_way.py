"""Right of way at the junctions of a road network: lights, signs, turns and people who cross.

All of it is a function of the network, the time and the road users' places: a state is enough to go on from.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from zlib import crc32

import numpy as np

from lidardraft.scene.lane import Junction, Lane
from lidardraft.scene.pose import rotation
from lidardraft.scene.road_network import RoadNetwork
from lidardraft.simulation.motion.driver import Driver

# Lights: the first road of a junction and those along it, then the others. Seconds, estimates.
_GREEN, _AMBER, _ALL_RED = (18.0, 8.0), 3.0, 1.5
_FIRST = (-3.0, 4.0)  # s since the first road has had green at the time 0, so that its first wait is short
_CYCLE = sum(_GREEN) + 2 * (_AMBER + _ALL_RED)

_SAMPLED, _BESIDE = 1.0, 2.2  # m along ways; m between the middles of two that conflict
_MERGING = 6.0  # m from the point at which two ways merge, in which the later one waits
_BEFORE = 1.5  # m before an obstacle, for a driver without a stop line
_LOOKS = 15.0  # m that a driver looks further than its braking distance
_BRAKING, _ACCELERATION = 3.0, 1.5  # m/s2, as in `driving`
_TURNING, _CAREFUL = 5.0, 6.0  # m/s in a turn, and at the line of a driver that gives way
_MARGIN = 0.7  # s between two road users at one place
_PATIENCE = 8.0  # s after which the driver that has waited longest goes
_SLOW = 1.0  # m/s
_ROOM = 0.7  # m around a person who crosses
_CORNER, _BEYOND = 0.5, 5.0  # crossings beside a junction: share of its radius, and m beyond it
_OVER = 0.5  # m over the line beyond which drivers no longer wait
_ONCOMING = 0.4  # rad at most between the headings of two that pass side by side


@dataclass(frozen=True, slots=True)
class Zone:
    """The conflict zone of two passages: its start and end along both ways [m]. `gives` is 1 if the own passage gives
    way, -1 if the other does, 0 if the later one does."""

    other: int
    own: tuple[float, float]
    theirs: tuple[float, float]
    gives: int


@dataclass(slots=True)
class Passage:
    """A way through a junction: drivers wait at its `line` [m along] and are through at its `end`.

    It has the light of a `phase` or none, and gives way at a sign if `signed`. It turns left (1), right (-1) or not.
    """

    way: Lane
    line: float
    end: float
    phase: int | None
    signed: bool
    turn: int
    heading: float
    zones: list[Zone]

    @property
    def first(self) -> float:
        """The place [m] before all zones."""
        return min((zone.own[0] for zone in self.zones), default=math.inf) - _BEFORE


@dataclass(slots=True)
class _User:
    """A driver before a passage or on it: the `line` at which it waits, beyond that of the passage if it stands there
    and before the ways of others; its front and rear along the way, and the way to brake [m]; whether it is
    `committed`, too near to stop at the line, or `held` by a light."""

    number: int
    driver: Driver
    passage: Passage
    line: float
    front: float
    rear: float
    brakes: float
    committed: bool
    held: bool

    def reaches(self, along: float, of: float) -> float:
        """The time [s] until its front or rear, now at `of` [m], is as far `along` [m]."""
        way, turns = self.passage.way, self.passage.turn or any(self.passage.way.bend)
        top = min(_TURNING, way.limit(way.bend[0])) if turns else max(way.speed, self.driver.speed)
        return _seconds(along - of, min(self.driver.speed, top), top)

    def comes(self, zone: Zone, free: float) -> bool:
        """Whether it drives, or can get over its line or into that zone of another on a way that is `free` [m]."""
        return self.driver.speed > _SLOW or free > (zone.theirs[0] if self.committed else self.line)


class RightOfWay:
    """The junctions of a network, for drivers along its `ways`."""

    def __init__(self, roads: RoadNetwork | None, ways: Sequence[Lane]) -> None:
        self.ways, self.passages = ways, list[Passage]()
        self._zebras = () if roads is None else roads.crossings
        self._areas = list[tuple[np.ndarray, float]]()
        if roads is not None:
            self._areas = [_area(roads, junction) for junction in roads.junctions]
            for junction, area in zip(roads.junctions, self._areas, strict=True):
                self.passages += _passages(roads, junction, area, ways, len(self.passages))
        self.of_way: dict[int, list[int]] = {}
        for number, passage in enumerate(self.passages):
            self.of_way.setdefault(id(passage.way), []).append(number)
        lengths = [f"{lane.line.length:.2f}" for lane in (() if roads is None else roads.lanes)]
        self._offset = _FIRST[0] + crc32(" ".join(lengths).encode()) / 2**32 * (_FIRST[1] - _FIRST[0])

    def is_green(self, phase: int, time: float) -> bool:
        """Whether the light of a phase is green at a `time` [s]."""
        since = (time + self._offset - phase * (_GREEN[0] + _AMBER + _ALL_RED)) % _CYCLE
        return since < _GREEN[phase]

    def holds(
        self, drivers: Sequence[Driver], ahead: Sequence[tuple[float, float]], time: float, *, starts: bool = False
    ) -> list[float]:
        """The furthest place of each driver's front along its way now [m]. `ahead` gives each driver's free way [m] and
        the speed at its end [m/s]. Drivers that just start (`starts`) can stop anywhere."""
        users: dict[int, list[_User]] = {}
        for user, number in self._users(drivers, time, starts):
            users.setdefault(number, []).append(user)
        holds = [math.inf] * len(drivers)
        rows = zip(drivers, ahead, strict=True)
        free = [one.along + one.body.size[0] / 2 + gap - one.motion.gap for one, (gap, _) in rows]
        # the longest waiting driver comes last: it goes if all others in its way have to wait
        for user in sorted(itertools.chain(*users.values()), key=lambda one: (one.driver.waited, one.number)):
            if user.driver.motion.gives_way or user.committed:
                hold = self._hold(user, users, free)
                holds[user.number] = min(holds[user.number], hold)
                if user.committed:
                    free[user.number] = min(free[user.number], hold - user.driver.motion.gap)
        return holds

    def pace(self, driver: Driver) -> float:
        """The speed [m/s] at which a driver may approach the line at which it gives way."""
        front = driver.along + driver.body.size[0] / 2
        lines = (self.passages[number] for number in self.of_way.get(id(driver.lane), ()))
        rooms = [one.line - front for one in lines if one.signed and one.line >= front]
        return math.sqrt(_CAREFUL**2 + 2 * _ACCELERATION * min(rooms)) if rooms else math.inf

    def is_crossing(self, places: np.ndarray) -> bool:
        """Whether the way between places [2, 2] is a crossing: a zebra, or beside a junction."""
        middle = places.mean(axis=0)
        off = ((float(np.hypot(*(middle - center))), reach) for center, reach in self._areas)
        return self._on_zebra(middle) or any(_CORNER * reach < away < reach + _BEYOND for away, reach in off)

    def _on_zebra(self, place: np.ndarray) -> bool:
        for zebra in self._zebras:
            along, across = rotation(zebra.place[2]) @ (place - zebra.place[:2])
            if abs(along) < zebra.size[0] / 2 and abs(across) < zebra.size[1] / 2:
                return True
        return False

    def lets_cross(self, drivers: Sequence[Driver], time: float, places: np.ndarray, speed: float) -> bool:
        """Whether a person with a `speed` [m/s] can cross a road between `places` [2, 2] now: no driver comes, or each
        that comes has to stop and can. Nobody steps before a driver with green, or one that has let others cross."""
        length = float(np.hypot(*np.diff(places, axis=0)[0]))
        on_foot = np.linspace(0.0, length, 2 + int(length / _SAMPLED))
        points = places[0] + np.outer(on_foot / length, places[1] - places[0])
        zebra = self._on_zebra(points.mean(axis=0))
        users = [user for user, _ in self._users(drivers, time, False) if not user.committed]
        stops = {user.number for user in users if user.held and self._is_red(user.passage, time + length / speed)}
        goes = {user.number for user in users if user.passage.phase is not None and not user.passage.turn} - stops
        crossed: dict[int, tuple[np.ndarray, np.ndarray]] = {}
        for number, driver in enumerate(drivers):
            if id(driver.lane) not in crossed:
                crossed[id(driver.lane)] = driver.lane.line.along_across(points)
            along, left = crossed[id(driver.lane)]
            there = np.flatnonzero(np.abs(left - driver.left) < driver.body.size[1] / 2 + _ROOM)
            if not len(there) or number in stops:
                continue
            half, when = driver.body.size[0] / 2, on_foot[there] / speed
            room = float(along[there].min()) - driver.along - half
            if room < -driver.body.size[0] - _ROOM:
                continue
            if driver.speed < _SLOW and room > _ROOM and driver.waited < _PATIENCE and number not in goes:
                continue
            yields = (zebra and number not in goes) or driver.lane.bend[0] < driver.along + half + max(
                room, 0.0
            ) < driver.lane.bend[1] + _BEYOND
            if yields and room > driver.speed**2 / (2 * _BRAKING) + _ROOM:
                continue
            comes = room / max(driver.speed, _SLOW)
            gone = (room + driver.body.size[0] + _ROOM) / max(driver.speed, _SLOW)
            if comes < when[-1] + _MARGIN and gone > when[0] - _MARGIN:
                return False
        return True

    def _users(self, drivers: Sequence[Driver], time: float, starts: bool) -> Iterator[tuple[_User, int]]:
        for number, driver in enumerate(drivers):
            half = driver.body.size[0] / 2
            front, rear = driver.along + half, driver.along - half
            brakes = 0.0 if starts else driver.speed**2 / (2 * _BRAKING)
            for index in self.of_way.get(id(driver.lane), ()):
                passage = self.passages[index]
                line = max(passage.line, min(front, passage.first))
                room = line - front
                if rear > passage.end or room > 3 * brakes + 3 * _LOOKS:
                    continue
                committed = room < -_OVER or brakes > room + _OVER
                held = self._is_red(passage, time)
                if not driver.motion.gives_way:
                    committed, held = committed or driver.speed > _SLOW, False
                yield _User(number, driver, passage, line, front, rear, brakes, committed, held), index

    def _is_red(self, passage: Passage, time: float) -> bool:
        return passage.phase is not None and not self.is_green(passage.phase, time)

    def _hold(self, user: _User, users: dict[int, list[_User]], free: Sequence[float]) -> float:
        """The furthest place of a driver along its way [m]: its line or, once beyond it, the start of the zone of
        another driver that is beyond its own line and there first. `free` are the ends of all drivers' free ways
        [m]."""
        line = user.line
        if user.held and not user.committed:
            return line
        if line - user.front > user.brakes + _LOOKS:
            return math.inf
        found = [math.inf]
        for zone in user.passage.zones:
            others = (other for other in users.get(zone.other, ()) if other.number != user.number)
            others = (other for other in others if other.comes(zone, free[other.number]))
            if not user.committed:
                found += [line for other in others if _meet(user, zone, other)]
            elif user.front + user.brakes < zone.own[0]:
                first = (other for other in others if other.committed and _is_first(other, user, zone))
                found += [max(user.front, zone.own[0] - _BEFORE) for other in first if _meet(user, zone, other)]
        return min(found)


def _meet(user: _User, zone: Zone, other: _User) -> bool:
    """Whether a driver would meet another in a zone that it does not leave first."""
    (begin, end), (near, far) = zone.own, zone.theirs
    if other.rear > far:
        return False
    in_it, out = user.reaches(begin, user.front), user.reaches(end, user.rear)
    theirs_in, theirs_out = other.reaches(near, other.front), other.reaches(far, other.rear)
    if not other.committed:
        if other.held or _goes_first(user, in_it, zone, other, theirs_in):
            return False
    elif other.driver.speed < _SLOW and other.front > near:
        return True
    return in_it < theirs_out + _MARGIN and theirs_in < out + _MARGIN


def _is_first(other: _User, user: _User, zone: Zone) -> bool:
    """Whether another driver is in a zone first; both are beyond their lines."""
    (begin, _), (near, _) = zone.own, zone.theirs
    theirs, own = other.reaches(near, other.front), user.reaches(begin, user.front)
    return (theirs, other.number) < (own, user.number)


def _goes_first(user: _User, in_it: float, zone: Zone, other: _User, theirs_in: float) -> bool:
    """Whether a driver goes before another; both can still stop."""
    waited, theirs = user.driver.waited, other.driver.waited
    if max(waited, theirs) > _PATIENCE:
        return (waited, other.number) > (theirs, user.number)
    if zone.gives or not other.driver.motion.gives_way:
        return zone.gives < 0 and other.driver.motion.gives_way
    return (in_it, user.number) < (theirs_in, other.number)


def _seconds(way: float, speed: float, top: float) -> float:
    """The time [s] for a `way` [m] from `speed`, accelerating to `top` [m/s]."""
    if way <= 0.0:
        return 0.0
    faster = (top**2 - speed**2) / (2 * _ACCELERATION)
    if way < faster:
        return (math.sqrt(speed**2 + 2 * _ACCELERATION * way) - speed) / _ACCELERATION
    return (top - speed) / _ACCELERATION + (way - faster) / top


def _area(roads: RoadNetwork, junction: Junction) -> tuple[np.ndarray, float]:
    """The middle [2] and radius [m] of a circle around a junction."""
    points = np.concatenate([roads.lane(id).line.middle for id in junction.lanes])
    middle = points.mean(axis=0)
    return middle, float(np.hypot(*(points - middle).T).max()) + _BEFORE


def _passages(
    roads: RoadNetwork, junction: Junction, area: tuple[np.ndarray, float], ways: Sequence[Lane], first: int
) -> list[Passage]:
    """The passages through a junction, numbered from `first`."""
    middle, reach = area
    lights = [one for one in roads.signals if one.kind == "traffic-light"]
    lights = [one for one in lights if any(_leads(roads, id, junction) for id in one.lanes)]
    found, rows = list[Passage](), list[np.ndarray]()
    for way in ways:
        along = np.arange(0.0, way.line.length, _SAMPLED)
        points = way.line.at(along)
        inside = np.flatnonzero(np.hypot(*(points - middle).T) < reach)
        if way.closed or not len(inside):
            continue
        inside = inside[: int(np.argmax(np.append(np.diff(inside) > 1, True))) + 1]
        along = along[inside]
        heading = way.line.heading(along)
        turned = math.remainder(heading[-1] - heading[0], math.tau)
        stops = [at for light in lights if (at := _line_of(way, light.place, along[-1])) is not None]
        line = -math.inf if along[0] == 0.0 else math.inf
        if stops:
            line = max(stops)
        elif way.stop is not None and way.stop < along[-1]:
            line = way.stop
        axis = found[0].heading if found else heading[0]  # of the first road
        found.append(
            Passage(
                way=way,
                line=line,
                end=float(along[-1]),
                phase=int(abs(math.cos(heading[0] - axis)) < math.sqrt(0.5)) if stops else None,
                signed=way.stop is not None and not stops,
                turn=0 if abs(turned) < math.pi / 4 else int(math.copysign(1, turned)),
                heading=float(heading[0]),
                zones=[],
            )
        )
        rows.append(np.column_stack([along, points[inside], heading]))
    _add_zones(found, rows, first)
    return found


def _leads(roads: RoadNetwork, id: str, junction: Junction) -> bool:
    """Whether a lane leads into a junction or through it."""
    return id in junction.lanes or any(after in junction.lanes for after in roads.lane(id).successors)


def _line_of(way: Lane, place: tuple[float, float, float], end: float) -> float | None:
    """The place of a light along a way [m], or None if the way does not obey it."""
    (along,), (left,) = (rows.tolist() for rows in way.line.along_across(np.array([place[:2]])))
    looks = math.cos(place[2] - float(way.line.heading(along)))
    return along if abs(left) < 0.75 * way.width and 0.0 < along < end and looks > math.sqrt(0.5) else None


def _add_zones(found: Sequence[Passage], rows: Sequence[np.ndarray], first: int) -> None:
    for one, (passage, row) in enumerate(zip(found, rows, strict=True)):
        for other, (against, their) in enumerate(zip(found, rows, strict=True)):
            spans = None if one == other else _spans(row, their)
            if spans is not None:
                zone = Zone(first + other, *spans, _gives(passage, against))
                passage.zones.append(zone)
        if passage.line == math.inf:
            passage.line = passage.first


def _spans(row: np.ndarray, their: np.ndarray) -> tuple[tuple[float, float], tuple[float, float]] | None:
    """The spans [m] along two ways in which they conflict, from rows of along, x, y and heading; None if they do not
    conflict, or start as one way."""
    near = np.hypot(row[:, None, 1] - their[None, :, 1], row[:, None, 2] - their[None, :, 2]) < _BESIDE
    near &= np.cos(row[:, None, 3] - their[None, :, 3]) > -math.cos(_ONCOMING)
    mine, theirs = np.flatnonzero(near.any(axis=1)), np.flatnonzero(near.any(axis=0))
    if not len(mine) or (near[0, 0] and math.cos(row[0, 3] - their[0, 3]) > 0.0):
        return None
    begin, near_at, end, far = mine[0], theirs[0], row[mine[-1], 0], their[theirs[-1], 0]
    if math.cos(row[mine[-1], 3] - their[theirs[-1], 3]) > math.sqrt(0.5):  # they go on together
        # from the place that neither starts at: a way around a ring is also at its start when it has gone round
        met = (begin, near[begin].argmax()), (near[:, near_at].argmax(), near_at)
        begin, near_at = max(met, key=min)
        end, far = min(end, row[begin, 0] + _MERGING), min(far, their[near_at, 0] + _MERGING)
    return (float(row[begin, 0]), float(end)), (float(their[near_at, 0]), float(far))


def _gives(one: Passage, other: Passage) -> int:
    """Which of two gives way: 1 the first, -1 the other, 0 neither."""
    return int(_yields(one, other)) - int(_yields(other, one))


def _yields(one: Passage, other: Passage) -> bool:
    if one.signed != other.signed:
        return one.signed
    off = math.remainder(other.heading - one.heading, math.tau)
    if abs(off) > 3 * math.pi / 4:
        return one.turn > 0 >= other.turn
    if abs(off) < math.pi / 4:
        return one.turn != 0 and other.turn == 0
    return one.phase is None and off > 0.0
