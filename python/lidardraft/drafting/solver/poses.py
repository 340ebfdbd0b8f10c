"""Poses in the frame of a road: in its lanes and bays, at junctions, at the kerb, on the sidewalk and behind it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple, TypeVar

import numpy as np

from lidardraft.arranging.car_parks import AISLE_WIDTH, BAY_LENGTH, BAY_WIDTH
from lidardraft.drafting.solver.scene_spec import ObjectGroup
from lidardraft.objects.coarse_shapes import STANDING, CoarseShape
from lidardraft.objects.sentence_kind import SentenceKind
from lidardraft.scene.road import LEFT, RIGHT, RING, Road

BACKWARDS = math.pi  # rad, against the ego's direction
# Estimates.
YAW_DEVIATION = 0.01  # rad, standard deviation of the heading in a lane or along a kerb
LANE_OFFSET = 0.15  # m from the middle of a lane, at most
_WALKER_OFF, _IN_LANE_OFF = 1.2, 0.3  # m, the same for people, and for obstacles
STOP_LINE = 2.0  # m before the crossing road
_CORNER = (0.6, 3.0)  # m from the kerbs that meet at a corner
_FROM_SIDE = 5.0  # m from the kerb, the least for traffic from a side
_TURN = (0.3, 0.8)  # shares of the quarter circle of a turn
_IN_TURN, _TURNED = 0.25, 30.0  # the largest effort for a place in the turn; and m behind it, at most
_NOSE_IN = 0.75  # share of the vehicles in bays
_FULL = (0.5, 0.8)  # the share of the bays in the first rows that "many" vehicles fill
_OFF_MIDDLE = 0.1  # m along a bay, at most
_AISLE_OFF = 2.0  # m from the middle of an aisle for people, at most
_MEDIAN_OFF = 0.15  # of its width from the middle of a median, at most
_DEEPEST = 105.0  # m behind the sidewalk, for hundreds of objects
LOT_DEPTH = 3 * BAY_LENGTH + AISLE_WIDTH  # m from the ego's aisle: two rows back to back, an aisle, a row
LOT_DEPTHS = (LOT_DEPTH, 2 * BAY_LENGTH, BAY_LENGTH)  # m, of three rows, two, and one
_ROWS = ((0.5 * BAY_LENGTH, -1), (1.5 * BAY_LENGTH, 1), (LOT_DEPTH - 0.5 * BAY_LENGTH, -1))  # m; the side of the aisle

Lane = tuple[int, int]  # number and direction, 1 for the ego's, else -1
T = TypeVar("T")


class RoadPose(NamedTuple):
    """A place in the road's frame: along and across [m], and the yaw from the road's heading there [rad]."""

    along: float
    across: float
    yaw: float


class Try(NamedTuple):
    """One try for a pose: a distance along the road [m], the number of the object, and an effort that rises from 0 to 1
    while nothing fits."""

    rng: np.random.Generator
    along: float
    number: int
    effort: float

    def uniform(self, low: float, high: float) -> float:
        """A uniform random number between two others."""
        return float(self.rng.uniform(low, high))

    def one_of(self, choices: Sequence[T]) -> T:
        """One of some choices, at random."""
        return choices[int(self.rng.integers(len(choices)))]

    def side(self, sides: Sequence[int]) -> int:
        """The side of this object, if several objects alternate between the sides."""
        return sides[self.number % len(sides)]

    def turned(self, yaw: float) -> float:
        """A yaw [rad] with the precision of drivers."""
        return yaw + float(self.rng.normal(0.0, YAW_DEVIATION))

    def any_yaw(self) -> float:
        """A yaw [rad] for an object without a direction."""
        return self.uniform(-math.pi, math.pi)

    def walking_yaw(self, heading: str) -> float:
        """The yaw [rad] of a pedestrian: across the road, one way or the other, if the heading says so, else along
        it."""
        way = {"across-left": 1, "across-right": -1}.get(heading) or int(self.rng.choice([-1, 1]))
        return (math.pi / 2 if heading.startswith("across") else 0.0) * way + float(self.rng.normal(0.0, 0.2))


PoseSampler = Callable[[Try], RoadPose]


def each_lane(group: ObjectGroup, road: Road) -> list[Lane]:
    """All lanes that the heading of a group allows."""
    own, oncoming = [(n, 1) for n in range(road.lanes)], [(n, -1) for n in range(road.oncoming)]
    return {"with": own, "against": oncoming or own}.get(str(group.heading), own + oncoming)


def lanes_of(group: ObjectGroup, fore: str, side: str, road: Road) -> list[Lane]:
    """The lanes that fit, the ego's own first if it does."""
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
        the_wrong_way = right or (own[:1] if group.record.cycles else [])
        return (the_wrong_way if side == "right" else []) or oncoming or own
    if side == "left":
        return left or oncoming or own
    if side == "right":
        return right or own[:1]
    if fore == "beside":
        return own[1:] or oncoming or own
    return own if fore or group.heading == "with" else own + oncoming


def in_turns(samplers: Sequence[PoseSampler], at: Try) -> RoadPose:
    """A pose from the samplers in turn."""
    return samplers[at.number % len(samplers)](at)


def in_lane(road: Road, lanes: list[Lane], kind: SentenceKind, heading: str | None, side: str, at: Try) -> RoadPose:
    """Driving in one of the lanes; the first object is in the first lane."""
    lane, direction = lanes[0] if at.number == 0 and at.effort < 0.5 else at.one_of(lanes)
    middle = road.lane(lane) * direction + at.uniform(-LANE_OFFSET, LANE_OFFSET)
    if kind.cycles:  # keeps to the right of its lane; to the left only in the ego's lane
        to_the_left = side == "left" and (lane, direction) == (road.ego_lane, 1)
        middle -= (-1 if to_the_left else direction) * (road.lane_width / 2 - 0.7)
    direction = {"with": 1, "against": -1}.get(str(heading), direction)
    return RoadPose(at.along, middle, at.turned(0.0 if direction > 0 else BACKWARDS))


def on_carriageway(road: Road, sides: tuple[int, ...], heading: str, at: Try) -> RoadPose:
    """On foot between the kerbs; with one of the `sides` only, on that side of the ego."""
    low, high = (-(road.edge - 0.5), road.edge - 0.5 if road.median == 0.0 else -road.median / 2 - 0.5)
    if len(sides) == 1:
        ego = road.lane(road.ego_lane)
        low, high = (ego, high) if sides[0] > 0 else (low, max(low + 0.1, ego))
    yaw = at.walking_yaw(heading)
    return RoadPose(at.along, at.uniform(low, high), yaw)


def on_foot(road: Road, lanes: list[Lane], group: ObjectGroup, at: Try) -> RoadPose:
    """On foot, or set down, near the middle of one of the lanes."""
    lanes = [lanes[at.number % len(lanes)]] if group.lane == "each" else lanes
    lane, direction = lanes[0] if len(lanes) == 1 else at.one_of(lanes)
    aside = _WALKER_OFF if group.record.set_down or group.record.walks else _IN_LANE_OFF
    return RoadPose(at.along, direction * road.lane(lane) + at.uniform(-aside, aside), at.any_yaw())


def set_down(group: ObjectGroup, fore: str, side: str, sides: tuple[int, ...], road: Road, at: Try) -> RoadPose:
    """Objects on the road: in a lane, in the middle, or in a line along its edges; strips lie across it."""
    if group.lane is not None:
        pose = on_foot(road, lanes_of(group, fore, side, road), group, at)
    elif group.surface == "road" and not side:
        pose = _in_middle(road, at)
    else:
        pose = _road_edge(road, sides, at)
    if group.record.set_down:
        return pose
    backwards = BACKWARDS if pose.across > 0 and not road.one_way else 0.0
    return pose._replace(yaw=math.pi / 2 if group.record.follows_road else backwards)


def _in_middle(road: Road, at: Try) -> RoadPose:
    """Near the centreline, or near the middle of the ego's carriageway if there is a median."""
    ends = (-(road.edge - road.parking), -road.median / 2 if road.median else road.edge - road.parking)
    middle, half = (ends[0] + ends[1]) / 2, (ends[1] - ends[0]) / 2
    off = min(half, 0.5 + half * at.effort) * at.uniform(-1.0, 1.0)
    return RoadPose(at.along, middle + off, at.any_yaw())


def _road_edge(road: Road, sides: tuple[int, ...], at: Try) -> RoadPose:
    side = at.side(sides)
    wide = road.edge - side * road.lane(road.ego_lane)  # to the ego
    off = at.uniform(0.4, 0.5 + min(1.0, at.effort) * max(0.0, wide - 1.0))
    return RoadPose(at.along, side * (road.edge - off), at.any_yaw())


def at_kerb(road: Road, sides: tuple[int, ...], at: Try) -> RoadPose:
    """Parked at the kerb, a tenth of them in the other direction."""
    side = at.side(sides)
    other_way = at.rng.random() < 0.1
    backwards = (side > 0 and not road.one_way) != other_way
    return RoadPose(at.along, side * (road.edge - road.parking / 2), at.turned(BACKWARDS if backwards else 0.0))


def in_median(group: ObjectGroup, road: Road, at: Try) -> RoadPose:
    """Along the strip between the directions."""
    backwards = group.heading == "against"
    yaw = at.walking_yaw(str(group.heading)) if group.record.walks else BACKWARDS if backwards else 0.0
    along_it = group.record.follows_road or group.record.drives
    off = 0.0 if along_it else at.uniform(-_MEDIAN_OFF, _MEDIAN_OFF) * road.median
    return RoadPose(at.along, off, yaw)


def on_sidewalk(road: Road, sides: tuple[int, ...], at: Try) -> RoadPose:
    """Along the sidewalk."""
    yaw = float(at.rng.choice([0.0, math.pi])) + float(at.rng.normal(0.0, 0.2))
    return RoadPose(at.along, at.side(sides) * at.uniform(*_walkway(road)), yaw)


def beside_road(
    kind: SentenceKind, road: Road, sides: tuple[int, ...], distance: tuple[float, float] | None, at: Try
) -> RoadPose:
    """Behind the verge, or right at the kerb for kinds without a setback; `distance` [m] from the ego overrides
    both."""
    side, setback = at.side(sides), kind.setback
    turned = float(at.rng.normal(0.0, kind.yaw_deviation)) if kind.yaw_deviation else 0.0
    yaw = (0.0 if side > 0 else math.pi) + turned
    verge = lot_edge(road, side) if road.paved_areas else road.verge
    if distance is not None:
        return RoadPose(at.along, road.lane(road.ego_lane) + side * at.uniform(*distance), yaw)
    if setback is None:
        return RoadPose(at.along, side * (road.edge + 0.5 if road.sidewalk > 0.9 else verge + 0.6), yaw)
    nearest, usual, farthest = setback
    off = at.uniform(nearest, min(_DEEPEST, usual + (farthest - usual) * at.effort))
    return RoadPose(at.along, side * (verge + off), yaw)


def aside(group: ObjectGroup, road: Road, sides: tuple[int, ...], at: Try) -> RoadPose:
    """Level with the ego, at a distance from the middle of its lane."""
    across = road.lane(road.ego_lane) + at.side(sides) * at.uniform(*(group.distance or (0.0, 0.0)))
    yaw = at.any_yaw() if not group.record.drives else BACKWARDS if group.heading == "against" else 0.0
    return RoadPose(at.along, across, yaw)


def set_back(group: ObjectGroup, kind: SentenceKind, road: Road, sides: tuple[int, ...], at: Try) -> RoadPose:
    """The near side at a distance from the kerb or the sidewalk."""
    side, off = at.side(sides), at.uniform(*(group.from_road or group.from_sidewalk or (0.0, 0.0)))
    inwards = _lies_inwards(group)
    base = road.edge if inwards else lot_edge(road, side) + (road.sidewalk if group.from_road is None else 0.0)
    backwards = side > 0 and not (kind.drives and road.one_way)
    return RoadPose(at.along, side * (base - off if inwards else base + off), BACKWARDS if backwards else 0.0)


def with_near_side_at(group: ObjectGroup, pose: RoadPose, parts: list[CoarseShape]) -> RoadPose:
    """The pose moved so that the near side of the parts on the ground is at the place of the middle."""
    cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
    out = math.copysign(1.0, pose.across) * (-1.0 if _lies_inwards(group) else 1.0)
    near = [
        out * (sin * part.center[0] + cos * part.center[1]) - (abs(sin) * part.size[0] + abs(cos) * part.size[1]) / 2
        for part in parts
        if part.center[2] - part.size[2] / 2 < STANDING
    ]
    return pose._replace(across=pose.across - out * min(near, default=0.0))


def _lies_inwards(group: ObjectGroup) -> bool:
    """Whether a distance from the kerb is measured towards the middle of the road."""
    return group.record.drives or group.surface == "road"


def _walkway(road: Road) -> tuple[float, float]:
    """The walkway beside the road, from and to across, from the centreline [m]."""
    return (road.edge + 0.4, road.verge - 0.4) if road.sidewalk > 0.9 else (road.verge + 0.4, road.verge + 2.0)


def half_of(road: Road) -> float:
    """Half the extent of the junction along the road [m], without sidewalks."""
    return road.edge if road.roundabout_radius is None else road.roundabout_radius


def on_crossing_road(road: Road, heading: str, sides: tuple[int, ...], at: Try) -> RoadPose:
    """On the crossing road, before, in or after the junction; `at.along` is the middle of that road.

    With one of the `sides` only, a vehicle comes from that side.
    """
    reach = 0.0 if road.roundabout_radius is None else road.roundabout_radius + STOP_LINE
    direction = 1 if at.rng.random() < 0.5 else -1
    far = min(8.0 + 30.0 * at.effort + reach, road.half_length - 8.0)
    far = max(far, road.edge + _FROM_SIDE) if len(sides) == 1 else far
    low = -far if RIGHT in road.side_roads else -road.edge / 2
    high = far if LEFT in road.side_roads else road.edge / 2
    if len(sides) == 1:
        nearest = min(-1.0, road.lane(road.ego_lane) - 0.5)  # to the right of the ego, in any lane
        low, high = (max(low, 1.0), high) if sides[0] > 0 else (low, max(low, min(high, nearest)))
        direction = -sides[0]
    direction = {"across-left": 1, "across-right": -1}.get(heading, direction)
    across = at.uniform(low, high)
    if abs(across) < reach + 3.0 and reach:
        across += math.copysign(reach + 3.0, across)
    # beside a bend the road's frame is stretched, but the crossing road is not
    lane = road.lane(0, 1) * direction / (1.0 - road.curvature * across)
    return RoadPose(at.along - lane, across, direction * math.pi / 2)


def in_turn(road: Road, heading: str, at: Try) -> RoadPose:
    """On the quarter circle from a lane of the ego's direction, or of the opposite one, into the crossing road.

    The turn uses the side road of the junction, or either if there are two.
    """
    given = {"turning-left": (LEFT,), "turning-right": (RIGHT,)}.get(heading, (LEFT, RIGHT))
    lane, far, effort = -road.lane(0), road.edge + 1.0, min(1.0, at.effort)
    ways = [(side, way) for side in given for way in ((1,) if road.one_way else (1, -1))]
    side, way = at.one_of([(side, way) for side, way in ways if side * way in road.side_roads] or ways)
    turn = at.uniform(*_TURN) * math.pi / 2
    # forward and left of the driver: from the right-hand lane of one road into that of the other
    start, end = (-far - 3.0 * effort, -lane), (side * lane, side * far)
    forward, left = end[0] - start[0], end[1] - start[1]
    x, y = start[0] + forward * math.sin(turn), start[1] + left * (1.0 - math.cos(turn))
    yaw = math.atan2(left * math.sin(turn), forward * math.cos(turn))
    if at.effort > _IN_TURN and at.rng.random() < 0.7:  # the turn is full: behind it
        x, y, yaw = end[0], end[1] + side * (at.uniform(0.0, _TURNED) * effort), side * math.pi / 2
    return RoadPose(at.along + way * x, way * y, at.turned(yaw if way > 0 else yaw + BACKWARDS))


def on_ring(road: Road, at: Try) -> RoadPose:
    """On the lane of a roundabout, counter-clockwise; `at.along` is the middle of the junction."""
    radius, angle = road.island + RING / 2, at.any_yaw()
    return RoadPose(at.along + radius * math.cos(angle), radius * math.sin(angle), at.turned(angle + math.pi / 2))


def at_corner(road: Road, sides: tuple[int, ...], at: Try) -> RoadPose:
    """On the sidewalk of the ego's road, next to the crossing road; `at.along` is the middle of the junction."""
    off = half_of(road) + max(road.sidewalk, 0.5) + at.uniform(_CORNER[0], _CORNER[1] + 6.0 * min(1.0, at.effort))
    end = -1.0 if at.rng.random() < 0.7 else 1.0
    return RoadPose(at.along + end * off, at.side(sides) * at.uniform(*_walkway(road)), at.any_yaw())


def before_and_after(sample_pose: PoseSampler, junction: float, sides: int, at: Try) -> RoadPose:
    """Alternately at the given poses before the junction, and as far after it; first all `sides` of one."""
    pose = sample_pose(at)
    if at.number // sides % 2 == 0:
        return pose
    return pose._replace(along=2 * junction - pose.along, yaw=pose.yaw + BACKWARDS)


def lot_edge(road: Road, side: int) -> float:
    """The distance of a car park's far edge on a side (1, -1) from the centreline [m]; that of the kerb without one."""
    return max([road.edge, *(side * across for area in road.paved_areas for across in area.across)])


def row_poses(road: Road, side: int) -> list[tuple[float, float]]:
    """`across` [m] and yaw [rad] of vehicles parked nose in, for each row of bays on a side of a car park."""
    depth = lot_edge(road, side) - road.edge
    rows = [(off, aisle) for off, aisle in _ROWS if off < depth]
    return [(side * (road.edge + off), side * aisle * math.pi / 2) for off, aisle in rows]


def sample_full(road: Road, rng: np.random.Generator) -> int:
    """The number of vehicles that fill the first rows of a car park."""
    start, end = road.paved_areas[0].along
    return int(2 * (end - start) / BAY_WIDTH * float(rng.uniform(*_FULL)))


def in_bay(kind: SentenceKind, road: Road, sides: tuple[int, ...], exactly: bool, at: Try) -> RoadPose:
    """In the bay nearest to a distance along, row by row as they fill; a vehicle too long for a bay is along a row.

    For objects `exactly` at a distance, bays begin anywhere.
    """
    assert kind.sizes is not None
    rows = row_poses(road, at.side(sides))
    across, nose_in = rows[min(len(rows) - 1, int(at.rng.random() * (1.0 + len(_ROWS) * at.effort)))]
    if kind.sizes.largest[0] > BAY_LENGTH + 0.5:
        return RoadPose(at.along, across, at.turned(0.0))
    start, end = road.paved_areas[0].along
    bay = min(int((end - start) / BAY_WIDTH) - 1, max(0, int((at.along - start) / BAY_WIDTH)))
    middle = start + (bay + 0.5) * BAY_WIDTH + at.uniform(-_OFF_MIDDLE, _OFF_MIDDLE)
    yaw = nose_in if at.rng.random() > _NOSE_IN else -nose_in
    return RoadPose(at.along if exactly else middle, across, at.turned(yaw))


def in_aisle(road: Road, sides: tuple[int, ...], at: Try) -> RoadPose:
    """On foot in an aisle of the car park."""
    side, further = at.side(sides), road.edge + 2 * BAY_LENGTH + AISLE_WIDTH / 2
    far = at.rng.random() < 0.3 + 0.4 * at.effort and lot_edge(road, side) > further
    beside = min(max(0.5, side * road.lane(road.ego_lane) + 0.1), road.edge - 0.1)  # of the ego
    across = further + at.uniform(-_AISLE_OFF, _AISLE_OFF) if far else at.uniform(beside, road.edge)
    return RoadPose(at.along, side * across, at.any_yaw())
