"""Plants: trees with boughs, hedges, and shapes of foliage as media."""

from __future__ import annotations

from functools import partial

import numpy as np

from lidardraft.objects import plants
from lidardraft.scene.layout import Primitive
from lidardraft.simulation.coarse_object import CoarseObject, UprightBox
from lidardraft.simulation.fitting import fitted, medium, solid
from lidardraft.simulation.surroundings import Surroundings

# Extinction is 0.5 times leaf-area density, see `objects/plants.py`; an index of 3.5 over the height, as of bushes and
# small trees, and what narrows towards its top is denser.
_LEAF_AREA, _NARROWING = 0.5 * 3.5, 1.5
_SPREAD = 0.25  # deviation of the logarithm of densities
_CORE, _CORE_DENSER = 0.6, 2.0  # twigs in the middle: share of the extents; times as dense
# Mean free paths through a piece of a crown that a clustering cut: of 3, 4, 5, 6 and 8, PandaSet's foliage is as rough
# with 4 or 5 and reads as bright with 5 or more.
_PIECE_PATHS = 5.0


def plant(coarse: CoarseObject, surroundings: Surroundings) -> list[Primitive]:
    """A tree where there is one crown over one trunk; else each shape on its own."""
    trunks, foliage = coarse.labelled("trunk"), coarse.labelled("vegetation")
    if len(trunks) == 1 and len(foliage) == 1 and foliage[0].shape == "ellipsoid" and trunks[0].shape == "cylinder":
        return _tree(coarse, trunks[0], foliage[0])
    made = [solid(trunk) for trunk in trunks]
    for part in foliage:
        made += _hedge(coarse, part) if part.shape == "box" else _tuft(coarse, part, surroundings)
    return made


def _tree(coarse: CoarseObject, trunk: Primitive, crown: Primitive) -> list[Primitive]:
    """Boughs and lobes of a tree in leaf in the crown's box, and the trunk where it is and as thick as it is."""
    foot = trunk.center[2] - trunk.size[2] / 2
    x, y, _ = crown.center
    length, width, _ = crown.size
    top = crown.center[2] + crown.size[2] / 2
    box = UprightBox(x, y, foot, crown.yaw, (length, width, top - foot))
    clearance = max(crown.center[2] - crown.size[2] / 2 - foot, 0.0)
    parts = fitted(coarse, "tree", box, clearance=clearance, build=partial(plants.tree, bare=False))
    a, b, _ = trunk.size
    high = max(parts[0].size[2], trunk.size[2])
    center = (trunk.center[0], trunk.center[1], foot + high / 2)
    parts[0] = Primitive.unchecked(
        **{name: getattr(parts[0], name) for name in parts[0].__slots__} | {"size": (a, b, high), "center": center}
    )
    return parts


def _hedge(coarse: CoarseObject, part: Primitive) -> list[Primitive]:
    box = UprightBox.around([part])
    return fitted(coarse, "hedge", box.turned(1) if box.size[1] > box.size[0] else box)


def _tuft(coarse: CoarseObject, part: Primitive, surroundings: Surroundings) -> list[Primitive]:
    """A shape of foliage as a medium; where it is no piece of a clustering, with denser twigs in its middle."""
    if part.shape not in ("ellipsoid", "cylinder"):
        return [part]
    if surroundings.clustered:
        return [medium(part, _PIECE_PATHS / min(part.size))]
    density = _NARROWING * _LEAF_AREA / part.size[2] * float(np.exp(coarse.rng.normal(0.0, _SPREAD)))
    return [medium(part, density), medium(part, _CORE_DENSER * density, _CORE)]
