"""Steps of a world's things: a step takes one state to the next, and is a function of that state alone."""

from __future__ import annotations

import dataclasses
import math
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence

import numpy as np

from lidardraft.errors import LayoutError
from lidardraft.scene.check import OVERLAP_TOLERANCE
from lidardraft.scene.lane import Lane
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.scenario import AlongLane, Motion, Straight, Walk, Waypoints
from lidardraft.scene.solids import Solid, penetration
from lidardraft.simulation.motion.driver import Driver, driver_of
from lidardraft.simulation.motion.driving import STEP, Seen, Traffic, boxes_of, extents_in, settle
from lidardraft.simulation.motion.motions import Ground, usual_motions
from lidardraft.simulation.motion.right_of_way import RightOfWay
from lidardraft.simulation.motion.tracks import through
from lidardraft.simulation.motion.walking import FORESEEN, foreseen, walked
from lidardraft.simulation.sweeps import Spot
from lidardraft.world.state import Actor, Collision, Drive, WorldState
from lidardraft.world.things import Thing

_AWAY = 0.5  # m from an object to its way-points at most
_FORESEEN = 60.0  # s of a walk whose way is checked
_KEPT = ("along", "left", "yaw", "start", "speed", "beside", "returns", "waited", "drift")  # of a driver
ThingOf = Callable[[str, Actor], Thing]


class Stepping:
    """The roads of a world's layout, its remaining ground, and the length of the past that its scans need [s].

    Its caches between steps are functions of the state: the extents of standing things in lanes.
    """

    def __init__(self, base: Layout, ground: Sequence[Primitive], thing_of: ThingOf, span: float) -> None:
        self.roads, self.intent = base.roads, base.intent
        self.ways: tuple[Lane, ...] = () if base.roads is None else base.roads.ways()
        self._rules = RightOfWay(base.roads, self.ways)
        self._ground = Ground(Layout(tuple(ground))) if ground else None
        self._thing_of, self.span = thing_of, span
        self._standing: _Standing | None = None

    def on_ground(self, name: str, spot: Spot, x: float, y: float, yaw: float) -> Spot:
        """The spot at x, y, yaw, as high over the ground as now; raises `LayoutError` off the map."""
        if self._ground is None:
            return x, y, spot[2], yaw
        (there, here), label = self._ground.at(np.array([(x, y), spot[:2]]))
        if not label[0]:
            raise LayoutError(f"{name}: x {x:.1f}, y {y:.1f} m is off the map; there is no ground")
        return x, y, spot[2] + float(there - here), yaw

    def height(self, x: float, y: float) -> float:
        """The height of the ground [m]; 0 without ground."""
        return 0.0 if self._ground is None else float(self._ground.at(np.array([(x, y)]))[0][0])

    def launched(self, state: WorldState, names: Iterable[str]) -> WorldState:
        """The state in which the things of these names move by themselves, and have done so before."""
        bodies = {
            name: thing.body_at(actor.spot)
            for name, actor in state.actors.items()
            if not (thing := self._thing_of(name, actor)).is_ground
        }
        given: dict[str, Motion] = {name: Straight(0.0) for name in set(bodies) - set(names)}
        motions = usual_motions(self.intent, bodies, given, self._rules, self._ground or Ground(Layout()), _FORESEEN)
        actors = {name: self.commanded(name, state.actors[name], motion) for name, motion in motions.items()}
        state = state.but(actors)
        drivers, others = self._movers(state)
        rows = np.array([_row(state.actors[name], state.actors[name].rate()) for name in others]).reshape(-1, 6)
        among = [self._thing_of(name, state.actors[name]).body for name in others]
        starting = [drivers[name] for name in actors if name in drivers]
        Traffic(list(drivers.values()), among, self._rules).begin(starting, rows, state.time)
        return state.but({name: self._begun(actor, drivers.get(name), state.time) for name, actor in actors.items()})

    def _begun(self, actor: Actor, driver: Driver | None, time: float) -> Actor:
        """The actor as if it had come at its usual speed."""
        speed, heading = 0.0, actor.spot[3]
        if driver is not None and actor.drive is not None:
            speed, actor = driver.speed, dataclasses.replace(actor, drive=_drive(driver, actor.drive.way))
        elif isinstance(actor.motion, Straight) or (isinstance(actor.motion, Walk) and not actor.motion.crosses):
            speed = actor.motion.speed
        if isinstance(actor.motion, Walk):
            heading = math.atan2(actor.motion.to[1] - actor.spot[1], actor.motion.to[0] - actor.spot[0])
        return self.with_past(actor, time, speed * math.cos(heading), speed * math.sin(heading))

    def with_past(self, actor: Actor, time: float, x: float, y: float) -> Actor:
        """The actor with the past of a velocity x, y [m/s]."""
        if not (x or y):
            return dataclasses.replace(actor, past=())
        before = (actor.spot[0] - x * self.span, actor.spot[1] - y * self.span, *actor.spot[2:])
        return dataclasses.replace(actor, past=((time - self.span, *before), (time, *actor.spot)))

    def commanded(self, name: str, actor: Actor, motion: Motion | None) -> Actor:
        """The actor with another motion; raises `LayoutError` if it is to drive along a lane and is in none."""
        if isinstance(motion, AlongLane):
            after = self.along(name, actor, motion, self.ways)
            if after is None:
                raise LayoutError(f"{name} stands in no lane that it could drive along; move it into one first")
            return after
        stands = motion is None or motion == Straight(0.0)
        return dataclasses.replace(actor, motion=None if stands else motion, drive=None, goal=None)

    def told(self, name: str, actor: Actor, motion: Motion | None, time: float) -> Actor:
        """The actor with a motion that a user gives it; a `UserWarning` reports one off the map. Raises `LayoutError`
        also where its way-points are elsewhere at that time [s]."""
        goals = [motion.to] if isinstance(motion, Walk) else []
        if isinstance(motion, Waypoints):
            goals = [(row[1], row[2]) for row in motion.points]
            (x, y, *_), _ = through(np.array(motion.points), 0.0, time + np.array([0.0, STEP])).places.tolist()
            if (away := math.dist((x, y), actor.spot[:2])) > _AWAY:
                raise LayoutError(f"{name}: its way-points are {away:.1f} m away at {time:.2f} s; move it first")
        after = self.commanded(name, actor, motion)
        if goals and self._ground is not None and not (on := self._ground.at(np.array(goals))[1] > 0).all():
            x, y = goals[int(np.argmin(on))]
            said = f"{name} goes off the map, to x {x:.1f}, y {y:.1f} m; without ground it keeps its height"
            warnings.warn(said, stacklevel=4)
        return after

    def along(
        self, name: str, actor: Actor, motion: AlongLane, among: Sequence[Lane], *, to_middle: bool = False
    ) -> Actor | None:
        """The actor driving along one of the ways `among`, or `to_middle` of it; None if it is in none of them."""
        body = self._thing_of(name, actor).body_at(actor.spot)
        driver = driver_of(body, motion, among)
        if driver is None:
            return None
        x, y, _, _ = actor.rate()
        driver.speed = max(0.0, x * math.cos(actor.spot[3]) + y * math.sin(actor.spot[3]))
        driver.returns = to_middle
        way = next(number for number, lane in enumerate(self.ways) if lane is driver.lane)
        return dataclasses.replace(actor, motion=motion, drive=_drive(driver, way), goal=None)

    def check(self, state: WorldState) -> None:
        """Raises `LayoutError` if a state has drivers on unknown ways."""
        for name, actor in state.actors.items():
            fits = isinstance(actor.motion, AlongLane) == (actor.drive is not None)
            if not fits or (actor.drive is not None and not 0 <= actor.drive.way < len(self.ways)):
                raise LayoutError(f"the state has {name!r} on no lane of its layout that it could drive along")

    def stepped(self, state: WorldState, seconds: float, count: int, policy: str) -> WorldState:
        """The state `seconds` later, in `count` steps; things reach their goals in the last."""
        start = state.time
        for number in range(1, count + 1):
            state = self._step(state, start + seconds * number / count, count + 1 - number, policy)
        return state

    def _step(self, state: WorldState, time: float, left: int, policy: str) -> WorldState:
        span, actors = time - state.time, state.actors
        drivers, others = self._movers(state)
        bodies = [self._thing_of(name, actors[name]).body for name in others]
        traffic = Traffic(list(drivers.values()), bodies, self._rules)
        assert self._standing is not None
        rows = np.array([_row(actors[name], actors[name].rate()) for name in others]).reshape(-1, 6)
        watch = Seen(traffic, state.time, np.concatenate([self._standing.boxes, traffic.boxes(rows)]))
        changes = {name: _gone(actors[name], state.time, time, left, watch) for name in others}
        after = [
            _row(actors[name], [(b - a) / span for a, b in zip(actors[name].spot, one.spot, strict=True)])
            for name, one in changes.items()
        ]
        traffic.advance(state.time, np.array(after).reshape(-1, 6), span)
        places = traffic.places().tolist() if drivers else []
        for (name, driver), (x, y, _, yaw) in zip(drivers.items(), places, strict=True):
            actor = actors[name]
            assert actor.drive is not None
            turned = actor.spot[3] + math.remainder(yaw - actor.spot[3], math.tau)
            changes[name] = dataclasses.replace(
                actor, spot=(x, y, actor.spot[2], turned), drive=_drive(driver, actor.drive.way)
            )
        changes = self._raised(actors, changes)
        changes, events = self._run_into(state, changes, time, policy)
        for name, actor in actors.items():
            if name in changes or actor.past:
                changes[name] = self._remembered(actor, changes.get(name, actor), state.time, time)
        news = {name: after for name, after in changes.items() if after != actors[name]}
        return state.but(news, time=time, collisions=state.collisions + events)

    def _movers(self, state: WorldState) -> tuple[dict[str, Driver], list[str]]:
        """The drivers, each with its bar by standing things, and the names of other moving things."""
        moving = [name for name, actor in state.actors.items() if actor.motion is not None or actor.goal is not None]
        now = set(moving)
        standing = [(name, actor) for name, actor in state.actors.items() if name not in now]
        if self._standing is None or not self._standing.is_of(standing):
            self._standing = _Standing(standing, self._thing_of)
        drivers, others = dict[str, Driver](), list[str]()
        for name in moving:
            actor = state.actors[name]
            if (drive := actor.drive) is None:
                others.append(name)
                continue
            assert isinstance(actor.motion, AlongLane)
            body, lane = self._thing_of(name, actor).body, self.ways[drive.way]
            driver = Driver(body, actor.motion, lane, **{name: getattr(drive, name) for name in _KEPT})
            settle(driver, self._standing.extents(lane))
            drivers[name] = driver
        return drivers, others

    def _raised(self, actors: Mapping[str, Actor], changes: dict[str, Actor]) -> dict[str, Actor]:
        """The moved actors at their old heights over the ground."""
        if self._ground is None or not changes:
            return changes
        spots = [spot[:2] for name, after in changes.items() for spot in (actors[name].spot, after.spot)]
        heights, labels = self._ground.at(np.array(spots))
        rises = np.where(labels.reshape(-1, 2).all(axis=1), np.diff(heights.reshape(-1, 2))[:, 0], 0.0).tolist()
        raised = {}
        for (name, after), rise in zip(changes.items(), rises, strict=True):
            x, y, z, yaw = after.spot
            raised[name] = dataclasses.replace(after, spot=(x, y, z + rise, yaw)) if rise else after
        return raised

    def _remembered(self, before: Actor, after: Actor, begin: float, end: float) -> Actor:
        """The actor with its past up to now, as far back as scans need it."""
        past = (*(before.past or ((begin, *before.spot),)), (end, *after.spot))
        first = max((k for k, row in enumerate(past) if row[0] <= end - self.span), default=0)
        past = past[first:]
        moves = any(row[1:] != past[0][1:] for row in past)
        return dataclasses.replace(after, past=past if moves else ())

    def met(self, before: WorldState, after: WorldState, names: Iterable[str], policy: str) -> WorldState:
        """The state `after` placing the things of these names, with its collisions; raises if these are refused."""
        self._movers(before)
        _, events = self._run_into(before, {name: after.actors[name] for name in names}, after.time, policy)
        return dataclasses.replace(after, collisions=after.collisions + events)

    def _run_into(
        self, state: WorldState, changes: dict[str, Actor], time: float, policy: str
    ) -> tuple[dict[str, Actor], tuple[Collision, ...]]:
        """The changes and their collisions; with the policy "stop", colliding things stand in their old places."""
        assert self._standing is not None
        actors = state.actors
        moved = [name for name, after in changes.items() if name not in actors or after.spot != actors[name].spot]
        if not moved:
            return changes, ()
        live = {name: actor for name, actor in state.actors.items() if name not in self._standing.names} | changes
        bodies = {name: self._thing_of(name, actor).body_at(actor.spot) for name, actor in live.items()}
        solids = [(name, solid) for name, body in bodies.items() for solid in body.solids]
        circles = np.concatenate([self._standing.circles, _circles(solid for _, solid in solids)])
        solids, found, seen = self._standing.solids + solids, list[Collision](), set[str]()
        for name in moved:
            met = dict[str, None]()
            for own in bodies[name].solids:
                away = np.hypot(circles[:, 0] - own.x, circles[:, 1] - own.y) - circles[:, 2]
                for other, solid in (solids[k] for k in np.flatnonzero(away < own.radius).tolist()):
                    if other != name and other not in seen and other not in met and _touch(own, solid):
                        met[other] = None
            seen.add(name)
            found += [Collision(time, name, other) for other in met if not self._touched(state, name, other)]
        if found and policy == "refuse":
            raise LayoutError(f"{found[0].one} runs into {found[0].other} at {time:.2f} s; nothing was changed")
        if policy == "stop":
            for name in {name for event in found for name in (event.one, event.other)} & set(changes) & set(actors):
                changes[name] = dataclasses.replace(actors[name], motion=None, drive=None, goal=None)
        return changes, tuple(found)

    def _touched(self, state: WorldState, *names: str) -> bool:
        if not set(names) <= set(state.actors):
            return False
        bodies = [self._thing_of(name, state.actors[name]).body_at(state.actors[name].spot) for name in names]
        return any(_touch(a, b) for a in bodies[0].solids for b in bodies[1].solids)


class _Standing:
    """Standing things: their solids with the names of their owners, the circles around these, and their extents in
    lanes."""

    def __init__(self, actors: Sequence[tuple[str, Actor]], thing_of: ThingOf) -> None:
        self._actors, self.names = actors, {name for name, _ in actors}
        bodies = ((name, thing_of(name, actor).body_at(actor.spot)) for name, actor in actors)
        self.solids = [(name, solid) for name, body in bodies for solid in body.solids]
        self.circles = _circles(solid for _, solid in self.solids)
        self.boxes = boxes_of([solid for _, solid in self.solids])
        self._extents: dict[int, np.ndarray] = {}

    def is_of(self, actors: Sequence[tuple[str, Actor]]) -> bool:
        """Whether these actors are the standing ones."""
        return len(actors) == len(self._actors) and all(
            one is other and name == named for (name, one), (named, other) in zip(actors, self._actors, strict=True)
        )

    def extents(self, lane: Lane) -> np.ndarray:
        """The extents of all solids in a lane (`extents_in`)."""
        if id(lane) not in self._extents:
            self._extents[id(lane)] = extents_in(lane, [solid for _, solid in self.solids])
        return self._extents[id(lane)]


def _circles(solids: Iterable[Solid]) -> np.ndarray:
    return np.array([(solid.x, solid.y, solid.radius) for solid in solids]).reshape(-1, 3)


def _touch(one: Solid, other: Solid) -> bool:
    return penetration(one, other) > OVERLAP_TOLERANCE


def _drive(driver: Driver, way: int) -> Drive:
    return Drive(way, *(getattr(driver, name) for name in _KEPT))


def _row(actor: Actor, rate: Sequence[float]) -> tuple[float, ...]:
    expected = foreseen(actor.motion, actor.spot[:2]) if isinstance(actor.motion, Walk) else FORESEEN[0]
    return *actor.spot[:2], actor.spot[3], rate[0], rate[1], expected


def _gone(actor: Actor, begin: float, end: float, left: int, watch: Seen) -> Actor:
    """An actor without a lane after a step, the first of `left` steps to its goal; heights are added later."""
    (x, y, z, yaw), motion = actor.spot, actor.motion
    if actor.goal is not None:
        u, v, heading = actor.goal
        turn = math.remainder(heading - yaw, math.tau)
        if left == 1:
            return dataclasses.replace(actor, spot=(u, v, z, yaw + turn), goal=None)
        return dataclasses.replace(actor, spot=(x + (u - x) / left, y + (v - y) / left, z, yaw + turn / left))
    if isinstance(motion, Straight):
        way = motion.speed * (end - begin)
        return dataclasses.replace(actor, spot=(x + way * math.cos(yaw), y + way * math.sin(yaw), z, yaw))
    if isinstance(motion, Walk):
        (x, y, yaw), over = walked(motion, (x, y, yaw), begin, end, watch)
        return dataclasses.replace(actor, spot=(x, y, z, yaw), motion=None if over else motion)
    assert isinstance(motion, Waypoints)
    u, v, _, looks = through(np.array(motion.points), yaw, np.array([begin, end])).places[-1].tolist()
    over = end >= motion.points[-1][0]
    turned = yaw + math.remainder(looks - yaw, math.tau)
    return dataclasses.replace(actor, spot=(u, v, z, turned), motion=None if over else motion)
