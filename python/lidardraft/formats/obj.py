"""Wavefront OBJ, both ways: the meshes of its objects, and a layout as objects of triangles."""

from __future__ import annotations

import os
import re

import numpy as np

from lidardraft.errors import FormatError
from lidardraft.files import read_bytes, written_whole
from lidardraft.scene import mesh
from lidardraft.scene.class_names import OUTRIGHT
from lidardraft.scene.layout import Layout, primitive_mesh

# Limits for reading in seconds and a gigabyte, whatever the file; words are corners of faces.
_MAX_BYTES, _LIMITS = 2**26, {"lines": 4_000_000, "words": 8_000_000, "objects": 65_535}


def obj_meshes(path: str | os.PathLike[str]) -> list[tuple[str, str, mesh.TriangleMesh]]:
    """Name, material and mesh of each object; raises `FormatError` for a file that is broken or too large."""
    _check_amount(path)
    return mesh.read_obj(path)


def write_obj(path: str | os.PathLike[str], layout: Layout) -> None:
    """Write the shapes as triangles, z up, in metres: for each an object with its id, and a material that names its
    class, "class:car".

    Round shapes become polyhedra. `layout_from_obj` reads the same triangles, exact to the last digit.
    """
    lines, count = ["# a layout: metres, x forward, y left, z up"], 1
    for primitive in layout:
        shape = primitive_mesh(primitive)
        lines.append("o " + re.sub(r"\s", "_", primitive.id))
        lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in shape.vertices.tolist()]
        lines.append(f"usemtl {OUTRIGHT}{primitive.label}")
        lines += [f"f {a} {b} {c}" for a, b, c in (shape.faces.astype(np.int64) + count).tolist()]
        count += len(shape.vertices)
    with written_whole(path) as temporary:
        temporary.write_text("\n".join([*lines, ""]), encoding="utf-8")


def _check_amount(path: str | os.PathLike[str]) -> None:
    """Raises `FormatError` for a file too large to be read in a reasonable time."""
    data = read_bytes(path, _MAX_BYTES)
    amounts = {
        "lines": data.count(b"\n"),
        "words": data.count(b" ") + data.count(b"\t"),
        "objects": sum(data.count(word) for word in (b"\no ", b"\ng ", b"usemtl ")),
    }
    for name, amount in amounts.items():
        if amount > _LIMITS[name]:
            raise FormatError(f"{os.fspath(path)} has {amount} {name}; OBJ files of up to {_LIMITS[name]} are read")
