"""What belongs to what in a parsed sentence: numbers to objects, positions to the objects they follow or introduce."""

from __future__ import annotations

import dataclasses

from lark import Token, Tree

from lidardraft.drafting.number_words import COUNT_TYPES, count_of, exact_count, unclear_counts
from lidardraft.drafting.positions import Position, read_position
from lidardraft.drafting.sentence_kinds import SENTENCE_KINDS
from lidardraft.drafting.sentence_notes import Mention, SentenceNotes

Chunk = Tree[Token] | Token

KIND_OF = {kind.upper().replace("-", "_"): kind for kind in SENTENCE_KINDS}  # by its terminal in the grammar
_ROAD_OF = {"ROAD": "straight", "MOTORWAY": "motorway", "CROSSROADS": "crossroads", "T_JUNCTION": "t-junction"}
_SETTINGS = {"BUSY", "QUIET", "URBAN", "RESIDENTIAL", "RURAL", "TREE_LINED"}
_HEADING_OF = {"PARKED": "parked", "MOVING": "with", "CROSSING": "across", "ONCOMING": "against"}
_LISTED = ("AND", "OR", "COMMA")


class SentenceReader:
    """Reads the chunks of a parsed sentence from left to right."""

    def __init__(self, chunks: list[Chunk]) -> None:
        self.chunks = chunks
        self.notes = SentenceNotes()
        self.open: list[Mention] = []  # what the next position or state belongs to
        self.prefix: Position | None = None  # introduces the objects that follow
        self.prefix_weak = False
        self.denial = ""  # the word that denies a list of objects
        self.has_ego = False

    def read(self) -> SentenceNotes:
        """The notes on all chunks."""
        for index, chunk in enumerate(self.chunks):
            if isinstance(chunk, Token):
                self._link(chunk)
            elif chunk.data == "bend":
                side = "".join(f"{t.type.lower()}-" for t in _tokens(chunk) if t.type != "BEND")
                self.notes.road = f"{side}bend"
            elif chunk.data == "position":
                self._position(index, _tokens(chunk))
            else:
                self._phrase(index, _tokens(chunk))
        return self.notes

    def _link(self, token: Token) -> None:
        if token.type in ("WITH", "STOP"):
            self.open, self.prefix, self.denial = [], None, ""
        elif token.type == "EGO":
            self.has_ego = True
        elif token.type == "COMMA":
            self.prefix_weak, self.denial = True, ""
        elif token.type == "AND" and self.denial != "without":
            self.denial = ""

    def _phrase(self, index: int, tokens: list[Token]) -> None:
        noun = tokens[-1].type
        if self._is_compound(index, tokens):
            whole = [*self._tokens_at(index - 1), *tokens]
            self.notes.mentions.remove(self.open.pop())
            self.notes.not_understood.append(" ".join(token for token in whole if token.type not in ("A", "THE")))
            return
        if exact_count(tokens) == 0 and noun in (*_ROAD_OF, "LANE", "EACH_WAY", "NO_SIDEWALK"):
            self.notes.not_understood.append(" ".join(tokens))
            return
        if noun in _ROAD_OF or noun in _SETTINGS:
            self.notes.settings |= _SETTINGS & {token.type for token in tokens}
        strange = {"UNKNOWN"} | (_SETTINGS if noun in KIND_OF or noun == "UNKNOWN" else set())
        idle = {id(token) for token in self._idle_counts(tokens)}
        unknown = " ".join(token for token in tokens if token.type in strange or id(token) in idle)
        self.notes.not_understood += [unknown] if unknown else []
        if noun in KIND_OF:
            self._object(index, tokens)
        elif noun == "TRAFFIC":
            self._traffic(index, tokens)
        elif noun in _ROAD_OF:
            self._road(index, tokens)
        elif noun == "LANE":
            self.notes.lanes = self.notes.lanes or exact_count(tokens) or 0
        elif noun == "EACH_WAY":
            self.notes.each_way = True
        elif noun == "NO_SIDEWALK":
            self.notes.sidewalk = False
        else:
            self._state(tokens)

    def _state(self, tokens: list[Token]) -> None:
        """Words without a noun: how the objects before them stand or move."""
        heading = _heading(tokens)
        for mention in self.open:
            mention.heading = heading or mention.heading
        lone = " ".join(token for token in tokens if token.type in ("PARKED", "CROSSING", "ONCOMING"))
        self.notes.not_understood += [lone] if lone and not self.open else []

    def _idle_counts(self, tokens: list[Token]) -> list[Token]:
        """The words for a number in a phrase that say nothing of its noun."""
        noun, exact = tokens[-1].type, exact_count(tokens)
        if noun in KIND_OF:
            return unclear_counts(tokens)
        if noun == "TRAFFIC":
            clear = not exact and not unclear_counts(tokens)
        elif noun == "LANE":
            clear = exact is not None and self.notes.lanes in (0, exact)
        else:
            clear = exact == 1 and (noun in _ROAD_OF or noun in ("EACH_WAY", "NO_SIDEWALK"))
        return [] if clear else [token for token in tokens if token.type in COUNT_TYPES]

    def _object(self, index: int, tokens: list[Token]) -> None:
        kind = KIND_OF[tokens[-1].type]
        if self._is_reference(index, tokens):
            return
        if self._is_ego(index, tokens, kind):
            self.has_ego = True
        elif SENTENCE_KINDS[kind].is_ridden and self._is_ridden(index):
            self.open[-1].kind = kind
            if exact_count(tokens) not in (None, 1, self.open[-1].count):
                self.notes.not_understood += [token for token in tokens if token.type in COUNT_TYPES]
        else:
            self._put(index, Mention(kind, count_of(tokens), heading=_heading(tokens)))

    def _traffic(self, index: int, tokens: list[Token]) -> None:
        types = {token.type for token in tokens}
        many, few = types & {"BUSY", "MANY", "DOZENS"} or tokens[-1] != "traffic", types & {"QUIET", "FEW"}
        count: int | str = 0 if "NO" in types else "few" if few else "many" if many else "some"
        self._put(index, Mention("vehicle", count, heading=_heading(tokens)))

    def _put(self, index: int, mention: Mention) -> None:
        """Open a mention: alone, or beside those that a list has opened and no position has closed."""
        listed = self._type_before(index) in _LISTED
        if not listed or any(other.placed for other in self.open):
            self.open = []
        if mention.count == 0:
            self.denial = str(_tokens(self.chunks[index])[0])
        elif self.denial and listed:
            mention.count = 0
        if self.prefix is not None:
            mention.at, mention.placed, mention.weak = self.prefix, True, self.prefix_weak
        self.open.append(mention)
        self.notes.mentions.append(mention)

    def _road(self, index: int, tokens: list[Token]) -> None:
        kind = _ROAD_OF[tokens[-1].type]
        if kind != "straight" or self.notes.road is None:
            self.notes.road = kind
        if tokens[0].type == "THE" and self._type_before(index) not in _LISTED:
            for mention in self.open:
                mention.on_road = not mention.placed

    def _position(self, index: int, tokens: list[Token]) -> None:
        """Give a position to the objects before it, or keep it for those after it."""
        following = self._tokens_at(index + 1)
        types = {token.type for token in tokens}
        before = self._type_before(index)
        listed = before in _LISTED
        for types_of_length in (_DISTANCES, ("SPACING",)):  # the last one counts
            self.notes.not_understood += [token for token in tokens if token.type in types_of_length][:-1]
        position = read_position(tokens, beside_road=bool(following) and following[-1].type in _ROAD_OF)
        if _refers(tokens, following):
            self.notes.not_understood.append(" ".join([*tokens, *following]))
        elif types <= {"SIDEWALK", "SIDES", "ALONG"} and position.sidewalk and (listed or not self.open):
            self.notes.sidewalk = True
        elif before in (None, "STOP", "WITH", *_LISTED) and self._introduces(index, strongly=not self.open):
            self.prefix, self.prefix_weak = position, False
        elif self.open:
            self._attach(position, tokens, listed)
        elif position != Position(beside_road=position.beside_road):  # a road alone has no place
            self.notes.not_understood.append(" ".join(tokens))

    def _attach(self, position: Position, tokens: list[Token], listed: bool) -> None:
        """To the open mentions: a further place after "and", a closer description of the same place otherwise."""
        for mention in list(self.open):
            if position.sidewalk and "sidewalk" not in SENTENCE_KINDS[mention.kind].surfaces:
                self.notes.not_understood.append("sidewalk")
            if not mention.placed or mention.weak:
                mention.at = position
            elif listed and (position.distance or mention.at.distance):
                other = dataclasses.replace(mention, at=position)
                self.notes.mentions.append(other)
                self.open[self.open.index(mention)] = other
            elif listed:
                mention.at = mention.at.or_at(position)
            else:
                mention.at = mention.at.narrowed(self._without_second_length(position, tokens, mention.at))
            mention.placed, mention.weak = True, False

    def _without_second_length(self, position: Position, tokens: list[Token], at: Position) -> Position:
        """A further position of what is `at` a place: its first distance and spacing stay, and others are reported."""
        for types, known in ((_DISTANCES, at.distance), (("SPACING",), at.spacing)):
            self.notes.not_understood += [token for token in tokens if known and token.type in types]
        return dataclasses.replace(
            position,
            distance=None if at.distance else position.distance,
            spacing=None if at.spacing else position.spacing,
        )

    def _introduces(self, index: int, *, strongly: bool) -> bool:
        """Whether an object follows a position at once, or, where nothing is open yet, after a comma."""
        passed = ("EGO", "COMMA") if strongly else ("EGO",)
        nouns = [_tokens(chunk)[-1].type for chunk in self.chunks[index + 1 : index + 4]]
        noun = next((noun for noun in nouns if noun not in passed), "")
        return noun in KIND_OF or noun == "TRAFFIC"

    def _is_compound(self, index: int, tokens: list[Token]) -> bool:
        """Whether unknown words make something else of the object right before them, as in "bus stop"."""
        before = self._tokens_at(index - 1)
        if not self.open or not before or KIND_OF.get(before[-1].type) != self.open[-1].kind:
            return False
        if before[-1].endswith("s") and before[-1] != "bus":  # compounds begin with a singular
            return False
        return all(token.type == "UNKNOWN" for token in tokens) and not tokens[0].endswith(("ing", "ed", "ly"))

    def _is_reference(self, index: int, tokens: list[Token]) -> bool:
        """Whether an object only tells where another one is, as in "behind the bus"."""
        before = self._tokens_at(index - 1)
        return bool(before) and _is_position(self.chunks[index - 1]) and _refers(before, tokens)

    def _is_ego(self, index: int, tokens: list[Token], kind: str) -> bool:
        """Whether the first object of a sentence is who looks: a vehicle that drives on a road, and nowhere else."""
        if self.notes.mentions or self.has_ego or not SENTENCE_KINDS[kind].is_vehicle or count_of(tokens) != 1:
            return False
        after = [token.type for chunk in self.chunks[index + 1 :] for token in _tokens(chunk)]
        rest = [type for type in after if type not in _PASSED_ON_THE_WAY] + ["", ""]
        return after[:1] == ["MOVING"] and (rest[0] in _ROAD_OF or rest[0] == "BEND") and rest[1] not in _ASIDE

    def _is_ridden(self, index: int) -> bool:
        """Whether a two-wheeler is that of a person just named, as in "a man riding a bike"."""
        said = [token for chunk in self.chunks[max(0, index - 1) : index + 1] for token in _tokens(chunk)]
        riding = any(token.type == "DOING" and token.startswith("rid") for token in said)
        return riding and bool(self.open) and SENTENCE_KINDS[self.open[-1].kind].walks

    def _type_before(self, index: int) -> str | None:
        """The type of the link before a chunk; None at the start, "" after anything but a link."""
        if index == 0:
            return None
        before = self.chunks[index - 1]
        return before.type if isinstance(before, Token) and before.type != "EGO" else ""

    def _tokens_at(self, index: int) -> list[Token]:
        inside = 0 <= index < len(self.chunks) and isinstance(self.chunks[index], Tree)
        return _tokens(self.chunks[index]) if inside else []


_PASSED_ON_THE_WAY = ("MOVING", "ALONG", "A", "THE", "NUMBER", "LANE", "UNKNOWN", *_SETTINGS)
_ASIDE = ("FRONT", "BEHIND", "BESIDE", "LEFT", "RIGHT", "SIDES", "DISTANCE")
_DISTANCES = ("DISTANCE", "NEAR", "FAR")
_REFERRING = ("BEHIND", "BESIDE", "NEAR", "RELATED")


def _tokens(chunk: Chunk) -> list[Token]:
    return [chunk] if isinstance(chunk, Token) else [token for token in chunk.children if isinstance(token, Token)]


def _is_position(chunk: Chunk) -> bool:
    return isinstance(chunk, Tree) and chunk.data == "position"


def _heading(tokens: list[Token]) -> str | None:
    return next((_HEADING_OF[token.type] for token in tokens if token.type in _HEADING_OF), None)


def _refers(position: list[Token], named: list[Token]) -> bool:
    """Whether a position is relative to the object named after it."""
    if not named or named[-1].type not in KIND_OF:
        return False
    last, definite = position[-1], named[0].type == "THE"
    if last.type in ("BESIDE", "RELATED") or (last.type == "FRONT" and last.endswith(" of")):
        return True
    return definite and last.type in _REFERRING
