"""The zones of the objects of a group on and beside the road, in the road's frame (along, across)."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from functools import partial

from lidardraft.drafting.solver.poses import (
    STOP_LINE,
    PoseSampler,
    RoadPose,
    Try,
    aside,
    at_corner,
    at_kerb,
    before_and_after,
    beside_road,
    half_of,
    in_aisle,
    in_bay,
    in_lane,
    in_median,
    in_turn,
    in_turns,
    lanes_of,
    on_carriageway,
    on_crossing_road,
    on_foot,
    on_ring,
    on_sidewalk,
    set_back,
    set_down,
)
from lidardraft.drafting.solver.scene_spec import ObjectGroup, split_place
from lidardraft.objects.sentence_kind import SentenceKind
from lidardraft.scene.check import EGO_SIZE
from lidardraft.scene.road import Road

# Estimates.
NEAREST = 8.0  # m to the middle of an object in front or behind, without a requested distance
_CLEAR = 0.3  # m between a row and a road that crosses it
QUEUE_BEFORE = 25.0  # m before a junction that count as "at" it
# m along the road that a vehicle is beside the ego, and the share that stays there if only its side is asked for
_ALONGSIDE, _STAYS = 7.0, 0.25


@dataclass(frozen=True, slots=True)
class Zone:
    """The zone of the objects of a group: from and to along the road [m], and a sampler of poses there.

    `sides` counts the sides of the road between which the objects alternate.
    """

    span: tuple[float, float]
    sample_pose: PoseSampler
    sides: int = 1

    def grown(self, effort: int, road: Road) -> Zone:
        """The zone with a longer span, for objects that found no room in this one."""
        near, far = self.span
        if near == far or not effort:
            return self
        limit, more = road.half_length - 10.0, 0.4 * effort * (far - near)
        low = max(-limit, near - more) if near < 0 < far else near
        return dataclasses.replace(self, span=(low, min(limit, far + more) if far > near else max(-limit, far + more)))

    def in_row(self, length: float, road: Road, later: float, *, around: bool) -> Zone:
        """The zone with a span that begins at the start of a row of that `length` [m].

        The ego is in the middle of a row that may be `around` it; `later` [m] is limited by the length of the road.
        """
        near, far = self.span
        if around and near < 0 < far:
            near = -length / 2
        room = road.half_length - near - length if near < far else later
        return dataclasses.replace(self, span=(near + math.copysign(min(later, max(0.0, room)), far - near), far))


def zone_of(group: ObjectGroup, kind: SentenceKind, place: str, road: Road) -> Zone:
    """The zone for an object of `kind` that the group has at `place`, one of PLACES or ""."""
    fore, side = split_place(place)
    if group.distance is not None and not fore and group.on_road:
        fore = "front"
    comes = group.heading == "against" and group.lane is None  # traffic that has passed the ego is behind it
    in_the_way = (group.lane is not None or group.surface == "road") and not (kind.drives or kind.walks)
    if (comes or in_the_way) and not fore and "front" not in group.not_places:
        fore = "front"
    if not side:
        side = "right" if "left" in group.not_places else "left" if "right" in group.not_places else ""
    sides = {"left": (1,), "right": (-1,)}.get(side, (1, -1))
    if road.junction is not None:
        zone = _junction_zone(group, kind, sides, road, road.junction)
        if zone is not None:
            return zone
    if group.surface == "median":
        return Zone(_span(group, fore, road, 65.0), partial(in_median, group, road), 1)
    if fore == "beside" and group.distance is not None:
        return Zone((-1.5, 1.5), partial(aside, group, road, sides), len(sides))
    if group.set_back and kind.drives and not side and group.heading in ("with", "against"):
        sides = (-1,) if group.heading == "with" else (1,)
    if group.set_back:
        return Zone(_span(group, fore, road, 45.0), partial(set_back, group, kind, road, sides), len(sides))
    if group.goes_across:
        return _across(group, fore, sides, road)
    if kind.drives:
        return _driven(group, kind, fore, side, sides, road)
    if kind.walks:
        return _person(group, fore, side, sides, road)
    span = _span(group, fore, road, 65.0)
    if group.surface == "sidewalk":
        return Zone(span, partial(on_sidewalk, road, sides), len(sides))
    if group.on_road:
        in_row = group.spacing is not None or group.distance is not None
        if kind.set_down and fore in ("front", "behind") and not side and in_row:
            sides = (-1,)  # objects that begin at a place ahead are one row
        lanes = lanes_of(group, fore, side, road) if group.lane == "each" else ()
        rows = len(lanes or sides) if group.lane in (None, "each") else 1
        return Zone(span, partial(set_down, group, fore, side, sides, road), rows)
    lateral = group.distance if not fore else None
    sample_pose: PoseSampler = partial(beside_road, kind, road, sides, lateral)
    if kind.at_junction and road.junction is not None and not fore and lateral is None:
        span = (road.junction - half_of(road) - 5.0, road.junction - half_of(road) - 1.0)
        sample_pose = partial(before_and_after, sample_pose, road.junction, len(sides))
    return Zone(span, sample_pose, len(sides))


def _junction_zone(
    group: ObjectGroup, kind: SentenceKind, sides: tuple[int, ...], road: Road, junction: float
) -> Zone | None:
    """The zone at the junction with another road, if the group belongs there."""
    if group.crosses:
        heading = {1: "across-left", -1: "across-right"}[group.way_across or 1] if group.distance else group.heading
        return Zone((junction, junction), partial(on_crossing_road, road, str(heading), sides))
    if group.turns:
        if road.roundabout_radius is not None:
            return Zone((junction, junction), partial(on_ring, road))
        return Zone((junction, junction), partial(in_turn, road, str(group.heading)))
    if not group.at_junction or kind.at_junction:
        return None
    if group.goes_across:
        return None
    if kind.walks:
        return Zone((junction, junction), partial(at_corner, road, sides), len(sides))
    if kind.drives and group.heading != "parked":
        if road.roundabout_radius is not None and group.heading is None:
            return Zone((junction, junction), partial(on_ring, road))
        stop = junction - half_of(road) - STOP_LINE
        lanes = lanes_of(group, "front", "left" if sides == (1,) else "right" if sides == (-1,) else "", road)
        span = (stop - 3.0, max(NEAREST, stop - QUEUE_BEFORE))
        return Zone(span, partial(in_lane, road, lanes, kind, group.heading, ""))
    near = junction - half_of(road) - road.sidewalk
    if kind.drives:
        return Zone((near - 4.0, near - QUEUE_BEFORE), partial(at_kerb, road, sides), len(sides))
    sample_pose = partial(before_and_after, partial(beside_road, kind, road, sides, None), junction, len(sides))
    return Zone((near - 1.0, near - 15.0), sample_pose, len(sides))


def _driven(group: ObjectGroup, kind: SentenceKind, fore: str, side: str, sides: tuple[int, ...], road: Road) -> Zone:
    """The zone for vehicles: a lane, the kerb, a bay, or the sidewalk."""
    span = _span(group, fore, road, 45.0)
    if road.paved_areas and group.lane is None and group.heading in (None, "parked") and fore != "beside":
        exactly = group.distance is not None or group.spacing is not None
        return Zone(_in_lot(span, road), partial(in_bay, kind, road, sides, exactly), len(sides))
    if group.surface == "sidewalk":
        return Zone(span, partial(on_sidewalk, road, sides), len(sides))
    stands = side == "right" and road.ego_lane == 0 and kind.is_vehicle and not group.heading
    few = not fore and kind.is_vehicle and group.spacing is None and group.fewest in (1, 2, 3)
    if group.lane is None and (group.heading == "parked" or stands):
        sample_pose: PoseSampler = partial(at_kerb if kind.is_vehicle else on_sidewalk, road, sides)
        return Zone(span, partial(_seldom_alongside, sample_pose) if few else sample_pose, len(sides))
    if not fore:
        span = _span(group, fore, road, 60.0)
    lanes = lanes_of(group, fore, side, road)
    if group.lane == "each":
        each = [partial(in_lane, road, [lane], kind, group.heading, "") for lane in lanes]
        return Zone(span, partial(in_turns, each))
    sample_pose = partial(in_lane, road, lanes, kind, group.heading, side)
    return Zone(span, partial(_seldom_alongside, sample_pose) if few else sample_pose)


def _seldom_alongside(sample_pose: PoseSampler, at: Try) -> RoadPose:
    """The pose, mostly further ahead or behind where it is beside the ego, as vehicles seldom are."""
    if abs(at.along) < _ALONGSIDE and at.rng.random() > _STAYS:
        at = at._replace(along=at.along + math.copysign(_ALONGSIDE, at.along))
    return sample_pose(at)


def _in_lot(span: tuple[float, float], road: Road) -> tuple[float, float]:
    """The part of a span along a car park."""
    start, end = road.paved_areas[0].along
    near, far = (min(max(along, start + 1.5), end - 1.5) for along in span)
    return (near, far) if near != far or span[0] == span[1] else span


def _span(group: ObjectGroup, fore: str, road: Road, usual: float) -> tuple[float, float]:
    """The range along the road; a single distance for several objects is that of the first."""
    near, far = NEAREST, usual
    if group.record.is_vehicle:
        far = min(road.half_length - 10.0, max(far, queue_length(group)))
    if group.distance is not None and fore in ("front", "behind"):
        near, far = group.distance
        if near == far and group.fewest != 1:
            far = min(road.half_length - 10.0, near + _row_step(group) * (group.fewest or 4))
    if fore == "front":
        return near, far
    if fore == "behind":
        return -near, -far
    if fore == "beside":
        return -4.0, 4.0
    if group.fewest is not None:  # a few objects are best visible close by
        usual = min(usual, 15.0 + 10.0 * group.fewest)
    return -usual, usual


def _row_step(group: ObjectGroup) -> float:
    """The step from one object to the next [m], for those that begin at one distance; people are side by side."""
    if group.record.drives:
        return 10.0 if group.record.sizes is None else group.record.sizes.largest[0] + 5.0
    return 0.8 if group.record.walks else 6.0


def queue_length(group: ObjectGroup) -> float:
    """The reach of a lane with all the vehicles of a group [m]."""
    count = group.count if isinstance(group.count, int) else 4
    return NEAREST + count * group.record.lane_length


def _across(group: ObjectGroup, fore: str, sides: tuple[int, ...], road: Road) -> Zone:
    """Pedestrians cross the road before the junction, if there is one."""
    span = _span(group, fore or "front", road, 35.0)
    if road.junction is not None and group.distance is None and fore in ("", "front"):
        half = half_of(road)
        span = (road.junction - (half + road.sidewalk) - 2.0, road.junction - half - 0.5)
    return Zone(span, partial(on_carriageway, road, sides, str(group.heading)))


def _person(group: ObjectGroup, fore: str, side: str, sides: tuple[int, ...], road: Road) -> Zone:
    """People walk on the sidewalk, unless they are requested on the road, or simply in front or behind."""
    if group.surface == "road":
        return Zone(_span(group, fore, road, 35.0), partial(on_carriageway, road, sides, ""))
    if group.lane is not None:
        return Zone(_span(group, fore, road, 35.0), partial(on_foot, road, lanes_of(group, fore, side, road), group))
    if group.surface is None and fore in ("front", "behind") and not side:
        return Zone(_span(group, fore, road, 35.0), partial(on_foot, road, [(road.ego_lane, 1)], group))
    if road.paved_areas:
        return Zone(_in_lot(_span(group, fore, road, 40.0), road), partial(in_aisle, road, sides), len(sides))
    return Zone(_span(group, fore, road, 40.0), partial(on_sidewalk, road, sides), len(sides))


def along_row(group: ObjectGroup, road: Road, start: float, step: float, number: int) -> float:
    """The place of an object along [m] in a row that begins at `start`; beside the road it skips a crossing road."""
    half, place = ((group.size or (None,))[0] or 0.0) / 2, 0
    while True:
        along = start + place * step
        free = group.on_road or not road.in_junction(along, half + _CLEAR)
        if free and number == 0:
            return along
        number -= free
        place += 1


def measured_from(effort: float) -> tuple[float, bool]:
    """How much further than requested an object is [m], and whether the distance is that of its near end, as `effort`
    rises to just under 1.

    The middle is at the distance; if there is no room, the near end is; at last the distance counts from the ego's
    bumper.
    """
    return ((0.0, False), (0.0, False), (0.0, True), (EGO_SIZE[0] / 2, True))[int(4 * effort)]
