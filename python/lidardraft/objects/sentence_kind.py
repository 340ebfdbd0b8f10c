"""The properties of a kind that sentences can request: its sizes and parts, its place and its motion."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass
from typing import NamedTuple

import numpy as np

from lidardraft.objects.coarse_shapes import (
    CROWN_BASE,
    TRUNK_DIAMETER,
    CoarseShape,
    on_post,
    rider_on,
    standing,
    street_light_parts,
    tree_parts,
)
from lidardraft.objects.placed_object import Vector

_HEDGE_HEIGHT = (0.6, 1.1)  # m, of a garden; that of its bushes, and their distance behind the hedge
_BUSH_HEIGHT, _BUSHES_BEHIND = (0.7, 1.2), 1.3
_RIDER_TOP = (1.6, 1.85)  # m
_CONE_FOOT = 0.04  # m high
_LIGHTS_HEIGHT = 0.9  # m, of the box of a traffic light


@dataclass(frozen=True, slots=True)
class SizeBetween:
    """Sizes spread evenly between a smallest and a largest."""

    smallest: Vector
    largest: Vector

    def sample(self, rng: np.random.Generator) -> Vector:
        """One of these sizes."""
        length, width, height = rng.uniform(self.smallest, self.largest).tolist()
        return length, width, height


@dataclass(frozen=True, slots=True)
class SizeAround:
    """Sizes spread evenly around a typical one: by a share of each extent, up and down."""

    typical: Vector
    spread: tuple[float, float, float]

    @property
    def smallest(self) -> Vector:
        """The smallest of these sizes, to the millimetre."""
        return self._scaled(-1.0)

    @property
    def largest(self) -> Vector:
        """The largest of these sizes, to the millimetre."""
        return self._scaled(1.0)

    def _scaled(self, by: float) -> Vector:
        x, y, z = (round(one * (1.0 + by * share), 3) for one, share in zip(self.typical, self.spread, strict=True))
        return x, y, z

    def sample(self, rng: np.random.Generator) -> Vector:
        """One of these sizes."""
        x, y, z = (np.array(self.typical) * (1.0 + np.array(self.spread) * rng.uniform(-1, 1, 3))).tolist()
        return x, y, z


Sizes = SizeBetween | SizeAround


def sample_box(sizes: Sizes, label: str, rng: np.random.Generator) -> list[CoarseShape]:
    """One box."""
    return [standing("box", sizes.sample(rng), label)]


def with_rider(machine: CoarseShape, rng: np.random.Generator) -> list[CoarseShape]:
    """A two-wheeler and its rider."""
    return [machine._replace(name=machine.label), rider_on(machine, float(rng.uniform(*_RIDER_TOP)), name="rider")]


def sample_tree(sizes: Sizes, _label: str, rng: np.random.Generator) -> list[CoarseShape]:
    """A trunk and a crown."""
    height, crown = between(sizes, 2, rng), between(sizes, 0, rng)
    trunk = float(rng.uniform(*TRUNK_DIAMETER))
    return tree_parts(height, crown, trunk, float(rng.uniform(*CROWN_BASE)))


def sample_round(shape: str, sizes: Sizes, label: str, rng: np.random.Generator) -> list[CoarseShape]:
    """One shape that is round from above."""
    width, height = between(sizes, 0, rng), between(sizes, 2, rng)
    return [standing(shape, (width, width, height), label)]


def sample_garden(sizes: Sizes, label: str, rng: np.random.Generator) -> list[CoarseShape]:
    """A low hedge along the street (y = 0) with bushes behind it (y > 0)."""
    length, height = between(sizes, 0, rng), float(rng.uniform(*_HEDGE_HEIGHT))
    parts = [standing("box", (length, 0.6, height), label, "hedge")]
    for number, x in enumerate((-length / 3, 0.0, length / 3), start=1):
        size = float(rng.uniform(*_BUSH_HEIGHT))
        center = (x, _BUSHES_BEHIND, size / 2)
        parts.append(CoarseShape("ellipsoid", center, (size, size, size), label, name=f"bush_{number}"))
    return parts


def sample_cone(sizes: Sizes, label: str, rng: np.random.Generator) -> list[CoarseShape]:
    """A square foot and a cylinder as wide as the middle of the cone."""
    foot, height = between(sizes, 0, rng), between(sizes, 2, rng)
    body = (0.5 * foot, 0.5 * foot, height - _CONE_FOOT)
    return [
        standing("box", (foot, foot, _CONE_FOOT), label, "foot"),
        CoarseShape("cylinder", (0.0, 0.0, _CONE_FOOT + body[2] / 2), body, label, name="body"),
    ]


def sample_animal(sizes: Sizes, label: str, rng: np.random.Generator) -> list[CoarseShape]:
    """A body on four legs, and a head."""
    length, width, height = sizes.sample(rng)
    leg, belly = 0.18 * width, 0.45 * height
    legs = [(x, y, belly / 2) for x in (-0.3 * length, 0.25 * length) for y in (-0.3 * width, 0.3 * width)]
    return [
        CoarseShape(
            "ellipsoid", (-0.05 * length, 0.0, 0.65 * height), (0.9 * length, width, 0.45 * height), label, name="body"
        ),
        CoarseShape(
            "ellipsoid",
            (0.4 * length, 0.0, 0.85 * height),
            (0.2 * length, 0.4 * width, 0.3 * height),
            label,
            name="head",
        ),
        *(
            CoarseShape("cylinder", center, (leg, leg, belly), label, name=f"leg_{number}")
            for number, center in enumerate(legs, start=1)
        ),
    ]


def sample_street_light(sizes: Sizes, _label: str, rng: np.random.Generator) -> list[CoarseShape]:
    """A mast and its lamp."""
    return street_light_parts(between(sizes, 2, rng))


def sample_traffic_light(sizes: Sizes, label: str, rng: np.random.Generator) -> list[CoarseShape]:
    """A pole and its lights."""
    height = between(sizes, 2, rng)
    return on_post(label, (*sizes.smallest[:2], height), height - _LIGHTS_HEIGHT)


def sample_traffic_sign(sizes: Sizes, label: str, rng: np.random.Generator) -> list[CoarseShape]:
    """A pole and a square plate."""
    height, width = between(sizes, 2, rng), between(sizes, 1, rng)
    return on_post(label, (sizes.smallest[0], width, height), height - width)


def between(sizes: Sizes, axis: int, rng: np.random.Generator) -> float:
    """An extent along one axis [m] between the smallest and the largest."""
    return float(rng.uniform(sizes.smallest[axis], sizes.largest[axis]))


class CountRanges(NamedTuple):
    """The fewest and most objects at one place for the words "few", "some" and "many"."""

    few: tuple[int, int] = (2, 3)
    some: tuple[int, int] = (2, 4)
    many: tuple[int, int] = (5, 7)


COUNTS = CountRanges._fields
_OTHERS = CountRanges((2, 3), (4, 6), (8, 11))


@dataclass(frozen=True, slots=True)
class SentenceKind:
    """One kind of object.

    `label` is the class of its largest part. `sizes` are those of the whole object, without a rider. They are None for
    the kind "vehicle", which stands for any kind with a `traffic_share`, its share of such traffic. Kinds of one
    `family` are named or left out together by the sentences of streets; those without one are always named. `shapes`
    samples the parts. `counts` gives the meaning of words for numbers. `surfaces` are those on which it can be
    requested; without any it is always behind the sidewalk. A `set_down` object is on the road by default. `precedence`
    is higher for kinds that are placed earlier, as they need more room or have less choice.

    `is_vehicle`, `cycles` and `walks` tell how it moves, if it does. `is_ridden` adds a rider unless it is parked.
    `lane_length` is its length of lane in traffic, with the usual gaps [m], and `parking_width` the width of its
    parking strip [m].

    `setback` is the distance of the middle of a roadside object behind the sidewalk [m]: usually between the first two
    numbers, and up to the third if there is no room; None is at the kerb. Its alignment varies by `yaw_deviation`
    [rad]; an `is_square` object is exactly along the road or across it. `follows_road` is for long strips that bend
    with the road; `at_junction` is for objects at the place of waiting traffic before a junction, if there is one.
    """

    name: str
    sizes: Sizes | None
    label: str
    _: KW_ONLY
    family: str = ""
    shapes: Callable[[Sizes, str, np.random.Generator], list[CoarseShape]] = sample_box
    counts: CountRanges = _OTHERS
    surfaces: tuple[str, ...] = ()
    precedence: int = 0
    set_down: bool = False
    is_vehicle: bool = False
    cycles: bool = False
    walks: bool = False
    is_ridden: bool = False
    traffic_share: float = 0.0
    lane_length: float = 12.0
    parking_width: float = 2.2
    setback: tuple[float, float, float] | None = None
    yaw_deviation: float = 0.0
    is_square: bool = False
    follows_road: bool = False
    at_junction: bool = False

    @property
    def plural(self) -> str:
        """The plural in messages."""
        name = self.name.replace("-", " ")
        return "people" if name == "person" else name + ("es" if name.endswith(("s", "ch", "sh")) else "s")

    @property
    def drives(self) -> bool:
        """Whether it moves in a lane."""
        return self.is_vehicle or self.cycles

    @property
    def on_road(self) -> bool:
        """Whether it may be on the road without a request."""
        return self.drives or self.walks or self.set_down

    def sample_parts(self, rng: np.random.Generator, *, parked: bool = False) -> list[CoarseShape]:
        """The parts of one object, in a random size; a single part has an empty name.

        An `is_ridden` object has a rider unless `parked`.
        """
        assert self.sizes is not None, f"{self.name} stands for other kinds"
        parts = self.shapes(self.sizes, self.label, rng)
        return with_rider(parts[0], rng) if self.is_ridden and not parked else parts
