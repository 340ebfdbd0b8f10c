"""Wavefront OBJ: the objects of a modelled scene become the meshes of a layout."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Mapping

import numpy as np

from lidardraft.errors import LayoutError, one_of
from lidardraft.files import named
from lidardraft.scene import mesh
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.semantics import BY_NAME

# What Blender's exporter makes of its z-up, y-forward frame by default: y up, -z forward.
_FRAMES = {"z": np.eye(3), "y": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])}


def read_obj(
    path: str | os.PathLike[str], labels: Mapping[str, str] | None = None, *, up: str = "z", scale: float = 1.0
) -> Layout:
    """The layout of an OBJ file whose axis `up` points up and whose unit is `scale` metres.

    The class of an object is what `labels` says of its name or of its material's, or else either of those names itself:
    "car", "car.001" and "car_left" are cars. Things are numbered; an object's materials are parts of one thing. Raises
    `LayoutError` listing the names that say no class, and `FormatError` where the file is broken.
    """
    if up not in _FRAMES:
        raise LayoutError(f"up is {up!r}; it must be 'y' or 'z'")
    if not (math.isfinite(scale) and scale > 0):
        raise LayoutError(f"scale is {scale}; it must be a finite number of metres > 0")
    for key, value in (labels or {}).items():
        if value not in BY_NAME or value == "none":
            raise LayoutError(f"labels[{key!r}] is {value!r}; it must be {one_of(list(BY_NAME)[1:], value)}")
    objects = mesh.read_obj(path)
    with named(path):
        classes = [_class_of(name, material, labels or {}) for name, material, _ in objects]
        nameless = sorted(
            {f"{o[0]} ({o[1] or 'no material'})" for o, label in zip(objects, classes, strict=True) if not label}
        )
        if nameless:
            raise LayoutError(f"no class for {', '.join(nameless)}; pass them in `labels` (--class NAME=CLASS)")
        instances: dict[str, int] = {}
        ids: dict[str, int] = {}
        primitives = []
        for (name, material, shape), label in zip(objects, classes, strict=True):
            assert label is not None
            with np.errstate(over="ignore", invalid="ignore"):  # the mesh says which vertex is not finite
                vertices = scale * shape.vertices @ _FRAMES[up].T
            primitives.append(
                Primitive.from_mesh(
                    vertices,
                    shape.faces,
                    label=label,
                    id=_distinct(name or material, ids),
                    instance=instances.setdefault(name, len(instances) + 1) if BY_NAME[label].is_thing else 0,
                )
            )
        return Layout(primitives=tuple(primitives), provenance={"source": os.path.basename(os.fspath(path))})


def _class_of(name: str, material: str, labels: Mapping[str, str]) -> str | None:
    for key in (name, material):
        if key in labels:
            return labels[key]
    for key in (name, material):
        for class_name in list(BY_NAME)[1:]:
            if re.fullmatch(rf"{class_name}([._].*)?", key, re.IGNORECASE):
                return class_name
    return None


def _distinct(name: str, taken: dict[str, int]) -> str:
    """The id of an object or of one more part of it, `car_001` or `car_001.2`: only parts come after a dot."""
    name = name.replace(".", "_")
    taken[name] = taken.get(name, 0) + 1
    return name if taken[name] == 1 else f"{name}.{taken[name]}"
