"""A builder's object in a given box: built in the nearest size of its kind, then stretched into it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lidardraft.objects.kinds import kind_of
from lidardraft.objects.object_builder import Add, built
from lidardraft.objects.placed_object import PlacedObject, Vector
from lidardraft.scene.layout import Primitive
from lidardraft.scene.materials import CLASS_MATERIALS
from lidardraft.scene.mesh import TriangleMesh
from lidardraft.scene.pose import point_at
from lidardraft.semantics import CLASSES
from lidardraft.simulation.detail.coarse_object import CoarseObject, UprightBox

_PROUD = (0.05, 0.05, 0.0)  # m that trim may stand out of a box: length, width, height
_MOST_PROUD = 0.6  # m; parts that reach further out, such as balconies, are left out
_MOST_CUTS = 512
_MATERIAL_OF = {row.name: CLASS_MATERIALS[row.id].name for row in CLASSES}

_cuts: dict[tuple[int, float], tuple[TriangleMesh, TriangleMesh]] = {}


def fitted(
    coarse: CoarseObject,
    kind: str,
    box: UprightBox,
    *,
    clearance: float = 0.0,
    proud: Vector = _PROUD,
    labels: tuple[str, ...] | None = None,
    add: Add | None = None,
) -> list[Primitive]:
    """An object of a kind of `objects.kinds` in `box`, its front along the box's yaw; ids are left empty.

    `clearance` [m] is that of `PlacedObject`. Parts stand out of the box by `proud` [m] at most and do not reach under
    it. They have the instances and classes of `coarse`. `labels` are the classes of the parts to keep, by default all;
    `add` replaces the builder of the kind.
    """
    low, high = kind_of(kind).extents or (box.size, box.size)
    length, width, height = (min(max(extent, a), b) for extent, a, b in zip(box.size, low, high, strict=True))
    size = (length, width, height)
    placed = PlacedObject(
        kind=kind, id=coarse.name, x=0.0, y=0.0, z=0.0, level=0.0, yaw=0.0, size=size,
        clearance=clearance * size[2] / box.size[2],
    )  # fmt: skip
    parts = built(add or kind_of(kind).add, placed, coarse.rng)
    if labels is not None:
        parts = [part for part in parts if part.label in labels]
    return stretched(coarse, parts, box, size, proud)


def stretched(
    coarse: CoarseObject, parts: Sequence[Primitive], box: UprightBox, size: Vector, proud: Vector = _PROUD
) -> list[Primitive]:
    """Parts built for extents `size` at the origin, stretched into `box`."""
    most = size[0] / 2 + _MOST_PROUD, size[1] / 2 + _MOST_PROUD
    reaches = [(part, reach) for part in parts if (reach := _reach(part))[0] <= most[0] and reach[1] <= most[1]]
    limits = (box.size[0] / 2 + proud[0], box.size[1] / 2 + proud[1], box.size[2] + proud[2])
    scale = [
        min(extent / built, limit / max([1e-9, *(reach[axis] for _, reach in reaches)]))
        for axis, (extent, built, limit) in enumerate(zip(box.size, size, limits, strict=True))
    ]
    made = []
    for whole, _ in reaches:
        part = _cut_at_base(whole)
        if part is None:
            continue
        (x, y, z), (a, b, c) = part.center, part.size
        x, y, z = x * scale[0], y * scale[1], z * scale[2]
        label = part.label if part.label in coarse.owners else coarse.label
        made.append(
            Primitive.unchecked(
                shape=part.shape,
                center=(*point_at(box.place, x, y), box.bottom + z),
                size=(a * scale[0], b * scale[1], c * scale[2]),
                label=label,
                id="",
                yaw=box.yaw + part.yaw,
                instance=coarse.owners[label][1],
                material=part.material or _MATERIAL_OF[part.label],
                mesh=part.mesh,
                extinction=part.extinction,
            )
        )
    return made


def solid(part: Primitive) -> Primitive:
    """The given part with the material of its class."""
    return changed(part, material=_MATERIAL_OF[part.label])


def part_of(
    coarse: CoarseObject, shape: str, box: UprightBox, center: Vector, size: Vector, label: str, material: str
) -> Primitive:
    """A new part at a place in the frame of `box`, whose origin is the middle of its base."""
    x, y, z = center
    return Primitive.unchecked(
        shape=shape,
        center=(*point_at(box.place, x, y), box.bottom + z),
        size=size,
        label=label,
        id="",
        yaw=box.yaw,
        instance=coarse.owners[label][1],
        material=material,
    )


def medium(part: Primitive, extinction: float, share: float = 1.0) -> Primitive:
    """The given part, or a `share` of it about its middle, as a medium with `extinction` [1/m]."""
    a, b, c = part.size
    return changed(
        part,
        id=part.id if share == 1.0 else "",
        size=(share * a, share * b, share * c),
        material=_MATERIAL_OF[part.label],
        extinction=extinction,
    )


def changed(part: Primitive, **fields: object) -> Primitive:
    """The part with other fields, which must be valid: they are not checked."""
    return Primitive.unchecked(**({name: getattr(part, name) for name in part.__slots__} | fields))


def _reach(part: Primitive) -> Vector:
    """The reach of a part from the middle of its object along x, y and z [m]."""
    (x, y, z), (a, b, c) = part.center, part.size
    return abs(x) + a / 2, abs(y) + b / 2, z + c / 2


def _cut_at_base(part: Primitive) -> Primitive | None:
    """The part over z = 0, or None if all of it is below."""
    x, y, z = part.center
    a, b, c = part.size
    top = z + c / 2
    if z - c / 2 >= 0.0:
        return part
    if top <= 0.0:
        return None
    mesh = part.mesh
    if mesh is not None:
        mesh = _cut_mesh(mesh, round(0.5 - top / c, 6))
    return changed(part, center=(x, y, top / 2), size=(a, b, top), mesh=mesh)


def _cut_mesh(mesh: TriangleMesh, at: float) -> TriangleMesh:
    """A mesh of the unit box over z = `at`, in the unit box again; meshes are cached to be shared."""
    key = (id(mesh), at)
    entry = _cuts.get(key)  # another thread may clear the table at any time
    if entry is None:
        if len(_cuts) >= _MOST_CUTS:
            _cuts.clear()
        vertices = mesh.vertices.copy()
        vertices[:, 2] = (np.maximum(vertices[:, 2], at) - at) / (0.5 - at) - 0.5
        over = (mesh.vertices[mesh.faces, 2] > at).any(axis=1)
        # the mesh itself is kept as well: another could get its id
        entry = _cuts[key] = (mesh, TriangleMesh(vertices, mesh.faces[over]))
    return entry[1]
