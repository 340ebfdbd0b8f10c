"""Negation and exception: objects that are denied, left out, or only somewhere else."""

from __future__ import annotations

from dataclasses import replace

from lidardraft.drafting.text.mentions import Discourse, Ids, Mention, mention_of
from lidardraft.drafting.text.positions import NOWHERE, Position
from lidardraft.drafting.text.tree import Clause, NounPhrase, Place


def leave_out(d: Discourse, phrase: NounPhrase, before: Ids, told: bool, verb: bool) -> Ids:
    """ "Except a bus": only it, of denied objects; else it is left out of the wanted ones."""
    last = before[-1]
    source = d.mentions[last]
    if phrase.kind:
        wanted = source.count != 0 and not (told and phrase.kind == source.kind)
        made = replace(mention_of(phrase), count=0 if wanted else phrase.count or "some")
        return [d.add(made)]
    if told and source.count == 1:
        return []
    if told:
        kept = source.heading if source.heading == "parked" else None
        made = mention_of(replace(phrase, kind=source.kind))
        return [d.add(replace(made, heading=kept, same_as=last, of_them=True))]
    hosted = next((n for n, one in enumerate(d.mentions) if one.host is not None and last in (n, one.host)), None)
    if hosted is not None and isinstance(phrase.count, int):
        d.change(hosted, left_out=phrase.count)
    elif isinstance(phrase.count, int) and isinstance(source.count, int) and source.count > phrase.count:
        d.change(last, count=source.count - phrase.count)
        if source.heading is not None or verb:
            heading = "with" if source.at.both_sides or source.at.beside_road else None
            d.add(replace(source, count=phrase.count, heading=heading))
    return []


def leave_out_place(d: Discourse, ids: Ids, place: Place) -> None:
    """All objects except those at a place; only those, if the objects are denied."""
    if place.at != Position(
        place.at.places, both_sides=place.at.both_sides, shared=place.at.shared
    ) or place.at.places == (NOWHERE,):
        return
    for one in ids[-1:]:
        mention = d.mentions[one]
        if mention.kind is None:
            return
        if mention.count == 0:
            d.change(one, count="some", at=place.at, placed=True)
        else:
            d.mentions[one] = keep_away(mention, place.at)


def all_but_some(d: Discourse, phrase: NounPhrase, whole: int | None) -> Ids:
    """ "All but two": a part with that many fewer."""
    count = d.mentions[whole].count if whole is not None else None
    if whole is None or not isinstance(count, int) or count <= phrase.all_but:
        return []
    made = Mention(d.mentions[whole].kind, count - phrase.all_but, same_as=whole, of_them=True)
    return [d.add(made)]


def is_denied(d: Discourse, clause: Clause, number: int) -> bool:
    """Whether a denied list continues: "no cars or trucks", "without cars and buses"; not "no cars and a bus"."""
    link, phrase = clause.items[number].link, clause.items[number].head
    before = clause.items[number - 1].head if number else None
    if not isinstance(before, NounPhrase) or not isinstance(phrase, NounPhrase) or clause.items[number - 1].modifiers:
        return False
    denied = before.count == 0 or (number > 1 and is_denied(d, clause, number - 1))
    shared = phrase.determiners < before.determiners  # the "no", so "without a car and a bus" has neither
    return denied and (link == "or" or (link == "and" and before.without and shared))


def keep_away(mention: Mention, no: Position) -> Mention:
    """A mention without some places: removed from its own places, else excluded from everywhere."""
    if mention.relation is None and any(place in mention.at.places for place in no.places):
        return replace(mention, at=mention.at.without(no))
    return replace(mention, not_at=(*mention.not_at, *(place for place in no.places if any(place))))
