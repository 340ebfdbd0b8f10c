"""The tracks of all objects in a layout: as a scenario says, or as they would move by themselves (`motions`)."""

from __future__ import annotations

import dataclasses
import itertools
import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import PchipInterpolator

from lidardraft.errors import LayoutError
from lidardraft.scene.box import Box
from lidardraft.scene.check import EGO, EGO_SIZE, OVERLAP_TOLERANCE, VEHICLE_LABELS, objects
from lidardraft.scene.lane import Lane
from lidardraft.scene.layout import Layout, Primitive, box_around
from lidardraft.scene.scenario import AlongLane, Motion, Scenario, Straight, Track, Walk, Waypoints
from lidardraft.scene.solids import Solid, penetration
from lidardraft.semantics import BY_NAME
from lidardraft.simulation.motion.driver import Body, Driver, driver_of
from lidardraft.simulation.motion.driving import STEP, drive
from lidardraft.simulation.motion.motions import Ground, usual_motions
from lidardraft.simulation.motion.right_of_way import RightOfWay
from lidardraft.simulation.roads import with_known_roads

_REACHED = 1.9  # m over the ground: objects pass under higher parts
_SMOOTH = 6  # steps before and after one over which tracks of people and heights are smooth
_WAITS = 1.0  # s after another has passed
_CHECKED = 0.1  # s between the checks for collisions


@dataclass(frozen=True, slots=True, eq=False)
class Tracks:
    """The track of the ego vehicle on the road, and those of the middles of all objects that move."""

    ego: Track
    actors: Mapping[str, Track]

    def scenario(self) -> Scenario:
        """The scenario of these tracks: way-points for all moving objects, while the rest stands."""
        points = {name: _waypoints(track) for name, track in self.actors.items()}
        return Scenario(_waypoints(self.ego), {**points, "*": Straight(0.0)})


def tracks_of(layout: Layout, scenario: Scenario, duration: float, speed: float | None = None) -> Tracks:
    """The tracks of a layout's objects over `duration` [s].

    If the scenario leaves the ego vehicle open, it drives along its lane with `speed` [m/s], by default that of the
    sentence or the road. An object that the scenario does not name starts later or stands if it would collide.
    Raises `LayoutError` if the scenario names an unknown object or one without a lane to drive along, if objects
    collide, or if a vehicle leaves the road.
    """
    roads, ground = with_known_roads(layout).roads, Ground(layout)
    bodies = bodies_of(objects(layout), ground)
    scenario.check_names(list(bodies))
    lanes = () if roads is None else roads.ways()
    rules = RightOfWay(roads, lanes)
    given = {name: motion for name in bodies if (motion := scenario.of(name)) is not None}
    if scenario.ego is not None and speed is not None:
        raise LayoutError(f"speed is {speed:g}, and the scenario says how the ego vehicle moves; give one of them")
    bodies["ego"] = EGO_BODY
    if scenario.ego is not None:
        given["ego"] = scenario.ego
    elif speed is not None:
        in_lane = driver_of(EGO_BODY, AlongLane(), lanes) is not None
        given["ego"] = AlongLane(speed) if in_lane and speed >= 0.0 else Straight(speed)
    free = usual_motions(layout.intent, bodies, given, rules, ground, duration)
    while True:
        tracks = _moved({"ego": Straight(0.0), **given, **free}, bodies, lanes, rules, ground, duration)
        collisions = _collisions(tracks, bodies, duration)
        changed = dict[str, Motion | None]()
        for pair, time in collisions:
            some = sorted((name for name in free if name in pair), key=lambda one: not isinstance(free[one], Walk))
            passes = all(name in tracks and tracks[name].moves() for name in pair)
            changed |= {name: _later(free[name], time) if passes else None for name in some[:1]}
        if not changed:
            break
        free = {name: motion for name, old in free.items() if (motion := changed.get(name, old)) is not None}
    for (one, other), time in collisions:
        raise LayoutError(f"{one} and {other} collide after {time:.1f} s; change the motion of one of them")
    _warn_off_map(given, ground)
    _check_on_road(tracks, bodies, {name for name in given if not isinstance(given[name], AlongLane)}, ground)
    return Tracks(tracks.pop("ego"), {name: track for name, track in tracks.items() if track.moves()})


def _later(motion: Motion, time: float) -> Motion | None:
    """The motion, delayed until after a collision at a time [s]; None (standing) if it would begin later anyway."""
    if isinstance(motion, AlongLane | Walk) and motion.start < time:
        return dataclasses.replace(motion, start=time + _WAITS)
    return None


def bodies_of(parts: Mapping[str, list[Primitive]], ground: Ground) -> dict[str, Body]:
    """Objects of these parts by name. Others can pass under crowns, but collide with trunks."""
    boxes = {name: box_around(some) for name, some in parts.items()}
    floors = ground.at(np.array([box.center for box in boxes.values()]).reshape(-1, 3))[0].tolist()
    return {
        name: _body(name, parts[name], box, floor) for (name, box), floor in zip(boxes.items(), floors, strict=True)
    }


def _body(name: str, parts: list[Primitive], box: Box, floor: float) -> Body:
    hard = [part for part in parts if part.label != "vegetation"] or parts
    low = (part for part in hard if part.center[2] - part.size[2] / 2 < floor + _REACHED)
    labels = frozenset(part.label for part in parts)
    return Body(name, labels, (*box.center, box.yaw), box.size, tuple(map(Solid.from_primitive, low)))


_EGO = _body("ego", [EGO], box_around([EGO]), 0.0)
EGO_BODY = dataclasses.replace(_EGO, place=(0.0, 0.0, 0.0, 0.0), size=EGO_SIZE)


def _moved(
    motions: Mapping[str, Motion],
    bodies: Mapping[str, Body],
    lanes: Sequence[Lane],
    rules: RightOfWay,
    ground: Ground,
    duration: float,
) -> dict[str, Track]:
    """The tracks on the ground of all objects with a motion."""
    times = np.arange(math.ceil(duration / STEP) + 2) * STEP  # two at least, as rates need
    others, walks, drivers = dict[str, Track](), dict[str, Walk](), list[Driver]()
    for name, motion in motions.items():
        if isinstance(motion, AlongLane):
            driver = driver_of(bodies[name], motion, lanes)
            if driver is None:
                raise LayoutError(f"{name} stands in no lane that it could drive along; give it way-points")
            drivers.append(driver)
        elif isinstance(motion, Walk) and motion.crosses:
            walks[name] = motion
        elif name == "ego" or motion != Straight(0.0):
            others[name] = _track(motion, bodies[name].place, times)
    tracks = others | drive(drivers, others, walks, bodies, times, rules)
    rises = {driver.body.name for driver in drivers if driver.lane.line.heights.any()}
    for name, track in tracks.items():
        home = np.array([bodies[name].place])
        if name in rises:
            track.places[:, 2] += home[0, 2] - track.places[0, 2]
        else:
            track.places[:, 2] = home[0, 2] + _heights(track.places, ground) - ground.at(home)[0]
        smooth = slice(None) if isinstance(motions[name], Walk) else slice(2, 3)
        track.places[:, smooth] = _smooth(track.places)[:, smooth]
    return tracks


def _track(motion: Straight | Walk | Waypoints, place: tuple[float, float, float, float], times: np.ndarray) -> Track:
    """The track of an object that follows no lane; heights are added later."""
    x, y, _, yaw = place
    if isinstance(motion, Waypoints):
        return through(np.array(motion.points), yaw, times)
    heading, way = yaw, motion.speed * times
    if isinstance(motion, Walk):
        heading = math.atan2(motion.to[1] - y, motion.to[0] - x)
        way = np.clip(motion.speed * (times - motion.start), 0.0, math.dist(motion.to, (x, y)))
        yaw += math.remainder(heading - yaw, math.tau)
    flat = np.zeros_like(times)
    return Track(times, np.stack([x + way * math.cos(heading), y + way * math.sin(heading), flat, flat + yaw], axis=1))


def _heights(places: np.ndarray, ground: Ground) -> np.ndarray:
    """The heights of the ground [K]; off the map the last ones."""
    heights, label = ground.at(places)
    known = np.flatnonzero(label)
    return np.interp(np.arange(len(label)), known, heights[known]) if len(known) else heights


def _warn_off_map(motions: Mapping[str, Motion], ground: Ground) -> None:
    """A `UserWarning` reports the first way-points off the map."""
    for name, motion in motions.items():
        if isinstance(motion, Waypoints) and 0 in (on := ground.at(np.array(motion.points)[:, 1:3])[1]) and on.any():
            _, x, y, *_ = motion.points[int(np.argmin(on))]
            said = f"{name} goes off the map, to x {x:.1f}, y {y:.1f} m; without ground it keeps its height"
            warnings.warn(said, stacklevel=4)
            return


def _smooth(places: np.ndarray) -> np.ndarray:
    """Places [K, 4] without jumps, such as at kerbs and stops: means over the places before and after."""
    wide = np.pad(places, ((_SMOOTH, _SMOOTH), (0, 0)), mode="reflect", reflect_type="odd")
    smooth: np.ndarray = np.lib.stride_tricks.sliding_window_view(wide, 2 * _SMOOTH + 1, axis=0).mean(axis=-1)
    return smooth


def through(points: np.ndarray, yaw: float, times: np.ndarray) -> Track:
    """The smooth track through way-points [K, 3 or 4] of an object that has `yaw` before it moves."""
    if points.shape[1] == 4:
        points[:, 3] = np.unwrap(points[:, 3])
    when = np.clip(times, points[0, 0], points[-1, 0])
    rows = points[:, 1:] if len(points) == 1 else PchipInterpolator(points[:, 0], points[:, 1:])(when)
    rows = np.broadcast_to(rows, (len(times), points.shape[1] - 1))
    if points.shape[1] == 3:
        steps = np.gradient(rows, axis=0)
        goes = np.linalg.norm(steps, axis=1) > 0.02 * STEP
        known = np.flatnonzero(goes)
        headings = np.unwrap(np.arctan2(steps[known, 1], steps[known, 0])) if len(known) else np.array([yaw])
        looks = np.interp(np.arange(len(times)), known if len(known) else [0], headings)
        rows = np.column_stack([rows, looks])
    return Track(times, np.column_stack([rows[:, :2], np.zeros(len(times)), rows[:, 2]]))


def _collisions(
    tracks: Mapping[str, Track], bodies: Mapping[str, Body], duration: float
) -> list[tuple[tuple[str, str], float]]:
    """The pairs that collide, with the time [s]; pairs that touch at the start are left out."""
    times = np.arange(0.0, duration + 1e-9, _CHECKED)
    at = {name: track.at(times) for name, track in tracks.items() if name == "ego" or track.moves()}
    standing = [body for name, body in bodies.items() if name not in at]
    found = list[tuple[tuple[str, str], float]]()
    for one, other in itertools.chain(
        itertools.combinations(at, 2), ((name, body.name) for name in at for body in standing)
    ):
        there = at[other] if other in at else np.array([bodies[other].place])
        reach = sum(math.hypot(*bodies[name].size[:2]) for name in (one, other)) / 2
        for k in np.flatnonzero(np.hypot(*(at[one] - there)[:, :2].T) < reach).tolist():
            solids = (_solid(bodies[other], there[k]),) if other in at else bodies[other].solids
            mine = _solid(bodies[one], at[one][k])
            if any(penetration(mine, solid) > OVERLAP_TOLERANCE for solid in solids):
                if k:
                    found.append(((one, other), float(times[k])))
                break
    return found


def _solid(body: Body, place: np.ndarray) -> Solid:
    x, y, z, yaw = place.tolist()
    bottom = z if body is EGO_BODY else z - body.size[2] / 2
    return Solid.box(x, y, yaw, body.size[:2], bottom, bottom + body.size[2])


def _check_on_road(tracks: Mapping[str, Track], bodies: Mapping[str, Body], named: set[str], ground: Ground) -> None:
    """Raises `LayoutError` if a vehicle that follows no lane starts on a road and leaves it with its whole width."""
    for name in named & set(tracks):
        if name != "ego" and not bodies[name].labels & set(VEHICLE_LABELS):
            continue
        track = tracks[name]
        left = np.column_stack([-np.sin(track.places[:, 3]), np.cos(track.places[:, 3])]) * bodies[name].size[1] / 2
        across = (ground.at(track.places[:, :2] + side * left)[1] for side in (-1, 0, 1))
        road = np.any([label == BY_NAME["road"].id for label in across], axis=0)
        if road[0] and not road.all():
            k = int(np.argmin(road))
            x, y = track.places[k, :2]
            raise LayoutError(f"{name} leaves the road after {track.times[k]:.1f} s, at x {x:.1f} m, y {y:.1f} m")


def _waypoints(track: Track) -> Waypoints:
    rows = np.column_stack([track.times, track.places[:, [0, 1, 3]]]).round(4)  # tenths of a millimetre
    return Waypoints(tuple(map(tuple, rows.tolist())))
