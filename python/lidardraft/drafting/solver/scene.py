"""The objects placed on and beside a road so far, and the room that is left."""

from __future__ import annotations

import dataclasses
import math
from collections import Counter
from collections.abc import Iterator

import numpy as np

from lidardraft.drafting.solver.poses import RoadPose, lot_edge, with_near_side_at
from lidardraft.drafting.solver.relative_poses import Footprint
from lidardraft.drafting.solver.scene_spec import EXTENTS, ObjectGroup, split_place
from lidardraft.errors import LayoutError
from lidardraft.objects.coarse_shapes import STANDING, CoarseShape, extents, in_segments, resized
from lidardraft.objects.sentence_kind import SentenceKind
from lidardraft.scene.check import EGO, MAX_RANGE, SIZE_RANGES, LayoutGround
from lidardraft.scene.layout import Primitive
from lidardraft.scene.road import RING, Road
from lidardraft.scene.road_surfaces import road_surfaces
from lidardraft.scene.solids import Solid, Solids
from lidardraft.semantics import BY_NAME

# Estimates.
GAP = 0.25  # m between any two objects
FOLLOWING_GAP = 2.0  # m before and behind vehicles without a requested distance
_HIGH = 10.0  # m over a crossing road, kept free


class SpecScene:
    """The primitives of a layout under construction, and the solids that must not overlap.

    `in_the_way` counts the obstacles that left objects without room, by name, since it was cleared.
    """

    def __init__(self, road: Road, rng: np.random.Generator) -> None:
        self.road, self.rng = road, rng
        self.primitives = road_surfaces(road)
        self.ground = LayoutGround(self.primitives)
        self.in_the_way: Counter[str] = Counter()
        self._standing = Solids([Solid.from_primitive(EGO)])
        crossing = (surface for surface in self.primitives if surface.id in ("road_left", "road_right"))
        self._side_roads = Solids(Solid.from_primitive(surface)._replace(top=_HIGH) for surface in crossing)
        self._numbers: Counter[str] = Counter()
        self._instances = 0

    def place(
        self, kind: SentenceKind, group: ObjectGroup, pose: RoadPose, *, by_end: bool = False
    ) -> Footprint | None:
        """Place one object there, or its near end `by_end`, if there is room for it."""
        in_lot = bool(self.road.paved_areas) and abs(pose.across) > self.road.edge
        if (kind.walks or group.surface == "sidewalk") and group.heading in ("with", "against"):
            pose = pose._replace(yaw=0.0 if group.heading == "with" else math.pi)
        parked = group.heading == "parked" or (in_lot and group.heading is None)
        along_road = not group.on_road or group.surface == "median"
        bent = kind.follows_road and self.road.curvature != 0.0 and along_road
        parts = _sized(kind.sample_parts(self.rng, parked=parked), group)
        parts = in_segments(parts[0]) if bent else parts
        if group.set_back or group.set_aside:
            pose = with_near_side_at(group, pose, parts)
        if by_end:
            half = Footprint.of("", kind, pose, *extents(parts)[:2]).half_along
            pose = pose._replace(along=pose.along + math.copysign(half, pose.along))
        moving = kind.drives and not parked
        close = group.distance or group.spacing or group.relation
        blocker, primitives = self._limit(kind, group, parts, pose), []
        if blocker is None:
            primitives = [self._primitive(kind, part, pose, bent) for part in parts]
            ahead = FOLLOWING_GAP if moving and not close else min(GAP, gap_of(group) / 2)
            wide = [Solid.from_primitive(primitive).widened(ahead, GAP) for primitive in primitives]
            blocker = next(self._obstacles(wide, side_roads=not (moving or kind.walks)), None)
        if blocker is not None:
            self.in_the_way[blocker] += 1
            return None
        self._numbers[kind.name] += 1
        name = f"{kind.name}_{self._numbers[kind.name]}"
        numbers: dict[str, int] = {}  # a rider and its vehicle are two instances of one name
        for part, primitive in zip(parts, primitives, strict=True):
            if BY_NAME[part.label].is_thing and part.label not in numbers:
                self._instances += 1
                numbers[part.label] = self._instances
            id = f"{name}.{part.name}" if part.name else name
            self.primitives.append(dataclasses.replace(primitive, id=id, instance=numbers.get(part.label, 0)))
        for primitive in self.primitives[-len(parts) :]:
            self._standing.add(Solid.from_primitive(primitive))
        length, width, _ = extents([part for part in parts if part.center[2] - part.size[2] / 2 < STANDING])
        return Footprint.of(name, kind, pose, length, width)  # crowns and lamps overhang near objects

    def _limit(self, kind: SentenceKind, group: ObjectGroup, parts: list[CoarseShape], pose: RoadPose) -> str | None:
        """The name of the limit that rules out a pose in any scene; None if there is none."""
        if not group.on_road and any(_reaches(part, pose.across, self.road) for part in parts):
            return "the road"
        if any(is_at(pose, place, self.road) for place in group.not_places):
            return "a place where it may not be"
        if "sidewalk" not in kind.surfaces and not kind.on_road and self._reaches_into_lot(parts, pose):
            return "the parking lot"
        if group.surface == "median" and self.road.in_junction(pose.along, extents(parts)[0] / 2):
            return "the junction"
        x, y, _ = self.road.at(pose.along, pose.across)
        if abs(pose.along) > self.road.half_length or math.hypot(x, y) > MAX_RANGE:
            return "the end of the road"
        beyond = abs(pose.across) > self.road.edge and group.surface != "sidewalk"
        if kind.is_vehicle and beyond and not self._is_paved(pose):
            return "the kerb"
        return "the roundabout" if self._is_in_roundabout(kind, parts, pose) else None

    def _reaches_into_lot(self, parts: list[CoarseShape], pose: RoadPose) -> bool:
        if not self.road.paved_areas:
            return False
        (start, end), (length, width, _) = self.road.paved_areas[0].along, extents(parts)
        beside = start - length / 2 < pose.along < end + length / 2
        return beside and abs(pose.across) - width / 2 < lot_edge(self.road, 1 if pose.across > 0 else -1)

    def _is_paved(self, pose: RoadPose) -> bool:
        surface = self.ground.at(*self.road.at(pose.along, pose.across)[:2])
        return surface is not None and surface[1] == "road"

    def _is_in_roundabout(self, kind: SentenceKind, parts: list[CoarseShape], pose: RoadPose) -> bool:
        """Whether it would block traffic in the roundabout, or be on the island."""
        if self.road.roundabout_radius is None or self.road.junction is None:
            return False
        radius = math.hypot(pose.along - self.road.junction, pose.across)
        around = math.atan2(pose.across, pose.along - self.road.junction) + math.pi / 2
        on_ring = abs(radius - self.road.island - RING / 2) < 0.01 and math.cos(pose.yaw - around) > 0.9
        if kind.drives and on_ring:
            return False
        length, width, _ = extents(parts)
        reach = length / 2 if kind.drives else math.hypot(length, width) / 2
        return radius < self.road.roundabout_radius + reach

    def _obstacles(self, solids: list[Solid], *, side_roads: bool) -> Iterator[str]:
        """The names of the obstacles that some solids overlap with."""
        for solid in solids:
            for index in (self._standing, self._side_roads) if side_roads else (self._standing,):
                for other in index.touching(solid):
                    yield _NAMES.get(other.id, other.id.partition(".")[0])

    def _primitive(self, kind: SentenceKind, part: CoarseShape, pose: RoadPose, bent: bool) -> Primitive:
        along, across, yaw = pose
        if bent:  # each segment follows the bend, as long as the arc
            along, (length, width, height) = along + part.center[0], part.size
            length *= 1.0 - self.road.curvature * across
            part = part._replace(center=(0.0, *part.center[1:]), size=(length, width, height))
        x, y, heading = self.road.at(along, across)
        return part.placed((x, y, yaw + heading), self.ground.height(x, y), kind.name)


def gap_of(group: ObjectGroup) -> float:
    """The gap between neighbours in a row [m]; infinite for objects that are not in one."""
    length = group.size[0] if group.size else None
    return math.inf if group.spacing is None or length is None else max(0.0, group.spacing - length)


_NAMES = {"ego": "the ego vehicle", "road_left": "the crossing road", "road_right": "the crossing road"}


def _sized(parts: list[CoarseShape], group: ObjectGroup) -> list[CoarseShape]:
    """The parts in the requested size; raises `LayoutError` if its class does not allow it."""
    if group.scale is None and group.size is None:
        return parts
    asked, times, has = group.size or (None, None, None), group.scale or (1.0, 1.0, 1.0), extents(parts)
    label = group.record.label
    low, high = SIZE_RANGES.get(label, ((0.0, 0.0, 0.0), (EXTENTS[1],) * 3))
    wanted = [
        min(max(length * factor, least), most * (1 - 1e-6)) if said is None else said
        for said, factor, length, least, most in zip(asked, times, has, low, high, strict=True)
    ]
    for name, said, least, most in zip(("length", "width", "height"), asked, low, high, strict=True):
        if said is not None and not least <= said <= most:
            raise LayoutError(f"{group.kind}: {name} is {said:g} m; a {label} has {least:g} to {most:g} m")
    x, y, z = (to / of for to, of in zip(wanted, has, strict=True))
    return resized(parts, (x, y, z))


def _reaches(part: CoarseShape, across: float, road: Road) -> bool:
    """Whether a part of a roadside object would stand on the road; overhanging parts, such as a crown, may."""
    low = part.center[2] - part.size[2] / 2 < STANDING
    return low and abs(across) - part.size[1] / 2 < road.edge


def is_at(pose: RoadPose, place: str, road: Road) -> bool:
    """Whether a pose is at one of PLACES relative to the ego; "" is anywhere."""
    aside = pose.across - road.lane(road.ego_lane)
    fore, side = split_place(place)
    along = {"front": pose.along > 0, "behind": pose.along < 0, "beside": abs(pose.along) <= 4.0, "": True}[fore]
    return along and {"left": aside > 0, "right": aside < 0, "": True}[side]
