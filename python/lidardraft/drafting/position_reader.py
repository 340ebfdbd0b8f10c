"""What positions in a sentence belong to: the objects before them, those after them, or another object."""

from __future__ import annotations

import dataclasses

from lidardraft.drafting.chunk_reader import END, ChunkReader
from lidardraft.drafting.number_words import SMALL_NUMBERS, count_of, number
from lidardraft.drafting.positions import LANE_WORDS, Position, read_position
from lidardraft.drafting.references import (
    count_times,
    depends,
    known_mention,
    meant_by,
    mention_of,
    refers,
    relation_of,
)
from lidardraft.drafting.sentence_chunks import JUNCTIONS, LINKS, LISTED, ROAD_OF, Chunk
from lidardraft.drafting.sentence_kinds import SENTENCE_KINDS
from lidardraft.drafting.sentence_notes import Mention, keep_away

_OF_NOTHING = ("RELATED", "BETWEEN", "LEFT_OF", "RIGHT_OF", "FOLLOWED")  # without an object after them
_DISTANCES = ("DISTANCE", "NEAR", "FAR")
_SET_BACK = ("FROM_ROAD", "FROM_SIDEWALK")  # which no relation goes with
_FROM_THE_EGO = {  # where something is that the ego is behind, in front of, ...
    "behind": ("front", ""),
    "in-front-of": ("behind", ""),
    "beside": ("beside", ""),
    "left-of": ("", "right"),
    "right-of": ("", "left"),
}


class PositionReader(ChunkReader):
    """Reads one position at a time."""

    def _position(self, chunk: Chunk) -> None:
        """Give a position to the objects before it, or keep it for those after it."""
        self._report_second_lengths(chunk)
        following, before = self._following(), self._before(1)
        if chunk.types & {"SIDEWALK"} and self._previous().head == "BUSY" and not self.open:
            self.notes.settings.discard("BUSY")  # it is the sidewalk that is crowded
            self._report(self._previous())
        linked = before != ""
        relation = relation_of(chunk.tokens[-1])
        if following.name == "PRONOUN" and relation is not None:
            self.index += 1
            earlier = [m for m in self.notes.mentions if linked or not self.open or m is not self.open[-1]]
            road = self._road_named()
            if not earlier and road is not None and chunk.tokens[-1].type in ("NEAR", "BESIDE"):
                self._place(chunk, road, before)
            else:
                meant = meant_by(following.tokens[0], earlier)
                for mention in self._open_known() if following.tokens[0].startswith("each") else []:
                    mention.count = count_times(mention.count, meant[0].count) if meant else mention.count
                self._refer(chunk, relation, meant, before)
        elif (following.is_object or following.is_unknown) and refers(chunk, following, linked=linked):
            self.index += 1
            self._refer(chunk, relation, self._references(chunk, following, linked=linked), before)
        else:
            self._report_tokens(token for token in chunk.tokens if token.type in _OF_NOTHING)
            tokens = [token for token in chunk.tokens if token.type not in _OF_NOTHING]
            if tokens:
                self._place(Chunk("position", tokens), following, before)

    def _road_named(self) -> Chunk | None:
        """The road that "it" means in "a roundabout with houses around it"."""
        before = [chunk for chunk in self.chunks[: self.index] if chunk.name == "phrase" and chunk.head in ROAD_OF]
        return before[-1] if before and "NO" not in before[-1].types else None

    def _references(self, chunk: Chunk, named: Chunk, *, linked: bool) -> list[Mention]:
        """What a position is relative to, one mention or two; none where it is unknown."""
        chunks = [named]
        place = self._following() if self._following().name == "position" else None
        link, after = self._following(place is not None), self._following(1 + (place is not None))
        between = chunk.tokens[-1].type == "BETWEEN" and link.name == "AND" and (after.is_object or after.is_unknown)
        # "between a bus and a van", "between the trees and the houses"
        if between and (count_of(named.tokens) == 1 or {"THE"} <= named.types & after.types):
            chunks.append(after)
            self.index += 2 + (place is not None)
        else:
            place = None
        if any(one.is_unknown for one in chunks):
            for one in chunks:
                self._report(one)
            return []
        subjects = [] if linked else self.open[-1:]  # what begins a clause may be placed from the end of the last one
        references = [self._reference(one, subjects) for one in chunks]
        if place is not None and not references[0].placed:  # "between the bus ahead and the car behind"
            references[0].at, references[0].placed = read_position(place.tokens), True
            references[0].spans.append(place.span)
        return references

    def _reference(self, chunk: Chunk, subjects: list[Mention]) -> Mention:
        """The mention that a phrase means: one that is known and none of the subjects, or a new one."""
        known = known_mention(chunk, self.notes.mentions, subjects)
        self._report_strange(chunk)
        if known is None:
            known = mention_of(chunk)
            self.notes.mentions.append(known)
        return known

    def _refer(self, chunk: Chunk, relation: str | None, references: list[Mention], before: str | None) -> None:
        """Note a relation for the objects before it, or for those after it where it begins a clause."""
        last = 1 if chunk.tokens[-1].type != "DISTANCE_FROM" else 0
        words = chunk.tokens[: len(chunk.tokens) - last]
        at = read_position(words)
        if at.lane and not chunk.types & set(LANE_WORDS):  # what overtakes is at the left of what it is placed from
            at = dataclasses.replace(at, lane=None)
        from_ego = Position()
        if at.distance and last and words[-1].type not in _DISTANCES:  # "30 m ahead next to a wall"
            from_ego, at = at, dataclasses.replace(at, distance=None)
        if before == "" and self.open and not self._open_known():
            self._report(chunk)  # what an unknown object is at may have a place of its own
            self.open = [one for one in references if not one.placed and one.relation is None]
            for mention in self.open:
                mention.described = True
        elif not references or relation is None or any(reference.kind is None for reference in references):
            self._report(chunk)
        elif chunk.tokens[-1].type == "FOLLOWED" and self._open_known():
            subjects, self.open = self._open_known()[-1:], references
            self._relate(relation, subjects, at)
        elif before != "" and self._subject_follows(before, references):
            self.relation = (relation, references, at)
        elif self._subjects(references):
            if any(mention.relation is not None for mention in self._subjects(references)):
                self._relate_back(chunk, relation, references)
                return
            if chunk.tokens[-1].type == "OVERTAKING":
                at = dataclasses.replace(at, heading="with")
            for mention in self._subjects(references):
                mention.spans.append(chunk.span)
            if from_ego.distance:
                self._hand_over(from_ego, self._subjects(references)[0], references)
            self._relate(relation, references, at)
        elif self.has_ego and relation in _FROM_THE_EGO and not any(one.placed for one in references):
            for mention in references:
                mention.at, mention.placed = at.narrowed(Position(places=(_FROM_THE_EGO[relation],))), True
                mention.spans.append(chunk.span)
            self.open = references
        else:
            self._report(chunk)

    def _relate_back(self, chunk: Chunk, relation: str, references: list[Mention]) -> None:
        """A second relation of an object is that of what is named with it, where it goes both ways and that is free."""
        free = [one for one in references if one.relation is None and not one.placed]
        if len(free) == len(references) == 1 and relation in ("near", "beside", "opposite"):
            free[0].relation, free[0].references, free[0].placed = relation, self._subjects(references), True
            free[0].spans.append(chunk.span)
        else:
            self._report(chunk)

    def _subject_follows(self, before: str | None, references: list[Mention]) -> bool:
        """Whether a relation that begins a clause is that of the object after it, as in "behind the bus, a cyclist"."""
        after = [self._following(further) for further in range(4)]
        if [one.name for one in after[:3]] == ["COMMA", "position", "COMMA"]:  # "opposite it, on the left, a bus"
            following = after[3]
        elif after[0].name == "COMMA" and (before in (None, "STOP") or not self._subjects(references)):
            following = after[1]
        else:
            following = after[0]
        return following.is_object or following.is_unknown

    def _subjects(self, references: list[Mention]) -> list[Mention]:
        """The open mentions that can be placed from the references: those that these are not placed from."""
        return [mention for mention in self._open_known() if not any(depends(one, mention) for one in references)]

    def _relate(self, relation: str, references: list[Mention], at: Position) -> None:
        """The open mentions are at this relation to the references, which the next position then places."""
        subjects = self._subjects(references)
        for mention in subjects:
            mention.relation, mention.references = relation, references
            self._report_set_back(mention)
            before = mention.at if mention.placed and not mention.weak else Position()
            if before.distance:  # from the ego; what a relation has is measured from the reference
                self._hand_over(before, mention, references)
                before = dataclasses.replace(before, distance=None)
            mention.at = before.narrowed(at)
            mention.placed, mention.weak = True, False
        new = [reference for reference in references if not reference.placed and not reference.references]
        self.open = new if new and new[-1] is references[-1] else subjects

    def _report_set_back(self, mention: Mention) -> None:
        chunks = [chunk for chunk in self.chunks[: self.index] if chunk.span in mention.spans]
        self._report_tokens(token for chunk in chunks for token in chunk.tokens if token.type in _SET_BACK)

    def _hand_over(self, position: Position, mention: Mention, references: list[Mention]) -> None:
        """A distance from the ego is that of the first reference, if nothing places it yet; else it is reported."""
        if not references[0].placed and not references[0].references:
            references[0].at = dataclasses.replace(Position(position.places), distance=position.distance)
        else:
            chunks = [chunk for chunk in self.chunks[: self.index] if chunk.span in mention.spans]
            self._report_tokens(token for chunk in chunks for token in chunk.tokens if token.type in _DISTANCES)

    def _place(self, chunk: Chunk, following: Chunk, before: str | None) -> None:
        """A position that is relative to the ego, or to a road."""
        by_road = following.name == "phrase" and following.head in ROAD_OF
        position = read_position(chunk.tokens, beside_road=by_road)
        self._note_lanes(chunk)
        if by_road and following.head in JUNCTIONS and chunk.tokens[-1].type in ("FRONT", "BEHIND", "NEAR", "BESIDE"):
            position = dataclasses.replace(read_position(chunk.tokens[:-1]), at_junction=True)
        listed = before in LISTED
        sidewalk_only = chunk.types <= {"SIDEWALK", "SIDES", "ALONG"} and position.sidewalk
        if self.excepting:
            self._except(chunk, position)
        elif any(mention.kind is None for mention in self.open) and not (listed and self._introduces(strongly=False)):
            self._report(chunk)
            for mention in self.open:
                mention.at, mention.spans = mention.at.narrowed(position), [*mention.spans, chunk.span]
        elif sidewalk_only and (listed or not self.open):
            self.notes.sidewalk = True
        elif before == "WITH" and position.spacing and self.host:
            self.open = self.host
            self._attach(position, chunk, listed)
        elif before in (None, *LINKS) and self._introduces(strongly=not self.open or self.relation is not None):
            between = [chunk.name for chunk in self.chunks[self.prefix_index : self.index - 1]]
            adjoins = between in (["COMMA"], ["EGO", "COMMA"])  # "in front of us, at 30 m, a bus"
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
        for mention in list(self.open):
            at = self._fitting(position, chunk, mention)
            mention.spans.append(chunk.span)
            if not mention.placed or mention.weak:
                mention.at = at if mention.weak else mention.at.narrowed(at)
            elif listed and not self._goes_on(at, mention):
                if at.only_places and mention.at.only_places:
                    mention.at = mention.at.or_at(at)
                else:
                    other = dataclasses.replace(mention, at=at, spans=[chunk.span])
                    if mention.count == 2 and at.distance and mention.at.distance:  # "two cars at 20 m and at 40 m"
                        mention.count = other.count = 1
                    self.notes.mentions.append(other)
                    self.open[self.open.index(mention)] = other
                    mention = other
            else:
                mention.at = mention.at.narrowed(self._without_second_length(at, chunk, mention.at))
            mention.placed, mention.weak = True, False

    def _goes_on(self, at: Position, mention: Mention) -> bool:
        """Whether a position after a comma describes the same place more closely, as in "on the left, 20 m away"."""
        return self._before(1) == "COMMA" and not (at.only_places and mention.at.only_places) and at.agrees(mention.at)

    def _fitting(self, position: Position, chunk: Chunk, mention: Mention) -> Position:
        """The position without what its kind cannot have, which is reported."""
        kind = SENTENCE_KINDS[str(mention.kind)]
        unfit = {"SIDEWALK"} if "sidewalk" not in kind.surfaces else set()
        unfit |= set(_SET_BACK) if mention.references else set()
        unfit |= {"CROSSWALK"} if not kind.walks else set()
        unfit |= set(LANE_WORDS) if "road" not in kind.surfaces else set()
        self._report_tokens(t for t in chunk.tokens if t.type in unfit)
        return position if "CROSSWALK" not in unfit & chunk.types else dataclasses.replace(position, heading=None)

    def _report_second_lengths(self, chunk: Chunk) -> None:
        for types in (_DISTANCES, ("SPACING",)):  # the last one counts
            tokens = [token for token in chunk.tokens if token.type in types][:-1]
            self._report_tokens(tokens)

    def _without_second_length(self, position: Position, chunk: Chunk, at: Position) -> Position:
        """A further position of what is `at` a place: its first distance and spacing stay, and others are reported."""
        for types, known in ((_DISTANCES, at.distance), (("SPACING",), at.spacing)):
            tokens = [token for token in chunk.tokens if known and token.type in types]
            self._report_tokens(tokens)
        return dataclasses.replace(
            position,
            distance=None if at.distance else position.distance,
            spacing=None if at.spacing else position.spacing,
        )

    def _introduces(self, *, strongly: bool) -> bool:
        """Whether an object follows a position at once, or, where nothing is open yet, after a comma."""
        passed = ("EGO", "COMMA", "turn") if strongly else ("EGO", "turn")
        after = self.chunks[self.index : self.index + 4]
        if after and after[0].name == "phrase" and after[0].head in ROAD_OF and "THE" in after[0].types:
            after = after[1:]  # "on the left of the road a car"
        if strongly and [chunk.name for chunk in after[:3]] == ["EGO", "COMMA", "position"]:
            after = self.chunks[self.index + 3 : self.index + 6]  # "in front of us, at 30 m, a bus"
        following = next((c for c in after[:3] if c.name not in passed), END)
        return following.is_object or following.is_unknown
