"""Mentions of objects, and notes on the road: the form of a sentence's clauses before they become a spec."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from lidardraft.drafting.text.positions import ANYWHERE, Place, Position
from lidardraft.drafting.text.tree import NO_SCALE, NO_SIZE, Count, Manner, NounPhrase, Sizes, Tokens
from lidardraft.drafting.text.tree import Place as PlaceSaid
from lidardraft.objects.kinds import SENTENCE_KINDS
from lidardraft.objects.sentence_kind import SentenceKind


@dataclass(frozen=True, slots=True)
class Mention:
    """Objects of a kind that a sentence names; None is an unknown kind, which takes the words after it.

    References to other mentions are their numbers. Count 0 denies the objects; a `weak` position is overridden by the
    next one. The other fields by example:

    described: "a man waits": objects listed after the verb do not share its position same_as, of_them: "three cars, two
    of them red": the two are the `same_as` the three, and counted in them host, left_out: "two trees for each house
    except one": the houses are the host, one of them is left out name: the A of "car A" summed: "a queue: three cars
    and a bus": the queue is everything listed after its colon only: "parked cars on the left only": none are elsewhere
    with_it: "a garden with two trees": the trees are near it unless placed otherwise
    """

    kind: str | None
    count: Count = 1
    at: Position = ANYWHERE
    not_at: tuple[Place, ...] = ()
    heading: str | None = None
    on_road: bool = False
    queue: bool = False
    row: bool = False
    ridden: bool = False
    placed: bool = False
    weak: bool = False
    size: Sizes = NO_SIZE
    scale: tuple[float, float, float] = NO_SCALE
    paint: str | None = None
    relation: str | None = None
    references: tuple[int, ...] = ()
    described: bool = False
    moves: bool = False
    same_as: int | None = None
    of_them: bool = False
    host: int | None = None
    abreast: bool = False
    motion: str | None = None
    speed: float | None = None
    noun: str = ""
    name: str = ""
    left_out: int = 0
    summed: bool = False
    with_it: int | None = None
    only: bool = False
    tokens: Tokens = frozenset()

    @property
    def record(self) -> SentenceKind:
        """The record of its kind."""
        assert self.kind is not None
        return SENTENCE_KINDS[self.kind]

    @property
    def denies_all(self) -> bool:
        """Whether it denies its kind at any place and in any state."""
        return self.count == 0 and self.kind is not None and not self.placed and self.heading is None

    @property
    def is_wanted(self) -> bool:
        """Whether it is of a known kind and not denied."""
        return self.kind is not None and self.count != 0


@dataclass(frozen=True, slots=True)
class RoadNotes:
    """The statements on the road and the setting ("busy", "residential", ...)."""

    kind: str | None = None
    lanes: int = 0
    usual_lanes: int = 0
    oncoming_lanes: int = 0
    each_way: bool = False
    one_way: bool = False
    ego_lane: str | None = None
    junction: tuple[float, float] | None = None
    sidewalk: bool | None = None
    ego_motion: str | None = None
    ego_speed: float | None = None
    settings: frozenset[str] = frozenset()


Mentions = tuple[Mention, ...]
COMPANIONS = ("animal", "box", "trailer")  # these are with their owners
JUNCTIONS = ("crossroads", "t-junction", "roundabout")
RUNNING = 2.8  # m/s, of words.txt
Ids = list[int]


@dataclass
class Discourse:
    """The mentions of a text so far, and the referents of later words: those of the previous clause, "it", "each"."""

    inner_side: str | None  # the direction of the bend in the text
    mentions: list[Mention] = field(default_factory=list)
    road: RoadNotes = RoadNotes()
    latest: Ids = field(default_factory=list)  # the subjects of the previous clause
    each: int | None = None  # the houses of "each house has a tree"
    sentence: int = 0  # the number of mentions at the start of this sentence
    earlier: int = 0  # and of the previous one
    count_before: int = 0  # and of the current noun phrase
    last_lead: PlaceSaid | None = None
    it: int | None = None  # the referent of "it" in this sentence
    summed: int | None = None
    unfit: set[int] = field(default_factory=set)  # tokens of places that do not fit some of their objects
    dropped: set[int] = field(default_factory=set)  # of places that do not fit an object, or that it does not need
    taken: set[int] = field(default_factory=set)  # of places in use

    def add(self, mention: Mention) -> int:
        """The number of a new mention."""
        self.mentions.append(mention)
        return len(self.mentions) - 1

    def change(self, number: int, **fields: object) -> None:
        """Replace some fields of a mention."""
        self.mentions[number] = replace(self.mentions[number], **fields)  # type: ignore[arg-type]

    def cover(self, number: int, tokens: Tokens) -> None:
        """Add words to those of a mention."""
        self.change(number, tokens=self.mentions[number].tokens | tokens)

    def several(self, kind: str = "") -> int | None:
        """The last mention of several objects."""
        for number in range(len(self.mentions) - 1, -1, -1):
            one = self.mentions[number]
            if one.is_wanted and one.count != 1 and kind in ("", one.kind):
                return number
        return None

    def building_before(self, number: int) -> int | None:
        """The building of this sentence that roadside objects are in front of by default."""
        thing = self.mentions[number]
        if thing.kind is None or thing.record.family == "buildings":
            return None
        if thing.record.on_road and (thing.heading != "parked" or thing.count == 1):
            return None
        before = [n for n in range(self.sentence, number) if self.mentions[n].is_wanted]
        buildings = [n for n in before if self.mentions[n].record.family == "buildings"]
        alike = (
            buildings == before and (self.mentions[buildings[0]].count == 1) is (thing.count == 1)
            if buildings
            else False
        )
        return buildings[0] if alike else None

    def depends(self, number: int, other: int) -> bool:
        """Whether a mention is another one, or depends on its place."""
        return depends(self.mentions, number, other)


def depends(mentions: list[Mention], number: int, other: int) -> bool:
    """Whether a mention is another one, or depends on its place."""
    reached = [number]
    for one in reached:  # grows
        reached += [reference for reference in mentions[one].references if reference not in reached]
    return other in reached


def count_times(count: Count, each: Count) -> Count:
    """The product of two counts; a word for either makes a word for the whole."""
    if isinstance(count, int) and isinstance(each, int):
        return count * each
    return each if count == 1 else count


def mention_of(phrase: NounPhrase) -> Mention:
    """The mention of a phrase with a noun."""
    bare = Mention(phrase.kind, phrase.count)
    manner = fitting_manner(phrase.manner, bare)
    return Mention(
        phrase.kind,
        phrase.count,
        heading=manner.heading,
        queue=manner.queue,
        row=manner.row,
        ridden=phrase.ridden,
        size=manner.size,
        scale=manner.scale,
        paint=manner.paint,
        noun=phrase.noun,
        name=phrase.name,
        abreast=manner.abreast,
        described=phrase.traffic,
        at=phrase.at or Position(),
        placed=phrase.at is not None,
        motion=manner.motion,
        speed=manner.speed,
        tokens=phrase.tokens,
    )


def fitting_manner(manner: Manner, mention: Mention) -> Manner:
    """A manner without a heading that its kind cannot have, or that is given already."""
    kind, heading = mention.record, str(manner.heading)
    fits = kind.drives or (kind.walks and heading != "parked" and not heading.startswith("turning"))
    fits = fits or (kind.follows_road and heading == "across")
    abreast = mention.count in (2, 3, 4, 5)
    if manner.abreast and not abreast:
        manner = replace(manner, abreast=False)
    if not kind.drives:
        manner = replace(manner, paint=None)
    elif manner.speed == RUNNING:
        manner = replace(manner, speed=None)  # "a tram runs"
    return manner if fits else replace(manner, heading=None)
