"""The objects of a Blender scene: where they are, how they are turned and scaled, and whose parts they are."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from lidardraft.drafting.blender_scene.blocks import Block, Blocks, Unread
from lidardraft.drafting.blender_scene.mathutils_module import quaternion
from lidardraft.drafting.blender_scene.meshes import Material, Mesh, scale_of
from lidardraft.drafting.blender_scene.modifiers import Modifiers
from lidardraft.drafting.blender_scene.rotations import affine, angles_of, rotation_matrix
from lidardraft.drafting.blender_scene.vectors import IDENTITY, Euler, Matrix, Rotation, Vector
from lidardraft.drafting.script.limits import Budget, RefusalError
from lidardraft.drafting.script.values import Builtin, Value, describe, real, reals, truth

# What changes how an object is shown, and not where it is or what shape it has.
_LOOKS = (
    *(
        "hide_render",
        "hide_viewport",
        "hide_select",
        "display_type",
        "show_name",
        "show_in_front",
        "show_wire",
        "color",
    ),
    *("pass_index", "cycles", "visible_shadow", "visible_camera", "show_axis", "show_bounds", "show_transparent"),
    *("empty_display_size", "empty_display_type", "use_fake_user", "track_axis", "up_axis", "lock_location"),
)
_LONGEST_CHAIN = 32  # of parents
_STEPS = 20  # that a copy or a matrix costs


class Objects(Blocks):
    """`bpy.data.objects`, with what is selected of them, in the order of selection."""

    def __init__(self, budget: Budget, note: Callable[[str], None], line: Callable[[], int]) -> None:
        super().__init__("objects", SceneObject, budget, note)
        self.line = line  # of the script, that is being carried out
        self.active: SceneObject | None = None
        self.links = 0  # of objects to collections, that have been made
        self.selection: dict[SceneObject, None] = {}

    def new(self, name: str, *arguments: Value, **named: Value) -> Value:
        most = self.budget.limits.objects
        if len(self.by_name) >= most:
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
        """All objects, linked to the scene or not, in the order of their making."""
        self.budget.take_cells(len(self.by_name))
        return [item for item in self.by_name.values() if isinstance(item, SceneObject)]

    def select_only(self, item: SceneObject) -> None:
        """Make an object the only selected one, and the active one."""
        self.selection = {item: None}
        self.active = item


class SceneObject(Block):
    """An object: a mesh, an empty, a light or a camera, with its transform."""

    kind = "an object"
    weight = 2
    owner: Objects

    def __init__(self, owner: Objects, object_data: Value = None) -> None:
        super().__init__(owner)
        if not isinstance(object_data, Mesh | Unread | None):
            raise RefusalError(f"an object of {describe(object_data)} is not read")
        self.data = object_data
        self.location = Vector([0.0, 0.0, 0.0])
        self.rotation = Euler([0.0, 0.0, 0.0])
        self.scale = Vector([1.0, 1.0, 1.0])
        self.parent: SceneObject | None = None
        self.parent_inverse = IDENTITY
        self.collections: dict[Block, int] = {}  # with the number of the link, which grows from one to the next
        self.modifiers = Modifiers(owner.note)
        self.mode = "XYZ"
        self.line = owner.line()
        self.suffix = ""  # of its id, where it is what an array has made of another object

    def local(self) -> np.ndarray:
        """parent_from_object [4, 4], without the inverse of the parent."""
        return affine(rotation_matrix(self.rotation.numbers) * self.scale.numbers, np.array(self.location.numbers))

    def world(self) -> np.ndarray:
        """world_from_object [4, 4]."""
        matrix, parent = self.local(), self.parent
        inverse = self.parent_inverse
        while parent is not None:
            matrix = parent.local() @ inverse @ matrix
            inverse, parent = parent.parent_inverse, parent.parent
        return matrix

    def set_world(self, matrix: np.ndarray) -> None:
        """Place it so that `world()` is the matrix [4, 4]; raises `RefusalError` for one that shears."""
        self.owner.budget.take_steps(3 * _STEPS)
        if self.parent is not None:
            try:
                matrix = np.linalg.inv(self.parent.charged_world() @ self.parent_inverse) @ matrix
            except np.linalg.LinAlgError:
                raise RefusalError(f"the parent of {self.name!r:.60} is scaled to nothing") from None
        if not np.isfinite(matrix).all():
            raise RefusalError(f"{self.name!r:.60} is placed by numbers that are not finite")
        scale = np.linalg.norm(matrix[:3, :3], axis=0)
        if np.linalg.det(matrix[:3, :3]) < 0:
            scale = -scale
        rotation = matrix[:3, :3] / np.where(scale == 0, 1.0, scale)
        if scale.all() and not np.allclose(rotation.T @ rotation, np.eye(3), atol=1e-6):
            raise RefusalError("a matrix that shears an object")
        self.location.numbers, self.scale.numbers = matrix[:3, 3].tolist(), scale.tolist()
        self.rotation.numbers = angles_of(rotation)

    def set_parent(self, parent: Value) -> None:
        """Make it a part of another object, or of none."""
        if not isinstance(parent, SceneObject | None):
            raise RefusalError(f"the parent is {describe(parent)}; it must be an object")
        above, count = parent, 0
        while above is not None:
            count += 1
            if above is self or count > _LONGEST_CHAIN:
                raise RefusalError(
                    f"the parents of {self.name!r:.60} go in a circle, or are more than {_LONGEST_CHAIN}"
                )
            above = above.parent
        self.parent = parent

    def copy(self) -> SceneObject:
        """Another object with the same data, transform and parent, in no collection yet."""
        self.owner.budget.take_steps(_STEPS)
        self.owner.budget.take_cells(3 * len(self.properties))
        other: SceneObject = self.owner.new(self.name, self.data)
        for name in ("location", "rotation", "scale"):
            getattr(other, name).numbers = list(getattr(self, name).numbers)
        other.parent, other.parent_inverse = self.parent, self.parent_inverse
        other.properties, other.mode = dict(self.properties), self.mode
        other.modifiers.arrays = [array.copied() for array in self.modifiers.arrays]
        return other

    def extents(self) -> np.ndarray:
        """The full extents [3] of its mesh along the mesh's own axes, before the object's scale."""
        vertices = self.vertices()
        return np.asarray(np.ptp(vertices, axis=0)) if len(vertices) else np.zeros(3)

    def vertices(self) -> np.ndarray:
        """The vertices of its mesh [V, 3], in its own axes."""
        if not isinstance(self.data, Mesh) or self.data.shape is None:
            return np.zeros((0, 3))
        self.owner.budget.take_steps(_STEPS + self.data.shape.vertices)
        vertices, _ = self.data.shape.make()
        return np.asarray(vertices @ self.data.matrix[:3, :3].T + self.data.matrix[:3, 3])

    def attribute(self, name: str) -> Value:
        if name in _FIELDS:
            return _FIELDS[name](self)
        if name in _METHODS:
            return Builtin(name, partial(_METHODS[name], self))
        try:
            return super().attribute(name)
        except RefusalError:
            if isinstance(self.data, Unread) or name in _LOOKS:
                return Unread(f"{name} of objects", self.owner.note)
            raise

    def _type(self) -> str:
        return "MESH" if isinstance(self.data, Mesh) else "EMPTY" if self.data is None else self.data.kind

    def charged_world(self) -> np.ndarray:
        """`world()`, counted as steps."""
        above, levels = self.parent, 1
        while above is not None:
            above, levels = above.parent, levels + 1
        self.owner.budget.take_steps(_STEPS * levels)
        return self.world()

    def _collections(self) -> tuple[Block, ...]:
        self.owner.budget.take_cells(len(self.collections))
        return tuple(self.collections)

    def _quaternion(self) -> Rotation:
        self.owner.budget.take_steps(_STEPS)
        return Rotation(rotation_matrix(self.rotation.numbers))

    def _local(self) -> np.ndarray:
        self.owner.budget.take_steps(_STEPS)
        return self.local()

    def _bound_box(self) -> Value:
        self.owner.budget.take_steps(_STEPS)
        vertices = self.vertices()
        vertices = vertices if len(vertices) else np.zeros((1, 3))
        corners = np.stack([vertices.min(axis=0), vertices.max(axis=0)])
        order = [(0, 0, 0), (0, 0, 1), (0, 1, 1), (0, 1, 0), (1, 0, 0), (1, 0, 1), (1, 1, 1), (1, 1, 0)]
        return [tuple(float(corners[side, axis]) for axis, side in enumerate(sides)) for sides in order]

    def materials(self) -> list[Material | None]:
        """Those of its mesh."""
        return self.data.materials.materials if isinstance(self.data, Mesh) else []

    def select(self, state: Value = True) -> None:
        """Select it, or not."""
        if truth(state):
            self.owner.selection[self] = None
        else:
            self.owner.selection.pop(self, None)

    def _constraints(self) -> Value:
        if isinstance(self.data, Mesh | None):
            raise RefusalError("constraints of objects are not read")
        return Unread("constraints", self.owner.note)

    def set_attribute(self, name: str, value: Value) -> None:
        if name == "location":
            self.location.numbers = list(reals(value, 3, "the location"))
        elif name == "rotation_quaternion" and self.mode == "QUATERNION":
            self.rotation.numbers = angles_of(quaternion(value).array)
        elif name == {"XYZ": "rotation_quaternion", "QUATERNION": "rotation_euler"}[self.mode]:
            self.owner.note(f"{name} is passed over: the rotation mode is {self.mode!r}")
        elif name == "rotation_euler":
            self.rotation.numbers = list(reals(value, 3, "the rotation"))
        elif name == "scale":
            self.scale.numbers = list(scale_of(value))
        elif name == "dimensions":
            self._set_dimensions(reals(value, 3, "the dimensions"))
        elif name == "parent":
            self.set_parent(value)
        elif name in ("matrix_world", "matrix_parent_inverse"):
            self._set_matrix(name, value)
        elif name == "active_material":
            self._set_material(value)
        elif name == "data" and isinstance(value, Mesh | None):
            self.data = value
        elif name == "rotation_mode" and value in ("XYZ", "QUATERNION"):
            self.mode = value
        elif name in _LOOKS or isinstance(self.data, Unread):
            self.owner.note(f"{name} of objects is passed over")
        else:
            super().set_attribute(name, value)

    def _set_dimensions(self, wanted: tuple[float, ...]) -> None:
        extents = self.extents().tolist()
        for axis, (extent, length) in enumerate(zip(extents, wanted, strict=True)):
            if extent > 0:
                self.scale.numbers[axis] = real(length / extent, "the scale")

    def _set_matrix(self, name: str, value: Value) -> None:
        if not isinstance(value, Matrix) or value.array.shape != (4, 4):
            raise RefusalError(f"{name} is {describe(value)}; it must be a Matrix of 4 rows")
        if name == "matrix_world":
            self.set_world(value.array)
        else:
            self.parent_inverse = value.array

    def _set_material(self, value: Value) -> None:
        if not isinstance(self.data, Mesh):
            return
        if self.data.materials.materials:
            self.data.materials.set_item(0, value)
        else:
            self.data.materials.append(value)

    def class_names(self) -> list[str]:
        """The names that may say its class, the most telling ones first: its own, those of its materials, parents and
        collections."""
        names, parent = [self.name, *(material.name for material in self.materials() if material)], self.parent
        while parent is not None:
            names.append(parent.name)
            parent = parent.parent
        return [*names, *(collection.name for collection in self.collections)]


def _active_material(item: SceneObject) -> Value:
    return next(iter(item.materials()), None)


_FIELDS: dict[str, Callable[[SceneObject], Value]] = {
    "data": lambda item: item.data,
    "type": SceneObject._type,
    "location": lambda item: item.location,
    "rotation_euler": lambda item: item.rotation,
    "rotation_mode": lambda item: item.mode,
    "rotation_quaternion": SceneObject._quaternion,
    "scale": lambda item: item.scale,
    "parent": lambda item: item.parent,
    "matrix_world": lambda item: Matrix(item.charged_world()),
    "matrix_local": lambda item: Matrix(item._local()),
    "matrix_basis": lambda item: Matrix(item._local()),
    "bound_box": SceneObject._bound_box,
    "dimensions": lambda item: Vector((item.extents() * np.abs(item.scale.numbers)).tolist()),
    "active_material": _active_material,
    "users_collection": SceneObject._collections,
    "material_slots": lambda item: Unread("material_slots", item.owner.note),
    "modifiers": lambda item: item.modifiers,
    "constraints": SceneObject._constraints,
    "animation_data": lambda _: None,
}
_METHODS: dict[str, Callable[..., Value]] = {
    "select_set": SceneObject.select,
    "select_get": lambda item: item in item.owner.selection,
    "copy": SceneObject.copy,
    "hide_get": lambda _: False,
    "hide_set": lambda item, *_: item.owner.note("what hides objects is passed over"),
    "keyframe_insert": lambda item, *_, **__: item.owner.note("animation is passed over"),
}
