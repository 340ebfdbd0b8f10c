"""Mentions of objects in a sentence, and the groups of a spec that they become.

Adjectives and verbs say how they stand or move and how large they are. Some mentions count others, or stand for several
groups: what "one of them", "each" and "side by side" mean.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass, field

from lark import Token

from lidardraft.drafting.solver.scene_spec import ObjectGroup
from lidardraft.drafting.solver.sentence_kinds import SENTENCE_KINDS
from lidardraft.drafting.text.number_words import Count, count_times, metres
from lidardraft.drafting.text.positions import Place, Position

Span = tuple[int, int]  # of characters of the sentence: from and to
_BESIDE_EACH_OTHER = 1.0  # m between people in a queue; estimate of ours
_MOST_ABREAST = 5  # that stand side by side; a word for a number says nothing of them
_QUEUE_GAP = 2.5  # m between vehicles in a queue; estimate of ours
_HEADING_OF = {"PARKED": "parked", "MOVING": "with", "CROSSING": "across", "ONCOMING": "against"}
# What usual lengths, widths and heights are multiplied by; estimates of ours.
_SCALE_OF = {
    "LARGE": (1.25, 1.15, 1.25),
    "SMALL": (0.8, 0.85, 0.8),
    "TALL": (1.0, 1.0, 1.6),
    "LOW": (1.0, 1.0, 0.6),
    "LONG": (1.5, 1.0, 1.0),
    "SHORT": (0.7, 1.0, 0.7),
    "WIDE": (1.0, 1.3, 1.0),
    "NARROW": (1.0, 0.75, 1.0),
}
_JAM = "stuck in"  # a queue in all lanes
_TOWERS, _TOWER = ("sky", "high", "tower"), (1.0, 1.0, 2.5)
_AXIS_OF = {"long": 0, "length": 0, "wide": 1, "deep": 1, "thick": 1, "width": 1, "tall": 2, "high": 2, "height": 2}
SCALES = tuple(_SCALE_OF)
SIZES = (*SCALES, "SIZE", "LENGTH", "HEIGHT")


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


def heading_of(tokens: list[Token]) -> str | None:
    """How objects stand or move relative to the ego, None where nothing is said of it."""
    for token in tokens:
        if token.type == "CROSSING" and {"left", "right"} <= set(token.split()):
            return "across-right" if token.rindex("right") > token.rindex("left") else "across-left"
    found = [_HEADING_OF[token.type] for token in tokens if token.type in _HEADING_OF]
    found += ["with" for token in tokens if token.type == "QUEUEING" and token.startswith(_JAM)]
    return next((heading for heading in found if heading != "with"), found[0] if found else None)


def add_qualities(mention: Mention, tokens: list[Token]) -> None:
    """Note what some words say of a mention."""
    mention.heading = heading_of(tokens) or mention.heading
    mention.in_queue = mention.in_queue or any(
        (token.type == "QUEUEING" and not token.startswith(_JAM))
        or (token.type == "MANY" and {"queue", "line"} & set(token.split()))
        for token in tokens
    )
    if mention.kind == "person" and any(token == "cycling" for token in tokens):
        mention.kind = "bicycle"
    mention.ridden = mention.ridden or tokens[-1].rstrip("s").endswith(("ist", "rider"))
    for token in tokens:
        tower = token.type == "BUILDING" and token.startswith(_TOWERS)
        scale = _TOWER if tower else _SCALE_OF.get(token.type)
        if scale is not None:
            mention.scale = [a * b for a, b in zip(mention.scale, scale, strict=True)]
        elif token.type in ("LENGTH", "HEIGHT"):
            mention.size[0 if token.type == "LENGTH" else 2] = metres(token)[1]
        elif token.type == "SIZE":
            mention.size[_AXIS_OF[token.split()[-1]]] = metres(token)[1]


def depends(mention: Mention, other: Mention) -> bool:
    """Whether a mention is another one, or placed from it."""
    return mention is other or any(depends(reference, other) for reference in mention.references)


def parted(mentions: list[Mention]) -> list[Mention]:
    """The mentions of what is wanted, each of its own objects: none only sums up others or counts them again."""
    for mention in mentions:
        if mention.host is not None:
            mention.count = hosted_count(mention)
            if mention.relation is None and not mention.placed:
                mention.relation, mention.references, mention.placed = "near", [mention.host], True
    for mention in mentions:
        _keep_with(mention)
        _turn_to_strip(mention)
        if mention.relation == "between" and mention.heading == "parked":
            for reference in mention.references:
                reference.heading = reference.heading or "parked"
        if mention.relation == "left-of" and mention.at.heading == "with":  # it overtakes
            for reference in mention.references:
                _park_at_right(reference)
    _note_listed_parts(mentions)
    for mention in mentions:
        _count_rest(mention, _parts_of(mention, mentions))
    sums = [one for one in mentions if one.count != 0 and _is_sum(one, _parts_of(one, mentions))]
    for part in mentions:
        whole = part.same_as
        if whole is not None and (part.of_them or whole in sums):
            _inherit(part, whole)
            if isinstance(part.count, int) and isinstance(whole.count, int) and 0 < part.count < whole.count:
                whole.count -= part.count if part.of_them and whole not in sums else 0
    wanted = [mention for mention in mentions if mention.count != 0 and mention not in sums]
    return [one for mention in wanted for one in (*_abreast(mention), *_at_each_side(mention))]


def hosted_count(mention: Mention) -> Count:
    """How many objects there are where a count is said for each host: "two trees for each house" are 2 x houses."""
    assert mention.host is not None
    hosts = mention.host.count
    if isinstance(hosts, int) and hosts > mention.left_out:
        hosts -= mention.left_out
    return count_times(mention.count, hosts)


def is_one_of(mention: Mention, reference: Mention, wanted: list[Mention]) -> bool:
    """Whether a mention is what another one is placed from, or a part that it was divided into."""
    return mention is reference or (mention.same_as is reference and reference not in wanted)


def lanes_filled(mentions: list[Mention]) -> int:
    """How many lanes "three cars, one in each lane" speaks of; 0 where it is not said."""
    for one in mentions:
        if one.at.lane == "each" and one.same_as is not None:
            whole, each = one.same_as.count, one.count
            if isinstance(whole, int) and isinstance(each, int) and whole > each and not whole % each:
                return whole // each
    return 0


def _keep_with(mention: Mention) -> None:
    """What is with something, and placed by nothing else, is near it, as in "a garden with two trees"."""
    other = mention.with_it
    if other is None or other.kind in (None, "vehicle") or other.count == 0 or mention.count == 0:
        return
    drives = SENTENCE_KINDS[str(mention.kind)].drives and not SENTENCE_KINDS[str(other.kind)].drives
    if not mention.placed and mention.relation is None and not drives and not depends(other, mention):
        mention.relation, mention.references, mention.placed = "near", [other], True


def _park_at_right(overtaken: Mention) -> None:
    """What is parked and overtaken stands at the kerb of the lanes that it is overtaken in."""
    at = overtaken.at
    if overtaken.heading == "parked" and not overtaken.references and not any(side for _, side in at.places):
        overtaken.at, overtaken.placed = at.narrowed(Position(places=(("", "right"),))), True


def _turn_to_strip(mention: Mention) -> None:
    """A hedge in front of several houses is what those stand behind, as long as they need it."""
    strip = mention.kind is not None and SENTENCE_KINDS[mention.kind].follows_road and mention.count == 1
    if not strip or mention.relation != "in-front-of" or len(mention.references) != 1:
        return
    (row,) = mention.references
    if row.count not in (0, 1) and row.relation is None and not row.at.distance and not mention.at.distance:
        set_back = row.at.from_road or row.at.from_sidewalk  # which no relation goes with
        at = dataclasses.replace(row.at, from_road=None, from_sidewalk=None).narrowed(mention.at)
        mention.relation, mention.references, mention.at = None, [], at
        if set_back:
            return
        row.relation, row.references, row.placed = "behind", [mention], True


def _parts_of(whole: Mention, mentions: list[Mention]) -> list[Mention]:
    return [other for other in mentions if other.same_as is whole]


def _note_listed_parts(mentions: list[Mention]) -> None:
    """Those that sum up to the number of vehicles, or of their own kind, just before them are parts of it."""
    for index, whole in enumerate(mentions):
        if not isinstance(whole.count, int) or whole.count < 2 or whole.references:
            continue
        parts: list[Mention] = []
        for other in mentions[index + 1 :]:
            vehicle = whole.kind == "vehicle" and SENTENCE_KINDS[str(other.kind)].is_vehicle
            if other.same_as is not None or not (vehicle or other.kind == whole.kind):
                break
            parts.append(other)
            if sum(part.count for part in parts if isinstance(part.count, int)) >= whole.count:
                break
        if len(parts) > 1 and sum(part.count for part in parts if isinstance(part.count, int)) == whole.count:
            for part in parts:
                part.same_as, part.of_them = whole, True


def _count_rest(whole: Mention, parts: list[Mention]) -> None:
    """Of "the others" there are as many as the other parts leave."""
    vague = [part for part in parts if part.count == "some" and not part.of_them]
    if len(vague) == len(parts) > 1 and isinstance(whole.count, int) and whole.count >= len(parts):
        for number, part in enumerate(parts):  # "six people, some on the left and some on the right"
            part.count, part.of_them = (whole.count + number) // len(parts), True
    for rest in parts:
        if rest.of_them and rest.count == "some" and isinstance(whole.count, int):
            left = whole.count - sum(part.count for part in parts if isinstance(part.count, int))
            rest.count = max(1, left)


def _is_sum(whole: Mention, parts: list[Mention]) -> bool:
    """Whether it only sums up its parts, as in "three cars: one ahead, two behind"."""
    if isinstance(whole.count, str) and len(parts) == len(whole.at.places) > 1:  # "on both sides (10 left, 8 right)"
        return {place for part in parts for place in part.at.places} == set(whole.at.places)
    if whole.summed or (not whole.placed and any(part.at.lane == "each" for part in parts)):
        return True
    if not parts or sum(part.count for part in parts if isinstance(part.count, int)) != whole.count:
        return False
    if any(part.of_them for part in parts):
        return True
    return not whole.placed or (len(parts) > 1 and all(part.at.agrees(whole.at) for part in parts))


def _inherit(part: Mention, whole: Mention) -> None:
    """Give to a part what is said of all, where it says nothing else itself."""
    if whole.placed:
        at = whole.at.narrowed(part.at)
        apart = len(at.places) > max(len(whole.at.places), len(part.at.places))
        part.at = dataclasses.replace(at, places=part.at.places) if apart else at
        part.placed = True
    if not part.references and whole.references and whole.relation is not None:
        part.relation, part.references = whole.relation, whole.references
    if part.kind == whole.kind:
        part.size = part.size if any(part.size) else whole.size
        part.scale = part.scale if part.scale != [1.0, 1.0, 1.0] else whole.scale
    part.heading = part.heading or whole.heading


def _abreast(mention: Mention) -> Iterator[Mention]:
    """All but the first of what stands side by side, each beside the one before it."""
    if not mention.abreast or not isinstance(mention.count, int) or not 1 < mention.count <= _MOST_ABREAST:
        return
    before = mention
    for _ in range(mention.count - 1):
        at = Position(heading=mention.at.heading)
        before = dataclasses.replace(mention, count=1, at=at, relation="beside", references=[before], same_as=mention)
        yield before
    mention.count = 1


def _at_each_side(mention: Mention) -> Iterator[Mention]:
    """A number of objects at both sides is half of them at each."""
    low, high = mention.count if isinstance(mention.count, tuple) else (mention.count, mention.count)
    if not mention.at.shared or len(mention.at.places) != 2 or isinstance(low, str) or isinstance(high, str) or low < 2:
        yield mention
        return
    for place, odd in zip(mention.at.places, (1, 0), strict=True):
        count = ((low + odd) // 2, (high + odd) // 2)
        at = dataclasses.replace(mention.at, places=(place,))
        yield dataclasses.replace(mention, count=count if low != high else count[0], at=at, same_as=mention)
