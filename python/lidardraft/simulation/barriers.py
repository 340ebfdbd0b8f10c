"""Walls and fences: panels, palings, bars and meshes in the boxes that they were given as."""

from __future__ import annotations

from functools import partial

from lidardraft.objects import fences
from lidardraft.scene.layout import Primitive
from lidardraft.simulation.coarse_object import CoarseObject, UprightBox
from lidardraft.simulation.fitting import Build, fitted, solid
from lidardraft.simulation.surroundings import Surroundings

# Estimates of ours.
_GARDEN_WALL = 1.0  # m: lower walls are those of gardens
_THICK_WALL, _THICK_FENCE = 2.0, 0.8  # m: what is thicker is neither
_MESH, _MESH_FROM = 0.2, 4.0  # share of fences that are of wire mesh, of those longer than this [m]
_LEAST = (0.5, 0.3)  # m of length and height
_FENCES = ("mesh_fence", "barrier")  # kinds of fence that a name can say


def wall(coarse: CoarseObject, _surroundings: Surroundings) -> list[Primitive]:
    """Low walls with copings as of gardens, high ones of panels between posts."""
    made = []
    for part in coarse.parts:
        box = _lengthwise(part)
        kind = "garden_wall" if box.size[2] <= _GARDEN_WALL else "wall"
        made += _stretch_of(coarse, part, kind, box, _THICK_WALL)
    return made


def fence(coarse: CoarseObject, surroundings: Surroundings) -> list[Primitive]:
    """Fences of palings, iron bars or mesh, all segments of one alike; of a clustering, which has pieces of what sent
    back most rays, of close palings."""
    made = []
    for part in coarse.parts:
        alike, box = coarse.again(), _lengthwise(part)
        if surroundings.clustered:
            made += _stretch_of(alike, part, "fence", box, _THICK_FENCE, build=partial(fences.fence, dense=True))
            continue
        mesh = float(alike.rng.random()) < _MESH and max(box.size) > _MESH_FROM
        kind = coarse.word if coarse.word in _FENCES else "mesh_fence" if mesh else "fence"
        made += _stretch_of(alike, part, kind, box, _THICK_FENCE)
    return made


def _lengthwise(part: Primitive) -> UprightBox:
    box = UprightBox.around([part])
    return box.turned(1) if box.size[1] > box.size[0] else box


def _stretch_of(
    coarse: CoarseObject, part: Primitive, kind: str, box: UprightBox, thickest: float, *, build: Build | None = None
) -> list[Primitive]:
    length, thick, height = box.size
    if part.shape != "box" or length < _LEAST[0] or height < _LEAST[1] or thick > thickest:
        return [solid(part)]
    return fitted(coarse, kind, box, build=build)
