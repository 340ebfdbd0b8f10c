"""Poses on the road itself, of what drives, walks, or is set down: in its lanes, along its edges, in its middle."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from lidardraft.drafting.solver.road_pose import BACKWARDS, PoseSampler, RoadPose, alternate, turned, walking_yaw
from lidardraft.drafting.solver.scene_spec import ObjectGroup
from lidardraft.drafting.solver.sentence_kinds import SentenceKind
from lidardraft.scene.road import Road

# Estimates of ours.
LANE_OFFSET = 0.15  # m from the middle of a lane, at most
_WALKER_OFF, _IN_LANE_OFF = 1.2, 0.3  # m, the same for who walks, and for what stands in the way


def each_lane(group: ObjectGroup, road: Road) -> list[tuple[int, int]]:
    """(number, direction) of all lanes that the heading of a group allows."""
    own, oncoming = [(n, 1) for n in range(road.lanes)], [(n, -1) for n in range(road.oncoming)]
    return {"with": own, "against": oncoming or own}.get(str(group.heading), own + oncoming)


def lanes_of(group: ObjectGroup, fore: str, side: str, road: Road) -> list[tuple[int, int]]:
    """(number, direction) of the lanes that fit, the ego's own first where it does."""
    if group.lane == "each":
        return each_lane(group, road)
    own = [(road.ego_lane, 1), *((n, 1) for n in range(road.lanes) if n != road.ego_lane)]
    oncoming = [(n, -1) for n in range(road.oncoming)]
    left, right = ([(n, d) for n, d in own if (n - road.ego_lane) * way > 0] for way in (1, -1))
    if group.lane is not None:
        leftmost = own[:0] if road.lanes == 1 and oncoming else [(road.lanes - 1, 1)]
        middle, rightmost = [(road.lanes // 2, 1)], [(0, 1)]
        named = {"own": own[:1], "left": leftmost, "middle": middle, "right": rightmost, "opposite": oncoming}
        return named[group.lane] or oncoming or own
    if group.heading == "against":
        return (right if side == "right" else []) or oncoming or own
    if side == "left":
        return left or oncoming or own
    if side == "right":
        return right or own[:1]
    if fore == "beside":
        return own[1:] or oncoming or own
    return own if fore or group.heading == "with" else own + oncoming


def in_turns(lanes: list[tuple[int, int]], sampler_of: Callable[[tuple[int, int]], PoseSampler]) -> PoseSampler:
    """In one lane after the other."""
    samplers = [sampler_of(lane) for lane in lanes]

    def sample(rng: np.random.Generator, along: float, number: int, effort: float) -> RoadPose:
        return samplers[number % len(samplers)](rng, along, number, effort)

    return sample


def in_lane(
    road: Road, lanes: list[tuple[int, int]], kind: SentenceKind, heading: str | None, side: str = ""
) -> PoseSampler:
    """Driving in one of the lanes, the first object in the first of them."""

    def sample(rng: np.random.Generator, along: float, number: int, effort: float) -> RoadPose:
        lane, direction = lanes[0] if number == 0 and effort < 0.5 else lanes[int(rng.integers(len(lanes)))]
        middle = road.lane(lane) * direction + float(rng.uniform(-LANE_OFFSET, LANE_OFFSET))
        if kind.cycles:  # keeps to the right of its lane, to the left only where the whole lane is the ego's
            to_the_left = side == "left" and (lane, direction) == (road.ego_lane, 1)
            middle -= (-1 if to_the_left else direction) * (road.lane_width / 2 - 0.7)
        direction = {"with": 1, "against": -1}.get(str(heading), direction)
        return RoadPose(along, middle, turned(rng, 0.0 if direction > 0 else BACKWARDS))

    return sample


def on_carriageway(road: Road, sides: tuple[int, ...], heading: str = "") -> PoseSampler:
    """On foot between the kerbs, on one of the `sides` only on that side of the ego."""

    def sample(rng: np.random.Generator, along: float, _number: int, _effort: float) -> RoadPose:
        low, high = (-(road.edge - 0.5), road.edge - 0.5 if road.median == 0.0 else -road.median / 2 - 0.5)
        if len(sides) == 1:
            ego = road.lane(road.ego_lane)
            low, high = (ego, high) if sides[0] > 0 else (low, max(low + 0.1, ego))
        yaw = walking_yaw(heading, rng)
        return RoadPose(along, float(rng.uniform(low, high)), yaw)

    return sample


def on_foot(group: ObjectGroup, fore: str, side: str, road: Road, aside: float = _WALKER_OFF) -> PoseSampler:
    """On foot, or set down, in the lanes that a group asks for, up to `aside` from their middle [m]."""
    lanes = lanes_of(group, fore, side, road)
    if group.lane == "each":
        return in_turns(lanes, lambda lane: in_lane_on_foot(road, [lane], aside))
    return in_lane_on_foot(road, lanes, aside)


def in_lane_on_foot(road: Road, lanes: list[tuple[int, int]], aside: float = _WALKER_OFF) -> PoseSampler:
    """On foot, or set down, in one of the lanes, up to `aside` from its middle [m]."""

    def sample(rng: np.random.Generator, along: float, _number: int, _effort: float) -> RoadPose:
        lane, direction = lanes[0] if len(lanes) == 1 else lanes[int(rng.integers(len(lanes)))]
        off = float(rng.uniform(-aside, aside))
        return RoadPose(along, direction * road.lane(lane) + off, float(rng.uniform(-math.pi, math.pi)))

    return sample


def set_down(
    group: ObjectGroup, kind: SentenceKind, fore: str, side: str, sides: tuple[int, ...], road: Road
) -> PoseSampler:
    """What stands on the road: in a lane, in the middle, or in a line along its edges; strips stand across it."""
    if group.lane is not None:
        sample_pose = on_foot(group, fore, side, road, _WALKER_OFF if kind.set_down else _IN_LANE_OFF)
    elif group.surface == "road" and not side:
        sample_pose = _in_middle(road)
    else:
        sample_pose = _road_edge(road, sides)
    if kind.set_down:
        return sample_pose

    def sample(rng: np.random.Generator, along: float, number: int, effort: float) -> RoadPose:
        pose = sample_pose(rng, along, number, effort)
        backwards = BACKWARDS if pose.across > 0 and not road.one_way else 0.0
        return pose._replace(yaw=math.pi / 2 if kind.follows_road else backwards)

    return sample


def _in_middle(road: Road) -> PoseSampler:
    """Near the centreline, or the middle of the ego's carriageway where there is a median."""
    ends = (-(road.edge - road.parking), -road.median / 2 if road.median else road.edge - road.parking)
    middle, half = (ends[0] + ends[1]) / 2, (ends[1] - ends[0]) / 2

    def sample(rng: np.random.Generator, along: float, _number: int, effort: float) -> RoadPose:
        off = min(half, 0.5 + half * effort) * float(rng.uniform(-1.0, 1.0))
        return RoadPose(along, middle + off, float(rng.uniform(-math.pi, math.pi)))

    return sample


def _road_edge(road: Road, sides: tuple[int, ...]) -> PoseSampler:
    """What is set down on the road: in a line along its edges."""

    def sample(rng: np.random.Generator, along: float, number: int, effort: float) -> RoadPose:
        side = alternate(sides, number)
        wide = road.edge - side * road.lane(road.ego_lane)  # to the ego
        off = float(rng.uniform(0.4, 0.5 + min(1.0, effort) * max(0.0, wide - 1.0)))
        return RoadPose(along, side * (road.edge - off), float(rng.uniform(-math.pi, math.pi)))

    return sample
