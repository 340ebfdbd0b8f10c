from scene_reading import refuses, with_car


def test_a_mesh_is_edited_in_edit_mode() -> None:
    edited = (
        "import bmesh\nbpy.ops.object.mode_set(mode='EDIT')\nbm = bmesh.from_edit_mesh(car.data)\n"
        "for v in bm.verts:\n    v.co.x *= 4\n    v.co.z = (v.co.z + 0.5) * 2\n"
    )
    for end in ("bmesh.update_edit_mesh(car.data)\nbpy.ops.object.mode_set(mode='OBJECT')", ""):
        car = with_car(edited + end)
        assert (car.shape, car.size, car.center) == ("box", (4, 1, 2), (5, 0, 1.5))


def test_kinds_can_be_asked_for() -> None:
    with_car(
        "import bmesh\nbm = bmesh.new()\nv = bm.verts.new((0, 0, 0))\n"
        "assert isinstance(v, bmesh.types.BMVert) and not isinstance(v, (bmesh.types.BMFace, bmesh.types.BMEdge))"
    )


def test_what_it_refuses() -> None:
    refuses("import bmesh\nbmesh.from_edit_mesh(car.data)", "from_edit_mesh outside of the edit mode")
    refuses("import bmesh\nbmesh.update_edit_mesh(1)", "1 is no mesh")
    refuses("import bmesh\nbmesh.utils", "bmesh.utils is not supported")
