"""What an object that a sentence asks for is made of: a few coarse shapes, in sizes that such objects have.

Sizes are (length, width, height) [m]; numbers without a source are estimates of ours.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

Size = tuple[float, float, float]

TRUNK_DIAMETER = (0.25, 0.5)  # m, smallest and largest
CROWN_BASE = (1.6, 2.4)  # m from the ground to where a crown begins, smallest and largest
TRUNK_IN_CROWN = 0.25  # of the height of the crown: so far the trunk rises into it
_LAMP_HEIGHT = 0.9  # m, of the box of a traffic light
_HEDGE_HEIGHT = (0.6, 1.1)  # m, of a garden; that of its bushes, and how far behind the hedge they stand
_BUSH_HEIGHT, _BUSHES_BEHIND = (0.7, 1.2), 1.3
_SADDLE = 0.6  # of the height of a two-wheeler
_RIDER_TOP = (1.6, 1.85)  # m
_CONE_FOOT = 0.04  # m high
STANDING = 0.5  # m over the ground, under which parts begin that stand on it
_SEGMENT = 4.0  # m; the chord of a 90 m bend leaves the arc by 2 cm


class ObjectPart(NamedTuple):
    """One shape of an object: x forward, y left and z up from the middle of its footprint on the ground [m]."""

    name: str
    shape: str
    center: tuple[float, float, float]
    size: Size
    label: str


@dataclass(frozen=True, slots=True)
class SizeBetween:
    """Sizes spread evenly between a smallest and a largest."""

    smallest: Size
    largest: Size

    def sample(self, rng: np.random.Generator) -> Size:
        """One of these sizes."""
        length, width, height = rng.uniform(self.smallest, self.largest).tolist()
        return length, width, height


@dataclass(frozen=True, slots=True)
class SizeAround:
    """Sizes spread evenly around a typical one: by a share of each extent, up and down."""

    typical: Size
    spread: tuple[float, float, float]

    @property
    def smallest(self) -> Size:
        """The smallest of these sizes, to the millimetre."""
        return self._scaled(-1.0)

    @property
    def largest(self) -> Size:
        """The largest of these sizes, to the millimetre."""
        return self._scaled(1.0)

    def _scaled(self, by: float) -> Size:
        x, y, z = (
            round(typical * (1.0 + by * share), 3) for typical, share in zip(self.typical, self.spread, strict=True)
        )
        return x, y, z

    def sample(self, rng: np.random.Generator) -> Size:
        """One of these sizes."""
        x, y, z = (np.array(self.typical) * (1.0 + np.array(self.spread) * rng.uniform(-1, 1, 3))).tolist()
        return x, y, z


Sizes = SizeBetween | SizeAround


def sample_box(sizes: Sizes, label: str, rng: np.random.Generator) -> list[ObjectPart]:
    """One box."""
    return [_standing("", "box", sizes.sample(rng), label)]


def with_rider(machine: ObjectPart, rng: np.random.Generator) -> list[ObjectPart]:
    """A two-wheeler and who rides it."""
    saddle, top = _SADDLE * machine.size[2], float(rng.uniform(*_RIDER_TOP))
    rider = ObjectPart("rider", "box", (-0.1, 0.0, (saddle + top) / 2), (0.7, 0.55, top - saddle), "rider")
    return [machine._replace(name=machine.label), rider]


def in_segments(strip: ObjectPart) -> list[ObjectPart]:
    """A long box in short ones, so that they can follow a bend."""
    length, thickness, height = strip.size
    count = math.ceil(length / _SEGMENT)
    step, size = length / count, (length / count, thickness, height)
    centers = [((number + 0.5) * step - length / 2, 0.0, height / 2) for number in range(count)]
    return [strip._replace(name=str(k), center=center, size=size) for k, center in enumerate(centers, start=1)]


def extents(parts: Sequence[ObjectPart]) -> Size:
    """Length, width and height [m] of the upright box around all parts, about the middle of their footprint."""
    length, width = (2 * max(abs(part.center[axis]) + part.size[axis] / 2 for part in parts) for axis in (0, 1))
    return length, width, max(part.center[2] + part.size[2] / 2 for part in parts)


def resized(parts: list[ObjectPart], by: Size) -> list[ObjectPart]:
    """The parts of an object stretched along each of its axes."""

    def scaled(extents: Size) -> Size:
        return extents[0] * by[0], extents[1] * by[1], extents[2] * by[2]

    return [part._replace(center=scaled(part.center), size=scaled(part.size)) for part in parts]


def tree_parts(height: float, crown: float, trunk: float, base: float) -> list[ObjectPart]:
    """A tree `height` high with a crown `crown` wide from `base` up, and a trunk `trunk` thick [m]."""
    top = base + TRUNK_IN_CROWN * (height - base)
    return [
        _standing("trunk", "cylinder", (trunk, trunk, top), "trunk"),
        ObjectPart("crown", "ellipsoid", (0.0, 0.0, (base + height) / 2), (crown, crown, height - base), "vegetation"),
    ]


def street_light_parts(height: float) -> list[ObjectPart]:
    """A mast `height` [m] high with its lamp over the road, to the right."""
    return [
        _standing("mast", "cylinder", (0.18, 0.18, height), "pole"),
        ObjectPart("lamp", "box", (0.0, -0.5, height), (0.3, 1.2, 0.15), "pole"),
    ]


def traffic_light_parts(pole_height: float) -> list[ObjectPart]:
    """A pole `pole_height` [m] high with the box of the lights on top."""
    return [
        _standing("pole", "cylinder", (0.15, 0.15, pole_height), "pole"),
        ObjectPart(
            "light", "box", (0.0, 0.0, pole_height + _LAMP_HEIGHT / 2), (0.35, 0.35, _LAMP_HEIGHT), "traffic-light"
        ),
    ]


def traffic_sign_parts(height: float, width: float) -> list[ObjectPart]:
    """A pole `height` [m] high with a square plate `width` [m] wide at its top, towards who comes."""
    return [
        _standing("pole", "cylinder", (0.08, 0.08, height), "pole"),
        ObjectPart("sign", "box", (-0.08, 0.0, height - width / 2), (0.05, width, width), "traffic-sign"),
    ]


def sample_tree(sizes: Sizes, _label: str, rng: np.random.Generator) -> list[ObjectPart]:
    """A trunk and a crown."""
    height, crown = between(sizes, 2, rng), between(sizes, 0, rng)
    trunk = float(rng.uniform(*TRUNK_DIAMETER))
    return tree_parts(height, crown, trunk, float(rng.uniform(*CROWN_BASE)))


def sample_round(shape: str, sizes: Sizes, label: str, rng: np.random.Generator) -> list[ObjectPart]:
    """One shape that is round seen from above."""
    width, height = between(sizes, 0, rng), between(sizes, 2, rng)
    return [_standing("", shape, (width, width, height), label)]


def sample_garden(sizes: Sizes, label: str, rng: np.random.Generator) -> list[ObjectPart]:
    """A low hedge along the street (y = 0) with bushes behind it (y > 0)."""
    length, height = between(sizes, 0, rng), float(rng.uniform(*_HEDGE_HEIGHT))
    parts = [_standing("hedge", "box", (length, 0.6, height), label)]
    for number, x in enumerate((-length / 3, 0.0, length / 3), start=1):
        size = float(rng.uniform(*_BUSH_HEIGHT))
        center = (x, _BUSHES_BEHIND, size / 2)
        parts.append(ObjectPart(f"bush_{number}", "ellipsoid", center, (size, size, size), label))
    return parts


def sample_cone(sizes: Sizes, label: str, rng: np.random.Generator) -> list[ObjectPart]:
    """A square foot and a cylinder as wide as the cone is in its middle."""
    foot, height = between(sizes, 0, rng), between(sizes, 2, rng)
    body = (0.5 * foot, 0.5 * foot, height - _CONE_FOOT)
    return [
        _standing("foot", "box", (foot, foot, _CONE_FOOT), label),
        ObjectPart("body", "cylinder", (0.0, 0.0, _CONE_FOOT + body[2] / 2), body, label),
    ]


def sample_traffic_light(sizes: Sizes, _label: str, rng: np.random.Generator) -> list[ObjectPart]:
    """A pole and its lights."""
    return traffic_light_parts(float(rng.uniform(sizes.smallest[2] - _LAMP_HEIGHT, sizes.largest[2] - _LAMP_HEIGHT)))


def _standing(name: str, shape: str, size: Size, label: str) -> ObjectPart:
    return ObjectPart(name, shape, (0.0, 0.0, size[2] / 2), size, label)


def between(sizes: Sizes, axis: int, rng: np.random.Generator) -> float:
    """An extent along one axis [m] between the smallest and the largest."""
    return float(rng.uniform(sizes.smallest[axis], sizes.largest[axis]))
