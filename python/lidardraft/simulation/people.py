"""People on foot, and riders as one with what they ride."""

from __future__ import annotations

from lidardraft.scene.layout import Primitive
from lidardraft.simulation.coarse_object import CoarseObject
from lidardraft.simulation.fitting import fitted
from lidardraft.simulation.surroundings import Surroundings

_PROUD = (0.03, 0.03, 0.0)
_MACHINE_PROUD = (0.06, 0.06, 0.0)
_RIDDEN_FROM, _RIDDEN_LENGTH = 1.3, 1.2  # m of height, or of length: a rider without a machine has one in the box


def person(coarse: CoarseObject, surroundings: Surroundings) -> list[Primitive]:
    """Someone in a gait as long as the box."""
    box = coarse.box()
    if box.size[1] > 1.2 * box.size[0]:
        box = box.turned(1)
    return fitted(coarse, "person", surroundings.headed(coarse, box), proud=_PROUD)


def rider(coarse: CoarseObject, surroundings: Surroundings) -> list[Primitive]:
    """A rider and what is ridden, where it is not known a bicycle; a rider in a small box without one."""
    box = coarse.box()
    if box.size[1] > box.size[0]:
        box = box.turned(1)
    box = surroundings.headed(coarse, box)
    kind = "motorcyclist" if coarse.labelled("motorcycle") else "cyclist"
    if len(coarse.owners) > 1 or box.size[2] >= _RIDDEN_FROM or box.size[0] >= _RIDDEN_LENGTH:
        return fitted(coarse, kind, box, proud=_MACHINE_PROUD)
    return fitted(coarse, "person", box, proud=_PROUD)


def machine(coarse: CoarseObject, surroundings: Surroundings) -> list[Primitive]:
    """A bicycle or a motorcycle without a rider."""
    box = coarse.box()
    if box.size[1] > box.size[0]:
        box = box.turned(1)
    return fitted(coarse, coarse.label, surroundings.headed(coarse, box), proud=_MACHINE_PROUD)
