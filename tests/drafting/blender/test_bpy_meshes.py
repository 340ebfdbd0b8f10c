"""Meshes: the shapes of operators, vertices that are moved, and bmesh."""

import math

import numpy as np
import pytest
from scene_reading import refuses, scene, with_car

from lidardraft.drafting.blender.bpy import meshes as shapes
from lidardraft.drafting.blender.bpy.meshes import MeshShape
from lidardraft.scene.layout import primitive_mesh
from lidardraft.scene.mesh import TriangleMesh

CLOSED = {
    "cube": (shapes.cube(2.0), 8.0),
    "cylinder": (shapes.cone(1.0, 1.0, 2.0, 64), 2 * math.pi),
    "cone": (shapes.cone(1.0, 0.0, 3.0, 64), math.pi),
    "sphere": (shapes.sphere(1.0, 64, 32), 4 / 3 * math.pi),
    "icosphere": (shapes.icosphere(1.0, 4), 4 / 3 * math.pi),
    "torus": (shapes.torus(2.0, 0.5, 96, 48), 2 * math.pi**2 * 2 * 0.25),
}
TENT = "mesh = bpy.data.meshes.new('Tent')\nmesh.from_pydata(%s, [], %s)\nmesh.update()\nmesh.validate()\n"
LINKED = "tent = bpy.data.objects.new('House', mesh)\nbpy.context.collection.objects.link(tent)\n"
CORNERS = "[(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (1, 1, 3)]"
NEW = "import bmesh\nbm = bmesh.new()\n"
END = "\nbm.to_mesh(car.data)"
REFUSED: list[tuple[str, str]] = [
    (TENT % ("[(0, 0)]", "[]"), "a vertex is a tuple; it must be 3 numbers"),
    (TENT % (CORNERS, "[(0, 1, 7)]"), r"face 0 is \(0, 1, 7\); the mesh has 5 vertices"),
    (TENT % (CORNERS, "[(0, 1, 0.5)]"), "face 0 is"),
    (TENT % ("5", "[]"), "5 cannot be looped over"),
    (
        NEW + "other = bmesh.new()\nv = [other.verts.new((k, k * k, 0)) for k in range(3)]\nbm.faces.new(v)\n"
        "bm.to_mesh(car.data)",
        "line 11: a face of a BMesh has a vertex that has been removed, or is one of another BMesh",
    ),
    (NEW + "bm.edges[0]", "`edges` of a BMesh of 0 has no place 0"),
    (NEW + "bm.faces.new([bm.verts.new((0, 0, 0))] * 3)", "a face of 1 vertices; it needs 3 or more, each once"),
    (NEW + "bm.faces.new([1, 2, 3])", "a corner of a face is 1; it must be a vertex"),
    ("import bmesh\nbmesh.from_edit_mesh(car.data)", "from_edit_mesh outside of the edit mode"),
    ("import bmesh\nbmesh.update_edit_mesh(1)", "the mesh is 1; it must be a mesh"),
    ("import bmesh\nbmesh.utils", "bmesh.utils is not supported"),
    (NEW + "bmesh.ops.subdivide_edges(bm, edges=bm.edges, cuts=2)", "bmesh.ops.subdivide_edges is not supported"),
    (NEW + "bmesh.ops.create_icosphere(bm, subdivisions=9)", "subdivisions is 9; it must be 1 to 8"),
    (NEW + "bmesh.ops.create_circle(bm, segments=8)", "a circle without cap_ends=True has no face"),
    (NEW + "bmesh.ops.create_cube(1)", "bm is 1; it must be a BMesh"),
]


@pytest.mark.parametrize(("script", "said"), REFUSED)
def test_it_is_refused(script: str, said: str) -> None:
    refuses(script, said)


@pytest.mark.parametrize("name", CLOSED)
def test_closed_shapes_have_their_volume_and_look_outwards(name: str) -> None:
    shape, expected = CLOSED[name]
    vertices, faces = shape.triangles()
    assert len(vertices) == shape.vertices
    assert TriangleMesh(vertices, faces).is_closed()
    a, b, c = vertices[faces].transpose(1, 0, 2)
    assert np.einsum("fi,fi->", a, np.cross(b, c)) / 6 == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize(
    ("shape", "vertices", "polygons"),
    [
        (shapes.cube(1.0), 8, 6),
        (shapes.grid(1.0, 3, 2), 12, 6),
        (shapes.cone(1.0, 1.0, 2.0, 32), 64, 34),
        (shapes.cone(1.0, 0.0, 2.0, 32), 33, 33),
        (shapes.cone(0.0, 1.0, 2.0, 32, capped=False), 33, 32),
        (shapes.sphere(1.0, 32, 16), 482, 512),
        (shapes.icosphere(1.0, 2), 42, 80),
        (shapes.torus(1.0, 0.25, 48, 12), 576, 576),
    ],
)
def test_vertices_and_polygons_are_as_many_as_in_blender(shape: MeshShape, vertices: int, polygons: int) -> None:
    places, faces = shape.make()
    assert (len(places), sum(map(len, faces)), shape.vertices) == (vertices, polygons, vertices)


def test_round_shapes_of_few_corners_are_meshes() -> None:
    assert shapes.cone(1.0, 1.0, 2.0, 32).shape == "cylinder"
    assert shapes.cone(1.0, 1.0, 2.0, 6).shape == "mesh"
    assert shapes.cone(1.0, 1.0, 2.0, 32, capped=False).shape == "mesh"
    assert shapes.sphere(1.0, 32, 16).shape == "ellipsoid"
    assert shapes.sphere(1.0, 4, 3).shape == "mesh"
    assert shapes.icosphere(1.0, 1).shape == "mesh"


def test_lists_of_vertices_and_polygons() -> None:
    script = TENT % (CORNERS, "[(0, 1, 2, 3), (0, 1, 4), (1, 2, 4)]") + LINKED
    (tent,) = scene(script + "tent.location = (10, 0, 0)")
    assert (tent.shape, tent.center, tent.size) == ("mesh", (11, 1, 1.5), (2, 2, 3))
    assert tent.mesh is not None
    assert len(tent.mesh.faces) == 4


def test_a_mesh_is_copied_and_moved() -> None:
    script = TENT % (CORNERS, "[(0, 1, 4)]") + LINKED
    script += "other = mesh.copy()\nother.transform(Matrix.Translation((0, 0, 5)))\ntent.data = other\n"
    assert scene(script).primitives[0].center[2] == pytest.approx(6.5)


def test_materials_of_a_mesh() -> None:
    car = with_car(
        "car.name = 'Cube'\nred = bpy.data.materials.new('mat_truck')\nred.diffuse_color = (1, 0, 0, 1)\n"
        "car.data.materials.append(None)\ncar.data.materials[0] = red\n"
        "assert len(car.data.materials) == 1 and car.active_material is red\n"
        "car.active_material = red\ncar.data.materials.clear()\ncar.active_material = red"
    )
    assert car.label == "truck"


def test_vertices_and_faces_become_a_mesh() -> None:
    wedge = with_car(
        NEW + "v = [bm.verts.new(p) for p in [(0, 0, 0), (2, 0, 0), (0, 3, 0), (0, 0, 1)]]\n"
        "bm.verts.ensure_lookup_table()\n"
        "for f in [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]:\n    bm.faces.new([bm.verts[k] for k in f])\n"
        "assert len(bm.faces) == 4 and bm.faces[0].normal.z == -1\n"
        "bm.to_mesh(car.data)\nbm.free()"
    )
    assert (wedge.shape, wedge.size) == ("mesh", (2, 3, 1))
    assert primitive_mesh(wedge).faces.shape == (4, 3)


def test_a_mesh_that_is_taken_moved_and_given_back_is_the_box_that_it_was() -> None:
    box = with_car(NEW + "bm.from_mesh(car.data)\nbm.transform(Matrix.Translation((0, 0, 2)))\nbm.to_mesh(car.data)")
    assert (box.shape, box.center, box.size) == ("box", (5, 0, 2.5), (1, 1, 1))


def test_what_is_removed_is_gone() -> None:
    box = with_car(
        NEW + "bm.from_mesh(car.data)\nassert len(bm.faces) == 6\nbm.faces.remove(bm.faces[0])\nbm.to_mesh(car.data)"
    )
    assert primitive_mesh(box).faces.shape == (10, 3)


def test_edges_are_those_of_the_faces() -> None:
    with_car(
        NEW + "bm.from_mesh(car.data)\nassert len(bm.edges) == 12\nupright = 0\nfor e in bm.edges:\n"
        "    a, b = e.verts\n    assert e.calc_length() == 1 and isinstance(e, bmesh.types.BMEdge)\n"
        "    upright += a.co.z != b.co.z\nassert upright == 4\nbm.edges.ensure_lookup_table()\n"
        "assert bm.edges[0].verts[0] in bm.verts[:] and len(bm.edges[:3]) == 3"
    )


def test_a_mesh_is_edited_in_edit_mode() -> None:
    edited = (
        "import bmesh\nbpy.ops.object.mode_set(mode='EDIT')\nbm = bmesh.from_edit_mesh(car.data)\n"
        "for v in bm.verts:\n    v.co.x *= 4\n    v.co.z = (v.co.z + 0.5) * 2\n"
    )
    for end in ("bmesh.update_edit_mesh(car.data)\nbpy.ops.object.mode_set(mode='OBJECT')", ""):
        car = with_car(edited + end)
        assert (car.shape, car.size, car.center) == ("box", (4, 1, 2), (5, 0, 1.5))


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
