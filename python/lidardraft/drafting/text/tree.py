"""The typed tree of a sentence: clauses of noun phrases, with the places, relations and manners said of them."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from lidardraft.drafting.text.chart import Node
from lidardraft.drafting.text.positions import ANYWHERE, Position
from lidardraft.objects.kinds import SENTENCE_KINDS

Count = int | str | tuple[int, int]  # a number, a word for one, or a range
Sizes = tuple[float | None, float | None, float | None]
Tokens = frozenset[int]  # by their numbers in the sentence
NO_SIZE: Sizes = (None, None, None)
NO_SCALE = (1.0, 1.0, 1.0)
# Words with and without a meaning among verbs and adjectives, noun phrases and places.
_SIGNS = ("queue", "cycling", "facing", "drives", "moves", "abreast", "on_the_road", "at_junction", "in_row", "row")
_MARKS = ("all", "both", "rest", "ridden", "anybody", "plain", "in_total")
_MARKS_OF_PLACES = ("other_side", "bare", "shoulder", "everywhere", "middle", "crosswalk", "from_to")
_LONG = ("truck", "bus", "tram", "wall", "fence", "hedge", "barrier")  # "a 12 m truck" is 12 m long
_HIGH = ("tree", "pole", "building", "house", "street-light")  # "a 10 m tree" is 10 m high


@dataclass(frozen=True, slots=True)
class Manner:
    """The motion, state and size of objects."""

    heading: str | None = None
    queue: bool = False
    cycling: bool = False
    facing: bool = False  # without any motion
    drives: bool = False  # for vehicles only
    walks: bool = False
    moves: bool = False  # "passing", wherever to
    abreast: bool = False
    motion: str | None = None
    speed: float | None = None  # m/s
    riding: bool = False
    on_the_road: bool = False
    at_junction: bool = False
    says: bool = False  # whether any verb or adjective describes the objects
    size: Sizes = NO_SIZE
    scale: tuple[float, float, float] = NO_SCALE
    length: float | None = None  # "a wall of 3 m": its height or its length
    long: bool | None = None  # which of them, by a word such as "long" or "tall"
    in_row: bool = False  # "one behind the other"
    row: bool = False  # "a row of"
    road: str | None = None  # the road crossed
    paint: str | None = None
    tokens: Tokens = frozenset()

    @property
    def is_idle(self) -> bool:
        """Whether it has no effect on the scene."""
        return dataclasses.replace(self, says=False, tokens=frozenset()) == Manner()


@dataclass(frozen=True, slots=True)
class NounPhrase:
    """A determiner, a kind and its qualities; the kind is None if unknown, "" without a noun.

    `pronoun` is "it", "them" or "us", `part` a number of a whole: "one of the three cars" is 1 of 3.
    """

    kind: str | None
    count: Count = 1
    exact: bool = False
    plural: bool = False
    definite: bool = False
    each: bool = False
    all: bool = False
    both: bool = False
    another: bool = False
    rest: bool = False
    ordinal: int | None = None
    part: float | str | None = None
    of_them: bool = False
    name: str = ""
    pronoun: str = ""
    of_person: bool = False  # "him", not "it"
    without: bool = False
    determiners: int = 0  # "no", "a", "the", "two"
    traffic: bool = False
    ridden: bool = False
    owned: bool = False  # "its roof"
    noun: str = ""  # of its kind, in the singular
    anybody: bool = False  # "the man" may be the worker named before, "the driver" may not
    plain: bool = False  # "the car" may be the ego's, "the taxi" may not
    one_each: bool = False
    in_total: bool = False
    all_but: int = 0
    at: Position | None = None  # "the left hedge"
    manner: Manner = Manner()
    tokens: Tokens = frozenset()


@dataclass(frozen=True, slots=True)
class Place:
    """A place relative to the ego."""

    at: Position
    times: int = 1  # "at each of the four corners"
    road: str | None = None
    lanes: int = 0
    other_side: bool = False
    bend_side: str = ""
    bare: bool = False  # "in front", perhaps of a building
    only: bool = False
    shoulder: bool = False
    everywhere: bool = False
    middle: bool = False  # "in the middle", for objects that may be on the road
    centre: bool = False  # "in the middle of the road"
    crosswalk: bool = False
    there: bool = False
    in_row: bool = False  # "each 10 m behind the other"
    of_all: bool = False  # "each 7 m from the next"
    from_to: bool = False  # "from 5 m to 35 m", the ends of a wall
    tokens: Tokens = frozenset()


@dataclass(frozen=True, slots=True)
class Relation:
    """A preposition with its objects, one or two; None if the preposition has no meaning in a layout."""

    relation: str | None
    targets: tuple[NounPhrase, ...]
    at: Position = ANYWHERE
    ego_at: Position | None = None  # the meaning of the preposition before the ego
    strong: bool = True  # False for prepositions that are also places, as "behind"; True for "in front of"
    overtakes: bool = False
    followed: bool = False
    at_it: bool = False  # "at", "by" and "on"
    acts: bool = False  # "a man mowing his lawn"
    target_place: Place | None = None  # "between the bus ahead and the car behind"
    tokens: Tokens = frozenset()


@dataclass(frozen=True, slots=True)
class Street:
    """The statements on the road."""

    kind: str | None = None
    lanes: tuple[int, ...] = ()
    usual_lanes: int = 0
    one_way: bool = False
    each_way: bool = False
    sidewalk: bool | None = None
    settings: frozenset[str] = frozenset()
    definite: bool = False
    on: bool = False  # "on the street"
    denied: bool = False


Said = Place | Relation | Manner | Street


@dataclass(frozen=True, slots=True)
class Modifier:
    """A modifier of objects, after a link and a verb; the verb is "", "one" as in "is", or "many" as in "are"."""

    said: Said
    link: str = ""
    verb: str = ""


@dataclass(frozen=True, slots=True)
class Item:
    """A noun phrase or a road in a clause, with the modifiers after it."""

    head: NounPhrase | Street
    link: str = ""
    verb: str = ""  # before it, as in "one of them is a taxi"
    modifiers: tuple[Modifier, ...] = ()
    is_told: bool = False  # with a modifier that is not understood
    comma: bool = False  # before its "and"
    is_carried: bool = False  # by the one before it, as in "a man pushing a pram"


@dataclass(frozen=True, slots=True)
class Clause:
    """The lead, which applies to all objects after it, and the objects."""

    lead: tuple[Modifier, ...] = ()
    items: tuple[Item, ...] = ()
    link: str = ""
    begins: bool = False  # whether a sentence begins with it


def leaves(node: Node, *symbols: str) -> Iterator[Node]:
    """The outermost constituents with some symbols inside another one."""
    if node.symbol in symbols:
        yield node
    else:
        for child in node.children:
            yield from leaves(child, *symbols)


def tokens_of(node: Node) -> Tokens:
    """The numbers of its tokens."""
    return frozenset(range(node.start, node.end))


def manner_of(nodes: list[Node], kind: str | None = None) -> Manner:
    """The combined meaning of verbs and adjectives."""
    features = list(itertools.chain.from_iterable(node.features for node in nodes))
    values: dict[str, list[Any]] = {}
    for name, value in features:
        values.setdefault(name, []).append(value)
    headings = [str(heading) for heading in values.get("heading", [])]
    scale, size = NO_SCALE, list(NO_SIZE)
    for factor in values.get("scale", []):
        scale = tuple(a * b for a, b in zip(scale, factor, strict=True))
    said: dict[str, Any] = {name: name in values for name in _SIGNS}
    said |= {name: values[name][0] for name in ("motion", "speed", "road", "paint") if name in values}
    for axis, metres in values.get("size", []):
        size[axis] = metres
    for node in nodes:
        if node.symbol == "length":
            size[0 if kind in _LONG else 2] = node.get("length")[1]
    return Manner(
        heading=next((one for one in headings if one != "with"), headings[0] if headings else None),
        walks="walking" in values.get("anyway", []) or "on_foot" in values,
        riding=any(node.symbol == "riding" for node in nodes),
        says=any(
            node.symbol in ("state", "crossed", "turned", "crossing", "turning", "abreast", "overtaking")
            for node in nodes
        ),
        size=(size[0], size[1], size[2]),
        length=next(iter(values.get("length_of", [])), None),
        long=False if "tall" in values else True if "long" in values else None,
        scale=scale,
        tokens=frozenset().union(*(tokens_of(node) for node in nodes)),
        **said,
    )


def noun_phrase(node: Node) -> NounPhrase:
    """The phrase of an object, an ellipsis, a pronoun or an unknown word."""
    tokens = tokens_of(node)
    special = _special_phrase(node, tokens)
    if special is not None:
        return special
    kind = node.get("kind") or ""
    attributes = [inner for one in leaves(node, "attribute") for inner in one.children]
    fits = [one for one in attributes if one.symbol not in ("unknown", "unshown", "busy", "quiet", "setting", "adverb")]
    if kind not in (*_LONG, *_HIGH):
        fits = [one for one in fits if one.symbol != "length"]
    traffic = bool(node.get("traffic"))
    plural = node.get("plural") is True or (node.get("plural") == "any" and not any(leaves(node, "a", "the", "number")))
    count, clear = _count(node, attributes, traffic, plural)
    counted = [one for one in leaves(node, "quantity") if one.all("count")] + list(leaves(node, "tally"))
    each = bool(node.get("each")) and node.get("part") is None and node.symbol == "object"
    ones_in = [one for child in node.children if child.symbol == "determiner" for one in leaves(child, "each")]
    if each and ones_in and counted and clear:  # "every ten trees" is one of ten
        each = False
    sides = [one.get("at") for one in attributes if one.symbol in ("side", "central")]
    spacing = node.get("spacing")
    of_nobody = [child for child in node.children if child.symbol == "state"]
    marks: dict[str, Any] = {name: bool(node.get(name)) for name in _MARKS}
    return NounPhrase(
        kind=kind,
        count=count,
        exact=bool(counted and clear and isinstance(count, int)) and node.get("part") != 0,
        plural=plural,
        definite=any(leaves(node, "the", "each", "all", "both")),
        each=each or (node.symbol == "ellipsis" and bool(node.get("each"))),
        another=bool(node.get("another")) or (node.get("ordinal") is not None and any(leaves(node, "a"))),
        ordinal=node.get("ordinal"),
        part=node.get("part", node.get("share")),
        of_them=bool(node.get("of_them")) or any(leaves(node, "ofthem")),
        name=node.get("name", ""),
        without=any(leaves(node, "no")) and node.children[0].end - node.children[0].start < 3,
        determiners=sum(child.symbol == "determiner" for child in node.children),
        traffic=traffic,
        owned=any(one.get("owned") for one in leaves(node, "the")),
        noun=node.get("noun", ""),
        one_each=node.symbol == "ellipsis" and bool(node.get("each")) and bool(counted),
        all_but=node.get("all_but", 0),
        at=Position(spacing=spacing) if spacing else sides[0] if sides else None,
        manner=manner_of([*fits, *leaves(node, "collective", "kind", "traffic"), *of_nobody], kind),
        tokens=tokens,
        **marks,
    )


def _special_phrase(node: Node, tokens: Tokens) -> NounPhrase | None:
    """The phrase of an unknown object, a pronoun, or a part of the road; else None."""
    if node.symbol in ("stranger", "scenic"):
        at = next((one.get("at") for one in node.children if one.symbol == "whereabouts"), None)
        return NounPhrase(None, tokens=tokens, definite=any(leaves(node, "the")), at=at)
    if node.symbol in ("pronoun", "ego", "'that"):
        word = "us" if node.symbol == "ego" else "them" if node.get("several") else "it"
        person = bool(node.get("person"))
        return NounPhrase("", pronoun=word, of_person=person, each=bool(node.get("each")), tokens=tokens)
    if node.symbol in ("border", "junction"):
        return NounPhrase("", pronoun="road" if node.symbol == "border" else "junction", tokens=tokens)
    if node.symbol == "nothing":
        return NounPhrase(node.get("kind"), 0, tokens=tokens)
    return None


def _count(node: Node, attributes: list[Node], traffic: bool, plural: bool) -> tuple[Count, bool]:
    """The count of a noun phrase, and whether its words form one number."""
    if any(leaves(node, "no", "no_one")) or node.get("none"):
        return 0, not any(leaves(node, "number"))
    if any(leaves(node, "tally")):
        value = next((one.get("value") for one in leaves(node, "number")), 0)
        return int(value), True
    quantities = list(leaves(node, "quantity"))
    said = [one.get("count") for one in quantities]
    if traffic:
        vague = [count for count in said if isinstance(count, str)]
        busy = any(one.symbol == "busy" for one in attributes) or "many" in vague or node.get("count") == "many"
        quiet = any(one.symbol == "quiet" for one in attributes) or "few" in vague
        few: Count = "many" if busy else "few" if quiet else "some"
        return few, all(isinstance(count, str) for count in said)
    several: Count = 2 if node.get("both") else "some" if plural else 1
    vague = [count for count in said if isinstance(count, str)]
    if said and len(vague) == len(said):
        return ("many" if "many" in vague else vague[0]), True
    firm = [count for count in said if not isinstance(count, str)]
    collective = any(leaves(quantities[0], "collective")) if quantities else False
    if len(firm) == 1 and firm[0] is not None and (len(said) == 1 or collective):
        return firm[0], True
    if said:
        return several, False
    head = [child for child in node.children if child.symbol == "head"]
    return (head[0].get("count") or several) if head else several, True


def relation_of(node: Node) -> Relation:
    """A relation with its targets."""
    heads = [
        one for one in node.children if one.symbol not in ("relative", "length", "whereabouts", "border", "junction")
    ]
    targets = [
        next(leaves(one, "object", "pronoun", "stranger", "scenic", "ellipsis", "ego", "'that", "border", "junction"))
        for one in node.children
        if one.symbol in ("relative", "border", "junction")
    ]
    targets += [one for one in node.children if one.symbol == "ego"]
    places = [one for one in node.children if one.symbol == "whereabouts"]
    said = {name: value for head in heads for name, value in head.features}
    relation = "near" if said.get("does") else said.get("relation")
    if relation is None and "side" in said:
        relation = f"{said['side']}-of"
    lengths = [one.get("length") for one in node.children if one.symbol == "length"]
    if relation is None and lengths:
        relation = "near"
    phrases = tuple(noun_phrase(one) for one in targets)
    if not targets:  # "on its left"
        phrases = (NounPhrase("", pronoun="it"),)
    if any(one.symbol == "junction" for one in node.children):
        lengths = []
    return Relation(
        relation=relation,
        targets=phrases,
        at=Position(distance=lengths[0]) if lengths else Position(),
        ego_at=said.get("at"),
        strong=bool(said.get("strong")) or not any(one.symbol == "prep" for one in node.children),
        overtakes=said.get("motion") == "overtakes",
        followed=bool(said.get("followed")),
        at_it=any(one.symbol in ("at_prep", "inside") for one in node.children),
        acts=bool(said.get("does")),
        target_place=place_of(places[0]) if places else None,
        tokens=tokens_of(node),
    )


def place_of(node: Node) -> Place:
    """A place with the meanings of all its words."""
    return Place(
        at=node.get("at", Position()),
        times=node.get("times", 1),
        road=node.get("road"),
        lanes=node.get("lanes", 0),
        bend_side=node.get("bendside", ""),
        only=any(leaves(node, "'only")),
        centre=bool(node.get("centre")) or bool(node.get("middle")),
        in_row=any(leaves(node, "neighbour")) and any(leaves(node, "the_next")),
        of_all=any(leaves(node, "each")) and any(leaves(node, "neighbour")),
        tokens=tokens_of(node),
        **{name: bool(node.get(name)) for name in _MARKS_OF_PLACES},
    )


def street_of(node: Node) -> Street:
    """A road, its lanes and sidewalks."""
    roads = [value for value in node.all("road") if value]
    kinds = [road for road in roads if road != "straight"] or roads
    wide = node.all("wide")
    kind = kinds[-1] if kinds else None
    bends = [road for road in roads if road.endswith("bend")]
    counts = [one.get("count") for one in leaves(node, "quantity")] if node.symbol in ("lanes", "street") else []
    exact = [count for count in counts if type(count) is int]
    if len(exact) != 1 or len(counts) != 1:
        exact = []
    denied = any(leaves(node, "no"))
    is_walkway = node.symbol == "walkway"
    return Street(
        kind=bends[-1] if bends and kind in ("straight", *bends) else kind,
        lanes=tuple(node.all("lanes")) + (tuple(exact) if node.symbol == "lanes" else ()),
        usual_lanes=wide[-1] if wide and roads and not is_walkway else 0,
        one_way=bool(node.get("one_way")),
        each_way=bool(node.get("each_way")),
        sidewalk=not any(leaves(node, "no")) if is_walkway else None,
        settings=frozenset() if is_walkway else frozenset(node.all("setting")),
        definite=any(leaves(node, "the")),
        on=node.symbol == "road_part",
        denied=denied and not is_walkway,
    )


def is_known(phrase: NounPhrase) -> bool:
    """Whether the phrase names a kind."""
    return bool(phrase.kind) and phrase.kind in SENTENCE_KINDS
