"""`bpy` as a script imports it: a table of what is read, what is passed over with a note, and nothing else."""

from __future__ import annotations

from lidardraft.drafting.blender_scene.edit_operators import edit_operators
from lidardraft.drafting.blender_scene.mesh_operators import mesh_operators
from lidardraft.drafting.blender_scene.object_operators import object_operators
from lidardraft.drafting.blender_scene.scene import Scene
from lidardraft.drafting.script.limits import RefusalError
from lidardraft.drafting.script.values import Builtin, Namespace, Record, Value

# Operators that leave every shape where it is: pictures, files that are written, views, smoothness.
_PASSED_OVER = (
    *("render.", "export_scene.", "export_mesh.", "export_anim.", "wm.save_", "wm.obj_export", "wm.stl_export"),
    *("wm.ply_export", "wm.usd_export", "view3d.", "screen.", "outliner.", "uv.", "ed.undo", "wm.redraw_timer"),
    *("object.shade_", "object.material_slot_", "object.hide_view_", "material.", "world.", "node."),
)


class Operators(Record):
    """`bpy.ops`, or one of its groups: `name` is "" or, say, "mesh."."""

    def __init__(self, scene: Scene, name: str = "") -> None:
        self.kind = f"bpy.ops.{name}".rstrip(".")
        self._scene = scene
        self._name = name
        self._known = mesh_operators(scene) | object_operators(scene) | edit_operators(scene)
        self._made: dict[str, Value] = {}

    def attribute(self, name: str) -> Value:
        if name not in self._made:
            self._made[name] = self._operator(self._name + name) if self._name else Operators(self._scene, f"{name}.")
        return self._made[name]

    def _operator(self, name: str) -> Value:
        if name in self._known:
            return Operator(f"bpy.ops.{name}", self._known[name])
        if not name.startswith(_PASSED_OVER):
            raise RefusalError(f"bpy.ops.{name} is not read")
        return Operator(f"bpy.ops.{name}", lambda **_: self._scene.note(f"bpy.ops.{name} is passed over"))


class Operator(Builtin):
    """One operator, which can also be asked whether it may be called."""

    def attribute(self, name: str) -> Value:
        return Builtin("poll", lambda: True) if name == "poll" else super().attribute(name)


def bpy_module(scene: Scene) -> Namespace:
    """The module, of which a script fills the scene."""
    return Namespace("bpy", {"ops": Operators(scene), **scene.modules()})
