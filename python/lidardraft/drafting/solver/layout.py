"""The solver: a spec and a seed become a layout in which nothing overlaps and everything stands on its ground."""

from __future__ import annotations

import dataclasses
import itertools
import json
import math
from collections.abc import Iterator

import numpy as np

from lidardraft.drafting.solver.crowd import Crowd
from lidardraft.drafting.solver.lane_poses import each_lane, lanes_of
from lidardraft.drafting.solver.occupancy import GAP, Occupancy, is_at
from lidardraft.drafting.solver.parking_bays import sample_full
from lidardraft.drafting.solver.placing_order import (
    long_strips,
    placing_order,
    row_of,
    with_gaps,
    with_references,
    with_sides,
)
from lidardraft.drafting.solver.relation_text import group_relations
from lidardraft.drafting.solver.relative_poses import Footprint, RelativePoses
from lidardraft.drafting.solver.road_from_spec import road_from_spec
from lidardraft.drafting.solver.road_pose import RoadPose
from lidardraft.drafting.solver.road_zones import Zone, along_row, measured_from, zone_of
from lidardraft.drafting.solver.scene_spec import ObjectGroup, SceneSpec
from lidardraft.drafting.solver.sentence_kinds import SENTENCE_KINDS, SentenceKind
from lidardraft.errors import LayoutError
from lidardraft.scene.layout import Layout

TRIES = 60  # of places for one object
ARRANGEMENTS = 10  # of the whole scene
_CROWDED = 100  # objects of one group that need more room from the start
_LATER = 4.0  # m that a row begins later with each arrangement
_MOST_SPACED = 40  # objects of a row whose number is a word


def layout_from_spec(spec: SceneSpec, seed: int = 0) -> Layout:
    """A layout in which every relation of the spec holds and that passes every check; the same for the same arguments.

    What finds no room makes the scene be arranged anew, with that first and more room for what the spec leaves open.
    `layout.provenance` holds the spec, the numbers of the road, and for each object the number of its group.

    Raises `LayoutError` on a seed that is no integer >= 0, and where a relation cannot hold, naming it, how many of how
    many objects found room, and what is in the way.
    """
    check_seed(seed)
    urgent: dict[int, int] = {}  # the groups that found no room, and in which arrangement
    crowded = False
    most = max((group.fewest or 0 for group in spec.groups), default=0)
    for attempt in range(min(most // _CROWDED, ARRANGEMENTS - 3), ARRANGEMENTS):
        solver = _Solver(spec, seed, attempt)
        failed = solver.arrange(urgent)
        if failed is None:
            return Layout(primitives=tuple(solver.scene.primitives), provenance=solver.provenance(seed))
        urgent |= dict.fromkeys(with_references(spec, failed), attempt)
        if solver.crowd is not None and not crowded:  # whether those between are worth the time: the last has most room
            crowded, solver = True, _Solver(spec, seed, ARRANGEMENTS - 1)
            if solver.arrange(urgent) is not None:
                break
    raise LayoutError(solver.refusal)


def check_seed(seed: int) -> None:
    """Raises `LayoutError` on a seed that is no integer >= 0."""
    if type(seed) is not int or seed < 0:
        raise LayoutError(f"seed is {seed!r}; it must be an integer >= 0")


class _Solver:
    """One arrangement of a scene; `attempt` numbers those that came to nothing before."""

    def __init__(self, spec: SceneSpec, seed: int, attempt: int) -> None:
        self.spec, self.attempt = spec, attempt
        self.groups = with_gaps(with_sides(long_strips(spec.groups)))
        self.rng = np.random.default_rng([seed, attempt] if attempt else seed)
        self.road = road_from_spec(spec, self.rng, attempt)
        self.scene = Occupancy(self.road, self.rng)
        self.placed: dict[int, list[Footprint]] = {}
        self.crowd: Crowd | None = None
        self.overcrowded = False
        self.refusal = ""

    def arrange(self, urgent: dict[int, int]) -> int | None:
        """Place all groups; the number of the group that found no room, or None."""
        spec = self.spec
        for number in placing_order(spec, urgent):
            if number in self.placed:
                continue
            group = self.groups[number]
            row = row_of(spec, number)
            if row is not None:
                if not self._place_row(row):
                    return number
                continue
            for place in group.places or ("",):
                if not self._fill(number, group, place):
                    return number
        return None

    def provenance(self, seed: int) -> dict[str, object]:
        """Where the layout came from, as JSON types."""
        objects = {footprint.name: number for number in self.placed for footprint in self.placed[number]}
        return {
            "source": "spec",
            "seed": seed,
            "spec": self.spec.to_dict(),
            "road": json.loads(json.dumps(dataclasses.asdict(self.road))),
            "objects": objects,
        }

    def _fill(self, number: int, group: ObjectGroup, place: str) -> bool:
        """Place what a group wants at one place; a number is met exactly, a word by as many as find room."""
        wanted = self._count(group, place)
        least = self._least(group, wanted)
        self.scene.in_the_way.clear()
        self.crowd = Crowd() if wanted >= _CROWDED else None
        placed: list[Footprint] = []
        for index in range(wanted):
            footprint = self._place(group, place, index, wanted)
            if footprint is not None:
                placed.append(footprint)
            elif isinstance(group.count, int):
                break
            self.overcrowded = self.crowd is not None and self.crowd.most(len(placed)) < least
            if self.overcrowded:
                break
        self.placed.setdefault(number, []).extend(placed)
        if len(placed) >= least:
            return True
        self._refuse(self.spec.groups[number], place, len(placed), wanted)
        return False

    def _place(self, group: ObjectGroup, place: str, index: int, wanted: int) -> Footprint | None:
        kind = self._kind(group)
        if group.relation is not None:
            return self._place_relative(group, kind, group.relation, self._references(group, place), index, place)
        bound = group.distance is not None or place.startswith("beside")
        zone = zone_of(group, kind, place, self.road).grown(0 if bound else self.attempt, self.road)
        if group.spacing is not None and not bound:
            length = group.spacing * ((wanted - 1) // zone.sides)
            zone = zone.in_row(length, self.road, self.attempt * _LATER, around=not kind.drives)
        for anywhere, by_end, pose in self._poses(zone, group, index, wanted):
            footprint = self.scene.place(kind, group, pose, by_end=by_end)
            if anywhere and self.crowd is not None:
                self.crowd.add(found=footprint is not None)
            if footprint is not None:
                return footprint
        return None

    def _references(self, group: ObjectGroup, place: str) -> list[Footprint]:
        """What the objects of a group are placed from, at their own place if any are; between, two neighbours."""
        each = [self.placed[reference] for reference in group.references]
        there = [[one for one in found if is_at(one.pose, place, self.road)] for found in each]
        each = [near or found for near, found in zip(there, each, strict=True)]
        if group.relation != "between":
            return [footprint for footprints in each for footprint in footprints]
        if len(each) == 2:
            one = each[0][int(self.rng.integers(len(each[0])))]
            return [one, min(each[1], key=lambda other: math.dist(one.pose[:2], other.pose[:2]))]
        line = sorted(each[0], key=lambda footprint: (footprint.side, footprint.pose.along))
        pairs = list(itertools.pairwise(line)) or [(line[0], line[0])]
        pairs = [pair for pair in pairs if pair[0].side == pair[1].side] or pairs
        return list(pairs[int(self.rng.integers(len(pairs)))])

    def _place_relative(
        self,
        group: ObjectGroup,
        kind: SentenceKind,
        relation: str,
        references: list[Footprint],
        index: int,
        place: str,
    ) -> Footprint | None:
        assert kind.sizes is not None
        length, width, _ = kind.sizes.largest
        sides = (group.scale or (1.0, 1.0))[:2]
        size = tuple((group.size or (None, None))[axis] or (length, width)[axis] * sides[axis] for axis in (0, 1))
        lanes = lanes_of(group, "", "", self.road) if group.lane is not None else ()
        if relation == "between" and references[0] is references[-1]:
            relation = "beside"  # of "the parked cars" there is only one
        poses = RelativePoses(
            self.road, kind, (size[0], size[1]), group.heading, relation, group.distance, lanes, group.surface
        )
        for attempt in range(TRIES):
            pose = poses.sample(references, self.rng, index, attempt / TRIES)
            if pose is None or not is_at(pose, place, self.road):
                self.scene.in_the_way["the road" if pose is None else "the other place that it has"] += 1
                continue
            footprint = self.scene.place(kind, group, pose)
            if footprint is not None:
                return footprint
        return None

    def _place_row(self, row: tuple[int, int, int]) -> bool:
        """Place one object, then in line with it those of the group between, then the other one."""
        first, between, last = row
        start = self.spec.groups[first]
        self.scene.in_the_way.clear()
        found = self._place(start, (start.places or ("",))[0], 0, 1)
        line = [found] if found else []
        wanted = self._count(self.spec.groups[between], "one")
        members = [between] * wanted + [last]
        self.placed[first] = list(line)
        for member in members:
            if not line:
                break
            group = self.spec.groups[member]
            found = self._place_relative(group, self._kind(group), "row", line[-1:], 0, (group.places or ("",))[0])
            if found is None:
                break
            line.append(found)
            self.placed.setdefault(member, []).append(found)
        if len(line) == wanted + 2:
            return True
        self._refuse(self.spec.groups[between], "", max(0, len(line) - 1), wanted)
        return False

    def _refuse(self, group: ObjectGroup, place: str, placed: int, wanted: int) -> None:
        said = group_relations(group, self.spec, place)
        room = f"at most {self.crowd.most(placed)}" if self.crowd and self.overcrowded else placed
        asked = wanted if group.fewest is not None else repr(group.count)
        blockers = [name for name, _ in self.scene.in_the_way.most_common()] or ["the end of the road"]
        more = f" and {len(blockers) - 3} more" if len(blockers) > 3 else ""
        self.refusal = (
            f"{' '.join([group.kind, ', '.join(said)]).strip()}: {room} of {asked} found room; "
            f"in the way: {', '.join(blockers[:3])}{more}; ask for fewer or for another place"
        )

    def _least(self, group: ObjectGroup, wanted: int) -> int:
        """How many objects meet a count; in the last arrangement one is enough for a word."""
        if isinstance(group.count, int):
            return wanted
        if isinstance(group.count, tuple):
            return group.count[0] * self._times(group)
        few = getattr(group.record.counts, group.count)[0] * self._times(group)
        return 1 if self.attempt == ARRANGEMENTS - 1 else min(few, wanted)

    def _count(self, group: ObjectGroup, place: str) -> int:
        times = self._times(group)
        if isinstance(group.count, int):
            return group.count * times
        if isinstance(group.count, tuple):
            low, high = group.count
            return int(self.rng.integers(low, high + 1)) * times
        low, high = getattr(group.record.counts, group.count)
        if group.count == "many" and group.record.is_vehicle and self.road.paved_areas and not (place or group.lane):
            return sample_full(self.road, self.rng) if group.heading in (None, "parked") else high
        if group.spacing is not None:
            return max(low, min(_MOST_SPACED, int(100.0 / group.spacing)))
        if group.lane == "each":
            return int(self.rng.integers(low, high + 1)) * times
        return int(self.rng.integers(low, high + 1)) * (1 if place or group.relation else 2)

    def _times(self, group: ObjectGroup) -> int:
        """How often a count is meant at one place: in each lane, or once."""
        return len(each_lane(group, self.road)) if group.lane == "each" else 1

    def _kind(self, group: ObjectGroup) -> SentenceKind:
        """The kind of one object of a group: its own, or one of the mix that traffic is."""
        kind = group.record
        if kind.sizes is not None:
            return kind
        mix = [one for one in SENTENCE_KINDS.values() if one.traffic_share and one.name not in self.spec.absent]
        if group.heading == "parked":  # what a usual parking strip takes
            mix = [one for one in mix if one.parking_width < kind.parking_width]
        if group.spacing is not None:  # what fits into a row, or the shortest
            room = group.spacing - GAP
            mix = [one for one in mix if _longest(one) <= room] or sorted(mix, key=_longest)[:1]
        if not mix:
            raise LayoutError(f"{kind.name}: every kind of it is absent: {', '.join(self.spec.absent)}")
        shares = np.array([one.traffic_share for one in mix])
        return SENTENCE_KINDS[str(self.rng.choice([one.name for one in mix], p=shares / shares.sum()))]

    def _poses(self, zone: Zone, group: ObjectGroup, number: int, wanted: int) -> Iterator[tuple[bool, bool, RoadPose]]:
        """The poses to try in order: in the object's own slot first, then, unless it is bound to it, anywhere.

        With each goes whether it is anywhere, and whether it is that of the near end.
        """
        rng = self.rng
        near, far = zone.span
        step = (far - near) / wanted
        # what another object finds no room behind, or in front of, is moved as far as its distance allows
        referenced = any(self.groups[one] is group for other in self.groups for one in other.references)
        leeway = self.attempt / ARRANGEMENTS if referenced else 0.0
        bound = group.distance is not None and group.distance[0] == group.distance[1] == abs(near)
        tries = TRIES * 5 if wanted >= _CROWDED else TRIES
        for attempt in range(tries):
            by_end = False
            if group.spacing is not None:
                along = along_row(
                    group, self.road, near, math.copysign(group.spacing, far - near), number // zone.sides
                )
                if abs(along) > self.road.half_length:
                    self.scene.in_the_way["the end of the road"] += 1
                    return
            elif near == far:
                further, by_end = measured_from(max(leeway, attempt / tries)) if group.distance else (0.0, False)
                along = near + math.copysign(further, near)
            elif bound and number < self._times(group) and attempt < tries // 4:  # the first of a row
                further, by_end = measured_from(max(leeway, 4 * attempt / tries))
                along = near + math.copysign(further, near)
            elif attempt < tries // 4:
                along = near + step * (number + float(rng.uniform(0.25, 0.75)))
            else:
                along = near + (far - near) * float(rng.random())
            effort = float(rng.random()) if wanted >= _CROWDED else attempt / tries
            anywhere = attempt >= tries // 4 and group.spacing is None
            yield (
                anywhere,
                by_end,
                zone.sample_pose(rng, along, number, max(leeway, effort * (1 + self.attempt) ** 1.3)),
            )


def _longest(kind: SentenceKind) -> float:
    return kind.sizes.largest[0] if kind.sizes is not None else math.inf
