"""Street furniture and what else has no class of its own: bins, benches, shelters, cabinets."""

from __future__ import annotations

from lidardraft.objects.kinds import KINDS
from lidardraft.scene.layout import Primitive
from lidardraft.simulation.coarse_object import CoarseObject, UprightBox
from lidardraft.simulation.fitting import fitted, solid
from lidardraft.simulation.surroundings import Surroundings

_GUESSED = ("bench", "shelter", "bin", "cabinet")  # kinds that a box may be, in this order
_PROUD = (0.1, 0.1, 0.0)  # m: handles, lids and roofs


def other(coarse: CoarseObject, _surroundings: Surroundings) -> list[Primitive]:
    """What its name says (`bench_2` is a bench), or a kind that has such extents; else as it is."""
    named = coarse.word if "other" in KINDS.get(coarse.word, KINDS["tree"]).labels else None
    if len(coarse.parts) > 1 or coarse.parts[0].shape != "box":
        return [solid(part) for part in coarse.parts]
    box = coarse.box()
    for kind in (named,) if named else _GUESSED:
        for turned in (box, box.turned(1)):
            if named or _is_in(turned, kind):
                return fitted(coarse, kind, turned, proud=_PROUD)
    return [solid(coarse.parts[0])]


def _is_in(box: UprightBox, kind: str) -> bool:
    low, high = KINDS[kind].extents or (box.size, box.size)
    return all(a <= extent <= b for a, extent, b in zip(low, box.size, high, strict=True))
