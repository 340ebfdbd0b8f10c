"""The road of a spec, with room for all of its objects."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from lidardraft.arranging.district import SETTINGS
from lidardraft.drafting.solver.poses import LOT_DEPTHS
from lidardraft.drafting.solver.road_zones import queue_length
from lidardraft.drafting.solver.scene_spec import MAX_LANES, NEAREST_JUNCTION, ObjectGroup, SceneSpec, split_place
from lidardraft.errors import LayoutError
from lidardraft.scene.check import MAX_RANGE
from lidardraft.scene.road import LEFT, PARKING_STRIP, RIGHT, RING, PavedArea, Road

HARD_SHOULDER, MEDIAN = 3.0, 4.0  # m, of motorways: an estimate, and the German RAA (2008)
MAX_DISTANCE = MAX_RANGE - 10.0  # m, the largest distance of an object in a request
_LONGEST_QUEUE = 110.0  # m, the largest length of a road for objects without a distance: an estimate
AISLE_LANE = 3.0  # m; the aisle of a parking lot is 6 m wide (EAR 05)
_LOT_LENGTH = (60.0, 90.0)  # m, an estimate
_WIDEST_LANE = 3.7  # m, of the usual ones
_PARKED = 2.0  # m further to the right than in a lane; estimate


def road_from_spec(spec: SceneSpec, rng: np.random.Generator, effort: int = 0) -> Road:
    """A road in the ego's frame; the properties that the spec leaves open are sampled.

    A larger `effort` makes open extents larger, for objects that found no room before. Raises `LayoutError` on a
    distance beyond the range of sensors, on a sidewalk in a car park, and on a median without two directions of as many
    lanes.
    """
    kind = spec.road.kind
    motorway, lot, narrow = kind == "motorway", kind == "parking-lot", spec.district == "alley"
    if lot and (spec.road.sidewalk or any(g.surface == "sidewalk" or g.from_sidewalk for g in spec.groups)):
        raise LayoutError("road: a parking lot has no sidewalk; ask for one beside another road, or for none")
    usual, needed = _usual_ego_lane(spec)
    lanes = spec.road.lanes or max(
        needed, min(_most_lanes(spec), _sample_lanes(spec, rng, max(needed, 1 + (0 if narrow else effort // 2))))
    )
    ego_lane = min({"left": lanes - 1, "middle": lanes // 2, "right": 0}.get(str(spec.road.ego_lane), usual), lanes - 1)
    distances = [(g.distance[1], g.kind) for g in spec.groups if g.distance and g.relation is None]
    farthest, farthest_kind = max(distances, default=(0.0, ""))
    if farthest > MAX_DISTANCE:
        raise LayoutError(f"{farthest_kind}: distance is {farthest:g} m; it must be {MAX_DISTANCE:g} m or less")
    queue = max((queue_length(group) for group in spec.groups if group.record.is_vehicle), default=0.0)
    row = max((_row_end(group) for group in spec.groups), default=0.0)
    if spec.road.junction and spec.road.junction[1] > MAX_DISTANCE - 30.0:
        raise LayoutError(f"road: junction is {spec.road.junction[1]:g} m; it must be {MAX_DISTANCE - 30:g} m or less")
    farthest = max(farthest, spec.road.junction[1] + 30.0 if spec.road.junction else 0.0)
    half_length = max(80.0, farthest + 15.0, row + 5.0, min(_LONGEST_QUEUE, max(queue, 30.0 * effort) + 10.0))
    if motorway:  # nothing else of a motorway may differ between seeds
        half_length += float(rng.spawn(1)[0].uniform(0.0, 8.0))
    wanted = spec.road.sidewalk
    usual_walk = not (motorway or lot) and (spec.district is None or SETTINGS[spec.district].sidewalk[1] > 0.0)
    sidewalk = float(rng.uniform(1.8, 3.0)) if wanted or (wanted is None and usual_walk) else 0.0
    bend = {"left-bend": 1.0, "right-bend": -1.0, "bend": float(rng.choice([-1, 1]))}.get(kind, 0.0)
    widths = SETTINGS["alley"].lane_width if narrow else (3.3, _WIDEST_LANE)
    lane_width = 3.75 if motorway else AISLE_LANE if lot else float(rng.uniform(*widths))
    strip = 0.0 if lot else max(_parking_width(spec, ego_lane), _usual_strip(spec, rng.spawn(1)[0]))
    parking = HARD_SHOULDER if motorway else strip
    oncoming = 0 if spec.road.one_way else spec.road.oncoming_lanes or lanes
    median = _median(spec)
    edge = median / 2 + (lanes + oncoming) / 2 * lane_width + parking
    radius = edge + sidewalk + RING + float(rng.uniform(1.0, 5.0)) if kind == "roundabout" else None
    near = (edge if radius is None else radius) + sidewalk + 6.0
    curvature = bend / float(rng.uniform(90.0, 160.0))
    road = Road(
        lanes=lanes,
        oncoming_lanes=spec.road.oncoming_lanes,
        ego_lane=ego_lane,
        lane_width=lane_width,
        parking=parking,
        sidewalk=sidewalk,
        curvature=curvature,
        junction=_junction(spec, edge if radius is None else radius, near, rng, effort),
        side_roads=(_branch(spec, int(rng.choice([LEFT, RIGHT]))),) if kind == "t-junction" else (LEFT, RIGHT),
        half_length=half_length,
        median=median,
        roundabout_radius=radius,
        paved_areas=_parking_lot(spec, lanes * lane_width, farthest, rng) if lot else (),
        one_way=spec.road.one_way,
    )
    return _crossed_at(spec, road)


def _median(spec: SceneSpec) -> float:
    """The width of the strip between the directions [m]."""
    if spec.road.median or any(group.surface == "median" for group in spec.groups):
        ways = f"has {spec.road.lanes} lanes this way and {spec.road.oncoming_lanes} oncoming"
        ways = "is one-way" if spec.road.one_way else ways if spec.road.oncoming_lanes else ""
        ways = "is a parking lot" if spec.road.kind == "parking-lot" else ways
        if ways:
            raise LayoutError(
                f"road: it {ways}; a median is between two directions with as many lanes; ask for no median"
            )
        return MEDIAN
    usual = spec.road.kind == "motorway" and not (spec.road.one_way or _has_junction(spec))
    return MEDIAN if usual else 0.0


def _branch(spec: SceneSpec, usual: int) -> int:
    """The side of the ego's road that another one joins: the one that traffic comes from, if the spec says so."""
    ways = {group.way_across for group in spec.groups if group.crosses} - {0}
    if len(ways) > 1:
        raise LayoutError("road: a T-junction has one branch, but vehicles come from both sides; ask for a crossroads")
    return {frozenset({1}): RIGHT, frozenset({-1}): LEFT}.get(frozenset(ways), usual)


def _crossed_at(spec: SceneSpec, road: Road) -> Road:
    """The road with its junction at the distance of a vehicle that crosses, if the spec gives one."""
    crossing = [
        (group.kind, group.way_across or 1, group.distance)
        for group in spec.groups
        if group.crosses and group.distance and not group.relation
    ]
    if not crossing or spec.road.junction is not None:
        return road
    kind, way, distance = crossing[0]
    for other, _, apart in crossing:
        if apart != distance:
            asked = f"at {apart[0]:g} m and at {distance[0]:g} m"
            raise LayoutError(
                f"{other}: one road crosses that of the ego, but vehicles are asked for that cross {asked}"
            )
    lane = road.lane(0, 1) * way
    junction = sum(distance) / 2 + lane
    nearest = NEAREST_JUNCTION + (road.edge if road.roundabout_radius is None else road.roundabout_radius)
    if junction < nearest:
        limit = f"crossing traffic must be {math.ceil(nearest - lane)} m away or more"
        raise LayoutError(f"{kind}: distance is {sum(distance) / 2:g} m; {limit}")
    return replace(road, junction=junction, half_length=max(road.half_length, junction + 30.0))


def _row_end(group: ObjectGroup) -> float:
    """The distance of the last object of a row that begins at a distance [m]; 0 for other groups."""
    if group.spacing is None or group.distance is None or group.fewest is None:
        return 0.0
    return min(MAX_RANGE, group.distance[0] + group.spacing * (group.fewest - 1))


def _sample_lanes(spec: SceneSpec, rng: np.random.Generator, needed: int) -> int:
    if spec.road.kind == "parking-lot" or spec.district == "alley":
        return needed
    if spec.road.kind == "motorway":
        return max(needed, int(rng.choice([2, 3])))
    return min(MAX_LANES, max(needed, int(rng.choice([1, 2], p=[0.75, 0.25]))))


def _most_lanes(spec: SceneSpec) -> int:
    """The lanes in each direction that leave room for roadside objects at their distances from the ego."""
    beside = [
        group.distance[0]
        for group in spec.groups
        if group.distance is not None
        and group.relation is None
        and not group.on_road
        and any(split_place(place) in (("", ""), ("", "left")) for place in group.places or ("",))
    ]
    # the ego is in the rightmost of them
    return max(2 if spec.road.kind == "motorway" else 1, int((min(beside, default=100.0) / _WIDEST_LANE + 0.5) / 2))


def _usual_ego_lane(spec: SceneSpec) -> tuple[int, int]:
    """The default number of the ego's lane, and the number of lanes that it and the traffic there need."""
    left = any(_beside_the_ego(group, "left", spec.road.one_way) for group in spec.groups)
    right = any(_beside_the_ego(group, "right", spec.road.one_way) for group in spec.groups)
    right = right or any(group.relation == "right-of" and group.record.drives for group in spec.groups)
    middle = spec.road.ego_lane == "middle" or any(group.lane == "middle" for group in spec.groups)
    reach = _lanes_to_the_right(spec)
    needed = max(3 if middle or (left and right) else 2 if left or right or spec.road.ego_lane else 1, reach + 1)
    usual = any(_on_the_right(group) for group in spec.groups)
    # of two lanes, the left one is for vehicles that overtake the ego
    overtaken = needed > (spec.road.lanes or needed) and any(
        group.lane == "left" and "beside" in group.places for group in spec.groups
    )
    return max(reach, int((right or (usual and not left)) and not overtaken)), needed


def _lanes_to_the_right(spec: SceneSpec) -> int:
    """The number of lanes needed for objects to the right of the ego at a distance."""
    reach = [
        group.distance[0] - (_PARKED if group.heading == "parked" else 0.0)
        for group in spec.groups
        if group.distance and group.relation is None and group.record.is_vehicle and "beside-right" in group.places
    ]
    return min(MAX_LANES - 1, max(0, math.ceil(max(reach, default=0.0) / _WIDEST_LANE - 0.3)))


def _beside_the_ego(group: ObjectGroup, side: str, one_way: bool) -> bool:
    """Whether a group needs a lane of the ego's direction on that side of the ego's lane."""
    if not group.record.is_vehicle or group.heading == "parked" or group.crosses or group.turns:
        return False
    at_side = any(split_place(place)[1] == side for place in group.places)
    if side == "left":
        return group.lane == "left" or (at_side and (group.heading == "with" or one_way))
    return group.lane == "right" or (at_side and group.heading in ("with", "against"))


def _on_the_right(group: ObjectGroup) -> bool:
    right = any(split_place(place)[1] == "right" for place in group.places)
    return right and group.record.drives and group.heading in (None, "with")


def _has_junction(spec: SceneSpec) -> bool:
    kinds = ("crossroads", "t-junction", "roundabout")
    return spec.road.kind in kinds or any(
        group.crosses or group.turns or group.at_junction for group in spec.groups if spec.road.kind != "parking-lot"
    )


def _junction(spec: SceneSpec, half: float, near: float, rng: np.random.Generator, effort: int) -> float | None:
    """The distance of the middle of the crossing road ahead [m]; its half width is `half`."""
    if not _has_junction(spec):
        return None
    if spec.road.junction is not None:
        return half + float(rng.uniform(*spec.road.junction))
    return float(rng.uniform(near, near + 12.0 + 8.0 * effort))


def _parking_lot(spec: SceneSpec, edge: float, farthest: float, rng: np.random.Generator) -> tuple[PavedArea, ...]:
    """Both sides of the aisle that the ego drives in, as long as the requested objects need [m].

    The car park ends at objects on a side that do not belong in one, such as a house.
    """
    length = float(rng.uniform(*_LOT_LENGTH))
    before = length * float(rng.uniform(0.3, 0.5))
    along = (-max(before, farthest + 5.0), max(length - before, farthest + 5.0))
    areas = []
    for side, way in (("right", -1), ("left", 1)):
        room = min(_near_sides(spec, side), default=math.inf) - 1.5 * edge  # from the ego's lane, or further
        depth = next((depth for depth in LOT_DEPTHS if depth < room), LOT_DEPTHS[-1])
        low, high = sorted((way * edge, way * (edge + depth)))
        areas.append(PavedArea(along, (low, high)))
    return tuple(areas)


def _near_sides(spec: SceneSpec, side: str) -> list[float]:
    """The distances from the ego [m] of objects on a side that do not belong in a car park."""
    near = []
    for group in spec.groups:
        sizes, sides = group.record.sizes, {split_place(place)[1] for place in group.places or ("",)}
        fixed = group.distance is not None and group.relation is None and sides & {"", side}
        if fixed and group.distance and sizes and not group.on_road and "sidewalk" not in group.record.surfaces:
            near.append(group.distance[0] - sizes.largest[1] / 2)
    return near


def _parking_width(spec: SceneSpec, ego_lane: int) -> float:
    parked = [
        group.record for group in spec.groups if group.heading == "parked" or (ego_lane == 0 and _on_the_right(group))
    ]
    return max((kind.parking_width for kind in parked if kind.is_vehicle), default=0.0)


def _usual_strip(spec: SceneSpec, rng: np.random.Generator) -> float:
    """The default parking strip of a street between buildings [m], as often as in its district.

    There is none if cars are counted or denied, as it would then have to stay empty.
    """
    kinds = {group.kind for group in spec.groups if group.record.family == "buildings" and group.fewest is None}
    name = spec.district or ("residential" if "house" in kinds else "urban" if kinds else "country")
    district = SETTINGS[name]
    counted = any(group.record.label == "car" and group.fewest is not None for group in spec.groups)
    denied = {"car", "vehicle"} & {*spec.absent, *spec.not_around} or spec.activity == "empty"
    if counted or denied or not district.built_up or district.sidewalk[1] == 0.0:
        return 0.0
    return PARKING_STRIP if rng.random() < 1.0 - (1.0 - district.parked) ** 2 else 0.0
