"""A chart parser: rules over categories of words make constituents of a sentence, and the best of them cover it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

Features = tuple[tuple[str, Any], ...]  # the meaning of the words of a constituent, in their order
Build = Callable[["Node"], Features | None]  # the features of a constituent, None if its words do not go together


class Node(NamedTuple):
    """A constituent: its symbol, the tokens that it covers (from and to), and its features, the meaning.

    `cost` is higher for less likely ones: tokens without meaning, and rare rules.
    """

    symbol: str
    start: int
    end: int
    cost: float
    features: Features = ()
    children: tuple[Node, ...] = ()

    def get(self, name: str, default: Any = None) -> Any:
        """The last value of a feature."""
        return next((value for key, value in reversed(self.features) if key == name), default)

    def all(self, name: str) -> list[Any]:
        """All values of a feature, in order."""
        return [value for key, value in self.features if key == name]


Parts = tuple[tuple[str, str], ...]
Way = tuple[int, float, tuple[Node, ...]]  # a match of parts: its end, its cost, and the constituents


class Rule(NamedTuple):
    """A way to make a constituent from a row of symbols; each occurs once, optionally "?", or any number of times
    "*"."""

    parts: Parts
    build: Build | None
    cost: float


class Grammar(NamedTuple):
    """The rules of each symbol, the cost of each symbol that may be a sentence's constituent by itself, and the symbols
    of the words that each may begin with."""

    rules: dict[str, tuple[Rule, ...]]
    tops: dict[str, float]
    begins: dict[str, frozenset[str]]

    @classmethod
    def of(cls, rules: dict[str, tuple[Rule, ...]], tops: dict[str, float]) -> Grammar:
        """The grammar of these rules and costs."""
        begins = {symbol: frozenset({symbol}) for symbol in rules}
        grown = True
        while grown:
            grown = False
            for symbol, ways in rules.items():
                more = begins[symbol].union(*(begins.get(one, {one}) for way in ways for one in _leading(way.parts)))
                grown |= more != begins[symbol]
                begins[symbol] = more
        return cls(rules, tops, begins)


def _leading(parts: Parts) -> list[str]:
    """The symbols that the first constituent of a rule may have."""
    needed = next((number for number, (_, times) in enumerate(parts) if not times), len(parts))
    return [symbol for symbol, _ in parts[: needed + 1]]


def rule(parts: str, build: Build | None = None, cost: float = 0.0) -> Rule:
    """The rule written as a row of symbols such as "determiner? quality* noun"."""
    split = ((part.rstrip("?*"), part[-1] if part[-1] in "?*" else "") for part in parts.split())
    return Rule(tuple(split), build, cost)


MAX_SPAN = 40  # tokens of a constituent
_WAYS = 3  # matches kept for the same parts up to the same token, as a rule may refuse the cheapest


class Chart:
    """The constituents of a row of tokens, each found once."""

    def __init__(self, grammar: Grammar, words: Sequence[Iterable[Node]]) -> None:
        """`words` are the word nodes that begin at each token."""
        self._grammar, self._words = grammar, [list(at) for at in words]
        self._symbols = [{word.symbol for word in at} for at in self._words]
        self._known: dict[tuple[str, int], dict[int, Node]] = {}
        self._matched: dict[tuple[int, int, int], list[Way]] = {}

    def spans(self, symbol: str, start: int) -> dict[int, Node]:
        """The cheapest constituent of a symbol from a token on, for each possible end."""
        known = self._known.get((symbol, start))
        if known is not None:
            return known
        found: dict[int, Node] = {}
        self._known[symbol, start] = found
        begins = self._grammar.begins.get(symbol, {symbol})
        if start < len(self._words) and not begins.isdisjoint(self._symbols[start]):
            for word in self._words[start]:
                if word.symbol == symbol:
                    _keep(found, word)
            for one in self._grammar.rules.get(symbol, ()):
                for end, cost, children in self._match(one.parts, 0, start):
                    if end == start:
                        continue
                    features = tuple(feature for child in children for feature in child.features)
                    node: Node = Node(symbol, start, end, one.cost + cost, features, children)
                    said = one.build(node) if one.build else features
                    if said is not None:
                        _keep(found, node._replace(features=said))
        return found

    def _match(self, parts: Parts, number: int, start: int) -> list[Way]:
        """The cheapest matches of the parts of a rule from a number on, a few for each end."""
        if number == len(parts):
            return [(start, 0.0, ())]
        symbol, times = parts[number]
        nodes = self._known.get((symbol, start))
        if nodes is None:
            nodes = self.spans(symbol, start)
        if not nodes:
            return self._match(parts, number + 1, start) if times else []
        key = (id(parts), number, start)
        known = self._matched.get(key)
        if known is not None:
            return known
        found = list(self._match(parts, number + 1, start)) if times else []
        for end, node in nodes.items():
            for last, cost, children in self._match(parts, number + (times != "*"), end):
                if last - start <= MAX_SPAN:
                    found.append((last, cost + node.cost, (node, *children)))
        if len({way[0] for way in found}) < len(found):
            ways: dict[int, list[Way]] = {}
            for way in sorted(found, key=lambda way: way[1]):
                ways.setdefault(way[0], []).append(way)
            found = [way for to in ways.values() for way in to[:_WAYS]]
        self._matched[key] = found
        return found

    def cover(self) -> list[Node]:
        """The cheapest row of constituents that covers all tokens."""
        nothing: tuple[float, Node | None] = (float("inf"), None)
        best: list[tuple[float, Node | None]] = [(0.0, None), *[nothing] * len(self._words)]
        for start in range(len(self._words)):
            for symbol, cost in self._grammar.tops.items():
                for end, node in self.spans(symbol, start).items():
                    total = best[start][0] + node.cost + cost
                    if total < best[end][0]:
                        best[end] = (total, node)
        nodes: list[Node] = []
        end = len(self._words)
        while end:
            last = best[end][1]
            assert last is not None, "every token is at least unknown"
            nodes.append(last)
            end = last.start
        return nodes[::-1]


def _keep(found: dict[int, Node], node: Node) -> None:
    if node.end not in found or node.cost < found[node.end].cost:
        found[node.end] = node
