"""Poses relative to other objects: behind, in front of, beside, between, opposite or near placed objects."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lidardraft.drafting.solver.poses import BACKWARDS, Lane, RoadPose, Try, lot_edge, row_poses
from lidardraft.objects.sentence_kind import SentenceKind
from lidardraft.scene.road import Road

# Estimates: gaps between two objects [m], smallest and largest, without a requested distance.
_IN_LANE = (1.5, 5.0)  # along a lane
_CLOSE = (0.4, 1.2)
_NEAR = (0.5, 4.0)
_FURTHER, _DEEPEST = 8.0, 90.0  # m more if there is no room; behind a row, for hundreds
_MOVED_TO_SIDEWALK = 2.0  # m, of an object near another
_ACROSS_LANES = 0.6  # m between objects side by side
_MOVED, _MOVED_BETWEEN, _MOVED_EXACTLY = 12.0, 3.0, 0.3  # m across the road, at most, to a place that its kind allows


@dataclass(frozen=True, slots=True)
class Footprint:
    """The pose of an object in the road's frame, and its reach from the middle along and across [m]."""

    name: str
    kind: SentenceKind
    pose: RoadPose
    half_along: float
    half_across: float

    @classmethod
    def of(cls, name: str, kind: SentenceKind, pose: RoadPose, length: float, width: float) -> Footprint:
        """The footprint of an object with that length and width [m]."""
        cos, sin = abs(math.cos(pose.yaw)), abs(math.sin(pose.yaw))
        return cls(name, kind, pose, (cos * length + sin * width) / 2, (sin * length + cos * width) / 2)

    @property
    def forwards(self) -> int:
        """1 if it faces the ego's direction or, without a front, is ahead of the ego; else -1."""
        if self.kind.drives:
            return 1 if math.cos(self.pose.yaw) > 0 else -1
        return 1 if self.pose.along >= 0 else -1

    @property
    def side(self) -> int:
        """1 on the left of the road, -1 on the right."""
        return 1 if self.pose.across > 0 else -1


@dataclass(frozen=True, slots=True)
class RelativePoses:
    """Samples poses of an object of `kind` by its `relation` to the references; `distance` is a range from them [m].

    `lanes` are those allowed, all if empty; a `surface` "sidewalk" puts it there.

    The relation "row" continues a row: in line with the reference, on the side away from the ego.
    """

    road: Road
    kind: SentenceKind
    size: tuple[float, float]
    heading: str | None
    relation: str
    distance: tuple[float, float] | None = None
    lanes: Sequence[Lane] = ()
    surface: str | None = None

    def sample(self, references: Sequence[Footprint], at: Try) -> RoadPose | None:
        """A pose, or None if its kind allows none; if one reference leaves no room, relative to others too."""
        turn = at.number + max(0, int((2 * at.effort - 1) * len(references)))
        reference = references[turn % len(references)]
        at = at._replace(along=reference.pose.along, number=at.number // len(references))  # of those at this one
        if self.relation == "between":
            return self._between(references[0], references[1], at)
        if self.relation == "opposite":
            return self._opposite(reference, at)
        if self.relation in ("left-of", "right-of"):
            return self._aside(reference, 1 if self.relation == "left-of" else -1, at)
        if self.relation == "row":
            return self._in_line(reference, 1 if at.along >= 0 else -1, at._replace(number=0))
        if self.relation == "behind":
            return self._behind(reference, at)
        if self.relation == "in-front-of":
            return self._in_front(reference, at)
        return self._beside(reference, at, _NEAR if self.relation == "near" else _CLOSE)

    def _opposite(self, reference: Footprint, at: Try) -> RoadPose | None:
        """On the other side of the road, several in a row."""
        lane = self.road.edge - self.road.parking / 2 if self.heading == "parked" else self.road.edge / 2
        beside = lane if self.kind.drives else max(self.road.edge + 2.0, abs(reference.pose.across))
        reach = 1.0 + 2.0 * at.effort * at.number * self.size[0]
        return self._pose(at.along + reach * at.uniform(-1.0, 1.0), -reference.side * beside, reference, at)

    def _behind(self, reference: Footprint, at: Try) -> RoadPose | None:
        """At its back: behind the rear of a vehicle, on the far side of a roadside object."""
        if reference.kind.drives or reference.kind.walks or self.kind.is_vehicle:
            return self._in_line(reference, (-1 if reference.kind.drives else 1) * reference.forwards, at)
        deep = min(_DEEPEST, (at.number - 10) * self.size[1])  # hundreds make a wood
        off = reference.half_across + self.size[1] / 2 + self._gap(_CLOSE, at, max(_FURTHER, deep))
        along = at.along + at.uniform(-0.5, 0.5) * self._width_of_row(reference, at)
        return self._pose(along, reference.pose.across + reference.side * off, reference, at)

    def _in_front(self, reference: Footprint, at: Try) -> RoadPose | None:
        """At its front: before the nose of a vehicle, on the near side of a roadside object."""
        if reference.kind.drives or reference.kind.walks:
            return self._in_line(reference, (1 if reference.kind.drives else -1) * reference.forwards, at)
        off = reference.half_across + self.size[1] / 2 + self._gap(_CLOSE, at)
        along = at.along + at.uniform(-0.6, 0.6) * self._width_of_row(reference, at)
        return self._pose(along, reference.pose.across - reference.side * off, reference, at)

    def _width_of_row(self, reference: Footprint, at: Try) -> float:
        """How far objects behind or in front of one object extend along the road [m]; more as they find no room."""
        if reference.kind.follows_road and at.number:  # first along the whole object
            free = max(reference.half_along, 2.0 * reference.half_along - self.size[0])
            return free + 2.0 * max(0.0, 2.0 * at.effort - 1.0) * at.number * self.size[0]
        return reference.half_along + 2.0 * at.effort * at.number * self.size[0]

    def _in_line(self, reference: Footprint, way: int, at: Try) -> RoadPose | None:
        """In its row, `at.number` objects of this size after the first."""
        usual = _IN_LANE if self.kind.is_vehicle or reference.kind.is_vehicle else _CLOSE
        least = reference.half_along + self.size[0] / 2
        off = at.uniform(*self.distance) if self.distance else least + self._gap(usual, at)
        off = least + off if self.distance and off < least + 0.3 else off  # no room: measured between the ends
        off += at.number * (self.size[0] + usual[0])
        return self._pose(at.along + way * off, reference.pose.across, reference, at)

    def _beside(self, reference: Footprint, at: Try, usual: tuple[float, float]) -> RoadPose | None:
        """At its side across the road, or along it."""
        if reference.kind.follows_road and at.number:  # several along a fence, or along the kerb before it
            found = self._aside(reference, 1 if at.rng.random() < 0.5 else -1, at, usual)
            half = reference.half_along
            if self.kind.is_vehicle:
                half = min(half + self.size[0] / 2, self._width_of_row(reference, at))
            along = at.along + at.uniform(-1.0, 1.0) * half
            return found and found._replace(along=along)
        along_it = not (self.kind.drives and reference.kind.drives) and at.rng.random() < 0.5
        if along_it and not self.kind.is_vehicle:
            off = reference.half_along + self.size[0] / 2 + self._gap(usual, at)
            off += min(1.0, 2.0 * at.effort) * at.number * self.size[0]
            along, across = at.along + (off if at.rng.random() < 0.5 else -off), reference.pose.across
            if not reference.kind.drives:  # in line with its roadside face
                across -= reference.side * (reference.half_across - self.size[1] / 2)
            return self._pose(along, across, reference, at)
        return self._aside(reference, 1 if at.rng.random() < 0.5 else -1, at, usual)

    def _aside(self, reference: Footprint, side: int, at: Try, usual: tuple[float, float] = _CLOSE) -> RoadPose | None:
        """To one side of it; several form a row along the road if they find no room."""
        near = at._replace(effort=at.effort / 4)
        off = reference.half_across + self.size[1] / 2 + max(_ACROSS_LANES, self._gap(usual, near))
        together = at.number > 0 and self.kind.drives and reference.kind.drives  # several overtake one after another
        beyond = at.number + at.effort  # so the first finds room beside a larger object too
        row = 0.0 if together else 5.0 * at.effort * beyond * (self.size[0] + 1.0)
        along = at.along + at.uniform(-0.4, 0.4) * (reference.half_along + row)
        if together:
            along -= reference.forwards * at.number * (self.size[0] + self._gap(_IN_LANE, near))
        return self._pose(along, reference.pose.across + side * off, reference, at, side)

    def _between(self, one: Footprint, other: Footprint, at: Try) -> RoadPose | None:
        """On the line from one to the other, if there is room."""
        share = 0.5 + at.uniform(-0.25, 0.25) * at.effort * (1.6 if self.kind.drives else 1.0)
        along = one.pose.along + share * (other.pose.along - one.pose.along)
        across = one.pose.across + share * (other.pose.across - one.pose.across)
        if self.road.curvature and not (one.kind.drives and self.kind.drives):  # straight through the bend
            start, end = (np.array(self.road.at(*each.pose[:2])[:2]) for each in (one, other))
            along, across = self.road.along_across(*(start + share * (end - start)).tolist())
        return self._pose(along, across, one, at)

    def _gap(self, usual: tuple[float, float], at: Try, further: float = _FURTHER) -> float:
        """The gap to the reference [m]: the requested one, or more than usual if there is no room."""
        gap = at.uniform(*usual) + further * at.effort * float(at.rng.random())
        return at.uniform(*self.distance) if self.distance else gap

    @property
    def _on_sidewalk(self) -> bool:
        return self.surface == "sidewalk" and self.road.sidewalk > 0.9

    @property
    def _goes_across(self) -> bool:
        return (self.kind.walks or self.kind.cycles) and str(self.heading).startswith("across")

    def _pose(self, along: float, across: float, reference: Footprint, at: Try, side: int = 0) -> RoadPose | None:
        """The pose there, moved to a place that its kind allows: a lane or the kerb, or beside the road."""
        found, yaw = self._ground_at(across, reference, at, side)
        moved, apart = abs(found - across), (found - reference.pose.across) * side
        in_between = self.relation == "between" and reference.kind.drives == self.kind.drives
        exactly = self.relation == "near" and self.distance is not None
        beside = 0.0 if self.kind.on_road or exactly or in_between else abs(found - reference.pose.across)
        most = _MOVED_EXACTLY if exactly else _MOVED_BETWEEN if in_between else max(_MOVED, beside)
        if self._on_sidewalk and self.relation in ("near", "beside"):
            most = _MOVED_TO_SIDEWALK
        if (moved > most and not self._goes_across) or (side and apart < max(0.3, self.size[1] / 4)):
            return None
        towards = reference.half_across < abs(reference.pose.across) - abs(found)
        if self.relation == "in-front-of" and not (towards or reference.kind.drives or reference.kind.walks):
            return None
        return RoadPose(along, found, yaw)

    def _ground_at(self, across: float, reference: Footprint, at: Try, side: int) -> tuple[float, float]:
        """The nearest place across the road that its kind allows, and the yaw there."""
        if self._goes_across:  # between the kerbs, wherever the reference is
            free = self.road.edge - self.road.parking - 0.5
            across = across if abs(across) < free or self._on_sidewalk else at.uniform(-free, free)
            return across, at.walking_yaw(str(self.heading))
        if self._on_sidewalk:
            low, high = self.road.edge + 0.4, max(self.road.edge + 0.5, self.road.verge - 0.4)
            across = math.copysign(min(max(abs(across), low), high), across)
            standing = 0.0 if across > 0 else BACKWARDS
            return across, at.any_yaw() if self.kind.walks else standing
        if self.kind.walks or (self.kind.cycles and self.heading == "parked"):
            kerb = self.road.edge + self.size[0] / 2
            on_road = abs(across) < kerb and reference.side * reference.pose.across > self.road.edge
            if on_road and not self.kind.walks:  # a bicycle at a wall is on the wall's side of the kerb
                across = reference.side * kerb
            return across, at.any_yaw()
        if self.surface == "road" and not self.kind.drives:
            most = self.road.edge - self.size[1] / 2 - 0.3
            return max(-most, min(most, across)), at.any_yaw()
        if not self.kind.drives:
            clear = self._verge(1 if across > 0 else -1) + self.size[1] / 2 + 0.3
            if not self.kind.on_road and abs(across) < clear:
                aside = abs(reference.pose.across) > self.road.edge and self.relation in ("in-front-of", "behind")
                across = reference.side * clear if aside else math.copysign(clear, across)
            return across, 0.0 if across > 0 else BACKWARDS
        lanes = self.lanes or [(n, 1) for n in range(self.road.lanes)] + [(n, -1) for n in range(self.road.oncoming)]
        ways = [(self.road.lane(n, way), way) for n, way in lanes]
        at_kerb = abs(across) > self.road.edge - self.road.parking
        if self.road.parking and not self.lanes and (self.heading == "parked" or at_kerb):
            ways += [(s * (self.road.edge - self.road.parking / 2), -s) for s in (1, -1)]
        if reference.kind.drives and self.road.paved_areas and not self.lanes:
            ways.append((across, reference.forwards))
        elif self.road.paved_areas and not self.lanes and self.heading in (None, "parked"):  # in front of a shop
            bay, yaw = min(row_poses(self.road, reference.side), key=lambda row: abs(row[0] - across))
            if abs(bay - across) < abs(min(ways, key=lambda way: abs(way[0] - across))[0] - across):
                return bay, at.turned(yaw)
        if side:  # beside it, not in its own lane
            ways = [way for way in ways if (way[0] - reference.pose.across) * side > 1.0] or ways
        lane, way = min(ways, key=lambda way: (round(abs(way[0] - across), 2), way))
        same_row = abs(lane - reference.pose.across) < 1.0 and reference.kind.drives
        if self.heading in ("with", "against"):
            return lane, at.turned(0.0 if self.heading == "with" else BACKWARDS)
        return lane, at.turned(reference.pose.yaw if same_row else 0.0 if way > 0 else BACKWARDS)

    def _verge(self, side: int) -> float:
        """The distance from the centreline to the land that this kind stands on, on a side [m]."""
        if self.road.paved_areas and "sidewalk" not in self.kind.surfaces:  # lamps and trees are in the car park too
            return lot_edge(self.road, side)
        return self.road.edge if "sidewalk" in self.kind.surfaces else self.road.verge
