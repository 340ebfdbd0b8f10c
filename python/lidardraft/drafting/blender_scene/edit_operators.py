"""The edit mode: all vertices of the active mesh are moved, turned and stretched together."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from lidardraft.drafting.blender_scene.meshes import Mesh
from lidardraft.drafting.blender_scene.rotations import affine
from lidardraft.drafting.blender_scene.scene import Scene
from lidardraft.drafting.script.limits import RefusalError
from lidardraft.drafting.script.values import Value, describe

_STEPS = 40  # that a change costs
# What leaves a surface where it is.
_PASSED_OVER = (
    *("normals_make_consistent", "flip_normals", "remove_doubles", "quads_convert_to_tris", "tris_convert_to_quads"),
    *("select_mode", "faces_shade_smooth", "faces_shade_flat", "mark_sharp", "mark_seam", "subdivide"),
)


def edit_operators(scene: Scene) -> dict[str, Callable[..., Value]]:
    """The operators of meshes by their names behind `bpy.ops.`."""

    def select_all(action: Value = "TOGGLE") -> Value:
        if action not in ("SELECT", "DESELECT", "INVERT", "TOGGLE"):
            raise RefusalError(f"the action is {describe(action)}")
        scene.edits_all = action == "SELECT" or (action != "DESELECT" and not scene.edits_all)
        return ["FINISHED"]

    def passed_over(name: str) -> Callable[..., Value]:
        return lambda **_: scene.note(f"bpy.ops.mesh.{name} is passed over")

    return {"mesh.select_all": select_all, **{f"mesh.{name}": passed_over(name) for name in _PASSED_OVER}}


def transform_vertices(scene: Scene, linear: np.ndarray, offset: np.ndarray) -> None:
    """Turn or stretch the vertices about their middle [3, 3], and move them [3], both along the axes of the world."""
    item = scene.objects.active
    if item is None or not isinstance(item.data, Mesh) or item.data in scene.edited:
        raise RefusalError("a transform in the edit mode of what is no mesh, or is open in bmesh, is not read")
    vertices = item.vertices()
    if not scene.edits_all or not len(vertices):
        return
    scene.objects.budget.take_steps(_STEPS)
    world = item.charged_world()
    middle = world[:3, :3] @ vertices.mean(axis=0) + world[:3, 3]
    change = affine(linear, middle - linear @ middle + offset)
    try:
        item.data.matrix = np.linalg.inv(world) @ change @ world @ item.data.matrix
    except np.linalg.LinAlgError:
        raise RefusalError("the object is scaled to nothing") from None
