"""Objects that a sentence opens: new ones, and those without a noun that are more of the same or part of others."""

from __future__ import annotations

import dataclasses

from lidardraft.drafting.solver.sentence_kinds import SENTENCE_KINDS
from lidardraft.drafting.text.chunk_reader import END
from lidardraft.drafting.text.mention import SCALES, Mention, add_qualities
from lidardraft.drafting.text.number_words import COUNT_TYPES, Count, count_of, exact_count, number, unclear_counts
from lidardraft.drafting.text.position_reader import PositionReader
from lidardraft.drafting.text.positions import Position
from lidardraft.drafting.text.references import is_one_of_several, meant_by
from lidardraft.drafting.text.sentence_chunks import KIND_OF, LINKS, LISTED, STATES, Chunk

_SHARES = {"SOME": 0.5, "FEW": 0.25, "MANY": 0.75}  # of "them"; estimates of ours


class PartReader(PositionReader):
    """Reads one phrase that counts objects at a time."""

    def _put(self, chunk: Chunk, mention: Mention) -> None:
        """Open a mention: alone, or beside those that a list has opened and no position has closed."""
        listed = self._before(1) in LISTED
        last = self.notes.mentions[-1] if self.notes.mentions else None
        related = last if last is not None and self._before(1) == "AND" and last is self.related else None
        if related is not None and not (self.open and self.open[-1] is related):
            related = related if self.chunks[self.index - 3].span in related.spans else None
        self.subject_before_with = self._subject_before_with(chunk)
        self._list_traffic(mention)
        if not listed or any(
            other.placed or other.described or other.kind is None or (other.count == 0 and mention.count != 0)
            for other in self.open
        ):
            self.open = []
        if self.excepting:
            self.excepting = False
            if str(self._previous().tokens[0]).startswith("but no"):  # "cars but not trucks on the right"
                self.open = [one for one in self.excepted if one.count != 0 and not one.placed]
            wanted = bool(self.excepted) and self.excepted[-1].count != 0
            mention.count = 0 if wanted else mention.count
        elif mention.count == 0:
            self.denial = str(chunk.tokens[0])
        elif self.denial and listed and mention.count in (1, "some"):  # "no cars or ten trees" has trees
            mention.count = 0
        if self.manner:
            add_qualities(mention, self.manner)
        if self.turning is not None:
            mention.heading, self.turning = self.turning, None
        if self.prefix is not None:
            mention.at, mention.placed, mention.weak = self.prefix, True, self.prefix_weak and self.relation is None
        elif self._before(1) == "AND" and self._previous().tokens[0] == "then" and last is not None:
            mention.at, mention.placed, mention.weak = Position(last.at.places), last.placed, True  # further on
        mention.host = self.each if self.each is not None and self.each.kind != mention.kind else None
        if self._before(1) == "WITH" and self._previous().tokens[0] == "with" and len(self.host) == 1:
            mention.with_it = self.host[0]
        mention.described = chunk.head == "TRAFFIC"  # it is everywhere, whatever the objects listed after it do
        self.open.append(mention)
        self.latest = self.open
        self.notes.mentions.append(mention)
        if self.relation is not None:
            name, references, at = self.relation
            self.relation = None
            if self.prefix is not None and self.prefix.distance:  # which the relation may leave no room for
                mention.spans.append(self.chunks[self.prefix_index - 1].span)
            self._relate(name, references, at)
            self.related = mention
        elif related is not None:  # "behind it a truck and two cars"
            in_row = all(SENTENCE_KINDS[str(one.kind)].drives for one in (mention, related))
            in_row = in_row and related.relation in ("behind", "in-front-of")
            mention.relation, mention.references = related.relation, [related] if in_row else related.references
            mention.at, mention.placed, mention.weak = related.at, True, True
            self.open = [related, mention]
            self.related = mention

    def _ellipsis(self, chunk: Chunk) -> None:
        """A number without a noun means more of the same, as in "two cars ahead and one behind", or some of them."""
        last = self._last_subject()
        of_them = "OF_THEM" in chunk.types
        adjoin = all(one.name == "EGO" for one in self.chunks[self.prefix_index : self.index - 1])
        placed = self.prefix is not None and self.prefix_index > 0 and adjoin  # "behind us two cars, ahead three"
        begins = of_them or placed or self._before(1) in (*LISTED, "STOP", "WITH")
        several = meant_by("them", self._several())
        if several and (of_them or is_one_of_several(chunk)):
            last, of_them = several[0], True
        share = self._share_of_them(chunk)
        if share and several and isinstance(several[0].count, int):
            self._open_part(chunk, max(1, int(share * several[0].count)), several[0], of_them=True)
            return
        if chunk.tokens[0].type == "OF_THEM":
            self._share(chunk, several)
            return
        counts = [token for token in chunk.tokens if token.type in (*COUNT_TYPES, "ANOTHER", "FIRST")]
        said = counts[-1].split()[-1]  # "the rest", "the first two"
        count = "some" if said == "rest" else int(number(said)) if said in ("two", "three") else count_of(counts)
        of_them = of_them or (chunk.types == {"SOME"} and last is not None and last.of_them)  # "and some on the right"
        following = self._following(self._following().name == "COMMA")
        told = self._following().name == "position" or (following.name == "phrase" and following.types <= set(STATES))
        if self.excepting and self.excepted and told:  # "except one on the left", "except one, which is oncoming"
            self.excepting = False
            self._open_part(chunk, count, self.excepted[-1], of_them=True)
        elif self.excepting and self.excepted:
            self._leave_out(chunk, count)
        elif last is None or not begins or unclear_counts(counts):
            self._report(chunk)
        elif "EACH" in chunk.types and self._is_apposition(chunk):
            for mention in self.open:  # "on both sides, five each"
                mention.count, mention.at = count, dataclasses.replace(mention.at, shared=False)
                mention.spans.append(chunk.span)
        elif (
            self._following().name in ("position", "turn")
            or placed
            or (of_them and self._following().head == "ROAD")
            or self._is_part(chunk)
        ):
            self._open_part(chunk, count, last, of_them=of_them)
        elif isinstance(last.count, str) and (of_them or self._is_apposition(chunk)):
            last.count = count  # "bicycles at a fence: 15 of them", "people on the left, about ten"
            last.spans.append(chunk.span)
        else:
            self._report(chunk)

    def _last_subject(self) -> Mention | None:
        """The last mention, or what is placed from it: in "a pole by the house and one behind" another pole."""
        last = self.notes.mentions[-1] if self.notes.mentions else None
        before = self.notes.mentions[-2] if len(self.notes.mentions) > 1 else None
        named_for = before is not None and before.kind is not None and last in before.references
        return before if named_for and last is not None and last.count == 1 else last

    def _without_part(self, chunk: Chunk) -> Chunk:
        """The phrase of the whole in "one of the three cars", whose part is opened where its verb comes."""
        first, rest = chunk.tokens[0], Chunk("phrase", chunk.tokens[1:])
        if first.type not in ("NUMBER", "FIRST", "ANOTHER") or exact_count(rest.tokens) in (None, 0, 1):
            return chunk
        if "of" not in self._between(Chunk("phrase", [first]), rest):
            return chunk
        self.part = first
        return rest

    def _read_part(self, chunk: Chunk) -> Chunk:
        """The chunk, after the part that it says something of is opened; of a position only what is before its verb."""
        assert self.part is not None
        part = Chunk("phrase", [self.part])
        parts = [Chunk(chunk.name, chunk.tokens[:n]) for n in range(1, len(chunk.tokens))]
        rests = [Chunk(chunk.name, chunk.tokens[n:]) for n in range(1, len(chunk.tokens))]
        cut = next((n for n, pair in enumerate(zip(parts, rests, strict=True)) if self._follows_verb(*pair)), None)
        if chunk.name == "position" and cut is not None and not self._follows_verb(self._previous(), chunk):
            self.chunks[self.index - 1 : self.index] = [parts[cut], rests[cut]]
            return parts[cut]
        if chunk.name in LINKS:
            self._report(part)
            self.part = None
        elif {"has", "have"} & set(self._between(self._previous(), chunk)):  # all of it is told of what it has
            self.part = None
        elif self.open and self._follows_verb(self._previous(), chunk):
            self.part = None
            self._open_part(part, count_of(part.tokens) if part.head == "NUMBER" else 1, self.open[-1], of_them=True)
            if chunk.is_object and not chunk.types & {*COUNT_TYPES, "THE", "ANOTHER"}:  # "is a taxi"
                self.open[-1].kind = KIND_OF.get(chunk.head, self.open[-1].kind)
                self.open[-1].spans.append(chunk.span)
                return END
        return chunk

    def _share(self, chunk: Chunk, several: list[Mention]) -> None:
        """What is said of "all of them" is said of those, what is said of half of an open number of them of a part."""
        if several and chunk.tokens[0].startswith("half"):
            self._open_part(chunk, "some", several[0], of_them=False)
        elif self._listed_before():
            self.open = self.latest = self._listed_before()
        elif self.notes.mentions and chunk.tokens[0].startswith("all"):
            kind = self.notes.mentions[-1].kind
            self.open = self.latest = several or [one for one in self.notes.mentions if one.kind == kind]
        else:
            self._report(chunk)

    def _listed_before(self) -> list[Mention]:
        """The objects of different kinds that the last sentence named, where the last of them is a single one."""
        mentions = self.notes.mentions
        start = max((start for start in self.sentence_starts if start < len(mentions)), default=0)
        named = [one for one in mentions[start:] if one.count != 0]
        return named if len({one.kind for one in named}) > 1 and named[-1].count == 1 else []

    @staticmethod
    def _share_of_them(chunk: Chunk) -> float:
        """Which share "half of them", "some of them" or "a few of them" are, 0 for all and for numbers."""
        if "OF_THEM" not in chunk.types:
            return 0.0
        if chunk.tokens[0].startswith("half"):
            return 0.5
        return _SHARES.get(chunk.tokens[0].type, 0.0)

    def _open_part(self, chunk: Chunk, count: Count, last: Mention, *, of_them: bool) -> None:
        if "FIRST" in chunk.types and last.at.spacing:  # where the first is, the whole row begins
            self.open = self.latest = [last]
            if not self._following().types & {"FRONT", "BEHIND"}:
                last.at = last.at.narrowed(Position(places=(("front", ""),)))
            return
        self.open = []
        one = 1 if count == "some" and not chunk.types & {"SOME", "ANOTHER", "OF_THEM"} else count
        kept = last.heading == "parked" or (last.heading == "against" and "ANOTHER" in chunk.types)
        heading = last.heading if kept else None
        part = Mention(
            last.kind, one, heading=heading, spans=[chunk.span], same_as=last.same_as or last, of_them=of_them
        )
        if last.count == 0:
            part.same_as = None
        add_qualities(part, chunk.tokens)
        self._put(chunk, part)
        part.described = bool(chunk.types & set(STATES))

    def _list_traffic(self, mention: Mention) -> None:
        """What vehicles are listed after a colon are all of those before it, as in "a traffic jam: 20 cars, a bus"."""
        whole = self.notes.mentions[-1] if self.notes.mentions else None
        colon = self._before(1) == "COMMA" and self._previous().tokens[0] == ":"
        listed = whole if colon else whole.same_as if whole and self._before(1) in LISTED else None
        if listed is None or listed.kind != "vehicle" or not isinstance(listed.count, str):
            return
        if not (colon or listed.summed):
            return
        if SENTENCE_KINDS[str(mention.kind)].is_vehicle and mention.count != 0:
            listed.summed, mention.same_as, mention.of_them = True, listed, True

    def _subject_before_with(self, chunk: Chunk) -> list[Mention]:
        """What is with, or without, what a phrase names; it is what the verb after that belongs to."""
        without = chunk.tokens[0].type == "NO" and chunk.tokens[0].startswith("without")
        return self.open if without else self.host if chunk.is_unknown and self._before(1) == "WITH" else []

    def _several(self) -> list[Mention]:
        return [mention for mention in self.notes.mentions if mention.count not in (0, 1)]

    def _is_apposition(self, chunk: Chunk) -> bool:
        """Whether a number alone between commas tells how many those before it are."""
        ends = self._following().name in ("", "COMMA", "STOP", "AND")
        return self._before(1) == "COMMA" and ends and chunk.types <= {"NUMBER", "COUNT_RANGE", "DOZEN", "EACH"}

    def _leave_out(self, chunk: Chunk, count: Count) -> None:
        """All but so many of those before, as in "each one except the last"; there may be some for each of others."""
        self.excepting = False
        hosted = [one for one in self.notes.mentions if one.host is not None]
        excepted = self.excepted[-1]
        whole = next((one for one in hosted if excepted in (one, one.host)), excepted)
        if whole.host is not None and isinstance(count, int):
            whole.left_out, count = count, 0
            whole.spans.append(chunk.span)
            return
        if isinstance(count, int) and isinstance(whole.count, int) and whole.count > count:
            whole.count -= count
            whole.spans.append(chunk.span)
            if whole.heading is not None:  # "all parked except two": those are there, but do not park
                heading = "with" if whole.at.both_sides or whole.at.beside_road else None
                rest = dataclasses.replace(whole, count=count, heading=heading, spans=[chunk.span])
                self.notes.mentions.append(rest)
        else:
            self._report(chunk)

    def _is_part(self, chunk: Chunk) -> bool:
        """Whether a phrase without a noun tells what some of those before do, as "the other one is waiting"."""
        types = {*COUNT_TYPES, "THE", "ANOTHER", "FIRST", "OF_THEM", "QUIET", *STATES}
        if chunk.head == "ONES":  # "no vans but two small ones"
            return bool(self.notes.mentions) and {"NUMBER", "ONES"} <= chunk.types <= {"NUMBER", "ONES", *SCALES}
        several = bool(self._several()) or any(mention.same_as is not None for mention in self.notes.mentions)
        first = chunk.tokens[0]
        more = first.type == "ANOTHER" and first.startswith(("a ", "an", "one")) and bool(self.notes.mentions)
        counts = first.type in ("NUMBER", "ANOTHER", "FIRST") or self._share_of_them(chunk) > 0.0
        begins = more or (counts and several)
        return begins and chunk.types <= types and bool(chunk.types & set(STATES))

    def _whole(self, chunk: Chunk, mention: Mention) -> Mention | None:
        """What "one of them", "two of the cars" or "the last house" are part of."""
        if "OF_THEM" in chunk.types:
            return next(reversed(self._several()), None)
        first, rest = Chunk("phrase", chunk.tokens[:1]), Chunk("phrase", chunk.tokens[1:])
        of_the = [token.type for token in chunk.tokens[:2]] == ["NUMBER", "THE"] and "of" in self._between(first, rest)
        if not of_the and not is_one_of_several(chunk):
            return None
        return next((one for one in reversed(self._several()) if one.kind == mention.kind), None)
