"""Wavefront OBJ, both ways: the objects of a modelled scene are the meshes of a layout."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from lidardraft.errors import FormatError, LayoutError, check_type
from lidardraft.files import named, read_bytes, regular_size, written_whole
from lidardraft.json_fields import is_number
from lidardraft.scene import mesh
from lidardraft.scene.class_names import OUTRIGHT, check_classes, class_of, id_of, whole_of
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.layout_fields import FURTHEST
from lidardraft.semantics import BY_NAME

# What is read in seconds and a gigabyte, whatever it is: bytes, lines, words (which are corners of faces), objects.
_MAX_BYTES, _MAX_LINES, _MAX_WORDS, _MAX_OBJECTS = 2**26, 4_000_000, 8_000_000, 65_535
# What Blender's exporter makes of its z-up, y-forward frame by default: y up, -z forward.
_FRAMES = {"z": np.eye(3), "y": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])}


def layout_from_obj(
    path: str | os.PathLike[str], *, classes: Mapping[str, str] | None = None, up: str = "z", scale: float = 1.0
) -> Layout:
    """The layout of an OBJ file whose axis `up` points up and whose unit is `scale` metres.

    The class of an object is what `classes` says of its name or of its material's, or else what these names say:
    "car", "Car.001" and "ParkedCar_left" are cars. Things are numbered; an object's materials are parts of one thing,
    and so are "car_1.body" and "car_1.roof". Raises `LayoutError` listing the names that say no class, and
    `FormatError` where the file is broken.
    """
    check_type("path", path, str, os.PathLike)
    if not isinstance(up, str) or up not in _FRAMES:
        raise LayoutError(f"up is {up!r}; it must be 'y' or 'z'")
    if not (is_number(scale) and scale > 0):
        raise LayoutError(f"scale is {scale}; it must be a finite number of metres > 0")
    check_classes(classes or {})
    _check_amount(path)
    objects = mesh.read_obj(path)
    with named(path):
        labels = [class_of((name, material), classes or {}) for name, material, _ in objects]
        nameless = sorted(
            {f"{o[0]} ({o[1] or 'no material'})" for o, label in zip(objects, labels, strict=True) if not label}
        )
        if nameless:
            raise LayoutError(
                f"no class for {', '.join(nameless)}; say which by --class NAME=CLASS (`classes` in Python)"
            )
        instances: dict[str, int] = {}
        ids: dict[str, int] = {}
        fields: list[dict[str, Any]] = []
        for (name, material, _), label in zip(objects, labels, strict=True):
            assert label is not None
            thing = BY_NAME[label].is_thing
            number = instances.setdefault(whole_of(id_of(name)), len(instances) + 1) if thing else 0
            fields.append({"label": label, "id": _distinct(name or material, ids), "instance": number})
        primitives = _primitives([shape for _, _, shape in objects], scale * _FRAMES[up].T, fields)
        return Layout(primitives=tuple(primitives), provenance={"source": os.path.basename(os.fspath(path))})


def _primitives(
    meshes: list[mesh.TriangleMesh], transform: np.ndarray, fields: list[dict[str, Any]]
) -> Iterator[Primitive]:
    """What `Primitive.from_mesh` makes of each mesh under a linear map [3, 3]; of small ones many times as fast."""
    if not meshes:
        return
    ends = np.cumsum([len(one.vertices) for one in meshes])
    starts = np.concatenate([[0], ends[:-1]])
    with np.errstate(over="ignore", invalid="ignore"):
        vertices = np.concatenate([one.vertices for one in meshes]) @ transform
    if not (np.abs(vertices) <= FURTHEST).all():  # which of them, and why, is said there
        for start, end, one, more in zip(starts, ends, meshes, fields, strict=True):
            yield Primitive.from_mesh(vertices[start:end], one.faces, **more)
        return
    low, high = np.minimum.reduceat(vertices, starts), np.maximum.reduceat(vertices, starts)
    centers, sizes = (low + high) / 2, high - low
    each = np.repeat(np.arange(len(meshes)), ends - starts)
    unit = np.clip((vertices - centers[each]) / np.where(sizes > 0, sizes, 1.0)[each], -0.5, 0.5)
    places = zip(starts.tolist(), ends.tolist(), centers.tolist(), sizes.tolist(), strict=True)
    for (start, end, center, size), one, more in zip(places, meshes, fields, strict=True):
        shape = mesh.TriangleMesh.unchecked(unit[start:end], one.faces)
        yield Primitive(shape="mesh", center=tuple(center), size=tuple(size), mesh=shape, **more)


def _check_amount(path: str | os.PathLike[str]) -> None:
    """Raises `FormatError` for a file that holds more than can be read in a reasonable time."""
    amounts = {"bytes": regular_size(path)}
    if amounts["bytes"] <= _MAX_BYTES:
        data = read_bytes(path)
        amounts |= {"lines": data.count(b"\n"), "words": data.count(b" ") + data.count(b"\t")}
        amounts["objects"] = sum(data.count(word) for word in (b"\no ", b"\ng ", b"usemtl "))
    limits = {"bytes": _MAX_BYTES, "lines": _MAX_LINES, "words": _MAX_WORDS, "objects": _MAX_OBJECTS}
    for name, amount in amounts.items():
        if amount > limits[name]:
            raise FormatError(f"{os.fspath(path)} has {amount} {name}; OBJ files of up to {limits[name]} are read")


def write_obj(path: str | os.PathLike[str], layout: Layout) -> None:
    """Write the shapes as triangles, z up, in metres: an object with the id for each,
    and a material that names the class, "class:car".

    Round shapes become polyhedra. `layout_from_obj` reads the same triangles, to the last digit.
    """
    lines, count = ["# a layout: metres, x forward, y left, z up"], 1
    for primitive in layout:
        shape = mesh.primitive_mesh(primitive)
        lines.append("o " + re.sub(r"\s", "_", primitive.id))
        lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in shape.vertices.tolist()]
        lines.append(f"usemtl {OUTRIGHT}{primitive.label}")
        lines += [f"f {a} {b} {c}" for a, b, c in (shape.faces.astype(np.int64) + count).tolist()]
        count += len(shape.vertices)
    with written_whole(path) as temporary:
        temporary.write_text("\n".join([*lines, ""]), encoding="utf-8")


def _distinct(name: str, taken: dict[str, int]) -> str:
    """The id of an object or of one more part of it, `car_001` or `car_001.2`."""
    name = id_of(name)
    taken[name] = taken.get(name, 0) + 1
    return name if taken[name] == 1 else f"{name}.{taken[name]}"
