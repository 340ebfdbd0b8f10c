"""The objects of a Blender scene: their transforms, parents and modifiers. Only array modifiers are applied."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from lidardraft.drafting.blender.bpy.blocks import Block, Blocks, Listed, Unread
from lidardraft.drafting.blender.bpy.mathutils import (
    IDENTITY,
    Euler,
    LiveVector,
    Matrix,
    Quaternion,
    Vector,
    affine,
    angles_of,
    inverse,
    of_quaternion,
    quaternion_of,
    rotation_matrix,
)
from lidardraft.drafting.blender.bpy.meshes import Material, Mesh, scale_of
from lidardraft.drafting.blender.script.limits import RaisedError, RefusalError, Script
from lidardraft.drafting.blender.script.values import (
    Methods,
    Record,
    Value,
    describe,
    of_kind,
    real,
    reals,
    text,
    whole,
)

# Modifiers that change a surface by little; the notes on others say that the shape is that without them.
_SMOOTHING = ("BEVEL", "SUBSURF", "EDGE_SPLIT", "WEIGHTED_NORMAL", "SMOOTH", "TRIANGULATE", "SMOOTH_BY_ANGLE")
_MOST_COPIES = 1000  # of one array
# Attributes of an object's display that change neither its place nor its shape.
_LOOKS = (
    *("hide_render", "hide_viewport", "hide_select", "display_type", "show_name", "show_in_front", "show_wire"),
    *("color", "pass_index", "cycles", "visible_shadow", "visible_camera", "show_axis", "show_bounds"),
    *("show_transparent", "empty_display_size", "empty_display_type", "use_fake_user", "track_axis", "up_axis"),
    "lock_location",
)
_CORNERS = [(0, 0, 0), (0, 0, 1), (0, 1, 1), (0, 1, 0), (1, 0, 0), (1, 0, 1), (1, 1, 1), (1, 1, 0)]


class ArrayModifier(Record):
    """Copies of an object in a row, `count` of them including itself."""

    kind = "an array modifier"

    def __init__(self, name: str) -> None:
        self.name = name
        self.values: dict[str, Value] = {
            "count": 2,
            "use_relative_offset": True,
            "use_constant_offset": False,
            "relative_offset_displace": Vector([1.0, 0.0, 0.0]),
            "constant_offset_displace": Vector([1.0, 0.0, 0.0]),
            "fit_type": "FIXED_COUNT",
            "use_merge_vertices": False,
        }

    fields: ClassVar[Methods] = {"name": lambda self: self.name, "type": lambda _: "ARRAY"}

    def attribute(self, name: str) -> Value:
        return self.values[name] if name in self.values else super().attribute(name)

    def set_attribute(self, name: str, value: Value) -> None:
        if name.startswith("show_"):
            return
        if name not in self.values or (name == "fit_type" and value != "FIXED_COUNT"):
            super().set_attribute(name, value)
        elif name.endswith("_displace"):
            self.values[name].change(reals(value, 3, f"the {name}"))
        elif name == "count":
            self.values[name] = whole(value, "the count of an array", 1, _MOST_COPIES)
        elif not isinstance(value, bool | int | str):
            raise RefusalError(f"{name} of an array is {describe(value)}")
        else:
            self.values[name] = value

    def copied(self) -> ArrayModifier:
        """A copy with the same settings."""
        other = ArrayModifier(self.name)
        for name, value in self.values.items():
            other.values[name] = Vector(value.numbers) if isinstance(value, Vector) else value
        return other

    def step(self, extents: np.ndarray) -> np.ndarray:
        """The step from one copy to the next [3], along the axes of an object whose mesh has these extents [3]."""
        values, step = self.values, np.zeros(3)
        if values["use_relative_offset"]:
            step += np.array(values["relative_offset_displace"].numbers) * extents
        if values["use_constant_offset"]:
            step += values["constant_offset_displace"].numbers
        return step


class Modifiers(Listed):
    """All modifiers of one object."""

    kind = "the list of modifiers"

    def __init__(self, script: Script) -> None:
        self._script = script
        self.arrays: list[ArrayModifier] = []

    def new(self, name: Value, type: Value) -> Value:
        """A new modifier; an unsupported one and its settings are ignored."""
        kind = text(type, "the modifier")
        if kind == "ARRAY":
            self.arrays.append(ArrayModifier(text(name, "the name")))
            return self.arrays[-1]
        shape = "" if kind in _SMOOTHING else ": the shape is that without it"
        self._script.note(f"the modifier {kind:.40} is passed over{shape}")
        return Unread("modifiers", self._script)

    def held(self) -> list[ArrayModifier]:
        return self.arrays

    def __getitem__(self, key: Value) -> Value:
        try:
            return super().__getitem__(key)
        except RaisedError:
            return Unread("modifiers", self._script)  # an ignored one

    methods: ClassVar[Methods] = {
        **Listed.methods,
        "new": new,
        "clear": lambda self: self.arrays.clear(),
        "remove": lambda self, modifier: self.arrays.remove(modifier) if modifier in self.arrays else None,
    }

    def offsets(self, extents: np.ndarray) -> list[np.ndarray]:
        """The offsets [3] of its copies along the axes of the object, itself first; several arrays multiply."""
        count = 1
        for array in self.arrays:
            count *= array.values["count"]
            if count > _MOST_COPIES:
                raise RefusalError(f"the arrays of an object make {count} copies; the limit is {_MOST_COPIES}")
        places = [np.zeros(3)]
        for array in self.arrays:
            step, numbers = array.step(extents), range(array.values["count"])
            extents = extents + abs(step) * (len(numbers) - 1)
            places = [place + number * step for number in numbers for place in places]
        return places


class Objects(Blocks):
    """`bpy.data.objects`, with the selected ones in the order of selection."""

    def __init__(self, script: Script) -> None:
        super().__init__("objects", SceneObject, script)
        self.active: SceneObject | None = None
        self.links = 0  # links of objects to collections so far
        self.selection: dict[SceneObject, None] = {}

    def new(self, name: str, *arguments: Value, **named: Value) -> Value:
        if len(self.by_name) >= (most := self.script.limits.objects):
            raise RefusalError(f"more than {most} objects")
        return super().new(name, *arguments, **named)

    def remove(self, block: Value) -> None:
        super().remove(block)
        self.selection.pop(block, None)
        self.active = None if self.active is block else self.active
        for child in self.all():
            if child.parent is block:
                child.parent = None

    def all(self) -> list[SceneObject]:
        """All objects, linked to the scene or not, in order of creation."""
        return list(self)

    def select_only(self, item: SceneObject) -> None:
        """Select an object alone, and make it active."""
        self.selection = {item: None}
        self.active = item


class SceneObject(Block):
    """An object: a mesh, an empty, a light or a camera, with its transform."""

    kind = "an object"
    owner: Objects

    def __init__(self, owner: Objects, object_data: Value = None) -> None:
        super().__init__(owner)
        if not isinstance(object_data, Mesh | Unread | None):
            raise RefusalError(f"an object of {describe(object_data)} is not supported")
        self.data = object_data
        self.location = Vector([0.0, 0.0, 0.0])
        self.rotation = Euler([0.0, 0.0, 0.0])
        self.quaternion = Quaternion([1.0, 0.0, 0.0, 0.0])  # used if that is the mode
        self.scale = Vector([1.0, 1.0, 1.0])
        self.parent: SceneObject | None = None
        self.parent_inverse = IDENTITY
        self.collections: dict[Block, int] = {}  # with the number of the link, which counts up
        self.modifiers = Modifiers(self.script)
        self.mode = "XYZ"
        self.line = self.script.line
        self.suffix = ""  # of the id of an array's copy of another object

    def local(self) -> np.ndarray:
        """parent_from_object [4, 4], without the inverse of the parent."""
        self.script.check_time()
        return affine(self.turned() * self.scale.numbers, np.array(self.location.numbers))

    def turned(self) -> np.ndarray:
        """parent_from_object [3, 3], without the scale."""
        if self.mode == "XYZ":
            return rotation_matrix(self.rotation.numbers)
        return of_quaternion(self.quaternion.numbers)

    def turn(self, rotation: np.ndarray) -> None:
        """Turn it so that `turned()` is the rotation [3, 3]."""
        if self.mode == "XYZ":
            self.rotation.change(angles_of(rotation))
        else:
            self.quaternion.change(quaternion_of(rotation))

    def world(self) -> np.ndarray:
        """world_from_object [4, 4]."""
        matrix, parent = self.local(), self.parent
        inverse = self.parent_inverse
        while parent is not None:
            matrix = parent.local() @ inverse @ matrix
            inverse, parent = parent.parent_inverse, parent.parent
        return matrix

    def parents(self) -> list[SceneObject]:
        """Its parent, the parent of that, and so on."""
        above, found = self.parent, list[SceneObject]()
        while above is not None:
            found.append(above)
            above = above.parent
        return found

    def set_world(self, matrix: np.ndarray) -> None:
        """Place it so that `world()` is the matrix [4, 4]; raises `RefusalError` if it shears."""
        if self.parent is not None:
            parent = self.parent.world() @ self.parent_inverse
            matrix = inverse(parent, f"the parent of {self.name!r:.60}") @ matrix
        self.set_local(matrix)

    def set_local(self, matrix: np.ndarray) -> None:
        """Place it so that `local()` is the matrix [4, 4]; raises `RefusalError` if it shears."""
        if not np.isfinite(matrix).all():
            raise RefusalError(f"{self.name!r:.60} is placed by numbers that are not finite")
        scale = np.linalg.norm(matrix[:3, :3], axis=0)
        if np.linalg.det(matrix[:3, :3]) < 0:
            scale = -scale
        rotation = matrix[:3, :3] / np.where(scale == 0, 1.0, scale)
        if scale.all() and not np.allclose(rotation.T @ rotation, np.eye(3), atol=1e-6):
            raise RefusalError("a matrix that shears an object")
        self.location.change(matrix[:3, 3].tolist())
        self.scale.change(scale.tolist())
        self.turn(rotation)

    def set_parent(self, parent: Value) -> None:
        """Set its parent object, or None."""
        if parent is not None and self in (parent, *of_kind(parent, SceneObject, "the parent").parents()):
            raise RefusalError(f"the parents of {self.name!r:.60} go in a circle")
        self.parent = parent

    def copy(self) -> SceneObject:
        """Another object with the same data, transform and parent, in no collection yet."""
        self.script.take_made(self.properties)
        other: SceneObject = self.owner.new(self.name, self.data)
        for name in ("location", "rotation", "quaternion", "scale"):
            getattr(other, name).change(getattr(self, name).numbers)
        other.parent, other.parent_inverse = self.parent, self.parent_inverse
        other.properties, other.mode = dict(self.properties), self.mode
        other.modifiers.arrays = [array.copied() for array in self.modifiers.arrays]
        return other

    def vertices(self) -> np.ndarray:
        """The vertices of its mesh [V, 3], in its own axes."""
        if not isinstance(self.data, Mesh) or self.data.shape is None:
            return np.zeros((0, 3))
        return self.data.made()[0]

    def extents(self) -> np.ndarray:
        """The full extents [3] of its mesh along the mesh's own axes, before the object's scale."""
        vertices = self.vertices()
        return np.asarray(np.ptp(vertices, axis=0)) if len(vertices) else np.zeros(3)

    def attribute(self, name: str) -> Value:
        if name in self.fields or name in self.methods:
            return super().attribute(name)
        if isinstance(self.data, Unread) or name in _LOOKS:
            return Unread(f"{name} of objects", self.script)
        return super().attribute(name)

    def set_attribute(self, name: str, value: Value) -> None:
        if name in self.setters:
            self.setters[name](self, value)
        elif name in _LOOKS or isinstance(self.data, Unread):
            self.script.note(f"{name} of objects is passed over")
        else:
            super().set_attribute(name, value)

    def _type(self) -> str:
        return "MESH" if isinstance(self.data, Mesh) else "EMPTY" if self.data is None else self.data.kind

    def _set_angles(self, value: Value) -> None:
        if self.mode != "XYZ":
            self.script.note(f"rotation_euler is passed over: the rotation mode is {self.mode!r}")
        self.rotation.change(reals(value, 3, "the rotation"))

    def _set_quaternion(self, value: Value) -> None:
        if self.mode != "QUATERNION":
            self.script.note(f"rotation_quaternion is passed over: the rotation mode is {self.mode!r}")
        self.quaternion.change(reals(value, 4, "the quaternion"))

    def _set_mode(self, value: Value) -> None:
        if value not in ("XYZ", "QUATERNION"):
            raise RefusalError(f"the rotation mode {describe(value)} is not supported; 'XYZ' and 'QUATERNION' are")
        rotation, self.mode = self.turned(), value
        self.turn(rotation)

    def _dimensions(self) -> Vector:
        extents = self.extents()
        return LiveVector(lambda: (extents * np.abs(self.scale.numbers)).tolist(), self._set_dimensions)

    def _set_dimensions(self, wanted: Value) -> None:
        scale = list(self.scale.numbers)
        numbers = zip(self.extents().tolist(), reals(wanted, 3, "the dimensions"), strict=True)
        for axis, (extent, length) in enumerate(numbers):
            if extent > 0:
                scale[axis] = real(length / extent, "the scale")
        self.scale.change(scale)

    def _basis(self) -> Matrix:
        return Matrix(self.local(), self.set_local)

    def _bound_box(self) -> Value:
        vertices = self.vertices()
        vertices = vertices if len(vertices) else np.zeros((1, 3))
        corners = np.stack([vertices.min(axis=0), vertices.max(axis=0)])
        return [tuple(float(corners[side, axis]) for axis, side in enumerate(sides)) for sides in _CORNERS]

    def materials(self) -> list[Material | None]:
        """The materials of its mesh."""
        return self.data.materials.materials if isinstance(self.data, Mesh) else []

    def _set_material(self, value: Value) -> None:
        if not isinstance(self.data, Mesh):
            return
        if self.data.materials.materials:
            self.data.materials[0] = value
        else:
            self.data.materials.append(value)

    def _set_parent_inverse(self, array: np.ndarray) -> None:
        self.parent_inverse = array

    def _set_data(self, value: Value) -> None:
        if not isinstance(value, Mesh | None):
            raise RefusalError(f"the data of an object is {describe(value)}; it must be a mesh")
        self.data = value

    def _select(self, state: Value = True) -> None:
        if state:
            self.owner.selection[self] = None
        else:
            self.owner.selection.pop(self, None)

    def _collections(self) -> tuple[Block, ...]:
        return tuple(self.collections)

    def _constraints(self) -> Value:
        if isinstance(self.data, Mesh | None):
            raise RefusalError("constraints of objects are not supported")
        return Unread("constraints", self.script)

    def class_names(self) -> list[str]:
        """The names that may give its class, the most telling first: its own, those of its materials, parents and
        collections."""
        return [each.name for each in (self, *self.materials(), *self.parents(), *self.collections) if each]

    fields: ClassVar[Methods] = {
        **Block.fields,
        "data": lambda self: self.data,
        "type": _type,
        "location": lambda self: self.location,
        "rotation_euler": lambda self: self.rotation,
        "rotation_mode": lambda self: self.mode,
        "rotation_quaternion": lambda self: self.quaternion,
        "scale": lambda self: self.scale,
        "parent": lambda self: self.parent,
        "matrix_world": lambda self: Matrix(self.world(), self.set_world),
        "matrix_parent_inverse": lambda self: Matrix(self.parent_inverse, self._set_parent_inverse),
        **dict.fromkeys(("matrix_local", "matrix_basis"), _basis),
        "bound_box": _bound_box,
        "dimensions": _dimensions,
        "active_material": lambda self: next(iter(self.materials()), None),
        "users_collection": _collections,
        "material_slots": lambda self: Unread("material_slots", self.script),
        "modifiers": lambda self: self.modifiers,
        "constraints": _constraints,
        "animation_data": lambda _: None,
    }
    setters: ClassVar[Methods] = {
        **Block.setters,
        "data": _set_data,
        "location": lambda self, value: self.location.change(reals(value, 3, "the location")),
        "rotation_euler": _set_angles,
        "rotation_mode": _set_mode,
        "rotation_quaternion": _set_quaternion,
        "scale": lambda self, value: self.scale.change(scale_of(value)),
        "parent": set_parent,
        "matrix_world": lambda self, value: self.set_world(_four_rows(value)),
        "matrix_parent_inverse": lambda self, value: self._set_parent_inverse(_four_rows(value)),
        "dimensions": _set_dimensions,
        "active_material": _set_material,
    }
    methods: ClassVar[Methods] = {
        **Block.methods,
        "select_set": _select,
        "select_get": lambda self: self in self.owner.selection,
        "copy": copy,
        "hide_get": lambda _: False,
        "hide_set": lambda self, *_: self.script.note("what hides objects is passed over"),
        "keyframe_insert": lambda self, *_, **__: self.script.note("animation is passed over"),
    }


def _four_rows(value: Value) -> np.ndarray:
    array = of_kind(value, Matrix, "the matrix of an object").array
    if len(array) != 4:
        raise RefusalError("the matrix of an object has 3 rows; it must have 4")
    return array
