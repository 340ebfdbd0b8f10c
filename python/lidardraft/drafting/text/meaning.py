"""Checks of a spec against its sentence: nouns with their numbers, the road, sides, lengths and relations."""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Callable, Iterator, Sequence, Set
from functools import partial

import numpy as np

from lidardraft.drafting.solver.scene_spec import SceneSpec
from lidardraft.drafting.text.chart import Node
from lidardraft.drafting.text.grammar import parse
from lidardraft.drafting.text.lexicon import vocabulary
from lidardraft.drafting.text.tokens import clean, tokens_of
from lidardraft.drafting.text.tree import NounPhrase, Relation, leaves, noun_phrase, relation_of
from lidardraft.objects.kinds import SENTENCE_KINDS

_MOST = 200  # words read at once
_SHARING = {"each", "every", "per", "either"}  # "two trees in front of each house"
_DENYING = {"no", "none", "nothing", "nobody", "not", "without", "except", "but"}
# The groups that a phrase may name, each with its least and most objects; NaN and infinity for "some" and similar
# words.
Held = Callable[[NounPhrase], Sequence[tuple[float, float]]]


def omissions(text: str, held: Held) -> list[str]:
    """A line for each noun phrase of an English text for which a reply, read through `held`, has no object, too few or
    another number. There is none for a text with half of its words or more unknown to the lexicon."""
    tokens = tokens_of(clean(text), vocabulary())
    texts = [token.text for token in tokens]
    known = sum(word in vocabulary() or word.isdigit() for word in texts)
    parts = range(0, len(tokens) if 2 * known > len(tokens) else 0, _MOST)
    read = [(texts[first:], parse(tokens[first : first + _MOST])) for first in parts]
    return _missing(
        [(rest, one, phrase) for rest, nodes in read for one, phrase in _named(nodes)], texts, held, "reply"
    )


def mismatches(nodes: Sequence[Node], texts: Sequence[str], spec: SceneSpec, left: Set[int]) -> list[str]:
    """A line for each statement of a sentence that its spec does not hold, or holds otherwise.

    `nodes` are its constituents, `texts` its words; the words with the numbers `left` are reported already.
    """
    found = [one for one in _named(nodes) if one[0].end - 1 not in left]
    lines = _missing([(texts, *one) for one in found], texts, partial(held_by, spec), "scene")
    lines += [] if lines else _doubled(nodes, [phrase for _, phrase in found], texts, spec)
    said = {name: list[Node]() for name in ("road", "length", "relation")}
    for leaf in (leaf for node in nodes for kind in said for leaf in leaves(node, kind)):
        said[leaf.symbol] += [leaf] if left.isdisjoint(range(leaf.start, leaf.end)) else []
    lost = [(one, f"the road is {spec.road.kind}") for one in said["road"] if not _is_on(one.get("road"), spec)]
    lost += [(one, "no length is that") for one in said["length"] if not _has_length(one.get("length"), spec)]
    lost += [(one, "nothing is placed from that") for one in _unplaced(said["relation"], spec)]
    lines += [f"the sentence says {_words_of(texts, one)!r}; in the scene {what}" for one, what in lost]
    for one, after in itertools.pairwise(nodes):  # but not "bus (1) car (2)"
        words = texts[one.start : after.end]
        beside = (one.symbol, after.symbol) == ("object", "object") and "(" not in words
        if beside and left.isdisjoint(range(one.start, after.end)):
            lines.append(f"the sentence says {' '.join(words)!r}; it is read as two things")
    if _DENYING.isdisjoint(texts):
        sides = {word for number, word in enumerate(texts) if word in ("left", "right") and number not in left}
        lines += [
            f"the sentence says {one!r}; in the scene nothing is there" for one in sorted(sides - _sides_of(spec))
        ]
    return list(dict.fromkeys(lines))


def held_by(spec: SceneSpec, phrase: NounPhrase) -> list[tuple[float, float]]:
    """The groups of a spec that a phrase may name, in the form for `omissions`; a rider may be a "person" of the
    text."""
    kind, found = SENTENCE_KINDS[str(phrase.kind)], list[tuple[float, float]]()
    if kind.name in (*spec.absent, *spec.not_around) or any(phrase.noun in said for said in spec.not_understood):
        return [(0, math.inf)]
    for group in spec.groups:
        its = SENTENCE_KINDS[group.kind]
        fits = its == kind or (kind.name == "person" and its.is_ridden)
        fits = fits or ("vehicle" in (kind.name, its.name) and kind.is_vehicle and its.is_vehicle)
        if fits or (its.label == kind.label and phrase.noun in group.words.casefold()):
            count = (math.nan, math.inf) if isinstance(group.count, str) else np.broadcast_to(group.count, 2).tolist()
            found.append((count[0], count[1] * (math.inf if group.lane == "each" else max(len(group.places), 1))))
    return found


def _missing(
    named: Sequence[tuple[Sequence[str], Node, NounPhrase]], texts: Sequence[str], held: Held, has: str
) -> list[str]:
    """A line for each noun phrase of a text that the result `held` lacks, or has less often."""
    notes, needed = list[str](), Counter[str]()
    counts = not _SHARING.intersection(texts)
    for words, node, phrase in named:
        groups, kind = held(phrase), str(phrase.kind)
        least, most = (sum(group[end] for group in groups) for end in (0, 1))
        count = phrase.count if isinstance(phrase.count, int) and phrase.part is None else 0
        needed[kind] += 0 if phrase.definite or phrase.name else count
        same = any(low <= count <= high for low, high in [*groups, (least, most)])
        if not groups or most < needed[kind] or (counts and phrase.exact and not (same or phrase.part)):
            number = "some" if math.isnan(least) else f"{least if most == math.inf else most:g}"
            found = f"{kind}: {number}" if groups else f"no {kind}"
            notes.append(f"the sentence names {_words_of(words, node)!r}; the {has} has {found}")
    return list(dict.fromkeys(notes))


def _doubled(nodes: Sequence[Node], phrases: Sequence[NounPhrase], texts: Sequence[str], spec: SceneSpec) -> list[str]:
    """A line for each kind of which the spec has more than the sentence counts; "the car" is not counted."""
    phrase_of = (noun_phrase(leaf) for node in nodes for leaf in leaves(node, "object"))
    uncounted = {str(phrase.kind) for phrase in phrase_of if phrase.plain and phrase.definite}
    parts = any(True for node in nodes for _ in leaves(node, "ellipsis", "tally"))
    if parts or not _SHARING.isdisjoint(texts) or not _DENYING.isdisjoint(texts):
        return []
    found = []
    for kind in dict.fromkeys(str(phrase.kind) for phrase in phrases):
        of_kind = [phrase for phrase in phrases if phrase.kind == kind]
        groups = [group for group in spec.groups if group.kind == kind and group.words]
        counts = [phrase.count for phrase in of_kind if not phrase.definite and isinstance(phrase.count, int)]
        open_count = kind in uncounted or len(counts) < len(of_kind)
        open_count |= any(one.lane == "each" or one.record.follows_road for one in groups)
        held = [
            math.inf if isinstance(one.count, str) else np.max(one.count) * max(len(one.places), 1) for one in groups
        ]
        if not open_count and sum(held) > sum(counts):
            number = "some" if math.isinf(sum(held)) else f"{sum(held):g}"
            found.append(
                f"the sentence names {sum(counts)} {_plural(kind, sum(counts))}; the scene has {kind}: {number}"
            )
    return found


def _plural(kind: str, count: int) -> str:
    return SENTENCE_KINDS[kind].plural if count != 1 else kind.replace("-", " ")


def _is_on(road: str | None, spec: SceneSpec) -> bool:
    """Whether a spec's road is of that kind."""
    bends = [str(kind).rpartition("-")[2] for kind in (road, spec.road.kind)]
    return bends == ["bend", "bend"] or road in (None, "straight", spec.road.kind)


def _has_length(length: tuple[float, float], spec: SceneSpec) -> bool:
    """Whether a spec has that length [m]; a wall "from 5 m to 35 m" is 30 m long."""
    held = [spec.road.junction, *(at for one in spec.groups for at in (one.distance, one.from_road, one.from_sidewalk))]
    ends = [end for at in held if at for end in at]
    ends += [end for one in spec.groups for end in (one.spacing, *(one.size or ())) if end is not None]
    return any(math.isclose(said, end, rel_tol=0.01) for said in (*length, length[1] - length[0]) for end in ends)


def _unplaced(said: Sequence[Node], spec: SceneSpec) -> list[Node]:
    """The relations that no group of a spec has, in either direction; each group has one."""
    free = [group for group in spec.groups if group.references]
    lost = []
    for node in said:
        relation = relation_of(node)
        kinds = {phrase.kind for phrase in relation.targets if phrase.kind}
        known = kinds and relation.relation not in (None, "rides") and not _is_from_ego(relation, kinds, spec)
        held = [one for one in free if kinds & {spec.groups[other].kind for other in one.references}]
        if known and held:
            free = [one for one in free if one is not held[0]] if len(held) > 1 else free
        elif known:
            lost.append((node, kinds))
    turned = [one for one in free if one.kind in set().union(*(kinds for _, kinds in lost))]
    return [node for node, kinds in lost if not any(one.kind in kinds for one in turned)]


def _is_from_ego(said: Relation, kinds: Set[str | None], spec: SceneSpec) -> bool:
    """Whether the target of a relation is placed from the ego or the road, as in "we are behind a bus", or may be
    it."""
    placed = [one.places or one.lane or spec.road.kind == "parking-lot" for one in spec.groups if one.kind in kinds]
    return any(phrase.plain and phrase.definite for phrase in said.targets) or bool(placed and all(placed))


def _sides_of(spec: SceneSpec) -> set[str]:
    """The sides of any place, target or origin in a spec; the ego's lane is on the right."""
    said = [str(spec.road.kind), str(spec.road.ego_lane)]
    for group in spec.groups:
        said += [*group.places, *group.not_places, str(group.lane), str(group.heading), str(group.relation)]
    sides = {side for side in ("left", "right") if any(side in one for one in said)}
    across = any(one.startswith("across-") for one in said)
    return sides | ({"left", "right"} if across else set()) | ({"right"} if "own" in said else set())


def _words_of(texts: Sequence[str], node: Node) -> str:
    return " ".join(texts[node.start : node.end])


def _named(nodes: Sequence[Node]) -> Iterator[tuple[Node, NounPhrase]]:
    """The noun phrases, without those that are denied ("no cars or buses"), were counted before ("the third car"), or
    may be the ego vehicle ("the car")."""
    denied = -2  # where the last denied one ends
    for one in (leaf for node in nodes for leaf in leaves(node, "object")):
        phrase = noun_phrase(one)
        if phrase.count == 0 or (one.start == denied + 1 and not phrase.determiners):
            denied = one.end
        elif phrase.kind and phrase.ordinal is None and (phrase.exact or not (phrase.plain and phrase.definite)):
            yield one, phrase
