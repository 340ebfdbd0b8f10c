import pytest
from scene_reading import refuses, with_car

from lidardraft.scene.layout import primitive_mesh

NEW = "import bmesh\nbm = bmesh.new()\n"


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


@pytest.mark.parametrize(
    ("script", "said"),
    [
        (
            "other = bmesh.new()\nv = [other.verts.new((k, k * k, 0)) for k in range(3)]\nbm.faces.new(v)\n"
            "bm.to_mesh(car.data)",
            "line 11: a face of a BMesh has a vertex that has been removed, or is one of another BMesh",
        ),
        ("bm.edges[0]", "`edges` of a BMesh has no 0"),
        ("bm.faces.new([bm.verts.new((0, 0, 0))] * 3)", "a face of 1 vertices; it needs 3 or more, each once"),
        ("bm.faces.new([1, 2, 3])", "a face of what is no vertex"),
        ("bm.verts[0]", "`verts` of a BMesh has no 0"),
        ("bm.verts.new((0, 0))", "a vertex is a tuple; it must be 3 numbers"),
        ("bm.verts.new((0, 0, 0)).co = 1", "the place of a vertex is 1"),
        ("bm.to_mesh(car)", "an object is no mesh"),
        ("bm.transform(1)", "vertices are moved by 1; it must be a Matrix"),
    ],
)
def test_what_it_refuses(script: str, said: str) -> None:
    refuses(NEW + script, said)
