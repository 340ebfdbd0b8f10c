"""What belongs to what in a sentence: numbers to objects, positions to the objects they follow or introduce.

Chunks are read from left to right, clause by clause. What is unknown takes the words up to the next link with it, so
that it changes nothing of what is known.
"""

from __future__ import annotations

import dataclasses
import itertools

from lidardraft.drafting.solver.sentence_kinds import SENTENCE_KINDS
from lidardraft.drafting.text.mention import Mention, add_qualities, hosted_count
from lidardraft.drafting.text.number_words import COUNT_TYPES, exact_count
from lidardraft.drafting.text.part_reader import PartReader
from lidardraft.drafting.text.positions import Position
from lidardraft.drafting.text.references import known_mention, meant_by, mention_of
from lidardraft.drafting.text.sentence_chunks import JUNCTIONS, KIND_OF, LINKS, LISTED, ROAD_OF, SETTINGS, STATES, Chunk
from lidardraft.drafting.text.sentence_notes import SentenceNotes

_PASSED_ON_THE_WAY = ("MOVING", "ALONG", "A", "THE", "NUMBER", "LANE", "UNKNOWN", *SETTINGS)
_ASIDE = ("FRONT", "BEHIND", "BESIDE", "LEFT", "RIGHT", "SIDES", "EACH_SIDE", "DISTANCE")


class SentenceReader(PartReader):
    """Reads the chunks of a parsed sentence."""

    def read(self) -> SentenceNotes:
        """The notes on all chunks."""
        while self.index < len(self.chunks):
            chunk = self.chunks[self.index]
            self.index += 1
            if self.part is not None:
                chunk = self._read_part(chunk)
            if chunk.name == "phrase":
                self._phrase(chunk)
            elif chunk.name == "position":
                self._position(chunk)
            elif chunk.name == "turn":
                self._turn(chunk)
            elif chunk.name == "bend":
                side = "".join(f"{t.type.lower()}-" for t in chunk.tokens if t.type != "BEND")
                known = str(self.notes.road).endswith("bend") and not side
                self.notes.road = self.notes.road if known else f"{side}bend"
            else:
                self._link(chunk)
        self._report_tokens([self.part] if self.part is not None else [])
        return self.notes

    def _link(self, chunk: Chunk) -> None:
        if chunk.name in ("WITH", "STOP"):
            self.host = self.open if chunk.name == "WITH" and self._before() == "" else []
            self.earlier = self.latest if chunk.name == "STOP" else self.earlier
            self.sentence_starts += [len(self.notes.mentions)] * (chunk.name == "STOP")
            self.open, self.prefix, self.denial, self.each = [], None, "", None
            self.manner = self.manner if chunk.name == "WITH" else []
            at = self.host[0].at if len(self.host) == 1 and self.host[0].kind is None else Position()
            if any(at.places[0]) or at.heading == "across":  # "a petrol station on the right with two cars"
                at = at if at.heading == "across" else Position(at.places)
                self.prefix, self.prefix_weak, self.prefix_index = at, at.heading != "across", self.index
        elif chunk.name == "EACH_HAS":
            several = [mention for mention in self.notes.mentions if mention.count not in (0, 1)]
            self.each = meant_by("them", several)[0] if several else None
            self.open, self.prefix = [], None
            if self.each is None:
                self._report(chunk)
        elif chunk.name == "EGO":
            self.has_ego = True
        elif chunk.name == "PRONOUN" and self._previous().name == "PREPOSITION" and self._open_known():
            earlier = [mention for mention in self.notes.mentions if mention not in self.open]
            for mention in meant_by(str(chunk.tokens[0]), earlier) if self._road_named() is None else []:
                self._near(mention)  # "a bench and a man on it"
        elif chunk.name == "PRONOUN" and not self.open:
            self.open = self.latest
        elif chunk.name in LISTED and any(mention.kind is None for mention in self.open):
            self.earlier = self.open  # "a bus stop on the right, a man waits there"
            # what is unknown ends here, and so does the list that it is in; "on the left" still holds after "and"
            self.open, self.restart, self.denial = [], self.index - 1, ""
            self.prefix = None if chunk.name == "COMMA" else self.prefix
        elif chunk.name == "COMMA":
            named = any(one.is_object for one in self.chunks[self.prefix_index : self.index])
            self.prefix_weak, self.denial, self.each = self.prefix_weak or named, "", None
            if named and any(mention.kind is None for mention in self.host):
                self.prefix = None  # of what the unknown, or a crossing, is with
        elif chunk.name == "AND" and self.denial != "without":
            self.denial = ""
        elif chunk.name == "EXCEPT":
            self.excepting, self.excepted = True, self.open
        elif chunk.name == "NO_SIDEWALK":
            self.notes.sidewalk = False
        elif chunk.name == "EACH_WAY":
            self._each_way()

    def _each_way(self) -> None:
        """Of lanes, or of what drives in them; a number alone is one of lanes, as in "four lanes, two each way"."""
        driven = [m for m in self.open if m.kind is not None and SENTENCE_KINDS[m.kind].drives and m.heading is None]
        if self._previous().head == "LANE" or not driven:
            self.notes.each_way = True
            return
        for mention in driven:
            half = mention.count // 2 if isinstance(mention.count, int) and mention.count > 1 else 0
            other = dataclasses.replace(mention, heading="against", count=half or mention.count)
            mention.heading, mention.count = "with", mention.count - half if half else mention.count  # type: ignore
            self.notes.mentions.append(other)

    def _phrase(self, chunk: Chunk) -> None:
        chunk = self._without_part(chunk)
        head = chunk.head
        self.notes.one_way = self.notes.one_way or "ONE_WAY" in chunk.types
        if exact_count(chunk.tokens) == 0 and head in (*ROAD_OF, "LANE"):
            self._report(chunk)
            return
        if head == "TRAM" and self.notes.road == "parking-lot":  # which has no rails; its trolleys are of a shop
            self._unknown(chunk)
            return
        carried = self._before(1) == "WITH" and chunk.head == "UNKNOWN" and chunk.types <= {"UNKNOWN"}
        if self.notes.lanes and self._following().name == "EACH_WAY" and chunk.types == {"NUMBER"} and not self.open:
            self.notes.lanes = exact_count(chunk.tokens) or self.notes.lanes
            return
        if chunk.is_unknown or carried or (chunk.may_be_unknown and self._before(1) != ""):
            self._unknown(chunk)
            return
        if head in ROAD_OF or (head in SETTINGS and not self._previous().types & {"SIDEWALK"}):
            self.notes.settings |= chunk.types & set(SETTINGS)
        counted = {*COUNT_TYPES, "ANOTHER", "FIRST", "OF_THEM"} & chunk.types
        if (counted and chunk.types <= counted | {"A", "THE", "EACH"}) or self._is_part(chunk):
            self._ellipsis(chunk)
            return
        if chunk.types <= {"BUSY", "QUIET"} and self._previous().types & {"SIDEWALK"}:
            self._report(chunk)  # "the pavement is crowded"
            return
        self._report_strange(chunk)
        if head in KIND_OF or head == "TRAFFIC":
            self._object(chunk)
        elif head in ROAD_OF:
            self._road(chunk)
        elif head == "LANE":
            self._lanes(chunk)
        else:
            self._state(chunk)

    def _unknown(self, chunk: Chunk) -> None:
        """Open what is unknown; where no link parts it from an object, it only says something of that one."""
        self._report(chunk)
        before = self._before(1)
        self.subject_before_with = self._subject_before_with(chunk)
        if before == "WITH" and self.host and not any(mention.placed for mention in self.host):
            self.open = self.host
        elif before != "" or not self.open or any(mention.placed for mention in self.open):
            self.listed = [one for one in self._open_known() if not one.placed] if before == "AND" else []
            self.open = self.latest = [Mention(None, at=self.prefix or Position())]
            self.relation = None

    def _state(self, chunk: Chunk) -> None:
        """Words without a noun: how the objects before them stand or move, and how large they are."""
        self._end_list(chunk)
        if not self.open and chunk.tokens[0].type == "OF_THEM":
            self._share(chunk, meant_by("them", self._several()))
        if self.related is not None and self._previous().is_object and self._previous().span in self.related.spans:
            self.open = [self.related]  # "opposite the church two coaches are parked"
        if self.subject_before_with and self._before() == "":  # "a man with a hat crosses", not "with llamas crossing"
            if self._previous().is_unknown and chunk.tokens[0].endswith("ing"):
                self._report(chunk)
                return
            self.open = self.subject_before_with
        self._report_tokens(token for token in chunk.tokens if token.type == "EACH")
        self._open_all(chunk)
        if chunk.types == {"QUEUEING"} and chunk.tokens[0].startswith("one ") and self._queue_up(None):
            return
        for mention in self.open:
            if mention.kind is None or ("NO" in chunk.types and chunk.types & set(STATES)):
                self._report(chunk)
                if chunk.types & {"PARKED", "ONCOMING"} and mention.kind is not None:  # "none of them parked"
                    mention.heading = "with"
            else:
                add_qualities(mention, chunk.tokens)
                mention.spans.append(chunk.span)
                mention.described = True
        begins = self._before(1) in (None, "STOP") or (self._before(1) == "COMMA" and self.prefix is not None)
        if not self.open and begins and self._is_of_what_follows(chunk):
            self.manner = chunk.tokens
        elif not self.open:
            lone = ("PARKED", "CROSSING", "ONCOMING", "QUEUEING", "SIZE")
            self._report_tokens(t for t in chunk.tokens if t.type in lone)

    def _is_of_what_follows(self, chunk: Chunk) -> bool:
        """Whether a state is that of a list of objects after it, as in "parked on the left: a car, a van"."""
        rest = itertools.dropwhile(lambda one: one.name in ("position", "COMMA"), self.chunks[self.index :])
        listed = "COMMA" in (self._following().name, self._following(1).name)
        return (
            chunk.types <= {"PARKED", "ONCOMING", "CROSSING", "MOVING", "QUEUEING"}
            and listed
            and next(rest, chunk).is_object
        )

    def _lanes(self, chunk: Chunk) -> None:
        count = exact_count(chunk.tokens)
        if count is None and self.notes.road is None and not self.open:
            self.notes.road = "straight"  # "a country lane"
            self.notes.settings |= chunk.types & set(SETTINGS)
        if count is not None and self.notes.lanes and self.notes.each_way:
            self.notes.oncoming_lanes = count  # "two lanes northbound, one southbound"
        self.notes.lanes = self.notes.lanes or count or 0

    def _object(self, chunk: Chunk) -> None:
        mention = mention_of(chunk)
        if self._previous().head == "TRAFFIC" and self._between(self._previous(), chunk) == ["of"] and self.open:
            jam = self.notes.mentions.pop()  # "a traffic jam of 12 cars"
            mention.at, mention.placed, mention.heading = jam.at, jam.placed, mention.heading or jam.heading
            mention.spans, self.open = [*jam.spans, *mention.spans], []
        mention.same_as = self._whole(chunk, mention)
        mention.of_them = mention.same_as is not None
        kind = SENTENCE_KINDS[str(mention.kind)]
        before = self._previous()
        begins = self._before(1) in ("STOP", *LISTED) or bool(mention.name)
        known = known_mention(chunk, self.notes.mentions, []) if begins else None
        goes_on = self._following().head in ("FOLLOWED", "OVERTAKING")
        if (
            known is not None
            and not mention.name
            and self._before(1) != "STOP"
            and not goes_on
            and (known.placed or known.relation is not None)
        ):
            known = None
        hosts = [one.host for one in self.notes.mentions if one.host is not None and one.host.kind == mention.kind]
        if self.notes.text[chunk.span[1] :].lstrip().startswith(("in total", "in all", "altogether")):
            hosts = [one for one in self.notes.mentions if one.kind == mention.kind and one.same_as is None]
        counted = [one for one in self.notes.mentions if one.host is not None and one.kind == mention.kind]
        bare = self._following().name in ("", *LINKS) and exact_count(chunk.tokens) is not None
        if self._counts_after_each(chunk):
            self._report_tokens(token for token in chunk.tokens if token.type == "EACH")
        elif "EACH" in chunk.types:
            known = known_mention(chunk, self.notes.mentions, [])
            mention.count = mention.count if exact_count(chunk.tokens) else "some"
            self.each = known or mention
        elif hosts and isinstance(hosts[-1].count, str) and exact_count(chunk.tokens):  # "there are four lamps"
            known, hosts[-1].count = hosts[-1], mention.count
        elif counted and bare and hosted_count(counted[-1]) == mention.count:  # "each has a tree: four trees"
            known = counted[-1]
        if self._is_ego(chunk, mention):
            self.has_ego = True
        elif kind.is_ridden and self._is_ridden(chunk, before):
            self.open[-1].kind = mention.kind
            self.open[-1].spans.append(chunk.span)
            if exact_count(chunk.tokens) not in (None, 1, self.open[-1].count):
                self._report_tokens(t for t in chunk.tokens if t.type in COUNT_TYPES)
        elif before.name == "PREPOSITION" and self._before(2) == "" and self._open_known():
            self._near(self._reference(chunk, self.open[-1:]))
        elif known is not None:
            known.spans.append(chunk.span)
            self.open = self.latest = [known]
        else:
            self._put(chunk, mention)

    def _road(self, chunk: Chunk) -> None:
        kind = ROAD_OF[chunk.head]
        if kind != "straight" or self.notes.road is None:
            self.notes.road = kind
        if chunk.types & {"WIDE", "NARROW"}:
            self.notes.usual_lanes = 4 if "WIDE" in chunk.types else 2
        linked = self._before(2 if self._previous().name == "PREPOSITION" else 1) != ""
        at_junction = chunk.head in JUNCTIONS and "THE" in chunk.types and not linked
        from_junction = at_junction and self._previous().head == "DISTANCE"
        if from_junction:  # where a junction is, is not known yet
            self._report(self._previous())
        for mention in self.open if self.prefix is None or self._previous().name != "position" else []:
            if mention.kind is None:
                continue
            if from_junction:
                mention.at = dataclasses.replace(mention.at, distance=None)
            if at_junction:
                mention.at = dataclasses.replace(mention.at, at_junction=not SENTENCE_KINDS[mention.kind].at_junction)
                mention.placed = True
                if "approaching" in self._previous().tokens:
                    mention.heading = None
            elif chunk.tokens[0].type == "THE" and self._before(1) not in LISTED:
                mention.on_road = not mention.placed

    def _near(self, reference: Mention) -> None:
        """What a queue, or what is placed already, stands at is near to it."""
        queues = [one for one in self._open_known() if one.in_queue or one.relation is not None]
        if queues and not reference.placed and not reference.references:
            reference.relation, reference.references, reference.placed = "near", queues, True
        else:
            self._relate("near", [reference], Position())

    def _turn(self, chunk: Chunk) -> None:
        """Of a road, or of what drives."""
        self._end_list(chunk)
        side = "".join(t.type.lower() for t in chunk.tokens if t.type in ("LEFT", "RIGHT"))
        driven = [m for m in self._open_known() if SENTENCE_KINDS[str(m.kind)].drives]
        heading = f"turning-{side}" if side else "turning"
        if self._previous().head in ROAD_OF or (side and not driven and not self.open):
            self.notes.road = f"{side}-bend" if side else "bend"
        elif driven:
            for mention in driven:
                mention.heading, mention.placed = heading, True
                mention.spans.append(chunk.span)
        elif self._following().is_object:
            self.turning = heading
        else:
            self._report(chunk)

    def _is_ego(self, chunk: Chunk, mention: Mention) -> bool:
        """Whether the first object of a sentence is who looks: a vehicle that drives on a road, and nowhere else."""
        vehicle = SENTENCE_KINDS[str(mention.kind)].is_vehicle and chunk.head != "TRAFFIC"
        if self.notes.mentions or self.has_ego or not vehicle or mention.count != 1:
            return False
        after = [token.type for chunk in self.chunks[self.index :] for token in chunk.tokens]
        rest = [type for type in after if type not in _PASSED_ON_THE_WAY] + ["", ""]
        return after[:1] == ["MOVING"] and (rest[0] in ROAD_OF or rest[0] == "BEND") and rest[1] not in _ASIDE

    def _is_ridden(self, chunk: Chunk, before: Chunk) -> bool:
        """Whether a two-wheeler is that of a person just named, as in "a man riding a bike" or "on a bike"."""
        riding = any(t.type == "DOING" and t.startswith("rid") for t in (*before.tokens, *chunk.tokens))
        riding = riding or any(token == "on" for token in before.tokens)
        return riding and bool(self._open_known()) and SENTENCE_KINDS[str(self.open[-1].kind)].walks
