"""A 3D model in a file of glTF or Wavefront OBJ becomes a layout; its names give the classes."""

from __future__ import annotations

import math
import os
import warnings
from collections.abc import Iterable, Iterator, Mapping
from functools import partial
from typing import Any

import numpy as np

from lidardraft.drafting.plausible import check_scale, settled
from lidardraft.drafting.things import Node, Things
from lidardraft.errors import FormatError, LayoutError, check_type
from lidardraft.files import named
from lidardraft.formats.glb import MOST_VERTICES, GlbFile, Piece, extras_of, open_glb
from lidardraft.formats.obj import obj_meshes
from lidardraft.scene.box import FURTHEST
from lidardraft.scene.class_names import check_classes, class_of
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.mesh import TriangleMesh
from lidardraft.scene.placed_mesh import MOST_RECOGNISED, placed_mesh, recognised_shape

# layout_from_model by the axis that points up. With y up, as in glTF and in Blender's exporters and importers, x, y, z
# becomes x, -z, y.
_FRAMES = {"y": np.array([[1.0, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]]), "z": np.eye(4)}
_LEAN = 1e-5  # the tangent of the largest lean of an upright axis


def layout_from_glb(
    path: str | os.PathLike[str],
    *,
    classes: Mapping[str, str] | None = None,
    up: str = "y",
    scale: float = 1.0,
    recentre: bool = False,
    as_is: bool = False,
) -> Layout:
    """The layout of a glTF file, binary or with its buffers in the text. Its axis `up`, y in the format, points up; its
    unit, the metre in the format, is `scale` metres.

    The class of an object is the property "class" (in `extras`) of it or of its mesh. Else `classes` decides, by its
    name or by those of its material, parents and mesh; else these names themselves. All nodes below one whose name
    gives one thing of that class ("Truck_2", not "Trucks") are that thing. Upright boxes, ellipsoids, cylinders and
    planes become those shapes, within the rounding of float32. Others stay meshes; those with a skin are in its bind
    pose. `recentre` moves the middle of the ground to the origin.

    Raises `FormatError` if the file is broken, compressed or needs another file. Raises `LayoutError` listing the names
    without a class, and for a thing whose size is in another unit, unless `as_is`.
    """
    classes = _checked(path, classes, up)
    file = open_glb(path)
    with named(path):
        pieces = list(file.pieces(_FRAMES[up]))
        labels = _labels((piece.name, _class_of(piece, classes)) for piece in pieces)
        primitives = list(_glb_primitives(file, pieces, labels, classes))
        for what, names in file.unread.items():
            more = f" and {len(names) - 5} more" * (len(names) > 5)
            warnings.warn(f"{os.fspath(path)}: {what}: {', '.join(names[:5])}{more}", stacklevel=2)
        if not primitives:
            raise FormatError("the file has no triangles")
        travelled = extras_of(file.scene).get("lidardraft")
        head: dict[str, Any] = {"provenance": {"source": os.path.basename(os.fspath(path))}, "coverage": None}
        if is_ours := isinstance(travelled, dict) and travelled.keys() >= head.keys():
            head = travelled
        layout = Layout.with_head(primitives, head)
        return settled(layout, scale=scale, recentre=recentre, as_is=as_is, is_ours=is_ours)


def layout_from_obj(
    path: str | os.PathLike[str],
    *,
    classes: Mapping[str, str] | None = None,
    up: str = "z",
    scale: float = 1.0,
    recentre: bool = False,
    as_is: bool = False,
) -> Layout:
    """The layout of an OBJ file whose axis `up` points up and whose unit is `scale` metres.

    The class of an object comes from `classes`, by its name or its material's, or else from these names themselves:
    "car", "Car.001" and "ParkedCar_left" are cars. Things are numbered; an object's materials are parts of one thing,
    and so are "car_1.body" and "car_1.roof". `recentre` and `as_is` are as in `layout_from_glb`. Raises `LayoutError`
    as that does, and `FormatError` if the file is broken.
    """
    classes = _checked(path, classes, up)
    check_scale(scale)
    objects = obj_meshes(path)
    with named(path):
        labels = _labels(
            (f"{name} ({material or 'no material'})", class_of((name, material), classes))
            for name, material, _ in objects
        )
        nodes: dict[str, Node] = {}
        for (name, material, mesh), label in zip(objects, labels, strict=True):
            nodes.setdefault(name or material, Node(name or material, label, place=partial(_middle, mesh)))
        things = Things(list(nodes.values()), classes)
        fields = [
            things.fields_of(nodes[name or material], label, {})
            for (name, material, _), label in zip(objects, labels, strict=True)
        ]
        primitives = _obj_primitives([shape for _, _, shape in objects], scale * _FRAMES[up][:3, :3].T, fields)
        layout = Layout(primitives=tuple(primitives), provenance={"source": os.path.basename(os.fspath(path))})
        return settled(layout, recentre=recentre, as_is=as_is)


def _checked(path: object, classes: Mapping[str, str] | None, up: object) -> Mapping[str, str]:
    check_type("path", path, str, os.PathLike)
    check_classes(classes or {})
    if not isinstance(up, str) or up not in _FRAMES:
        raise LayoutError(f"up is {up!r}; it must be 'y' or 'z'")
    return classes or {}


def _labels(found: Iterable[tuple[str, str | None]]) -> list[str]:
    """The classes of pieces, from their names and classes; raises `LayoutError` listing the names without one."""
    rows = list(found)
    if nameless := sorted({name for name, label in rows if not label}):
        raise LayoutError(f"no class for {', '.join(nameless)}; say which by --class NAME=CLASS (`classes` in Python)")
    return [label for _, label in rows if label]


def _class_of(piece: Piece, classes: Mapping[str, str]) -> str | None:
    if isinstance(given := piece.extras.get("class"), str):
        return given
    own, *parents, mesh = piece.names
    # The mesh comes last: most have the name of their origin, such as "Cube" or "Plane".
    return class_of([own, piece.material, *parents], classes) or class_of([mesh], classes)


def _glb_primitives(
    file: GlbFile, pieces: list[Piece], labels: list[str], classes: Mapping[str, str]
) -> Iterator[Primitive]:
    nodes = _nodes_of(pieces, labels)
    given = (piece.extras.get("instance") for piece in pieces)
    things = Things([nodes[piece.indices[0]] for piece in pieces], classes, given)
    shapes: dict[tuple[str, bool], tuple[np.ndarray, np.ndarray, str]] = {}  # many nodes may share a mesh
    spent = 0
    for piece, label in zip(pieces, labels, strict=True):
        is_y_up = _is_upright(piece.matrix[:3, 1])  # the upright axis of the mesh becomes its z
        matrix = piece.matrix @ _FRAMES["y"].T if is_y_up else piece.matrix
        parts = [piece.part.get(name) for name in ("attributes", "indices", "mode")]
        key = repr((parts, piece.skin)), is_y_up
        if key not in shapes:
            with named(piece.name):
                shapes[key] = _shape(file.triangles(piece), is_y_up)
        vertices, faces, shape = shapes[key]
        spent += max(len(vertices), len(faces))
        if spent > MOST_VERTICES:
            raise FormatError(f"more than {MOST_VERTICES} vertices or triangles in all nodes")
        fields = things.fields_of(nodes[piece.indices[0]], label, piece.extras)
        primitive = placed_mesh(matrix, vertices, faces, shape=shape, **fields)
        if primitive is not None:
            yield primitive


def _nodes_of(pieces: list[Piece], labels: list[str]) -> dict[int, Node]:
    """The nodes of pieces and all nodes above them, by their indices."""
    nodes: dict[int, Node] = {}
    for piece, label in zip(pieces, labels, strict=True):
        parent: Node | None = None
        for place in reversed(range(len(piece.indices))):
            index = piece.indices[place]
            if index not in nodes:
                nodes[index] = Node(next((name for name in piece.names[place:] if name), "unnamed"), parent=parent)
            parent = nodes[index]
        node = nodes[piece.indices[0]]
        node.label, node.place = node.label or label, partial(_origin, piece.matrix)
    return nodes


def _origin(matrix: np.ndarray) -> np.ndarray:
    return matrix[:3, 3]


def _middle(mesh: TriangleMesh) -> np.ndarray:
    return np.asarray(mesh.vertices.mean(axis=0))


def _is_upright(axis: np.ndarray) -> bool:
    x, y, z = axis.tolist()
    return z > 0 and math.hypot(x, y) <= _LEAN * z


def _shape(mesh: TriangleMesh, is_y_up: bool) -> tuple[np.ndarray, np.ndarray, str]:
    """Vertices [V, 3] with z up, triangles [F, 3] and their shape."""
    vertices, faces = mesh.vertices, mesh.faces
    if len(vertices) <= MOST_RECOGNISED:
        # Exporters split faces at sharp edges; vertices in one place are merged again.
        vertices, place = np.unique(vertices, axis=0, return_inverse=True)
        faces = place.reshape(-1)[faces]
    if is_y_up:
        vertices = vertices @ _FRAMES["y"][:3, :3].T
    return vertices, faces, recognised_shape(vertices, faces)


def _obj_primitives(
    meshes: list[TriangleMesh], transform: np.ndarray, fields: list[dict[str, Any]]
) -> Iterator[Primitive]:
    """`Primitive.from_mesh` of each mesh under a linear map [3, 3], but many times as fast for small ones."""
    if not meshes:
        return
    ends = np.cumsum([len(one.vertices) for one in meshes])
    starts = np.concatenate([[0], ends[:-1]])
    with np.errstate(over="ignore", invalid="ignore"):
        vertices = np.concatenate([one.vertices for one in meshes]) @ transform
    if not (np.abs(vertices) <= FURTHEST).all():  # `from_mesh` reports which one, and why
        for start, end, one, more in zip(starts, ends, meshes, fields, strict=True):
            yield Primitive.from_mesh(vertices[start:end], one.faces, **more)
        return
    low, high = np.minimum.reduceat(vertices, starts), np.maximum.reduceat(vertices, starts)
    centers, sizes = (low + high) / 2, high - low
    each = np.repeat(np.arange(len(meshes)), ends - starts)
    unit = np.clip((vertices - centers[each]) / np.where(sizes > 0, sizes, 1.0)[each], -0.5, 0.5)
    places = zip(starts.tolist(), ends.tolist(), centers.tolist(), sizes.tolist(), strict=True)
    for (start, end, center, size), one, more in zip(places, meshes, fields, strict=True):
        shape = TriangleMesh.unchecked(unit[start:end], one.faces)
        yield Primitive(shape="mesh", center=tuple(center), size=tuple(size), mesh=shape, **more)
