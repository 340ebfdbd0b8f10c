"""The scope of a place, a relation or a verb after a list: all items of the list that it fits, or the last."""

from __future__ import annotations

from lidardraft.drafting.text.tree import Clause, Item, Manner, Modifier, NounPhrase, Place, Relation
from lidardraft.objects.kinds import SENTENCE_KINDS

_MANY = 4  # of a kind; more at one object have no room


def spread(clause: Clause, last: int, modifier: Modifier) -> list[int]:
    """The numbers of the items in the scope of the first modifier after an item."""
    first, item = _list_begins(clause, last), clause.items[last]
    if modifier.verb == "one" or first == last:
        return [last]
    if modifier.verb != "many" and (_is_unknown(item.head) or item.is_told):
        return [last]  # "two cars and a llama on the left", but "are on the left"
    after = clause.items[last + 1].link if last + 1 < len(clause.items) else ""
    if item.link == "," and after in (",", "and") and not modifier.verb:
        return [last]  # "a bus, a car on the left, and a van"
    said = modifier.said
    listed = {one: head for one in range(first, last + 1) if isinstance(head := clause.items[one].head, NounPhrase)}
    if isinstance(said, Relation):
        heads = list(listed.values())
        alone = (
            item.link == ","
            or said.acts
            or _differs(heads, said)
            or ("it" in _pronouns(said) and (first == 0 or item.link != "and"))
        )
        return [last] if alone else list(listed)
    if isinstance(said, Place):
        if (item.link == "," and (said.at.distance or said.at.sidewalk)) or (item.comma and said.at.distance):
            return [last]
        if said.times > 1 and listed[last].count == 1:
            return [last]  # "trees, and a lamp at each corner"
        # a modifier of the last item does not apply to "an oncoming car" before it
        oncoming = listed[last].manner.heading != "against"
        listed = {one: head for one, head in listed.items() if not (oncoming and head.manner.heading == "against")}
        found = [one for one, head in listed.items() if _can_be(head, said)] or [last]
        drives = [one for one in found if SENTENCE_KINDS[str(listed[one].kind)].drives] if said.at.distance else []
        strips = [one for one in found if drives and SENTENCE_KINDS[str(listed[one].kind)].follows_road]
        return [one for one in found if one not in strips]  # "guard rails and three cars 20 m ahead"
    heading = said.heading if isinstance(said, Manner) else None
    others = {one for one, head in listed.items() if heading and head.manner.heading not in (None, "with", heading)}
    return [one for one, head in listed.items() if _can_move(head, said) and one not in others] or [last]


def _pronouns(said: Relation) -> set[str]:
    return {phrase.pronoun for phrase in said.targets}


def _differs(heads: list[NounPhrase], said: Relation) -> bool:
    """Whether a relation applies to the last in a list only: to one after many, or to one that moves otherwise."""
    *others, last = heads
    crowd = any(one.count == "many" or (isinstance(one.count, int) and one.count > _MANY) for one in others)
    one_of_several = len(others) > 1 and not last.plural and any(one.plural for one in others)
    moves = last.manner.heading is not None and others[0].manner.heading is None
    return moves or (crowd and last.count == 1) or (one_of_several and "them" not in _pronouns(said))


def _list_begins(clause: Clause, last: int) -> int:
    """The first item of the list that ends with an item.

    "A bus, cars and people, houses and trees" are two lists: a comma after an "and" begins a new one.
    """
    first = last
    while first > 0:
        item, before = clause.items[first], clause.items[first - 1]
        if item.link not in (",", "and", "or", "then") or _is_told(before) or item.verb or not _is_listed(before.head):
            break
        if not (_is_listed(item.head) or (first == last and _is_unknown(item.head))) or (
            _denied(item.head) != _denied(before.head)
        ):
            break
        if item.comma and before.link != ",":
            break  # "a row of trees, and a lorry in the distance"
        if item.link == "," and (before.link == "and" or (first == last and _differ(before.head, item.head))):
            break
        first -= 1
    return first


def _differ(one: object, other: object) -> bool:
    """Whether a comma separates their modifiers, as in "an oncoming bus, a man on the left"."""
    assert isinstance(one, NounPhrase)
    assert isinstance(other, NounPhrase)
    return one.plural != other.plural or one.manner.heading is not None


def _is_told(item: Item) -> bool:
    """Whether an item has a modifier of its own; lengths keep it in its list."""
    return item.is_told or any(not isinstance(one.said, Manner) or one.said.says for one in item.modifiers)


def _is_listed(head: object) -> bool:
    return isinstance(head, NounPhrase) and bool(head.kind) and not head.traffic and head.manner.motion != "overtakes"


def _is_unknown(head: object) -> bool:
    return isinstance(head, NounPhrase) and head.kind is None


def _denied(head: object) -> bool:
    return isinstance(head, NounPhrase) and head.count == 0


def _can_move(phrase: NounPhrase, said: object) -> bool:
    """Whether the object can drive or walk, if a verb says so."""
    moves = isinstance(said, Manner) and (said.heading or said.motion or said.speed or said.queue)
    kind = SENTENCE_KINDS.get(str(phrase.kind))
    if isinstance(said, Manner) and said.walks and kind is not None:
        return kind.walks
    if not moves or kind is None:
        return True
    return kind.drives or (kind.walks and said.heading != "parked" and not said.drives)  # type: ignore[attr-defined]


def _can_be(phrase: NounPhrase, place: Place) -> bool:
    """Whether the object can be at a place: one object is not on both sides, a house not in a lane."""
    if phrase.kind is None:
        return False
    kind = SENTENCE_KINDS[phrase.kind]
    if place.at.sidewalk and "sidewalk" not in kind.surfaces:
        return False
    if place.at.lane and "road" not in kind.surfaces:
        return False
    if str(place.at.heading).startswith("across") and not (kind.drives or kind.walks):
        return False  # "a stop sign, a car coming from the left"
    return not (place.at.both_sides and phrase.count == 1)
