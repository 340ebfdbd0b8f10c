"""What a sentence was found to say so far: its mentions of objects, its road, its setting; and the spec of all that."""

from __future__ import annotations

import dataclasses
import re
from dataclasses import dataclass, field

from lidardraft.drafting.positions import Place, Position
from lidardraft.drafting.scene_spec import ObjectGroup, RoadSpec, SceneSpec
from lidardraft.drafting.sentence_kinds import SENTENCE_KINDS

Span = tuple[int, int]  # of characters of the sentence: from and to
_HYPHENED_TO, _HYPHENED = (
    re.compile(r"([^\W\d]+-)*$"),
    re.compile(r"(-[^\W\d]+)*"),
)  # the rest of a word such as "lay-by"
_SIDES = ("left", "right")
_BESIDE_EACH_OTHER = 1.0  # m between people in a queue; estimate of ours
_QUEUE_GAP = 2.5  # m between vehicles in a queue; estimate of ours


@dataclass(eq=False)
class Mention:
    """A group while its modifiers are being read; count 0 denies it, a `weak` position is overruled by the next one.

    The kind is None for what is unknown, which takes the words after it and makes nothing. What is `described` by a
    verb shares no position with what is listed after it; `same_as` is the mention whose noun "one" or "two" stand for,
    `of_them` says that it counts them already.
    """

    kind: str | None
    count: int | str | tuple[int, int] = 1
    at: Position = field(default_factory=Position)
    not_at: list[Place] = field(default_factory=list)
    heading: str | None = None
    on_road: bool = False
    in_queue: bool = False
    ridden: bool = False
    placed: bool = False
    weak: bool = False
    size: list[float | None] = field(default_factory=lambda: [None, None, None])
    scale: list[float] = field(default_factory=lambda: [1.0, 1.0, 1.0])
    relation: str | None = None
    references: list[Mention] = field(default_factory=list)
    described: bool = False
    same_as: Mention | None = None
    of_them: bool = False
    spans: list[Span] = field(default_factory=list)

    def group(self, references: tuple[int, ...] = (), words: str = "") -> ObjectGroup:
        """As a group of the spec; vehicles along the sides of a road are parked."""
        assert self.kind is not None
        at, kind = self.at, SENTENCE_KINDS[self.kind]
        heading = "across" if at.heading == "across" else self.heading or at.heading
        lane, spacing = at.lane, at.spacing
        if kind.is_vehicle and heading is None and (at.beside_road or at.both_sides):
            heading = "parked"
        if not (kind.drives or (kind.walks and heading != "parked")):
            heading = None
        if self.in_queue and kind.drives and heading is None and not references:
            heading, lane = "with", lane or (None if any(side for _, side in at.places) else "own")
            spacing = spacing or (kind.sizes.largest[0] if kind.sizes else 6.0) + _QUEUE_GAP
        elif self.in_queue and kind.walks:
            spacing = spacing or _BESIDE_EACH_OTHER
        standing = bool(self.references) and not any(_moves(str(one.kind)) for one in self.references)
        if kind.cycles and heading is None and standing and not self.ridden:
            heading = "parked"  # a bicycle at a wall
        if at.on_road and kind.is_vehicle and heading is None:
            lane = lane or "own"
        in_road = (self.on_road or at.on_road) and {"road", "sidewalk"} <= set(kind.surfaces)
        places = tuple(dict.fromkeys(_named(place) for place in at.places if any(place)))
        return ObjectGroup(
            kind=self.kind,
            count="some" if spacing and self.count == 1 else self.count,
            places=places or (("front",) if self.in_queue and kind.drives and not references else ()),
            not_places=tuple(dict.fromkeys(_named(place) for place in self.not_at if any(place))),
            surface="sidewalk" if at.sidewalk and "sidewalk" in kind.surfaces else "road" if in_road else None,
            lane=lane if "road" in kind.surfaces and (not references or kind.is_vehicle) else None,
            at_junction=at.at_junction,
            heading=heading,
            distance=at.distance,
            from_road=None if references else at.from_road,
            from_sidewalk=None if references or at.from_road else at.from_sidewalk,
            spacing=spacing,
            size=(self.size[0], self.size[1], self.size[2]) if any(self.size) else None,
            scale=(self.scale[0], self.scale[1], self.scale[2]) if self.scale != [1.0, 1.0, 1.0] else None,
            relation=self.relation if references else None,
            references=references,
            words=words,
        )


def _named(place: Place) -> str:
    return "-".join(filter(None, place))


@dataclass
class SentenceNotes:
    """The mentions of objects, the road, and the setting ("BUSY", "RESIDENTIAL", ...: terminals of the grammar).

    `unclear` are the parts of the `text` that say nothing here.
    """

    text: str = ""
    mentions: list[Mention] = field(default_factory=list)
    road: str | None = None
    lanes: int = 0
    usual_lanes: int = 0
    oncoming_lanes: int = 0
    each_way: bool = False
    one_way: bool = False
    sidewalk: bool | None = None
    settings: set[str] = field(default_factory=set)
    unclear: list[Span] = field(default_factory=list)

    @property
    def not_understood(self) -> list[str]:
        """The words of the text that say nothing here; what adjoins is one."""
        joined: list[Span] = []
        for start, end in sorted(self.unclear):
            start -= len(_HYPHENED_TO.search(self.text[:start])[0])  # type: ignore[index]
            end += len(_HYPHENED.match(self.text[end:])[0])  # type: ignore[index]
            if joined and not self.text[joined[-1][1] : start].strip():
                joined[-1] = (joined[-1][0], max(end, joined[-1][1]))
            else:
                joined.append((start, end))
        return [self.text[start:end] for start, end in joined]

    @property
    def empty(self) -> bool:
        """Whether nothing at all was understood."""
        said = self.mentions or self.road or self.lanes or self.usual_lanes or self.settings or self.one_way
        return not said and self.sidewalk is None

    def spec(self) -> SceneSpec:
        """The spec: what is wanted, less what is denied, with what the setting implies."""
        divided = [mention for mention in self.mentions if mention.count != 0 and self._is_divided(mention)]
        for part in self.mentions:
            whole = part.same_as
            if whole is not None and (part.of_them or whole in divided):
                part.at = whole.at.narrowed(part.at) if whole.placed else part.at
                part.heading, part.size, part.scale = part.heading or whole.heading, whole.size, whole.scale
                counted = part.of_them and isinstance(part.count, int) and isinstance(whole.count, int)
                if counted and 0 < part.count < whole.count:  # type: ignore[operator]
                    whole.count -= part.count  # type: ignore[operator]
        wanted = [mention for mention in self.mentions if mention.count != 0 and mention not in divided]
        denied = [mention for mention in self.mentions if mention.count == 0]
        for mention in wanted:
            for no in denied:
                if no.placed and _covers(no, mention):
                    keep_away(mention, no.at)
                elif _is_off_the_road(no) and no.kind == mention.kind and not mention.on_road:
                    mention.at = dataclasses.replace(mention.at, sidewalk=True)
            if mention.at.lane == "each" and self.road == "motorway" and SENTENCE_KINDS[str(mention.kind)].drives:
                mention.heading = mention.heading or "with"
            if "BUSY" in self.settings and mention.count == "some" and _drives(mention.kind, mention.heading):
                mention.count = "many"
        walking = {mention.kind for mention in wanted}
        absent = {
            str(mention.kind)
            for mention in denied
            if not mention.placed
            and mention.heading is None
            and not (_is_off_the_road(mention) and mention.kind in walking)
        }
        groups = [
            mention.group(
                tuple(
                    number
                    for reference in mention.references
                    for number, one in enumerate(wanted)
                    if one is reference or (reference in divided and one.same_as is reference)
                ),
                self._words(mention),
            )
            for mention in wanted
        ]
        groups += [group for group in self._implied(groups) if group.kind not in absent]
        return SceneSpec(
            road=self._road_spec(any(group.surface == "sidewalk" or group.from_sidewalk for group in groups)),
            groups=tuple(groups),
            absent=tuple(sorted(absent)),
            not_understood=tuple(self.not_understood),
        )

    def _is_divided(self, mention: Mention) -> bool:
        """Whether it only sums up those after it, as in "three cars: one ahead, two behind"."""
        each = [other for other in self.mentions if other.same_as is mention]
        if not mention.placed and any(other.at.lane == "each" for other in each):
            return True
        whole = sum(other.count for other in each if isinstance(other.count, int))
        if not each or whole != mention.count or (mention.placed and len(each) == 1):
            return False
        return not mention.placed or all(other.at.agrees(mention.at) for other in each)

    def _words(self, mention: Mention) -> str:
        """The words that a mention was read from: all between its first and its last, unless others are among them."""
        start, end = min((a for a, _ in mention.spans), default=0), max((b for _, b in mention.spans), default=0)
        others = [span for other in self.mentions if other is not mention for span in other.spans]
        if any(a < end and b > start for a, b in others):
            return " ".join(self.text[a:b] for a, b in sorted(set(mention.spans)))
        return self.text[start:end]

    def _road_spec(self, needs_sidewalk: bool) -> RoadSpec:
        kind = self.road or "straight"
        whole = kind == "motorway" or self.each_way or self.one_way
        number = self.lanes or self._lanes_filled() or self.usual_lanes
        lanes = number if whole else (number + 1) // 2
        oncoming = number // 2 if number % 2 and not whole else self.oncoming_lanes if kind != "motorway" else 0
        sidewalk = self.sidewalk if self.sidewalk is not None or "RURAL" not in self.settings else False
        sidewalk = True if needs_sidewalk else sidewalk
        return RoadSpec(
            kind=kind,
            lanes=lanes or None,
            oncoming_lanes=oncoming or None,
            sidewalk=sidewalk,
            one_way=self.one_way,
        )

    def _lanes_filled(self) -> int:
        """How many lanes "three cars, one in each lane" speaks of; 0 where it is not said."""
        for one in self.mentions:
            if one.at.lane == "each" and one.same_as is not None:
                whole, each = one.same_as.count, one.count
                if isinstance(whole, int) and isinstance(each, int) and whole > each and not whole % each:
                    return whole // each
        return 0

    def _implied(self, groups: list[ObjectGroup]) -> list[ObjectGroup]:
        """What the setting means where the sentence does not say it itself."""
        kinds = {group.kind for group in groups}
        implied = []
        if "RESIDENTIAL" in self.settings and not kinds & {"house", "building"}:
            implied.append(ObjectGroup(kind="house", count="some", places=_SIDES))
        if "URBAN" in self.settings and not kinds & {"house", "building"}:
            implied.append(ObjectGroup(kind="building", count="some", places=_SIDES))
        if "TREE_LINED" in self.settings and "tree" not in kinds:
            implied.append(ObjectGroup(kind="tree", count="many", places=_SIDES))
        if "BUSY" in self.settings and not any(_drives(group.kind, group.heading) for group in groups):
            implied.append(ObjectGroup(kind="vehicle", count="some"))
        return implied


def _is_off_the_road(no: Mention) -> bool:
    """Whether it denies what walks on the road alone, as in "people on the pavement but nobody on the road"."""
    return (no.on_road or no.at.on_road) and SENTENCE_KINDS[str(no.kind)].walks


def _covers(no: Mention, mention: Mention) -> bool:
    """Whether what is denied somewhere is, or may be, what is wanted."""
    kinds = {no.kind, mention.kind}
    return len(kinds) == 1 or ("vehicle" in kinds and all(SENTENCE_KINDS[str(kind)].is_vehicle for kind in kinds))


def keep_away(mention: Mention, no: Position) -> None:
    """Leave out places: of those that the mention names, else of everywhere."""
    if mention.relation is None and any(place in mention.at.places for place in no.places):
        mention.at = mention.at.without(no)
    else:
        mention.not_at += [place for place in no.places if any(place)]


def _moves(kind: str) -> bool:
    return SENTENCE_KINDS[kind].drives or SENTENCE_KINDS[kind].walks


def _drives(kind: str | None, heading: str | None) -> bool:
    return kind is not None and SENTENCE_KINDS[kind].is_vehicle and heading != "parked"
