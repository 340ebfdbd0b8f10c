"""The defaults of mentions for open properties, and the spec of all of them."""

from __future__ import annotations

from dataclasses import replace

from lidardraft.drafting.solver.scene_spec import ObjectGroup, RoadSpec, SceneSpec
from lidardraft.drafting.text.exceptions import keep_away
from lidardraft.drafting.text.mentions import JUNCTIONS, Mention, Mentions, RoadNotes
from lidardraft.drafting.text.named_defaults import as_named
from lidardraft.drafting.text.parts import divided
from lidardraft.drafting.text.positions import BEHIND, BESIDE, Place, Position
from lidardraft.drafting.text.tree import NO_SCALE
from lidardraft.objects.sentence_kind import SentenceKind

_BESIDE_EACH_OTHER = 1.0  # m between people in a queue; estimate
_QUEUE_GAP = 2.5  # m between vehicles in a queue; estimate
_ROW_GAP = 1.0  # m between things in a row; estimate
_FEW = 3  # named vehicles; with fewer, a busy road gets further ones
_LEFT_IN_ROADS = ("bench", "bin")
_SIDES = ("left", "right")
_CROSSED = ("crossroads", "t-junction")


def spec_of(mentions: Mentions, road: RoadNotes, texts: list[str]) -> SceneSpec:
    """The spec of the wanted objects, without the denied ones, with the defaults of the setting."""
    denied = [one for one in mentions if one.kind is not None and one.count == 0]
    wanted = [(number, as_named(_wanted(one, denied, road), mentions)) for number, one in divided(mentions)]
    walking = {one.kind for _, one in wanted}
    absent = {
        str(one.kind): one
        for one in denied
        if not one.placed and one.heading is None and not (_is_off_the_road(one) and one.kind in walking)
    }
    groups = []
    for index, (_, one) in enumerate(wanted):
        references = [index + 1] if one.references == (-1,) else [
            other for reference in one.references for other, (number, whole) in enumerate(wanted)
            if number == reference or (whole.same_as == reference and reference not in [n for n, _ in wanted])
        ]  # fmt: skip
        references = [
            other for other in dict.fromkeys(references) if other != index and wanted[other][1].references != (-1,)
        ] or (references if one.references == (-1,) else [])
        groups.append(_group(one, tuple(references), mentions, road, _words(one, mentions, texts)))
    groups += [group for group in _implied(groups, road) if group.kind not in absent]
    if road.kind == "parking-lot":  # car parks have no sidewalk
        groups = [replace(one, surface="road" if one.surface == "road" else None, from_sidewalk=None) for one in groups]
        road = replace(road, sidewalk=None)
    needs_sidewalk = any(group.surface == "sidewalk" or group.from_sidewalk for group in groups)
    return SceneSpec(
        road=_road_spec(road, mentions, {str(group.surface) for group in groups}, needs_sidewalk),
        groups=tuple(groups),
        absent=tuple(sorted(absent)),
        not_around=tuple(sorted({str(one.kind) for one in mentions if one in denied or one.only} - set(absent))),
    )


def _wanted(mention: Mention, denied: list[Mention], road: RoadNotes) -> Mention:
    for no in denied:
        if no.placed and _covers(no, mention):
            mention = keep_away(mention, no.at)
        elif _is_off_the_road(no) and no.kind == mention.kind and not mention.on_road:
            mention = replace(mention, at=replace(mention.at, sidewalk=True))
    if mention.at.lane == "each" and road.kind == "motorway" and mention.record.drives:
        mention = replace(mention, heading=mention.heading or "with")
    if (
        "busy" in road.settings
        and mention.count == "some"
        and mention.record.is_vehicle
        and mention.heading != "parked"
    ):
        mention = replace(mention, count="many")
    return mention


def _group(
    mention: Mention, references: tuple[int, ...], mentions: Mentions, road: RoadNotes, words: str
) -> ObjectGroup:
    """The mention as a group of the spec."""
    at, heading, lane = _headed(mention, motorway=road.kind == "motorway")
    kind, spacing = mention.record, at.spacing
    in_row = mention.row and kind.family == "trees"
    strip_across = heading == "across" and kind.follows_road  # a fence across the road
    waits = kind.walks and mention.speed == 0.0 and str(heading).startswith("across")  # to cross, at the kerb
    if waits or not (kind.drives or (kind.walks and heading != "parked")):
        heading = None
    in_lot = road.kind == "parking-lot"
    if mention.queue and kind.drives and heading is None and not references and not in_lot:
        heading, lane = "with", lane or (None if at.sides else "own")
        spacing = spacing or (kind.sizes.largest[0] if kind.sizes else 6.0) + _QUEUE_GAP
    elif mention.queue and kind.drives and heading is None and mention.relation == "behind":
        first = mentions[mention.references[0]]
        heading = "against" if (first.heading or first.at.heading) == "against" else "with"
    elif mention.queue and kind.walks:
        spacing = spacing or _BESIDE_EACH_OTHER
    elif (mention.queue or in_row) and kind.sizes and not references and mention.count != 1:
        spacing = spacing or kind.sizes.largest[0] + _ROW_GAP
    still = bool(references) and not any(
        mentions[one].record.drives or mentions[one].record.walks for one in mention.references if one >= 0
    )
    if kind.cycles and heading is None and still and not mention.ridden:
        heading = "parked"  # a bicycle at a wall
    if at.on_road and kind.is_vehicle and heading is None:
        lane = lane or "own"
    on_road = (
        at.on_road or strip_across or (mention.on_road and (kind.on_road or kind.name in _LEFT_IN_ROADS))
    )  # a house "on the road" is beside it
    in_road = on_road and not at.median and "road" in kind.surfaces and not kind.is_vehicle
    places = tuple(dict.fromkeys(_named(place) for place in _where(at, kind, references) if any(place)))
    return ObjectGroup(
        kind=kind.name,
        count="some" if at.spacing and mention.count == 1 else mention.count,
        places=places
        or (("front",) if mention.queue and kind.drives and not (references or in_lot) and lane != "opposite" else ()),
        not_places=tuple(dict.fromkeys(_named(place) for place in mention.not_at if any(place))),
        surface=_surface(at, kind, waits=waits, on_road=in_road, parted=not (references or road.one_way)),
        lane=lane if "road" in kind.surfaces and (not references or kind.is_vehicle) else None,
        at_junction=at.at_junction,
        heading=heading,
        motion=mention.motion
        if kind.drives and not (mention.motion == "overtakes" and str(heading).startswith("across"))
        else None,
        speed=mention.speed if kind.drives or kind.walks else None,
        distance=at.distance,
        from_road=None if references else at.from_road,
        from_sidewalk=None if references or at.from_road else at.from_sidewalk,
        spacing=spacing,
        size=mention.size if any(mention.size) else None,
        scale=mention.scale if mention.scale != NO_SCALE else None,
        paint=mention.paint,
        relation=mention.relation if references else None,
        references=references,
        words=words,
    )


def _surface(at: Position, kind: SentenceKind, *, waits: bool, on_road: bool, parted: bool) -> str | None:
    """Its surface, None if it is the usual one of its kind; only a road of two directions has a median."""
    if at.median and "median" in kind.surfaces and parted:
        return "median"
    if (at.sidewalk or waits) and "sidewalk" in kind.surfaces:
        return "sidewalk"
    return "road" if on_road else None


def _headed(mention: Mention, *, motorway: bool) -> tuple[Position, str | None, str | None]:
    """The place, heading and lane of a mention; vehicles along the sides of a road are parked."""
    at, kind = _overtaking(mention), mention.record
    sideways = str(at.heading).startswith("across-") and mention.heading in ("across", "against", "with")
    across = at.heading == "across" and not str(mention.heading).startswith("across-")
    heading = at.heading if sideways or across else mention.heading or at.heading
    lane = at.lane
    elsewhere = ("across", "turning") if kind.is_vehicle else "turning"
    if kind.drives and mention.references and str(heading).startswith(elsewhere):
        heading = None  # it follows the other one
    free = heading is None and not mention.references
    if at.at_junction and kind.drives and free and len(at.sides) == 1:  # on an arm of the junction
        heading = "across-right" if at.sides == ["left"] else "across-left"
    if lane == "own" and kind.drives and str(heading).startswith(("across", "turning")):
        lane = None  # "turns left across our lane"
    if lane is not None and not kind.drives:
        at = replace(at, places=tuple((fore, "") for fore, _ in at.places))  # the lane implies the side
    if heading == "against" and at.places == (BEHIND,):  # it comes up to us
        heading = "with"
    if lane == "own" and at.heading == "parked" and at.sides:  # double parked, beside the strip on its side
        lane = "opposite" if at.sides == ["left"] else lane
        at = replace(at, places=tuple((fore, "") for fore, _ in at.places))
    waits = at.both_sides and mention.speed == 0.0
    moves = mention.moves or waits or (motorway and at.both_sides)
    if kind.is_vehicle and heading is None and (at.beside_road or at.both_sides) and not moves:
        heading = "parked"
    return at, heading, lane


def _where(at: Position, kind: SentenceKind, references: tuple[int, ...]) -> tuple[Place, ...]:
    """The places of a position: roadside objects at a distance are ahead, or level with the ego."""
    if at.distance is None or references or kind.on_road:
        return at.places
    return tuple(("" if fore == "beside" else fore or "front", side) for fore, side in at.places)


def _overtaking(mention: Mention) -> Position:
    """The position of a mention; one that overtakes is beside the ego in the left lane, unless placed elsewhere."""
    at = mention.at
    if mention.motion != "overtakes" or str(mention.heading).startswith("across"):
        return at
    if mention.references:
        return replace(at, heading="with")
    lane = at.lane or (None if "right" in at.sides else "left")
    at = replace(at, lane=lane, heading="with")
    return at if any(fore for fore, _ in at.places) else at.narrowed(Position(places=(BESIDE,)))


def _named(place: Place) -> str:
    return "-".join(filter(None, place))


def _words(mention: Mention, mentions: Mentions, texts: list[str]) -> str:
    """The words of a mention: all between its first and its last, unless other mentions are among them."""
    if not mention.tokens:
        return ""
    between = range(min(mention.tokens), max(mention.tokens) + 1)
    others = frozenset().union(*(one.tokens for one in mentions)) - mention.tokens
    return " ".join(texts[n] for n in (sorted(mention.tokens) if others & set(between) else between))


def _road_spec(notes: RoadNotes, mentions: Mentions, surfaces: set[str], needs_sidewalk: bool) -> RoadSpec:
    at_junction = any(one.is_wanted and one.at.at_junction for one in mentions)
    kind = notes.kind or ("crossroads" if at_junction else "straight")
    number = notes.lanes or _lanes_filled(mentions) or notes.usual_lanes
    middle = notes.ego_lane == "middle" and number == 3  # a lane on each side leads the same way
    median = "median" in notes.settings and not notes.one_way and kind != "parking-lot"
    divided_alike = number % 2 == 1 and (median or "median" in surfaces)  # as many lanes on each side
    whole = kind == "motorway" or notes.each_way or notes.one_way or middle or divided_alike
    if kind == "motorway" and number > 3 and number % 2 == 0 and not (notes.each_way or notes.one_way):
        number //= 2  # a six-lane motorway has three each way
    usual = notes.usual_lanes and number == notes.usual_lanes and notes.one_way and not notes.lanes
    lanes = number if whole and not usual else (number + 1) // 2
    oncoming = number // 2 if number % 2 and not whole else notes.oncoming_lanes if kind != "motorway" else 0
    sidewalk = notes.sidewalk if notes.sidewalk is not None or "rural" not in notes.settings else False
    return RoadSpec(
        kind=kind,
        lanes=lanes or None,
        oncoming_lanes=oncoming or None,
        sidewalk=True if needs_sidewalk else sidewalk,
        median=median,
        one_way=notes.one_way,
        ego_lane=notes.ego_lane,
        ego_motion=notes.ego_motion,
        ego_speed=notes.ego_speed,
        junction=notes.junction if kind in JUNCTIONS else None,
    )


def _lanes_filled(mentions: Mentions) -> int:
    """The number of lanes implied by "three cars, one in each lane"; 0 if there is none."""
    for one in mentions:
        if one.at.lane == "each" and one.same_as is not None:
            whole, each = mentions[one.same_as].count, one.count
            if isinstance(whole, int) and isinstance(each, int) and whole > each and not whole % each:
                return whole // each
    return 0


def _implied(groups: list[ObjectGroup], road: RoadNotes) -> list[ObjectGroup]:
    """The groups that the setting implies and the sentence does not state."""
    kinds = {group.kind for group in groups}
    busy, junction = "busy" in road.settings, road.kind in (*_CROSSED, "roundabout")
    implied = []
    if "residential" in road.settings and not kinds & {"house", "building"}:
        implied.append(ObjectGroup(kind="house", count="some", places=_SIDES))
    if "urban" in road.settings and not kinds & {"house", "building"}:
        implied.append(ObjectGroup(kind="building", count="some", places=_SIDES))
    if "tree-lined" in road.settings and "tree" not in kinds:
        implied.append(ObjectGroup(kind="tree", count="many", places=_SIDES))
    moving = [group for group in groups if group.record.is_vehicle and group.heading != "parked"]
    if busy and all(isinstance(one.count, int) for one in moving) and sum(one.fewest or 0 for one in moving) < _FEW:
        implied.append(ObjectGroup(kind="vehicle", count="many"))
        if road.kind == "roundabout":
            implied.append(ObjectGroup(kind="vehicle", count="some", at_junction=True))
        elif road.kind in _CROSSED:
            implied.append(ObjectGroup(kind="vehicle", count="some", heading="across"))
    if busy and junction and kinds <= {"vehicle"}:
        implied.append(ObjectGroup(kind="person", count="some", at_junction=True))
    return implied


def _is_off_the_road(no: Mention) -> bool:
    """Whether it denies people on the road alone, as in "people on the pavement but nobody on the road"."""
    return (no.on_road or no.at.on_road) and no.record.walks


def _covers(no: Mention, mention: Mention) -> bool:
    """Whether a denied mention includes, or may include, a wanted one."""
    kinds = {no.kind, mention.kind}
    return len(kinds) == 1 or ("vehicle" in kinds and no.record.is_vehicle and mention.record.is_vehicle)
