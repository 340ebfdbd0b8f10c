"""One object of a layout as given: its primitives, and the properties that the rules of detail use."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from lidardraft.objects.placed_object import PlacedObject, Vector
from lidardraft.scene.layout import Layout, Primitive, corners_around, object_of
from lidardraft.scene.pose import Place, point_at
from lidardraft.semantics import BY_NAME, GROUND

_MACHINES = ("bicycle", "motorcycle")
_RIDES_WITHIN = 0.8  # m between the middles of a rider and of the machine: an estimate
_CROWN_OVER = 0.5  # m from the top of a trunk to its crown, at most: an estimate
_HALF_ROOF = 0.19  # of the width of a house: half the height of a usual roof, as in streets
_MOST_EMPTY = 2.0  # times the volume of parts that the box around one object has: an estimate


class UprightBox(NamedTuple):
    """A box on its base: the middle of the base (x, y, bottom) [m], yaw [rad], size (length, width, height) [m]."""

    x: float
    y: float
    bottom: float
    yaw: float
    size: Vector

    @classmethod
    def around(cls, parts: Sequence[Primitive]) -> UprightBox:
        """The box around shapes, with the yaw of the largest."""
        if len(parts) == 1:
            (part,) = parts
            x, y, z = part.center
            return cls(x, y, z - part.size[2] / 2, part.yaw, part.size)
        yaw = max(parts, key=lambda part: math.prod(part.size)).yaw
        low, high = corners_around(parts, yaw)
        u, v = (low[0] + high[0]) / 2, (low[1] + high[1]) / 2
        size = (high[0] - low[0], high[1] - low[1], high[2] - low[2])
        return cls(*point_at((0.0, 0.0, yaw), u, v), low[2], yaw, size)

    @property
    def place(self) -> Place:
        """x, y, yaw of the middle of its base."""
        return self.x, self.y, self.yaw

    def turned(self, quarters: int) -> UprightBox:
        """The same box with its x axis turned by quarters of a circle."""
        length, width, height = self.size
        size = (width, length, height) if quarters % 2 else self.size
        return self._replace(yaw=self.yaw + quarters * math.pi / 2, size=size)

    def lengthwise(self, times: float = 1.0) -> UprightBox:
        """The same box with x along its longer side, if that is more than `times` as long as the other."""
        return self.turned(1) if self.size[1] > times * self.size[0] else self


@dataclass(frozen=True, slots=True, eq=False)
class CoarseObject:
    """The primitives of one object, or of a rider and the machine, and the generator of its random numbers.

    `name` is the part of their ids before the dot. `owners` gives, by class, the name and instance of its parts.
    `seed` is that of the whole layout.
    """

    name: str
    parts: tuple[Primitive, ...]
    owners: dict[str, tuple[str, int]]
    seed: int
    rng: np.random.Generator

    @classmethod
    def of(cls, parts: Sequence[Primitive], seed: int, name: str) -> CoarseObject:
        """From the primitives of one object; its random numbers depend on `seed` and `name` alone."""
        owners = {part.label: (object_of(part), part.instance) for part in reversed(parts)}
        return cls(name, tuple(parts), owners, seed, generator_of(seed, name))

    def again(self) -> CoarseObject:
        """The same object with its random numbers from the start, for parts that are to be alike."""
        return replace(self, rng=generator_of(self.seed, self.name))

    @property
    def label(self) -> str:
        """The class of its first part."""
        return self.parts[0].label

    @property
    def word(self) -> str:
        """The word in its name: `car` for `car_3` and for `around/car_3`."""
        return self.name.rpartition("/")[2].rpartition("_")[0]

    def box(self) -> UprightBox:
        """The box around all its parts."""
        return UprightBox.around(self.parts)

    def placed(self) -> PlacedObject:
        """The object to which its coarse shapes belong (`objects.coarse_shapes`). An overhanging part gives the
        clearance; the shapes of a house have half of the roof."""
        box = self.box()
        length, width, height = box.size
        clearance = max(part.center[2] - part.size[2] / 2 for part in self.parts) - box.bottom
        if self.word == "house":
            clearance, height = height - _HALF_ROOF * width, height + _HALF_ROOF * width
        return PlacedObject(
            kind=self.word, id=self.name, x=box.x, y=box.y, z=box.bottom, level=box.bottom, yaw=self.parts[0].yaw,
            size=(length, width, height), clearance=clearance, instance=min(part.instance for part in self.parts),
        )  # fmt: skip

    def labelled(self, label: str) -> list[Primitive]:
        """Its parts of one class."""
        return [part for part in self.parts if part.label == label]


def coarse_objects(layout: Layout, seed: int, *, clustered: bool = False) -> Iterator[CoarseObject]:
    """The objects of `layout` except ground, in order; a rider comes with the machine, a trunk with its crown.

    In a `clustered` layout, trunks and pieces of crowns stay apart. Objects with a material, a mesh or an extinction
    are not coarse and are left out.
    """
    groups: dict[str, list[Primitive]] = {}
    for primitive in layout:
        if primitive.label not in GROUND:
            groups.setdefault(object_of(primitive), []).append(primitive)
    groups = {name: parts for name, parts in groups.items() if all(map(_is_coarse, parts))}
    machines = [parts for parts in groups.values() if len(parts) == 1 and parts[0].label in _MACHINES]
    ridden: set[str] = set()
    for parts in groups.values():
        if len(parts) == 1 and parts[0].label == "rider":
            machine = _nearest(parts[0], [m for m in machines if object_of(m[0]) not in ridden])
            if machine is not None:
                ridden.add(object_of(machine[0]))
                parts.extend(machine)
    joined: set[str] = set() if clustered else _join_crowns(groups)
    for name, parts in groups.items():
        if name not in ridden | joined:
            apart = _apart(parts)
            yield from (CoarseObject.of(one, seed, name if len(apart) == 1 else one[0].id) for one in apart)


def _is_coarse(part: Primitive) -> bool:
    return part.material is None and part.mesh is None and part.extinction is None and part.shape != "plane"


def _apart(parts: list[Primitive]) -> list[list[Primitive]]:
    """The parts of one name by object: several things may share a name, such as `car.1` and `car.2`."""
    if len(parts) == 1 or not BY_NAME[parts[0].label].is_thing:
        return [parts]
    ridden = [part for part in parts if part.label in _MACHINES]
    if len(parts) == 2 and len(ridden) == 1 and any(part.label == "rider" for part in parts):
        return [parts]
    numbered: dict[tuple[str, int], list[Primitive]] = {}
    for part in parts:
        numbered.setdefault((part.label, part.instance), []).append(part)
    apart = []
    for one in numbered.values():
        whole = math.prod(UprightBox.around(one).size)
        together = whole <= _MOST_EMPTY * sum(math.prod(part.size) for part in one)
        apart += [one] if together else [[part] for part in one]
    return apart


def generator_of(seed: int, name: str) -> np.random.Generator:
    """The random numbers of the object of that name, the same on every machine."""
    digest = hashlib.blake2b(f"{seed} {name}".encode(), digest_size=8).digest()
    return np.random.Generator(np.random.SFC64(int.from_bytes(digest, "little")))


def _join_crowns(groups: dict[str, list[Primitive]]) -> set[str]:
    """Add to each single trunk the crown over it, if any; returns the names of these crowns."""
    alone = [parts for parts in groups.values() if len(parts) == 1]
    crowns = [parts[0] for parts in alone if (parts[0].label, parts[0].shape) == ("vegetation", "ellipsoid")]
    joined: set[str] = set()
    for parts in alone:
        if (parts[0].label, parts[0].shape) == ("trunk", "cylinder"):
            crown = next((one for one in crowns if object_of(one) not in joined and _over(one, parts[0])), None)
            if crown is not None:
                joined.add(object_of(crown))
                parts.append(crown)
    return joined


def _over(crown: Primitive, trunk: Primitive) -> bool:
    """Whether a trunk ends in a crown, or just under it, in the middle half of its width."""
    aside = math.hypot(crown.center[0] - trunk.center[0], crown.center[1] - trunk.center[1])
    foot, head = (trunk.center[2] + side * trunk.size[2] / 2 for side in (-1, 1))
    low, high = (crown.center[2] + side * crown.size[2] / 2 for side in (-1, 1))
    return aside <= min(crown.size[:2]) / 4 and foot < low <= head + _CROWN_OVER and head <= high


def _nearest(rider: Primitive, machines: list[list[Primitive]]) -> list[Primitive] | None:
    x, y, _ = rider.center
    found, least = None, _RIDES_WITHIN
    for machine in machines:
        away = math.hypot(machine[0].center[0] - x, machine[0].center[1] - y)
        if away < least:
            found, least = machine, away
    return found
