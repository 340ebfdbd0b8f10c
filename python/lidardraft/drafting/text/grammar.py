"""The rules by which the words of a sentence form phrases, and the meaning of a phrase from its words."""

from __future__ import annotations

import dataclasses
import itertools
import re
from functools import cache, reduce
from typing import Any, cast

from lidardraft.drafting.text.chart import Build, Chart, Features, Grammar, Node, Rule, rule
from lidardraft.drafting.text.lexicon import features_of, lexicon, rows
from lidardraft.drafting.text.positions import NOWHERE, Position
from lidardraft.drafting.text.tokens import NUMBER, Token, number
from lidardraft.drafting.text.tree import leaves
from lidardraft.objects.kinds import SENTENCE_KINDS

_NO_COUNT = 20  # from here on, a number before a singular noun is no count: "two bench", but "a 30 sign"
_FURTHER = 40.0  # m beyond "at least 20 m"; an estimate
_FEW_TIMES = {"few": (3, 5), "some": (3, 6)}  # dozen, hundred, thousand; an estimate
UNSHOWN = ("unshown", "unseen")  # understood, but without a shape
UNKNOWN = 10.0  # the cost of an unknown word
_SAYS_NOTHING = 1.0  # the cost of a word without meaning here


def parse(tokens: list[Token]) -> list[Node]:
    """The constituents that cover the tokens best."""
    return Chart(grammar(), _words(tokens)).cover()


def _words(tokens: list[Token]) -> list[list[Node]]:
    """The nodes that begin at each token: words of the lexicon, numbers, the token as itself, and the unknown."""
    texts = [token.text for token in tokens]
    starts, length = {}, 0
    for index, text in enumerate(texts):
        starts[length] = index
        length += len(text) + 1
    line, ends = " ".join(texts), {start - 1: index for start, index in starts.items()} | {length - 1: len(texts)}
    known = lexicon()
    found: list[list[Node]] = []
    for (start, index), token in zip(starts.items(), tokens, strict=True):
        here: list[Node] = []
        match = None if token.is_strange else NUMBER.match(line, start)
        entries = () if token.is_strange else known.get(token.text, ())
        for parts, word in entries:
            if match and word.category == "dozen" and ends.get(match.end(), 0) > index + 1:
                continue  # "hundred and one" is no hundred
            if word.features.get("named") and _is_named_before(texts, index, parts[-1]):
                continue  # "a robot ahead, a car behind the robot"
            if tuple(texts[index : index + len(parts)]) == parts:
                cost = {"silent": _SAYS_NOTHING, "unknown": -_SAYS_NOTHING}.get(word.category, 0.0)
                here.append(Node(word.category, index, index + len(parts), cost, tuple(word.features.items())))
        if match and match.end() in ends:
            here.append(_number(match[0], index, ends[match.end()], 0.0))
            before, link, upper = match[0].rpartition(" and ")
            between = {"between", "from"} & set(texts[max(0, index - 2) : index])
            if link and between and upper != "one":  # "between two hundred and three hundred"
                here.append(_number(before, index, index + len(before.split()), 0.5))
        cost = UNKNOWN if not here else 2 * UNKNOWN
        if not token.is_strange:
            here.append(Node(f"'{token.text}", index, index + 1, 0.0))
        if token.text in _SIGNS:
            here.append(Node(token.text, index, index + 1, 0.0))
        elif _is_name(texts, index):
            here.append(Node("name", index, index + 1, 0.0, (("name", token.text),)))
        is_word = any(parts == (token.text,) and word.category != "foreign" for parts, word in entries)
        strange = () if is_word or token.text in _SIGNS or match else (("strange", token.text),)
        here.append(Node("unknown", index, index + 1, cost, strange))
        found.append(here)
    return found


def _number(text: str, start: int, end: int, cost: float) -> Node:
    category = "fraction" if "." in text or " point " in text else "number"
    return Node(category, start, end, cost, (("value", number(text)),))


def _is_named_before(texts: list[str], index: int, noun: str) -> bool:
    """Whether a noun occurs before a token, except in "robot view"."""
    return any(text == noun and after not in _views() for text, after in itertools.pairwise(texts[: index + 1]))


@cache
def _views() -> frozenset[str]:
    return frozenset(
        parts[0] for entries in lexicon().values() for parts, word in entries if word.category == "scene_noun"
    )


_SIGNS = (",", ".", ":", "(", ")")


def _is_name(texts: list[str], index: int) -> bool:
    """Whether a token names the object before it: a capital letter, or a number if there are "van 1" and "van 2"."""
    text = texts[index]
    if len(text) == 1 and text.isupper():
        return True
    kind = texts[index - 1] if index else ""
    numbered = {after for before, after in itertools.pairwise(texts) if before == kind}
    return text in ("1", "2", "3", "4") and kind.isalpha() and {"1", "2"} <= numbered


def _counted(count: Any) -> Features:
    return (("count", count),)


def _uncounted(_: Node) -> Features:
    return _counted(None)


def _many_of_two(node: Node) -> Features | None:
    return _counted("many") if "many" in node.all("count") else None


def _count(node: Node) -> Features:
    return _counted(int(node.get("value")))


def _range(node: Node) -> Features:
    low, high = sorted(int(value) for value in node.all("value"))
    return _counted((low, high) if low else None)


def _at_most(node: Node) -> Features:
    return _counted((1, max(1, int(node.get("value")) - node.get("less"))))


def _at_least(node: Node) -> Features:
    low = int(node.get("value"))
    return _counted((low + node.get("least"), low + max(2, low // 2)))


def _or_more(node: Node) -> Features:
    low = int(node.get("value"))
    return _counted(
        {"more": (low, low + max(2, low // 2)), "fewer": (1, low), "so": low}[node.children[-1].children[0].symbol[1:]]
    )


def _dozens(node: Node) -> Features:
    (times,) = node.all("times")
    many = node.get("value", 1) if not node.all("count") else node.get("count")
    if node.get("share"):
        return _counted(int(times * 0.5))
    if many in _FEW_TIMES:
        low, high = _FEW_TIMES[many]
        return _counted((low * times, high * times))
    return _counted(int(times * many)) if isinstance(many, int | float) else _counted(None)


def _collected(node: Node) -> Features | None:
    """ "A row of ten trees" counts ten; a row alone is many."""
    counts = node.all("count")
    if len(counts) > 1:
        rest = tuple((name, value) for name, value in node.features if name != "count")
        plural = any(
            child.symbol == "collective" and child.end - child.start == 2 and child.get("count")
            for child in node.children
        )
        return (*rest, ("count", counts[-1])) if plural else None
    return tuple((name, value) for name, value in node.features if name not in ("plural", "scale", "long"))


def _length(node: Node) -> Features:
    """A range of metres."""
    units = node.all("metres")
    values = sorted(value * units[-1] for value in node.all("value"))
    if node.all("less"):
        return (("length", (0.0, values[-1])),)
    if node.all("least"):
        return (("length", (values[0], values[0] + _FURTHER)),)
    return (("length", (values[0], values[-1])),)


def _from_to(node: Node) -> Features:
    return (*_length(node), ("from_to", True))


def _pace(node: Node) -> Features:
    return (("speed", round(node.get("value") * node.get("pace"), 3)),)


def _distance(node: Node) -> Features:
    return (("at", Position(distance=node.get("length"))), ("from_to", node.get("from_to")))


def _aside(node: Node) -> Features:
    """ "4 m to the left" is level with the ego."""
    return (("at", Position((("beside", node.get("side")),), node.get("length"))),)


def _beside_road(node: Node) -> Features:
    return (("at", Position((("", node.get("side")),), from_road=node.get("length"))),)


def _spacing(node: Node) -> Features:
    return (*node.features, ("at", Position(spacing=node.get("length")[0])))


def _from_road(node: Node) -> Features:
    return (("at", Position(from_road=node.get("length"))),)


def _from_sidewalk(node: Node) -> Features:
    return (("at", Position(from_sidewalk=node.get("length"))),)


def _shoulder(node: Node) -> Features:
    return (("at", Position(places=node.get("at").places, heading="parked")),)


def _as_ego_sees(node: Node) -> Features | None:
    return (("at", node.get("at")),) if node.get("at") else None


def _length_of(node: Node) -> Features:
    return (("length_of", node.get("length")[1]),)


def _spaced_between(node: Node) -> Features:
    return (*node.features, ("spacing", node.get("length")[0]))


def _sized(node: Node) -> Features:
    return (("size", (node.get("axis"), node.get("length")[1])),)


def _place(node: Node) -> Features | None:
    """Adjacent places are one, if they can hold at once."""
    ats = [value for value in node.all("at") if value is not None]
    for name in ("distance", "spacing", "lane"):
        if len([1 for at in ats if getattr(at, name)]) > 1:
            return None
    for place, following in itertools.pairwise(itertools.accumulate(ats, Position.narrowed)):
        if place == following:
            return None  # "behind behind"
    at = reduce(Position.narrowed, ats, Position())
    said = [one for one in ats if one.places != (NOWHERE,)]
    if len(said) > 1 and not all(one.agrees(other) for one in said for other in said):
        return None
    rest = tuple((name, value) for name, value in node.features if name not in ("at", "length", "plural"))
    return (("at", at), *rest)


def _either(node: Node) -> Features:
    """ "Both in front and behind"."""
    one, other = node.all("at")
    return (("at", one.or_at(other)),)


def _crossing(node: Node) -> Features | None:
    sides = node.all("side")
    if len(sides) == 2:
        return (("heading", f"across-{sides[1]}"),) if sides[0] != sides[1] else None
    said: Features = (("heading", "across"), *((name, value) for name, value in node.features if name == "speed"))
    if node.all("road"):
        junction = node.get("road") in JUNCTIONS
        named = junction or node.get("road") == "parking-lot"
        said = (*said, ("road", node.get("road"))) if named else (*said, ("on_the_road", True))
        said = (*said, ("at_junction", True)) if junction else said
    return said


def _from_side(node: Node) -> Features:
    (at,) = node.all("at")
    heading = f"across-{_ACROSS_FROM[at.sides[0]]}"
    return (("at", dataclasses.replace(at, heading=heading)),)


def _level(node: Node) -> Features:
    """ "On both sides of us" is beside us."""
    at = node.get("at")
    return (("at", dataclasses.replace(at, places=(("beside", "left"), ("beside", "right")), both_sides=False)),)


def _joined(node: Node) -> Features:
    """Traffic that merges from a side is there, and drives in the ego's direction."""
    return (("at", dataclasses.replace(node.get("at"), heading="with")),)


_ACROSS_FROM = {"left": "right", "right": "left"}


def _turning(node: Node) -> Features:
    side = node.get("side")
    return (("heading", f"turning-{side}" if side else "turning"),)


def _bend(node: Node) -> Features:
    side = node.get("side")
    return (("road", f"{side}-bend" if side else "bend"),)


def _agreeing(node: Node) -> Features | None:
    """A noun and words that agree with it in number: no "a cars"."""
    head = node.children[-1]
    several = head.get("plural")
    if isinstance(node.get("part"), float) and not several and not node.get("traffic"):
        return None  # half a car
    determiners = [one for child in node.children if child.symbol == "determiner" for one in child.children]
    articles = [one for one in determiners if one.symbol == "a"]
    group = any(one.symbol == "quantity" for one in determiners)
    attributes = [one for child in node.children if child.symbol == "attribute" for one in child.children]
    if not node.get("traffic") and any(one.symbol in ("busy", "quiet") for one in attributes):
        return None
    if ("side", "unknown") in itertools.pairwise(one.symbol for one in attributes):
        return None  # "on the left directing traffic"
    if any(ego for one in attributes for ego in leaves(one, "ego")):
        return None  # "approaching the ego vehicle"
    counts = [one.get("count") for one in determiners if one.symbol == "quantity" and isinstance(one.get("count"), int)]
    if several is False and any(count >= _NO_COUNT for count in counts):
        return None  # a "speed limit 30 sign"
    if len(counts) > 1:
        return None
    if articles and several is True and not group:
        return None
    said = [one.symbol for child in node.children if child.symbol == "determiner" for one in child.children]
    lone = [symbol for symbol in said if symbol in ("a", "the", "another", "each", "no", "both")]
    if len(lone) > 1 and lone not in (["both", "the"], ["no", "a"], ["no", "the"], ["the", "the"]):
        return None
    if ("both" in said or "all" in said) and not several and node.children[-1].symbol == "head":
        return None
    return node.features


def _kind_of_traffic(node: Node) -> Features | None:
    """ "Bus traffic" is of buses; "vans queue" is a clause."""
    kind, traffic = node.children
    return None if kind.get("plural") is True else (*traffic.features, *kind.features, ("plural", True))


def _nobody_comes(node: Node) -> Features | None:
    """ "Nobody is coming the other way" denies vehicles."""
    return (("kind", "vehicle"), ("count", 0)) if node.get("heading") in ("with", "against") else None


def _rides(node: Node) -> Features | None:
    """Only two-wheelers are ridden."""
    return node.features if node.get("kind") in ("bicycle", "motorcycle") else None


def _between_two(node: Node) -> Features | None:
    """ "Between two trees and a llama" is between the trees, so "and" begins something else."""
    (first,) = node.children[1].children[0].children
    if any(leaves(node.children[-1], "ego")):
        return node.features
    several = first.symbol == "pronoun" or (first.get("count") not in (None, 1) and first.get("plural"))
    return None if several else node.features


def _only_junction(node: Node) -> Features | None:
    return node.features if node.get("road") in JUNCTIONS else None


def _no_junction(node: Node) -> Features | None:
    return node.features if node.get("road") not in JUNCTIONS else None


def _acts_on(node: Node) -> Features | None:
    """Somebody who repairs a car, or leaves a house, is near it."""
    return node.features if node.get("does") else None


def _for_each(node: Node) -> Features | None:
    return node.features if any(leaves(node, "each")) else None


def _at_thing(node: Node) -> Features | None:
    """ "On the right parked cars" are cars on the right."""
    return None if node.get("on") and any(leaves(node.children[-1], "side")) else node.features


def _distances(node: Node) -> Features | None:
    """Several distances that share a unit, as in "at 10, 20 and 30 m"."""
    unit, at = node.get("metres"), node.get("at", Position())
    lengths = [value * unit for value in node.all("value")]
    places = tuple(at.narrowed(Position(distance=(length, length))) for length in lengths)
    return (("places", places),)


JUNCTIONS = ("crossroads", "t-junction", "roundabout")


def _compound(node: Node) -> Features | None:
    """A noun in the singular qualifies the next one: "garden fence"."""
    return None if node.children[0].get("plural") is True else node.children[1].features


def _facade(node: Node) -> Features | None:
    """A shop's entrance is at the shop's place."""
    kind = node.children[0]
    return kind.features if SENTENCE_KINDS[kind.get("kind")].family == "buildings" else None


def _family(node: Node) -> Features | None:
    return (*node.features, ("plural", True)) if node.all("kind") else None


def _qualified_one(node: Node) -> Features | None:
    return node.features if len(node.children) > 1 else None


def _foreign_compound(node: Node) -> Features | None:
    """A "bus stop" is no bus; "buses stop" is a clause."""
    one = any(part.symbol == "a" for child in node.children for part in child.children)  # "a bus stops" is a clause
    return None if node.children[-2].get("plural") is True or (one and node.children[-1].get("plural")) else ()


def _foreign_compounds(node: Node) -> Features | None:
    return None if node.children[1].get("plural") is True or node.get("count") == 1 else ()


def _country_lane(node: Node) -> Features | None:
    return None if node.get("plural") else (*node.features, ("road", "straight"))


@cache
def grammar() -> Grammar:
    """The rules of `phrases.txt`."""
    rules: dict[str, list[Rule]] = {}
    symbol = ""
    for line in rows("phrases.txt"):
        name, _, said = re.split(r" (=|\|) ", f" {line}", maxsplit=1)
        symbol = name.strip() or symbol
        found = _RULE.fullmatch(said)
        assert found is not None, f"{line!r} is no rule of phrases.txt"
        cost = float(found["cost"] or 0.0)
        rules.setdefault(symbol, []).extend(
            rule(parts, _build(found["how"], found["what"]), cost) for parts in found["parts"].split(" | ")
        )
    return Grammar.of({name: tuple(ways) for name, ways in rules.items()}, _TOPS)


_RULE = re.compile(r"(?P<parts>.*?)(?: (?P<how>->|=>|\+>)(?P<what>.*?))??(?: @(?P<cost>-?[\d.]+))?")


def _build(how: str | None, what: str | None) -> Build | None:
    """The function that builds the features of a phrase from those of its parts."""
    if how is None:
        return None
    said = (what or "").split()
    if how == "->":
        return cast(Build, globals()[f"_{said[0]}"])

    def features(node: Node) -> Features:
        new = ((name, _part(value, node)) for name, value in features_of(said).items())
        return (*(node.features if how == "+>" else ()), *new)

    return features


def _part(value: Any, node: Node) -> Any:
    """A value, or that of the part written as "$name"."""
    if not str(value).startswith("$"):
        return value
    found = node.get(str(value)[1:])
    return int(found) if isinstance(found, float) else found


# Symbols that may be in a sentence by themselves; the cost of each makes few constituents better than many.
_TOPS = dict.fromkeys(
    (
        *("object", "ellipsis", "stranger", "street", "lanes", "whereabouts", "relation", "crossed", "turned", "state"),
        *("walkway", "measure", "abreast", "eachway", "oneway", "pronoun", "ego", "there", "crosswalk", "nothing"),
        *(
            "road_part",
            "overtakes",
            "overtaking",
            "size",
            "distances",
            "respectively",
            "blocked",
            "quiet",
            "busy",
            "sky",
            "colour",
        ),
        *("time", "usual", "aside", *UNSHOWN),
        *("and", "or", "with", "has", "but", "except", "which", "is", "silent", "unknown", *_SIGNS),
    ),
    2.0,
)
