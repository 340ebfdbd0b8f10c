"""A place in the run of chunks of a sentence, what is open there, and the notes on all before."""

from __future__ import annotations

import itertools
from collections.abc import Iterable

from lark import Token

from lidardraft.drafting.solver.sentence_kinds import SENTENCE_KINDS
from lidardraft.drafting.text.mention import SIZES, Mention
from lidardraft.drafting.text.number_words import COUNT_TYPES, exact_count, unclear_counts
from lidardraft.drafting.text.positions import Position
from lidardraft.drafting.text.sentence_chunks import KIND_OF, LINKS, LISTED, ROAD_OF, SETTINGS, STATES, Chunk
from lidardraft.drafting.text.sentence_notes import SentenceNotes

END = Chunk("", [])
_VERBS = ("is", "are", "was", "were")
_SINGULAR = (
    "is",
    "was",
    "drives",
    "moves",
    "travels",
    "goes",
    "overtakes",
    "rides",
    "walks",
    "stands",
    "waits",
    "stops",
    "sits",
    "plays",
)


class ChunkReader:
    """What readers of phrases and of positions share."""

    def __init__(self, text: str, chunks: list[Chunk]) -> None:
        self.chunks, self.index = chunks, 0
        self.notes = SentenceNotes(text)
        self.open: list[Mention] = []  # what the next position or state belongs to
        self.sentence_starts = [0]  # how many mentions there were where each sentence began
        self.latest: list[Mention] = []  # what "it" means at the beginning of a clause
        self.earlier: list[Mention] = []  # of the clause before: "a bus stop on the left. A man waits there."
        self.listed: list[Mention] = []  # what an unknown one is listed with
        self.host: list[Mention] = []  # the house of "a house with a garden"
        self.part: Token | None = None  # "one" of "one of the three cars", until its verb
        self.subject_before_with: list[Mention] = []  # "a man with a hat crosses": the man, once the hat is read
        self.prefix: Position | None = None  # introduces the objects that follow
        self.prefix_weak = False
        self.prefix_index = -9  # where it was read
        self.relation: tuple[str, list[Mention], Position] | None = None  # of the object that follows
        self.turning: str | None = None  # how the object that follows turns
        self.related: Mention | None = None  # the last of those that a relation before them placed
        self.manner: list[Token] = []  # states of all objects that follow
        self.denial = ""  # the word that denies a list of objects
        self.excepting = False
        self.excepted: list[Mention] = []  # the trees of "trees except on the left"
        self.each: Mention | None = None  # the houses of "each house has a tree"
        self.has_ego = False
        self.restart = -1  # the link that ended what is unknown

    def _open_known(self) -> list[Mention]:
        return [mention for mention in self.open if mention.kind is not None]

    def _report(self, chunk: Chunk) -> None:
        self.notes.unclear.append(chunk.span)

    def _report_tokens(self, tokens: Iterable[Token]) -> None:
        self.notes.unclear += [(token.start_pos or 0, token.end_pos or 0) for token in tokens]

    def _following(self, further: int = 0) -> Chunk:
        index = self.index + further
        return self.chunks[index] if index < len(self.chunks) else END

    def _previous(self) -> Chunk:
        """The chunk before the one that is being read."""
        return self.chunks[self.index - 2] if self.index >= 2 else END

    def _before(self, back: int = 1) -> str | None:
        """The name of the link before the chunk that is being read; None at the start, "" after anything but a link."""
        index = self.index - 1 - back
        if index < 0:
            return None
        if index == self.restart:
            return "STOP"
        return self.chunks[index].name if self.chunks[index].name in LINKS else ""

    def _end_list(self, chunk: Chunk) -> None:
        """Leave open those of a list that the place after it is of.

        A sidewalk is that of the last ones that can be there. A verb in the singular is that of the last one alone, as
        in "trees, a bus is 20 m ahead"; a place before all of them is then not its own.
        """
        if not self._previous().is_object or self._before(2) not in LISTED:
            return
        if "DISTANCE" in chunk.types and self._before(2) == "COMMA":  # "three cars, a bus 20 m ahead"
            self.open = self.open[-1:]
        if "SIDEWALK" in chunk.types and _fits_sidewalk(self.open[-1]):  # "a bus, people on the sidewalk"
            self.open = list(itertools.takewhile(_fits_sidewalk, reversed(self.open)))[::-1]
        if any(verb in _SINGULAR for verb in [*self._between(self._previous(), chunk), *chunk.tokens]):
            self.open = self.open[-1:]
            first = self.index - self.prefix_index <= 4  # after the place
            for mention in self.open if self.prefix is not None and not first else []:
                mention.at, mention.placed, self.prefix = Position(), False, None

    def _queue_up(self, spacing: float | None) -> bool:
        """Place each of several single objects behind the one before it; the first one alone stays open."""
        if len(self.open) < 2 or any(one.count != 1 or one.relation is not None for one in self._open_known()):
            return False
        for before, mention in itertools.pairwise(self._open_known()):
            mention.relation, mention.references, mention.placed = "behind", [before], True
            mention.at = Position(distance=(spacing, spacing) if spacing else None)
        self.open = self.open[:1]
        return True

    def _open_all(self, chunk: Chunk) -> None:
        """What "both" or "all" do is said of the whole whose parts were named last, what "both" do of the last two."""
        if not self.open:
            return
        if self.open[0].kind is None and {"are", "were"} & set(self._between(self._previous(), chunk)):
            self.open = self.listed or self.open  # "a car and a caravan are"
        said = {*self._between(self._previous(), chunk), str(chunk.tokens[0])}
        whole, last = self.open[-1].same_as, self.notes.mentions[-2:]
        if whole is not None and chunk.head == "SPACING" and chunk.tokens[-1].startswith("each "):
            self.open = [whole, *(one for one in self.notes.mentions if one.same_as is whole)]
        elif whole is not None and {"both", "all"} & said:
            self.open = [whole]
        elif "both" in said and [one.count for one in last] == [1, 1]:
            self.open = last

    def _between(self, one: Chunk, other: Chunk) -> list[str]:
        """The words between two chunks, which say nothing alone."""
        return self.notes.text[one.span[1] : other.tokens[0].start_pos if other.tokens else None].split()

    def _counts_after_each(self, chunk: Chunk) -> bool:
        """Whether it is as "every ten trees", which means one of ten, and not as "each of ten trees"."""
        counted = "EACH" in chunk.types and exact_count(chunk.tokens) not in (None, 1)
        return counted and "of" not in self.notes.text[slice(*chunk.span)].split()

    def _follows_verb(self, before: Chunk, chunk: Chunk) -> bool:
        """Whether a verb without a meaning of its own stands between two chunks."""
        return any(word in _VERBS for word in self._between(before, chunk))

    def _latest_known(self) -> bool:
        return bool(self.latest) and all(mention.kind is not None for mention in self.latest)

    def _report_strange(self, chunk: Chunk) -> None:
        """The words of a phrase that say nothing of its noun."""
        head, strange = chunk.head, {"UNKNOWN", "ONES"}
        if head in KIND_OF or head == "UNKNOWN":
            strange |= set(SETTINGS)
        if head not in (*KIND_OF, *STATES, *SIZES):
            strange |= set(SIZES) - ({"WIDE", "NARROW"} if head == "ROAD" else set())
        idle = {id(token) for token in self._idle_counts(chunk)}
        self._report_tokens(token for token in chunk.tokens if token.type in strange or id(token) in idle)

    def _idle_counts(self, chunk: Chunk) -> list[object]:
        """The words for a number in a phrase that say nothing of its noun."""
        head, exact = chunk.head, exact_count(chunk.tokens)
        if head in KIND_OF:
            return list(unclear_counts(chunk.tokens))
        if head == "TRAFFIC":
            clear = not exact and not unclear_counts(chunk.tokens) and "COUNT_RANGE" not in chunk.types
        elif head == "LANE":
            clear = exact is not None and (self.notes.lanes in (0, exact) or self.notes.each_way)
        else:
            clear = exact == 1 and head in ROAD_OF
        return [] if clear else [token for token in chunk.tokens if token.type in COUNT_TYPES]


def _fits_sidewalk(mention: Mention) -> bool:
    return mention.kind is not None and "sidewalk" in SENTENCE_KINDS[mention.kind].surfaces
