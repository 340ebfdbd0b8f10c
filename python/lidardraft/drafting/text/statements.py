"""Clauses become mentions: each states properties of objects, new ones and those named before."""

from __future__ import annotations

import itertools
from dataclasses import replace

from lidardraft.drafting.text.coordination import spread
from lidardraft.drafting.text.exceptions import is_denied, leave_out
from lidardraft.drafting.text.leads import area_of, follow, holds_for, lead_of, place_in_area
from lidardraft.drafting.text.mentions import COMPANIONS, Discourse, Ids, Mention, mention_of
from lidardraft.drafting.text.parts import kept_with
from lidardraft.drafting.text.places import attach, describe, place_at, queue_up, say_place, with_side
from lidardraft.drafting.text.portions import counted_later, named_part
from lidardraft.drafting.text.positions import NOWHERE, Position
from lidardraft.drafting.text.references import call, can_be_where, known_mention, meant_by, targets_of
from lidardraft.drafting.text.relations import is_side_of, relate, relate_another
from lidardraft.drafting.text.streets import (
    note_junction,
    note_street,
    on_street,
    say_of_ego,
    say_of_road,
    with_direction,
)
from lidardraft.drafting.text.tree import (
    NO_SCALE,
    Clause,
    Item,
    Manner,
    Modifier,
    NounPhrase,
    Place,
    Relation,
    Street,
)


def read(d: Discourse, clause: Clause) -> None:
    """Note all statements of a clause."""
    if clause.begins:
        d.each, d.earlier, d.sentence = None, d.sentence, len(d.mentions)
        d.last_lead = d.it = None
    if not clause.items:
        _say_of_latest(d, clause)
        return
    lead, relation, manner = lead_of(d, clause)
    if lead is None and relation is not None and clause.link and d.last_lead is not None:
        lead = d.last_lead
    d.last_lead = lead
    named: list[Ids] = []
    related: tuple[Relation, Ids, int] | None = None
    around: Place | None = None
    for number, item in enumerate(clause.items):
        before = next((ids for ids in reversed(named) if ids), [])
        if lead is not None and number and not holds_for(d, lead, item, before):
            lead = None
        if isinstance(item.head, Street):
            note_street(d, with_direction(item))
            named.append([])
            say_of_road(d, item)
            lead = area_of(clause, number) or (None if number and item.link == "," else lead)
            continue
        own = [one for one in item.modifiers if isinstance(one.said, Place | Relation)]
        if item.link == "with" and named and named[-1]:
            before = _whose(d, clause.items[number - 1], item, named[-1])
        ids = _subject(d, clause, number, before, bool(lead) or _is_told(item))
        if ids is None:
            say_of_ego(d, item)
            named.append([])
            continue
        new = [one for one in ids if one >= d.count_before]
        if lead is not None:
            _place_first(d, clause, number, new, lead, weak=bool(own))
        for one, way in itertools.product(new, manner):
            describe(d, one, way)
        around = place_in_area(d, clause, number, (before, new), around)
        link = clause.items[number].link
        if relation is not None and ids:
            if relation[0].at.distance is None or not any(d.mentions[one].at.distance for one in ids):
                relate(d, ids, relation[0], relation[1])
            for one in ids if any(phrase.each for phrase in relation[0].targets) and relation[1] else []:
                d.change(one, host=relation[1][0])
            related, relation = (relation[0], relation[1], ids[-1]), None
        elif related is not None and link == "and" and new and not own:
            relate_another(d, new[0], *related)
            related = (related[0], related[1], new[0])
        elif link == "and" and new and not item.modifiers and _is_ego_named(clause.items[number - 1]) and d.latest:
            d.change(new[0], at=d.mentions[d.latest[-1]].at, placed=True, weak=True)  # "we are behind a bus and a van"
        elif link == "then" and new and not own and before:
            follow(d, new[0], before[-1])
        _fill_sidewalk(d, clause, number, new)
        named.append(ids)
        _modify(d, clause, number, named)
        if item.link not in ("except", "but"):
            _deny_once(d, new, item.head)
    d.latest = next((ids for ids in reversed(named) if ids), d.latest)


def _fill_sidewalk(d: Discourse, clause: Clause, number: int, new: Ids) -> None:
    """ "The sidewalks are full of people"."""
    item, before = clause.items[number], clause.items[number - 1].head if number else None
    if item.verb and not item.link and isinstance(before, Street) and before.sidewalk:
        for one in new:
            place_at(d, one, Place(Position(sidewalk=True)))


def _place_first(d: Discourse, clause: Clause, number: int, new: Ids, lead: Place, *, weak: bool) -> None:
    """Place the new objects of an item at the lead of the clause; weakly in a list, as an item may have its own
    place."""
    item = clause.items[number]
    one_of = bool(item.modifiers) and item.modifiers[0].verb == "one" and number > 0
    comes_along = item.link == "with" and isinstance(item.head, NounPhrase) and item.head.kind in COMPANIONS
    if one_of or comes_along:
        return
    for one in new:
        place_at(d, one, lead, weak=weak and any(other.link == "," for other in clause.items[1 : number + 1]))
        d.cover(one, lead.tokens)


def _is_traffic(item: Item) -> bool:
    return isinstance(item.head, NounPhrase) and item.head.traffic


def _is_told(item: Item) -> bool:
    """Whether an item itself has a modifier; not so in "one black and one white, on the left"."""
    said = [one for one in item.modifiers if not (isinstance(one.said, Manner) and one.said.is_idle)]
    elsewhere = item.link == "and" and isinstance(item.head, NounPhrase) and item.head.kind == ""
    return item.is_told or (bool(said) and not (elsewhere and said[0].link == ","))


def _deny_once(d: Discourse, new: Ids, phrase: NounPhrase) -> None:
    """Drop denials of wanted objects, unless they deny others: "no cars and three cars"."""
    for one in new:
        kind, denies = d.mentions[one].kind, d.mentions[one].count == 0
        others = [n for n, other in enumerate(d.mentions) if other.kind == kind and (other.count == 0) is not denies]
        for denial in [one] if denies and others and not phrase.another else [] if denies else others:
            if d.mentions[denial].denies_all:
                d.change(denial, kind=None)


def _say_of_latest(d: Discourse, clause: Clause) -> None:
    """A clause without objects describes those before it, as in "A bus! 20 m ahead!"."""
    known = [one for one in d.latest if d.mentions[one].is_wanted]
    if not known and any(isinstance(one.said, Manner) for one in clause.lead):
        say_of_ego(d, Item(NounPhrase("", pronoun="us"), modifiers=clause.lead))  # "stopped behind a van"
        return
    lead, relation, manner = lead_of(d, clause)
    for one in known if lead is not None else []:
        assert lead is not None
        attach(d, one, lead, "")
    for one, said in itertools.product(known, manner):
        describe(d, one, said)
    if relation is not None and known:
        relate(d, known, *relation)
    if lead is not None and lead.at.sidewalk and not known:
        d.road = replace(d.road, sidewalk=True)


def _subject(d: Discourse, clause: Clause, number: int, before: Ids, told: bool) -> Ids | None:
    """The mentions that an item of a clause is about, new ones or known ones; None for the observer."""
    item = clause.items[number]
    phrase = item.head
    assert isinstance(phrase, NounPhrase)
    d.count_before = len(d.mentions)
    if phrase.pronoun == "us":
        return None
    if phrase.pronoun:
        return meant_by(d, phrase)
    if phrase.kind is None:
        carried = (
            (item.link == "with" or phrase.without) and before and not any(d.mentions[one].placed for one in before)
        )
        return before if carried else [d.add(Mention(None, at=phrase.at or Position(), placed=phrase.at is not None))]
    if phrase.part == 0 or (number and item.verb and _is_ego_named(clause.items[number - 1])):
        return []
    if item.link == "except" and (before or d.latest):
        verb = bool(item.modifiers) and bool(item.modifiers[0].verb) and item.modifiers[0].link != "which"
        return leave_out(d, phrase, before or d.latest, told and not verb, verb)
    if (
        phrase.kind == ""
        or phrase.part is not None
        or ((phrase.rest or phrase.ordinal is not None) and d.several(phrase.kind) is not None)
    ):
        return named_part(d, clause, number, before, told)
    head = clause.items[number - 1].head if number else None
    aside = item.link == "," and isinstance(head, NounPhrase) and head.kind == "" and not phrase.definite
    aside = aside and (  # "another one, a taxi, waits behind it", "the one behind, a van, brakes"
        head.definite or (bool(item.modifiers) and item.modifiers[0].verb == "one")  # type: ignore[union-attr]
    )
    if number and (not item.link or aside) and before and phrase.count != 0 and not phrase.exact:
        several = (
            isinstance(head, NounPhrase)
            and head.pronoun != "us"
            and (head.kind == "" or head.part is not None or head.ordinal is not None or (head.definite and item.verb))
        )
        if several and (aside or item.verb or not clause.items[number - 1].modifiers):
            return call(d, phrase, before)
    alone = clause.begins and len(clause.items) == 1 and not clause.lead
    counted = counted_later(d, phrase, told, before, item.link, alone)
    if counted is not None:
        return [counted]
    known = known_mention(d, phrase, [])
    if known is not None and can_be_where(d, known, item):
        describe(d, known, replace(phrase.manner, scale=NO_SCALE))
        if phrase.each:
            d.each = known
        return [known]
    if item.link == "with" and before and d.mentions[before[-1]].kind == phrase.kind and not phrase.ridden:
        known_as = d.mentions[before[-1]].record
        if not (known_as.walks or known_as.drives):
            return before  # "a bus stop with a shelter"
    return [_new(d, clause, number, phrase, before)]


def _whose(d: Discourse, before: Item, item: Item, ids: Ids) -> Ids:
    """The owner of the object an item is "with": the nearest noun before it, as in "next to a man with a bag"."""
    said = before.modifiers[-1].said if before.modifiers else None
    assert isinstance(item.head, NounPhrase)
    if not (isinstance(said, Relation) and said.targets) or max(said.tokens) > min(item.head.tokens, default=0):
        return ids
    kind = said.targets[-1].kind
    return [n for n, one in enumerate(d.mentions) if one.is_wanted and one.kind == kind][-1:] or ids


def _new(d: Discourse, clause: Clause, number: int, phrase: NounPhrase, before: Ids) -> int:
    """A mention of objects that were not named before."""
    item, host = clause.items[number], None
    count = phrase.count
    if is_denied(d, clause, number) and not phrase.exact and count in (1, "some"):
        count = 0
    mention = mention_of(phrase)
    said = clause.items[number - 1].modifiers[-1:] if number else ()
    streets = (*(one.said for one in said), *(one.head for one in clause.items[number - 1 : number]))
    of_street = any(isinstance(one, Street) or (isinstance(one, Place) and one.road) for one in streets)
    if item.link in ("with", "has", "have") and before and d.mentions[before[-1]].is_wanted and not of_street:
        host = before[-1]
        if item.link == "have" and d.mentions[host].count != 1 and d.each is None:
            d.each = host
    others = d.mentions[before[-1]].with_it if before and item.link == "and" else None
    if others is not None and not (d.mentions[others].record.drives or d.mentions[others].record.walks):
        host = others if not clause.items[number - 1].modifiers else host  # "a petrol station with a car and a van"
    traffic = item.verb in ("one", "many") and bool(before) and number and _is_traffic(clause.items[number - 1])
    if (
        (item.link == ":" or traffic)
        and before
        and d.mentions[before[-1]].kind == "vehicle"
        and isinstance(d.mentions[before[-1]].count, str)
    ):
        d.change(before[-1], summed=True)
        d.summed = before[-1]
    if (not item.link and not traffic) or item.link == "." or number == 0:
        d.summed = None
    if d.summed is not None and mention.is_wanted and mention.record.is_vehicle:
        tokens = mention.tokens | d.mentions[d.summed].tokens
        mention = replace(mention, same_as=d.summed, of_them=True, tokens=tokens)
    made = d.add(replace(mention, count=count, with_it=host if len(before) == 1 else None))
    if phrase.each:
        d.each = made
        if not phrase.exact:
            d.change(made, count="some")
    elif d.each is not None and d.mentions[d.each].kind != phrase.kind:
        d.change(made, host=d.each)
    return made


def _modify(d: Discourse, clause: Clause, number: int, named: list[Ids]) -> None:
    """Note the modifiers of an item, for all items in their scope."""
    item = clause.items[number]
    open_ids: Ids = named[number]
    modifiers = _split_part(d, clause, number, open_ids)
    denied = bool(open_ids) and d.mentions[open_ids[0]].count == 0
    if item.link == "except" and not named[number] and not (modifiers and modifiers[0].verb):
        return
    verb = bool(modifiers) and bool(modifiers[0].verb) and _is_had(item)
    if number and ((item.link == "except" and (denied or not open_ids)) or (verb and named[number - 1])):
        open_ids = named[number - 1]  # "cars but not trucks on the right"
    last: Relation | None = None
    first = next((n for n, one in enumerate(modifiers) if not isinstance(one.said, Manner) or one.said.says), -1)
    for index, modifier in enumerate(modifiers):
        said = modifier.said
        facade = isinstance(said, Place) and said.bare and open_ids and d.building_before(open_ids[0]) is not None
        is_first = index == first and item.link != "except" and not verb and not facade
        if is_first:
            numbers = spread(clause, number, modifier)
            open_ids = [one for n in numbers for one in named[n]] if numbers != [number] else open_ids
        if not isinstance(said, Street):
            for one in open_ids:
                d.cover(one, said.tokens)
        if is_first and _respective(d, clause, number, open_ids):
            return
        if number and open_ids == named[number]:
            open_ids = _carrier(d, item, open_ids, named[number - 1], said) or open_ids
        if last is not None and _is_of_subject(last, modifier):
            open_ids = named[number]
        before = modifiers[index - 1].said if index else None
        if isinstance(said, Place) and isinstance(before, Street) and not modifier.link and note_junction(d, said):
            continue
        if isinstance(said, Place):
            passed = last is not None and last.overtakes and said.at.sides == ["left"]
            if last is not None and is_side_of(d, last, said, named[number] if passed else open_ids):
                last = None
                continue
            open_ids = say_place(d, open_ids, said, modifier)
        elif isinstance(said, Relation) and modifier.link == "except":
            return
        elif isinstance(said, Relation):
            them = any(phrase.pronoun == "them" and not phrase.each for phrase in said.targets)
            if them and len(open_ids) > 1 and index == first:
                references, open_ids = open_ids[:-1], open_ids[-1:]
            else:
                references = targets_of(d, said, open_ids)
            last = said
            open_ids = relate(d, open_ids, said, references)
        elif isinstance(said, Manner) and said.in_row and queue_up(d, open_ids, None):
            open_ids = open_ids[:1]
        elif isinstance(said, Manner):
            for one in _who_acts(d, item, named, number, open_ids):
                describe(d, one, said)
                if d.mentions[one].kind is not None:
                    d.change(one, described=True)
        else:
            on_street(d, open_ids, said)


def _is_of_subject(last: Relation, modifier: Modifier) -> bool:
    """Whether a modifier after a relation is of its subject again, and not of the relation's target."""
    if modifier.link == "and" and modifier.verb:
        return True
    if modifier.link == ",":  # "in front of the shop, next to a bench"
        return isinstance(modifier.said, Relation | Manner)
    at_light = any(to.kind == "traffic-light" for to in last.targets)
    return at_light and not modifier.link and isinstance(modifier.said, Relation)  # "at a red light next to a car"


def _is_had(item: Item) -> bool:
    """Whether the item before has, or lacks, this item."""
    return item.link == "with" or (isinstance(item.head, NounPhrase) and item.head.without)


def _split_part(d: Discourse, clause: Clause, number: int, ids: Ids) -> tuple[Modifier, ...]:
    """The modifiers of an item, without those before its verb, which are of the whole: "one of the cars ahead is
    ..."."""
    item = clause.items[number]
    assert isinstance(item.head, NounPhrase)
    whole = d.mentions[ids[0]].same_as if ids else None
    if item.head.part is None or not item.head.kind or whole is None:
        return item.modifiers
    verbs = [index for index, one in enumerate(item.modifiers) if one.verb]
    later = number + 1 < len(clause.items) and bool(clause.items[number + 1].verb)
    cut = verbs[0] if verbs else len(item.modifiers) if later else 0
    for modifier in item.modifiers[:cut]:
        if isinstance(modifier.said, Place):
            say_place(d, [whole], modifier.said, modifier)
        elif isinstance(modifier.said, Manner):
            describe(d, whole, modifier.said)
    return item.modifiers[cut:]


def _carrier(d: Discourse, item: Item, ids: Ids, host: Ids, said: object) -> Ids:
    """The owner of an object, if a modifier is about the owner: "a lorry with a sign at 65 m"."""
    if item.link != "with" or len(ids) != 1 or len(host) != 1:
        return []
    carried, carrier = d.mentions[ids[0]], d.mentions[host[0]]
    if not (carrier.is_wanted and carried.is_wanted and carrier.same_as is None):
        return []
    together = carrier.kind == carried.kind == "person"
    companion = carried.kind in COMPANIONS or item.is_carried or (isinstance(item.head, NounPhrase) and item.head.owned)
    companion = companion or together or (carrier.record.walks and carried.record.cycles)
    if isinstance(said, Relation) and any(phrase.pronoun for phrase in said.targets):
        return []  # "two houses with a tree between them"
    facade = isinstance(said, Place) and said.bare
    companion = companion or (carrier.record.family == "buildings" and not (carried.record.on_road or facade))
    at_distance = isinstance(said, Place) and bool(said.at.distance) and len(item.modifiers) == 1
    if not (companion and isinstance(said, Place | Relation | Street)) and not at_distance:
        return []
    if carrier.placed or carrier.relation or (carried.record.drives and not companion):
        return []
    if together:  # "a mother with two kids at the corner"
        return [*host, *ids]
    if carried.relation is None:
        d.mentions[ids[0]] = kept_with(carried, host[0])
    return host


def _who_acts(d: Discourse, item: Item, named: list[Ids], number: int, ids: Ids) -> Ids:
    """The objects that act together with a companion: "a pickup with a trailer crossing"; a trailer follows its
    vehicle."""
    if not (number and isinstance(item.head, NounPhrase) and item.link == "with"):
        return ids
    together = [item.head.kind] == [d.mentions[one].kind for one in named[number - 1]] == ["person"]
    if not (item.head.kind in COMPANIONS or together):
        return ids
    return [*named[number - 1], *(ids if item.head.kind in ("animal", "person") else [])]


def _respective(d: Discourse, clause: Clause, number: int, open_ids: Ids) -> bool:
    """Give each object its own place if there are as many, as in "a car and a truck at 20 m and 50 m"."""
    modifiers = clause.items[number].modifiers
    places = [one.said for one in modifiers if isinstance(one.said, Place)][: len(open_ids)]
    links = [one.link for one in modifiers][1 : len(places)]
    rest = modifiers[len(places) :]
    single = all(d.mentions[one].count == 1 for one in open_ids) and all(one.at.distance for one in places)
    single = single or modifiers[0].verb == "respectively"
    begins = all(isinstance(one.said, Place) for one in modifiers[: len(places)])
    if not (len(places) == len(open_ids) > 1 and single and all(links) and begins):
        return False
    shared = next((one.at.places for one in reversed(places) if one.at.places != (NOWHERE,)), (NOWHERE,))
    for one, place in zip(open_ids, places, strict=True):
        at = place.at if place.at.places != (NOWHERE,) else place.at.narrowed(Position(shared))
        place_at(d, one, replace(with_side(d, place), at=at))
    for modifier in rest:
        if isinstance(modifier.said, Place):
            say_place(d, open_ids, modifier.said, modifier)
        elif isinstance(modifier.said, Manner):
            for one in open_ids:
                describe(d, one, modifier.said)
    return True


def resolve(clauses: list[Clause]) -> Discourse:
    """The mentions of a text in order, its statements on the road, and the dropped words."""
    discourse = Discourse(_inner_side(clauses))
    for clause in clauses:
        read(discourse, clause)
    return discourse


def _inner_side(clauses: list[Clause]) -> str | None:
    """The direction of the bend in a text, None if there is none."""
    said = [
        one for clause in clauses for item in clause.items for one in (item.head, *(m.said for m in item.modifiers))
    ]
    said += [one.said for clause in clauses for one in clause.lead]
    kinds = [one.kind if isinstance(one, Street) else one.road for one in said if isinstance(one, Street | Place)]
    return next((str(kind).partition("-")[0] for kind in kinds if kind in ("left-bend", "right-bend")), None)


def _is_ego_named(item: Item) -> bool:
    return isinstance(item.head, NounPhrase) and item.head.pronoun == "us"
