"""What positions in a sentence belong to: the objects before them, those after them, or another object."""

from __future__ import annotations

import dataclasses
import itertools

from lark import Token

from lidardraft.drafting.chunk_reader import END
from lidardraft.drafting.mention import Mention, keep_away
from lidardraft.drafting.number_words import SMALL_NUMBERS, count_times, metres, number
from lidardraft.drafting.positions import DISTANCES, LANE_WORDS, SET_BACK, Position, read_position
from lidardraft.drafting.references import meant_by, refers, relation_of
from lidardraft.drafting.relation_reader import RelationReader
from lidardraft.drafting.sentence_chunks import JUNCTIONS, LINKS, LISTED, ROAD_OF, Chunk
from lidardraft.drafting.sentence_kinds import SENTENCE_KINDS

_OF_NOTHING = ("RELATED", "BETWEEN", "LEFT_OF", "RIGHT_OF", "FOLLOWED")  # without an object after them
_OTHER_SIDE = ("opposite side", "other side", "far side", "off side")


class PositionReader(RelationReader):
    """Reads one position at a time."""

    def _position(self, chunk: Chunk) -> None:
        """Give a position to the objects before it, or keep it for those after it."""
        chunk = self._without_size(self._with_known_side(self._without_abreast(chunk)))
        if not chunk.tokens:
            return
        self._open_all(chunk)
        self._report_second_lengths(chunk)
        following, before = self._following(), self._before()
        if self._previous().name == "EGO" and following.name == "EGO":
            before = self._before(2)  # "if you look to the right you see"
        if self.manner and self.manner is self._previous().tokens:
            before = "STOP"
        if chunk.types & {"SIDEWALK"} and self._previous().head == "BUSY" and not self.open:
            self.notes.settings.discard("BUSY")  # it is the sidewalk that is crowded
            self._report(self._previous())
        linked = before != ""
        relation = relation_of(chunk.tokens[-1])
        host = self.open[0].host if self.open else None
        if following.name == "PRONOUN" and relation is not None:
            self.index += 1
            self._refer_to_pronoun(chunk, relation, following.tokens[0], before)
        elif self._several_named(following) and relation is not None:  # "under the third one there is a bench"
            several, rest = self._several_named(following), following.tokens[self._words_for_some(following) :]
            self.chunks[self.index : self.index + 1] = [Chunk("phrase", rest)] if rest else []
            if chunk.tokens[-1].type == "BETWEEN":
                self._skip_second(several)
            self._refer(chunk, relation, several, before)
        elif (following.is_object or following.is_unknown) and refers(chunk, following, linked=linked):
            self.index += 1
            if self._is_ego_named(following):
                self.has_ego = True
                self._place(chunk, self._following(), before)
            else:
                references = self._references(chunk, following, linked=linked)
                self._refer(chunk, relation_of(chunk.tokens[-1]), references, before)
        elif host is not None and relation is not None and not linked:
            self._refer(chunk, relation, [host], before)  # "each with a hedge in front"
        else:
            self._report_tokens(token for token in chunk.tokens if token.type in _OF_NOTHING)
            tokens = [token for token in chunk.tokens if token.type not in _OF_NOTHING]
            if tokens:
                self._place(Chunk("position", tokens), following, before)

    def _refer_to_pronoun(self, chunk: Chunk, relation: str, pronoun: str, before: str | None) -> None:
        listed = self._open_known()
        earlier = [m for m in self.notes.mentions if before != "" or not self.open or m is not self.open[-1]]
        road = self._road_named()
        if not earlier and road is not None and chunk.tokens[-1].type in ("NEAR", "BESIDE"):
            self._place(chunk, road, before)
            return
        meant = meant_by(pronoun, earlier)
        if listed and listed[0].host is not None:
            meant = [listed[0].host]
        elif pronoun in ("they", "them") and before == "" and len(listed) > 1:
            meant, self.open = listed[:-1], listed[-1:]  # "cars, lorries and a bus between them"
        side = self._following()
        if relation == "beside" and [token.type for token in side.tokens] in (["LEFT"], ["RIGHT"]):
            relation = "left-of" if side.head == "LEFT" else "right-of"  # "next to it on the left"
            self.index += 1
        for mention in listed if pronoun.startswith(("each", "every")) else []:
            mention.count = count_times(mention.count, meant[0].count) if meant else mention.count
        self._refer(chunk, relation, meant, before)

    def _several_named(self, chunk: Chunk) -> list[Mention]:
        """Those of which the first words of a phrase name some, as "the third one"; a noun may follow them."""
        several = [mention for mention in self.notes.mentions if mention.count not in (0, 1)][-1:]
        named = chunk.name == "phrase" and chunk.tokens[0].type in ("ANOTHER", "FIRST", "NUMBER", "THE")
        return several if named and self._words_for_some(chunk) else []

    @staticmethod
    def _words_for_some(chunk: Chunk) -> int:
        """How many of the first words name some of those before; 0 for none."""
        types = [token.type for token in chunk.tokens]
        number = len(list(itertools.takewhile(("ANOTHER", "FIRST", "NUMBER", "OF_THEM").__contains__, types)))
        definite = chunk.tokens[0].startswith("the ") or "OF_THEM" in types[:number]
        return number if definite and types[number : number + 1] in ([], ["A"], ["DOING"]) else 0

    def _skip_second(self, several: list[Mention]) -> None:
        """Pass over the other one of two neighbours, as in "between the second and the third one"."""
        link, other = self._following(), self._following(1)
        if link.name == "AND" and several and self._several_named(other):
            rest = other.tokens[self._words_for_some(other) :]
            verb = all(token.type == "DOING" for token in rest)
            self.chunks[self.index : self.index + 2] = [] if verb else [Chunk("phrase", rest)]

    def _is_ego_named(self, named: Chunk) -> bool:
        """Whether "the car" can only be that of the ego: no other was named."""
        vehicles = [one for one in self.notes.mentions if one.kind is not None and SENTENCE_KINDS[one.kind].is_vehicle]
        return [str(token) for token in named.tokens] in (["the", "car"], ["the", "vehicle"]) and not vehicles

    def _without_abreast(self, chunk: Chunk) -> Chunk:
        """The position without "side by side", which is noted or reported."""
        found = [token for token in chunk.tokens if token.type == "ABREAST"]
        if not found:
            return chunk
        known = self._open_known()
        if len(known) == 1 and isinstance(known[0].count, int) and known[0].count > 1:
            known[0].abreast = True
            known[0].spans.append(chunk.span)
        elif len(known) == 2 and known[1].relation is None and [one.count for one in known] == [1, 1]:
            known[1].relation, known[1].references, known[1].placed = "beside", known[:1], True
            self.open = known[:1]
        else:
            self._report_tokens(found)
        return Chunk("position", [token for token in chunk.tokens if token.type != "ABREAST"])

    def _with_known_side(self, chunk: Chunk) -> Chunk:
        """The position with a side for "the other side": the one where the last objects are not."""
        if not any(token.endswith(_OTHER_SIDE) for token in chunk.tokens):
            return chunk
        sides = [
            side
            for mention in self.notes.mentions
            if self._before(1) != "" or not any(mention is one for one in self.open)
            for _, side in mention.at.places
            if side
        ]
        other = "RIGHT" if sides[-1:] == ["left"] else "LEFT"
        tokens = [
            Token.new_borrow_pos(other, str(token), token) if token.endswith(_OTHER_SIDE) else token
            for token in chunk.tokens
        ]
        return Chunk("position", tokens)

    def _without_size(self, chunk: Chunk) -> Chunk:
        """The position without a length that is a size of the object before it, as in "a tall building of 30 m"."""
        named = self._previous()
        if not (named.is_object and chunk.tokens and chunk.tokens[0].type == "DISTANCE"):
            return chunk
        if self._between(named, chunk) != ["of"] or len(self._open_known()) != 1:
            return chunk
        long = SENTENCE_KINDS[str(self.open[0].kind)].follows_road or "LONG" in named.types
        self.open[0].size[0 if long and not named.types & {"TALL", "LOW"} else 2] = metres(chunk.tokens[0])[1]
        self.open[0].scale = [1.0, 1.0, 1.0]
        self.open[0].spans.append(chunk.span)
        return Chunk("position", chunk.tokens[1:])

    def _road_named(self) -> Chunk | None:
        """The road that "it" means in "a roundabout with houses around it"."""
        before = [chunk for chunk in self.chunks[: self.index] if chunk.name == "phrase" and chunk.head in ROAD_OF]
        return before[-1] if before and "NO" not in before[-1].types else None

    def _place(self, chunk: Chunk, following: Chunk, before: str | None) -> None:
        """A position that is relative to the ego, or to a road."""
        by_road = following.name == "phrase" and following.head in ROAD_OF
        position = read_position(chunk.tokens, beside_road=by_road)
        self._note_lanes(chunk)
        if by_road and following.head in JUNCTIONS and chunk.tokens[-1].type in ("FRONT", "BEHIND", "NEAR", "BESIDE"):
            position = dataclasses.replace(read_position(chunk.tokens[:-1]), at_junction=True)
        listed = before in LISTED
        sidewalk_only = chunk.types <= {"SIDEWALK", "SIDES", "EACH_SIDE", "ALONG"} and position.sidewalk
        if self.excepting:
            self._except(chunk, position)
        elif any(mention.kind is None for mention in self.open) and not (listed and self._introduces(strongly=False)):
            self._report(chunk)
            for mention in self.open:
                mention.at, mention.spans = mention.at.narrowed(position), [*mention.spans, chunk.span]
        elif sidewalk_only and (listed or not self.open) and not (self.prefix and self._introduces(strongly=True)):
            self.notes.sidewalk = True
        elif before == "WITH" and position.spacing and self.host:
            self.open = self.host
            self._attach(position, chunk, listed)
        elif before in (None, *LINKS) and self._introduces(strongly=not self.open or self.relation is not None):
            between = [chunk.name for chunk in self.chunks[self.prefix_index : self.index - 1]]
            adjoins = bool(between) and set(between) <= {"COMMA", "EGO"}  # "in front of us, at 30 m, a bus"
            self.prefix = self.prefix.narrowed(position) if self.prefix is not None and adjoins else position
            self.prefix_weak, self.prefix_index = False, self.index
        elif before in LISTED and {"is", "are"} & set(self._between(chunk, following)):
            self._report(chunk)  # "and the left lane is free"
        elif self.open:
            self._end_list(chunk)
            self._attach(position, chunk, listed)
        elif before == "STOP" and self._latest_known() and following.name in ("", "STOP"):  # "A bus! 20 m ahead!"
            self.open = self.latest
            self._attach(position, chunk, listed)
        elif position.sidewalk and before in (None, "WITH", "STOP", ""):
            self.notes.sidewalk = True
            self._report_tokens(t for t in chunk.tokens if t.type != "SIDEWALK")
        elif position != Position(beside_road=position.beside_road):  # a road alone has no place
            self._report(chunk)

    def _note_lanes(self, chunk: Chunk) -> None:
        """What "in both lanes" or "in each of the three lanes" says of the road."""
        for token in chunk.tokens:
            words = token.split() if token.type == "EACH_LANE" else []
            said = [int(number(word)) for word in words if word.isdigit() or word in SMALL_NUMBERS]
            self.notes.lanes = self.notes.lanes or (said[0] if said else 2 if {"both", "either"} & set(words) else 0)

    def _except(self, chunk: Chunk, position: Position) -> None:
        """All but those at a position; none but those, of what is denied."""
        self.excepting = False
        for mention in self.notes.mentions[-1:]:
            if mention.count == 0:
                mention.count, mention.at, mention.placed = "some", position, True
            else:
                keep_away(mention, position)
            mention.spans.append(chunk.span)

    def _attach(self, position: Position, chunk: Chunk, listed: bool) -> None:
        """To the open mentions: a further place after "and", a closer description of the same place otherwise."""
        corners = 4 if any(t.type == "CORNER" and t.startswith(("each", "every")) for t in chunk.tokens) else 1
        for mention in list(self.open):
            mention.count = count_times(mention.count, corners)
            at = self._fitting(position, chunk, mention)
            mention.spans.append(chunk.span)
            if not mention.placed or mention.weak:
                mention.at = at if mention.weak else mention.at.narrowed(at)
            elif listed and not self._goes_on(at, mention):
                if at.only_places and mention.at.only_places:
                    mention.at = mention.at.or_at(at)
                else:
                    other = dataclasses.replace(mention, at=at, spans=[chunk.span])
                    if at.distance and mention.at.distance and mention.count != 1:  # "two cars at 20 m and at 40 m"
                        self._list_distances(mention, other)
                    self.notes.mentions.append(other)
                    self.open[self.open.index(mention)] = other
                    mention = other
            else:
                mention.at = mention.at.narrowed(self._without_second_length(at, chunk, mention.at))
            mention.placed, mention.weak = True, False

    def _list_distances(self, mention: Mention, other: Mention) -> None:
        """One of several is at a further distance; the place that follows the last distance is that of all."""
        other.count, other.same_as, other.of_them = 1, mention.same_as or mention, mention.count != "some"
        mention.count = 1 if mention.count == "some" else mention.count
        rest = dataclasses.replace(other.at, distance=None)
        for one in self.notes.mentions:
            if (one is mention or one.same_as is other.same_as) and rest.agrees(
                dataclasses.replace(one.at, distance=None)
            ):
                one.at = rest.narrowed(one.at)

    def _goes_on(self, at: Position, mention: Mention) -> bool:
        """Whether a position after a comma describes the same place more closely, as in "on the left, 20 m away"."""
        closer = mention.count == 1 or not (at.only_places and mention.at.only_places)
        return self._before(1) == "COMMA" and closer and at.agrees(mention.at)

    def _fitting(self, position: Position, chunk: Chunk, mention: Mention) -> Position:
        """The position without what its kind cannot have, which is reported."""
        kind = SENTENCE_KINDS[str(mention.kind)]
        unfit = {"SIDEWALK"} if "sidewalk" not in kind.surfaces else set()
        unfit |= set(SET_BACK) if mention.references else set()
        unfit |= {"CROSSWALK"} if not kind.walks else set()
        unfit |= set(LANE_WORDS) if "road" not in kind.surfaces else set()
        self._report_tokens(t for t in chunk.tokens if t.type in unfit)
        return position if "CROSSWALK" not in unfit & chunk.types else dataclasses.replace(position, heading=None)

    def _report_second_lengths(self, chunk: Chunk) -> None:
        for types in (DISTANCES, ("SPACING",)):  # the last one counts
            tokens = [token for token in chunk.tokens if token.type in types][:-1]
            self._report_tokens(tokens)

    def _without_second_length(self, position: Position, chunk: Chunk, at: Position) -> Position:
        """A further position of what is `at` a place: its first distance and spacing stay, and others are reported."""
        for types, known in ((DISTANCES, at.distance), (("SPACING",), at.spacing)):
            tokens = [token for token in chunk.tokens if known and token.type in types]
            self._report_tokens(tokens)
        return dataclasses.replace(
            position,
            distance=None if at.distance else position.distance,
            spacing=None if at.spacing else position.spacing,
        )

    def _leads_to_object(self) -> bool:
        """Whether nothing but places and commas stands before an object, as in "in front of us, at 30 m, a bus"."""
        names = ("COMMA", "EGO", "position")
        following = itertools.dropwhile(lambda one: one.name in names, self.chunks[self.index :])
        named = next(following, END)
        return self._following().name in ("COMMA", "EGO") and (named.is_object or named.is_unknown)

    def _introduces(self, *, strongly: bool) -> bool:
        """Whether an object follows a position at once, or, where nothing is open yet, after a comma."""
        if strongly and not self.open and self._leads_to_object():
            return True
        passed = ("EGO", "COMMA", "turn") if strongly else ("EGO", "turn")
        after = self.chunks[self.index : self.index + 4]
        if after and after[0].name == "phrase" and after[0].head in ROAD_OF and "THE" in after[0].types:
            after = after[1:]  # "on the left of the road a car"
        following = next((c for c in after[:3] if c.name not in passed), END)
        return following.is_object or following.is_unknown
