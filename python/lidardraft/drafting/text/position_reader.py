"""What positions in a sentence belong to: the objects before them, those after them, or another object."""

from __future__ import annotations

import dataclasses
import itertools

from lark import Token

from lidardraft.drafting.solver.sentence_kinds import SENTENCE_KINDS
from lidardraft.drafting.text.chunk_reader import END
from lidardraft.drafting.text.mention import Mention
from lidardraft.drafting.text.number_words import count_of, count_times, metres
from lidardraft.drafting.text.place_reader import PlaceReader
from lidardraft.drafting.text.positions import Position, read_position
from lidardraft.drafting.text.references import meant_by, refers, relation_of
from lidardraft.drafting.text.sentence_chunks import JUNCTIONS, KIND_OF, LINKS, LISTED, ROAD_OF, Chunk

_EGO_LANES = {"LEFT_LANE": "left", "MIDDLE_LANE": "middle", "RIGHT_LANE": "right"}
_OF_NOTHING = ("RELATED", "BETWEEN", "LEFT_OF", "RIGHT_OF", "FOLLOWED")  # without an object after them


class PositionReader(PlaceReader):
    """Reads one position at a time."""

    def _position(self, chunk: Chunk) -> None:
        """Give a position to the objects before it, or keep it for those after it."""
        chunk = self._without_size(self._with_known_side(self._without_there(self._without_abreast(chunk))))
        if not chunk.tokens:
            return
        if self._is_lane_of_ego(chunk):
            self.notes.ego_lane = _EGO_LANES[chunk.head]
            return
        self._open_all(chunk)
        self._report_second_lengths(chunk)
        following, before = self._following(), self._link_before(chunk)
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
        elif [token.type for token in chunk.tokens] in (["SPACING", "BETWEEN"], ["DISTANCE", "BETWEEN"]) and _is_row(
            following
        ):
            self._space_out(chunk, following)
        elif chunk.head == "BETWEEN" and following.head in ROAD_OF and self._joins(self._following(1)):
            named = self._following(2)  # "a hedge between the road and two houses"
            self.index += 3
            chunk = Chunk(
                "position", [*chunk.tokens[:-1], Token.new_borrow_pos("FRONT", "in front of", chunk.tokens[-1])]
            )
            self._refer(chunk, "in-front-of", self._references(chunk, named, linked=linked), before)
        elif chunk.head == "BETWEEN" and self._between_ego(following):
            named = self._following(2)  # "between us and the bus"
            self.index += 3
            chunk = Chunk("position", [*chunk.tokens[:-1], Token.new_borrow_pos("BEHIND", "behind", chunk.tokens[-1])])
            self._refer(chunk, "behind", self._references(chunk, named, linked=linked), before)
        elif (following.is_object or following.is_unknown) and (
            refers(chunk, following, linked=linked) or (relation is not None and self._leads_to_subject(chunk))
        ):
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

    def _between_ego(self, following: Chunk) -> bool:
        """Whether "us and" comes next, and a vehicle."""
        named = self._following(2)
        drives = named.head in KIND_OF and SENTENCE_KINDS[KIND_OF[named.head]].is_vehicle
        return following.name == "EGO" and self._following(1).name == "AND" and drives

    def _leads_to_subject(self, chunk: Chunk) -> bool:
        """Whether a second object follows at once, as in "behind a hedge on the right there are two houses"."""
        after = self._following(2 if self._following(1).name == "position" else 1)
        return chunk.head in ("BEHIND", "NEAR") and after.is_object

    def _space_out(self, chunk: Chunk, row: Chunk) -> None:
        """A gap between objects is their spacing, as in "a gap of 30 m between the buses"."""
        self.index += 1
        mention = self._reference(row, [])
        mention.at = mention.at.narrowed(Position(spacing=metres(chunk.tokens[0])[0]))
        mention.spans.append(chunk.span)
        self.open = [mention]

    def _link_before(self, chunk: Chunk) -> str | None:
        """The name of the link before a place; who looks, and a manner of what follows, are no part of it."""
        if self.manner and self.manner is self._previous().tokens:
            return "STOP"
        before = self._before()
        if before != "" or self._previous().name != "EGO":
            return before
        if self.index > 2 and self.chunks[self.index - 3].name == "position":  # "in front of us in the left lane"
            return self._before(3)
        looks = {"see", "have", "look"} & set(self._between(self._previous(), chunk))
        return self._before(2) if looks or self._following().name == "EGO" else ""

    def _is_lane_of_ego(self, chunk: Chunk) -> bool:
        """Whether the ego drives there, as in "we are in the left lane", and nothing else does."""
        verbs = {"MOVING", "DOING", "COMMA"}
        earlier = itertools.dropwhile(lambda one: one.types <= verbs, reversed(self.chunks[: self.index - 1]))
        subject, before = [*earlier, END, END][:2]
        if chunk.types != {chunk.head} or chunk.head not in _EGO_LANES or subject.name != "EGO":
            return False
        seen = {"see", "have", "has"} & set(self._between(subject, chunk))
        return before.name in ("", *LINKS) and not seen and not self._introduces(strongly=False)

    def _refer_to_pronoun(self, chunk: Chunk, relation: str, pronoun: str, before: str | None) -> None:
        listed = self._open_known()
        earlier = [m for m in self.notes.mentions if before != "" or not self.open or m is not self.open[-1]]
        sibling = self.open[-1].same_as if self.open and before == "" else None
        if sibling is not None and sibling.references:  # "a car to the left of it and one to its right"
            earlier = [m for m in earlier if m is not sibling]
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

    def _joins(self, link: Chunk) -> bool:
        """Whether a link is between what was named and another object."""
        return link.name == "AND" and self._following(2).is_object

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

    def _without_there(self, chunk: Chunk) -> Chunk:
        """The position without "there", which is where the last of the clause before is, known or not."""
        found = [token for token in chunk.tokens if token.type == "THERE"]
        at = self.earlier[-1].at if self.earlier else Position()
        for mention in self._open_known() if found and at != Position() else []:
            mention.at, mention.placed = mention.at.narrowed(Position(at.places, at.distance, lane=at.lane)), True
            mention.spans.append(chunk.span)
        return Chunk("position", [token for token in chunk.tokens if token.type != "THERE"])

    def _road_named(self) -> Chunk | None:
        """The road that "it" means in "a roundabout with houses around it"."""
        before = [chunk for chunk in self.chunks[: self.index] if chunk.name == "phrase" and chunk.head in ROAD_OF]
        return before[-1] if before and "NO" not in before[-1].types else None

    def _place(self, chunk: Chunk, following: Chunk, before: str | None) -> None:
        """A position that is relative to the ego, or to a road."""
        by_road = following.name == "phrase" and following.head in ROAD_OF
        position = read_position(chunk.tokens, beside_road=by_road)
        self._note_road(chunk)
        if by_road and following.head in JUNCTIONS and chunk.tokens[-1].type in ("FRONT", "BEHIND", "NEAR", "BESIDE"):
            position = dataclasses.replace(read_position(chunk.tokens[:-1]), at_junction=True)
        if chunk.tokens[0].type == "CROSSWALK" and not self.open and self._walks_on(following):
            self.open = [Mention(None, at=position)]  # "a zebra crossing with two people"
            return
        if self._is_side_of_bend(chunk, before):
            self.notes.road = f"{chunk.head.lower()}-bend"
            return
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

    def _is_side_of_bend(self, chunk: Chunk, before: str | None) -> bool:
        """Whether a side between commas is that of a bend just before it, as in "a curved road (to the right)"."""
        adjoins = self.notes.road == "bend" and before == "COMMA" and self._following().name in ("", "COMMA", "STOP")
        named = self.chunks[self.index - 3 : self.index - 2] if adjoins else []
        return any(one.name == "bend" or one.head in ROAD_OF for one in named) and chunk.head in ("LEFT", "RIGHT")

    def _walks_on(self, link: Chunk) -> bool:
        """Whether a crossing is with people, who are on it."""
        named = self._following(1)
        return link.name == "WITH" and named.head in KIND_OF and SENTENCE_KINDS[KIND_OF[named.head]].walks

    def _leads_to_object(self) -> bool:
        """Whether nothing but places and commas stands before an object, as in "in front of us, at 30 m, a bus"."""
        states = {"PARKED", "ONCOMING", "CROSSING", "MOVING", "QUEUEING"}
        passed = ("COMMA", "EGO", "position")
        following = itertools.dropwhile(
            lambda one: one.name in passed or (one.name == "phrase" and one.types <= states), self.chunks[self.index :]
        )
        named = next(following, END)
        return self._following().name in ("COMMA", "EGO") and (named.is_object or named.is_unknown)

    def _introduces(self, *, strongly: bool) -> bool:
        """Whether an object follows a position at once, or, where nothing is open yet, after a comma."""
        if strongly and not self.open and self._leads_to_object():
            return True
        passed = ("EGO", "COMMA", "turn") if strongly else ("EGO", "turn")
        after = self.chunks[self.index :][self._words_of_road() :][:3]
        following = next((c for c in after if c.name not in passed), END)
        return following.is_object or following.is_unknown or self._counts_more()

    def _words_of_road(self) -> int:
        """How many chunks only say of what road a lane is, as in "in the left lane of the road a bus"."""
        if "of" not in self._between(self.chunks[self.index - 1], self._following()):
            return 0
        roads = ("LANE", *ROAD_OF)
        return len(list(itertools.takewhile(lambda one: one.head in roads, self.chunks[self.index :])))

    def _counts_more(self) -> bool:
        """Whether a number alone follows, of what was named before, as in "three cars behind us, ahead two"."""
        ego = self._following().name == "EGO"
        number, link = self._following(ego), self._following(1 + ego)
        alone = number.name == "phrase" and number.types == {"NUMBER"}
        return alone and link.name in ("", *LINKS) and any(one.kind is not None for one in self.notes.mentions)


def _is_row(chunk: Chunk) -> bool:
    """Whether it names several objects."""
    return chunk.is_object and count_of(chunk.tokens) != 1
