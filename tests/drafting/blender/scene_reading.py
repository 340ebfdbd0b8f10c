"""Blender scripts for the tests of scenes."""

import pytest

from lidardraft.drafting.blender.layout import layout_from_blender
from lidardraft.errors import ScriptError
from lidardraft.scene.layout import Layout, Primitive

CUBE = "bpy.ops.mesh.primitive_cube_add(size=1, location=(5, 0, 0.5))\ncar = bpy.context.object\ncar.name = 'Car'\n"


def scene(script: str) -> Layout:
    """The layout of a script, which begins with the imports that all need."""
    return layout_from_blender(f"import bpy, math\nfrom mathutils import Vector, Euler, Matrix\n{script}")


def with_car(script: str) -> Primitive:
    """The first shape of a scene whose first object is a cube of 1 m, `car`, 5 m ahead."""
    return scene(CUBE + script).primitives[0]


def refuses(script: str, said: str) -> None:
    """The scene is refused."""
    with pytest.raises(ScriptError, match=said):
        scene(CUBE + script)
