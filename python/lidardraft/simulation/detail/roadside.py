"""Objects beside roads: poles with lamps, signs and signals; bins and benches; walls, fences and plants."""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from lidardraft.objects import fences, plants, signs
from lidardraft.objects.kinds import KINDS
from lidardraft.objects.object_builder import Add
from lidardraft.scene.layout import Primitive
from lidardraft.simulation.detail.coarse_object import CoarseObject, UprightBox
from lidardraft.simulation.detail.fitting import changed, fitted, medium, part_of, solid
from lidardraft.simulation.detail.surroundings import LANE_SIDE, Surroundings

_HEAD_PROUD = (0.3, 0.05, 0.0)  # m: shades of signals, plates before their posts
# Lamps [m], as of `objects/poles.py`: a luminaire at the end of an arm, and how thick the arm is.
_LUMINAIRE, _ARM = (0.6, 0.25, 0.14), 0.08
_LONG = 1.5  # times as long as wide: shorter boxes have no thin side
_GUESSED = ("bench", "shelter", "bin", "cabinet")  # kinds that a box may be, in this order
_FURNITURE_PROUD = (0.1, 0.1, 0.0)  # m: handles, lids and roofs
# Estimates.
_GARDEN_WALL = 1.0  # m: lower walls are those of gardens
_THICK_WALL, _THICK_FENCE = 2.0, 0.8  # m: thicker boxes are neither
_MESH, _MESH_FROM = 0.2, 4.0  # share of fences that are of wire mesh, of those longer than this [m]
_LEAST_BARRIER = (0.5, 0.3)  # m of length and height
_FENCES = ("mesh_fence", "barrier")  # kinds of fence that a name can give
# Extinction is 0.5 times leaf-area density, see `objects/plants.py`; the index is 3.5 over the height, as of bushes and
# small trees. Shapes that narrow towards the top are denser.
_LEAF_AREA, _NARROWING = 0.5 * 3.5, 1.5
_SPREAD = 0.25  # deviation of the logarithm of densities
_CORE, _CORE_DENSER = 0.6, 2.0  # twigs in the middle: share of the extents; times as dense
# Mean free paths through a piece of a crown of a clustering. Of 3, 4, 5, 6 and 8: PandaSet's foliage is as rough as
# with 4 or 5, and as bright as with 5 or more.
_PIECE_PATHS = 5.0


def pole(coarse: CoarseObject, surroundings: Surroundings) -> list[Primitive]:
    """Masts, lamps on arms, signs and signals, each part in its given place."""
    plates, lights = coarse.labelled("traffic-sign"), coarse.labelled("traffic-light")
    posts = [part for part in coarse.labelled("pole") if part.shape == "cylinder"]
    if len(posts) == 1 and len(plates) + len(lights) == 1 and len(coarse.parts) == 2:
        return _on_post(coarse, posts[0], (plates + lights)[0], surroundings)
    made: list[Primitive] = []
    for part in coarse.parts:
        if part.label == "traffic-sign":
            made += _plate(coarse, part, surroundings)
        elif part.label == "traffic-light" or part.shape not in ("cylinder", "box"):
            made.append(solid(part))
        elif part.shape == "cylinder":
            made += fitted(coarse, "pole", UprightBox.around([part]))
        elif posts:
            made += _lamp(coarse, posts[0], part)
        else:
            made.append(solid(part))
    return made


def _on_post(coarse: CoarseObject, post: Primitive, head: Primitive, surroundings: Surroundings) -> list[Primitive]:
    """A sign or a signal on its post, from the foot of one to the top of the other."""
    foot = min(post.center[2] - post.size[2] / 2, head.center[2] - head.size[2] / 2)
    top = max(post.center[2] + post.size[2] / 2, head.center[2] + head.size[2] / 2)
    box = _facing(UprightBox.around([head]), surroundings)
    x, y, _ = post.center
    whole = box._replace(x=x, y=y, bottom=foot, size=(*box.size[:2], top - foot))
    kind = "sign" if head.label == "traffic-sign" else "traffic_light"
    return fitted(coarse, kind, whole, clearance=max(box.bottom - foot, 0.0), proud=_HEAD_PROUD)


def _plate(coarse: CoarseObject, part: Primitive, surroundings: Surroundings) -> list[Primitive]:
    """A plate without a post; in a clustering, whose boxes are tight, it fills its box."""
    box = _facing(UprightBox.around([part]), surroundings)
    if part.shape != "box" or box.size[1] < _LONG * box.size[0]:
        return [solid(part)]
    add = partial(signs.sign, square=surroundings.clustered)
    return fitted(coarse, "sign", box, labels=("traffic-sign",), add=add)


def _facing(box: UprightBox, surroundings: Surroundings) -> UprightBox:
    """The box with its thin side ahead; if its front is unknown, it faces the traffic of its side."""
    if box.size[0] > _LONG * box.size[1]:
        box = box.turned(1)
    if not surroundings.clustered:
        return box
    # right-hand traffic: signs on the right face the ego vehicle, those on the left oncoming traffic
    ahead = math.cos(box.yaw)
    if abs(ahead) > math.sqrt(0.5):
        towards_ego = ahead < 0.0
        return box if towards_ego == (box.y < LANE_SIDE) else box.turned(2)
    return box if math.sin(box.yaw) * box.y < 0.0 else box.turned(2)


def _lamp(coarse: CoarseObject, post: Primitive, part: Primitive) -> list[Primitive]:
    """An arm from the mast to the far end of the lamp's box, and the luminaire there."""
    box = UprightBox.around([part]).lengthwise()
    cos, sin = math.cos(box.yaw), math.sin(box.yaw)
    along = (box.x - post.center[0]) * cos + (box.y - post.center[1]) * sin
    if along < 0.0:
        box, along = box.turned(2), -along
    length, width, height = box.size
    long, wide, tall = min(_LUMINAIRE[0], length), min(_LUMINAIRE[1], width), min(_LUMINAIRE[2], height)
    start = min(-along, length / 2 - long)
    arm = (length / 2 - start, min(_ARM, width), min(_ARM, height))
    return [
        part_of(coarse, "box", box, ((length / 2 + start) / 2, 0.0, height / 2), arm, "pole", "metal"),
        part_of(coarse, "box", box, (length / 2 - long / 2, 0.0, height / 2), (long, wide, tall), "pole", "plastic"),
    ]


def other(coarse: CoarseObject, _surroundings: Surroundings) -> list[Primitive]:
    """The kind in its name (`bench_2` is a bench), or a kind of such extents; else the object as it is."""
    named = coarse.word if "other" in KINDS.get(coarse.word, KINDS["tree"]).labels else None
    if len(coarse.parts) > 1 or coarse.parts[0].shape != "box":
        return [solid(part) for part in coarse.parts]
    box = coarse.box()
    for kind in (named,) if named else _GUESSED:
        for turned in (box, box.turned(1)):
            if named or _is_in(turned, kind):
                return fitted(coarse, kind, turned, proud=_FURNITURE_PROUD)
    return [solid(coarse.parts[0])]


def _is_in(box: UprightBox, kind: str) -> bool:
    low, high = KINDS[kind].extents or (box.size, box.size)
    return all(a <= extent <= b for a, extent, b in zip(low, box.size, high, strict=True))


def wall(coarse: CoarseObject, _surroundings: Surroundings) -> list[Primitive]:
    """Low walls with copings, as around gardens, or high ones of panels between posts."""
    made = []
    for part in coarse.parts:
        box = UprightBox.around([part]).lengthwise()
        kind = "garden_wall" if box.size[2] <= _GARDEN_WALL else "wall"
        made += _stretch_of(coarse, part, kind, box, _THICK_WALL)
    return made


def fence(coarse: CoarseObject, surroundings: Surroundings) -> list[Primitive]:
    """Fences of palings, iron bars or mesh, with all segments alike; fences of close palings in a clustering, whose
    pieces sent back most rays."""
    made = []
    for part in coarse.parts:
        alike, box = coarse.again(), UprightBox.around([part]).lengthwise()
        if surroundings.clustered:
            made += _stretch_of(alike, part, "fence", box, _THICK_FENCE, add=partial(fences.fence, dense=True))
            continue
        mesh = float(alike.rng.random()) < _MESH and max(box.size) > _MESH_FROM
        kind = coarse.word if coarse.word in _FENCES else "mesh_fence" if mesh else "fence"
        made += _stretch_of(alike, part, kind, box, _THICK_FENCE)
    return made


def _stretch_of(
    coarse: CoarseObject, part: Primitive, kind: str, box: UprightBox, thickest: float, *, add: Add | None = None
) -> list[Primitive]:
    length, thick, height = box.size
    if part.shape != "box" or length < _LEAST_BARRIER[0] or height < _LEAST_BARRIER[1] or thick > thickest:
        return [solid(part)]
    return fitted(coarse, kind, box, add=add)


def plant(coarse: CoarseObject, surroundings: Surroundings) -> list[Primitive]:
    """A tree for one trunk with one crown; else each shape on its own."""
    trunks, foliage = coarse.labelled("trunk"), coarse.labelled("vegetation")
    if len(trunks) == 1 and len(foliage) == 1 and foliage[0].shape == "ellipsoid" and trunks[0].shape == "cylinder":
        return _tree(coarse, trunks[0], foliage[0])
    made = [solid(trunk) for trunk in trunks]
    for part in foliage:
        made += _hedge(coarse, part) if part.shape == "box" else _tuft(coarse, part, surroundings)
    return made


def _tree(coarse: CoarseObject, trunk: Primitive, crown: Primitive) -> list[Primitive]:
    """Boughs and lobes of a tree in leaf in the crown's box; the trunk keeps its place and thickness."""
    foot = trunk.center[2] - trunk.size[2] / 2
    x, y, _ = crown.center
    length, width, _ = crown.size
    top = crown.center[2] + crown.size[2] / 2
    box = UprightBox(x, y, foot, crown.yaw, (length, width, top - foot))
    clearance = max(crown.center[2] - crown.size[2] / 2 - foot, 0.0)
    parts = fitted(coarse, "tree", box, clearance=clearance, add=partial(plants.tree, bare=False))
    a, b, _ = trunk.size
    high = max(parts[0].size[2], trunk.size[2])
    center = (trunk.center[0], trunk.center[1], foot + high / 2)
    parts[0] = changed(parts[0], size=(a, b, high), center=center)
    return parts


def _hedge(coarse: CoarseObject, part: Primitive) -> list[Primitive]:
    return fitted(coarse, "hedge", UprightBox.around([part]).lengthwise())


def _tuft(coarse: CoarseObject, part: Primitive, surroundings: Surroundings) -> list[Primitive]:
    """A shape of foliage as a medium, with denser twigs in its middle unless it is a piece of a clustering."""
    if part.shape not in ("ellipsoid", "cylinder"):
        return [part]
    if surroundings.clustered:
        return [medium(part, _PIECE_PATHS / min(part.size))]
    density = _NARROWING * _LEAF_AREA / part.size[2] * float(np.exp(coarse.rng.normal(0.0, _SPREAD)))
    return [medium(part, density), medium(part, _CORE_DENSER * density, _CORE)]
