"""The constituents of a sentence become clauses: a lead, and objects with the modifiers after each."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterable, Iterator

from lidardraft.drafting.text.chart import Node
from lidardraft.drafting.text.grammar import UNSHOWN
from lidardraft.drafting.text.positions import LEFT, RIGHT, Position
from lidardraft.drafting.text.tree import (
    Clause,
    Item,
    Manner,
    Modifier,
    NounPhrase,
    Place,
    Relation,
    Said,
    Street,
    is_known,
    leaves,
    manner_of,
    noun_phrase,
    place_of,
    relation_of,
    street_of,
    tokens_of,
)
from lidardraft.objects.kinds import SENTENCE_KINDS

LINKS = (",", ":", "(", ")", "and", "or", "with", "has", "but", "except", "which")
_WEAK = (",", ":", "(", ")")  # that say less than the word beside them
_NAMES = ("object", "ellipsis", "stranger", "pronoun", "ego", "nothing")
_ROADS = ("street", "lanes", "walkway", "oneway", "eachway")
_MANNERS = ("state", "crossed", "turned", "measure", "abreast", "overtaking", "overtakes")
_SAID = ("whereabouts", "relation", "road_part", "distances", "blocked", *_MANNERS)
_PASSED = ("is", "silent", "there")
_BOTH_SIDES = Position((LEFT, RIGHT), both_sides=True)
_FALSE_NOUNS = ("ed", "ing", "ly")  # endings of words that modify the noun before them


def clauses_of(nodes: list[Node], texts: list[str]) -> list[Clause]:
    """The clauses of a text, whose tokens are `texts`."""
    found: list[Clause] = []
    for sentence in _sentences(_with_crosswalks(_with_names(nodes, texts), texts)):
        found += _Reading(sentence, texts).clauses()
    return found


def _sentences(nodes: Iterable[Node]) -> Iterator[list[Node]]:
    for is_stop, part in itertools.groupby(nodes, lambda node: node.symbol == "."):
        if not is_stop:
            yield list(part)


def _with_names(nodes: list[Node], texts: list[str]) -> list[Node]:
    """The nodes, in which bare unknown words name unknown objects if they begin a clause or follow "with"."""
    found: list[Node] = []
    for node in nodes:
        before = found[-1].symbol if found else "."
        word = texts[node.start]
        noun = node.symbol == "unknown" and word[0].isalpha() and node.get("strange")
        if noun and before in (*LINKS, ".") and (not word.endswith(_FALSE_NOUNS) or word.endswith("thing")):
            found.append(node._replace(symbol="stranger"))
        elif (
            node.symbol == "unknown"
            and before == "stranger"
            and node.get("strange")
            and not word.endswith(_FALSE_NOUNS)
        ):
            found[-1] = found[-1]._replace(end=node.end)
        elif node.symbol == "unseen" and node.children[0].symbol != "worn" and not _goes_on_with(found, "unseen"):
            found.append(node._replace(symbol="stranger"))  # "a hat on the road"
        else:
            found.append(node)
    return found


def _goes_on_with(before: list[Node], symbol: str) -> bool:
    """Whether "and" continues a constituent, as in "with a hat and a coat"."""
    return [node.symbol for node in before[-2:]] == [symbol, "and"]


def _with_crosswalks(nodes: list[Node], texts: list[str]) -> list[Node]:
    """The nodes, with a crosswalk for "a pedestrian crossing with two women", who are on it."""
    found: list[Node] = []
    for index, node in enumerate(nodes):
        words = texts[node.start : node.end]
        link, walkers = [*nodes[index + 1 : index + 3], node, node][:2]
        crossing = (
            node.symbol == "crossed" and words == ["crossing"] and found and texts[found[-1].end - 1] == "pedestrian"
        )
        walks = walkers.symbol == "object" and SENTENCE_KINDS[walkers.get("kind")].walks
        if crossing and link.symbol == "with" and walks:
            found[-1] = _crosswalk(found[-1].start, node.end)
        elif node.symbol == "crosswalk" or (crossing and found[-1].end - found[-1].start == 1 and link.symbol == ","):
            start = node.start if node.symbol == "crosswalk" else found.pop().start
            found.append(_crosswalk(start, node.end))
        else:
            found.append(node)
    return found


def _crosswalk(start: int, end: int) -> Node:
    return Node("whereabouts", start, end, 0.0, (("at", Position(heading="across")), ("crosswalk", True)))


class _Reading:
    """The constituents of one sentence on their way to clauses."""

    def __init__(self, nodes: list[Node], texts: list[str]) -> None:
        self._nodes, self._texts = nodes, texts
        self._found: list[Clause] = []
        self._lead: list[Modifier] = []
        self._items: list[Item] = []
        self._clause_link = ""
        self._anchor = -1  # the item before a bracket
        self._about = (0, -1)  # the number of items, and of the item last modified
        self._lined = False  # whether the next objects are along both sides
        self._carried = False  # whether the next object is carried, pushed or led
        self._comma = False  # whether a comma is before its "and"
        self._unclear = False  # whether the clause begins with unknown words
        self._alone = False  # whether the lead introduces no object

    def clauses(self) -> list[Clause]:
        """The clauses of the sentence."""
        index, link, verb = 0, "", ""
        while index < len(self._nodes):
            node = self._nodes[index]
            if node.symbol == "(":
                self._anchor = len(self._items) - 1
            if node.symbol in LINKS:
                link, verb = self._linked(link, index), "" if node.symbol == "," else verb
            elif node.symbol == "is":
                verb = verb or node.get("verb")
            elif node.symbol == "there":
                if self._items and (self._at(index + 1) in ("", *LINKS)):
                    place = Place(Position(), there=True, tokens=tokens_of(node))
                    self._items[-1] = _with(self._items[-1], Modifier(place, link))
                verb = "there"
            elif node.symbol == "respectively":
                self._part_out()
            elif node.symbol == "ego" and self._only_looks(index):
                link = "" if self._at(index + 1) == "has" else link
                index += self._at(index + 1) == "has"
            elif (
                node.symbol in ("busy", "quiet", "size", "colour") and self._items and self._is_said(index, verb, link)
            ):
                self._qualify(node)
                link = ""
            elif node.symbol in ("unknown", *UNSHOWN):
                verb = verb or ("one" if link == "and" and self._word(node).endswith("ing") else "")
                link = "" if link == "has" or node.symbol == "unseen" else link
                self._unclear = self._unclear or not self._items
                if self._items and not self._items[-1].modifiers:
                    self._items[-1] = dataclasses.replace(self._items[-1], is_told=True)
            elif node.symbol in (*_NAMES, *_ROADS):
                self._name(node, link, "" if verb == "there" else verb)
                link = verb = ""
            elif node.symbol in _SAID:
                index = self._say(index, link, "" if verb == "there" else verb)
                link = verb = ""
                continue
            index += 1
        self._end()
        return self._found

    def _is_said(self, index: int, verb: str, link: str) -> bool:
        """Whether a single word modifies the one before it, as in "the road is wide" and "a road, narrow"."""
        of_road = link == "," and isinstance(self._items[-1].head, Street) and self._at(index + 1) in ("", *LINKS)
        return (bool(verb) and not link) or of_road

    def _at(self, index: int) -> str:
        return self._nodes[index].symbol if index < len(self._nodes) else ""

    def _word(self, node: Node) -> str:
        return self._texts[node.end - 1]

    def _linked(self, link: str, index: int) -> str:
        """The combined meaning of several links in a row."""
        node = self._nodes[index]
        if self._word(node) == "then":
            return "then"
        area = self._items[-1].head if self._items else None
        if self._word(node) == "where" and isinstance(area, Street) and "median" in area.settings:
            return "with"
        if node.symbol == "has" and self._word(node) == "have":
            return "have" if self._items else ""
        if node.symbol == "has":
            return "has"
        self._lined, self._carried = bool(node.get("lined")), bool(node.get("act"))
        self._comma = node.symbol == "and" and link == ","
        strong = node.symbol in ("with", "except", "which")
        return node.symbol if not link or link in _WEAK or strong else link

    def _only_looks(self, index: int) -> bool:
        """Whether the observer is named only as such: "we see a bus", "if you look to the right"."""
        after = self._at(index + 1)
        return (
            after in ("silent", "has", "object", "stranger")
            and self._at(index + 2) != "is"
            and not (after == "silent" and self._at(index + 2) in ("overtakes", "state", "relation", "street"))
        )

    def _end(self, link: str = "") -> None:
        if self._items or (self._lead and not self._unclear):
            self._found.append(Clause(tuple(self._lead), tuple(self._items), self._clause_link, begins=not self._found))
        self._lead, self._items, self._clause_link, self._unclear = [], [], link, False

    def _part_out(self) -> None:
        """ "Respectively" pairs places with objects, one for each."""
        if self._items and self._items[-1].modifiers:
            each = tuple(dataclasses.replace(one, verb="respectively") for one in self._items[-1].modifiers)
            self._items[-1] = dataclasses.replace(self._items[-1], modifiers=each)

    def _name(self, node: Node, link: str, verb: str) -> None:
        """Open an object or a road; a road right after an object is the object's place."""
        if (
            self._alone
            and not self._items
            and not self._unclear
            and any(isinstance(one.said, Manner) for one in self._lead)
        ):
            self._items = [Item(NounPhrase("", pronoun="us"), modifiers=tuple(self._lead))]  # "driving down a street"
            self._lead = []
        elif self._alone and not self._items and node.symbol != "street":
            self._end(link)
        self._alone = False
        before = self._items[-1] if self._items else None
        named = before is not None and isinstance(before.head, NounPhrase)
        if node.symbol == "eachway":
            self._each_way(node, link)
            return
        if node.symbol in _ROADS:
            street = street_of(node)
            ego = before is not None and isinstance(before.head, NounPhrase) and before.head.pronoun == "us"
            traffic = before is not None and isinstance(before.head, NounPhrase) and before.head.traffic
            at = self._texts[max(0, node.start - 1)] == "at" and not traffic  # "crossing at an intersection"
            there = (street.definite or ego or at) and node.symbol == "street"
            if before is not None and named and not link and there:
                self._items[-1] = _with(before, Modifier(street, link, verb))
            elif before is not None and named and not link and node.symbol == "walkway" and street.sidewalk:
                at = node.get("at", Position(sidewalk=True))
                self._items[-1] = _with(before, Modifier(Place(at), link, verb))
            elif (
                before is not None
                and named
                and not link
                and node.symbol == "street"
                and street.kind == "straight"
                and not street.settings
                and not street.lanes
            ):
                self._items[-1] = _with(before, Modifier(street, link, verb))
            else:
                self._items.append(Item(street, link, verb))
            return
        head = noun_phrase(node)
        if head.kind is None and not link and before is not None and named and not self._is_placed(before):
            self._items[-1] = dataclasses.replace(before, is_told=True)
            return  # it only modifies the object before it: "a man walking his dog"
        if not link and named and is_known(head) and (head.kind == "animal" or head.owned):
            link = "with"  # "a man walking his dog"
        along = (Modifier(Place(_BOTH_SIDES)),) if self._lined and link == "with" else ()
        self._items.append(
            Item(
                head,
                link,
                verb,
                along,
                comma=self._comma and link == "and",
                is_carried=self._carried and link == "with",
            )
        )

    def _qualify(self, node: Node) -> None:
        """ "The road is busy", "the traffic is heavy", "the house is big"."""
        item = self._items[-1]
        head = item.head
        if isinstance(head, NounPhrase):
            if head.traffic and node.symbol != "size":
                head = dataclasses.replace(head, count="many" if node.symbol == "busy" else "few")
                self._items[-1] = dataclasses.replace(item, head=head)
            elif node.symbol == "colour" or (node.symbol == "size" and is_known(head)):
                self._items[-1] = _with(item, Modifier(manner_of([node]), verb="one"))
        elif not head.sidewalk:
            settings = head.settings | frozenset(node.all("setting"))
            wide = node.get("wide", head.usual_lanes)
            new = dataclasses.replace(head, settings=settings, usual_lanes=wide)
            self._items[-1] = dataclasses.replace(item, head=new)

    def _is_placed(self, item: Item) -> bool:
        assert isinstance(item.head, NounPhrase)
        return item.head.kind is None or any(not isinstance(one.said, Manner) for one in item.modifiers)

    def _each_way(self, node: Node, link: str) -> None:
        """For lanes, or for traffic in them; a number before it counts lanes, as in "four lanes, two each way"."""
        last = self._items[-1].head if self._items else None
        if isinstance(last, NounPhrase) and last.kind == "" and last.exact and isinstance(last.count, int):
            street = Street(lanes=(last.count,), each_way=True)
            self._items[-1] = dataclasses.replace(self._items[-1], head=street)
        elif isinstance(last, NounPhrase) and is_known(last):
            said = manner_of([node])
            if SENTENCE_KINDS[str(last.kind)].drives:
                said = dataclasses.replace(said, heading="both")
            self._items[-1] = _with(self._items[-1], Modifier(said, link))
        elif isinstance(last, Street) and last.lanes:
            street = dataclasses.replace(last, each_way=True)
            self._items[-1] = dataclasses.replace(self._items[-1], head=street)
        else:
            self._items.append(Item(Street(each_way=True), link))

    def _say(self, index: int, link: str, verb: str) -> int:
        """Attach a modifier to the objects after it or before it; returns the index of the next constituent."""
        node, end = self._nodes[index], self._leads_to(index, link)
        if end:
            if self._items or (self._lead and link):
                self._end(link)
            self._clause_link = self._clause_link or link
            for one in self._nodes[index:end]:
                if one.symbol in _SAID:
                    self._lead += self._modifiers(one, link, "")
                    link = ""
                elif one.symbol == "which":
                    link = "which"
            return end
        if link in (",", "and", "but") and self._items and self._at(index + 1) == "is":
            return index + 1  # "and the left lane is free"
        if node.symbol == "blocked":
            return index + 1
        first = self._texts[node.start]
        singular = node.symbol in (*_MANNERS, "relation") and first.endswith("s") and first not in ("across", "towards")
        modifiers = self._modifiers(node, link, "one" if singular else verb)
        if self._at(index + 1) in ("whereabouts", "state", "which"):
            modifiers = [_of_another_car(one) for one in modifiers]
        for modifier in modifiers:
            if self._items:
                at = self._anchor if link == ")" and self._anchor >= 0 else self._subject(link, verb or singular)
                self._about = (len(self._items), at)
                self._items[at] = _with(self._items[at], modifier)
            else:
                self._lead.append(modifier)
        self._alone = not self._items
        return index + 1

    def _subject(self, link: str, has_verb: object) -> int:
        """The item that a modifier is about: after "and", or after a carried object, that before its verb."""
        same = link in ("", ",") and self._about[0] == len(self._items)
        at = self._about[1] if same else len(self._items) - 1
        last = self._items[at].modifiers[-1].said if self._items[at].modifiers else None
        goes_on = has_verb and (link == "and" or (not link and last is not None))
        goes_on = goes_on or (
            bool(has_verb) and self._items[at].link == "with" and isinstance(self._items[at - 1].head, NounPhrase)
        )
        goes_on = goes_on or (link == "," and isinstance(last, Relation) and last.targets[0].pronoun == "it")
        head = self._items[at].head
        if at > 0 and link == "," and isinstance(head, NounPhrase) and head.without:
            return at - 1  # "a car without others around, crossing ahead"
        while at > 0 and goes_on and self._items[at].link in ("with", "has", *([""] if link else [])):
            at -= 1
        return at

    def _leads_to(self, index: int, link: str) -> int:
        """The index of the object that this lead introduces; 0 if it modifies objects before it.

        The object follows at once or after a colon, or after a comma if the sentence has no object before it.
        """
        if self._items and not link:
            return 0
        free, comma = not self._items, False
        backward = self._nodes[index].symbol == "relation" and any(leaves(self._nodes[index], "pronoun", "owner"))
        for end in range(index, len(self._nodes)):
            node = self._nodes[end]
            if node.symbol == "state" and self._word(node) == "for":
                return 0  # "and waits for a bus"
            if node.symbol in ("object", "ellipsis", "stranger", "nothing"):
                alone = node.symbol == "ellipsis" and comma
                return end if end > index and not alone and (free or not comma or (backward and link == "and")) else 0
            if link == "but" and node.symbol in ("street", "lanes", "walkway"):
                return end  # "while in front the road is free"
            if node.symbol in (",", "which"):
                comma = True
            elif node.symbol in (":", "has") or (node.symbol == "with" and self._has_things(index, link)):
                continue
            elif node.symbol not in (*_SAID, *_PASSED, "ego") or (node.symbol == "ego" and not self._only_looks(end)):
                return 0
        return 0

    def _has_things(self, index: int, link: str) -> bool:
        """Whether the objects a place is "with" are there: "a crosswalk with two men", "a bus, the left lane with two
        cars"."""
        node = self._nodes[index]
        at = node.get("at")
        if node.get("crosswalk") or (isinstance(at, Position) and at.at_junction):
            return True
        return link == "," and bool(self._items) and node.symbol == "whereabouts"

    def _modifiers(self, node: Node, link: str, verb: str) -> list[Modifier]:
        if node.symbol == "distances":
            places = [Place(at, tokens=tokens_of(node)) for at in node.get("places")]
            return [Modifier(place, link if index == 0 else "and", verb) for index, place in enumerate(places)]
        return [Modifier(self._said(node), link, verb)]

    @staticmethod
    def _said(node: Node) -> Said:
        if node.symbol == "whereabouts":
            return place_of(node)
        if node.symbol == "relation":
            return relation_of(node)
        return street_of(node) if node.symbol == "road_part" else manner_of([node])


def _of_another_car(modifier: Modifier) -> Modifier:
    """ "Behind the car on the left" is behind a car of the scene, not behind the ego's."""
    if not isinstance(modifier.said, Relation):
        return modifier
    targets = tuple(dataclasses.replace(one, plain=False) for one in modifier.said.targets)
    return dataclasses.replace(modifier, said=dataclasses.replace(modifier.said, targets=targets))


def _with(item: Item, modifier: Modifier) -> Item:
    return dataclasses.replace(item, modifiers=(*item.modifiers, modifier))
