"""Statements on the road, and on the ego vehicle."""

from __future__ import annotations

from dataclasses import replace

from lidardraft.drafting.text.mentions import JUNCTIONS, Discourse, Ids
from lidardraft.drafting.text.places import attach, note_place, place_at
from lidardraft.drafting.text.positions import BEHIND, BESIDE, FRONT, LEFT, RIGHT, Position
from lidardraft.drafting.text.references import targets_of
from lidardraft.drafting.text.tree import Item, Manner, NounPhrase, Place, Relation, Street

_FROM_THE_EGO = {  # the place of an object that the ego is behind, in front of, ...
    "behind": FRONT,
    "in-front-of": BEHIND,
    "beside": BESIDE,
    "left-of": RIGHT,
    "right-of": LEFT,
}


def note_street(d: Discourse, street: Street) -> None:
    """Note a statement on the road."""
    if street.denied:
        return
    notes = d.road
    kind = notes.kind
    bend = kind in ("bend", "right-bend", "left-bend") and str(street.kind).endswith("-bend")
    second = kind not in (None, "straight", street.kind) and street.kind not in (None, "straight") and not bend
    if street.kind is not None and (street.kind != "straight" or kind is None) and not second:
        kind = street.kind
    lanes, oncoming = notes.lanes, notes.oncoming_lanes
    for count in street.lanes:
        if lanes and notes.each_way and count != lanes:
            oncoming = count
        elif lanes and street.each_way:
            lanes = count
        lanes = lanes or count
    d.road = replace(
        notes,
        kind=kind,
        lanes=lanes,
        oncoming_lanes=oncoming,
        usual_lanes=street.usual_lanes or notes.usual_lanes,
        each_way=notes.each_way or street.each_way,
        one_way=notes.one_way or street.one_way,
        sidewalk=street.sidewalk if street.sidewalk is not None else notes.sidewalk,
        settings=notes.settings | street.settings,
    )


def note_junction(d: Discourse, place: Place) -> bool:
    """Whether a place at a distance is the junction's, as in "a crossroads 30 m ahead"."""
    ahead = place.at == Position(place.at.places, distance=place.at.distance) and not place.at.sides
    if d.road.kind not in JUNCTIONS or not place.at.distance or not ahead or place.at.places == (BEHIND,):
        return False
    d.road = replace(d.road, junction=place.at.distance)
    return True


def with_direction(item: Item) -> Street:
    """Lanes with their stated direction: "one lane in the other direction"."""
    street = item.head
    assert isinstance(street, Street)
    ways = [
        one.said for one in item.modifiers if isinstance(one.said, Manner) and one.said.heading in ("with", "against")
    ]
    if not ways or not street.lanes:
        return street
    return replace(street, each_way=True)


def say_of_road(d: Discourse, item: Item) -> None:
    """Note a bend named after the road: "a road that turns left", "a curved street (to the left)"."""
    for modifier in item.modifiers:
        said = modifier.said
        if isinstance(said, Manner) and said.heading and said.heading.startswith("turning"):
            side = said.heading.partition("-")[2]
            d.road = replace(d.road, kind=f"{side}-bend" if side else "bend")
        elif (
            isinstance(said, Place) and said.at == Position(said.at.places) and said.at.sides and d.road.kind == "bend"
        ):
            d.road = replace(d.road, kind=f"{said.at.sides[0]}-bend")
        elif isinstance(said, Place) and said.at.distance:
            note_junction(d, said)
        elif isinstance(said, Relation) and said.relation == "between" and len(said.targets) == 1:
            for one in targets_of(d, said, []):
                at = Position((LEFT, RIGHT), both_sides=True, shared=isinstance(d.mentions[one].count, int))
                place_at(d, one, Place(at))  # "an alley between houses"
        elif isinstance(said, Relation) and not any(phrase.traffic for phrase in said.targets):
            targets_of(d, said, [])  # "a street in front of a school", but not "at rush hour"
        elif isinstance(said, Street):
            note_street(d, said)


def on_street(d: Discourse, ids: Ids, street: Street) -> None:
    """ "On the street", "at the junction"."""
    note_street(d, street)
    for one in ids:
        mention = d.mentions[one]
        if mention.kind is None:
            continue
        if street.kind in JUNCTIONS:
            if mention.heading == "against":
                d.change(one, heading=None)  # it approaches the junction
            at = replace(mention.at, at_junction=not mention.record.at_junction)
            d.change(one, at=at, placed=True)
        elif street.kind is not None or street.on:
            on_foot = mention.record.on_road and not mention.record.drives
            d.change(one, on_road=mention.on_road or on_foot or not mention.placed)


def say_of_ego(d: Discourse, item: Item) -> None:
    """ "We are in the middle lane", "we are behind a truck"."""
    phrase = item.head
    assert isinstance(phrase, NounPhrase)
    placed: Ids = []
    for modifier in item.modifiers:
        said = modifier.said
        if isinstance(said, Place):
            note_place(d, said)
        if isinstance(said, Place) and said.middle and not placed and d.road.lanes > 1:
            d.road = replace(d.road, ego_lane="middle")
        elif (
            isinstance(said, Place)
            and said.at.lane in ("left", "middle", "right")
            and said.at == Position(lane=said.at.lane)
            and not placed
        ):
            d.road = replace(d.road, ego_lane=said.at.lane)
        elif isinstance(said, Place):
            for one in placed:
                attach(d, one, said, modifier.link)
        elif isinstance(said, Relation) and said.relation is not None:
            placed = targets_of(d, said, [])
            if said.overtakes and not said.followed:
                d.road = replace(d.road, ego_motion="overtakes")
            for one in placed if said.overtakes and said.followed else []:
                d.change(one, motion="overtakes")
            where = BEHIND if said.followed else _FROM_THE_EGO.get(said.relation)
            where = FRONT if said.at_it and where is None else where  # "we wait at a traffic light"
            for one in placed if where is not None else []:
                if not d.mentions[one].placed:
                    place_at(d, one, Place(Position(places=(where,)).narrowed(said.at)))  # type: ignore[arg-type]
        elif isinstance(said, Manner):
            speed = 0.0 if said.heading == "parked" else d.road.ego_speed if said.speed is None else said.speed
            d.road = replace(d.road, ego_motion=said.motion or d.road.ego_motion, ego_speed=speed)
        elif isinstance(said, Street):
            note_street(d, said)
    if placed:
        d.latest = placed
