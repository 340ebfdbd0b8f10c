"""A world that is changed, stepped and scanned: `World`."""

from __future__ import annotations

import dataclasses
import itertools
import math
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from fnmatch import fnmatchcase
from typing import Any

import numpy as np

from lidardraft.drafting.boxes import layout_from_boxes
from lidardraft.errors import (
    LayoutError,
    LidarDraftError,
    UnknownNameError,
    check_choice,
    check_seed,
    check_that,
    check_type,
    did_you_mean,
    one_of,
)
from lidardraft.json_fields import are_numbers, is_number
from lidardraft.scan import Scan
from lidardraft.scene.bodies import Bodies
from lidardraft.scene.box import Box
from lidardraft.scene.edit import moved_part
from lidardraft.scene.lane import Lane
from lidardraft.scene.layout import Layout, Primitive, box_around, object_of
from lidardraft.scene.pose import Place, upright
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.scenario import FASTEST, AlongLane, Motion, Straight, Walk, Waypoints
from lidardraft.scene.sensor import Sensor
from lidardraft.scene.sensor_model import SensorModel
from lidardraft.scene.surfaces import Surfaces
from lidardraft.scene.weather import Weather, weather_of
from lidardraft.semantics import BY_NAME, GROUND
from lidardraft.simulation.motion.driving import STEP
from lidardraft.simulation.motion.motions import DRIVES
from lidardraft.simulation.on_relief import on_relief
from lidardraft.simulation.recorded.solid_object import sampled_parts
from lidardraft.simulation.roads import with_known_roads
from lidardraft.simulation.simulate import level_layout
from lidardraft.simulation.sweeps import FLASH, Mover, Spot, Sweeper, radius_of
from lidardraft.world.rig import Mount, Rig
from lidardraft.world.state import EGO_NAME, Actor, Collision, WorldState
from lidardraft.world.stepping import Stepping
from lidardraft.world.things import EGO_THING, Thing, built

_POLICIES = ("allow", "refuse", "stop")
_MOST_THINGS = 5000  # if all of them drive, a step and a scan take a second together
_MOST_INSTANCES = 2**16 - 1
_LONGEST = 60.0  # s, of a step


class Handle:
    """One object of a world, or its ego vehicle, in the current state."""

    __slots__ = ("_world", "id")

    def __init__(self, world: World, id: str) -> None:
        self._world, self.id = world, id

    @property
    def pose(self) -> Place:
        """x, y [m] and yaw [rad] of the middle of its box; for the ego vehicle, of its place on the road.

        Set it to the goal for the end of the next step: the object goes there evenly, then stands until its next
        command. `World.move` places at once.
        """
        x, y, _, yaw = self._world._actor(self.id).spot
        return x, y, yaw

    @pose.setter
    def pose(self, pose: Place) -> None:
        self._world._send(self.id, pose)

    @property
    def size(self) -> tuple[float, float, float]:
        """Length, width and height of its box [m]."""
        return self._world._thing(self.id, self._world._actor(self.id)).body.size

    @property
    def velocity(self) -> tuple[float, float, float]:
        """Its velocity x, y, z in the world [m/s]."""
        return self._world._actor(self.id).rate()[:3]

    @property
    def speed(self) -> float:
        """Its speed ahead [m/s]. A new value holds at once, along its lane or walk, or straight on; a driver in a lane
        still stops behind others."""
        actor = self._world._actor(self.id)
        if actor.drive is not None:
            return actor.drive.speed
        if isinstance(actor.motion, Straight | Walk):
            return actor.motion.speed
        return self.velocity[0] * math.cos(actor.spot[3]) + self.velocity[1] * math.sin(actor.spot[3])

    @speed.setter
    def speed(self, speed: float) -> None:
        self._world._set_speed(self.id, speed)

    @property
    def motion(self) -> Motion | None:
        """Its motion until the next command, None if it stands; times are those of the world. Set it to move as in a
        scenario; `Straight` and `Waypoints` also run into others or, with a `UserWarning`, off the map."""
        return self._world._actor(self.id).motion

    @motion.setter
    def motion(self, motion: Motion | None) -> None:
        self._world._set_motion(self.id, motion)

    def __repr__(self) -> str:
        x, y, yaw = self.pose
        return f"Handle({self.id}, x {x:.2f} m, y {y:.2f} m, yaw {yaw:.3f} rad, {self.speed:.2f} m/s)"


class World:
    """A layout, the street of a sentence, or boxes, scanned while things in it move, come and go.

    Vehicles in a lane, people and the ego vehicle move by themselves, as in sequences, until a command. The part of an
    id before the dot names a thing; the ego vehicle is "ego".

    A scan at the time t covers the sweep that ends at t, with everything in its place at each moment. `boxes` are those
    at t. The time, pose, boxes and velocities of the `Scan` itself are those of the middle of its sweep, as in
    sequences. So frame k of a `SequenceSimulator` is the scan after k + 1 steps of 1 / hz. A box of the scan is half a
    `sweep_time` of its velocity behind that of `boxes`.

    With a `Rig`, several sensors on the ego vehicle scan one moment: `scan(channel)`, `scans()`. `state()` has all but
    sensor, model and weather: the same state gives the same bytes in scans and steps. A `WorldState` in place of the
    layout goes on from there. `collisions` lists things that run into each other. With "stop" they stand there; with
    "refuse" the call raises `LayoutError`. `model`, `weather`, `relief`, `carrier`, `own_returns` and `threads` are
    those of `Simulator`. A call that raises changes nothing; one thread may use a world at a time.
    """

    def __init__(
        self,
        layout: Layout | str | Sequence[Box] | WorldState,
        sensor: Sensor | Rig,
        *,
        seed: int = 0,
        collisions: str = "allow",
        model: SensorModel | None = None,
        weather: Weather | None = None,
        relief: bool = True,
        carrier: bool | Layout = True,
        own_returns: bool = False,
        threads: int | None = None,
    ) -> None:
        check_type("sensor", sensor, Sensor, Rig)
        check_choice("collisions", collisions, _POLICIES)
        self._policy, self._lock = collisions, threading.Lock()
        if isinstance(sensor, Rig):
            check_that(model is None, "model", model, "left out: each sensor of a rig has its own")
            self.rig = sensor
        else:
            self.rig = Rig({sensor.name: Mount(sensor, (0.0, 0.0, sensor.mount_height, 0.0))})
        self._built: dict[int, tuple[Layout, dict[str, Thing]]] = {}
        self._state: WorldState
        self._roads: tuple[Layout, list[Primitive], Layout, Stepping] | None = None
        given: Any = layout
        if isinstance(layout, WorldState):
            check_that(check_seed(seed) in (0, layout.seed), "seed", seed, f"{layout.seed}, that of the state")
            check_that(relief, "relief", relief, "left out: the state has its own")
            given = layout.layouts[0]
        elif not isinstance(layout, Layout | str):
            given = layout_from_boxes(layout)
        base, self._assumed = level_layout(given, seed, relief)
        self._made_for, self._given = (0, (0.0, 0.0, 0.0), Weather()), (model, weather, threads)
        self._carrier: dict[str, Any] = {"carrier": carrier, "own_returns": own_returns}
        self._weather: Weather | None = None
        if isinstance(layout, WorldState):
            self._adopt(layout)
        else:
            self._begin(base, check_seed(seed))

    def _begin(self, base: Layout, seed: int) -> None:
        """Give all things their places, and let them move."""
        names = set(map(object_of, base))
        if EGO_NAME in names:
            raise LayoutError("an object of the layout is called 'ego', as the ego vehicle is; rename it")
        _check_number(len(names))
        weather = self._weather_over(base)
        things = built(base, seed, weather.wetness)
        actors = {name: Actor(0, thing.home) for name, thing in things.items()}
        origin = next((thing.bodies.origin for thing in things.values()), (0.0, 0.0, 0.0))
        actors[EGO_NAME] = Actor(0, EGO_THING.home)
        self._built, self._made_for = {0: (base, things)}, (seed, origin, weather)
        self._adopt(WorldState(seed=seed, origin=origin, time=0.0, steps=0, layouts={0: base}, actors=actors))
        ego = Actor(0, (0.0, 0.0, self._stepping.height(0.0, 0.0), 0.0))
        self._state = self._stepping.launched(self._state.but({EGO_NAME: ego}), (*self.ids, EGO_NAME))

    def _weather_over(self, base: Layout) -> Weather:
        return self._given[1] or weather_of(base.intent.weather) or Weather()

    def _adopt(self, state: WorldState) -> None:
        """Take a state, and build the new ones of its layouts; raises `LayoutError` if it contradicts itself."""
        base = state.layouts[0]
        weather = self._weather_over(base)
        made_for = state.seed, state.origin, weather
        kept = self._built if made_for == self._made_for else {}
        made = {number: entry for number, entry in kept.items() if state.layouts.get(number) is entry[0]}
        for number, layout in state.layouts.items():
            if number not in made:
                around = base if number else None
                made[number] = layout, built(layout, state.seed, weather.wetness, around, state.origin)
        things = dict[str, Thing]()
        for name, actor in state.actors.items():
            if name != EGO_NAME:
                if name not in made.get(actor.batch, (base, {}))[1]:
                    raise LayoutError(f"the state has {name!r} of its layout {actor.batch}, which has no such object")
                things[name] = made[actor.batch][1][name]
        ground = [part for thing in things.values() if thing.is_ground for part in thing.parts if part.label in GROUND]
        if self._roads is None or self._roads[0] is not base or not _same(self._roads[1], ground):
            known = with_known_roads(on_relief(base))
            longest = max(mount.sensor.sweep_time for mount in self.rig.mounts.values())
            stepping = Stepping(known, ground, self._thing, max(longest, FLASH))
        else:
            _, _, known, stepping = self._roads
        stepping.check(state)
        if weather != self._weather:
            model, _, threads = self._given
            self._sweepers = {
                name: Sweeper.of(mount.sensor, model, weather, threads, **self._carrier, spot=mount.spot)
                for name, mount in self.rig.mounts.items()
            }
        self._roads, self._weather, self._made_for = (base, ground, known, stepping), weather, made_for
        self._known, self._stepping, self._built, self._state = known, stepping, made, state
        self._still: tuple[list[Actor], Bodies] | None = None
        self._table: tuple[list[Thing], Surfaces] | None = None
        self._scans: tuple[WorldState, dict[str, Scan]] | None = None

    @contextmanager
    def _alone(self) -> Iterator[None]:
        if not self._lock.acquire(blocking=False):
            raise LidarDraftError("another thread uses this world; give each one of its own, `World(state, sensor)`")
        try:
            yield
        finally:
            self._built = {number: self._built[number] for number in self._state.layouts}
            self._lock.release()

    def _thing(self, name: str, actor: Actor) -> Thing:
        return EGO_THING if name == EGO_NAME else self._built[actor.batch][1][name]

    def _actor(self, id: str) -> Actor:
        actor = self._state.actors.get(id) if isinstance(id, str) else None
        if actor is None:
            raise UnknownNameError(f"the world has no object {id!r}{did_you_mean(self._state.actors, id)}")
        return actor

    def _movable(self, id: str) -> Actor:
        actor = self._actor(id)
        if self._thing(id, actor).is_ground:
            raise LayoutError(f"{id} is ground, which others stand on; it cannot be moved")
        return actor

    @property
    def time(self) -> float:
        """The simulated time since the start [s]."""
        return self._state.time

    @property
    def ids(self) -> tuple[str, ...]:
        """The ids of all objects except the ego vehicle and the ground."""
        actors = self._state.actors
        return tuple(n for n in actors if n != EGO_NAME and not self._thing(n, actors[n]).is_ground)

    @property
    def collisions(self) -> tuple[Collision, ...]:
        """All collisions so far."""
        return self._state.collisions

    @property
    def ego(self) -> Handle:
        """The vehicle with the sensor."""
        return Handle(self, EGO_NAME)

    def __getitem__(self, id: str) -> Handle:
        self._actor(id)
        return Handle(self, id)

    def __contains__(self, id: object) -> bool:
        return id in self._state.actors

    def state(self) -> WorldState:
        """The current state, as a value."""
        return self._state

    def restore(self, state: WorldState) -> None:
        """Go on from a state, of this world or of another; raises `LayoutError` if it contradicts itself."""
        check_type("state", state, WorldState)
        with self._alone():
            self._adopt(state)

    def add(
        self,
        what: str | Primitive | Sequence[Primitive] | Layout,
        at: tuple[float, float] | None = None,
        *,
        yaw: float = 0.0,
        speed: float | None = None,
        id: str | None = None,
    ) -> str:
        """Add an object: a kind, such as "van" or "cyclist", or its shapes, such as a model's; returns its id.

        Its middle stands `at` x, y [m] on the ground, by default at the place of the shapes; it is turned by `yaw`
        [rad]. With a `speed` [m/s] it moves as in `Handle.speed`, else by itself. Raises `LayoutError` for an unknown
        kind, several objects without an `id` for all, a taken id, a place off the map and too many things.
        """
        with self._alone():
            state = self._state
            name, parts = self._parts_of(what, id)
            if name in state.actors:
                raise LayoutError(f"id is {name!r}, which another object has; give `id`, or remove that one first")
            _check_number(len(state.actors) + 1)
            at = (0.0, 0.0) if at is None and isinstance(what, str) else at
            layout, number = Layout(self._counted(self._placed(name, parts, at, yaw))), max(state.layouts) + 1
            things = built(layout, state.seed, self._made_for[2].wetness, state.layouts[0], state.origin)
            self._built[number] = layout, things
            after = state.but({name: Actor(number, things[name].home)}, layouts={**state.layouts, number: layout})
            if speed is None:
                after = self._stepping.launched(after, [name])
            else:
                after = after.but({name: self._at_speed(name, after.actors[name], speed, True)})
            self._state = self._stepping.met(state, after, [name], self._policy)
            return name

    def _parts_of(self, what: str | Primitive | Sequence[Primitive] | Layout, id: str | None) -> tuple[str, Any]:
        """The name of the new object and its shapes, in their place or, for a kind, at the origin."""
        if isinstance(what, str):
            names = {name for _, things in self._built.values() for name in things}
            name = id or next(one for k in itertools.count(1) if (one := f"{what}_{k}") not in names)
            shapes = enumerate(sampled_parts(what, self._state.seed, name), start=1)
            origin = (0.0, 0.0, 0.0)
            return name, [s.placed(origin, 0.0, f"{name}.{s.name}" if s.name else name, k) for k, s in shapes]
        parts = [what] if isinstance(what, Primitive) else list(what)
        for part in parts:
            check_type("a shape", part, Primitive)
            said = f"{part.id}: label"
            check_that(part.label not in GROUND, said, part.label, "that of an object, not of the ground")
        names = set(map(object_of, parts))
        if (len(names) > 1 and id is None) or not parts:
            raise LayoutError(f"what is added holds {len(names)} objects; add one, or give an `id` for all of them")
        if id is not None:
            parts = [dataclasses.replace(p, id=f"{id}.{k}" if k else id) for k, p in enumerate(parts)]
        return object_of(parts[0]), parts

    def _placed(self, name: str, parts: list[Primitive], at: Any, yaw: float) -> list[Primitive]:
        """The turned parts, with their middle `at` a place on the ground, if given."""
        (yaw,), box = _numbers(f"{name}: yaw", (yaw,), 1), box_around(parts)
        x, y = box.center[:2] if at is None else _numbers(f"{name}: at", at, 2)
        bottom = box.center[2] - box.size[2] / 2
        here = self._stepping.on_ground(name, (*box.center[:2], bottom, 0.0), x, y, yaw)
        up = 0.0 if at is None else self._stepping.height(x, y) - bottom
        middle, by = box.center[:2], (x - box.center[0], y - box.center[1], up)
        return [moved_part(part, middle, by, here[3]) for part in parts] if any((*by, yaw)) else parts

    def _counted(self, parts: Sequence[Primitive]) -> tuple[Primitive, ...]:
        """The parts with unused instances, a new one for each of their own."""
        used = {part.instance for _, things in self._built.values() for one in things.values() for part in one.parts}
        free = (number for number in range(1, _MOST_INSTANCES + 1) if number not in used)
        numbers: dict[tuple[str, int], int] = {}
        counted = []
        for part in parts:
            if BY_NAME[part.label].is_thing:
                key = object_of(part), part.instance
                if key not in numbers:
                    numbers[key] = next(free)
                part = dataclasses.replace(part, instance=numbers[key])
            counted.append(part)
        return tuple(counted)

    def move(self, id: str, to: tuple[float, float], *, yaw: float | None = None, speed: float = 0.0) -> None:
        """Place an object at x, y [m] at once; it stands there, or moves with a `speed` [m/s] as in `Handle.speed`."""
        with self._alone():
            actor, (x, y) = self._movable(id), _numbers("to", to, 2)
            turned = actor.spot[3] if yaw is None else _numbers("yaw", (yaw,), 1)[0]
            spot = self._stepping.on_ground(id, actor.spot, x, y, turned)
            after = self._at_speed(id, Actor(actor.batch, spot), speed, True)
            self._state = self._stepping.met(self._state, self._state.but({id: after}), [id], self._policy)

    def remove(self, pattern: str) -> None:
        """Remove all objects whose ids match, such as "around/tree_*"; raises `LayoutError` if none does."""
        with self._alone():
            check_type("pattern", pattern, str)
            names = [name for name in self._state.actors if fnmatchcase(name, pattern) and name != EGO_NAME]
            if not names:
                self._actor(pattern)
                raise LayoutError("the ego vehicle cannot be removed")
            self._adopt(self._state.but(dict.fromkeys(names)))

    def follow(self, id: str, *, lane: str | Lane | None = None, behind: str | None = None, gap: float = 2.0) -> None:
        """Let an object drive to the middle of a lane of the layout's `roads` and along it, or `behind` another object
        in its lane. It keeps `gap` [m] and 1.5 s to the vehicle ahead. Raises `LayoutError` if it is not in that
        lane."""
        with self._alone():
            actor, ways = self._movable(id), self._stepping.ways
            if (lane is None) == (behind is None):
                raise LayoutError(f"{id} follows a lane or somebody; give one of lane and behind")
            if behind is not None:
                leader = self._actor(behind)
                led = leader if leader.drive else self._stepping.along(behind, leader, AlongLane(), ways)
                fits = behind != id and led is not None and led.drive is not None
                check_that(fits, "behind", behind, "another object that stands in a lane and looks along it")
                assert led is not None
                assert led.drive is not None
                among, where, before = [ways[led.drive.way]], f"the lane of {behind}", led.drive.along
            else:
                roads = self._stepping.roads
                if roads is None:
                    raise LayoutError("the layout has no roads that are known; nothing can follow a lane")
                one = lane if isinstance(lane, Lane) else roads.lane(str(lane))
                among, where, before = [way for way in ways if way.leads_along(one)], f"lane {one.id}", math.inf
            for way in among:
                after = self._stepping.along(id, actor, AlongLane(gap=gap, turn=way.turn), [way], to_middle=True)
                if after is not None and after.drive is not None and after.drive.along < before:
                    self._state = self._state.but({id: after})
                    return
            back = f" behind {behind}" if behind else ""
            raise LayoutError(f"{id} does not stand in {where}{back} and look along it; move it there first")

    def _send(self, id: str, pose: Place) -> None:
        with self._alone():
            actor = self._movable(id)
            x, y, yaw = _numbers(f"{id}: pose", pose, 3)
            self._stepping.on_ground(id, actor.spot, x, y, yaw)
            after = dataclasses.replace(actor, motion=None, drive=None, goal=(x, y, yaw))
            self._state = self._state.but({id: after})

    def _set_speed(self, id: str, speed: float) -> None:
        with self._alone():
            self._state = self._state.but({id: self._at_speed(id, self._movable(id), speed, False)})

    def _at_speed(self, name: str, actor: Actor, speed: float, anew: bool) -> Actor:
        """The actor with a speed, along its lane if it is in one; `anew` as if it had come at it."""
        fits = is_number(speed) and abs(speed) <= FASTEST
        check_that(fits, f"{name}: speed", speed, f"-{FASTEST:g} to {FASTEST:g} m/s")
        if isinstance(actor.motion, Walk) and speed > 0.0:
            after = dataclasses.replace(actor, motion=dataclasses.replace(actor.motion, speed=speed))
        elif isinstance(actor.motion, AlongLane) and speed >= 0.0:
            after = dataclasses.replace(actor, motion=dataclasses.replace(actor.motion, speed=speed, later=()))
        else:
            drives = speed > 0.0 and self._thing(name, actor).body.labels & DRIVES
            along = self._stepping.along(name, actor, AlongLane(speed), self._stepping.ways) if drives else None
            after = along or self._stepping.commanded(name, actor, Straight(speed))
        if after.drive is not None:
            after = dataclasses.replace(after, drive=dataclasses.replace(after.drive, speed=float(speed)))
        if not anew:
            return after
        ways = speed * math.cos(actor.spot[3]), speed * math.sin(actor.spot[3])
        return self._stepping.with_past(after, self._state.time, *ways)

    def _set_motion(self, id: str, motion: Motion | None) -> None:
        with self._alone():
            if motion is not None:
                check_type("motion", motion, Straight, AlongLane, Walk, Waypoints)
            after = self._stepping.told(id, self._movable(id), motion, self._state.time)
            self._state = self._state.but({id: after})

    def step(self, seconds: float) -> None:
        """Advance, in steps of 0.05 s or less. Raises `LayoutError` if `seconds` is not over 0, or over 60."""
        with self._alone():
            fits = is_number(seconds) and 0.0 < seconds <= _LONGEST
            check_that(fits, "seconds", seconds, f"a number over 0, and {_LONGEST:g} at most")
            count = max(1, math.ceil(seconds / STEP - 1e-9))
            after = self._stepping.stepped(self._state, float(seconds), count, self._policy)
            self._state = dataclasses.replace(after, steps=after.steps + 1)

    def scan(self, channel: str | None = None) -> Scan:
        """The scan by a sensor of the rig, by default the first, of the sweep that ends now; noise and drop are drawn
        anew after each step. Raises `UnknownNameError` for another channel."""
        with self._alone():
            if self._scans is None or self._scans[0] is not self._state:
                self._scans = self._state, {}
            channel, kept = self._channel(channel), self._scans[1]
            if channel not in kept:
                kept[channel] = self._scanned(self._state, channel)
            return kept[channel]

    def scans(self) -> dict[str, Scan]:
        """The scans of all sensors of the rig, by their channels."""
        return {channel: self.scan(channel) for channel in self.rig.mounts}

    def cast(self, channel: str | None = None) -> RangeImage:
        """The clean returns of all sub-rays of a sensor in the sweep that ends now (`Sweeper.cast`)."""
        with self._alone():
            channel = self._channel(channel)
            return self._cast(self._state, channel, self._swept(self._state, channel))[0]

    def points(self, channel: str | None = None) -> np.ndarray:
        """`scan(channel).points()`: float32 [N, 3], in the sensor's frame in the middle of the sweep [m]."""
        return self.scan(channel).points()

    def _channel(self, channel: str | None) -> str:
        names = self.rig.mounts
        if channel is not None and channel not in names:
            raise UnknownNameError(f"channel is {channel!r}; it must be {one_of(names, channel)}")
        return next(iter(names)) if channel is None else channel

    def boxes(self) -> list[Box]:
        """The boxes of all instances now, in the world frame, with their velocities [m/s]."""
        with self._alone():
            things = ((self._thing(name, one), one) for name, one in self._state.actors.items() if name != EGO_NAME)
            return [box for thing, one in things for box in thing.boxes_at(one.spot, one.rate()[:3])]

    def layout(self) -> Layout:
        """The current layout."""
        with self._alone():
            return self._layout({name: actor.spot for name, actor in self._state.actors.items()})

    def _layout(self, spots: dict[str, Spot]) -> Layout:
        actors = ((name, actor) for name, actor in self._state.actors.items() if name != EGO_NAME)
        parts = tuple(part for name, actor in actors for part in self._thing(name, actor).parts_at(spots[name]))
        return dataclasses.replace(self._known, primitives=parts)

    def _swept(self, state: WorldState, channel: str) -> dict[str, Any]:
        """Pose, speed, yaw rate and heading of a sensor in the sweep that ends now, as in `Scan`."""
        mount, ego = self.rig.mounts[channel], state.actors[EGO_NAME].track()
        sweep = max(mount.sensor.sweep_time, FLASH)
        places = ego.at(state.time - np.array([sweep, mount.sensor.sweep_time / 2, 0.0])).tolist()
        on = upright(mount.spot[:3], mount.spot[3])
        begin, pose, end = (upright((x, y, z), yaw) @ on for x, y, z, yaw in places)
        rate = ((end - begin)[:3, 3] / sweep).tolist()
        speed = math.hypot(*rate)
        heading = {"heading": (rate[0] / speed, rate[1] / speed, rate[2] / speed)} if speed else {}
        return {"pose": pose, "speed": speed, "turn": (places[2][3] - places[0][3]) / sweep, **heading}

    def _cast(self, state: WorldState, channel: str, swept: dict[str, Any]) -> tuple[RangeImage, Surfaces]:
        """The clean returns, and their surfaces."""
        sensor = self.rig.mounts[channel].sensor
        still, moving = list[tuple[Thing, Actor]](), list[tuple[Thing, Actor]]()
        for name, actor in state.actors.items():
            if name != EGO_NAME:
                (moving if actor.past else still).append((self._thing(name, actor), actor))
        things = [thing for thing, _ in (*still, *moving)]
        if self._table is None or not _same(self._table[0], things):
            self._table = things, Surfaces.joined([thing.bodies.surfaces for thing in things])
        table, actors = self._table[1], [actor for _, actor in still]
        if self._still is None or not _same(self._still[0], actors):
            parts = [thing.bodies_at(actor.spot) for thing, actor in still]
            self._still = actors, Bodies.joined(parts, table, state.origin)
        poses = _poses(sensor, swept)
        times = state.time - sensor.sweep_time + sensor.column_times()
        first, movers = len(self._still[1].primitives), list[Mover]()
        for thing, actor in moving:
            places = actor.track().at(times)
            movers.append(Mover(thing.bodies, first, thing.home, radius_of(thing.body.size), places))
            first += len(thing.bodies.primitives)
        return self._sweepers[channel].cast(self._still[1], movers, poses, state.seed), table

    def _scanned(self, state: WorldState, channel: str) -> Scan:
        swept, sensor, on = self._swept(state, channel), self.rig.mounts[channel].sensor, self.rig.mounts[channel].spot
        sweep = sensor.sweep_time
        clean, table = self._cast(state, channel, swept)
        seed = (state.seed + state.steps + (list(self.rig.mounts).index(channel) << 40)) % 2**63
        spots, velocities = {name: actor.spot for name, actor in state.actors.items()}, {}
        for name, actor in state.actors.items():
            if actor.past and name != EGO_NAME:
                span = max(sweep, FLASH)
                begin, middle, end = actor.track().at(state.time - np.array([span, sweep / 2, 0.0]))
                spots[name] = tuple(middle.tolist())
                velocities[name] = tuple(((end - begin)[:3] / span).tolist())
        return Scan(
            image=self._sweepers[channel].observe(clean, table, _poses(self.rig.mounts[channel].sensor, swept), seed),
            layout=self._layout(spots),
            seed=seed,
            time=state.time - sweep / 2,
            velocities=velocities,
            mount=None if on == (0.0, 0.0, sensor.mount_height, 0.0) else on,
            assumed=(*self._assumed, *self._sweepers[channel].notes),
            **swept,
        )


def _poses(sensor: Sensor, swept: dict[str, Any]) -> np.ndarray:
    """world_from_sensor of each column of a sweep, [W, 4, 4]."""
    velocity = swept["speed"] * np.array(swept.get("heading", (0.0, 0.0, 0.0)))
    return sensor.poses_in_motion(swept["pose"], velocity, (0.0, 0.0, swept["turn"]))


def _same(some: Sequence[object], others: Sequence[object]) -> bool:
    return len(some) == len(others) and all(one is other for one, other in zip(some, others, strict=True))


def _check_number(things: int) -> None:
    if things > _MOST_THINGS:
        raise LayoutError(f"{things} objects; a world has {_MOST_THINGS} at most, with which a step takes seconds")


def _numbers(name: str, values: Any, count: int) -> tuple[float, ...]:
    values = values.tolist() if isinstance(values, np.ndarray) else values
    check_that(are_numbers(values, count), name, values, f"{count} finite numbers" if count > 1 else "a finite number")
    return tuple(map(float, values))
