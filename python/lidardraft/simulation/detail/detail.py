"""Any layout in detail: detailed objects replace its boxes, cylinders and ellipsoids."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

from lidardraft.errors import check_seed, check_type
from lidardraft.objects.cars import PAINTS
from lidardraft.objects.kinds import KINDS, kind_of
from lidardraft.scene.layout import AROUND, Layout, Primitive, object_of
from lidardraft.semantics import GROUND
from lidardraft.simulation.detail.buildings import building
from lidardraft.simulation.detail.coarse_object import CoarseObject, coarse_objects
from lidardraft.simulation.detail.ground import ground_parts
from lidardraft.simulation.detail.roadside import fence, other, plant, pole, wall
from lidardraft.simulation.detail.surroundings import Surroundings
from lidardraft.simulation.detail.traffic import car, heavy, machine, person, rider

# The rule for an object, by the first of these classes that it has.
RULES: dict[str, Callable[[CoarseObject, Surroundings], list[Primitive]]] = {
    "rider": rider,
    "car": car,
    "truck": heavy,
    "bus": heavy,
    "train": heavy,
    "motorcycle": machine,
    "bicycle": machine,
    "person": person,
    "building": building,
    "wall": wall,
    "fence": fence,
    "vegetation": plant,
    "trunk": plant,
    "traffic-sign": pole,
    "traffic-light": pole,
    "pole": pole,
    "other": other,
}


def _in_paint(part: Primitive, paint: str) -> Primitive:
    return dataclasses.replace(part, material=paint) if part.material in PAINTS else part


def detail(layout: Layout, *, seed: int = 0, around: Layout | None = None) -> Layout:
    """The layout with each coarse object replaced by a detailed one in its place, as in docs/explanation/simulation.md.

    Ids keep the part before the dot; objects keep their classes, instances, places and extents. Objects with a
    material, a mesh or an extinction stay as they are. So does the ground, which gets markings and kerbs. An object's
    random numbers depend on `seed` and its name alone: an edit of one object changes no other. Objects to be put into
    another layout, `around` them, use its roads, and their own ground stays as it is.
    Raises `LayoutError` if the seed is invalid.
    """
    check_type("layout", layout, Layout)
    seed = check_seed(seed)
    surroundings = Surroundings.of(around or layout)
    detailed: dict[str, list[Primitive]] = {}
    painted = {name: f"{asked.paint}-paint" for name, asked in layout.intent.objects.items() if asked.paint}
    for coarse in coarse_objects(layout, seed, clustered=surroundings.clustered):
        for part in coarse.parts:
            detailed.setdefault(object_of(part), [])
        if coarse.name.startswith(AROUND) and coarse.word in KINDS:
            detailed[coarse.name] += _as_placed(coarse)
            continue
        rule = next(rule for label, rule in RULES.items() if label in coarse.owners)
        for part in rule(coarse, surroundings):
            detailed[coarse.owners[part.label][0]].append(part)
    taken = {primitive.id for primitive in layout if primitive.label in GROUND}
    primitives: list[Primitive] = []
    for primitive in layout:
        name = object_of(primitive)
        if primitive.label in GROUND or name not in detailed:
            primitives.append(primitive)
        elif detailed[name]:
            parts = _named(detailed[name], name, taken)
            primitives += [_in_paint(part, painted[name]) for part in parts] if name in painted else parts
            detailed[name] = []
    if around is None:
        primitives += ground_parts(layout, surroundings.strips, seed)
    return dataclasses.replace(layout, primitives=tuple(primitives))


def _as_placed(coarse: CoarseObject) -> list[Primitive]:
    """An object of the surroundings, built as in a street, with its own instances."""
    parts = kind_of(coarse.word).build(coarse.placed(), coarse.rng)
    for part in parts:
        if part.instance:
            object.__setattr__(part, "instance", coarse.owners[part.label][1])
    return parts


def _named(parts: list[Primitive], name: str, taken: set[str]) -> list[Primitive]:
    """The parts of one object, each with an id: new ones are `name`, `name.1`, ..., given ones keep theirs."""
    given = taken | {part.id for part in parts}
    number = 0
    for part in parts:
        if not part.id:
            while (id := f"{name}.{number}" if number else name) in given:
                number += 1
            number += 1
            object.__setattr__(part, "id", id)
    return parts
