"""The lanes that are driven in: straight pieces and arcs in the frame of the road."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from lidardraft.arranging.car_parks import CarPark
from lidardraft.arranging.district import PARKING_STRIP, District
from lidardraft.scene.road import LEFT, RIGHT, RING, Road

# Limits [m/s] of the German road code (StVO).
_TOWN_SPEED = 50 / 3.6
_ROUNDABOUT_SPEED = 30 / 3.6  # as is usual
_CAR_PARK_SPEED = 10 / 3.6  # walking speed
# Estimates of ours [m].
_STOP = 1.5  # from where traffic waits for a light to the road that is crossed
_AISLE_END = 2.5  # at either end of an aisle that is not driven in
_AISLE_OFF = 1.4  # from the middle of an aisle to that of each way
_JUNCTION_GAP = 2.0  # between the lane of a roundabout, or the road, and the lanes that lead to it
_SHORTEST = 12.0  # a piece of the road before or behind a roundabout
_TWO_LANES = 6.0  # width from which a one-way street has two
_FOUR_LANES = 6.5  # half width from which a side road has two each way
_ONE_EACH_WAY, _TWO_EACH_WAY = (0.5,), (0.75, 0.25)  # middles of lanes in shares of the half width


@dataclass(frozen=True, kw_only=True, slots=True)
class LaneKind:
    """What lanes of one kind have in common: estimates of ours.

    `ego_share` is how often a place in such a lane is taken for the ego vehicle, against one of the road itself, and
    `ego_stands` how often it stands there. `free_gap` is the mean distance [m] of vehicles that follow none, None for
    that of the district. `heavy` is the share of trucks and buses in the traffic, None for that of the district; where
    `only_cars`, there are neither these nor riders. Lanes that `follow_road` bend with it.
    """

    ego_share: float
    ego_stands: float
    free_gap: float | None = None
    heavy: float | None = None
    only_cars: bool = False
    follow_road: bool = False


MAIN_ROAD = LaneKind(ego_share=1.0, ego_stands=0.12, follow_road=True)
SIDE_ROAD = LaneKind(ego_share=0.5, ego_stands=0.3, free_gap=45.0, heavy=0.04)
ROUNDABOUT = LaneKind(ego_share=1.0, ego_stands=0.1, free_gap=40.0, only_cars=True)
AISLE = LaneKind(ego_share=0.7, ego_stands=0.25, free_gap=60.0, only_cars=True)


@dataclass(frozen=True, kw_only=True, slots=True)
class Lane:
    """A lane from (`along`, `across`) [m] of the road's frame on, `angle` [rad] against the road, bent to the left by
    `bend` [1/m] in that frame. `speed` [m/s] is the limit, `stop` the distance from the start to where traffic waits
    for a light, or None. `outer` is whether it is the outermost of its direction.
    """

    kind: LaneKind
    along: float
    across: float
    angle: float
    length: float
    speed: float
    bend: float = 0.0
    stop: float | None = None
    outer: bool = True

    def at(self, distance: float, left: float = 0.0) -> tuple[float, float, float]:
        """Along, across [m] and angle [rad] that far from the start and `left` [m] of the middle."""
        angle = self.angle + self.bend * distance
        if self.bend == 0.0:
            along = self.along + distance * math.cos(angle)
            across = self.across + distance * math.sin(angle)
        else:
            along = self.along + (math.sin(angle) - math.sin(self.angle)) / self.bend
            across = self.across - (math.cos(angle) - math.cos(self.angle)) / self.bend
        return along - left * math.sin(angle), across + left * math.cos(angle), angle


def driven_lanes(
    road: Road, district: District, parking: tuple[int, ...], car_park: CarPark | None, *, oneway: bool, lights: bool
) -> tuple[Lane, ...]:
    """The lanes of a road, of its side roads, its roundabout and its car park.

    Parked cars take the outermost of several lanes, or a strip beside the only one. The side roads of a bend, in whose
    frame they would widen, have none.
    """
    lanes: list[Lane] = []
    for across, direction, outer in _offsets(road, parking, oneway):
        lanes += _main_lanes(road, across, direction, district.speed, outer=outer, lights=lights)
    if road.junction is not None and not road.curvature:
        for side in road.side_roads:
            lanes += _side_road_lanes(road, road.junction, side, district.speed, lights)
    if road.roundabout_radius is not None and road.junction is not None:
        lanes.append(_roundabout_lane(road.junction, road.roundabout_radius - RING / 2))
    if car_park is not None:
        lanes += _aisle_lanes(car_park)
    return tuple(lanes)


def _offsets(road: Road, parking: tuple[int, ...], oneway: bool) -> list[tuple[float, int, bool]]:
    """Across [m], direction and whether outermost, of the lanes of the road itself."""
    strip = road.parking or PARKING_STRIP
    right = road.edge - (strip if RIGHT in parking or road.parking else 0.0)
    left = road.edge - (strip if LEFT in parking or road.parking else 0.0)
    if oneway:
        # all the room between the parked cars: one lane, or two where there is width for them
        middle, width = (left - right) / 2, left + right
        if width < _TWO_LANES:
            return [(middle, 1, True)]
        return [(middle - width / 4, 1, True), (middle + width / 4, 1, False)]
    if road.lanes == road.oncoming == 1 and not road.median:
        middle = (left - right) / 2
        return [((middle - right) / 2, 1, True), ((middle + left) / 2, -1, True)]
    offsets = []
    for direction, lanes in ((1, road.lanes), (-1, road.oncoming)):
        first = 1 if -direction in parking and lanes > 1 else 0
        offsets += [(road.lane(number, direction), direction, number == first) for number in range(first, lanes)]
    return offsets


def _main_lanes(road: Road, across: float, direction: int, speed: float, *, outer: bool, lights: bool) -> list[Lane]:
    """A lane along the whole road, in two pieces where a roundabout breaks it."""
    start, length = -direction * road.half_length, 2 * road.half_length
    angle = 0.0 if direction > 0 else math.pi
    whole = Lane(kind=MAIN_ROAD, along=start, across=across, angle=angle, length=length, speed=speed, outer=outer)
    if road.junction is None:
        return [whole]
    to_junction = direction * (road.junction - start)
    if road.roundabout_radius is None:
        return [replace(whole, stop=to_junction - road.verge - _STOP if lights else None)]
    gap = road.roundabout_radius + _JUNCTION_GAP
    pieces = ((start, to_junction - gap), (road.junction + direction * gap, length - to_junction - gap))
    return [replace(whole, along=begin, length=piece) for begin, piece in pieces if piece > _SHORTEST]


def _side_road_lanes(road: Road, junction: float, side: int, speed: float, lights: bool) -> list[Lane]:
    """The two or four lanes of a side road; right-hand traffic: outwards on the right seen from the junction."""
    near = (road.edge if road.roundabout_radius is None else road.roundabout_radius) + _JUNCTION_GAP
    length = road.half_length - near
    stop = length - (road.verge - road.edge) - _STOP if lights and road.roundabout_radius is None else None
    lanes = []
    shares = _ONE_EACH_WAY if road.edge < _FOUR_LANES else _TWO_EACH_WAY
    for share in shares:
        off = side * road.edge * share
        outwards = Lane(
            kind=SIDE_ROAD,
            along=junction + off,
            across=side * near,
            angle=side * math.pi / 2,
            length=length,
            speed=min(speed, _TOWN_SPEED),
            outer=share == shares[0],
        )
        inwards = replace(
            outwards, along=junction - off, across=side * road.half_length, angle=-outwards.angle, stop=stop
        )
        lanes += [outwards, inwards]
    return lanes


def _roundabout_lane(junction: float, radius: float) -> Lane:
    """Once around, counter-clockwise."""
    return Lane(
        kind=ROUNDABOUT,
        along=junction + radius,
        across=0.0,
        angle=math.pi / 2,
        length=2 * math.pi * radius,
        speed=_ROUNDABOUT_SPEED,
        bend=1 / radius,
    )


def _aisle_lanes(car_park: CarPark) -> list[Lane]:
    """One each way in each aisle."""
    first, last = car_park.paved_area.along
    lanes = []
    for across in car_park.aisles:
        forward = Lane(
            kind=AISLE,
            along=first + _AISLE_END,
            across=across - _AISLE_OFF,
            angle=0.0,
            length=last - first - 2 * _AISLE_END,
            speed=_CAR_PARK_SPEED,
        )
        back = replace(forward, along=last - _AISLE_END, across=across + _AISLE_OFF, angle=math.pi)
        lanes += [forward, back]
    return lanes
