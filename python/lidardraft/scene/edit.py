"""Edits of a layout; each returns a new layout and leaves the old one unchanged.

A pattern is a glob on ids or on names of objects: `car_*`, `*.crown`, `tree_3` (all parts of that tree).
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterable, Iterator
from fnmatch import fnmatchcase
from typing import Any

from lidardraft.errors import LayoutError, check_type
from lidardraft.json_fields import are_numbers, is_number
from lidardraft.scene.layout import Layout, Primitive, object_of
from lidardraft.scene.pose import Place, in_frame, point_at
from lidardraft.semantics import BY_NAME


def select(layout: Layout, pattern: str = "*", *, label: str | None = None) -> tuple[Primitive, ...]:
    """The matching primitives, in the layout's order; an empty tuple if none matches."""
    check_type("pattern", pattern, str)
    return tuple(p for p in layout if _matches(p, pattern) and label in (None, p.label))


def add(layout: Layout, *primitives: Primitive) -> Layout:
    """The layout with more primitives at the end.

    A thing with instance 0, such as a car, gets a free instance, one for all parts of an object. Raises `LayoutError`
    if an id is taken, or if the instance belongs to another object.
    """
    for primitive in primitives:
        check_type("a primitive", primitive, Primitive)
    owners = {primitive.instance: object_of(primitive) for primitive in layout}
    free = itertools.filterfalse((owners | {p.instance: "" for p in primitives}).__contains__, itertools.count(1))
    numbers = {object_of(primitive): primitive.instance for primitive in layout if primitive.instance}
    added = []
    for primitive in primitives:
        name = object_of(primitive)
        if primitive.instance and owners.get(primitive.instance, name) != name:
            owner = owners[primitive.instance]
            raise LayoutError(f"{primitive.id}: instance {primitive.instance} is {owner}'s; 0 takes a free one")
        if not primitive.instance and BY_NAME[primitive.label].is_thing:
            if name not in numbers:
                numbers[name] = next(free)
            primitive = dataclasses.replace(primitive, instance=numbers[name])
        if primitive.instance:
            owners[primitive.instance], numbers[name] = name, primitive.instance
        added.append(primitive)
    return dataclasses.replace(layout, primitives=(*layout.primitives, *added))


def remove(layout: Layout, pattern: str) -> Layout:
    """The layout without the matching primitives; raises `LayoutError` if none matches."""
    gone = {primitive.id for primitive in _existing(layout, pattern)}
    return dataclasses.replace(layout, primitives=tuple(p for p in layout if p.id not in gone))


def move(
    layout: Layout, pattern: str, by: tuple[float, float, float] = (0.0, 0.0, 0.0), *, turn: float = 0.0
) -> Layout:
    """The layout with the matching objects shifted `by` [m], each turned about its own middle [rad, counter-clockwise].

    An object moves as a whole, even if only a part of it matches. Raises `LayoutError` if none matches.
    """
    if not are_numbers(by, 3):
        raise LayoutError(f"by is {by!r}; it must be three finite numbers of metres, along x, y and z")
    if not is_number(turn):
        raise LayoutError(f"turn is {turn!r}; it must be a finite number of radians")
    names = dict.fromkeys(object_of(primitive) for primitive in _existing(layout, pattern))
    moved: dict[str, Primitive] = {}
    for name in names:
        parts = [primitive for primitive in layout if object_of(primitive) == name]
        middle = _middle(parts)
        moved |= {part.id: moved_part(part, middle, by, turn) for part in parts}
    return dataclasses.replace(layout, primitives=tuple(moved.get(p.id, p) for p in layout))


def replace(layout: Layout, pattern: str, **fields: Any) -> Layout:
    """The layout with new values for `fields` of the matching primitives: `replace(layout, "car_1", label="truck")`.

    Raises `LayoutError` if none matches, and for an unknown field or an invalid value.
    """
    names = [field.name for field in dataclasses.fields(Primitive)]
    unknown = set(fields) - set(names)
    if unknown:
        raise LayoutError(f"a primitive has no field {sorted(unknown)[0]!r}; it has {', '.join(names)}")
    changed = {p.id: dataclasses.replace(p, **fields) for p in _existing(layout, pattern)}
    primitives = tuple(changed.get(p.id, p) for p in layout)
    named = {object_of(before): object_of(after) for before, after in zip(layout, primitives, strict=True)}
    left = set(map(object_of, primitives))
    intent = layout.intent.renamed({before: after for before, after in named.items() if before not in left})
    return dataclasses.replace(layout, primitives=primitives, intent=intent)


def _matches(primitive: Primitive, pattern: str) -> bool:
    return fnmatchcase(primitive.id, pattern) or fnmatchcase(object_of(primitive), pattern)


def _existing(layout: Layout, pattern: str) -> tuple[Primitive, ...]:
    matching = select(layout, pattern)
    if not matching:
        raise layout.unknown(pattern)
    return matching


def _middle(parts: list[Primitive]) -> tuple[float, float]:
    """The mean of the parts' centres, weighted by area seen from above: a small part does not pull the pivot away."""
    areas = [part.size[0] * part.size[1] or 1e-9 for part in parts]
    total = sum(areas)
    x = sum(area * part.center[0] for area, part in zip(areas, parts, strict=True)) / total
    y = sum(area * part.center[1] for area, part in zip(areas, parts, strict=True)) / total
    return x, y


def moved_part(part: Primitive, middle: tuple[float, float], by: tuple[float, float, float], turn: float) -> Primitive:
    """The part turned about the `middle` [rad] and shifted `by` [m]."""
    x, y = point_at((*middle, turn), part.center[0] - middle[0], part.center[1] - middle[1])
    return dataclasses.replace(part, center=(x + by[0], y + by[1], part.center[2] + by[2]), yaw=part.yaw + turn)


def placed(primitives: Iterable[Primitive], place: Place) -> Iterator[Primitive]:
    """The primitives of a frame that is at `place`, in the frame around it."""
    if not any(place):
        yield from primitives
        return
    for primitive in primitives:
        x, y, yaw = in_frame((*primitive.center[:2], primitive.yaw), place)
        yield dataclasses.replace(primitive, center=(x, y, primitive.center[2]), yaw=yaw)
