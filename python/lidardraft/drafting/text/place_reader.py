"""What places, distances and lengths say of the objects that they belong to."""

from __future__ import annotations

import dataclasses

from lark import Token

from lidardraft.drafting.solver.sentence_kinds import SENTENCE_KINDS
from lidardraft.drafting.text.mention import Mention, keep_away
from lidardraft.drafting.text.number_words import SMALL_NUMBERS, count_times, metres, number
from lidardraft.drafting.text.positions import DISTANCES, LANE_WORDS, SET_BACK, Position, read_position
from lidardraft.drafting.text.relation_reader import RelationReader
from lidardraft.drafting.text.sentence_chunks import LISTED, Chunk

_OTHER_SIDE = ("the other", "opposite side", "other side", "far side", "off side")


class PlaceReader(RelationReader):
    """Gives one position at a time to the objects that are open."""

    def _with_known_side(self, chunk: Chunk) -> Chunk:
        """The position with a side for "the other side" and for "the outer side"; without it where that is unknown."""
        tokens: list[Token] = []
        for token in chunk.tokens:
            if token.type in ("OUTER", "INNER"):
                side = self._side_of_bend(token)
                tokens += [Token.new_borrow_pos(side, str(token), token)] if side else []
                self._report_tokens([token] if not side else [])
            elif token.type == "LEFT" and token.endswith(_OTHER_SIDE):
                tokens.append(Token.new_borrow_pos(self._other_side(), str(token), token))
            else:
                tokens.append(token)
        return Chunk("position", tokens)

    def _side_of_bend(self, where: Token) -> str | None:
        """The outer or the inner side of the bend of the sentence, which is to the right where no side is said."""
        bends = [token.type for chunk in self.chunks if chunk.types & {"BEND", "TURN"} for token in chunk.tokens]
        said = {"left-bend": "LEFT", "right-bend": "RIGHT"}.get(str(self.notes.road))
        inner = said or next((type for type in bends if type in ("LEFT", "RIGHT")), None)
        if inner is None and (self.notes.road == "bend" or where.endswith(("bend", "curve", "turn"))):
            self.notes.road, inner = "right-bend", "RIGHT"
        return {"LEFT": "RIGHT", "RIGHT": "LEFT"}[inner] if inner and where.type == "OUTER" else inner

    def _other_side(self) -> str:
        """The side where the last objects are not."""
        sides = [
            side
            for mention in self.notes.mentions
            if self._before(1) != "" or not any(mention is one for one in self.open)
            for _, side in mention.at.places
            if side
        ]
        return "RIGHT" if sides[-1:] == ["left"] else "LEFT"

    def _without_size(self, chunk: Chunk) -> Chunk:
        """The position without a length that is a size of the object before it, as in "a tall building of 30 m".

        A fence of less than is usual for its height is so high, and otherwise so long.
        """
        named = self._previous()
        if not (named.is_object and chunk.tokens and chunk.tokens[0].type == "DISTANCE"):
            return chunk
        if self._between(named, chunk) != ["of"] or not self._open_known():
            return chunk
        sized, size = self._open_known()[-1], metres(chunk.tokens[0])[1]
        kind = SENTENCE_KINDS[str(sized.kind)]
        long = "LONG" in named.types or (kind.follows_road and kind.sizes is not None and size > kind.sizes.largest[2])
        sized.size[0 if long and not named.types & {"TALL", "LOW"} else 2] = size
        sized.scale = [1.0, 1.0, 1.0]
        sized.spans.append(Chunk("position", chunk.tokens[:1]).span)
        return Chunk("position", chunk.tokens[1:])

    def _note_road(self, chunk: Chunk) -> None:
        """What "in each of the three lanes" or "at the corner of the crossroads" says of the road."""
        for token in chunk.tokens:
            if token.type == "CORNER" and token.endswith(("crossroads", "intersection", "junction")):
                self.notes.road = self.notes.road or "crossroads"
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
        if position.spacing and any(t.endswith(("the other", "the next", "another")) for t in chunk.tokens):
            position = self._in_row(position)
        carried = position.distance is not None and self._is_carried()
        if carried:  # "a lorry with a sign at 65 m"
            self.open[0].relation, self.open[0].references, self.open[0].placed = "near", self.host, True
            self.open = self.host
        respective = self._respective(chunk)
        places = [read_position(one.tokens).places for one in respective]
        shared = Position(next((some for some in places[::-1] if some != Position().places), Position().places))
        if respective:
            self.index += 2 * len(respective) - 2
            for mention, one in zip(self.open, respective, strict=True):
                own = self._fitting(read_position(one.tokens), one, mention)
                mention.at = mention.at.narrowed(own if own.places != Position().places else own.narrowed(shared))
                mention.placed, mention.weak = True, False
                mention.spans.append(one.span)
            return
        corners = 4 if any(t.type == "CORNER" and t.startswith(("each", "every")) for t in chunk.tokens) else 1
        for mention in list(self.open):
            mention.count = count_times(mention.count, corners)
            at = self._like_sibling(mention, self._fitting(position, chunk, mention))
            if mention.of_them and mention.count == 1 and at.spacing:
                self._begin_row(mention, at, chunk)
                continue
            mention.spans.append(chunk.span)
            if mention.weak:
                mention.relation, mention.references = None, []
            if not mention.placed or mention.weak:
                mention.at = at if mention.weak else mention.at.narrowed(at)
            elif listed and not self._goes_on(at, mention) and not self._is_second_distance(at, mention):
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

    def _like_sibling(self, part: Mention, at: Position) -> Position:
        """The position of a part, on the side of the part before it: "the first is 20 m ahead, the second at 50 m"."""
        index = self.notes.mentions.index(part)
        before = self.notes.mentions[index - 1] if part.same_as is not None and index else None
        alike = before is not None and part.same_as in (before, before.same_as) and before.at.distance
        only_distance = at.distance and not any(any(place) for place in (*at.places, *part.at.places))
        return Position(before.at.places).narrowed(at) if alike and only_distance and before else at

    def _is_carried(self) -> bool:
        """Whether what was named last is with something that has no place yet, and cannot drive there itself."""
        known = [one for one in (*self.host, *self.open) if one.kind is not None and not one.placed and one.count != 0]
        adjoins = self._before(2) == "WITH" and self.chunks[self.index - 3].tokens[0] in ("with", "having")
        fits = (
            len(known) == 2
            and known[0] is not known[1]
            and len(self.host) == len(self.open) == 1
            and known[1].relation is None
        )
        return adjoins and fits and not SENTENCE_KINDS[str(known[1].kind)].drives

    def _in_row(self, position: Position) -> Position:
        """Where the first of some is that stand "each 10 m behind the other"; the others are placed from it."""
        if not self._queue_up(position.spacing):
            return position
        return dataclasses.replace(position, spacing=None)

    def _begin_row(self, first: Mention, at: Position, chunk: Chunk) -> None:
        """Where the first of several is, all of them begin, as in "the first at 10 m, 20 m between them"."""
        assert first.same_as is not None
        whole, front = first.same_as, Position(places=(("front", ""),))
        whole.at, whole.placed = whole.at.narrowed(first.at).narrowed(at), True
        whole.at = whole.at if any(fore for fore, _ in whole.at.places) else whole.at.narrowed(front)
        whole.spans += [*first.spans, chunk.span]
        self.notes.mentions.remove(first)
        self.open[self.open.index(first)] = whole

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

    def _respective(self, first: Chunk) -> list[Chunk]:
        """As many positions as objects, one for each, as in "a car and a truck at 20 m and 50 m"; none otherwise."""
        found = [first]
        while (
            self._following(2 * len(found) - 2).name in LISTED
            and self._following(2 * len(found) - 1).name == "position"
        ):
            found.append(self._following(2 * len(found) - 1))
        single = all(one.count == 1 for one in self.open) and all("DISTANCE" in one.types for one in found)
        words = [
            *self._between(self._previous(), first),
            *self._between(found[-1], self._following(2 * len(found) - 2)),
        ]
        fits = len(found) == len(self.open) > 1 and (single or "respectively" in words)
        return found if fits else []

    def _goes_on(self, at: Position, mention: Mention) -> bool:
        """Whether a position after a comma describes the same place more closely, as in "on the left, 20 m away"."""
        closer = mention.count == 1 or not (at.only_places and mention.at.only_places)
        return self._before(1) == "COMMA" and closer and at.agrees(mention.at)

    def _is_second_distance(self, at: Position, mention: Mention) -> bool:
        """Whether a comma alone parts a further distance from that of a single object, which it cannot be."""
        return self._before(1) == "COMMA" and mention.count == 1 and bool(at.distance and mention.at.distance)

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
