from scene_reading import CUBE, refuses, scene


def test_operators_that_leave_shapes_alone_are_passed_over() -> None:
    calls = ("render.render(write_still=True)", "wm.save_as_mainfile(filepath='a')", "export_scene.gltf(filepath='a')")
    layout = scene(
        CUBE + "".join(f"bpy.ops.{call}\n" for call in calls) + "if bpy.ops.object.mode_set.poll():\n    pass"
    )
    assert [note.split(": ")[1].split(" ")[0] for note in layout.provenance["notes"]] == [
        "bpy.ops.render.render",
        "bpy.ops.wm.save_as_mainfile",
        "bpy.ops.export_scene.gltf",
    ]


def test_other_operators_are_refused() -> None:
    refuses("bpy.ops.import_scene.obj(filepath='a.obj')", "^line 6: bpy.ops.import_scene.obj is not supported")
    refuses("bpy.ops.mesh()", "bpy.ops.mesh cannot be called")
    refuses("bpy.types.Operator", "bpy.types.Operator is not supported")
