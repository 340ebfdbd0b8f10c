"""The mention of a noun phrase or a pronoun: a new one, or one that was named before."""

from __future__ import annotations

from dataclasses import replace

from lidardraft.drafting.text.mentions import JUNCTIONS, Discourse, Ids, mention_of
from lidardraft.drafting.text.places import describe, place_at
from lidardraft.drafting.text.tree import Item, NounPhrase, Place, Relation


def meant_by(d: Discourse, phrase: NounPhrase) -> Ids:
    """The referents of a pronoun: "them" are several, "it" is one."""
    wanted = [n for n, one in enumerate(d.mentions) if one.is_wanted]
    numbers = [n for n in wanted if d.mentions[n].with_it is None] or wanted
    if phrase.pronoun == "them":
        fitting = [n for n in numbers if d.mentions[n].count != 1] or [n for n in wanted if d.mentions[n].count != 1]
    else:
        fitting = [n for n in numbers if d.mentions[n].count in (1, "many", "few")]
        people = [n for n in fitting if d.mentions[n].record.walks or d.mentions[n].record.cycles]
        others = [n for n in fitting if d.mentions[n].kind != "person"]
        fitting = (people if phrase.of_person else others) or ([] if d.road.kind in JUNCTIONS else fitting)
    found = (fitting or numbers)[-1:]
    for subject in fitting[:-1]:  # "a car behind a truck, a man next to it": the car
        other, one = d.mentions[found[-1]], d.mentions[subject]
        named = other.placed or other.described
        if (
            found[-1] == subject + 1
            and subject + 1 in one.references
            and (not named or (one.record.drives and not other.record.drives))
        ):
            found = [subject]
    if phrase.pronoun == "it" and d.it in fitting:
        found = [d.it]
    if phrase.pronoun == "it" and found:
        d.it = found[0]
    return found


def _meant_but(d: Discourse, phrase: NounPhrase, subjects: Ids) -> Ids:
    """The referents of a pronoun, without the subjects."""
    siblings = [d.mentions[one].same_as for one in subjects[-1:] if d.mentions[one].same_as is not None]
    hidden = [*subjects, *(one for one in siblings if one is not None and d.mentions[one].references)]
    kept = [d.mentions[one] for one in hidden]
    for one in hidden:
        d.mentions[one] = replace(d.mentions[one], kind=None)
    found = meant_by(d, phrase)
    for one, mention in zip(hidden, kept, strict=True):
        d.mentions[one] = mention
    return found


def known_mention(d: Discourse, phrase: NounPhrase, subjects: Ids) -> int | None:
    """The last mention that "the bus" or "bus A" can mean; None if it must be another object."""
    if phrase.name:
        return next((n for n, one in enumerate(d.mentions) if (one.kind, one.name) == (phrase.kind, phrase.name)), None)
    if (
        not phrase.definite
        or (phrase.exact and not phrase.each)
        or phrase.count == 0
        or phrase.all
        or phrase.rest
        or phrase.manner.heading
    ):
        return None
    for number in range(len(d.mentions) - 1, -1, -1):
        one = d.mentions[number]
        if not one.is_wanted or number in subjects:
            continue
        if phrase.owned and not (number == len(d.mentions) - 1 and one.record.cycles):
            continue  # "a cyclist pushes his bike", but "a shepherd and his dog"
        if one.kind == phrase.kind == "person" and not phrase.anybody and phrase.noun != one.noun:
            continue  # "a man lies there; the driver stands beside him"
        if one.kind == phrase.kind or (phrase.kind == "vehicle" and one.record.is_vehicle and not phrase.traffic):
            return number
    return None


def can_be_where(d: Discourse, number: int, item: Item) -> bool:
    """Whether a mention can be at the place of a later one."""
    places = [one.said.at for one in item.modifiers[:1] if isinstance(one.said, Place)]
    return all(d.mentions[number].at.agrees(replace(at, distance=None)) for at in places)


def call(d: Discourse, phrase: NounPhrase, before: Ids) -> Ids:
    """Change objects to the kind that they are called: "one of them is a taxi"."""
    for one in before:
        if not d.mentions[one].is_wanted:
            continue
        d.change(one, kind=phrase.kind)
        describe(d, one, phrase.manner)
    return before


def targets_of(d: Discourse, relation: Relation, subjects: Ids) -> Ids:
    """The target mentions of a relation; empty if one of them is unknown."""
    found: Ids = []
    for phrase in relation.targets:
        found += _target(d, phrase, subjects)
    if relation.relation == "between" and len(relation.targets) == 1 and relation.targets[0].pronoun == "them":
        found = _two_of_them(d, found, subjects)
    if relation.target_place is not None and found and not d.mentions[found[0]].placed:
        place_at(d, found[0], relation.target_place)
    return found


def _two_of_them(d: Discourse, found: Ids, subjects: Ids) -> Ids:
    """The two that an object is between: the last two single ones, or the last two vehicles if it drives."""
    drives = any(d.mentions[one].is_wanted and d.mentions[one].record.drives for one in subjects)
    others = [n for n, one in enumerate(d.mentions) if one.is_wanted and n not in subjects]
    fitting = [n for n in others if d.mentions[n].record.drives] if drives else others
    if found and d.mentions[found[0]].count != 1 and found[0] in fitting:
        return found
    single = [n for n in fitting if d.mentions[n].count == 1][-2:]
    return single if len(single) == 2 else [one for one in found if d.mentions[one].count != 1]


def _target(d: Discourse, phrase: NounPhrase, subjects: Ids) -> Ids:
    if phrase.kind is None or phrase.pronoun in ("us", "road", "junction"):
        return []
    if phrase.pronoun:
        found = _meant_but(d, phrase, subjects)
        for subject in subjects if phrase.each else []:
            if found and d.mentions[subject].is_wanted:
                d.change(subject, host=found[0])
        return found
    if phrase.kind == "":
        whole = d.several()
        counted = phrase.exact and phrase.ordinal is None and not phrase.of_them
        if whole is None or whole in subjects or (counted and d.mentions[whole].count != phrase.count):
            return []
        for subject in subjects if phrase.each else []:
            d.change(subject, host=whole)
        return [whole]
    if phrase.ordinal is not None and (phrase.definite or not phrase.another):
        whole = d.several(phrase.kind)
        if whole is not None:
            return [] if any(one.same_as == whole for one in d.mentions) else [whole]
    if is_car_of_ego(d, phrase):
        return []
    bare = not phrase.plural and phrase.count == 1 and len(phrase.tokens) == 1
    known = known_mention(d, replace(phrase, definite=True) if bare else phrase, subjects[-1:])
    if known is None:
        known = d.add(replace(mention_of(phrase), count="some" if phrase.each and phrase.count == 1 else phrase.count))
    for subject in subjects if phrase.each else []:
        if d.mentions[subject].is_wanted:
            d.change(subject, host=known)
    return [known]


def is_car_of_ego(d: Discourse, phrase: NounPhrase) -> bool:
    """Whether "the car" can only be that of the ego: no other was named."""
    vehicles = any(one.kind is not None and one.record.is_vehicle for one in d.mentions)
    return phrase.plain and phrase.definite and phrase.count == 1 and len(phrase.tokens) == 2 and not vehicles
