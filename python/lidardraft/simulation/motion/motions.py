"""How objects move that no scenario names: as the sentence has it, else by their kind.

Vehicles and riders in a lane drive along it, those that are parked stand, people walk where their way is free.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from lidardraft.scene.check import VEHICLE_LABELS
from lidardraft.scene.intent import Asked, Intent
from lidardraft.scene.lane import Lane
from lidardraft.scene.layout import Layout
from lidardraft.scene.raycast import Raycaster
from lidardraft.scene.scenario import AlongLane, Motion, Straight, Walk
from lidardraft.scene.solids import Solid
from lidardraft.semantics import BY_NAME, GROUND
from lidardraft.simulation.motion.driving import Body, Driver, driver_of

DRIVES = frozenset({*VEHICLE_LABELS, "rider"})  # classes of what drives along lanes
_WALKING, _CLEAR, _STRIDE = 1.3, 0.6, 0.5  # m/s; m that stay free around who walks; m between places that are looked at
_SHORTEST_WALK = 2.0  # m; who has less room stands
_BESIDE_ROAD = 1.0  # m, how far who crosses a road goes on beside it
_HIGH = 500.0  # m, over all ground
_SOON = 1.0  # s after which who brakes or accelerates does so
_SLOW = 0.3  # share of its usual speed that who accelerates has before
_FASTER = 1.4  # times as fast as whom it overtakes
_TURNS = {"turning-left": ("left",), "turning-right": ("right",), "turning": ("left", "right")}


class Ground:
    """The ground of a layout, looked at from above."""

    def __init__(self, layout: Layout) -> None:
        self.caster = Raycaster(Layout(tuple(p for p in layout if p.label in GROUND)))

    def at(self, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Heights [m], 0 where there is none, and class ids [N] under places [N, 2 or more]."""
        origins = np.column_stack([places[:, :2], np.full(len(places), _HIGH)])
        hits = self.caster.cast(origins, np.tile((0.0, 0.0, -1.0), (len(places), 1)))
        return np.where(hits.valid, _HIGH - hits.distance, 0.0), hits.label


def usual_motions(
    intent: Intent,
    bodies: Mapping[str, Body],
    given: Mapping[str, Motion],
    lanes: Sequence[Lane],
    ground: Ground,
    duration: float,
) -> dict[str, Motion]:
    """The motions of all bodies that have none `given`, but for those that stand; first who is the first to give way:
    the ego vehicle after others, and what the sentence moves after the rest."""
    said = {name: intent.of(name) for name in bodies}
    crossing = {name for name, asked in said.items() if str(asked.heading).startswith("across")}
    found: dict[str, Motion] = {}
    for name, body in bodies.items():
        asked = said[name]
        if name in given or asked.heading == "parked" or asked.speed == 0.0:
            continue
        motion: Motion | None = None
        if body.labels & DRIVES:
            motion = _along_lane(body, asked, lanes)
        elif "person" in body.labels:
            together = crossing if name in crossing else {name}
            still = [other for one, other in bodies.items() if one not in together]
            motion = _free_walk(body, asked.speed or _WALKING, still, ground, duration, name in crossing)
        if motion is not None:
            found[name] = motion
    for name in ("ego", *intent.objects):
        if name in bodies and said[name].motion == "overtakes":
            others = [one for one in bodies if said[one].group in said[name].overtakes]
            _pass(name, others or ["ego"], {**given, **found}, found, bodies, lanes)

    def gives_way_late(name: str) -> tuple[bool, bool]:
        asked = said[name]
        moves = str(asked.heading) in _TURNS or asked.motion is not None or asked.speed is not None
        return name in crossing or moves, name == "ego"

    return {name: found[name] for name in sorted(found, key=gives_way_late)}


def _along_lane(body: Body, asked: Asked, lanes: Sequence[Lane]) -> Motion | None:
    """How a vehicle drives along its lane, if it is in one, as was asked."""
    heading, speed, motion = str(asked.heading), asked.speed, asked.motion
    straight = AlongLane(speed, overtakes=motion == "overtakes", gives_way=not heading.startswith("across"))
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


def _pass(
    name: str,
    others: Iterable[str],
    motions: Mapping[str, Motion],
    found: dict[str, Motion],
    bodies: Mapping[str, Body],
    lanes: Sequence[Lane],
) -> None:
    """Make somebody faster than others that it overtakes: those slower whose speed nobody says, else itself faster."""
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


def _free_walk(
    body: Body, speed: float, others: Iterable[Body], ground: Ground, duration: float, crosses: bool
) -> Walk | None:
    """The walk of a person ahead as far as its way is free: on the kind of ground that it is on, and across the road
    that it is on or `crosses`."""
    x, y, _, yaw = body.place
    steps = np.arange(0.0, max(speed * duration, _SHORTEST_WALK) + _STRIDE, _STRIDE)
    places = np.array([x, y]) + steps[:, None] * np.array([math.cos(yaw), math.sin(yaw)])
    _, label = ground.at(places)
    road, free = label == BY_NAME["road"].id, label == label[0]
    if road[0] or (crosses and road.any()):
        begin = int(np.argmax(road))
        end = begin + int(np.argmin(np.append(road[begin:], False)))
        free |= np.arange(len(free)) < end + _BESIDE_ROAD / _STRIDE
    for other in others:
        if math.dist(other.place[:2], (x, y)) < steps[-1] + max(other.size) + _CLEAR:
            for solid in other.solids:
                free &= ~_near(places, solid)
    end = int(np.argmin(free)) - 1 if not free.all() else len(free) - 1
    if steps[max(end, 0)] < (_STRIDE if crosses else _SHORTEST_WALK):
        return None
    return Walk((float(places[end, 0]), float(places[end, 1])), speed)


def _near(places: np.ndarray, solid: Solid) -> np.ndarray:
    """Whether a solid is near places [N, 2]."""
    turn = np.array([[solid.cos, -solid.sin], [solid.sin, solid.cos]])
    off = np.abs((places - solid[:2]) @ turn) - (solid.half_length, solid.half_width)
    near: np.ndarray = np.hypot(*np.maximum(off, 0.0).T) < _CLEAR
    return near
