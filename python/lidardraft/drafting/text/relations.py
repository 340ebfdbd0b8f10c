"""Objects placed relative to others: to another mention, to the ego or to the road."""

from __future__ import annotations

from dataclasses import replace

from lidardraft.drafting.text.mentions import JUNCTIONS, Discourse, Ids
from lidardraft.drafting.text.places import describe, place_at
from lidardraft.drafting.text.positions import LEFT, RIGHT, Position
from lidardraft.drafting.text.references import is_car_of_ego
from lidardraft.drafting.text.tree import Manner, Place, Relation

TURNED = {"behind": "in-front-of", "in-front-of": "behind"}


def relate(d: Discourse, ids: Ids, said: Relation, references: Ids) -> Ids:
    """Place objects relative to others; returns the new references, or else the objects, for the next words."""
    subjects = [
        one
        for one in ids
        if d.mentions[one].kind is not None and not any(d.depends(other, one) for other in references)
    ]
    pronouns = [phrase.pronoun for phrase in said.targets]
    if said.relation == "rides":
        _ride(d, ids, said, references)
        return ids
    if ("us" in pronouns and len(pronouns) == 1) or (
        len(said.targets) == 1 and not references and is_car_of_ego(d, said.targets[0])
    ):
        return _relate_to_ego(d, ids, said)
    if said.overtakes and not references:
        return ids
    if pronouns == ["it"] and not references and said.relation in ("left-of", "right-of"):
        side = LEFT if said.relation == "left-of" else RIGHT
        return _relate_to_ego(d, ids, replace(said, ego_at=Position((side,))))
    on_ring = d.road.kind == "roundabout" and said.at_it and all(d.mentions[one].record.drives for one in subjects)
    if pronouns == ["it"] and on_ring:
        return _relate_to_junction(d, ids)  # "a roundabout with a car coming and a motorcycle on it"
    if pronouns == ["it"] and not references and said.at_it and "median" in d.road.settings:
        for one in subjects:
            place_at(d, one, Place(Position(median=True)))
        return ids
    if pronouns == ["it"] and not references and (d.road.kind is not None or (said.at_it and d.last_lead)):
        return _relate_to_junction(d, ids)
    if pronouns == ["junction"]:
        for one in subjects:
            d.change(one, at=replace(d.mentions[one].at, at_junction=True), placed=True)
        d.road = replace(d.road, kind=d.road.kind if d.road.kind in JUNCTIONS else "crossroads")
        return ids
    if "road" in pronouns or ("us" in pronouns and len(pronouns) == 2):
        return _relate_to_road(d, subjects, said, references, "us" in pronouns)
    unknown = [one for one in ids if d.mentions[one].kind is None]
    if unknown and len(unknown) == len(ids):
        return [one for one in references if not d.mentions[one].placed] or ids
    if not references or said.relation is None or not subjects or len(references) < len(said.targets):
        return ids
    if said.followed:
        subjects, references = references, subjects[-1:]
    if said.at_it and _stand_at(d, subjects, references):
        return references
    sides = [
        phrase.at
        for phrase in said.targets
        if phrase.at is not None and phrase.at.sides and d.mentions[references[0]].at.both_sides
    ]
    for one in subjects if sides else []:
        place_at(d, one, Place(sides[0]))
    named = not any(pronouns)  # "a car behind it waits": the car
    new = [one for one in references if named and not d.mentions[one].placed and not d.mentions[one].references]
    for one in subjects:
        _relate_one(d, one, said, references)
    return new if new and new[-1] == references[-1] and not said.followed else subjects


def _relate_one(d: Discourse, number: int, said: Relation, references: Ids) -> None:
    mention, relation = d.mentions[number], said.relation
    if mention.relation is not None and not mention.weak:
        first = d.mentions[references[0]]
        free = len(references) == 1 and first.relation is None and not first.placed
        if free and relation in ("near", "beside", "opposite"):  # a bench under a tree, opposite a house
            d.change(references[0], relation=relation, references=(number,), placed=True)
        return
    before = mention.at if mention.placed and not mention.weak else Position(heading=mention.at.heading)
    if before.distance and said.at.distance is None:
        if _turn_round(d, number, relation, references):
            return
        other = d.mentions[references[0]]
        if not other.placed and not other.references:
            d.change(references[0], at=Position(before.places, distance=before.distance))
        else:
            return
        before = replace(before, distance=None)
    if before.from_road or before.from_sidewalk:
        return
    at = before.narrowed(said.at)
    first = d.mentions[references[0]]
    parked = "parked" in (mention.heading, at.heading) and at.sides and relation in TURNED
    if parked and first.record.is_vehicle and not first.placed and first.heading is None:
        d.change(references[0], at=Position(at.places), heading="parked", placed=True)  # at the same place
    motion = d.mentions[number].motion
    if said.overtakes and mention.record.walks:
        relation = "near"  # "walks past a row of cars"
    elif said.overtakes and d.mentions[references[0]].record.walks:
        relation, at = "beside", replace(at, heading="with")
    elif said.overtakes:
        at, motion = replace(at, heading="with"), "overtakes"
    d.change(number, relation=relation, references=tuple(references), at=at, placed=True, weak=False, motion=motion)


def _turn_round(d: Discourse, number: int, relation: str | None, references: Ids) -> bool:
    """An object at a distance behind an unplaced one: that one is in front of it."""
    turned = TURNED.get(str(relation))
    other = d.mentions[references[0]]
    drive = all(d.mentions[one].record.drives for one in (number, *references))
    if turned is None or not drive or len(references) > 1 or other.placed or other.references:
        return False
    d.change(references[0], relation=turned, references=(number,), placed=True)
    return True


def _relate_to_ego(d: Discourse, ids: Ids, said: Relation) -> Ids:
    """ "A car follows us", "a van overtakes us"."""
    for one in ids:
        if said.overtakes:
            describe(d, one, Manner(motion="overtakes"))
        elif said.ego_at is not None:
            place_at(d, one, Place(said.ego_at.narrowed(said.at)))
    return ids


def _relate_to_road(d: Discourse, subjects: Ids, said: Relation, references: Ids, ego: bool) -> Ids:
    """ "Between the trees and the road" is in front of the trees, "between us and the bus" behind the bus."""
    if len(said.targets) == 2 and said.relation == "between" and references:
        drives = d.mentions[references[0]].record.drives
        parked = d.mentions[references[0]].heading == "parked"
        relation = "behind" if ego else "beside" if drives and parked else "right-of" if drives else "in-front-of"
        if said.targets[0].pronoun == "road" and not drives:
            relation = "in-front-of"
        return relate(
            d,
            subjects,
            Relation(
                relation,
                (said.targets[0],) if not said.targets[0].pronoun else (said.targets[1],),
                said.at,
            ),
            references,
        )
    if said.ego_at is not None and said.relation in ("beside", "near"):
        for one in subjects:
            place_at(d, one, Place(Position(beside_road=True)))
    return subjects


def _relate_to_junction(d: Discourse, ids: Ids) -> Ids:
    """ "It" is the road if nothing else was named: "a roundabout with houses around it"."""
    for one in ids:
        if d.mentions[one].kind is None:
            continue
        if d.road.kind in JUNCTIONS:
            d.change(one, at=replace(d.mentions[one].at, at_junction=True), placed=True)
    return ids


def _ride(d: Discourse, ids: Ids, said: Relation, references: Ids) -> None:
    """ "A man on a bicycle" is a bicycle with its rider."""
    for one in ids:
        target = said.targets[0]
        rider = references and one not in references and d.mentions[one].kind is not None
        if not rider or not (d.mentions[one].record.walks or d.mentions[one].kind == target.kind):
            continue
        last = len(d.mentions) - 1
        if references[0] == last and d.mentions[last].tokens == target.tokens:  # it was named for its rider alone
            d.mentions.pop()
        d.change(one, kind=target.kind, ridden=True, host=None)


def _stand_at(d: Discourse, subjects: Ids, references: Ids) -> bool:
    """A free reference at a queue, or at an object placed already, is near to it."""
    queues = [one for one in subjects if d.mentions[one].queue or d.mentions[one].relation is not None]
    free = d.mentions[references[0]]
    if not queues or free.placed or free.references:
        return False
    d.change(references[0], relation="near", references=tuple(queues), placed=True)
    for one in queues if free.kind == "traffic-light" else []:
        d.change(one, speed=0.0)
    return True


def is_side_of(d: Discourse, relation: Relation, place: Place, ids: Ids) -> bool:
    """ "Next to it on the left", "passes it on the right": the side is that of the other one."""
    sides = place.at.sides
    known = len(ids) == 1 and d.mentions[ids[0]].relation == relation.relation in ("beside", "left-of")
    if (
        not known
        or len(sides) != 1
        or place.at != Position(place.at.places)
        or not (relation.overtakes or relation.targets[0].pronoun)
    ):
        return False
    d.change(ids[0], relation=f"{sides[0]}-of")
    return True


def relate_another(d: Discourse, number: int, said: Relation, references: Ids, before: int) -> None:
    """ "Behind it a truck and two cars": vehicles are one behind the other, other objects at the same reference."""
    if any(phrase.each for phrase in said.targets) and references:
        d.change(number, host=references[0])
    known = d.mentions[number].is_wanted and d.mentions[before].is_wanted
    row = known and all(d.mentions[one].record.drives for one in (number, before)) and said.relation in TURNED
    relate(d, [number], said, [before] if row else references)
