"""Constituents of sentences that are too involved: they are reported rather than guessed."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

from lidardraft.drafting.text.chart import Node
from lidardraft.drafting.text.grammar import JUNCTIONS
from lidardraft.drafting.text.positions import Position
from lidardraft.drafting.text.tree import leaves

STRANGE = ("unknown", "stranger", "aside")  # constituents without effect
_ENDS = (",", ".", ":", ")", "but")  # of the constituents that a word governs
_NAMES = ("object", "ellipsis", "pronoun", "stranger")
_SAID = ("whereabouts", "relation")
_PREPOSITIONS = ("in", "of", "to", "from", "on", "at", "by", "through", "onto", "into", "for", "as")
_MANNERS = ("ly", "ing", "ed", "en")  # endings of words of manner
_VERBS = ("state", "crossed", "turned", "overtakes", "overtaking", "relation")
_SUBORDINATE = ("if", "until", "although", "though", "since", "as")


def with_doubts(nodes: Sequence[Node], texts: Sequence[str]) -> list[Node]:
    """The constituents of a text, with doubtful ones turned into unknown ones."""
    found = list(nodes)
    for index in range(len(nodes)):
        for doubtful in _doubtful(found, index, texts):
            if found[doubtful].symbol not in (",", "."):
                found[doubtful] = found[doubtful]._replace(symbol="unknown")
    return found


def _doubtful(nodes: list[Node], index: int, texts: Sequence[str]) -> Sequence[int]:
    """The numbers of the constituents that one makes doubtful."""
    words = texts[nodes[index].start : nodes[index].end]
    node, after = nodes[index], nodes[index + 1].symbol if index + 1 < len(nodes) else ""
    end = _end(nodes, index)
    governed = range(index, end)
    unclear = any(nodes[one].symbol in STRANGE for one in governed)
    if node.symbol == "(":
        closed = next((n for n in range(index, len(nodes)) if nodes[n].symbol == ")"), len(nodes) - 1)
        inside = range(index, closed + 1)
        return inside if any(nodes[n].symbol in ("object", *STRANGE) for n in inside) else ()
    if node.symbol == "which":  # about unknown objects, or with unknown words
        before = nodes[index - 1] if index else node
        known = before.symbol in ("object", "street", ",") or (
            before.symbol == "relation" and any(leaves(before, "object"))
        )
        return governed if unclear or not known else ()
    last = nodes[index - 1].symbol if index else ""
    if node.symbol in ("busy", "quiet"):  # "the pavement is empty", "one lane is busy"
        named = next((one for one in nodes[index::-1] if one.symbol in (*_NAMES, "walkway", "street", "lanes")), None)
        other = named is not None and named.symbol != "street" and not named.get("traffic")
        return (index,) if other or after in ("unknown", "stranger", "state") else ()
    of = words[-1:] == ["of"] and index > 0 and nodes[index - 1].symbol in STRANGE  # "tens of cars"
    if node.symbol == "silent" and words[-1] in _PREPOSITIONS and after in _NAMES and not of:
        first = index - 1 if last == "ellipsis" else index
        return range(first, _after_places(nodes, index + 2, "state"))  # "in a traffic jam"
    if node.symbol == "pronoun" and last in STRANGE:  # "walks past them towards us"
        return governed
    acts = (
        index > 1
        and last == "unknown"
        and (nodes[index - 2].symbol == "object" or texts[node.start - 1].endswith("ing"))
    )
    if node.symbol == "object" and acts and nodes[index - 2].symbol not in (*_ENDS, "and", "with"):
        return range(index, _after_places(nodes, index + 1))  # "a lorry chasing two cats drives 30 m ahead"
    does = last in ("object", "relation", "whereabouts") and words[0].endswith("ing")
    if node.symbol == "object" and does and _first_leaf(node).symbol == "unknown":
        return range(index, _after_places(nodes, index + 1))  # "an officer directing traffic stands ahead"
    if node.symbol == "silent" and words[0] in _SUBORDINATE and after in (*_NAMES, "there"):
        return governed
    if node.symbol == "state" and words[-1].startswith("approach") and after in ("street", "walkway", *_NAMES):
        return range(index, index + 1 + (after == "pronoun"))  # of an object, not of us
    if node.symbol == "except" and after in ("road_part", "street", "walkway", "silent"):
        return governed
    if words[0] in ("not", "cannot", "never") and after in _VERBS:
        return (index, index + 1)  # "we cannot overtake"
    if words in (["so"], ["because"]):
        return governed  # "so nothing can overtake", "because it is closed"
    if node.symbol in ("except", "nothing") or (node.symbol in ("object", "ellipsis") and node.get("count") == 0):
        said = {nodes[one].symbol for one in governed}
        base = itertools.takewhile(lambda one: one.symbol not in _ENDS, nodes[index - 1 :: -1] if index else ())
        if node.symbol == "except":  # "in all bays except two", "light traffic except for a coach"
            unclear = unclear or any(one.symbol in STRANGE for one in base) or _is_of_others(nodes, index)
        too_much = unclear or "pronoun" in said or ("relation" in said and after != "object")
        return range(index, _after_list(nodes, end)) if too_much else ()
    return _doubtful_ellipsis(nodes, index, texts) or _doubtful_place(nodes, index, texts)


def _doubtful_ellipsis(nodes: list[Node], index: int, texts: Sequence[str]) -> Sequence[int]:
    """As above, for objects named by a number or a place alone."""
    node = nodes[index]
    if node.symbol != "ellipsis":
        return ()
    words = texts[node.start : node.end]
    next_ones = [one.symbol for one in nodes[index + 1 : index + 3]]
    if next_ones[:1] in (["unknown"], ["quiet"], ["busy"], ["size"]):  # "one empty slot"
        return range(index, _after_places(nodes, index + 2))
    if next_ones in (["is", "quiet"], ["is", "busy"]):  # "the right one is empty"
        return range(index, index + 3)
    is_number = words[-1].isdigit() and index > 0 and nodes[index - 1].symbol in ("object", "unknown")
    if words == ["not"] or is_number:  # "has not stopped", "a car 20 30 m ahead", "a sign reading 30"
        return (index,)
    return range(index, _end(nodes, index)) if any(leaves(node, "unknown")) else ()  # "the middle one is set back"


def _doubtful_place(nodes: list[Node], index: int, texts: Sequence[str]) -> Sequence[int]:
    """As above, for places and for constituents beside unknown words."""
    words = texts[nodes[index].start : nodes[index].end]
    node, after = nodes[index], nodes[index + 1].symbol if index + 1 < len(nodes) else ""
    last = nodes[index - 1].symbol if index else ""
    governed = range(index, _end(nodes, index))
    if words in (["left"], ["right"]) and after in _NAMES and nodes[index - 1].symbol == "object":
        return (index - 1, index)  # "someone left a box"
    if node.symbol == "whereabouts" and any(one.get("owned") for one in leaves(node, "the")):  # "its left edge"
        return (index,)
    of = after == "silent" and texts[node.end] == "of"
    if node.symbol == "whereabouts" and of and (*nodes, node, node)[index + 2].symbol != "street":
        return (index,)  # "in the back of a pickup"
    if node.symbol == "whereabouts" and last == "unknown" and not _named_before(nodes, index):
        return (index,)  # "snow piles on both sides, a car"
    far = node.get("road") in JUNCTIONS or (
        {"far", "opposite"} & set(words) and any(one.get("road") in JUNCTIONS for one in nodes)
    )
    if node.symbol == "whereabouts" and node.get("other_side") and far:
        return (index,)  # "on the far side of the crossroads"
    if node.symbol == "whereabouts" and "gap" in words and index and last in (",", "and", "ellipsis"):
        return (
            (index - 1, index) if last == "ellipsis" else (index,)
        )  # "two vans, then a 5 m gap", "with one gap of 8 m"
    if node.symbol == "whereabouts" and "gap" in words and after == "relation":
        return (index, index + 1)  # "has a 2 m gap behind it"
    if words in (["left"], ["right"]) and last == "unknown" and texts[node.start - 1].endswith("ing"):
        return (index,)  # "a bus indicating left"
    if node.symbol == "ellipsis" and node.get("ordinal") is not None and after in _SAID:
        verb = _after_places(nodes, index + 1)  # "the first on the right is a taxi"
        return governed if verb < len(nodes) and nodes[verb].symbol == "is" else ()
    first = index
    while first and nodes[first].symbol == nodes[first - 1].symbol == "unknown":
        first -= 1
    of_verb = node.symbol == "unknown" and texts[nodes[first].start].endswith(_MANNERS)  # "taking pictures of it"
    of_verb = of_verb and texts[node.end : node.end + 1] != ["by"]  # "hidden by a van"
    if node.symbol in STRANGE and after == "relation" and not of_verb:  # "a gap between a skip and a truck"
        return range(index + 1, _after_places(nodes, index + 1))
    if node.symbol in STRANGE and after == "whereabouts" and _is_length(nodes[index + 1]):
        return (index + 1,)
    if node.symbol == "whereabouts" and _is_length(node) and after in STRANGE:  # "10 m further"
        return (index,)
    return ()


def _named_before(nodes: Sequence[Node], index: int) -> bool:
    """Whether the sentence names an object or a road before a constituent."""
    before = itertools.takewhile(lambda one: one.symbol != ".", nodes[index::-1])
    return any(one.symbol in (*_NAMES, "ego", "there", "street", "walkway", "lanes") for one in before)


def _is_of_others(nodes: Sequence[Node], index: int) -> bool:
    """Whether the excepted kind differs from the wanted kind before it."""
    kinds = [[one for one in part if one.symbol == "object"] for part in (nodes[index::-1], nodes[index:])]
    if (
        not all(kinds)
        or nodes[index].get("without")
        or kinds[0][0].get("count") == 0
        or nodes[index + 1].symbol != "object"
    ):
        return False
    return kinds[0][0].get("kind") != kinds[1][0].get("kind")


def _first_leaf(node: Node) -> Node:
    while node.children:
        node = node.children[0]
    return node


def _is_length(node: Node) -> bool:
    at = node.get("at")
    return isinstance(at, Position) and at == Position(distance=at.distance)


def _end(nodes: Sequence[Node], index: int) -> int:
    """The number of the constituent after those that one governs: up to a sign, or to a link with another object."""
    for number in range(index + 1, len(nodes)):
        after = nodes[number + 1].symbol if number + 1 < len(nodes) else ""
        if nodes[number].symbol in _ENDS or (nodes[number].symbol == "and" and after in _NAMES):
            return number
    return len(nodes)


def _after_list(nodes: Sequence[Node], index: int) -> int:
    """The number of the constituent after a list that continues: "except trucks and buses"."""
    while [one.symbol for one in nodes[index : index + 2]] in (["and", "object"], ["or", "object"]):
        index += 2
    return index


def _after_places(nodes: Sequence[Node], index: int, *more: str) -> int:
    while index < len(nodes) and (nodes[index].symbol in (*_SAID, *more) or nodes[index].get("posture")):
        index += 1
    return index
