"""Where on and beside the road the objects of a group may be, as zones of the road's frame (along, across)."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from lidardraft.drafting.scene_spec import ObjectGroup, split_place
from lidardraft.drafting.sentence_kinds import SentenceKind
from lidardraft.scene.road import LEFT, RIGHT, Road

LANE_OFFSET = 0.15  # m from the middle of a lane, at most; estimate of ours
YAW_DEVIATION = 0.01  # rad, standard deviation of the heading in a lane or along a kerb; estimate of ours
NEAREST = 8.0  # m to the middle of what is in front or behind, where no distance is asked for; estimate of ours


class RoadPose(NamedTuple):
    """A place in the road's frame: along and across [m], and the yaw from the road's heading there [rad]."""

    along: float
    across: float
    yaw: float


PoseSampler = Callable[[np.random.Generator, float, int, float], RoadPose]


@dataclass(frozen=True, slots=True)
class Zone:
    """Where the objects of a group may be: from and to along the road [m], and how to sample a pose there.

    `sample_pose` gets the generator, a distance along, the number of the object, and an effort that rises from 0 to 1
    while nothing fits. `sides` counts the sides of the road that the objects take in turns.
    """

    span: tuple[float, float]
    sample_pose: PoseSampler
    sides: int = 1


def zone_of(group: ObjectGroup, kind: SentenceKind, place: str, road: Road) -> Zone:
    """The zone for an object of `kind` that the group wants at `place`, one of PLACES or ""."""
    fore, side = split_place(place)
    if group.distance is not None and not fore and "road" in kind.surfaces:
        fore = "front"
    sides = {"left": (1,), "right": (-1,)}.get(side, (1, -1))
    if group.crosses and road.junction is not None:
        return Zone((road.junction, road.junction), _crossing_lane(road))
    if kind.drives:
        if group.heading == "parked" or (
            side == "right" and road.ego_lane == 0 and kind.is_vehicle and not group.heading
        ):
            sample_pose = _kerb(road, sides) if kind.is_vehicle else _sidewalk(road, sides)
            return Zone(_span(group, fore, road, 45.0), sample_pose, len(sides))
        if group.surface == "sidewalk":
            return Zone(_span(group, fore, road, 45.0), _sidewalk(road, sides), len(sides))
        return Zone(
            _span(group, fore, road, 45.0 if fore else 60.0), _lane(road, _lanes(group, fore, side, road), kind)
        )
    if kind.walks:
        return _person(group, fore, side, sides, road)
    span = _span(group, fore, road, 65.0)
    if group.surface == "sidewalk":
        return Zone(span, _sidewalk(road, sides), len(sides))
    lateral = group.distance if not fore else None
    if kind.at_junction and road.junction is not None and not fore and lateral is None:
        span = (road.junction - road.edge - 5.0, road.junction - road.edge - 1.0)
    return Zone(span, _roadside(kind, road, sides, lateral), len(sides))


def _span(group: ObjectGroup, fore: str, road: Road, usual: float) -> tuple[float, float]:
    """The range along the road; a single distance for several objects is where the first of them stands."""
    near, far = NEAREST, usual
    if group.record.is_vehicle:
        far = min(road.half_length - 10.0, max(far, queue_length(group)))
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
    if isinstance(group.count, int):  # a few objects are seen best close by
        usual = min(usual, 15.0 + 10.0 * group.count)
    return -usual, usual


def queue_length(group: ObjectGroup) -> float:
    """How far a lane with all the vehicles of a group reaches [m]."""
    count = group.count if isinstance(group.count, int) else 4
    return NEAREST + count * group.record.lane_length


def _lanes(group: ObjectGroup, fore: str, side: str, road: Road) -> list[tuple[int, int]]:
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


def _lane(road: Road, lanes: list[tuple[int, int]], kind: SentenceKind) -> PoseSampler:
    def sample(rng: np.random.Generator, along: float, number: int, effort: float) -> RoadPose:
        lane, direction = lanes[0] if number == 0 and effort < 0.5 else lanes[int(rng.integers(len(lanes)))]
        middle = road.lane(lane, direction) + float(rng.uniform(-LANE_OFFSET, LANE_OFFSET))
        if kind.cycles:  # keeps to the right of its lane
            middle -= direction * (road.lane_width / 2 - 0.7)
        return RoadPose(along, middle, (0.0 if direction > 0 else math.pi) + float(rng.normal(0.0, YAW_DEVIATION)))

    return sample


def _crossing_lane(road: Road) -> PoseSampler:
    """On the crossing road, before, in or after the junction; `along` is the middle of that road."""

    def sample(rng: np.random.Generator, along: float, _number: int, effort: float) -> RoadPose:
        direction = 1 if rng.random() < 0.5 else -1
        far = 8.0 + 30.0 * effort
        low = -far if RIGHT in road.side_roads else -road.edge / 2
        high = far if LEFT in road.side_roads else road.edge / 2
        across = float(rng.uniform(low, high))
        # beside a bend the road's frame is stretched, the crossing road is not
        lane = road.lane(0, direction) / (1.0 - road.curvature * across)
        return RoadPose(along - lane, across, direction * math.pi / 2)

    return sample


def _kerb(road: Road, sides: tuple[int, ...]) -> PoseSampler:
    def sample(rng: np.random.Generator, along: float, number: int, _effort: float) -> RoadPose:
        side = _alternate(sides, number)
        turned = rng.random() < 0.1
        middle = side * (road.edge - road.parking / 2)
        return RoadPose(
            along, middle, (math.pi if (side > 0) != turned else 0.0) + float(rng.normal(0.0, YAW_DEVIATION))
        )

    return sample


def _sidewalk(road: Road, sides: tuple[int, ...]) -> PoseSampler:
    low, high = (road.edge + 0.4, road.verge - 0.4) if road.sidewalk > 0.9 else (road.verge + 0.4, road.verge + 2.0)

    def sample(rng: np.random.Generator, along: float, number: int, _effort: float) -> RoadPose:
        turn = float(rng.choice([0.0, math.pi])) + float(rng.normal(0.0, 0.2))
        return RoadPose(along, _alternate(sides, number) * float(rng.uniform(low, high)), turn)

    return sample


def _person(group: ObjectGroup, fore: str, side: str, sides: tuple[int, ...], road: Road) -> Zone:
    """People walk on the sidewalk, unless they cross, are wanted on the road, or are simply in front or behind."""
    if group.heading == "across":
        span = _span(group, fore or "front", road, 35.0)
        if road.junction is not None and group.distance is None and fore in ("", "front"):
            span = (road.junction - road.verge - 2.0, road.junction - road.edge - 0.5)
        return Zone(span, _carriageway(road, sides, math.pi / 2))
    if group.surface == "road":
        return Zone(_span(group, fore, road, 35.0), _carriageway(road, sides, 0.0))
    if group.surface is None and fore in ("front", "behind") and not side:
        return Zone(_span(group, fore, road, 35.0), _ego_lane(road))
    return Zone(_span(group, fore, road, 40.0), _sidewalk(road, sides), len(sides))


def _carriageway(road: Road, sides: tuple[int, ...], turn: float) -> PoseSampler:
    def sample(rng: np.random.Generator, along: float, _number: int, _effort: float) -> RoadPose:
        low, high = (-(road.edge - 0.5), road.edge - 0.5)
        if len(sides) == 1:
            low, high = (0.0, high) if sides[0] > 0 else (low, 0.0)
        yaw = turn * float(rng.choice([-1, 1])) + float(rng.normal(0.0, 0.2))
        return RoadPose(along, float(rng.uniform(low, high)), yaw)

    return sample


def _ego_lane(road: Road) -> PoseSampler:
    def sample(rng: np.random.Generator, along: float, _number: int, _effort: float) -> RoadPose:
        return RoadPose(
            along, road.lane(road.ego_lane) + float(rng.uniform(-1.2, 1.2)), float(rng.uniform(-math.pi, math.pi))
        )

    return sample


def _roadside(
    kind: SentenceKind, road: Road, sides: tuple[int, ...], distance: tuple[float, float] | None
) -> PoseSampler:
    """Behind the verge, or right at the kerb for what has no setback; `distance` [m] from the ego overrules both."""
    ego, setback = road.lane(road.ego_lane), kind.setback

    def sample(rng: np.random.Generator, along: float, number: int, effort: float) -> RoadPose:
        side = _alternate(sides, number)
        turn = (0.0 if side > 0 else math.pi) + (
            float(rng.normal(0.0, kind.yaw_deviation)) if kind.yaw_deviation else 0.0
        )
        if distance is not None:
            return RoadPose(along, ego + side * float(rng.uniform(*distance)), turn)
        if setback is None:
            return RoadPose(along, side * (road.edge + 0.5 if road.sidewalk > 0.9 else road.verge + 0.6), turn)
        farthest = setback.usual + (setback.farthest - setback.usual) * effort
        return RoadPose(along, side * (road.verge + float(rng.uniform(setback.nearest, farthest))), turn)

    return sample


def _alternate(sides: tuple[int, ...], number: int) -> int:
    return sides[number % len(sides)]
