"""The lead of a clause, as in "on the left" and "behind the bus", and the objects of the clause that it places."""

from __future__ import annotations

from dataclasses import replace

from lidardraft.drafting.text.mentions import Discourse, Ids
from lidardraft.drafting.text.places import describe, note_place, place_at, with_side
from lidardraft.drafting.text.positions import BEHIND, FRONT, Position
from lidardraft.drafting.text.references import targets_of
from lidardraft.drafting.text.relations import TURNED
from lidardraft.drafting.text.streets import note_street
from lidardraft.drafting.text.tree import Clause, Item, Manner, NounPhrase, Place, Relation, Street


def lead_of(d: Discourse, clause: Clause) -> tuple[Place | None, tuple[Relation, Ids] | None, list[Manner]]:
    """The place, the relation with its references and the manner that begin a clause."""
    place: Place | None = None
    relation: tuple[Relation, Ids] | None = None
    manner: list[Manner] = []
    which = False
    for modifier in clause.lead:
        said, which = modifier.said, which or modifier.link == "which"
        if isinstance(said, Place):
            note_place(d, said)
            said = with_side(d, said)
            if relation is not None and relation[1] and not d.mentions[relation[1][-1]].placed:
                place_at(d, relation[1][-1], said)
            else:
                at = place.at.narrowed(said.at) if place is not None else said.at
                place = replace(said, at=at)
        elif isinstance(said, Relation):
            relation = (said, targets_of(d, said, []))
        elif isinstance(said, Manner) and which and relation is not None and relation[1]:
            describe(d, relation[1][-1], said)
        elif isinstance(said, Manner):
            manner.append(said)
        else:
            note_street(d, said)
    return place, relation, manner


def holds_for(d: Discourse, lead: Place, item: Item, before: Ids) -> bool:
    """Whether the place that begins a clause also holds for an item after its first."""
    said = [one.said for one in item.modifiers]
    if item.link == ",":
        unknown = bool(before) and d.mentions[before[-1]].kind is None  # whose it was
        moves = any(isinstance(one, Manner) and one.heading for one in said)  # "on the right cars, a bus coming to us"
        moves = moves or (isinstance(item.head, NounPhrase) and item.head.manner.heading == "against")
        if unknown or moves or lead.at.lane == "each":
            return False
    if item.comma and any(isinstance(one, Place) for one in said):
        return False  # "to the right trees, and a lorry in the distance"
    return not any(isinstance(one, Street) and one.on for one in said)  # "on the right cars, and a ball on the road"


def area_of(clause: Clause, number: int) -> Place | None:
    """The place of an area without a road, which its contents share: "roadworks on the left with cones"."""
    street, after = clause.items[number].head, clause.items[number + 1 : number + 2]
    places = [one.said for one in clause.items[number].modifiers if isinstance(one.said, Place)]
    if not (isinstance(street, Street) and street.kind is None and after and after[0].link == "with"):
        return None
    at = Position(sidewalk=bool(street.sidewalk), median="median" in street.settings)
    return Place(places[0].at.narrowed(at)) if places else Place(at) if at != Position() else None


def place_in_area(
    d: Discourse, clause: Clause, number: int, named: tuple[Ids, Ids], around: Place | None
) -> Place | None:
    """The place of an area without a shape, which its contents share, as in "a park on the left with trees".

    `named` are the mentions before an item and its new ones; `around` is the area in which a list continues.
    """
    (before, new), item = named, clause.items[number]
    if before and item.link == "with" and number and isinstance(clause.items[number - 1].head, NounPhrase):
        area = d.mentions[before[-1]]
        around = Place(Position(area.at.places, area.at.distance)) if area.kind is None and area.placed else None
    elif item.link != "and":
        around = None
    own = [one.said for one in item.modifiers if isinstance(one.said, Place | Relation)]
    on_it = all(isinstance(said, Relation) and any(to.pronoun for to in said.targets) for said in own)
    for one in new if around is not None and on_it else []:
        place_at(d, one, around, weak=True)  # type: ignore[arg-type]
    return around


def follow(d: Discourse, number: int, before: int) -> None:
    """An object after "then" is further away at the same place; a vehicle is the next in the row."""
    one, other = d.mentions[number], d.mentions[before]
    at = Position(other.at.places)
    d.change(number, at=at, placed=at != Position(), weak=True, heading=one.heading or other.heading)
    if not (one.is_wanted and other.is_wanted and one.record.drives and other.record.drives):
        return
    whole = d.mentions[other.same_as] if other.same_as is not None else other
    relation = other.relation if other.relation in TURNED else None
    relation = "behind" if whole.heading == "against" or other.at.places == (BEHIND,) else relation
    relation = "in-front-of" if relation is None and other.at.places == (FRONT,) else relation
    if relation is not None and not one.references:
        d.change(number, relation=relation, references=(before,), at=Position(), placed=True, weak=False)
