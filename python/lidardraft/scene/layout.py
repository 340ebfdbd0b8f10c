"""The layout: semantic shapes in metres, and its JSON.

Frame: right-handed, x forward, y left, z up. The road under the ego vehicle is z = 0; the ego is at the origin and
faces +x. Every shape is a unit shape scaled by `size`, turned by `yaw` about z and moved to `center`.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence, Sized
from dataclasses import MISSING, dataclass, field, fields, replace
from typing import Any

import numpy as np

from lidardraft.errors import (
    FormatError,
    LayoutError,
    UnknownNameError,
    as_tuple,
    check_that,
    did_you_mean,
    one_of,
)
from lidardraft.files import JsonFile, named, write_text
from lidardraft.json_fields import (
    check_brackets,
    check_fields,
    check_lists,
    check_object,
    check_schema,
    is_number,
    parse_document,
)
from lidardraft.scene.box import FURTHEST, THINNEST, Box, check_id, checked_instance, checked_vector, checked_yaw
from lidardraft.scene.intent import NOTHING_ASKED, Intent
from lidardraft.scene.materials import MATERIAL_BY_NAME
from lidardraft.scene.mesh import TriangleMesh, has_surface, unit_mesh, unit_vertices
from lidardraft.scene.pose import point_at
from lidardraft.scene.road_network import RoadNetwork
from lidardraft.semantics import BY_NAME

SCHEMA = "lidardraft.layout/2"
SHAPES = ("box", "ellipsoid", "cylinder", "plane", "mesh")
_INSTANCE_LIMIT = 2**16 - 1  # a SemanticKITTI label file holds 16 bits of instance
AROUND = "around/"  # the prefix of ids of surroundings (`surround`)
MORE = ("material", "extinction", "open")  # fields that few primitives have
_HEAD = ("provenance", "coverage", "roads", "intent", "notes")
MOST_PRIMITIVES = 100_000  # read in a second or two


@dataclass(frozen=True, kw_only=True, slots=True)
class Primitive:
    """One semantic shape.

    `size` holds full extents [m]; a plane is the rectangle z = 0 of its frame and has size z 0. `instance` is 0 for
    stuff and the number of the object, shared by its parts, for things. `material` refines the class's surface (a name
    of `scene.materials`); None is the class's own. `mesh` holds the vertices of shape "mesh" within the unit box.

    `extinction` [1/m] makes it a medium, such as a crown. A ray travels 1 / extinction in it on average before it
    returns, or leaves it on the other side (law of Beer and Lambert). A large value is nearly solid, None is solid. A
    plane, or a mesh that is not closed, has no inside and cannot be a medium.

    An `open` shape fills space that the source leaves open, such as the lawn around a sentence's road: `surround` may
    put anything there.
    """

    shape: str
    center: tuple[float, float, float]
    size: tuple[float, float, float]
    label: str
    id: str
    yaw: float = 0.0
    instance: int = 0
    material: str | None = None
    mesh: TriangleMesh | None = None
    extinction: float | None = None
    open: bool = False

    def __post_init__(self) -> None:
        check_id(self.id)
        object.__setattr__(self, "center", checked_vector(self.id, "center", self.center))
        object.__setattr__(self, "size", checked_vector(self.id, "size", self.size))
        if self.shape not in SHAPES:
            raise LayoutError(f"{self.id}: shape is {self.shape!r}; it must be {one_of(SHAPES, self.shape)}")
        if not isinstance(self.label, str) or self.label not in BY_NAME or self.label == "none":
            known = one_of(list(BY_NAME)[1:], self.label)
            raise LayoutError(f"{self.id}: label is {self.label!r}; it must be {known}")
        object.__setattr__(self, "yaw", checked_yaw(self.id, self.yaw))
        object.__setattr__(self, "instance", checked_instance(self.id, self.instance, _INSTANCE_LIMIT))
        if self.material is not None and self.material not in tuple(MATERIAL_BY_NAME):
            known = one_of(MATERIAL_BY_NAME, self.material)
            raise LayoutError(f"{self.id}: material is {self.material!r}; it must be {known}")
        if type(self.open) is not bool:
            raise LayoutError(f"{self.id}: open is {self.open!r}; it must be true or false")
        self._check_size()
        self._check_extinction()

    def _check_size(self) -> None:
        if (self.mesh is not None) != (self.shape == "mesh"):
            raise LayoutError(f"{self.id}: shape is {self.shape!r}; shape 'mesh', and no other, comes with a mesh")
        x, y, z = self.size
        if self.shape == "plane":
            fits, rule = min(x, y) >= THINNEST and z == 0, f"a plane needs x and y >= {THINNEST:g} m, and z = 0"
        elif self.mesh is not None:
            fits, rule = min(self.size) >= 0, "no extent may be negative"
        else:
            fits, rule = min(self.size) >= THINNEST, f"every extent must be >= {THINNEST:g} m"
        if not fits:
            raise LayoutError(f"{self.id}: size is {list(self.size)}; {rule}")
        if self.mesh is not None:
            if np.abs(self.mesh.vertices).max() > 0.5 + 1e-6:
                raise LayoutError(f"{self.id}: a vertex of the mesh lies outside the unit box [-1/2, 1/2]^3")
            if not has_surface(self.mesh.vertices * self.size, self.mesh.faces):
                raise LayoutError(f"{self.id}: size is {list(self.size)}; all its triangles are points or lines")

    def _check_extinction(self) -> None:
        if self.extinction is None:
            return
        if not is_number(self.extinction) or self.extinction <= 0:
            raise LayoutError(f"{self.id}: extinction is {self.extinction!r}; it must be a finite number > 0, or None")
        object.__setattr__(self, "extinction", float(self.extinction))
        if self.shape == "plane":
            raise LayoutError(f"{self.id}: a plane has no inside; it cannot have the extinction {self.extinction}")
        if self.mesh is not None and not self.mesh.is_closed():
            raise LayoutError(
                f"{self.id}: the mesh is not closed; it cannot have the extinction {self.extinction} (every edge must "
                "be shared by two triangles that run along it in opposite directions)"
            )

    @classmethod
    def unchecked(cls, **values: Any) -> Primitive:
        """A primitive of values known to be valid, made six times as fast without the checks."""
        primitive = object.__new__(cls)
        for name, value in (_DEFAULTS | values).items():
            object.__setattr__(primitive, name, value)
        return primitive

    @classmethod
    def from_mesh(cls, vertices: np.ndarray, faces: np.ndarray, *, label: str, id: str, **fields: Any) -> Primitive:
        """A mesh primitive from vertices [V, 3] in metres in the layout's frame; `center` and `size` are its bounds.

        Vertices without a face are left out.
        """
        mesh = TriangleMesh(vertices, faces)
        used = np.bincount(mesh.faces.ravel(), minlength=len(mesh.vertices)) > 0
        if not used.all():
            mesh = TriangleMesh(mesh.vertices[used], (np.cumsum(used) - 1)[mesh.faces])
        if (furthest := float(np.abs(mesh.vertices).max())) > FURTHEST:
            raise LayoutError(f"{id}: the mesh reaches {furthest:g} m from the origin; the limit is {FURTHEST:g} m")
        center, size, unit = unit_vertices(mesh.vertices)
        return cls(
            shape="mesh",
            center=tuple(center.tolist()),
            size=tuple(size.tolist()),
            label=label,
            id=id,
            mesh=TriangleMesh.unchecked(unit, mesh.faces),
            **fields,
        )

    def to_dict(self) -> dict[str, Any]:
        """The primitive as JSON types; optional fields only if they differ from their defaults."""
        required = ("shape", "center", "size", "yaw", "label", "id", "instance")
        fields: dict[str, Any] = {name: getattr(self, name) for name in required}
        fields |= {"center": list(self.center), "size": list(self.size)}
        fields |= self.more()
        if self.mesh is not None:
            fields["vertices"], fields["faces"] = self.mesh.vertices.tolist(), self.mesh.faces.tolist()
        return fields

    def more(self) -> dict[str, Any]:
        """The fields of `MORE` that it has."""
        return {name: value for name in MORE if (value := getattr(self, name))}

    @classmethod
    def from_dict(cls, fields: Mapping[str, Any]) -> Primitive:
        """The inverse of `to_dict`; raises `FormatError` for a missing or unknown field, `LayoutError` for an invalid
        one."""
        fields = dict(fields)
        with named(str(fields.get("id", "a primitive"))):
            required = ("shape", "center", "size", "label", "id")
            check_fields(fields, required, ("yaw", "instance", *MORE, "vertices", "faces"))
            vertices, faces = fields.pop("vertices", None), fields.pop("faces", None)
            if vertices is not None or faces is not None:
                fields["mesh"] = TriangleMesh(vertices, faces)
        return cls(**fields)


_DEFAULTS = {row.name: row.default for row in fields(Primitive) if row.default is not MISSING}


@dataclass(frozen=True, slots=True)
class Layout(JsonFile):
    """An ordered set of primitives with distinct ids.

    `provenance` is its origin (sentence, seed, source; JSON types only); nothing depends on it. `coverage` is the part
    of the azimuth [rad] that the source covers, (from, to) counter-clockwise, or None for all of it. `roads` are the
    roads, if known; `intent` is the request. `notes`, a line each, say which input was not understood, left out or
    assumed, and which objects a sensor cannot see. Raises `LayoutError` on invalid values.
    """

    primitives: tuple[Primitive, ...] = ()
    provenance: dict[str, Any] = field(default_factory=dict)
    coverage: tuple[float, float] | None = None
    roads: RoadNetwork | None = None
    intent: Intent = NOTHING_ASKED
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "primitives", tuple(self.primitives))
        if not isinstance(self.provenance, dict):
            raise LayoutError(f"provenance is {self.provenance!r}; it must be an object of JSON types")
        try:
            json.dumps(self.provenance, allow_nan=False)
        except (TypeError, ValueError, RecursionError) as error:
            raise LayoutError(f"provenance cannot be written as JSON: {error}") from None
        if self.coverage is not None:
            object.__setattr__(self, "coverage", checked_vector("layout", "coverage", self.coverage, 2, math.inf))
        check_that(isinstance(self.roads, RoadNetwork | None), "roads", self.roads, "a RoadNetwork or None")
        check_that(isinstance(self.intent, Intent), "intent", self.intent, "an Intent")
        object.__setattr__(self, "notes", as_tuple("notes", self.notes))
        check_that(all(type(note) is str for note in self.notes), "notes", list(self.notes), "lines of text")
        if self.intent.objects:
            object.__setattr__(self, "intent", self.intent.only(set(map(object_of, self.primitives))))
        _check_number(self.primitives)
        seen: set[str] = set()
        for primitive in self.primitives:
            if primitive.id in seen:
                raise LayoutError(f"{primitive.id}: two primitives have this id; ids must be distinct")
            seen.add(primitive.id)

    def __iter__(self) -> Iterator[Primitive]:
        return iter(self.primitives)

    def __len__(self) -> int:
        return len(self.primitives)

    def __repr__(self) -> str:
        objects = len({p.instance for p in self.primitives if p.instance and BY_NAME[p.label].is_thing})
        return f"Layout({len(self)} shapes, {objects} objects with a box, from {self.provenance.get('source')})"

    def __contains__(self, one: object) -> bool:
        return any(one in (primitive.id, primitive) for primitive in self)

    def __getitem__(self, id: str) -> Primitive:
        """The primitive with that id; raises `UnknownNameError`, a `KeyError`, if there is none."""
        for primitive in self.primitives:
            if primitive.id == id:
                return primitive
        raise self.unknown(id)

    def unknown(self, pattern: str) -> UnknownNameError:
        """The error for an id or pattern without a primitive."""
        names = list(dict.fromkeys(map(object_of, self)))
        parts = [primitive.id for primitive in self if object_of(primitive) == pattern]
        near = "" if parts else did_you_mean([*names, *(primitive.id for primitive in self)], pattern)
        some = parts or names
        known = near or f"; it has {', '.join(some[:8]) or 'none'}{', ...' if len(some) > 8 else ''}"
        return UnknownNameError(f"no primitive has the id {pattern!r}{known}")

    def noted(self, *lines: str) -> Layout:
        """The layout with those of the lines that are not among its notes yet."""
        more = tuple(line for line in lines if line not in self.notes)
        return replace(self, notes=self.notes + more) if more else self

    def boxes(self) -> list[Box]:
        """One box around each thing (instance > 0), with the yaw of its largest part, in the order of instances."""
        parts: dict[int, list[Primitive]] = {}
        for primitive in self.primitives:
            if primitive.instance and BY_NAME[primitive.label].is_thing:
                parts.setdefault(primitive.instance, []).append(primitive)
        return [box_around(parts[instance]) for instance in sorted(parts)]

    def to_json(self) -> str:
        """The layout as JSON text, one primitive a line; `from_json` gives an equal layout."""
        rows = ",\n  ".join(json.dumps(p.to_dict(), allow_nan=False) for p in self.primitives)
        return json.dumps(self.head(), allow_nan=False)[:-1] + ', "primitives": [\n  ' + rows + "\n]}\n"

    def head(self) -> dict[str, Any]:
        """All but the primitives, as JSON types; models and scripts carry it beside their shapes."""
        more = {"roads": self.roads and self.roads.to_dict(), "intent": self.intent.to_dict(), "notes": [*self.notes]}
        known = {name: value for name, value in more.items() if value}
        return {"schema": SCHEMA, "provenance": self.provenance, "coverage": self.coverage, **known}

    @classmethod
    def from_json(cls, text: str) -> Layout:
        """Raises `FormatError` if the text is not the JSON of a layout, `LayoutError` on an invalid value."""
        head = parse_document(text, SCHEMA, ("primitives",), _HEAD)
        rows = head.pop("primitives")
        if not isinstance(rows, list):
            raise FormatError(f"primitives is {rows!r:.50}; it must be a list of objects")
        _check_number(rows)
        return cls.with_head((Primitive.from_dict(check_object(row)) for row in rows), head)

    @classmethod
    def with_head(cls, primitives: Iterable[Primitive], head: Mapping[str, Any]) -> Layout:
        """The layout of primitives and a `head`, of this schema unless it says another one."""
        check_schema(head.get("schema", SCHEMA), SCHEMA)
        check_fields(head, (), ("schema", *_HEAD))
        fields = {name: head[name] for name in _HEAD if name in head}
        for name, kind in (("roads", RoadNetwork), ("intent", Intent)):
            if name in fields:
                with named(name):
                    fields[name] = kind.from_dict(check_object(fields[name]))
        return cls(tuple(primitives), **fields)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the JSON of `to_json`; raises `FormatError` if it is larger than `load` accepts."""
        meshes = [primitive.mesh for primitive in self.primitives if primitive.mesh is not None]
        with named(path):
            check_lists(sum(len(mesh.vertices) + len(mesh.faces) for mesh in meshes))  # before they become text
            text = self.to_json()
            check_brackets(text)
        write_text(path, text)


def object_of(primitive: Primitive) -> str:
    """The name of the object of a primitive: its id up to the first dot."""
    return primitive.id.split(".", 1)[0]


def box_around(parts: Sequence[Primitive]) -> Box:
    """The box around the parts of one object, with the yaw, id, label and instance of the largest."""
    largest = max(parts, key=lambda part: math.prod(part.size))
    low, high = corners_around(parts, largest.yaw)
    u, v, z = ((a + b) / 2 for a, b in zip(low, high, strict=True))
    center = (*point_at((0.0, 0.0, largest.yaw), u, v), z)
    size = (high[0] - low[0], high[1] - low[1], high[2] - low[2])
    return Box(largest.id, largest.label, largest.instance, center, size, largest.yaw)


def corners_around(parts: Sequence[Primitive], yaw: float) -> tuple[list[float], list[float]]:
    """The lowest and the highest corner [3] of the box around shapes, in the layout's frame turned by `yaw`."""
    cos, sin = math.cos(yaw), math.sin(yaw)
    low, high = [math.inf] * 3, [-math.inf] * 3
    for part in parts:
        x, y, z = part.center
        length, width, height = part.size
        c, s = abs(math.cos(part.yaw - yaw)), abs(math.sin(part.yaw - yaw))
        middle = (cos * x + sin * y, cos * y - sin * x, z)
        half = ((c * length + s * width) / 2, (s * length + c * width) / 2, height / 2)
        low = [min(a, m - h) for a, m, h in zip(low, middle, half, strict=True)]
        high = [max(a, m + h) for a, m, h in zip(high, middle, half, strict=True)]
    return low, high


def primitive_mesh(primitive: Primitive) -> TriangleMesh:
    """The primitive as triangles in the layout's frame; the vertices of round shapes lie on the surface."""
    unit = primitive.mesh if primitive.mesh is not None else unit_mesh(primitive.shape)
    vertices = unit.vertices * primitive.size
    cos, sin = np.cos(primitive.yaw), np.sin(primitive.yaw)
    x, y = vertices[:, 0].copy(), vertices[:, 1].copy()
    vertices[:, 0], vertices[:, 1] = cos * x - sin * y, sin * x + cos * y
    return TriangleMesh.unchecked(vertices + primitive.center, unit.faces)


def _check_number(primitives: Sized) -> None:
    if len(primitives) > MOST_PRIMITIVES:
        raise LayoutError(f"{len(primitives)} primitives; a layout has {MOST_PRIMITIVES} at most")
