"""What a sentence was found to say so far: its mentions of objects, its road, its setting; and the spec of all that."""

from __future__ import annotations

from dataclasses import dataclass, field

from lidardraft.drafting.positions import Position
from lidardraft.drafting.scene_spec import ObjectGroup, RoadSpec, SceneSpec
from lidardraft.drafting.sentence_kinds import SENTENCE_KINDS

_SIDES = ("left", "right")


@dataclass
class Mention:
    """A group while its modifiers are being read; count 0 denies it, a `weak` position is overruled by the next one."""

    kind: str
    count: int | str
    at: Position = field(default_factory=Position)
    heading: str | None = None
    on_road: bool = False
    placed: bool = False
    weak: bool = False

    def group(self) -> ObjectGroup:
        """As a group of the spec; vehicles along the sides of a road are parked."""
        heading, kind = self.heading, SENTENCE_KINDS[self.kind]
        if kind.is_vehicle and heading is None and (self.at.beside_road or self.at.both_sides):
            heading = "parked"
        surface = "road" if self.on_road and {"road", "sidewalk"} <= set(kind.surfaces) else None
        return ObjectGroup(
            kind=self.kind,
            count=self.count,
            places=tuple(dict.fromkeys("-".join(filter(None, place)) for place in self.at.places if any(place))),
            surface="sidewalk" if self.at.sidewalk and "sidewalk" in kind.surfaces else surface,
            heading=heading,
            distance=self.at.distance,
            spacing=self.at.spacing,
        )


@dataclass
class SentenceNotes:
    """The mentions of objects, the road, and the setting ("BUSY", "RESIDENTIAL", ...: terminals of the grammar)."""

    mentions: list[Mention] = field(default_factory=list)
    road: str | None = None
    lanes: int = 0
    each_way: bool = False
    sidewalk: bool | None = None
    settings: set[str] = field(default_factory=set)
    not_understood: list[str] = field(default_factory=list)

    @property
    def empty(self) -> bool:
        """Whether nothing at all was understood."""
        return not (self.mentions or self.road or self.lanes or self.settings) and self.sidewalk is None

    def spec(self) -> SceneSpec:
        """The spec: what is wanted, less what is denied, with what the setting implies."""
        wanted = [mention for mention in self.mentions if mention.count != 0]
        denied = [mention for mention in self.mentions if mention.count == 0]
        for mention in wanted:
            for no in denied:
                if no.placed and no.kind == mention.kind:
                    mention.at = mention.at.without(no.at)
            if "BUSY" in self.settings and mention.count == "some" and _drives(mention.kind, mention.heading):
                mention.count = "many"
        absent = {mention.kind for mention in denied if not mention.placed and mention.heading is None}
        groups = [mention.group() for mention in wanted]
        groups += [group for group in self._implied(groups) if group.kind not in absent]
        return SceneSpec(
            road=self._road_spec(any(group.surface == "sidewalk" for group in groups)),
            groups=tuple(groups),
            absent=tuple(sorted(absent)),
            not_understood=tuple(self.not_understood),
        )

    def _road_spec(self, needs_sidewalk: bool) -> RoadSpec:
        kind = self.road or "straight"
        lanes = self.lanes if kind == "motorway" or self.each_way else (self.lanes + 1) // 2
        sidewalk = self.sidewalk if self.sidewalk is not None or "RURAL" not in self.settings else False
        return RoadSpec(kind=kind, lanes=lanes or None, sidewalk=True if needs_sidewalk else sidewalk)

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


def _drives(kind: str, heading: str | None) -> bool:
    return SENTENCE_KINDS[kind].is_vehicle and heading != "parked"
