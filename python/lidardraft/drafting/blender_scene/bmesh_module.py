"""`bmesh` as a script sees it: vertices and faces that are made and moved before they become a mesh."""

from __future__ import annotations

from collections.abc import Callable

from lidardraft.drafting.blender_scene.bmesh_operators import bmesh_operators
from lidardraft.drafting.blender_scene.edited_mesh import EditedEdge, EditedFace, EditedMesh, EditedVertex
from lidardraft.drafting.blender_scene.meshes import Mesh
from lidardraft.drafting.blender_scene.scene import Scene
from lidardraft.drafting.script.limits import RefusalError
from lidardraft.drafting.script.values import Builtin, KindOfRecord, Namespace, Value, describe


def bmesh_module(scene: Scene) -> Namespace:
    """The module, of which the meshes go into the scene."""

    def edited(mesh: Value) -> Mesh:
        if not isinstance(mesh, Mesh):
            raise RefusalError(f"{describe(mesh)} is no mesh")
        return mesh

    def from_edit_mesh(mesh: Value) -> EditedMesh:
        if not scene.edit_mode:
            raise RefusalError("from_edit_mesh outside of the edit mode")
        if edited(mesh) not in scene.edited:
            scene.edited[mesh] = EditedMesh(scene.objects.budget, scene.note)
            scene.edited[mesh].take_mesh(mesh)
        return scene.edited[mesh]

    functions: dict[str, Callable[..., Value]] = {
        "new": lambda **_: EditedMesh(scene.objects.budget, scene.note),
        "from_edit_mesh": from_edit_mesh,
        "update_edit_mesh": lambda mesh, **_: edited(mesh) and None,
    }
    values: dict[str, Value] = {name: Builtin(f"bmesh.{name}", function) for name, function in functions.items()}
    kinds = {"BMVert": EditedVertex, "BMFace": EditedFace, "BMesh": EditedMesh, "BMEdge": EditedEdge}
    values["types"] = Namespace("bmesh.types", {name: KindOfRecord(kind) for name, kind in kinds.items()})
    operators = bmesh_operators(scene.note)
    values["ops"] = Namespace("bmesh.ops", {name: Builtin(f"bmesh.ops.{name}", f) for name, f in operators.items()})
    return Namespace("bmesh", values)
