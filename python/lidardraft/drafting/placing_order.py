"""In which order the groups of a spec are placed, and which of them are placed as one row."""

from __future__ import annotations

from lidardraft.drafting.scene_spec import ObjectGroup, SceneSpec


def placing_order(spec: SceneSpec, urgent: set[int]) -> list[int]:
    """The numbers of the groups as they are placed: the `urgent`, what has relations, what is bound, the largest."""
    referenced = {reference for group in spec.groups for reference in group.references}

    def depth(number: int) -> int:
        return max((1 + depth(reference) for reference in spec.groups[number].references), default=0)

    def rank(number: int) -> tuple[bool, bool, int, bool, bool, int]:
        group = spec.groups[number]
        related = number in referenced or bool(group.references)
        bound = group.distance is None, group.spacing is None, -group.record.precedence
        return number not in urgent, not related, depth(number), *bound

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


def _is_free(group: ObjectGroup) -> bool:
    return group.relation is None and group.distance is None and group.spacing is None and len(group.places) < 2
