"""The motions of objects that no scenario names: as in the sentence, or by their kind.

Vehicles and riders in a lane drive along it, parked ones stand, and people walk as far as their way is free.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from zlib import crc32

import numpy as np

from lidardraft.scene.check import VEHICLE_LABELS
from lidardraft.scene.intent import Asked, Intent
from lidardraft.scene.lane import Lane
from lidardraft.scene.layout import Layout
from lidardraft.scene.raycast import Raycaster
from lidardraft.scene.scenario import AlongLane, Motion, Straight, Walk
from lidardraft.scene.solids import Solid
from lidardraft.semantics import BY_NAME, GROUND
from lidardraft.simulation.motion.driver import Body, Driver, driver_of
from lidardraft.simulation.motion.right_of_way import RightOfWay

DRIVES = frozenset({*VEHICLE_LABELS, "rider"})  # classes that drive along lanes
_WALKING, _CLEAR, _STRIDE = 1.3, 0.6, 0.5  # m/s; m that stay free around a walker; m between checked places
_LONG = 1e4  # m, longer than all ways
_WIDEST = 30.0  # m of a way to the far side of a road
_OFF_ROAD = 0.5  # m from the kerb at which a person may stop
_FAR_KERB = 20.0  # m to the next kerb from which a person on a road goes along it
_TURNS_TO_KERB = tuple(np.radians(range(-90, 91, 15)).tolist())  # from its heading
_SHORTEST_WALK = 2.0  # m; people with less room stand
_HIGH = 500.0  # m, over all ground
_SOON = 1.0  # s after which a vehicle that "brakes" or "accelerates" does so
_SLOW = 0.3  # share of its usual speed that an accelerating vehicle begins with
_FASTER = 1.4  # times as fast as the vehicle that it overtakes
_TURN_RIGHT, _TURN_LEFT, _SHORT = 0.2, 0.15, 6.5  # shares of vehicles that turn at a junction; m, only shorter ones
_SHELTER = 8.0  # m to the right of a bus and ahead of it, to a shelter for its halt
_BESIDE_LANE = (1.5, 6.0)  # m from the middle of a lane to a vehicle in the next
_TURNS = {"turning-left": ("left",), "turning-right": ("right",), "turning": ("left", "right")}


class Ground:
    """The ground of a layout, looked at from above."""

    def __init__(self, layout: Layout) -> None:
        self.caster = Raycaster(Layout(tuple(p for p in layout if p.label in GROUND)))

    def at(self, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Heights [m], 0 without ground, and class ids [N] under places [N, 2 or more]."""
        origins = np.column_stack([places[:, :2], np.full(len(places), _HIGH)])
        hits = self.caster.cast(origins, np.tile((0.0, 0.0, -1.0), (len(places), 1)))
        return np.where(hits.valid, _HIGH - hits.distance, 0.0), hits.label


def usual_motions(
    intent: Intent,
    bodies: Mapping[str, Body],
    given: Mapping[str, Motion],
    rules: RightOfWay,
    ground: Ground,
    duration: float,
) -> dict[str, Motion]:
    """The motions of all moving bodies that have none `given`, in the order in which they give way: the first gives
    way first. The ego vehicle comes after others, and objects that the sentence moves come last."""
    said = {name: intent.of(name) for name in bodies}
    crossing = {name for name, asked in said.items() if str(asked.heading).startswith("across")}
    lanes, found = rules.ways, dict[str, Motion]()
    by_itself = [name for name in bodies if name not in given and said[name].heading != "parked"]
    by_itself = [name for name in by_itself if said[name].speed != 0.0]
    for name in (name for name in by_itself if bodies[name].labels & DRIVES):
        if (drives := _along_lane(bodies[name], said[name], lanes)) is not None:
            found[name] = _with_halt(drives, bodies[name], lanes, bodies.values())
    for name in (name for name in by_itself if "person" in bodies[name].labels):
        body, crosses = bodies[name], name in crossing
        others = [other for one, other in bodies.items() if one not in (crossing if crosses else {name})]
        way = _Way(body, said[name].speed or _WALKING, duration, ground)
        if way.road.any():  # it looks out for drivers
            others = [one for one in others if one.name not in found]
        walk = (None if crosses else _over_road(way, rules, others)) or _free_walk(way, others, crosses)
        if walk is not None:
            found[name] = walk
    for name in ("ego", *intent.objects):
        if name in bodies and said[name].motion == "overtakes":
            passed = [one for one in bodies if said[one].group in said[name].overtakes]
            _pass(name, passed or ["ego"], {**given, **found}, found, bodies, lanes)

    order = {name: number for number, name in enumerate(bodies)}

    def gives_way_late(name: str) -> tuple[bool, bool, int]:
        asked = said[name]
        moves = str(asked.heading) in _TURNS or asked.motion is not None or asked.speed is not None
        return name in crossing or moves, name == "ego", order[name]

    return {name: found[name] for name in sorted(found, key=gives_way_late)}


def _along_lane(body: Body, asked: Asked, lanes: Sequence[Lane]) -> Motion | None:
    """The motion of a vehicle along its lane as asked for; None if it is in no lane and has no other motion."""
    heading, speed, motion = str(asked.heading), asked.speed, asked.motion
    goes = asked.counted and heading.startswith("across")  # those asked for by number cross, of the rest each as it may
    straight = AlongLane(speed, overtakes=motion == "overtakes", gives_way=not goes)
    if asked.heading is None and motion is None and body.name != "ego" and body.size[0] < _SHORT:
        straight = replace(straight, turn=_turn_of(body, lanes))
    turned = [replace(straight, turn=turn) for turn in _TURNS.get(heading, ())]
    drivers = [driver for one in turned if (driver := driver_of(body, one, lanes)) is not None]
    driver = min(drivers, key=lambda one: abs(one.yaw), default=driver_of(body, straight, lanes))
    if driver is None:
        return Straight(speed) if body.name == "ego" and speed is not None else None
    usual = driver.usual()
    if motion == "brakes":
        return replace(driver.motion, later=((_SOON, 0.0),))
    if motion == "accelerates":
        return replace(driver.motion, speed=_SLOW * usual, later=((_SOON, usual),))
    return driver.motion


def _with_halt(motion: Motion, body: Body, lanes: Sequence[Lane], bodies: Iterable[Body]) -> Motion:
    """The motion; a bus gets a halt at the next shelter beside its lane, if any."""
    driver = _driver(body, motion, lanes) if "bus" in body.labels else None
    if driver is None or not isinstance(motion, AlongLane):
        return motion
    shelters = [one.place[:2] for one in bodies if one.name.rpartition("/")[2].startswith("shelter")]
    along, left = driver.lane.line.along_across(np.array(shelters).reshape(-1, 2))
    beside = (left < 0.0) & (left > -_SHELTER) & (along > driver.along + _SHELTER)
    return replace(motion, halt=shelters[int(np.where(beside, along, np.inf).argmin())]) if beside.any() else motion


def _turn_of(body: Body, lanes: Sequence[Lane]) -> str | None:
    """The turn at the next junction of a vehicle that the sentence leaves open; of vehicles side by side, only the
    outermost turns."""
    chance = crc32(f"{body.name} turns".encode()) / 2**32
    turn = "right" if chance < _TURN_RIGHT else "left"
    if chance >= _TURN_RIGHT + _TURN_LEFT * ("rider" not in body.labels):
        return None
    driver = driver_of(body, AlongLane(turn=turn), lanes)
    if driver is None or driver.along + body.size[0] / 2 > driver.lane.bend[0]:
        return None
    for lane in (lane for lane in lanes if lane.turn is None):
        (along,), (left,) = (rows.tolist() for rows in lane.line.along_across(np.array([body.place[:2]])))
        same = math.cos(body.place[3] - float(lane.line.heading(along))) > 0.9 and 0.0 < along < lane.line.length
        if same and _BESIDE_LANE[0] < (left if turn == "right" else -left) < _BESIDE_LANE[1]:
            return None
    return turn


def _pass(
    name: str,
    others: Iterable[str],
    motions: Mapping[str, Motion],
    found: dict[str, Motion],
    bodies: Mapping[str, Body],
    lanes: Sequence[Lane],
) -> None:
    """Make a vehicle faster than those that it overtakes: slow down those without a given speed, else speed it up."""
    drivers = {one: _driver(bodies[one], motions.get(one), lanes) for one in (name, *others)}
    own = drivers.pop(name)
    for other, driver in drivers.items():
        if own is None or driver is None:
            continue
        if other in found and driver.motion.speed is None:
            found[other] = replace(driver.motion, speed=min(driver.usual(), own.usual() / _FASTER))
        elif name in found:
            found[name] = replace(own.motion, speed=max(own.usual(), driver.usual() * _FASTER))


def _driver(body: Body, motion: Motion | None, lanes: Sequence[Lane]) -> Driver | None:
    return driver_of(body, motion, lanes) if isinstance(motion, AlongLane) else None


class _Way:
    """The way ahead of a person: `places` f64 [N, 2], their distances `steps` [m], and whether the ground is `road`
    there, or the `same` class as under the person."""

    def __init__(self, body: Body, speed: float, duration: float, ground: Ground) -> None:
        self.body, self.speed = body, speed
        usual = np.arange(0.0, max(speed * duration, _SHORTEST_WALK) + _STRIDE, _STRIDE)
        self.usual = len(usual) - 1
        self.steps = np.arange(0.0, usual[-1] + _WIDEST, _STRIDE)
        self._look(ground, 0.0)
        if self.road[0] and self.kerb() > _FAR_KERB / _STRIDE:  # along a road; it leaves that
            kerbs = [(self._look(ground, turn).kerb(), abs(turn), turn) for turn in _TURNS_TO_KERB]
            self._look(ground, min(kerbs)[2])

    def _look(self, ground: Ground, turn: float) -> _Way:
        """Turn to the left [rad] of the person's heading."""
        x, y, _, yaw = self.body.place
        heading = np.array([math.cos(yaw + turn), math.sin(yaw + turn)])
        self.places = np.array([x, y]) + self.steps[:, None] * heading
        _, self.label = ground.at(self.places)
        self.road, self.same = self.label == BY_NAME["road"].id, self.label == self.label[0]
        return self

    def kerb(self) -> int:
        """The index of the first place beyond the first road."""
        begin = int(np.argmax(self.road))
        return begin + int(np.argmin(np.append(self.road[begin:], False)))

    def free_of(self, others: Iterable[Body]) -> np.ndarray:
        """The mask [N] of places that are free of others."""
        free = np.ones(len(self.steps), dtype=bool)
        for other in others:
            if math.dist(other.place[:2], self.body.place[:2]) < self.steps[-1] + max(other.size) + _CLEAR:
                for solid in other.solids:
                    free &= ~_near(self.places, solid)
        return free

    def walk(self, end: int, crosses: tuple[tuple[float, float], ...] = ()) -> Walk:
        """The walk to the place of that index."""
        return Walk((float(self.places[end, 0]), float(self.places[end, 1])), self.speed, crosses=crosses)


def _over_road(way: _Way, rules: RightOfWay, others: Iterable[Body]) -> Walk | None:
    """The walk of a person from a sidewalk over crossings; None if the way leads to none."""
    if way.road[0] or not way.road.any():
        return None
    free, edges = way.free_of(others), np.flatnonzero(np.diff(way.road.astype(int)))
    end, spans = way.usual, list[tuple[int, int]]()
    for before, last in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=False):
        if before >= end or not (way.same | way.road)[: last + 2].all() or not free[: last + 2].all():
            break
        if not rules.is_crossing(way.places[[before, last + 1]]):
            break
        spans.append((before, last + 1))
        end = max(end, last + 1)
    if not spans:
        return None
    beyond = np.flatnonzero(~(free & way.same)[spans[-1][1] :])
    end = min(end, spans[-1][1] + int(beyond[0]) - 1) if len(beyond) else end
    return way.walk(end, tuple(tuple((way.steps[end] - way.steps[[a, b]]).tolist()) for a, b in spans))


def _free_walk(way: _Way, others: Iterable[Body], crosses: bool) -> Walk | None:
    """The walk of a person ahead as far as its way is free. It stays on its kind of ground, or goes across the road
    that it is on or `crosses`."""
    free = way.free_of(others)
    if not way.road[0] and not (crosses and way.road.any()):
        end = int(np.argmin(np.append((way.same & free)[: way.usual + 1], False))) - 1
        return way.walk(end) if way.steps[max(end, 0)] >= _SHORTEST_WALK else None
    kerb = way.kerb()
    same = way.label == way.label[min(kerb, len(free) - 1)]
    beyond = free & same & (np.arange(len(free)) > kerb + _OFF_ROAD / _STRIDE)
    if not beyond.any():
        return None
    first = int(np.argmax(beyond))
    end = min(first + int(np.argmin(np.append(beyond[first:], False))) - 1, max(way.usual, first))
    # it does not wait, but does not walk into cars either
    return way.walk(end, ((_LONG, float(way.steps[end] - way.steps[kerb])),))


def _near(places: np.ndarray, solid: Solid) -> np.ndarray:
    """Whether a solid is near places [N, 2]."""
    turn = np.array([[solid.cos, -solid.sin], [solid.sin, solid.cos]])
    off = np.abs((places - solid[:2]) @ turn) - (solid.half_length, solid.half_width)
    near: np.ndarray = np.hypot(*np.maximum(off, 0.0).T) < _CLEAR
    return near
