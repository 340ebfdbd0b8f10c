"""The lanes that are driven in: straight pieces and arcs in the frame of the road."""

from __future__ import annotations

import math
from dataclasses import dataclass

from lidardraft.scene.road import RING, Road
from lidardraft.streets.placement.car_parks import CarPark
from lidardraft.streets.placement.district import PARKING_STRIP, District

_LOT_END = 2.5  # m that an aisle is not driven in at its ends
# Limits [m/s] of the German road code (StVO): 30 km/h in a roundabout is usual, walking speed in car parks.
_RING_SPEED, _LOT_SPEED = 30 / 3.6, 10 / 3.6


@dataclass(frozen=True, kw_only=True, slots=True)
class Lane:
    """A lane from (`along`, `across`) [m] of the road's frame on, `angle` [rad] against the road, bent to the left by
    `bend` [1/m] in that frame. `speed` [m/s] is the limit, `stop` the distance from the start to a line where traffic
    waits for a light, or None. `outer` is whether it is the outermost of its direction. `name` is "road", "arm", "ring"
    or "aisle".
    """

    name: str
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

    Parked cars take the outermost of several lanes, or a bay beside the only one.
    """
    lanes: list[Lane] = []
    for across, direction, outer in _offsets(road, parking, oneway):
        lanes += _road_lane(road, across, direction, district.speed, outer=outer, lights=lights)
    if road.junction is not None:
        for side in road.side_roads:
            lanes += _arm_lanes(road, road.junction, side, district.speed, lights)
    if road.roundabout_radius is not None and road.junction is not None:
        radius = road.roundabout_radius - RING / 2
        angle = 2 * math.pi * radius
        lanes.append(
            Lane(
                name="ring",
                along=road.junction + radius,
                across=0.0,
                angle=math.pi / 2,
                length=angle,
                speed=_RING_SPEED,
                bend=1 / radius,
            )
        )
    if car_park is not None:
        for across in car_park.aisles:
            for way, angle in ((-1, 0.0), (1, math.pi)):
                start = car_park.paved_area.along[0 if way < 0 else 1] - way * _LOT_END
                length = car_park.paved_area.along[1] - car_park.paved_area.along[0] - 2 * _LOT_END
                lanes.append(
                    Lane(
                        name="aisle",
                        along=start,
                        across=across + way * 1.4,
                        angle=angle,
                        length=length,
                        speed=_LOT_SPEED,
                    )
                )
    return tuple(lanes)


def _offsets(road: Road, parking: tuple[int, ...], oneway: bool) -> list[tuple[float, int, bool]]:
    """Across [m], direction and whether outermost, of the lanes of the road itself."""
    right = road.edge - (PARKING_STRIP if -1 in parking else 0.0)
    left = road.edge - (PARKING_STRIP if 1 in parking else 0.0)
    if oneway:
        # all the room between the parked cars: one lane, or two where there is width for them
        middle, width = (left - right) / 2, left + right
        if width < 6.0:
            return [(middle, 1, True)]
        return [(middle - width / 4, 1, True), (middle + width / 4, 1, False)]
    if road.lanes == 1 and not road.median:
        middle = (left - right) / 2
        return [((middle - right) / 2, 1, True), ((middle + left) / 2, -1, True)]
    offsets = []
    for direction in (1, -1):
        first = 1 if -direction in parking and road.lanes > 1 else 0
        offsets += [(road.lane(number, direction), direction, number == first) for number in range(first, road.lanes)]
    return offsets


def _road_lane(road: Road, across: float, direction: int, speed: float, *, outer: bool, lights: bool) -> list[Lane]:
    """A lane along the whole road, in two pieces where a roundabout breaks it."""
    angle = 0.0 if direction > 0 else math.pi
    start = -direction * road.half_length
    if road.junction is None:
        whole = Lane(
            name="road", along=start, across=across, angle=angle, length=2 * road.half_length, speed=speed, outer=outer
        )
        return [whole]
    to_junction = direction * (road.junction - start)
    if road.roundabout_radius is None:
        stop = to_junction - road.verge - 1.5 if lights else None
        return [
            Lane(
                name="road",
                along=start,
                across=across,
                angle=angle,
                length=2 * road.half_length,
                speed=speed,
                stop=stop,
                outer=outer,
            )
        ]
    gap = road.roundabout_radius + 2.0
    after = road.junction + direction * gap
    pieces = ((start, to_junction - gap), (after, 2 * road.half_length - to_junction - gap))
    return [
        Lane(name="road", along=begin, across=across, angle=angle, length=length, speed=speed, outer=outer)
        for begin, length in pieces
        if length > 12.0
    ]


def _arm_lanes(road: Road, junction: float, side: int, speed: float, lights: bool) -> list[Lane]:
    """The two or four lanes of a side road; right-hand traffic: outwards on the right seen from the junction."""
    near = (road.edge if road.roundabout_radius is None else road.roundabout_radius) + 2.0
    length = road.half_length - near
    stop = length - (road.verge - road.edge) - 1.5 if lights and road.roundabout_radius is None else None
    speed = min(speed, 50 / 3.6)
    lanes = []
    shares = (0.5,) if road.edge < 6.5 else (0.75, 0.25)
    for share in shares:
        off, angle, outer = side * road.edge * share, side * math.pi / 2, share == shares[0]
        lanes += [
            Lane(
                name="arm",
                along=junction + off,
                across=side * near,
                angle=angle,
                length=length,
                speed=speed,
                outer=outer,
            ),
            Lane(
                name="arm",
                along=junction - off,
                across=side * road.half_length,
                angle=-angle,
                length=length,
                speed=speed,
                stop=stop,
                outer=outer,
            ),
        ]
    return lanes
