"""Where on and beside the road a kind of thing belongs, as ranges of the road's frame (along, across)."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from lidardraft.drafting.sentence_kinds import SENTENCE_KINDS, SentenceKind
from lidardraft.drafting.spec import Group, SceneSpec
from lidardraft.errors import LayoutError
from lidardraft.scene.check import MAX_RANGE
from lidardraft.scene.road import LEFT, RIGHT, Road

HARD_SHOULDER = 3.0  # m, estimate of ours
LANE_OFFSET = 0.15  # m from the middle of a lane, at most; estimate of ours
YAW_DEVIATION = 0.01  # rad, standard deviation of the heading in a lane or along a kerb; estimate of ours
NEAR = 8.0  # m; the nearest that the middle of a thing in front or behind may be without a distance asked for

Spot = tuple[float, float, float]  # along [m], across [m], turn [rad] from the road's heading
Pick = Callable[[np.random.Generator, float, int, float], Spot]


@dataclass(frozen=True, slots=True)
class Site:
    """A range along the road [m], how many sides of it, and the pick of a spot there.

    The pick gets the generator, a distance along, the number of the thing, and an effort that rises from 0 to 1 while
    nothing fits.
    """

    span: tuple[float, float]
    pick: Pick
    sides: int = 1


def lay_road(spec: SceneSpec, rng: np.random.Generator) -> Road:
    """The road of a plan, with room for everything that the plan puts on it."""
    kind = spec.road.kind
    motorway = kind == "motorway"
    lanes = spec.road.lanes or (int(rng.choice([2, 3])) if motorway else int(rng.choice([1, 2], p=[0.75, 0.25])))
    farthest = max((group.distance[1] for group in spec.groups if group.distance), default=0.0)
    if farthest > MAX_RANGE - 10.0:
        raise LayoutError(f"distance is {farthest:g} m; things can be asked for up to {MAX_RANGE - 10.0:g} m away")
    queue = max((_queue(group) for group in spec.groups if SENTENCE_KINDS[group.kind].is_vehicle), default=0.0)
    half_length = max(80.0, farthest + 15.0, min(MAX_RANGE - 10.0, queue + 10.0))
    wanted = spec.road.sidewalk
    sidewalk = float(rng.uniform(1.8, 3.0)) if wanted or (wanted is None and not motorway) else 0.0
    bend = {"left-bend": 1.0, "right-bend": -1.0, "bend": float(rng.choice([-1, 1]))}.get(kind, 0.0)
    crossing = kind in ("crossroads", "t-junction") or any(_crosses(group) for group in spec.groups)
    lane_width = 3.75 if motorway else float(rng.uniform(3.3, 3.7))
    parking = HARD_SHOULDER if motorway else _parking(spec, lanes)
    near = lanes * lane_width + parking + sidewalk + 6.0
    return Road(
        lanes=lanes,
        ego_lane=1 if lanes > 1 and any(_on_the_right(group) for group in spec.groups) else 0,
        lane_width=lane_width,
        parking=parking,
        sidewalk=sidewalk,
        curvature=bend / float(rng.uniform(90.0, 160.0)),
        junction=float(rng.uniform(near, near + 12.0)) if crossing else None,
        side_roads=(int(rng.choice([LEFT, RIGHT])),) if kind == "t-junction" else (LEFT, RIGHT),
        half_length=half_length,
    )


def site_of(group: Group, kind: SentenceKind, place: str, road: Road) -> Site:
    """Where things of a kind go that a group wants at a place."""
    fore, side = _split(place)
    if group.distance is not None and not fore and "road" in kind.surfaces:
        fore = "front"
    sides = {"left": (1,), "right": (-1,)}.get(side, (1, -1))
    if _crosses(group) and road.junction is not None:
        return Site((road.junction, road.junction), _crossing_lane(road))
    if kind.drives:
        if group.heading == "parked" or (
            side == "right" and road.ego_lane == 0 and kind.is_vehicle and not group.heading
        ):
            pick = _kerb(road, sides) if kind.is_vehicle else _sidewalk(road, sides)
            return Site(_span(group, fore, road, 45.0), pick, len(sides))
        if group.surface == "sidewalk":
            return Site(_span(group, fore, road, 45.0), _sidewalk(road, sides), len(sides))
        return Site(
            _span(group, fore, road, 45.0 if fore else 60.0), _lane(road, _lanes(group, fore, side, road), kind)
        )
    if kind.walks:
        return _person(group, fore, side, sides, road)
    span = _span(group, fore, road, 65.0)
    if group.surface == "sidewalk":
        return Site(span, _sidewalk(road, sides), len(sides))
    lateral = group.distance if not fore else None
    if kind.at_junction and road.junction is not None and not fore and lateral is None:
        span = (road.junction - road.edge - 5.0, road.junction - road.edge - 1.0)
    return Site(span, _roadside(kind, road, sides, lateral), len(sides))


def _split(place: str) -> tuple[str, str]:
    fore, _, side = place.partition("-")
    return ("", fore) if fore in ("left", "right") else (fore, side)


def _crosses(group: Group) -> bool:
    return group.heading == "across" and SENTENCE_KINDS[group.kind].drives


def _on_the_right(group: Group) -> bool:
    right = any(_split(place)[1] == "right" for place in group.places)
    return right and SENTENCE_KINDS[group.kind].drives and group.heading in (None, "with")


def _parking(spec: SceneSpec, lanes: int) -> float:
    parked = [
        SENTENCE_KINDS[group.kind]
        for group in spec.groups
        if group.heading == "parked" or (lanes == 1 and _on_the_right(group))
    ]
    return max((kind.parking_width for kind in parked if kind.is_vehicle), default=0.0)


def _span(group: Group, fore: str, road: Road, usual: float) -> tuple[float, float]:
    """The range along the road; a single distance for several things is where the first of them stands."""
    near, far = NEAR, usual
    if SENTENCE_KINDS[group.kind].is_vehicle:
        far = min(road.half_length - 10.0, max(far, _queue(group)))
    if group.distance is not None and fore in ("front", "behind"):
        near, far = group.distance
        if near == far and group.count != 1:
            far = min(road.half_length - 10.0, near + 10.0 * (group.count if isinstance(group.count, int) else 4))
    if fore == "front":
        return near, far
    if fore == "behind":
        return -near, -far
    if fore == "beside":
        return -4.0, 4.0
    if isinstance(group.count, int):  # a few things are seen best close by
        usual = min(usual, 15.0 + 10.0 * group.count)
    return -usual, usual


def _queue(group: Group) -> float:
    """How far a lane with all the vehicles of a group reaches [m]."""
    count = group.count if isinstance(group.count, int) else 4
    return NEAR + count * SENTENCE_KINDS[group.kind].lane_length


def _lanes(group: Group, fore: str, side: str, road: Road) -> list[tuple[int, int]]:
    """(number, direction) of the lanes that fit, the ego's own first where it does."""
    own = [(road.ego_lane, 1), *((n, 1) for n in range(road.lanes) if n != road.ego_lane)]
    oncoming = [(n, -1) for n in range(road.lanes)]
    if group.heading == "against":
        return oncoming
    if side == "left":
        left = [(n, d) for n, d in own if n > road.ego_lane]
        return left or ([] if group.heading == "with" else oncoming) or own
    if side == "right":
        return [(n, d) for n, d in own if n < road.ego_lane] or own
    if fore == "beside":
        return own[1:] or oncoming
    return own if fore or group.heading == "with" else own + oncoming


def _lane(road: Road, lanes: list[tuple[int, int]], kind: SentenceKind) -> Pick:
    def pick(rng: np.random.Generator, along: float, number: int, effort: float) -> Spot:
        lane, direction = lanes[0] if number == 0 and effort < 0.5 else lanes[int(rng.integers(len(lanes)))]
        middle = road.lane(lane, direction) + float(rng.uniform(-LANE_OFFSET, LANE_OFFSET))
        if kind.cycles:  # keeps to the right of its lane
            middle -= direction * (road.lane_width / 2 - 0.7)
        return along, middle, (0.0 if direction > 0 else math.pi) + float(rng.normal(0.0, YAW_DEVIATION))

    return pick


def _crossing_lane(road: Road) -> Pick:
    """On the crossing road, before, in or after the junction; `along` is the middle of that road."""

    def pick(rng: np.random.Generator, along: float, _number: int, effort: float) -> Spot:
        direction = 1 if rng.random() < 0.5 else -1
        far = 8.0 + 30.0 * effort
        low = -far if RIGHT in road.side_roads else -road.edge / 2
        high = far if LEFT in road.side_roads else road.edge / 2
        return along - road.lane(0, direction), float(rng.uniform(low, high)), direction * math.pi / 2

    return pick


def _kerb(road: Road, sides: tuple[int, ...]) -> Pick:
    def pick(rng: np.random.Generator, along: float, number: int, _effort: float) -> Spot:
        side = _alternate(sides, number)
        turned = rng.random() < 0.1
        middle = side * (road.edge - road.parking / 2)
        return along, middle, (math.pi if (side > 0) != turned else 0.0) + float(rng.normal(0.0, YAW_DEVIATION))

    return pick


def _sidewalk(road: Road, sides: tuple[int, ...]) -> Pick:
    low, high = (road.edge + 0.4, road.verge - 0.4) if road.sidewalk > 0.9 else (road.verge + 0.4, road.verge + 2.0)

    def pick(rng: np.random.Generator, along: float, number: int, _effort: float) -> Spot:
        turn = float(rng.choice([0.0, math.pi])) + float(rng.normal(0.0, 0.2))
        return along, _alternate(sides, number) * float(rng.uniform(low, high)), turn

    return pick


def _person(group: Group, fore: str, side: str, sides: tuple[int, ...], road: Road) -> Site:
    """People walk on the sidewalk, unless they cross, are wanted on the road, or are simply in front or behind."""
    if group.heading == "across":
        span = _span(group, fore or "front", road, 35.0)
        if road.junction is not None and group.distance is None and fore in ("", "front"):
            span = (road.junction - road.verge - 2.0, road.junction - road.edge - 0.5)
        return Site(span, _carriageway(road, sides, math.pi / 2))
    if group.surface == "road":
        return Site(_span(group, fore, road, 35.0), _carriageway(road, sides, 0.0))
    if group.surface is None and fore in ("front", "behind") and not side:
        return Site(_span(group, fore, road, 35.0), _ego_lane(road))
    return Site(_span(group, fore, road, 40.0), _sidewalk(road, sides), len(sides))


def _carriageway(road: Road, sides: tuple[int, ...], turn: float) -> Pick:
    def pick(rng: np.random.Generator, along: float, _number: int, _effort: float) -> Spot:
        low, high = (-(road.edge - 0.5), road.edge - 0.5)
        if len(sides) == 1:
            low, high = (0.0, high) if sides[0] > 0 else (low, 0.0)
        yaw = turn * float(rng.choice([-1, 1])) + float(rng.normal(0.0, 0.2))
        return along, float(rng.uniform(low, high)), yaw

    return pick


def _ego_lane(road: Road) -> Pick:
    def pick(rng: np.random.Generator, along: float, _number: int, _effort: float) -> Spot:
        return along, road.lane(road.ego_lane) + float(rng.uniform(-1.2, 1.2)), float(rng.uniform(-math.pi, math.pi))

    return pick


def _roadside(kind: SentenceKind, road: Road, sides: tuple[int, ...], distance: tuple[float, float] | None) -> Pick:
    """Behind the verge, or right at the kerb for what has no setback; `distance` [m] from the ego overrules both."""
    ego, setback = road.lane(road.ego_lane), kind.setback

    def pick(rng: np.random.Generator, along: float, number: int, effort: float) -> Spot:
        side = _alternate(sides, number)
        turn = (0.0 if side > 0 else math.pi) + (
            float(rng.normal(0.0, kind.yaw_deviation)) if kind.yaw_deviation else 0.0
        )
        if distance is not None:
            return along, ego + side * float(rng.uniform(*distance)), turn
        if setback is None:
            return along, side * (road.edge + 0.5 if road.sidewalk > 0.9 else road.verge + 0.6), turn
        farthest = setback.usual + (setback.farthest - setback.usual) * effort
        return along, side * (road.verge + float(rng.uniform(setback.nearest, farthest))), turn

    return pick


def _alternate(sides: tuple[int, ...], number: int) -> int:
    return sides[number % len(sides)]
