"""Effects of places, verbs and adjectives on mentions: their place, motion, state and size."""

from __future__ import annotations

import itertools
from dataclasses import replace

from lidardraft.drafting.text.exceptions import leave_out_place
from lidardraft.drafting.text.mentions import JUNCTIONS, Discourse, Ids, Mention, count_times, fitting_manner
from lidardraft.drafting.text.positions import BEHIND, FRONT, LEFT, RIGHT, Position
from lidardraft.drafting.text.tree import Count, Manner, Modifier, Place

_VERGE = (0.0, 1.5)  # m from the kerb


def say_place(d: Discourse, ids: Ids, place: Place, modifier: Modifier) -> Ids:
    """Note a place of objects; returns the objects that the next words are about."""
    note_place(d, place)
    place = with_side(d, place)
    if place.middle and d.road.kind in JUNCTIONS:
        place = replace(place, at=Position(at_junction=True))
    if place.at.at_junction and d.road.kind == "parking-lot":
        return ids
    building = d.building_before(ids[0]) if place.bare and ids else None
    if building is not None and not any(d.depends(building, one) for one in ids):  # "a house, hedge in front"
        for one in ids:
            d.change(one, relation="in-front-of", references=(building,), placed=True)
        return ids
    if place.only:
        for one in ids:
            d.change(one, only=True)
    if modifier.link == "except":
        leave_out_place(d, ids, place)
        return ids
    if place.there:
        _say_there(d, ids)
        return ids
    if place.at.spacing and place.in_row and queue_up(d, ids, place.at.spacing):
        return ids[:1]
    if place.at.spacing and len(ids) > 2 and queue_up(d, ids, place.at.spacing):  # "a car, a van and a bus 5 m apart"
        ids, place = ids[:1], replace(place, at=replace(place.at, spacing=None))
    spaced = modifier.link == "," and place.at == Position(spacing=place.at.spacing)  # "6 left, 4 right, 5 m apart"
    ahead = modifier.link == "," and not modifier.verb and place.at == Position(place.at.places) and not place.at.sides
    ahead = ahead and bool(ids) and d.mentions[ids[0]].at.distance is not None  # "one at 5 m and one at 9 m, ahead"
    if (place.of_all or spaced or ahead) and len(ids) == 1 and d.mentions[ids[0]].same_as is not None:
        whole = d.mentions[ids[0]].same_as
        ids = [n for n, one in enumerate(d.mentions) if n == whole or one.same_as == whole]
    for one in ids:
        mention = d.mentions[one]
        if mention.kind is None:
            d.change(one, at=mention.at.narrowed(place.at), placed=True)
        elif _has_facade(d, one) and place.bare:
            d.change(one, relation="in-front-of", references=(mention.with_it,), placed=True)
        elif mention.host is not None and place.at in (Position((FRONT,)), Position((BEHIND,))) and not mention.placed:
            relation = "in-front-of" if place.at.places == (FRONT,) else "behind"
            d.change(one, relation=relation, references=(mention.host,), placed=True)
        elif mention.of_them and mention.count == 1 and place.at.spacing and mention.same_as is not None:
            return [_begin_row(d, one, place)]
        else:
            attach(d, one, _spanned(d, one, place), "" if modifier.verb else modifier.link)
    return ids


def _has_facade(d: Discourse, number: int) -> bool:
    """Whether it is with buildings, as in "houses with a fence in front"."""
    host = d.mentions[number].with_it
    if host is None or d.mentions[host].kind is None or d.depends(host, number):
        return False
    return d.mentions[host].record.family == "buildings"


def _spanned(d: Discourse, number: int, place: Place) -> Place:
    """ "From 5 m to 35 m" gives the length and the middle of a wall."""
    near, far = place.at.distance or (0.0, 0.0)
    mention = d.mentions[number]
    if place.from_to and mention.record.follows_road and mention.count == 1 and near < far:
        d.change(number, size=(far - near, *mention.size[1:]))
        place = replace(place, at=replace(place.at, distance=((near + far) / 2, (near + far) / 2)))
    return place


def _say_there(d: Discourse, ids: Ids) -> None:
    """ "There" is at the last object of before, or at the place of an unknown one."""
    before = [n for n, one in enumerate(d.mentions[: ids[0]] if ids else []) if one.placed or one.kind is None]
    for one in ids if before else []:
        there, mention = d.mentions[before[-1]], d.mentions[one]
        if mention.kind is None or mention.relation is not None:
            continue
        if there.is_wanted and not there.record.on_road and not d.depends(before[-1], one):
            d.change(one, relation="near", references=(before[-1],), placed=True)
        elif there.at != Position():
            place_at(d, one, Place(Position(there.at.places, there.at.distance, lane=there.at.lane)))


def _begin_row(d: Discourse, first: int, place: Place) -> int:
    """All of several objects begin at the place of the first, as in "the first at 10 m, 20 m between them"."""
    one = d.mentions[first]
    assert one.same_as is not None
    whole = d.mentions[one.same_as]
    at = whole.at.narrowed(one.at).narrowed(place.at)
    if not any(fore for fore, _ in at.places):
        at = at.narrowed(Position(places=(FRONT,)))
    d.change(one.same_as, at=at, placed=True)
    d.change(first, kind=None, same_as=None, of_them=False)
    return one.same_as


def queue_up(d: Discourse, ids: Ids, spacing: float | None) -> bool:
    """Put each of several single objects behind the one before it."""
    known = [d.mentions[one] for one in ids]
    if len(ids) < 2 or any(one.count != 1 or one.relation is not None or one.kind is None for one in known):
        return False
    for before, one in itertools.pairwise(ids):
        at = Position(distance=(spacing, spacing) if spacing else None)
        d.change(one, relation="behind", references=(before,), placed=True, at=at)
    return True


def attach(d: Discourse, number: int, place: Place, link: str) -> None:
    """Add a further place after "and", else a closer description of the same place."""
    mention = d.mentions[number]
    at = _fitting(place, mention)
    d.dropped |= place.tokens
    if at is None:
        return
    _note_unfit(d, place, at)
    if mention.weak:
        d.change(number, relation=None, references=())
        mention = d.mentions[number]
    if mention.at.lane and at.lane and mention.at.lane != at.lane and not mention.weak and link not in ("and", "or"):
        return  # a second lane
    if at.distance and mention.at.distance and ("beside" in {fore for fore, _ in (*at.places, *mention.at.places)}):
        return  # "10 m ahead and 3 m to the left"
    d.taken |= place.tokens
    if place.everywhere and mention.count == "some":
        d.change(number, count="many")
    if place.times > 1:
        count = place.times if mention.count == "some" else count_times(mention.count, place.times)
        d.change(number, count=count)
    if not mention.placed or mention.weak:
        if mention.weak and mention.at.sidewalk and at.only_places:
            at = replace(at, sidewalk=True)  # "a sidewalk with two people on the right"
        d.change(number, at=at if mention.weak else mention.at.narrowed(at), placed=True, weak=False)
    elif link in ("and", "or", ",") and not _goes_on(at, mention, link):
        if at.only_places and mention.at.only_places:
            d.change(number, at=mention.at.or_at(at))
        else:
            _add_elsewhere(d, number, at)
    elif (at.distance and _is_exact(mention.at)) or (at.spacing and mention.at.spacing):
        d.taken -= place.tokens  # a second length
    elif mention.at.narrowed(at) != mention.at or place.lanes or place.road:
        d.change(number, at=mention.at.narrowed(at))


def _is_exact(at: Position) -> bool:
    """Whether it gives one distance, not a range such as "far ahead"."""
    return at.distance is not None and at.distance[0] == at.distance[1]


def _add_elsewhere(d: Discourse, number: int, at: Position) -> None:
    """More of the same at another place; with two distances, several objects are one at each."""
    mention = d.mentions[number]
    if at.distance and mention.at.distance and mention.count != 1:
        whole = mention.same_as if mention.same_as is not None else number
        of_them = mention.count != "some"
        other = replace(mention, count=1, at=at, same_as=whole, of_them=of_them)
        if mention.count == "some":
            d.change(number, count=1)
        rest = replace(at, distance=None)
        d.add(other)
        for n, one in enumerate(d.mentions):
            if n == number or one.same_as == whole:
                d.change(n, at=rest.narrowed(one.at) if rest.agrees(replace(one.at, distance=None)) else one.at)
        return
    d.add(replace(mention, at=at))


def _goes_on(at: Position, mention: Mention, link: str) -> bool:
    """Whether a place after a comma refines the previous one, as in "on the left, 20 m away"."""
    if at == Position(spacing=at.spacing):
        return True  # "and there is a gap of 1 m between them"
    closer = mention.count == 1 or not (at.only_places and mention.at.only_places)
    second = link == "," and mention.count == 1 and bool(at.distance and mention.at.distance)
    return (link == "," and closer and at.agrees(mention.at)) or second


def place_at(d: Discourse, number: int, place: Place, weak: bool = False) -> None:
    """Put a mention at a place; the next one overrides it if it is weak."""
    mention = d.mentions[number]
    if mention.kind is None:
        d.change(number, at=mention.at.narrowed(place.at), placed=True)
        return
    at = _fitting(place, mention)
    d.dropped |= place.tokens
    if at is not None:
        d.taken |= place.tokens
        _note_unfit(d, place, at)
        d.change(number, at=mention.at.narrowed(at), placed=True, weak=weak)


def _note_unfit(d: Discourse, place: Place, at: Position) -> None:
    """A wall on the right sidewalk is on the right; the sidewalk is reported."""
    if place.at.sidewalk and not (at.sidewalk or at.beside_road):
        d.unfit |= place.tokens


def _fitting(place: Place, mention: Mention) -> Position | None:
    """The position of a place, None if its kind does not fit there."""
    at, kind = place.at, mention.record
    if place.crosswalk and not kind.walks:
        return None
    if place.middle and (not kind.on_road or kind.follows_road):
        return None if at.at_junction or "median" not in kind.surfaces else Position(median=True)
    if at.from_road is not None and at.from_road[0] == 0.0 and kind.cycles:
        at = replace(at, from_road=None, places=at.places if at.sides else (RIGHT,))  # a rider close to the kerb
    if at.beside_road and kind.walks and not (at.sidewalk or at.from_road):
        at = replace(at, beside_road=False, from_road=_VERGE)  # somebody at the side of the road
    if place.centre and kind.is_vehicle and "median" in kind.surfaces and not at.at_junction:  # a tram
        at = replace(at, on_road=False, median=True)
    if at.median and "median" not in kind.surfaces:
        return None
    if at.sidewalk and "sidewalk" not in kind.surfaces:
        return None if at == Position(sidewalk=True) else replace(at, sidewalk=False)
    if at.lane and "road" not in kind.surfaces:
        return None
    if (at.from_road or at.from_sidewalk) and mention.references:
        return None
    if place.shoulder and not mention.at.sides and not at.sides:
        at = replace(at, places=(RIGHT,))
    return at


def note_place(d: Discourse, place: Place) -> None:
    """Note the road implied by a place, as "in each of the three lanes" or "at the corner of the crossroads"."""
    if place.road is not None and (d.road.kind in (None, "straight") or place.road in ("left-bend", "right-bend")):
        d.road = replace(d.road, kind=place.road if place.road != "straight" else d.road.kind)
    if place.at.lane == "each" and not d.road.lanes and place.lanes:
        d.road = replace(d.road, lanes=place.lanes)


def with_side(d: Discourse, place: Place) -> Place:
    """A place with its side for "the other side" and for "the outer side" of a bend."""
    if place.other_side:
        sides = [side for mention in d.mentions for side in mention.at.sides]
        side = RIGHT if sides[-1:] == ["left"] else LEFT
        return replace(place, at=place.at.narrowed(Position(places=(side,))))
    if not place.bend_side:
        return place
    inner = {"left-bend": "left", "right-bend": "right"}.get(str(d.road.kind), d.inner_side)
    if inner is None:
        if d.road.kind != "bend":
            return place
        d.road, inner = replace(d.road, kind="right-bend"), "right"
    side_name = inner if place.bend_side == "inner" else {"left": "right", "right": "left"}[inner]
    return replace(place, at=place.at.narrowed(Position(places=(("", side_name),))))


def describe(d: Discourse, number: int, manner: Manner) -> None:
    """Note the motion, state and size of objects."""
    mention = d.mentions[number]
    if mention.kind is None:
        return
    if manner.heading == "both":
        if mention.record.drives:
            _both_ways(d, number)
        return
    if manner.cycling and mention.kind == "person":
        d.change(number, kind="bicycle", ridden=False)
    mention = d.mentions[number]
    manner = fitting_manner(manner, mention)
    if str(mention.heading).startswith("turning") and manner.heading == "across":
        manner = replace(manner, heading=None)  # "turns left across our lane"
    stays = mention.heading == "parked" and (manner.facing or str(manner.heading).startswith("across"))
    heading = mention.heading if stays else manner.heading or mention.heading
    at, size, scale = mention.at, manner.size, manner.scale
    if manner.length is not None:
        size = _sized(mention, manner)
        scale = tuple(1.0 if one is None else 1.0 / a for one, a in zip(size, mention.scale, strict=True))  # type: ignore[assignment]
    if manner.road is not None:
        d.road = replace(d.road, kind=manner.road)
    d.change(
        number,
        heading=heading,
        queue=mention.queue or manner.queue,
        abreast=mention.abreast or manner.abreast,
        on_road=mention.on_road or manner.on_the_road,
        at=replace(at, at_junction=at.at_junction or manner.at_junction),
        placed=mention.placed or manner.at_junction,
        motion=manner.motion or mention.motion,
        speed=mention.speed if manner.speed is None else manner.speed,
        paint=manner.paint or mention.paint,
        moves=mention.moves or manner.moves,
        size=tuple(new if new is not None else old for new, old in zip(size, mention.size, strict=True)),
        scale=tuple(a * b for a, b in zip(mention.scale, scale, strict=True)),
    )


def _both_ways(d: Discourse, number: int) -> None:
    """Half of the traffic in both directions is oncoming."""
    mention = d.mentions[number]
    half = mention.count // 2 if isinstance(mention.count, int) and mention.count > 1 else 0
    rest: Count = mention.count - half if half and isinstance(mention.count, int) else mention.count
    d.change(number, heading="with", count=rest)
    d.add(replace(d.mentions[number], heading="against", count=half or mention.count))


def _sized(mention: Mention, manner: Manner) -> tuple[float | None, float | None, float | None]:
    """The size given by "of 3 m": the height of a fence up to its usual height, else its length."""
    length, kind = manner.length or 0.0, mention.record
    tall = mention.scale[2] != 1.0 and mention.scale[0] == 1.0
    long = mention.scale[0] > 1.0 and mention.scale[2] == 1.0
    long = long or (kind.follows_road and kind.sizes is not None and length > kind.sizes.largest[2])
    return (length, None, None) if long and not tall else (None, None, length)
