"""In which order the groups of a spec are placed, which of them as one row, and what their relations leave of them."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

from lidardraft.drafting.solver.occupancy import GAP
from lidardraft.drafting.solver.scene_spec import EXTENTS, ObjectGroup, SceneSpec, split_place

# Estimates of ours.
_APART = 1.5  # m between what stands in a row at a wall
_BETWEEN_CROWNS = 0.3  # m
_LONGEST_ROW, _SHORTEST_STRIP = 90.0, 3.0  # m, of many walls or hedges together, and of one of them
_BARRIER = 2.0  # m, the length of a fence or wall that stands in a lane, across it


def placing_order(spec: SceneSpec, urgent: Mapping[int, int]) -> list[int]:
    """The numbers of the groups as they are placed: the `urgent`, what has relations, what is bound, the largest.

    The urgent are those that found no room, with when they did so: the last of them first.
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
    """A group, and all that it is placed from."""
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
    """The groups, with the length of walls and hedges whose length is open.

    One is as long as a row of what stands at it, many are shorter than usual, and in a lane they are short.
    """
    found = []
    for number, group in enumerate(groups):
        sizes, size = group.record.sizes, group.size or (None, None, None)
        if group.record.follows_road and group.on_road and size[0] is None:
            group = dataclasses.replace(group, size=(_BARRIER, *size[1:]))
        elif group.record.follows_road and size[0] is None and (group.fewest or 0) > 1:
            length = (_LONGEST_ROW - (group.fewest or 0) * (group.spacing or _APART)) / (group.fewest or 1)
            if sizes is not None and length < sizes.largest[0] and group.relation is None:
                length = max(_SHORTEST_STRIP, min(length, (sizes.smallest[0] + sizes.largest[0]) / 2))
                group = dataclasses.replace(group, size=(length, *size[1:]))
        elif group.record.follows_road and group.count == 1 and size[0] is None and sizes is not None:
            rows = [_row_length(other) for other in groups if other.references == (number,)]
            if max(rows, default=0.0) > sizes.largest[0]:
                group = dataclasses.replace(group, size=(max(rows), *size[1:]))
        found.append(group)
    return tuple(found)


def with_sides(groups: tuple[ObjectGroup, ...]) -> tuple[ObjectGroup, ...]:
    """The groups, where what is placed nowhere is on the side that something at one side is placed from it.

    What stands beside the road has others that do so to the left of it only on the left side, and vehicles only on the
    right side.
    """
    found = list(groups)
    for group in groups:
        sides = {split_place(place)[1] for place in group.places}
        if group.relation in ("left-of", "right-of") and not group.places:
            sides = {"left" if (group.relation == "left-of") != group.on_road else "right"}
        for number in group.references:
            reference = found[number]
            free = not (reference.places or reference.not_places or reference.references or reference.lane)
            if len(sides) == 1 and sides <= {"left", "right"} and free and not reference.record.drives:
                (side,) = sides
                side = side if group.relation != "opposite" else "right" if side == "left" else "left"
                found[number] = dataclasses.replace(reference, places=(side,))
    return tuple(found)


def with_gaps(groups: tuple[ObjectGroup, ...]) -> tuple[ObjectGroup, ...]:
    """The groups, where a spacing that is shorter than the objects is that between the end of one and the next."""
    return tuple(map(_with_gap, groups))


def _with_gap(group: ObjectGroup) -> ObjectGroup:
    """All objects are of one length then, that of trees what leaves room for the crowns."""
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


def _row_length(group: ObjectGroup) -> float:
    """How long a row of all its objects is [m], 0 for what drives or is one."""
    sizes, count = group.record.sizes, group.count
    most = getattr(group.record.counts, count)[1] if isinstance(count, str) else count
    most = most[1] if isinstance(most, tuple) else most
    if sizes is None or group.record.is_vehicle or most < 2:
        return 0.0
    return min(EXTENTS[1], most * (sizes.largest[0] + _APART))


def _is_free(group: ObjectGroup) -> bool:
    return group.relation is None and group.distance is None and group.spacing is None and len(group.places) < 2
