"""Poses where another road meets the ego's: on the crossing road, in a turn, on the ring, before it, at its corners."""

from __future__ import annotations

import math

import numpy as np

from lidardraft.drafting.solver.road_pose import BACKWARDS, PoseSampler, RoadPose, alternate, turned
from lidardraft.scene.road import LEFT, RIGHT, RING, Road

# Estimates of ours.
STOP_LINE = 2.0  # m before the crossing road
_CORNER = (0.6, 3.0)  # m from the kerbs that meet there
_FROM_SIDE = 5.0  # m from the kerb that who comes from a side may be, at least
_TURN = (0.3, 0.8)  # shares of the quarter circle of a turn
_IN_TURN, _TURNED = 0.25, 30.0  # effort up to which who turns is still in the turn, and m behind it that one may be


def half_of(road: Road) -> float:
    """How far along the road the junction reaches from its middle [m], without sidewalks."""
    return road.edge if road.roundabout_radius is None else road.roundabout_radius


def on_crossing_road(road: Road, heading: str, sides: tuple[int, ...]) -> PoseSampler:
    """On the crossing road, before, in or after the junction; `along` is the middle of that road.

    On one of the `sides` only, a vehicle comes from there.
    """
    given = {"across-left": 1, "across-right": -1}.get(heading)
    reach = 0.0 if road.roundabout_radius is None else road.roundabout_radius + STOP_LINE

    def sample(rng: np.random.Generator, along: float, _number: int, effort: float) -> RoadPose:
        direction = 1 if rng.random() < 0.5 else -1
        far = min(8.0 + 30.0 * effort + reach, road.half_length - 8.0)
        far = max(far, road.edge + _FROM_SIDE) if len(sides) == 1 else far
        low = -far if RIGHT in road.side_roads else -road.edge / 2
        high = far if LEFT in road.side_roads else road.edge / 2
        if len(sides) == 1:
            nearest = min(-1.0, road.lane(road.ego_lane) - 0.5)  # to the right of the ego, wherever that drives
            low, high = (max(low, 1.0), high) if sides[0] > 0 else (low, max(low, min(high, nearest)))
            direction = -sides[0]
        direction = given or direction
        across = float(rng.uniform(low, high))
        if abs(across) < reach + 3.0 and reach:
            across += math.copysign(reach + 3.0, across)
        # beside a bend the road's frame is stretched, the crossing road is not
        lane = road.lane(0, 1) * direction / (1.0 - road.curvature * across)
        return RoadPose(along - lane, across, direction * math.pi / 2)

    return sample


def in_turn(road: Road, heading: str) -> PoseSampler:
    """On the quarter circle from a lane of the ego's direction, or from the opposite one, into the crossing road.

    The ego's road is left by the side that the junction has, by any where it has both.
    """
    given = {"turning-left": (LEFT,), "turning-right": (RIGHT,)}.get(heading, (LEFT, RIGHT))
    lane, far = -road.lane(0), road.edge + 1.0

    def sample(rng: np.random.Generator, along: float, _number: int, effort: float) -> RoadPose:
        ways = [(side, way) for side in given for way in ((1,) if road.one_way else (1, -1))]
        ways = [(side, way) for side, way in ways if side * way in road.side_roads] or ways
        side, way = ways[int(rng.integers(len(ways)))]
        turn = float(rng.uniform(*_TURN)) * math.pi / 2
        # forward and left as the driver sees it: from the lane to the right of one road into that of the other
        start, end = (-far - 3.0 * min(1.0, effort), -lane), (side * lane, side * far)
        forward, left = end[0] - start[0], end[1] - start[1]
        x, y = start[0] + forward * math.sin(turn), start[1] + left * (1.0 - math.cos(turn))
        yaw = math.atan2(left * math.sin(turn), forward * math.cos(turn))
        if effort > _IN_TURN and rng.random() < 0.7:  # the turn is full: just turned
            further = float(rng.uniform(0.0, _TURNED)) * min(1.0, effort)
            x, y, yaw = end[0], end[1] + side * further, side * math.pi / 2
        return RoadPose(along + way * x, way * y, turned(rng, yaw if way > 0 else yaw + BACKWARDS))

    return sample


def on_ring(road: Road) -> PoseSampler:
    """On the lane of a roundabout, counter-clockwise; `along` is the middle of the junction."""
    radius = road.island + RING / 2

    def sample(rng: np.random.Generator, along: float, _number: int, _effort: float) -> RoadPose:
        angle = float(rng.uniform(-math.pi, math.pi))
        return RoadPose(along + radius * math.cos(angle), radius * math.sin(angle), turned(rng, angle + math.pi / 2))

    return sample


def at_corner(road: Road, sides: tuple[int, ...]) -> PoseSampler:
    """On the sidewalk of the ego's road, next to the crossing road; `along` is the middle of the junction."""
    low, high = (road.edge + 0.4, road.verge - 0.4) if road.sidewalk > 0.9 else (road.verge + 0.4, road.verge + 2.0)
    clear = half_of(road) + max(road.sidewalk, 0.5)

    def sample(rng: np.random.Generator, along: float, number: int, effort: float) -> RoadPose:
        off = clear + float(rng.uniform(_CORNER[0], _CORNER[1] + 6.0 * min(1.0, effort)))
        end = -1.0 if rng.random() < 0.7 else 1.0
        across = alternate(sides, number) * float(rng.uniform(low, high))
        return RoadPose(along + end * off, across, float(rng.uniform(-math.pi, math.pi)))

    return sample


def before_and_after(sample_pose: PoseSampler, junction: float, sides: int) -> PoseSampler:
    """In turns before the junction, as the poses are that are given, and as far after it; first all `sides` of one."""

    def sample(rng: np.random.Generator, along: float, number: int, effort: float) -> RoadPose:
        pose = sample_pose(rng, along, number, effort)
        return (
            pose
            if number // sides % 2 == 0
            else pose._replace(along=2 * junction - pose.along, yaw=pose.yaw + BACKWARDS)
        )

    return sample
