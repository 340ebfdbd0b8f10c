import pytest
from scene_reading import refuses, scene


@pytest.mark.parametrize(
    ("operator", "shape", "size"),
    [
        ("cube_add(size=3)", "box", (3, 3, 3)),
        ("cube_add(size=2, scale=(1, 2, 3))", "box", (2, 4, 6)),
        ("plane_add(size=4)", "plane", (4, 4, 0)),
        ("grid_add(x_subdivisions=3, size=4)", "plane", (4, 4, 0)),
        ("cylinder_add(radius=2, depth=5)", "cylinder", (4, 4, 5)),
        ("cone_add(radius1=1, radius2=1, depth=2)", "cylinder", (2, 2, 2)),
        ("cone_add(radius1=1.5, depth=2, vertices=32)", "mesh", (3, 3, 2)),
        ("uv_sphere_add(radius=2)", "ellipsoid", (4, 4, 4)),
        ("ico_sphere_add(radius=2, subdivisions=3)", "ellipsoid", (4, 4, 4)),
        ("torus_add(major_radius=2, minor_radius=0.5)", "mesh", (5, 5, 1)),
        ("torus_add(mode='EXT_INT', abso_major_rad=2, abso_minor_rad=1)", "mesh", (4, 4, 1)),
        ("circle_add(radius=2, fill_type='NGON')", "mesh", (4, 4, 0)),
    ],
)
def test_each_operator_makes_its_shape(operator: str, shape: str, size: tuple[float, ...]) -> None:
    (primitive,) = scene(f"bpy.ops.mesh.primitive_{operator}\nbpy.context.object.name = 'House'")
    assert primitive.shape == shape
    assert primitive.size == pytest.approx(size, abs=1e-9)


def test_a_circle_without_faces_is_left_out() -> None:
    layout = scene(
        "bpy.ops.mesh.primitive_circle_add()\nbpy.ops.mesh.primitive_cube_add()\nbpy.context.object.name = 'Car'"
    )
    assert [p.label for p in layout] == ["car"]
    assert "Circle has no faces" in layout.provenance["notes"][0]


@pytest.mark.parametrize(
    ("operator", "said"),
    [
        ("cube_add(width=3)", "the argument 'width' is not supported; size are"),
        ("cube_add(location=(1, 2))", "the location is a tuple; it must be 3 numbers"),
        ("cube_add(size='big')", "size is 'big'; it must be a finite number"),
        ("cube_add(align='VIEW')", "align='VIEW' or enter_editmode is not supported"),
        ("uv_sphere_add(segments=1000)", "segments is 1000; it must be 3 to 500"),
        ("ico_sphere_add(subdivisions=9)", "subdivisions is 9; it must be 1 to 8"),
        ("cylinder_add(vertices=2)", "vertices is 2; it must be 3 to 500"),
        ("monkey_add()", "monkey_add is not supported"),
        ("teapot_add()", "bpy.ops.mesh.primitive_teapot_add is not supported"),
    ],
)
def test_what_they_refuse(operator: str, said: str) -> None:
    refuses(f"bpy.ops.mesh.primitive_{operator}", said)
