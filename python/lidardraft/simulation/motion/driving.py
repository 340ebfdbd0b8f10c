"""Traffic on the lanes of a layout: followers, and the place of each road user at each step.

Vehicles keep the distance of the Intelligent Driver Model. They never drive too fast to stop behind the road user in
their way (Gipps, Transportation Research B 15, 1981).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from lidardraft.scene.lane import Lane
from lidardraft.scene.scenario import AlongLane, Track, Walk
from lidardraft.scene.solids import Solid
from lidardraft.simulation.motion.driver import Body, Driver
from lidardraft.simulation.motion.right_of_way import RightOfWay
from lidardraft.simulation.motion.walking import FORESEEN, foreseen, walked

STEP = 0.05  # s between the places of a track
_WARNS = 1.0  # s before a vehicle in which people let it pass
_SIDE = 0.2  # m that stay free beside a vehicle
_TOUCHING = 0.5  # m by which an object before a vehicle may reach into its box at the start
_ACCELERATION, _BRAKING, _HARDEST = 1.5, 3.0, 8.0  # m/s2: usual ones, and the limit of tyres
_CLOSING = 2 * math.sqrt(_ACCELERATION * _BRAKING)  # m/s2, by which the kept distance grows with the speeds' gap
_STANDS, _ROLLS = 0.1, 1.5  # m/s: with a lower wanted speed a vehicle stands; faster it no longer waits
_AIM = 10.0  # m over which a vehicle turns into its lane's direction
_SEES, _CLEAR, _TO_EDGE = 20.0, 1.0, 0.7  # m of view to cyclists, m beside them, m from them to the lane's edge
_LEFT = 4.0  # m/s at which a bus has left its stop
_RETURN, _PASSED = 12.0, 6.0  # m over which a vehicle returns to its lane; m that it is then ahead of the passed one
CYCLES = frozenset({"bicycle"})  # classes that keep right


def drive(
    drivers: Sequence[Driver],
    others: Mapping[str, Track],
    walks: Mapping[str, Walk],
    bodies: Mapping[str, Body],
    times: np.ndarray,
    rules: RightOfWay,
) -> dict[str, Track]:
    """The tracks of drivers, and of `walks` over roads, at `times` [s] that are `STEP` apart.

    `others` have known tracks; all other bodies stand.
    """
    moving = {*others, *walks, *(driver.body.name for driver in drivers)}
    standing = [body for name, body in bodies.items() if name not in moving]
    solids = [solid for body in standing for solid in body.solids]
    extents = {id(driver.lane): extents_in(driver.lane, solids) for driver in drivers}
    for driver in drivers:
        settle(driver, extents[id(driver.lane)])
    at = (track.at(times) for track in others.values())
    rows = [np.column_stack([one[:, [0, 1, 3]], np.gradient(one[:, :2], STEP, axis=0)]) for one in at]
    known = np.array(rows).reshape(-1, len(times), 5)
    known = np.concatenate([known, np.full((*known.shape[:2], 1), FORESEEN[0])], axis=2)
    traffic, still = Traffic(drivers, [bodies[name] for name in (*others, *walks)], rules), boxes_of(solids)
    places = np.empty((len(times), len(drivers) + len(walks), 4))
    on_foot = np.array([bodies[name].place for name in walks]).reshape(-1, 4)
    traffic.begin(drivers, np.concatenate([known[:, 0], _rows(on_foot, _towards(on_foot, walks.values()), walks)]))
    for step, time in enumerate(times.tolist()):
        places[step] = np.concatenate([traffic.places(), on_foot])
        now = np.concatenate([known[:, step], _rows(on_foot, np.zeros((len(walks), 2)), walks)])
        after, watch = on_foot.copy(), Seen(traffic, time, np.concatenate([still, traffic.boxes(now)]))
        for row, walk in zip(after, walks.values(), strict=True):
            row[[0, 1, 3]] = walked(walk, tuple(row[[0, 1, 3]].tolist()), time, time + STEP, watch)[0]
        goes = _rows(on_foot, (after - on_foot)[:, :2] / STEP, walks)
        traffic.advance(time, np.concatenate([known[:, step], goes]))
        on_foot = after
    places[:, :, 3] = np.unwrap(places[:, :, 3], axis=0)
    names = (*(driver.body.name for driver in drivers), *walks)
    return {name: Track(times, places[:, number]) for number, name in enumerate(names)}


def _rows(places: np.ndarray, rates: np.ndarray, walks: Mapping[str, Walk]) -> np.ndarray:
    """x, y, yaw, velocity and the seconds for which that is foreseen [N, 6] of people at places [N, 4]."""
    spans = [foreseen(walk, (x, y)) for walk, (x, y) in zip(walks.values(), places[:, :2].tolist(), strict=True)]
    return np.column_stack([places[:, [0, 1, 3]], rates, np.array(spans)])


def _towards(places: np.ndarray, walks: Iterable[Walk]) -> np.ndarray:
    """The velocities [N, 2] of people at places [N, 4] who walk on."""
    rows = np.array([(*walk.to, walk.speed) for walk in walks]).reshape(-1, 3)
    ways = rows[:, :2] - places[:, :2]
    rates: np.ndarray = ways * (rows[:, 2] / np.maximum(np.hypot(*ways.T), 1e-9))[:, None]
    return rates


def boxes_of(solids: Sequence[Solid]) -> np.ndarray:
    """Standing solids as rows of `Watch.obstacles`, f64 [S, 6]."""
    rows = [(*one[:2], math.atan2(one.sin, one.cos), one.half_length, one.half_width, 0.0) for one in solids]
    return np.array(rows).reshape(-1, 6)


def extents_in(lane: Lane, solids: Sequence[Solid]) -> np.ndarray:
    """The nearest point of each solid along a lane, and its right and left end beside the middle [m], f64 [S, 3]."""
    if not solids:
        return np.empty((0, 3))
    first = np.cumsum([0, *(len(solid.outline) for solid in solids)])[:-1]
    along, left = lane.line.along_across(np.concatenate([solid.outline for solid in solids]))
    rows = np.minimum.reduceat(along, first), np.minimum.reduceat(left, first), np.maximum.reduceat(left, first)
    return np.stack(rows, axis=1)


def settle(driver: Driver, extents: np.ndarray) -> None:
    """Set how far standing objects (`extents_in` its lane) let a driver go; cyclists keep right."""
    driver.barred = bar_of(driver, extents)
    if driver.body.labels & CYCLES and driver.lane.kind == "driving":
        side = min(_TO_EDGE - driver.lane.width / 2, 0.0)
        if bar_of(replace(driver, left=side), extents) >= driver.barred:
            driver.returns, driver.side = True, side


def bar_of(driver: Driver, extents: np.ndarray) -> float:
    """The furthest place of a driver's front along its lane [m]: at the first standing object of `extents_in` that
    lane, or at its end. At the end of the map the ego vehicle stops, and others drive on."""
    front, reach = driver.along + driver.body.size[0] / 2, driver.body.size[1] / 2 + _SIDE
    ends = [driver.lane.line.length if driver.lane.closed or driver.body.name == "ego" else math.inf]
    nearest, low, high = extents.T
    in_way = (low < driver.left + reach) & (high > driver.left - reach) & (nearest > front - _TOUCHING)
    return min([*ends, *nearest[in_way].tolist()])


class Traffic:
    """All drivers, lane by lane, at one time, among `others` that follow no lane. The rows of these are f64 [W, 6]: x,
    y, yaw, velocity, and the time [s] for which that velocity is foreseen."""

    def __init__(self, drivers: Sequence[Driver], others: Sequence[Body], rules: RightOfWay) -> None:
        self.drivers, self.rules = drivers, rules
        bodies = [*(driver.body for driver in drivers), *others]
        self.cycles = np.array([bool(body.labels & CYCLES) for body in bodies], dtype=bool)
        self.walking = np.array(["person" in body.labels for body in bodies], dtype=bool)
        self.sizes = np.array([body.size[:2] for body in bodies]).reshape(-1, 2)
        self.lanes: dict[int, list[int]] = {}
        for number, driver in enumerate(drivers):
            self.lanes.setdefault(id(driver.lane), []).append(number)

    def begin(self, starting: Sequence[Driver], others: np.ndarray, time: float = 0.0) -> None:
        """Set the speeds of `starting` drivers: as wanted, but slow enough to stop behind the road user ahead; if all
        start, slow enough to follow it without braking."""
        together = len(starting) == len(self.drivers)
        for driver in starting:
            driver.speed = driver.wish(time)
        for _ in starting:  # a queue needs as many rounds as it is long
            before = [driver.speed for driver in starting]
            for driver, (gap, ahead) in zip(self.drivers, self._free(others, time, starts=True), strict=True):
                if driver in starting:
                    safe = _safe(gap - driver.motion.gap, ahead)
                    if together and ahead > 0.0:
                        safe = min(safe, _steady(driver.motion, gap, ahead))
                    driver.speed = min(driver.speed, safe, self.rules.pace(driver))
            if before == [driver.speed for driver in starting]:
                return

    def places(self) -> np.ndarray:
        """x, y, z, yaw [D, 4] of the drivers; z is the height of their lanes."""
        found = np.zeros((len(self.drivers), 4))
        for numbers in self.lanes.values():
            rows = [self.drivers[number] for number in numbers]
            lane = rows[0].lane
            end = lane.line.length
            along, left, first, start, drift = np.array(
                [(row.along, row.left, row.yaw, row.start, row.drift) for row in rows]
            ).T
            found[numbers, :2], found[numbers, 2] = lane.line.at(along, left), lane.line.height(along, left)
            off = first * np.exp((start - along) / _AIM) + np.arctan(drift)
            found[numbers, 3] = lane.line.heading(along) + off
            if (over := np.maximum(along - end, 0.0)).any():  # off the map it goes straight on
                heading = lane.line.heading(end)
                found[numbers, :2] += np.outer(over, (np.cos(heading), np.sin(heading)))
        return found

    def boxes(self, others: np.ndarray) -> np.ndarray:
        """All moving bodies as rows of `Watch.obstacles`; a vehicle also covers its way in the next second."""
        x, y, yaw, *rate = self._all(others).T
        half_length, half_width = self.sizes.T / 2
        speed = np.where(self.walking, 0.0, np.hypot(*rate))
        way = speed * _WARNS / 2
        along = x + way * np.cos(yaw), y + way * np.sin(yaw)
        return np.column_stack([*along, yaw, half_length + way, half_width, speed])

    def advance(self, time: float, others: np.ndarray, span: float = STEP) -> None:
        """Advance all drivers by `span` [s]."""
        for driver, (gap, ahead) in zip(self.drivers, self._free(others, time), strict=True):
            motion, speed, wish = driver.motion, driver.speed, min(driver.wish(time), self.rules.pace(driver))
            free = 1.0 - (speed / wish) ** 4 if wish > _STANDS else -_BRAKING / _ACCELERATION * (speed > 0.0)
            kept = motion.gap + max(0.0, speed * motion.headway + speed * (speed - ahead) / _CLOSING)
            push = _ACCELERATION * (max(free, -_BRAKING / _ACCELERATION) - (kept / max(gap, 0.1)) ** 2)
            faster = min(speed + push * span, _safe(gap - motion.gap / 2, ahead))
            driver.speed = max(faster, speed - _HARDEST * span, 0.0)
            driver.along += (way := driver.speed * span)
            rolls = driver.speed > (_ROLLS if motion.halt is None else _LEFT)
            driver.waited = 0.0 if rolls else driver.waited + span * (driver.speed < _STANDS)
            if driver.returns:  # it turns the wheel gradually
                driver.drift += way / _RETURN * ((driver.side - driver.left) / _RETURN - 2 * driver.drift)
                driver.left += way * driver.drift

    def _free(self, others: np.ndarray, time: float, *, starts: bool = False) -> list[tuple[float, float]]:
        """As `_ahead`, and up to the lines at which drivers have to wait."""
        ahead = self._ahead(others)
        holds = self.rules.holds(self.drivers, ahead, time, starts=starts)
        rows = zip(self.drivers, ahead, holds, strict=True)
        return [min(one, (min(hold, who.halt()) - who.along - who.body.size[0] / 2, 0.0)) for who, one, hold in rows]

    def _ahead(self, others: np.ndarray) -> list[tuple[float, float]]:
        """For each driver the free way before it [m] and the speed [m/s] of the road user at its end."""
        now = self._all(others)
        found = [(0.0, 0.0)] * len(self.drivers)
        for numbers in self.lanes.values():
            lane = self.drivers[numbers[0]].lane
            along, left, yaw, forward, sideways = self._in_lane(lane, now)
            expected = np.concatenate([np.zeros(len(self.drivers)), others[:, 5]])
            cycles = self.cycles & (forward > _ROLLS) & (np.abs(left) < lane.width / 2)
            cos, sin = np.abs(np.cos(yaw)), np.abs(np.sin(yaw))
            half_along = (cos * self.sizes[:, 0] + sin * self.sizes[:, 1]) / 2
            half_across = (sin * self.sizes[:, 0] + cos * self.sizes[:, 1]) / 2
            for number in numbers:
                driver = self.drivers[number]
                front, reach = driver.along + driver.body.size[0] / 2, driver.body.size[1] / 2 + _SIDE
                turns = abs(driver.yaw) * math.exp((driver.start - driver.along) / _AIM)
                reach += driver.body.size[0] / 2 * math.sin(turns)  # its ends swing out
                ways = np.maximum(along + half_along - driver.along + driver.body.size[0] / 2, 0.0)
                leaves = (np.sqrt(driver.speed**2 + 2 * _ACCELERATION * ways) - driver.speed) / _ACCELERATION
                soon = left + sideways * np.minimum(leaves, expected)
                low, high = np.minimum(left, soon) - half_across, np.maximum(left, soon) + half_across
                in_way = (low < driver.left + reach) & (high > driver.left - reach) & (along > driver.along)
                in_way[number] = False
                if driver.motion.overtakes:
                    apart = np.abs(along - driver.along) - half_along - driver.body.size[0] / 2
                    apart[number] = np.inf
                    passed = np.abs(left) - half_across < driver.body.size[1] / 2  # those in its lane
                    near = float(apart[passed].min(initial=np.inf))
                    driver.beside |= near < 0.0
                    driver.returns |= driver.beside and near > _PASSED
                elif not self.cycles[number]:
                    seen = cycles & (np.abs(along - driver.along - _SEES / 3) < _SEES)
                    self._pass(driver, (left + half_across)[seen])
                gaps = np.where(in_way, along - half_along - front, np.inf)
                nearest = int(np.argmin(gaps))
                found[number] = min(
                    (float(gaps[nearest]), max(0.0, float(forward[nearest]))), (driver.barred - front, 0.0)
                )
        return found

    def _pass(self, driver: Driver, edges: np.ndarray) -> None:
        """Let a driver keep left of cyclists if its lane has room, else in the middle; `edges` are the cyclists' left
        sides, left of the lane's middle [m]."""
        half, driver.side = driver.body.size[1] / 2, 0.0
        room = driver.lane.width / 2 + _SIDE - half
        if len(edges) and edges.max() + half + 2 * _SIDE <= room:
            driver.returns, driver.side = True, max(0.0, min(room, float(edges.max()) + half + _CLEAR))

    def _all(self, others: np.ndarray) -> np.ndarray:
        """x, y, yaw and velocity [M, 5] of all moving bodies: the drivers, then the others."""
        x, y, _, yaw = self.places().T
        speed = np.array([driver.speed for driver in self.drivers])
        rows = np.column_stack([x, y, yaw, speed * np.cos(yaw), speed * np.sin(yaw)])
        return np.concatenate([rows.reshape(-1, 5), others[:, :5]])

    @staticmethod
    def _in_lane(lane: Lane, now: np.ndarray) -> tuple[np.ndarray, ...]:
        """Along and left [m] of a lane, the yaw against it, and the velocities along it and to its left [M]."""
        along, left = lane.line.along_across(now[:, :2])
        heading = lane.line.heading(along)
        cos, sin = np.cos(heading), np.sin(heading)
        return along, left, now[:, 2] - heading, now[:, 3] * cos + now[:, 4] * sin, now[:, 4] * cos - now[:, 3] * sin


@dataclass(frozen=True, slots=True)
class Seen:
    """The traffic as people on foot see it at a `time` [s] (`Watch`)."""

    traffic: Traffic
    time: float
    obstacles: np.ndarray

    def can_cross(self, places: np.ndarray, speed: float) -> bool:
        """As `RightOfWay.lets_cross`."""
        return self.traffic.rules.lets_cross(self.traffic.drivers, self.time, places, speed)


def _safe(gap: float, ahead: float) -> float:
    """The highest speed [m/s] to stop within `gap` [m] behind a braking road user with the speed `ahead` [m/s]."""
    reaction = _BRAKING * STEP
    return max(0.0, math.sqrt(max(0.0, reaction**2 + ahead**2 + 2 * _BRAKING * gap)) - reaction)


def _steady(motion: AlongLane, gap: float, ahead: float) -> float:
    """The speed [m/s] at which a driver keeps just `gap` [m] from a road user with the speed `ahead` [m/s]."""
    half = (motion.headway * _CLOSING - ahead) / 2
    return math.sqrt(half**2 + max(0.0, gap - motion.gap) * _CLOSING) - half
