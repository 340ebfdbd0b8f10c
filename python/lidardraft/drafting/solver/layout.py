"""The solver: a spec and a seed become a layout in which nothing overlaps and everything stands on its ground."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Iterator, Mapping

import numpy as np

from lidardraft.arranging.district import SETTINGS, only_district
from lidardraft.drafting.solver.kept import unkept
from lidardraft.drafting.solver.poses import RoadPose, Try, each_lane, lanes_of, sample_full
from lidardraft.drafting.solver.relative_poses import Footprint, RelativePoses
from lidardraft.drafting.solver.road_from_spec import road_from_spec
from lidardraft.drafting.solver.road_zones import Zone, along_row, measured_from, zone_of
from lidardraft.drafting.solver.scene import GAP, SpecScene, is_at
from lidardraft.drafting.solver.scene_spec import (
    CLOSED,
    EXTENTS,
    ObjectGroup,
    SceneSpec,
    count_text,
    group_relations,
    split_place,
)
from lidardraft.errors import LayoutError, check_seed
from lidardraft.objects.kinds import SENTENCE_KINDS
from lidardraft.objects.sentence_kind import SentenceKind
from lidardraft.scene.intent import Intent
from lidardraft.scene.layout import Layout
from lidardraft.scene.road_network import RoadNetwork
from lidardraft.scene.street import StreetFrame

TRIES = 60  # places tried for one object
ARRANGEMENTS = 10  # of the whole scene
_CROWDED = 100  # objects of a group that needs more room from the start
_DEEPER = 5  # the first arrangement in which the buildings of an alley may be further back
_LATER = 4.0  # m by which a row begins later in each arrangement
_MOST_SPACED = 40  # objects of a row if the number is a word
# Estimates.
_APART = 1.5  # m between objects in a row at a wall
_BETWEEN_CROWNS = 0.3  # m
_LONGEST_ROW, _SHORTEST_STRIP = 90.0, 3.0  # m, of many walls or hedges together, and of one of them
_NARROWEST = 5.0  # m, of a house in a long terrace
_BARRIER = 2.0  # m, the length of a fence or wall that stands in a lane, across it
_AT_KERB = (0.1, 0.4)  # m from the road to the fronts of an alley
_LEAST = 200  # tries to find room in a crowd before its limit is estimated
# Objects placed at random saturate at 0.56 (squares) or 0.75 (along a line) of their area (Feder, J. Theor. Biol. 1980;
# Renyi, 1958). If a share r of places is still free, at most (1 + c sqrt(r) / (1 - r)) times the placed objects fit. c
# is 1.2 to 2.3 for these, at any density, so a crowd with room is never given up.
_FACTOR = 2.6


def layout_from_spec(spec: SceneSpec, *, seed: int = 0) -> Layout:
    """A layout in which every relation of the spec holds and that passes every check; the same for the same arguments.

    If an object finds no room, the scene is arranged again, with that object first and more room for the properties
    that the spec leaves open. `layout.intent` holds the request for each object, `layout.roads` the road,
    `layout.provenance` the spec; a note names the properties that the objects do not keep.

    Raises `LayoutError` on an invalid seed, and if a relation cannot hold: the error names the relation, the number of
    objects that found room, and the obstacles.
    """
    seed = check_seed(seed)
    urgent: dict[int, int] = {}  # groups without room, and the arrangement in which they found none
    crowded = False
    most = max((group.fewest or 0 for group in spec.groups), default=0)
    for attempt in range(min(most // _CROWDED, ARRANGEMENTS - 3), ARRANGEMENTS):
        solver = _Solver(spec, seed, attempt)
        failed = solver.arrange(urgent)
        if failed is None:
            return solver.layout(seed)
        urgent |= dict.fromkeys(with_references(spec, failed), attempt)
        if solver.crowd is not None and not crowded:  # skips to the last arrangement, which has most room
            crowded, solver = True, _Solver(spec, seed, ARRANGEMENTS - 1)
            if solver.arrange(urgent) is not None:
                break
    raise LayoutError(solver.refusal)


class _Solver:
    """One arrangement of a scene; `attempt` counts the failed ones before it."""

    def __init__(self, spec: SceneSpec, seed: int, attempt: int) -> None:
        self.spec, self.attempt = spec, attempt
        self.rng = np.random.default_rng([seed, attempt] if attempt else seed)
        self.road = road_from_spec(spec, self.rng, attempt)
        self.groups = tuple(with_gap(closed(group, self.rng)) for group in with_sides(long_strips(spec.groups)))
        if spec.district == "alley" and attempt < _DEEPER:
            self.groups = tuple(map(at_the_kerb, self.groups))
        self.scene = SpecScene(self.road, self.rng)
        self.placed: dict[int, list[Footprint]] = {}
        self.crowd: Crowd | None = None
        self.overcrowded = False
        self.refusal = ""

    def arrange(self, urgent: dict[int, int]) -> int | None:
        """Place all groups; returns the number of the group that found no room, or None."""
        for number in placing_order(self.spec, urgent):
            if number in self.placed:
                continue
            group, row = self.groups[number], row_of(self.spec, number)
            places = group.places or ("",)
            if not (self._place_row(*row) if row else all(self._fill(number, group, place) for place in places)):
                return number
        return None

    def layout(self, seed: int) -> Layout:
        """The layout of the placed objects."""
        kind, where = self.spec.road.kind, self.spec.district
        speed = SETTINGS[where or only_district(self.road, kind) or "urban"].speed
        roads = RoadNetwork(street=StreetFrame(road=self.road, speed=speed))
        objects = {footprint.name: number for number in self.placed for footprint in self.placed[number]}
        spec = self.spec.to_dict()
        provenance = {"source": "spec", "seed": seed, "spec": spec, "objects": objects}
        intent = Intent.of_spec(spec, objects)
        layout = Layout(primitives=tuple(self.scene.primitives), provenance=provenance, roads=roads, intent=intent)
        return layout.noted(*unkept(self.spec, layout, self.road, objects))

    def _fill(self, number: int, group: ObjectGroup, place: str) -> bool:
        """Place the objects of a group at one place; a number is met exactly, a word by as many as find room."""
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
        if len(placed) < least:
            self._refuse(self.spec.groups[number], place, len(placed), wanted)
        return len(placed) >= least

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
        """The reference objects for a group, those at its own place if there are any; for "between", two neighbours."""
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
        self, group: ObjectGroup, kind: SentenceKind, relation: str, near: list[Footprint], index: int, place: str
    ) -> Footprint | None:
        assert kind.sizes is not None
        asked, scale = group.size or (None, None), group.scale or (1.0, 1.0)
        length, width = (asked[axis] or kind.sizes.largest[axis] * scale[axis] for axis in (0, 1))
        lanes = lanes_of(group, "", "", self.road) if group.lane is not None else ()
        if relation == "between" and near[0] is near[-1]:
            relation = "beside"  # "the parked cars" turned out to be one car
        poses = RelativePoses(
            self.road, kind, (length, width), group.heading, relation, group.distance, lanes, group.surface
        )
        for attempt in range(TRIES):
            pose = poses.sample(near, Try(self.rng, 0.0, index, attempt / TRIES))
            if pose is None or not is_at(pose, place, self.road):
                self.scene.in_the_way["the road" if pose is None else "the other place that it has"] += 1
                continue
            footprint = self.scene.place(kind, group, pose)
            if footprint is not None:
                return footprint
        return None

    def _place_row(self, first: int, between: int, last: int) -> bool:
        """Place one object, then in line with it those of the group between, then the other one."""
        start = self.spec.groups[first]
        self.scene.in_the_way.clear()
        found = self._place(start, (start.places or ("",))[0], 0, 1)
        line = [found] if found else []
        wanted = self._count(self.spec.groups[between], "one")
        self.placed[first] = list(line)
        for member in [between] * wanted + [last] if line else []:
            group = self.spec.groups[member]
            place = (group.places or ("",))[0]
            found = self._place_relative(group, self._kind(group), "row", line[-1:], 0, place)
            if found is None:
                break
            line.append(found)
            self.placed.setdefault(member, []).append(found)
        if len(line) < wanted + 2:
            self._refuse(self.spec.groups[between], "", max(0, len(line) - 1), wanted)
        return len(line) == wanted + 2

    def _refuse(self, group: ObjectGroup, place: str, placed: int, wanted: int) -> None:
        kind, asked = group.record, wanted if isinstance(group.count, int) else count_text(group)
        room = f"At most {self.crowd.most(placed)}" if self.crowd and self.overcrowded else f"Only {placed}"
        fits = f"{room} of {asked} {kind.plural} fit"
        if placed == 0:
            several = group.fewest is not None and wanted > 1
            fits = f"None of {asked} {kind.plural} fits" if several else f"No {kind.name.replace('-', ' ')} fits"
        blockers = [name for name, _ in self.scene.in_the_way.most_common()] or ["the end of the road"]
        more = f" and {len(blockers) - 3} more" if len(blockers) > 3 else ""
        self.refusal = (
            f"{' '.join([fits, ', '.join(group_relations(group, self.spec, place))]).strip()}; "
            f"blocked by {', '.join(blockers[:3])}{more}; ask for fewer or for another place"
        )

    def _least(self, group: ObjectGroup, wanted: int) -> int:
        """The least number of objects for a count; in the last arrangement one is enough for a word."""
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
        """How many times a count applies at one place: once for each lane, or once."""
        return len(each_lane(group, self.road)) if group.lane == "each" else 1

    def _kind(self, group: ObjectGroup) -> SentenceKind:
        """The kind of one object of a group: its own, or one of the mix of traffic."""
        kind = group.record
        if kind.sizes is not None:
            return kind
        mix = [one for one in SENTENCE_KINDS.values() if one.traffic_share and one.name not in self.spec.absent]
        if group.heading == "parked":  # kinds that fit a usual parking strip
            mix = [one for one in mix if one.parking_width < kind.parking_width]
        if group.spacing is not None:  # kinds that fit into a row, or the shortest
            room = group.spacing - GAP
            mix = [one for one in mix if _longest(one) <= room] or sorted(mix, key=_longest)[:1]
        if not mix:
            raise LayoutError(f"{kind.name}: every kind of it is absent: {', '.join(self.spec.absent)}")
        shares = np.array([one.traffic_share for one in mix])
        return SENTENCE_KINDS[str(self.rng.choice([one.name for one in mix], p=shares / shares.sum()))]

    def _poses(self, zone: Zone, group: ObjectGroup, number: int, wanted: int) -> Iterator[tuple[bool, bool, RoadPose]]:
        """The poses to try in order: in the object's own slot first, then, unless it is bound to it, anywhere.

        Each comes with whether it is anywhere, and whether it is the pose of the near end.
        """
        rng, (near, far) = self.rng, zone.span
        step = (far - near) / wanted
        # an object that blocks another one behind or in front of it is moved as far as its distance allows
        referenced = any(self.groups[one] is group for other in self.groups for one in other.references)
        leeway = self.attempt / ARRANGEMENTS if referenced else 0.0
        bound = group.distance is not None and group.distance[0] == group.distance[1] == abs(near)
        tries = TRIES * 5 if wanted >= _CROWDED else TRIES
        for attempt in range(tries):
            in_slot, by_end, further = attempt < tries // 4, False, 0.0
            if group.spacing is not None:
                spacing = math.copysign(group.spacing, far - near)
                along = along_row(group, self.road, near, spacing, number // zone.sides)
                if abs(along) > self.road.half_length:
                    self.scene.in_the_way["the end of the road"] += 1
                    return
            elif near == far or (bound and number < self._times(group) and in_slot):  # the first of a row
                if group.distance:
                    further, by_end = measured_from(max(leeway, (1 if near == far else 4) * attempt / tries))
                along = near + math.copysign(further, near)
            elif in_slot:
                along = near + step * (number + float(rng.uniform(0.25, 0.75)))
            else:
                along = near + (far - near) * float(rng.random())
            effort = float(rng.random()) if wanted >= _CROWDED else attempt / tries
            effort = max(leeway, effort * (1 + self.attempt) ** 1.3)
            anywhere = not in_slot and group.spacing is None
            yield anywhere, by_end, zone.sample_pose(Try(rng, along, number, effort))


def _longest(kind: SentenceKind) -> float:
    return kind.sizes.largest[0] if kind.sizes is not None else math.inf


@dataclasses.dataclass(slots=True)
class Crowd:
    """The most objects of a crowd that can find room, estimated from the share of recent random places that were
    free."""

    tries: float = 0.0
    free: float = 0.0

    def add(self, *, found: bool) -> None:
        """Count a random place, free or not."""
        forget = 1.0 - 1.0 / _LEAST if self.tries >= _LEAST else 1.0
        self.tries, self.free = self.tries * forget + 1.0, self.free * forget + found

    def most(self, placed: int) -> float:
        """The most objects that find room in all, if `placed` have; infinite while too little is known."""
        # two standard deviations more than counted, plus two
        share = (self.free + 2 * math.sqrt(self.free) + 2) / self.tries if self.tries >= _LEAST else 1.0
        return math.inf if share >= 1.0 else math.ceil(placed * (1.0 + _FACTOR * math.sqrt(share) / (1.0 - share)))


def placing_order(spec: SceneSpec, urgent: Mapping[int, int]) -> list[int]:
    """The numbers of the groups in the order of placing: `urgent` ones, those with relations, bound ones, the largest.

    The urgent groups are those that found no room, with the arrangement in which they did not: the latest first.
    """
    referenced = {reference for group in spec.groups for reference in group.references}

    def depth(number: int) -> int:
        return max((1 + depth(reference) for reference in spec.groups[number].references), default=0)

    def rank(number: int) -> tuple[int, bool, int, bool, bool, int]:
        group = spec.groups[number]
        related = number in referenced or bool(group.references)
        bound = group.distance is None, group.spacing is None, -group.record.precedence
        return -urgent.get(number, -1), not related, depth(number), *bound

    return sorted(range(len(spec.groups)), key=rank)


def with_references(spec: SceneSpec, number: int) -> set[int]:
    """A group, and all groups that its place depends on."""
    return {number}.union(*(with_references(spec, reference) for reference in spec.groups[number].references))


def row_of(spec: SceneSpec, number: int) -> tuple[int, int, int] | None:
    """The two ends of a row and the group between them, if a group is one of its ends and both are free to move."""
    for between, group in enumerate(spec.groups):
        ends = group.references
        if group.relation != "between" or number not in ends:
            continue
        counts = {spec.groups[end].fewest for end in ends}
        if (len(ends), counts) not in ((1, {2}), (2, {1})) or not all(_is_free(spec.groups[end]) for end in ends):
            continue
        if len({spec.groups[end].places for end in ends}) > 1:
            continue
        if isinstance(group.count, int) and group.heading not in ("across", "parked"):
            return ends[0], between, ends[-1]
    return None


def long_strips(groups: tuple[ObjectGroup, ...]) -> tuple[ObjectGroup, ...]:
    """The groups, with a length for walls and hedges whose length is open."""
    found = []
    for number, group in enumerate(groups):
        length = _strip_length(group, [other for other in groups if other.references == (number,)])
        size = (length, *(group.size or (None, None, None))[1:])
        found.append(group if length is None else dataclasses.replace(group, size=size))
    return tuple(found)


def _strip_length(group: ObjectGroup, at_it: list[ObjectGroup]) -> float | None:
    """The length of a strip [m], None if it is given or the usual one.

    A single strip is as long as the row of objects at it, many are shorter than usual, and in a lane they are short.
    """
    sizes, count = group.record.sizes, group.fewest or 0
    if sizes is None or not group.record.follows_road or (group.size and group.size[0] is not None):
        return None
    if group.on_road:
        return _BARRIER
    if count > 1:
        length = (_LONGEST_ROW - count * (group.spacing or _APART)) / count
        usual = (sizes.smallest[0] + sizes.largest[0]) / 2
        shorter = length < sizes.largest[0] and group.relation is None
        return max(_SHORTEST_STRIP, min(length, usual)) if shorter else None
    row = max(map(_row_length, at_it), default=0.0)
    return row if group.count == 1 and row > sizes.largest[0] else None


def with_sides(groups: tuple[ObjectGroup, ...]) -> tuple[ObjectGroup, ...]:
    """The groups, in which an unplaced group gets the side that the place of another group relative to it requires.

    With roadside objects to its left, a roadside group is on the left side of the road; with vehicles to its left, on
    the right side.
    """
    found = list(groups)
    for group in groups:
        sides = {split_place(place)[1] for place in group.places}
        if group.relation in ("left-of", "right-of") and not group.places:
            sides = {"left" if (group.relation == "left-of") != group.on_road else "right"}
        if group.record.is_vehicle and group.relation == "near" and group.heading is None and not group.places:
            sides = {"right"}  # it can be overtaken there
        for number in group.references:
            reference = found[number]
            free = not (reference.places or reference.not_places or reference.references or reference.lane)
            if len(sides) == 1 and sides <= {"left", "right"} and free and not reference.record.drives:
                (side,) = sides
                side = side if group.relation != "opposite" else "right" if side == "left" else "left"
                found[number] = dataclasses.replace(reference, places=(side,))
    return tuple(found)


def with_gap(group: ObjectGroup) -> ObjectGroup:
    """The group; a spacing shorter than the objects becomes the gap between the end of one and the start of the next.

    All objects then have one length; trees have one that leaves room for the crowns.
    """
    spacing, sizes, size = group.spacing, group.record.sizes, group.size or (None, None, None)
    if spacing is None or group.relation is not None or sizes is None:
        return group
    scale = (group.scale or (1.0,))[0]
    if group.kind in ("tree", "bush"):
        crown = max(EXTENTS[0], spacing - _BETWEEN_CROWNS)
        if size[0] is None and crown < sizes.smallest[0] * scale:
            group = dataclasses.replace(group, size=(crown, crown, size[2]))
        return group
    least = size[0] or sizes.smallest[0] * scale
    length = size[0] or (sizes.smallest[0] + sizes.largest[0]) / 2 * scale
    if spacing >= least + GAP:
        return group
    return dataclasses.replace(group, size=(length, *size[1:]), spacing=spacing + length)


def closed(group: ObjectGroup, rng: np.random.Generator) -> ObjectGroup:
    """The group with one size and in line, if it is a row without gaps."""
    kind = group.record
    if kind.sizes is None or not group.is_closed:
        return group
    asked, times = group.size or (None,) * 3, group.scale or (1.0,) * 3
    size = [said or one * factor for said, one, factor in zip(asked, kind.sizes.sample(rng), times, strict=True)]
    size[0] = min(size[0], max(_NARROWEST, _LONGEST_ROW / (group.fewest or 1)))
    back = group.from_sidewalk
    if kind.setback is not None and not group.set_back:
        back = (max(0.1, kind.setback[0] - kind.sizes.largest[1] / 2),) * 2
    return dataclasses.replace(group, size=(size[0], size[1], size[2]), spacing=CLOSED, from_sidewalk=back)


def at_the_kerb(group: ObjectGroup) -> ObjectGroup:
    """The group, with its front at the kerb if it is of buildings whose place is open."""
    free = group.record.family == "buildings" and not (group.relation or group.distance or group.set_back)
    return dataclasses.replace(group, from_road=_AT_KERB) if free else group


def _row_length(group: ObjectGroup) -> float:
    """The length of a row of all its objects [m]; 0 for vehicles and single objects."""
    sizes, count = group.record.sizes, group.count
    most = getattr(group.record.counts, count)[1] if isinstance(count, str) else count
    most = most[1] if isinstance(most, tuple) else most
    if sizes is None or group.record.is_vehicle or most < 2:
        return 0.0
    return min(EXTENTS[1], most * (sizes.largest[0] + _APART))


def _is_free(group: ObjectGroup) -> bool:
    return group.relation is None and group.distance is None and group.spacing is None and len(group.places) < 2
