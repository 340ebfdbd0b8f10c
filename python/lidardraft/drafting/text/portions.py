"""Named parts of a whole: "one of the three cars", "the second", "the others", "all of them"."""

from __future__ import annotations

import itertools
from dataclasses import replace

from lidardraft.drafting.text.exceptions import all_but_some
from lidardraft.drafting.text.mentions import Discourse, Ids, Mention, mention_of
from lidardraft.drafting.text.places import describe
from lidardraft.drafting.text.positions import FRONT, Position
from lidardraft.drafting.text.references import can_be_where
from lidardraft.drafting.text.tree import Clause, Count, Item, Manner, NounPhrase, Place, Relation

_HAVING = ("with", "has", "have")
_SHARES = {"some": 0.5, "few": 0.25, "many": 0.75}  # of "them"; estimates


def named_part(d: Discourse, clause: Clause, number: int, before: Ids, told: bool) -> Ids:
    """The mentions named by a number without a noun, "one of the three cars" or "the second car"."""
    phrase, item = clause.items[number].head, clause.items[number]
    assert isinstance(phrase, NounPhrase)
    following = _following(clause, number)
    places = [one.said.at for one in item.modifiers if isinstance(one.said, Place)]
    if (
        before
        and phrase.exact
        and phrase.count == 1
        and places
        and all(at == Position(spacing=at.spacing) for at in places)
    ):
        return before  # "cones in our lane, one every 5 m"
    if _is_apposition(clause, number) and before and d.mentions[before[-1]].count == 1:
        describe(d, before[-1], phrase.manner)
        return before[-1:]
    if phrase.part is not None and phrase.kind:
        return _part_of_named(d, phrase, told, following in ("has", "have"))
    whole = d.several(phrase.kind or "")
    if whole is None and phrase.definite and phrase.exact and phrase.count == 1:
        fitting = [n for n, one in enumerate(d.mentions) if one.is_wanted and can_be_where(d, n, item)]
        if fitting:
            return fitting[-1:]  # "a car on the left and a bus on the right, the one on the left"
    last = before[-1] if before else len(d.mentions) - 1 if d.mentions else None
    if last is None or d.mentions[last].kind is None:
        return []
    if phrase.all_but or phrase.all or phrase.each:
        return _all_or_each(d, phrase, whole, before) if told or phrase.one_each or following in _HAVING else []
    known = d.mentions[whole].count if whole is not None else None
    beyond = phrase.another and isinstance(known, int) and phrase.ordinal is not None and phrase.ordinal >= known
    does = bool(item.modifiers) and all(isinstance(one.said, Manner) for one in item.modifiers)
    acts = does and item.link == "," and phrase.exact and _counted_from(clause, number) == known
    definite = phrase.definite or phrase.rest or phrase.ordinal is not None or phrase.at is not None
    of_them = phrase.of_them or (
        whole is not None and not beyond and (definite or acts or _is_to_the_rest(item))
    )  # but of "two vans and a third" the third is one more
    last = whole if of_them and whole is not None else last
    source = d.mentions[last]
    if phrase.count == 0:
        return _none_of(d, item, phrase, last, told)
    told = told or (number + 1 < len(clause.items) and not following)
    if item.link == ":" and told and not phrase.of_them and (source.count == 1 or isinstance(source.count, str)):
        d.change(last, summed=True)
    aside = bool(item.modifiers) and item.modifiers[0].link == "," and phrase.of_them
    counted = isinstance(source.count, str) and (aside or not (told or following in _HAVING))
    if counted or not (told or phrase.of_them or phrase.another):
        count = phrase.count if phrase.exact or isinstance(phrase.count, tuple) else None
        open_count = isinstance(source.count, str) or (source.count == 1 and source.at.spacing)
        if count is None or phrase.ordinal is not None or not open_count:
            return []
        d.change(last, count=count)  # "bicycles at a fence: 15 of them"
        return [last]
    if phrase.ordinal == 0 and source.at.spacing:  # the whole row begins at the first
        places = [one.said.at for one in item.modifiers if isinstance(one.said, Place)]
        ahead = not any(fore for at in places for fore, _ in at.places)
        at = source.at.narrowed(Position(places=(FRONT,))) if ahead else source.at
        d.change(last, at=at, weak=False)
        return [last]
    return [_new_part(d, phrase, last, of_them)]


def _counted_from(clause: Clause, number: int) -> int:
    """The sum of the numbers without nouns from one on: "one going left and two going right" are three."""
    heads = (one.head for one in clause.items[number:])
    listed = itertools.takewhile(lambda head: isinstance(head, NounPhrase) and head.kind == "" and head.exact, heads)
    return sum(int(str(head.count)) for head in listed if isinstance(head, NounPhrase))


def _is_apposition(clause: Clause, number: int) -> bool:
    """Whether it only describes the object before it: "a minibus, an orange one"."""
    phrase = clause.items[number].head
    new = isinstance(phrase, NounPhrase) and (phrase.another or phrase.definite or phrase.exact or phrase.count != 1)
    return number > 0 and clause.items[number].link == "," and not (new or clause.items[number - 1].modifiers)


def _is_to_the_rest(item: Item) -> bool:
    """Whether a part is related to the others: "two trucks, one overtaking the other"."""
    relations = (one.said for one in item.modifiers if isinstance(one.said, Relation))
    return any(phrase.rest and not phrase.kind for said in relations for phrase in said.targets)


def _new_part(d: Discourse, phrase: NounPhrase, last: int, of_them: bool) -> int:
    """A mention of a part of others, or of more of the same; for "half of them" the share counts."""
    source = d.mentions[last]
    count: Count = phrase.count
    if phrase.rest:
        count = "some" if phrase.plural or phrase.kind else 1
    share = phrase.part if isinstance(phrase.part, float) else _SHARES.get(str(phrase.count), 0.0) * phrase.of_them
    if share:
        of_them = isinstance(source.count, int)
        count = max(1, int(share * source.count)) if isinstance(source.count, int) else "some"
    kept = source.heading == "parked" or (source.heading == "against" and phrase.another)
    root = source.same_as if source.same_as is not None else last
    made = Mention(
        source.kind,
        count,
        heading=source.heading if kept else None,
        same_as=root if source.count != 0 else None,
        of_them=of_them or (count == "some" and source.of_them),
        tokens=phrase.tokens,
    )
    number = d.add(made)
    describe(d, number, phrase.manner)
    return number


def _all_or_each(d: Discourse, phrase: NounPhrase, whole: int | None, before: Ids) -> Ids:
    """The mentions named by "all of them", "all but two", "each" and "six each"."""
    if phrase.all_but:
        return all_but_some(d, phrase, whole)
    if phrase.one_each:
        if any(not isinstance(d.mentions[one].count, str) for one in before):
            return []
        for one in before:
            d.change(one, count=phrase.count, at=replace(d.mentions[one].at, shared=False))
        return before
    if phrase.all:
        return _all_of_them(d, phrase)
    if whole is None:
        return []
    d.each = whole
    return [whole]


def _none_of(d: Discourse, item: Item, phrase: NounPhrase, whole: int, told: bool) -> Ids:
    """ "None of them parked": they drive; "none on the left": they are elsewhere."""
    said = [one.said for one in item.modifiers]
    if item.link == ":" and not told:  # "cars on the left: none"
        d.change(whole, count=0)
        return []
    if not phrase.of_them:
        return [d.add(Mention(d.mentions[whole].kind, 0))] if told else []
    if said and all(isinstance(one, Manner) and one.heading in ("parked", "against") for one in said):
        d.change(whole, heading="with")
    return []


def _part_of_named(d: Discourse, phrase: NounPhrase, told: bool, has: bool) -> Ids:
    """ "One of the three cars": the cars, and one as a part of them."""
    whole = d.several(str(phrase.kind))
    if whole is None or phrase.exact:
        whole = d.add(replace(mention_of(phrase), count=phrase.count))
    count: Count = int(phrase.part) if isinstance(phrase.part, int) else "some"
    source = d.mentions[whole]
    if has:
        return [whole]
    if isinstance(phrase.part, float) and isinstance(source.count, int):
        count = max(1, int(phrase.part * source.count))
    if phrase.ordinal is not None and not told:
        return [whole]
    made = d.add(
        Mention(
            source.kind,
            count,
            heading=source.heading if source.heading == "parked" else None,
            same_as=whole,
            of_them=True,
        )
    )
    return [made]


def _all_of_them(d: Discourse, phrase: NounPhrase) -> Ids:
    """The mentions meant by "both" and "all of them": the several before, or all listed in the sentence."""
    first = d.sentence if d.sentence < len(d.mentions) else d.earlier
    listed = [n for n in range(first, len(d.mentions)) if d.mentions[n].is_wanted]
    if phrase.both and len(listed) > 1 and [d.mentions[n].count for n in listed[-2:]] == [1, 1]:
        return listed[-2:]
    whole = d.several()
    several = whole is not None and d.mentions[listed[-1]].count != 1 and (len(phrase.tokens) > 1 or phrase.both)
    return [whole] if several and whole is not None else listed


def _following(clause: Clause, number: int) -> str:
    """The link after an item."""
    return clause.items[number + 1].link if number + 1 < len(clause.items) else ""


def counted_later(d: Discourse, phrase: NounPhrase, told: bool, before: Ids, link: str, alone: bool) -> int | None:
    """The mention that a number counts later, as in "every lamp has a bin; there are four lamps"."""
    if not phrase.exact or told or (before and link != ":") or phrase.name:
        return None
    for number, one in enumerate(d.mentions):
        hosts = any(other.host == number for other in d.mentions) or one.left_out
        if (
            one.kind == phrase.kind
            and isinstance(one.count, str)
            and one.count != "few"
            and (hosts or phrase.in_total or alone)
        ):
            d.change(number, count=phrase.count)
            return number
    return None
