"""Vehicles, riders and people: the body nearest to the box, stretched to it; people in a gait as long as it."""

from __future__ import annotations

import math

import numpy as np

from lidardraft.objects.cars import BODIES, SHARES
from lidardraft.objects.placed_object import Vector
from lidardraft.scene.layout import Primitive
from lidardraft.simulation.detail.coarse_object import CoarseObject, UprightBox
from lidardraft.simulation.detail.fitting import fitted
from lidardraft.simulation.detail.surroundings import Surroundings

_SIDEWAYS = 1.25  # times as wide as long: the vehicle in the box stands across it
_TRIM_PROUD = (0.08, 0.13, 0.0)  # m that plates and mirrors stand out of a box
_NEAR = 0.08  # deviation of the logarithms of sizes within which bodies compete
_TRAILER_FROM = 12.6  # m of length
_LOGS = {name: np.log(body.size) for name, body in BODIES.items()}
_NAMES, _SIZES = tuple(_LOGS), np.array(list(_LOGS.values()))
_COMMON = np.array([SHARES[name] for name in _NAMES])
_BODY_PROUD = (0.03, 0.03, 0.0)
_MACHINE_PROUD = (0.06, 0.06, 0.0)
_RIDDEN_FROM, _RIDDEN_LENGTH = 1.3, 1.2  # m of height, or of length: the box of a rider without a machine holds one


def car(coarse: CoarseObject, surroundings: Surroundings) -> list[Primitive]:
    """A passenger car or a van; `hatchback_3` is a hatchback."""
    box = _lengthwise(coarse, surroundings)
    name = coarse.word if coarse.word in BODIES else _nearest_body(box.size, float(coarse.rng.random()))
    return fitted(coarse, name, box, proud=_TRIM_PROUD)


def heavy(coarse: CoarseObject, surroundings: Surroundings) -> list[Primitive]:
    """A bus, a tram, or a rigid truck; trucks longer than 12.6 m are tractors with trailers."""
    box = _lengthwise(coarse, surroundings)
    kind = "bus" if "bus" in coarse.owners else "tram"
    if "truck" in coarse.owners:
        kind = "trailer_truck" if box.size[0] > _TRAILER_FROM else "truck"
    return fitted(coarse, kind, box, proud=_TRIM_PROUD)


def _lengthwise(coarse: CoarseObject, surroundings: Surroundings) -> UprightBox:
    """The box with its x axis along the heading of its vehicle."""
    return surroundings.headed(coarse, coarse.box().lengthwise(_SIDEWAYS))


def _nearest_body(size: Vector, chance: float) -> str:
    """The name of a body with the proportions of `size`; of several equally near, the commoner is likelier."""
    off = ((_SIZES - [math.log(extent) for extent in size]) / _NEAR) ** 2
    far = off.sum(axis=1)
    shares = np.cumsum(_COMMON * np.exp(-0.5 * (far - far.min())))
    return _NAMES[int(np.searchsorted(shares, chance * shares[-1]))]


def person(coarse: CoarseObject, surroundings: Surroundings) -> list[Primitive]:
    """A person in a gait as long as the box."""
    box = surroundings.headed(coarse, coarse.box().lengthwise(1.2))
    return fitted(coarse, "person", box, proud=_BODY_PROUD)


def rider(coarse: CoarseObject, surroundings: Surroundings) -> list[Primitive]:
    """A rider with the machine, a bicycle if unknown; a rider in a small box has none."""
    box = surroundings.headed(coarse, coarse.box().lengthwise())
    kind = "motorcyclist" if coarse.labelled("motorcycle") else "cyclist"
    if len(coarse.owners) > 1 or box.size[2] >= _RIDDEN_FROM or box.size[0] >= _RIDDEN_LENGTH:
        return fitted(coarse, kind, box, proud=_MACHINE_PROUD)
    return fitted(coarse, "person", box, proud=_BODY_PROUD)


def machine(coarse: CoarseObject, surroundings: Surroundings) -> list[Primitive]:
    """A bicycle or a motorcycle without a rider."""
    box = surroundings.headed(coarse, coarse.box().lengthwise())
    return fitted(coarse, coarse.label, box, proud=_MACHINE_PROUD)
