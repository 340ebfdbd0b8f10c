"""The things of a plan as coarse shapes: what a kind looks like, with the spread of sizes that kind has."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from lidardraft.semantics import BY_NAME

STRIPS = ("hedge", "fence", "wall")
_SEGMENT = 4.0  # m; the chord of a 90 m bend leaves the arc by 2 cm


class Part(NamedTuple):
    """A shape of a thing: x forward, y left and z up from the middle of its footprint on the ground [m]."""

    name: str
    shape: str
    center: tuple[float, float, float]
    size: tuple[float, float, float]
    label: str


def thing(kind: str, rng: np.random.Generator, *, parked: bool = False, bent: bool = False) -> list[Part]:
    """The parts of one thing of a kind of the plan, in a size of its own; a single part has an empty name.

    Two-wheelers have a rider unless `parked`; strips come in short segments where the road is `bent`.
    """
    if kind in _VEHICLE_SIZES:
        return [_standing_box(_VEHICLE_LABELS.get(kind, kind), _jitter(rng, _VEHICLE_SIZES[kind], (0.10, 0.04, 0.08)))]
    if kind in ("bicycle", "motorcycle"):
        return _two_wheeler(kind, rng, parked)
    if kind in STRIPS:
        return _strip(kind, rng, bent)
    if kind in _BOXES:
        label, low, high = _BOXES[kind]
        return [_standing_box(label, tuple(rng.uniform(low, high).tolist()))]
    return _COMPOSED[kind](rng)


# Vans are cars in Cityscapes. Sizes not in the class table: common European vans.
_VEHICLE_LABELS = {"van": "car", "tram": "train"}
_VEHICLE_SIZES = {
    "van": (5.3, 2.0, 2.2),
    **{kind: BY_NAME[_VEHICLE_LABELS.get(kind, kind)].size for kind in ("car", "truck", "bus", "tram")},
}

# Smallest and largest (length along the road, depth, height) [m].
_BOXES: dict[str, tuple[str, tuple[float, float, float], tuple[float, float, float]]] = {
    "person": ("person", (0.4, 0.45, 1.5), (0.8, 0.65, 1.9)),
    "house": ("building", (8.0, 7.0, 5.0), (13.0, 10.0, 8.5)),
    "building": ("building", (12.0, 10.0, 9.0), (22.0, 14.0, 20.0)),
    "bin": ("other", (0.5, 0.5, 0.9), (0.8, 0.7, 1.2)),
    "bench": ("other", (1.4, 0.5, 0.75), (1.9, 0.6, 0.9)),
}

# Label, then smallest and largest (length, thickness, height) [m].
_STRIP_SIZES: dict[str, tuple[str, tuple[float, float, float], tuple[float, float, float]]] = {
    "hedge": ("vegetation", (6.0, 0.6, 0.9), (16.0, 1.2, 2.0)),
    "fence": ("fence", (10.0, 0.06, 0.9), (30.0, 0.15, 1.8)),
    "wall": ("wall", (10.0, 0.2, 1.5), (30.0, 0.4, 3.0)),
}


def _standing_box(label: str, size: tuple[float, float, float], name: str = "") -> Part:
    return Part(name, "box", (0.0, 0.0, size[2] / 2), size, label)


def _jitter(
    rng: np.random.Generator, typical: tuple[float, float, float] | None, spread: tuple[float, float, float]
) -> tuple[float, float, float]:
    assert typical is not None
    length, width, height = np.array(typical) * (1.0 + np.array(spread) * rng.uniform(-1, 1, 3))
    return float(length), float(width), float(height)


def _two_wheeler(kind: str, rng: np.random.Generator, parked: bool) -> list[Part]:
    size = _jitter(rng, BY_NAME[kind].size, (0.08, 0.1, 0.06))
    bike = _standing_box(kind, size, "" if parked else kind)
    if parked:
        return [bike]
    seat, top = 0.6 * size[2], float(rng.uniform(1.6, 1.85))
    rider = Part("rider", "box", (-0.1, 0.0, (seat + top) / 2), (0.7, 0.55, top - seat), "rider")
    return [bike, rider]


def _strip(kind: str, rng: np.random.Generator, bent: bool) -> list[Part]:
    label, low, high = _STRIP_SIZES[kind]
    length, thickness, height = rng.uniform(low, high).tolist()
    count = math.ceil(length / _SEGMENT) if bent else 1
    step = length / count
    return [
        Part(
            str(i + 1) if bent else "",
            "box",
            ((i + 0.5) * step - length / 2, 0.0, height / 2),
            (step, thickness, height),
            label,
        )
        for i in range(count)
    ]


def _tree(rng: np.random.Generator) -> list[Part]:
    height, crown, stem = rng.uniform(5.0, 10.0), rng.uniform(2.8, 5.0), rng.uniform(0.25, 0.5)
    clear = float(rng.uniform(1.6, 2.4))
    trunk = clear + 0.25 * (height - clear)
    return [
        Part("trunk", "cylinder", (0.0, 0.0, trunk / 2), (stem, stem, trunk), "trunk"),
        Part("crown", "ellipsoid", (0.0, 0.0, (clear + height) / 2), (crown, crown, height - clear), "vegetation"),
    ]


def _bush(rng: np.random.Generator) -> list[Part]:
    width, height = float(rng.uniform(0.8, 2.2)), float(rng.uniform(0.7, 1.8))
    return [Part("", "ellipsoid", (0.0, 0.0, height / 2), (width, width, height), "vegetation")]


def _garden(rng: np.random.Generator) -> list[Part]:
    """A low hedge along the street side (y = 0) with bushes behind it (y > 0)."""
    length, height = float(rng.uniform(5.0, 9.0)), float(rng.uniform(0.6, 1.1))
    parts = [Part("hedge", "box", (0.0, 0.0, height / 2), (length, 0.6, height), "vegetation")]
    for number, x in enumerate((-length / 3, 0.0, length / 3), start=1):
        size = float(rng.uniform(0.7, 1.2))
        parts.append(Part(f"bush_{number}", "ellipsoid", (x, 1.3, size / 2), (size, size, size), "vegetation"))
    return parts


def _pole(rng: np.random.Generator) -> list[Part]:
    width, height = float(rng.uniform(0.1, 0.2)), float(rng.uniform(2.5, 5.0))
    return [Part("", "cylinder", (0.0, 0.0, height / 2), (width, width, height), "pole")]


def _street_light(rng: np.random.Generator) -> list[Part]:
    height = float(rng.uniform(6.0, 8.5))
    return [
        Part("mast", "cylinder", (0.0, 0.0, height / 2), (0.18, 0.18, height), "pole"),
        Part("lamp", "box", (0.0, -0.5, height), (0.3, 1.2, 0.15), "pole"),
    ]


def _traffic_light(rng: np.random.Generator) -> list[Part]:
    height = float(rng.uniform(2.2, 3.0))
    return [
        Part("pole", "cylinder", (0.0, 0.0, height / 2), (0.15, 0.15, height), "pole"),
        Part("light", "box", (0.0, 0.0, height + 0.45), (0.35, 0.35, 0.9), "traffic-light"),
    ]


def _traffic_sign(rng: np.random.Generator) -> list[Part]:
    height, width = float(rng.uniform(2.0, 2.6)), float(rng.uniform(0.6, 0.9))
    return [
        Part("pole", "cylinder", (0.0, 0.0, height / 2), (0.08, 0.08, height), "pole"),
        Part("sign", "box", (-0.08, 0.0, height - width / 2), (0.05, width, width), "traffic-sign"),
    ]


_COMPOSED = {
    "tree": _tree,
    "bush": _bush,
    "garden": _garden,
    "pole": _pole,
    "street-light": _street_light,
    "traffic-light": _traffic_light,
    "traffic-sign": _traffic_sign,
}
