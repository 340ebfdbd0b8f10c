import pytest
from scene_reading import refuses, with_car

from lidardraft.scene.layout import primitive_mesh

NEW = "import bmesh\nbm = bmesh.new()\n"
END = "\nbm.to_mesh(car.data)"


@pytest.mark.parametrize(
    ("made", "shape", "size"),
    [
        ("create_cube(bm, size=2)", "box", (2, 2, 2)),
        ("create_grid(bm, x_segments=3, y_segments=2, size=4)", "plane", (8, 8, 0)),
        ("create_circle(bm, cap_ends=True, radius=2, segments=8)", "mesh", (4, 4, 0)),
        ("create_cone(bm, cap_ends=True, radius1=1, radius2=1, depth=3, segments=32)", "cylinder", (2, 2, 3)),
        ("create_uvsphere(bm, u_segments=32, v_segments=16, radius=1.5)", "ellipsoid", (3, 3, 3)),
        ("create_icosphere(bm, subdivisions=3, radius=1)", "ellipsoid", (2, 2, 2)),
    ],
)
def test_shapes_are_those_of_the_layout(made: str, shape: str, size: tuple[float, ...]) -> None:
    found = with_car(NEW + f"r = bmesh.ops.{made}\nassert len(r['verts']) == len(bm.verts)" + END)
    assert found.shape == shape
    assert found.size == pytest.approx(size, abs=0.1)  # an icosphere has no corner on each axis


def test_what_moves_vertices() -> None:
    box = with_car(
        NEW + "bmesh.ops.create_cube(bm, size=1, matrix=Matrix.Translation((0, 0, 0.5)))\n"
        "bmesh.ops.scale(bm, vec=(4, 2, 3), verts=bm.verts)\n"
        "bmesh.ops.translate(bm, vec=(0, 1, 0), verts=bm.verts[:])\n"
        "bmesh.ops.rotate(bm, cent=(0, 1, 0), matrix=Matrix.Rotation(math.pi / 2, 3, 'Z'), verts=bm.verts)" + END
    )
    assert (box.shape, sorted(round(size, 9) for size in box.size)) == ("box", [2, 3, 4])
    assert box.center == pytest.approx((5, 1, 2))
    assert abs(box.yaw) == pytest.approx(1.5707963) or box.size[0] == pytest.approx(2)


def test_a_face_is_extruded() -> None:
    house = with_car(
        NEW + "f = bm.faces.new([bm.verts.new(p) for p in [(0, 0, 0), (6, 0, 0), (6, 2, 0), (2, 2, 0), (0, 6, 0)]])\n"
        "r = bmesh.ops.extrude_face_region(bm, geom=[f])\n"
        "top = [v for v in r['geom'] if isinstance(v, bmesh.types.BMVert)]\n"
        "bmesh.ops.translate(bm, vec=(0, 0, 5), verts=top)\nassert len(bm.faces) == 7 and len(bm.verts) == 10" + END
    )
    assert (house.shape, house.size) == ("mesh", (6, 6, 5))
    assert primitive_mesh(house).faces.shape == (2 * 3 + 5 * 2, 3)


def test_vertices_are_deleted_with_their_faces() -> None:
    script = NEW + "bmesh.ops.create_cube(bm)\nbmesh.ops.delete(bm, geom=bm.verts[:1], context='VERTS')\n"
    with_car(script + "assert len(bm.verts) == 7 and len(bm.faces) == 3" + END)


def test_faces_are_deleted_with_the_vertices_of_no_other_one() -> None:
    two = "bmesh.ops.create_grid(bm, size=1)\nbmesh.ops.create_cube(bm)\n"
    with_car(
        NEW + two + "bmesh.ops.delete(bm, geom=[bm.faces[0]], context='FACES')\n"
        "assert len(bm.verts) == 8 and len(bm.faces) == 6\n"
        "bmesh.ops.delete(bm, geom=[bm.faces[0]], context='FACES')\n"
        "assert len(bm.verts) == 8 and len(bm.faces) == 5" + END
    )
    with_car(
        NEW + two + "bmesh.ops.delete(bm, geom=[bm.faces[0]], context='FACES_ONLY')\n"
        "assert len(bm.verts) == 12 and len(bm.faces) == 6" + END
    )


@pytest.mark.parametrize(
    ("script", "said"),
    [
        ("bmesh.ops.subdivide_edges(bm, edges=bm.edges, cuts=2)", "bmesh.ops.subdivide_edges is not supported"),
        ("bmesh.ops.create_icosphere(bm, subdivisions=9)", "subdivisions is 9; it must be 1 to 8"),
        ("bmesh.ops.create_circle(bm, segments=8)", "a circle without cap_ends=True has no face"),
        ("bmesh.ops.create_cube(1)", "1 is no BMesh"),
        ("bmesh.ops.translate(bm, vec=(1, 0, 0), verts=[1])", "vertices are moved that are none"),
        ("bmesh.ops.delete(bm, geom=[], context='EDGES')", "delete in the context 'EDGES' is not supported"),
    ],
)
def test_what_they_refuse(script: str, said: str) -> None:
    refuses(NEW + script, said)
