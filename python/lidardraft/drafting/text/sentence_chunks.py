"""A parsed sentence as a run of chunks: noun phrases, positions, and the links between them."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import NamedTuple

from lark import Token, Tree

from lidardraft.drafting.solver.sentence_kinds import SENTENCE_KINDS
from lidardraft.drafting.text.number_words import COUNT_TYPES, is_plural

KIND_OF = {kind.upper().replace("-", "_"): kind for kind in SENTENCE_KINDS}  # by its terminal in the grammar
ROAD_OF = {
    "ROAD": "straight",
    "MOTORWAY": "motorway",
    "CROSSROADS": "crossroads",
    "T_JUNCTION": "t-junction",
    "ROUNDABOUT": "roundabout",
    "PARKING_LOT": "parking-lot",
}
JUNCTIONS = ("CROSSROADS", "T_JUNCTION", "ROUNDABOUT")
SETTINGS = ("BUSY", "QUIET", "URBAN", "RESIDENTIAL", "RURAL", "TREE_LINED")
STATES = ("PARKED", "MOVING", "DOING", "QUEUEING", "CROSSING", "ONCOMING")
_NOUNS = (*KIND_OF, *ROAD_OF, "TRAFFIC", "LANE", "COMPOUND")
_OBJECTS = (*KIND_OF, "TRAFFIC")
_ARTICLES = ("A", "THE")
_DETERMINERS = (*_ARTICLES, *COUNT_TYPES, "ANOTHER", "FIRST", "EACH")
LISTED = ("AND", "OR", "COMMA")
_RELATING = (
    "BEHIND",
    "FRONT",
    "BESIDE",
    "NEAR",
    "BETWEEN",
    "OPPOSITE",
    "LEFT_OF",
    "RIGHT_OF",
    "DISTANCE_FROM",
    "RELATED",
)
LINKS = ("WITH", "STOP", "EXCEPT", "EACH_HAS", *LISTED)
_FALSE_NOUNS = ("ed", "ing", "ly")  # endings of words that say more of the noun before them


class Chunk(NamedTuple):
    """A part of a sentence: "phrase", "position", "bend" or "turn", or the terminal of a link; with its tokens."""

    name: str
    tokens: list[Token]

    @property
    def head(self) -> str:
        """The terminal of the last token, which is that of the noun if there is one."""
        return self.tokens[-1].type if self.tokens else ""

    @property
    def types(self) -> set[str]:
        """The terminals of all tokens."""
        return {token.type for token in self.tokens}

    @property
    def span(self) -> tuple[int, int]:
        """Where its words stand in the text: from and to, without articles before them."""
        said = [token for token in self.tokens if token.type not in _ARTICLES] or self.tokens
        return min(token.start_pos or 0 for token in said), max(token.end_pos or 0 for token in self.tokens)

    @property
    def is_object(self) -> bool:
        """Whether it names objects of a kind, or traffic."""
        return self.name == "phrase" and self.head in _OBJECTS

    @property
    def is_unknown(self) -> bool:
        """Whether it names something that is no kind of object: a determiner or a compound without a noun."""
        if self.name != "phrase" or self.head in _NOUNS:
            return self.name == "phrase" and self.head == "COMPOUND"
        return "UNKNOWN" in self.types and bool(self.types & {*COUNT_TYPES, *_ARTICLES, "ANOTHER"})

    @property
    def may_be_unknown(self) -> bool:
        """Whether words without a determiner can name something, at the beginning of a clause."""
        unknown = [token for token in self.tokens if token.type == "UNKNOWN"]
        bare = bool(unknown) and self.name == "phrase" and self.head == "UNKNOWN" and not self.types & set(STATES)
        return bare and (not unknown[0].endswith(_FALSE_NOUNS) or unknown[0].endswith("thing"))


def chunks_of(tree: Tree[Token]) -> list[Chunk]:
    """The chunks of a parsed sentence: one noun a phrase, no articles alone, no prepositions before places."""
    chunks: list[Chunk] = []
    for child in tree.children:
        if isinstance(child, Token):
            chunks.append(Chunk(child.type, [child]))
            continue
        tokens = [token for token in child.children if isinstance(token, Token)]
        parts = _one_noun_each(tokens) if child.data == "phrase" else iter([tokens])
        chunks += [Chunk(str(child.data), part) for part in parts]
    chunks = _with_crosswalks(_with_overtakers(_with_names(chunks)))
    said = [chunk for chunk in chunks if not chunk.types <= {*_ARTICLES}]
    return _joined(_with_adjectives(said))


def _one_noun_each(tokens: list[Token]) -> Iterator[list[Token]]:
    """A noun in the singular belongs to the next one, as in "garden fence"; one in the plural stands alone."""
    part: list[Token] = []
    for token, following in zip(tokens, [*tokens[1:], None], strict=True):
        cycles = token == "cycles" and bool(part) and part[-1].type == "PERSON"
        if cycles:  # a verb
            yield part
            part = []
        part.append(Token.new_borrow_pos("DOING", "cycling", token) if cycles else token)
        ends = token.type in _NOUNS and (token.type not in KIND_OF or is_plural(token))
        # "a hat crosses" is an unknown noun with a verb, but "a rusty parked car" a known one
        verb = following is not None and following.type in STATES and token.type == "UNKNOWN"
        verb = verb and not any(after.type in _NOUNS for after in tokens)
        if following is None or ends or verb:
            yield part
            part = []


def _with_names(chunks: list[Chunk]) -> list[Chunk]:
    """With the names of objects in their phrases, before the noun: "car A", or "van 1" and "van 2"."""
    pairs = list(itertools.pairwise(chunks))
    numbers = {(one.head, str(after.tokens[0])) for one, after in pairs if _is_numbered(one, after)}
    found: list[Chunk] = []
    for chunk in chunks:
        first, rest = chunk.tokens[0], chunk.tokens[1:]
        named = bool(found) and found[-1].head in KIND_OF and found[-1].name == chunk.name == "phrase"
        numbered = named and _is_numbered(found[-1], chunk) and {(found[-1].head, n) for n in "12"} <= numbers
        if numbered or (named and first.type == "NAME" and not is_plural(found[-1].tokens[-1])):
            found[-1] = Chunk("phrase", [Token.new_borrow_pos("NAME", str(first), first), *found[-1].tokens])
            found += [Chunk("phrase", rest)] if rest else []
        else:
            of_none = {token: "A" if token == "A" else "UNKNOWN" for token in chunk.tokens if token.type == "NAME"}
            found.append(
                Chunk(chunk.name, [Token.new_borrow_pos(of_none.get(t, t.type), str(t), t) for t in chunk.tokens])
            )
    return found


def _is_numbered(named: Chunk, number: Chunk) -> bool:
    """Whether a number follows a single object at once."""
    single = named.head in KIND_OF and len(named.tokens) == 1 and not is_plural(named.tokens[0])
    return single and number.name == "phrase" and [token.type for token in number.tokens[:1]] == ["NUMBER"]


def _with_overtakers(chunks: list[Chunk]) -> list[Chunk]:
    """With "overtaking" behind the noun that it is a quality of, as in "four overtaking cars"."""
    found: list[Chunk] = []
    for chunk in chunks:
        count, verb = found[-2:] if len(found) > 1 else (chunk, chunk)
        counted = count.name == chunk.name == "phrase" and count.tokens[0].type in _DETERMINERS
        counted = counted and not count.types & set(_NOUNS) and _adjoins(count, verb)
        if counted and verb.tokens == ["overtaking"] and chunk.tokens[0].type not in _DETERMINERS:
            overtakes = Token.new_borrow_pos("OVERTAKING", "overtakes", verb.tokens[0])  # of this noun alone
            found[-2:] = [Chunk("phrase", [*count.tokens, *chunk.tokens]), Chunk("position", [overtakes])]
        else:
            found.append(chunk)
    return found


def _with_crosswalks(chunks: list[Chunk]) -> list[Chunk]:
    """With a crosswalk for "a pedestrian crossing with people", who are on it."""
    found: list[Chunk] = []
    for index, chunk in enumerate(chunks):
        link, walkers = [*chunks[index + 1 :], chunk, chunk][:2]
        crossing = bool(found) and found[-1].tokens[-1] == "pedestrian" and chunk.tokens == ["crossing"]
        crossing = crossing and found[-1].types <= {"A", "THE", "PERSON"} and link.tokens == ["with"]
        if crossing and walkers.head in KIND_OF and SENTENCE_KINDS[KIND_OF[walkers.head]].walks:
            found[-1] = Chunk("position", [Token.new_borrow_pos("CROSSWALK", str(chunk.tokens[0]), chunk.tokens[0])])
        else:
            found.append(chunk)
    return found


def _adjoins(one: Chunk, other: Chunk) -> bool:
    """Whether no word stands between them."""
    return (other.tokens[0].start_pos or 0) <= (one.tokens[-1].end_pos or 0) + 1


def _with_adjectives(chunks: list[Chunk]) -> list[Chunk]:
    """With places behind the noun that they say more of: "the left hedge" is "the hedge on the left"."""
    found: list[Chunk] = []
    for chunk in chunks:
        place = found[-1].tokens[-1] if found and found[-1].name == "position" else None
        if place is not None and chunk.head in KIND_OF and len(chunk.tokens) == 1 and _is_adjective(place, found):
            found[-1:] = [Chunk("position", found[-1].tokens[:-1])] if found[-1].tokens[1:] else []
            found += [Chunk("phrase", [Token("THE", "the"), *chunk.tokens]), Chunk("position", [place])]
        else:
            found.append(chunk)
    return found


def _is_adjective(place: Token, chunks: list[Chunk]) -> bool:
    """Whether a place just before a noun is no place of its own, as in "behind the left hedge"."""
    before = chunks[-1].tokens[-2:-1] or (chunks[-2].tokens[-1:] if len(chunks) > 1 else [])
    if place not in ("the left", "the right") or not (place.start_pos == 0 or before):
        return False
    adjoins = place.start_pos == 0 or (place.start_pos or 0) <= (before[0].end_pos or 0) + 1  # no "to" between them
    return adjoins and (not before or before[0].type in (*LINKS, *_RELATING))


def _is_verb_before_subject(chunks: list[Chunk]) -> bool:
    """Whether a clause ends with a place and a verb, as "on the left stand", so that the subject is to come."""
    if not chunks or not (chunks[-1].name == "phrase" and chunks[-1].types <= set(STATES)):
        return False
    if len(chunks) < 2 or chunks[-2].name in LINKS:  # "from ahead is coming a bus"
        return chunks[-1].types <= {"ONCOMING", "PARKED", "CROSSING"}
    before = len(chunks) - 2
    named = [one.name in ("PRONOUN", "EGO") or one.is_object for one in chunks]
    if before > 1 and named[before - 1] and chunks[before].name == "position":  # "between the vans on the left stands"
        before -= 1
    before -= named[before]
    return before >= 0 and chunks[before].name == "position" and (before == 0 or chunks[before - 1].name in LINKS)


def _is_verb_after_place(chunk: Chunk, before: list[Chunk]) -> bool:
    """Whether "behind us is following" says "behind" a second time."""
    follows = [token.type for token in chunk.tokens] == ["BEHIND"] and chunk.tokens[0].startswith("follow")
    return follows and len(before) > 1 and before[-1].name == "EGO" and before[-2].head == "BEHIND"


def _is_road_of_side(chunk: Chunk, before: list[Chunk]) -> bool:
    """Whether "the road" only says of what "on both sides" are sides."""
    sided = bool(before) and before[-1].head in ("LEFT", "RIGHT", "SIDES", "EACH_SIDE")
    return sided and [token.type for token in chunk.tokens] == ["THE", "ROAD"]


def _is_had_by_none(chunk: Chunk, before: list[Chunk]) -> bool:
    """Whether "have" follows no object that has something, as in "we have a bus ahead" or "on the left have a tree"."""
    if chunk.name != "EACH_HAS" or chunk.tokens != ["have"]:
        return False
    place = bool(before) and before[-1].name == "position" and (len(before) == 1 or before[-2].name in LINKS)
    return not before or before[-1].name == "EGO" or place


def _counts_listed(count: Chunk, link: Chunk, named: Chunk) -> bool:
    """Whether a number is that of a bare noun before it, as in "cars: 3" or "cars: 3 parked"."""
    bare = named.head in (*KIND_OF, "LANE") and not named.types & {*COUNT_TYPES, *_ARTICLES, "ANOTHER", "OF_THEM"}
    alone = count.tokens[0].type in COUNT_TYPES and all(token.type in STATES for token in count.tokens[1:])
    return bare and link.name in ("COMMA", "STOP") and count.name == "phrase" and alone


def _joined(chunks: list[Chunk]) -> list[Chunk]:
    """Without the prepositions that no object follows, and with positions that then adjoin as one."""
    found: list[Chunk] = []
    for index, chunk in enumerate(chunks):
        if chunk.name == "PREPOSITION":
            following = chunks[index + 1] if index + 1 < len(chunks) else None
            named = following is not None and (following.name == "PRONOUN" or following.head in (*KIND_OF, *JUNCTIONS))
            if not named:
                continue
        if _is_verb_after_place(chunk, found) or _is_road_of_side(chunk, found):
            continue
        if _is_had_by_none(chunk, found):
            continue
        if chunk.name == "position" and found and found[-1].name == "position":
            found[-1] = Chunk("position", [*found[-1].tokens, *chunk.tokens])
        elif chunk.is_object and _is_verb_before_subject(found):
            found[-1] = Chunk("phrase", [*found[-1].tokens, *chunk.tokens])
        elif len(found) > 1 and _counts_listed(chunk, found[-1], found[-2]):
            found[-2:] = [Chunk("phrase", [*chunk.tokens, *found[-2].tokens])]
        else:
            found.append(chunk)
    return found
