"""A mention of objects in a sentence, and the group of a spec that it becomes."""

from __future__ import annotations

from dataclasses import dataclass, field

from lidardraft.drafting.solver.scene_spec import ObjectGroup
from lidardraft.drafting.solver.sentence_kinds import SENTENCE_KINDS
from lidardraft.drafting.text.positions import Place, Position

Span = tuple[int, int]  # of characters of the sentence: from and to
_BESIDE_EACH_OTHER = 1.0  # m between people in a queue; estimate of ours
_QUEUE_GAP = 2.5  # m between vehicles in a queue; estimate of ours


@dataclass(eq=False)
class Mention:
    """A group while its modifiers are being read; count 0 denies it, a `weak` position is overruled by the next one.

    The kind is None for what is unknown, which takes the words after it and makes nothing. The other fields by example:

    described: "a man waits": what is listed after the verb does not share its position
    same_as, of_them: "three cars, two of them red": the two are the `same_as` the three, and counted in them
    host, left_out: "two trees for each house except one": the houses are the host, one of them is left out
    abreast: "two vans side by side"
    name: the A of "car A"
    summed: "a queue: three cars and a bus": the queue is all that is listed after its colon
    with_it: "a garden with two trees": the trees are near it where nothing else places them
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
    host: Mention | None = None
    abreast: bool = False
    name: str = ""
    left_out: int = 0
    summed: bool = False
    with_it: Mention | None = None
    spans: list[Span] = field(default_factory=list)

    def group(self, references: tuple[int, ...] = (), words: str = "") -> ObjectGroup:
        """As a group of the spec; vehicles along the sides of a road are parked."""
        assert self.kind is not None
        at, kind = self.at, SENTENCE_KINDS[self.kind]
        heading = "across" if at.heading == "across" else self.heading or at.heading
        lane, spacing = at.lane, at.spacing
        if kind.is_vehicle and heading is None and (at.beside_road or at.both_sides):
            heading = "parked"
        strip_across = heading == "across" and kind.follows_road  # a fence across the road
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
        said_on_road = (
            at.on_road or strip_across or (self.on_road and kind.on_road)
        )  # a house "on the road" is beside it
        in_road = said_on_road and "road" in kind.surfaces and not kind.is_vehicle
        places = tuple(dict.fromkeys(_named(place) for place in at.places if any(place)))
        return ObjectGroup(
            kind=self.kind,
            count="some" if at.spacing and self.count == 1 else self.count,
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


def keep_away(mention: Mention, no: Position) -> None:
    """Leave out places: of those that the mention names, else of everywhere."""
    if mention.relation is None and any(place in mention.at.places for place in no.places):
        mention.at = mention.at.without(no)
    else:
        mention.not_at += [place for place in no.places if any(place)]


def _moves(kind: str) -> bool:
    return SENTENCE_KINDS[kind].drives or SENTENCE_KINDS[kind].walks
