"""Street furniture and what else has no class of its own: bins, benches, shelters, cabinets."""

from __future__ import annotations

from lidardraft.objects.kinds import KINDS
from lidardraft.scene.layout import Primitive
from lidardraft.simulation.coarse_object import CoarseObject, UprightBox
from lidardraft.simulation.fitting import EXTENTS, fitted, solid
from lidardraft.simulation.surroundings import Surroundings

_GUESSED = ("bench", "shelter", "cabinet", "bin")  # kinds that a box may be, in this order


def other(coarse: CoarseObject, _surroundings: Surroundings) -> list[Primitive]:
    """What its name says (`bench_2` is a bench), or a kind that has such extents; else as it is."""
    named = coarse.word if "other" in KINDS.get(coarse.word, KINDS["tree"]).labels else None
    if len(coarse.parts) > 1 or coarse.parts[0].shape != "box":
        return [solid(coarse, part) for part in coarse.parts]
    box = coarse.box()
    for turn in (0, 1):
        turned = box.turned(turn)
        kind = named or next((kind for kind in _GUESSED if _is_in(turned, kind)), None)
        if kind is not None:
            return fitted(coarse, kind, turned, proud=(0.1, 0.1, 0.0))
    return [solid(coarse, coarse.parts[0])]


def _is_in(box: UprightBox, kind: str) -> bool:
    low, high = EXTENTS[kind]
    return all(a <= extent <= b for a, extent, b in zip(low, box.size, high, strict=True))
