"""Words without a shape and words for defaults, with their modifiers: loads, parks, fields, roads ahead."""

from __future__ import annotations

from collections.abc import Sequence

from lidardraft.drafting.text.chart import Node
from lidardraft.drafting.text.positions import FRONT, Position
from lidardraft.drafting.text.tree import leaves
from lidardraft.objects.kinds import SENTENCE_KINDS

_BEFORE_NAMES = (",", ".", ":", "(", ")", "and", "or", "but", "with", "has", "is", "there")


def with_scenery(nodes: Sequence[Node]) -> list[Node]:
    """The constituents of a text, with those that are not about objects combined or marked as such."""
    found: list[Node] = []
    for index, node in enumerate(nodes):
        has = index + 1 < len(nodes) and nodes[index + 1].symbol in ("with", "has", "relation", "whereabouts")
        if node.symbol in ("object", "stranger") and _is_loaded(found):
            load = found.pop()
            found.append(Node("unseen", load.start, node.end, 0.0, (), (load._replace(symbol="worn"), node)))
        elif node.symbol == "whereabouts" and _is_named(found):
            found += _placed(found.pop(), node, has=has)
        else:
            found.append(node)
    return found


def _is_loaded(nodes: Sequence[Node]) -> bool:
    """Whether a vehicle carries the next object, which is then on it."""
    if not nodes or nodes[-1].symbol != "with" or not nodes[-1].get("cargo"):
        return False
    carrier = next((one for one in reversed(nodes) if one.symbol == "object"), None)
    return carrier is not None and SENTENCE_KINDS[carrier.get("kind")].is_vehicle


def _is_named(nodes: Sequence[Node]) -> bool:
    """Whether the last constituent is named for itself: "a park", and not "in a park"."""
    return bool(nodes) and (len(nodes) == 1 or nodes[-2].symbol in _BEFORE_NAMES)


def _placed(named: Node, place: Node, *, has: bool) -> list[Node]:
    """A named thing and its place; the objects that it `has` are at that place too."""
    at = place.get("at")
    if named.symbol == "unseen" and any(leaves(named, "scenery")):  # "a park on the right"
        return [named._replace(end=place.end, children=(*named.children, place))]
    if named.symbol == "street" and at == Position((FRONT,)) and not place.get("bare"):  # "a junction ahead"
        return [named, _so_anyway(place, "ahead")]
    around = named.symbol == "street" and named.get("district") and not (named.get("road") or named.get("lanes"))
    if around and at is not None and at.only_places and at.sides and not has:  # "fields on both sides"
        return [named, _so_anyway(place, "around")]
    return [named, place]


def _so_anyway(node: Node, said: str) -> Node:
    return node._replace(symbol="usual", features=(("anyway", said),), children=())
