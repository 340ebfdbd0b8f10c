"""What positions in a sentence say of two objects: one is placed from the other."""

from __future__ import annotations

import dataclasses
import itertools

from lark import Token

from lidardraft.drafting.solver.sentence_kinds import SENTENCE_KINDS
from lidardraft.drafting.text.chunk_reader import ChunkReader
from lidardraft.drafting.text.mention import Mention, add_qualities, depends
from lidardraft.drafting.text.number_words import count_of, is_plural
from lidardraft.drafting.text.positions import DISTANCES, LANE_WORDS, SET_BACK, Position, read_position
from lidardraft.drafting.text.references import known_mention, mention_of
from lidardraft.drafting.text.sentence_chunks import KIND_OF, ROAD_OF, Chunk

_PARTS_OF_ROAD = {"OWN_LANE", "LEFT_LANE", "RIGHT_LANE", "SIDEWALK"}
_FROM_THE_EGO = {  # where something is that the ego is behind, in front of, ...
    "behind": ("front", ""),
    "in-front-of": ("behind", ""),
    "beside": ("beside", ""),
    "left-of": ("", "right"),
    "right-of": ("", "left"),
}


class RelationReader(ChunkReader):
    """Reads one relation at a time."""

    def _references(self, chunk: Chunk, named: Chunk, *, linked: bool) -> list[Mention]:
        """What a position is relative to, one mention or two; none where it is unknown."""
        chunks = [named]
        place = self._following() if self._following().name == "position" else None
        link, after = self._following(place is not None), self._following(1 + (place is not None))
        between, both = chunk.tokens[-1].type == "BETWEEN" and link.name == "AND", after.is_object or after.is_unknown
        # "between a bus and a van", "between the trees and the houses"
        if between and both and (count_of(named.tokens) == 1 or {"THE"} <= named.types & after.types):
            chunks.append(after)
            self.index += 2 + (place is not None)
        elif between and (
            after.head in ROAD_OF or after.name == "EGO" or (after.types and after.types <= _PARTS_OF_ROAD)
        ):  # "between the trees and the road"
            drives = named.head in KIND_OF and SENTENCE_KINDS[KIND_OF[named.head]].drives
            found, word = ("BESIDE", "beside") if drives else ("FRONT", "in front of")
            found, word = ("BEHIND", "behind") if after.name == "EGO" else (found, word)
            chunk.tokens[-1] = Token.new_borrow_pos(found, word, chunk.tokens[-1])
            self.index += 2 + (place is not None)
        else:
            place = None
        if any(one.is_unknown for one in chunks):
            for one in chunks:
                self._report(one)
            return []
        subjects = [] if linked else self.open[-1:]  # what begins a clause may be placed from the end of the last one
        references = [self._reference(one, subjects) for one in chunks]
        for subject in self._open_known() if "EACH" in named.types else []:
            subject.host = references[0]
        if place is None and linked and self._names_place():
            place = self._following()  # "in front of a van on the right, a child"
            self.index += 1
            if references[0].placed:  # one of them is there, and so is the subject
                chunk.tokens[:0] = place.tokens
        if place is not None and not references[0].placed:  # "between the bus ahead and the car behind"
            references[0].at, references[0].placed = read_position(place.tokens), True
            references[0].spans.append(place.span)
        if linked:
            self._read_relative_clause(references[0])
        return references

    def _names_place(self) -> bool:
        """Whether what follows a reference that begins a clause is the place of it, and the subject is to come."""
        after = self._following(2 if self._following(1).name == "COMMA" else 1)
        return self._following().name == "position" and after.is_object

    def _read_relative_clause(self, reference: Mention) -> None:
        """What a clause with "which" says of a reference, as in "behind the bus, which is parked, a girl"."""
        if self._following().name != "COMMA":
            return
        if not {"which", "who", "that"} & set(self._between(self._following(), self._following(1))):
            return
        clause = list(
            itertools.takewhile(lambda one: one.name in ("phrase", "position"), self.chunks[self.index + 1 :])
        )
        if any(one.is_object for one in clause):
            return
        for one in clause:
            if one.name == "position":
                reference.at, reference.placed = reference.at.narrowed(read_position(one.tokens)), True
            else:
                add_qualities(reference, one.tokens)
            reference.spans.append(one.span)
        self.index += 1 + len(clause)

    def _reference(self, chunk: Chunk, subjects: list[Mention]) -> Mention:
        """The mention that a phrase means: one that is known and none of the subjects, or a new one."""
        named = chunk
        if len(chunk.tokens) == 1 and not is_plural(chunk.tokens[0]):  # "in front of wall"
            named = Chunk(chunk.name, [Token("THE", "the"), *chunk.tokens])
        known = known_mention(named, self.notes.mentions, subjects)
        self._report_strange(chunk)
        if known is None:
            known = mention_of(chunk)
            known.count = "some" if "EACH" in chunk.types and known.count == 1 else known.count
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
        if at.distance and last and words[-1].type not in DISTANCES:  # "30 m ahead next to a wall"
            from_ego, at = at, dataclasses.replace(at, distance=None)
        if before == "" and self.open and not self._open_known():
            self._report(chunk)  # what an unknown object is at may have a place of its own
            self.open = [one for one in references if not one.placed and one.relation is None]
            for mention in self.open:
                mention.described = True
        elif not references or relation is None or any(reference.kind is None for reference in references):
            self._report(chunk)
        elif chunk.tokens[-1].type == "FOLLOWED" and self._previous_names_ego(references):  # "we are followed by a van"
            for mention in references:
                mention.at, mention.placed = at.narrowed(Position(places=(("behind", ""),))), True
                mention.spans.append(chunk.span)
            self.open = references
        elif chunk.tokens[-1].type == "FOLLOWED" and self._open_known():
            subjects, self.open = self._open_known()[-1:], references
            self._relate(relation, subjects, at)
        elif before != "" and self._subject_follows(before, references):
            self.relation = (relation, references, at)
        elif self._subjects(references):
            if before == "":
                self._end_long_list()
            if chunk.tokens[-1].type == "OVERTAKING" and all(one.placed or one.references for one in references):
                relation = self._overtaking_side(relation)
            if any(mention.relation is not None for mention in self._subjects(references)):
                self._relate_back(chunk, relation, references)
                return
            if chunk.tokens[-1].type == "OVERTAKING":
                at = dataclasses.replace(at, heading="with")
            for mention in self._subjects(references):
                mention.spans.append(chunk.span)
            subject = self._subjects(references)[0]
            if from_ego.distance and self._turn_round(subject, relation, references):
                subject.at, subject.placed = subject.at.narrowed(from_ego), True
                self.open = [subject]
                return
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

    def _overtaking_side(self, relation: str) -> str:
        """The side of "passes it on the right", where the place of what is passed is known already."""
        side = self._following()
        if [token.type for token in side.tokens] not in (["LEFT"], ["RIGHT"]):
            return relation
        self.index += 1
        return "left-of" if side.head == "LEFT" else "right-of"

    def _end_long_list(self) -> None:
        """What follows "thirty cars, two vans and a man" is said of the man alone: there is no room for more."""
        *others, last = self._open_known()
        many = [one for one in others if one.count == "many" or (isinstance(one.count, int) and one.count > 4)]
        if last.count == 1 and many:
            self.open = [last]

    def _previous_names_ego(self, references: list[Mention]) -> bool:
        before = self.chunks[: self.index - 1]
        return len(before) > 1 and before[-2].name == "EGO" and not any(one.placed for one in references)

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
            if before.distance and self._turn_round(mention, relation, references):
                continue
            if before.distance:  # from the ego; what a relation has is measured from the reference
                self._hand_over(before, mention, references)
                before = dataclasses.replace(before, distance=None)
            mention.at = before.narrowed(at)
            mention.placed, mention.weak = True, False
        new = [reference for reference in references if not reference.placed and not reference.references]
        self.open = new if new and new[-1] is references[-1] else subjects

    def _turn_round(self, mention: Mention, relation: str, references: list[Mention]) -> bool:
        """What stands at a distance and behind what is placed nowhere: that one is in front of it."""
        turned = {"behind": "in-front-of", "in-front-of": "behind"}.get(relation)
        drive = all(SENTENCE_KINDS[str(one.kind)].drives for one in (mention, *references))
        if turned is None or not drive or len(references) > 1 or references[0].placed or references[0].references:
            return False
        mention.relation, mention.references = None, []
        references[0].relation, references[0].references, references[0].placed = turned, [mention], True
        return True

    def _report_set_back(self, mention: Mention) -> None:
        chunks = [chunk for chunk in self.chunks[: self.index] if chunk.span in mention.spans]
        self._report_tokens(token for chunk in chunks for token in chunk.tokens if token.type in SET_BACK)

    def _hand_over(self, position: Position, mention: Mention, references: list[Mention]) -> None:
        """A distance from the ego is that of the first reference, if nothing places it yet; else it is reported."""
        if not references[0].placed and not references[0].references:
            references[0].at = dataclasses.replace(Position(position.places), distance=position.distance)
        else:
            chunks = [chunk for chunk in self.chunks[: self.index] if chunk.span in mention.spans]
            self._report_tokens(token for chunk in chunks for token in chunk.tokens if token.type in DISTANCES)
