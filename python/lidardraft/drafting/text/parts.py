"""Parts of a whole: mentions that count or sum up others again, and the number of objects left for each."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from lidardraft.drafting.text.mentions import Mention, Mentions, count_times, depends
from lidardraft.drafting.text.positions import RIGHT, Position
from lidardraft.drafting.text.tree import NO_SCALE, Count

_DRAWBAR = (0.5, 1.0)  # m
_FOR_EACH = {"few": 3, "some": 4, "many": 8}  # numbers for hosts, so that each has its own objects
_MOST_ABREAST = 5  # objects side by side; counts in words do not apply


def part(mentions: Mentions) -> Mentions:
    """The mentions, each with its own objects; those that only sum up others, or have none left, get kind None."""
    found = list(mentions)
    for number in range(len(found)):
        _count_for_hosts(found, number)
    for number in range(len(found)):
        _keep_with(found, number)
        _turn_trailer(found, number)
        _turn_to_strip(found, number)
        _imply_parked(found, number)
        _wait_at_stop(found, number)
    _note_listed_parts(found)
    for number in range(len(found)):
        _count_rest(found, number)
    sums = {number for number, one in enumerate(found) if one.is_wanted and _is_sum(found, number)}
    for number, one in enumerate(found):
        if one.same_as is not None and (one.of_them or one.same_as in sums):
            found[number] = _inherit(one, found[one.same_as])
            _take_from_whole(found, number, sums)
    for number in sums:
        found[number] = replace(found[number], summed=True)
    return tuple(found)


def divided(mentions: Mentions) -> list[tuple[int, Mention]]:
    """The wanted mentions with their numbers; those side by side, or on two sides together, are divided."""
    found: list[tuple[int, Mention]] = []
    for number, one in enumerate(mentions):
        if one.is_wanted and not one.summed:
            found += [(number, divided) for whole in _abreast(one, number) for divided in _at_each_side(whole)]
    return found


def _parts_of(mentions: list[Mention], whole: int) -> list[int]:
    return [number for number, one in enumerate(mentions) if one.same_as == whole]


def _count_for_hosts(mentions: list[Mention], number: int) -> None:
    """ "Two trees for each house" are twice as many as houses, and near them."""
    mention = mentions[number]
    if mention.host is None:
        return
    host = mentions[mention.host]
    if isinstance(host.count, str) and host.count != "none":
        mentions[mention.host] = host = replace(host, count=_FOR_EACH[host.count])
    hosts = host.count
    if isinstance(hosts, int) and not host.at.shared:
        hosts *= len(host.at.places)
    if isinstance(hosts, int) and hosts > mention.left_out:
        hosts -= mention.left_out
    mentions[number] = replace(mention, count=count_times(mention.count, hosts))
    if mention.relation is None and not mention.placed:
        mentions[number] = replace(mentions[number], relation="near", references=(mention.host,), placed=True)


def _keep_with(mentions: list[Mention], number: int) -> None:
    """Objects with another one are near it unless placed otherwise, as in "a garden with two trees"."""
    mention = mentions[number]
    other = mentions[mention.with_it] if mention.with_it is not None else None
    if other is None or other.kind is None or not mention.is_wanted or other.count == 0:
        return
    if other.kind == "vehicle" and mention.kind != "trailer":
        return  # "traffic with cars"
    if mention.placed or mention.on_road or mention.relation is not None:
        return
    if not depends(mentions, mention.with_it, number):  # type: ignore[arg-type]
        mentions[number] = kept_with(mention, mention.with_it)  # type: ignore[arg-type]


def _turn_trailer(mentions: list[Mention], number: int) -> None:
    """A trailer has the heading of its vehicle."""
    mention = mentions[number]
    if mention.kind == "trailer" and mention.at.distance == _DRAWBAR and mention.references:
        carrier = mentions[mention.references[0]]
        if (carrier.heading or carrier.at.heading) not in (None, "with", "parked"):
            mentions[number] = replace(mention, at=replace(mention.at, heading=None))


def kept_with(mention: Mention, host: int) -> Mention:
    """A mention near its host; a trailer is right behind it."""
    if mention.kind == "trailer":
        at = Position(distance=_DRAWBAR, heading="with")
        return replace(mention, relation="behind", references=(host,), at=at, placed=True)
    return replace(mention, relation="near", references=(host,), placed=True)


def _turn_to_strip(mentions: list[Mention], number: int) -> None:
    """Several houses are behind the hedge in front of them, as long as they need it."""
    mention = mentions[number]
    strip = mention.is_wanted and mention.record.follows_road and mention.count == 1
    if not strip or mention.relation != "in-front-of" or len(mention.references) != 1:
        return
    row = mentions[mention.references[0]]
    if row.count in (0, 1) or row.relation is not None or row.at.distance or mention.at.distance:
        return
    at = replace(row.at, from_road=None, from_sidewalk=None).narrowed(mention.at)
    mentions[number] = replace(mention, relation=None, references=(), at=at)
    if not (row.at.from_road or row.at.from_sidewalk):  # no relation goes with these
        mentions[mention.references[0]] = replace(row, relation="behind", references=(number,), placed=True)


def _wait_at_stop(mentions: list[Mention], number: int) -> None:
    """People who wait, without another place, wait at the bus stop named before."""
    one = mentions[number]
    waits = one.kind == "person" and one.is_wanted and one.speed == 0.0 and one.heading is None
    stops = [n for n, other in enumerate(mentions[:number]) if other.kind == "shelter" and other.is_wanted]
    if waits and len(stops) == 1 and not (one.placed or one.relation or one.on_road or one.same_as is not None):
        mentions[number] = replace(one, relation="near", references=(stops[0],), placed=True)


def _imply_parked(mentions: list[Mention], number: int) -> None:
    """A parked object is between parked ones; a parked vehicle that is overtaken is at the kerb."""
    mention = mentions[number]
    for other in mention.references:
        reference = mentions[other]
        if mention.relation == "between" and mention.heading == "parked":
            mentions[other] = reference = replace(reference, heading=reference.heading or "parked")
        overtaken = mention.relation == "left-of" and mention.at.heading == "with" and reference.heading == "parked"
        if overtaken and not reference.references and not reference.at.sides:
            mentions[other] = replace(reference, at=reference.at.narrowed(Position(places=(RIGHT,))), placed=True)


def _note_listed_parts(mentions: list[Mention]) -> None:
    """Mentions that add up to the number of vehicles, or of their own kind, just before them are parts of it."""
    for number, whole in enumerate(mentions):
        if not isinstance(whole.count, int) or whole.count < 2 or whole.references or whole.kind is None:
            continue
        parts: list[int] = []
        total = 0
        for other in range(number + 1, len(mentions)):
            one = mentions[other]
            vehicle = whole.kind == "vehicle" and one.kind is not None and one.record.is_vehicle
            if one.same_as is not None or not (vehicle or one.kind == whole.kind):
                break
            parts.append(other)
            total += one.count if isinstance(one.count, int) else 0
            if total >= whole.count:
                break
        if len(parts) > 1 and total == whole.count:
            for other in parts:
                mentions[other] = replace(mentions[other], same_as=number, of_them=True)


def _count_rest(mentions: list[Mention], whole: int) -> None:
    """ "The others" are as many as the other parts leave."""
    parts, total = _parts_of(mentions, whole), mentions[whole].count
    if not isinstance(total, int):
        return
    vague = [one for one in parts if mentions[one].count == "some" and not mentions[one].of_them]
    if len(vague) == len(parts) > 1 and total >= len(parts):
        for index, one in enumerate(parts):  # "six people, some on the left and some on the right"
            mentions[one] = replace(mentions[one], count=(total + index) // len(parts), of_them=True)
    for one in parts:
        if mentions[one].of_them and mentions[one].count == "some":
            counts = [mentions[other].count for other in parts]
            left = total - sum(count for count in counts if isinstance(count, int))
            mentions[one] = replace(mentions[one], count=max(1, left))


def _is_sum(mentions: list[Mention], number: int) -> bool:
    """Whether it only sums up its parts, as in "three cars: one ahead, two behind"."""
    whole, parts = mentions[number], [mentions[one] for one in _parts_of(mentions, number)]
    if isinstance(whole.count, str) and len(parts) == len(whole.at.places) > 1:  # "on both sides (10 left, 8 right)"
        return {place for one in parts for place in one.at.places} == set(whole.at.places)
    if isinstance(whole.count, str) and any(one.host is not None for one in parts):
        return True
    anywhere = not whole.at.distance and not whole.at.sides and not whole.references
    if whole.count == "some" and anywhere and any(one.at.both_sides for one in parts):
        return True  # "people walk there, two on each side"
    if whole.summed or any(one.at.lane == "each" and one.at.agrees(whole.at) for one in parts):
        return True
    counts = [one.count * (1 if one.at.shared else len(one.at.places)) for one in parts if isinstance(one.count, int)]
    if not parts or whole.count == 1 or sum(counts) != whole.count:
        return False
    if any(one.of_them for one in parts):
        return True
    free = not whole.placed and whole.motion != "overtakes"
    several = len(parts) > 1 or len(parts[0].at.places) > 1
    return free or (several and all(one.at.agrees(whole.at) for one in parts))


def _inherit(one: Mention, whole: Mention) -> Mention:
    """A part with the properties of the whole that it does not set itself."""
    at = one.at
    if whole.placed:
        at = whole.at.narrowed(one.at)
        if len(at.places) > max(len(whole.at.places), len(one.at.places)):
            at = replace(at, places=one.at.places)
    related = not one.references and whole.references and whole.relation is not None and not one.on_road
    alike = one.kind == whole.kind
    return replace(
        one,
        at=at,
        placed=one.placed or whole.placed,
        relation=whole.relation if related else one.relation,
        references=whole.references if related else one.references,
        size=whole.size if alike and not any(one.size) else one.size,
        scale=whole.scale if alike and one.scale == NO_SCALE else one.scale,
        heading=one.heading or whole.heading,
        paint=one.paint or whole.paint,
        speed=whole.speed if one.speed is None else one.speed,
        on_road=one.on_road or whole.on_road,
    )


def _take_from_whole(mentions: list[Mention], number: int, sums: set[int]) -> None:
    one = mentions[number]
    assert one.same_as is not None
    whole = mentions[one.same_as]
    counted = isinstance(one.count, int) and isinstance(whole.count, int) and 0 < one.count < whole.count
    if counted and one.of_them and one.same_as not in sums:
        mentions[one.same_as] = replace(whole, count=whole.count - one.count)  # type: ignore[operator]


def _abreast(mention: Mention, number: int) -> Iterator[Mention]:
    """Objects side by side, each beside the next; only the last has a place."""
    count = mention.count
    if not mention.abreast or not isinstance(count, int) or not 1 < count <= _MOST_ABREAST:
        yield mention
        return
    for _ in range(count - 1):
        at = Position(heading=mention.at.heading)
        yield replace(mention, count=1, at=at, relation="beside", references=(-1,), same_as=number)
    yield replace(mention, count=1)


def _at_each_side(mention: Mention) -> Iterator[Mention]:
    """A number of objects at both sides, half of them at each."""
    low, high = mention.count if isinstance(mention.count, tuple) else (mention.count, mention.count)
    if not mention.at.shared or len(mention.at.places) != 2 or isinstance(low, str) or isinstance(high, str) or low < 2:
        yield mention
        return
    for place, odd in zip(mention.at.places, (1, 0), strict=True):
        count: Count = (low + odd) // 2 if low == high else ((low + odd) // 2, (high + odd) // 2)
        yield replace(mention, count=count, at=replace(mention.at, places=(place,)))
