"""What a sentence was found to say so far: its mentions of objects, its road, its setting; and the spec of all that."""

from __future__ import annotations

import dataclasses
import re
from dataclasses import dataclass, field

from lidardraft.drafting.solver.scene_spec import ObjectGroup, RoadSpec, SceneSpec
from lidardraft.drafting.solver.sentence_kinds import SENTENCE_KINDS
from lidardraft.drafting.text.mention import Mention, Span, is_one_of, keep_away, lanes_filled, parted

_HYPHENED_TO, _HYPHENED = (
    re.compile(r"([^\W\d]+-)*$"),
    re.compile(r"(-[^\W\d]+)*"),
)  # the rest of a word such as "lay-by"
_SIDES = ("left", "right")


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
    ego_lane: str | None = None
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
        return not said and self.sidewalk is None and self.ego_lane is None

    def spec(self) -> SceneSpec:
        """The spec: what is wanted, less what is denied, with what the setting implies."""
        wanted = parted(self.mentions)
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
                    if is_one_of(one, reference, wanted)
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
            not_around=tuple(sorted({str(mention.kind) for mention in denied} - absent)),
            not_understood=tuple(self.not_understood),
        )

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
        number = self.lanes or lanes_filled(self.mentions) or self.usual_lanes
        if kind == "motorway" and number > 3 and number % 2 == 0 and not (self.each_way or self.one_way):
            number //= 2  # a six-lane motorway has three each way
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
            ego_lane=self.ego_lane,
        )

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
            implied.append(ObjectGroup(kind="vehicle", count="many"))
            if self.road == "roundabout":
                implied.append(ObjectGroup(kind="vehicle", count="some", at_junction=True))
            elif self.road in ("crossroads", "t-junction"):
                implied.append(ObjectGroup(kind="vehicle", count="some", heading="across"))
        if (
            "BUSY" in self.settings
            and self.road in ("crossroads", "t-junction", "roundabout")
            and "person" not in kinds
        ):
            implied.append(ObjectGroup(kind="person", count="some", at_junction=True))
        return implied


def _is_off_the_road(no: Mention) -> bool:
    """Whether it denies what walks on the road alone, as in "people on the pavement but nobody on the road"."""
    return (no.on_road or no.at.on_road) and SENTENCE_KINDS[str(no.kind)].walks


def _covers(no: Mention, mention: Mention) -> bool:
    """Whether what is denied somewhere is, or may be, what is wanted."""
    kinds = {no.kind, mention.kind}
    return len(kinds) == 1 or ("vehicle" in kinds and all(SENTENCE_KINDS[str(kind)].is_vehicle for kind in kinds))


def _drives(kind: str | None, heading: str | None) -> bool:
    return kind is not None and SENTENCE_KINDS[kind].is_vehicle and heading != "parked"
