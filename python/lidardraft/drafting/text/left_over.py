"""The words of a sentence without effect: those not understood, and those that are but have no shape."""

from __future__ import annotations

from collections.abc import Iterator, Sequence, Set

from lidardraft.drafting.text.chart import Node
from lidardraft.drafting.text.grammar import UNSHOWN
from lidardraft.drafting.text.mentions import RUNNING
from lidardraft.drafting.text.tokens import Token
from lidardraft.drafting.text.tree import leaves

_JOINS = frozenset({"a", "an", "is", "are", "was", "were", "and", "with", *",.:()"})  # begin no reported part
_GLUE = _JOINS | {"the", "in", "on", "at", "to", "of", "from", "by"}  # end none
_SHAPELESS = (  # words that are understood even without an effect
    *(*UNSHOWN, "colour", "size", "bendy", "crosswalk", "time", "wetness", "ordinal", "crossing", "quiet", "usual"),
)


class LeftOver:
    """The tokens of a text without effect; adjacent ones are reported as one part."""

    def __init__(self, text: str, tokens: Sequence[Token], nodes: Sequence[Node], silent: Set[int]) -> None:
        self._text, self._tokens, self._silent = text, tokens, frozenset(silent)
        words = (word for node in nodes for word in _words(node) if word.symbol in UNSHOWN or not self._is_lost(node))
        shapeless = {n for word in words if _has_no_shape(word) for n in range(word.start, word.end)}
        strange = (word for node in nodes for word in leaves(node, "unknown"))
        shapeless -= {n for word in strange for n in range(word.start, word.end)}
        runs = [run for run in self._runs(range(len(tokens))) if all(self._joins(n) or n in shapeless for n in run)]
        self._unshown = {n for run in runs for n in run}

    def parts(self, within: range) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """The parts of some tokens that are not understood, and those without a shape."""
        runs = list(self._runs(within))
        unknown, unshown = (
            tuple(self.said(run) for run in runs if self._unshown.issuperset(run) is known) for known in (False, True)
        )
        return unknown, unshown

    def said(self, run: Sequence[int]) -> str:
        """The text from the first to the last of some tokens."""
        return self._text[self._tokens[run[0]].start : self._tokens[run[-1]].end]

    def _is_lost(self, node: Node) -> bool:
        """Whether it is a place without objects: "cars at the zebra crossing"."""
        if any(word.symbol == "place" and word.get("more") for word in _words(node)):
            return False  # "in the bike lane" is at the side of the road
        if _is_at_scenery(node):
            return False
        return node.symbol in ("whereabouts", "relation") and self._silent.issuperset(range(node.start, node.end))

    def _joins(self, token: int) -> bool:
        return self._tokens[token].text in _GLUE

    def _runs(self, within: range) -> Iterator[list[int]]:
        """Runs of adjacent silent tokens, without joining words at the ends."""
        run: list[int] = []
        for index in range(within.start, within.stop + 1):
            if index < within.stop and index in self._silent:
                run.append(index)
                continue
            while run and self._joins(run[-1]):
                run.pop()
            while run and self._tokens[run[0]].text in _JOINS:
                run.pop(0)
            if run:
                yield run
            run = []


def _words(node: Node) -> Iterator[Node]:
    """The words of a constituent; worn or carried things count as one."""
    if not node.children or node.symbol in UNSHOWN or _is_at_scenery(node):
        yield node
    else:
        for child in node.children:
            yield from _words(child)


def _is_at_scenery(node: Node) -> bool:
    """Whether it is a relation to scenery without a shape: "near a park"."""
    return node.symbol == "relation" and any(leaves(node, "scenic"))


def _has_no_shape(word: Node) -> bool:
    said = word.get("more") or word.get("road") == "straight" or word.get("speed") == RUNNING
    return word.symbol in _SHAPELESS or bool(said) or _is_at_scenery(word)
