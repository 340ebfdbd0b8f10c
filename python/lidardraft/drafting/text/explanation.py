"""The effects of the words of a sentence: a value to inspect, and lines to print."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from lidardraft.drafting.solver.scene_spec import SceneSpec, count_text, group_relations, road_relations


@dataclass(frozen=True, slots=True)
class Meaning:
    """Some words in a row, and their effects on the spec.

    `groups` are the numbers of the groups that they describe, `others` their statements about the road and the
    surroundings; both are empty for words that only join others. `lost` are the words without effect, `unshown` those
    that are understood, but have no shape.
    """

    words: str
    groups: tuple[int, ...] = ()
    others: tuple[str, ...] = ()
    lost: tuple[str, ...] = ()
    unshown: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Explanation:
    """The words of a sentence in their order, with the effect of each, and its spec.

    `mismatches` are lines on statements of the sentence that the spec does not hold, or holds otherwise.
    """

    meanings: tuple[Meaning, ...]
    spec: SceneSpec
    not_shown: tuple[str, ...] = ()
    mismatches: tuple[str, ...] = ()

    def __str__(self) -> str:
        """A line for each run of words; a group is described at its first mention."""
        wide = max(len(one.words) for one in self.meanings)
        told: set[int] = set()
        lines = []
        for one in self.meanings:
            lines.append(f"{one.words:<{wide}}  {self._said(one, told)}".rstrip())
            told |= set(one.groups)
        return "\n".join([*lines, f"road: {', '.join(road_relations(self.spec.road))}", *self.mismatches])

    def _said(self, one: Meaning, told: Collection[int]) -> str:
        gave = [*(self._group(number, number in told) for number in one.groups), *one.others]
        left = (("not understood", one.lost), ("not shown", one.unshown))
        notes = [f"{what}: {', '.join(words)}" if gave else what for what, words in left if words]
        return "; ".join([*gave, *notes])

    def _group(self, number: int, told: bool) -> str:
        group = self.spec.groups[number]
        if told:
            return f"{group.kind} [{number}]"
        places = [", ".join(group_relations(group, self.spec, place)) for place in group.places or ("",)]
        return f"{group.kind} [{number}]: {', '.join(filter(None, [count_text(group), ' and '.join(places)]))}"
