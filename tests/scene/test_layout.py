"""Shapes, the boxes around them, their meshes, and the layouts and JSON that hold them."""

import dataclasses
import json
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lidardraft.errors import FormatError, LayoutError, LidarDraftError
from lidardraft.json_fields import check_brackets
from lidardraft.scene.box import Box, check_id
from lidardraft.scene.layout import MOST_PRIMITIVES, SCHEMA, Layout, Primitive, box_around, primitive_mesh
from lidardraft.scene.mesh import TriangleMesh, unit_mesh
from lidardraft.scene.placed_mesh import placed_mesh, shape_of, size_and_yaw
from lidardraft.semantics import CLASSES

CAR = Primitive(shape="box", center=(10, 2, 0.75), size=(4.2, 1.8, 1.5), label="car", id="car_1", instance=1)
numbers = st.floats(-1e3, 1e3)
extents = st.floats(0.01, 1e3)
primitives = st.builds(
    Primitive,
    shape=st.sampled_from(["box", "ellipsoid", "cylinder"]),
    center=st.tuples(numbers, numbers, numbers),
    size=st.tuples(extents, extents, extents),
    label=st.sampled_from([row.name for row in CLASSES[1:]]),
    id=st.text(st.characters(categories=("L", "N", "P", "S")), min_size=1, max_size=8),
    yaw=numbers,
    instance=st.integers(0, 65535),
    material=st.none() | st.just("glass"),
    open=st.booleans(),
)


@settings(max_examples=30, deadline=None)
@given(st.lists(primitives, max_size=5, unique_by=lambda p: p.id), st.none() | st.just((-0.5, 1.5)))
def test_json_gives_the_layout_back(parts, coverage):
    layout = Layout(primitives=tuple(parts), provenance={"seed": 3, "sentence": "a car"}, coverage=coverage)
    assert Layout.from_json(layout.to_json()) == layout


def test_json_gives_meshes_and_planes_back(tmp_path):
    mesh = Primitive.from_mesh(
        np.array([[1.0, 2, 3], [5, 2, 3], [1, 4, 3.5]]), np.array([[0, 1, 2]]), label="road", id="m"
    )
    plane = Primitive(shape="plane", center=(0, 0, 0), size=(9, 9, 0), label="terrain", id="p")
    layout = Layout(primitives=(mesh, plane, CAR))
    layout.save(tmp_path / "layout.json")
    assert Layout.load(tmp_path / "layout.json") == layout
    assert [path.name for path in tmp_path.iterdir()] == ["layout.json"]


def test_the_json_names_the_class_and_has_one_primitive_a_line():
    text = Layout(primitives=(CAR,)).to_json()
    document = json.loads(text)
    assert document["schema"] == SCHEMA
    assert document["primitives"][0] == {
        "shape": "box",
        "center": [10, 2, 0.75],
        "size": [4.2, 1.8, 1.5],
        "yaw": 0.0,
        "label": "car",
        "id": "car_1",
        "instance": 1,
    }
    assert len(text.splitlines()) == 3


def test_a_layout_is_a_sequence_with_names():
    layout = Layout(primitives=(CAR,))
    assert (len(layout), list(layout), layout["car_1"]) == (1, [CAR], CAR)
    assert ("car_1" in layout, CAR in layout, "car_9" in layout, "car" in layout) == (True, True, False, False)
    message = "no primitive has the id 'car_9'; did you mean 'car_1'?"
    for family in (KeyError, LayoutError, LidarDraftError):
        with pytest.raises(family) as caught:
            layout["car_9"]
        assert str(caught.value) == message
    with pytest.raises(LayoutError, match=r"no primitive has the id 'zebra'; it has car_1$"):
        layout["zebra"]
    with pytest.raises(LayoutError, match=r"no primitive has the id 3; it has none$"):
        Layout()[3]  # type: ignore[index]
    tree = Layout(primitives=tuple(dataclasses.replace(CAR, id=f"tree_3.{part}") for part in ("trunk", "crown")))
    with pytest.raises(LayoutError, match=r"no primitive has the id 'tree_3'; it has tree_3\.trunk, tree_3\.crown$"):
        tree["tree_3"]


@pytest.mark.parametrize("unused", [0, 1, 3])
def test_from_mesh_bounds_the_vertices_of_its_faces(unused: int) -> None:
    vertices = np.insert([[1.0, 2, 3], [5, 2, 3], [1, 4, 3]], unused, 99.0, axis=0)
    faces = [[row for row in range(4) if row != unused]]
    mesh = Primitive.from_mesh(vertices, np.array(faces), label="road", id="m")
    assert mesh.center == (3, 3, 3)
    assert mesh.size == (4, 2, 0)
    assert np.abs(mesh.mesh.vertices).max() <= 0.5


def test_a_box_holds_all_parts_of_a_thing_and_has_the_yaw_of_the_largest():
    body = dataclasses.replace(CAR, center=(0, 0, 0.5), size=(4, 2, 1), yaw=0.5)
    roof = dataclasses.replace(CAR, id="roof", center=(0, 0, 1.2), size=(2, 2, 0.4), yaw=0.5)
    tree = Primitive(shape="ellipsoid", center=(9, 9, 2), size=(2, 2, 2), label="vegetation", id="tree")
    (box,) = Layout(primitives=(tree, roof, body)).boxes()
    np.testing.assert_allclose(box.center, (0, 0, 0.7), atol=1e-12)
    np.testing.assert_allclose(box.size, (4, 2, 1.4))
    assert (box.label, box.instance, box.yaw) == ("car", 1, 0.5)


def test_boxes_come_in_the_order_of_instances():
    cars = [dataclasses.replace(CAR, id=f"c{k}", instance=k) for k in (5, 2, 9)]
    assert [box.instance for box in Layout(primitives=tuple(cars)).boxes()] == [2, 5, 9]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"shape": "plane"}, r"car_1: size is .*; a plane needs x and y >= 1e-06 m, and z = 0"),
        ({"shape": "cone"}, r"car_1: shape is 'cone'; it must be one of box, ellipsoid, cylinder, plane, mesh"),
        ({"shape": "mesh"}, r"car_1: shape is 'mesh'; shape 'mesh', and no other, comes with a mesh"),
        ({"label": "none"}, r"car_1: label is 'none'; it must be one of road"),
        ({"instance": 65536}, r"car_1: instance is 65536; it must be 0 to 65535"),
        ({"instance": -1}, r"car_1: instance is -1; it must be 0 to 65535"),
        ({"material": "cheese"}, r"car_1: material is 'cheese'; it must be one of asphalt, "),
        ({"open": 1}, r"car_1: open is 1; it must be true or false"),
    ],
)
def test_a_primitive_that_cannot_be(change, message):
    with pytest.raises(LayoutError, match=message):
        dataclasses.replace(CAR, **change)


TRIANGLE = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])


@pytest.mark.parametrize(
    ("vertices", "faces", "message"),
    [
        (TRIANGLE[:, :2], [[0, 1, 2]], r"vertices \[V, 3\] and at least one face \[F, 3\]; got \(3, 2\)"),
        ([[0, 0, 0], [np.nan, 0, 0], [1, 0, 0]], [[0, 1, 2]], r"vertex 1 of a mesh is \[nan, 0.0, 0.0\]; every"),
        (TRIANGLE + np.array([0, 0, np.inf]), [[0, 1, 2]], r"vertex 0 of a mesh is \[0.0, 0.0, inf\]; every"),
        (TRIANGLE, [[0, 1, 2], [0, 1, 3]], r"face 1 is \[0, 1, 3\]; the mesh has 3 vertices"),
        (TRIANGLE, [[0, 1, -1]], r"face 0 is \[0, 1, -1\]; the mesh has 3 vertices"),
        (TRIANGLE, np.zeros((0, 3)), r"at least one face \[F, 3\]; got \(3, 3\) and \(0, 3\)"),
        (1e300 * TRIANGLE, [[0, 1, 2]], r"m: the mesh reaches 1e.300 m from the origin; the limit is 1e.09 m"),
    ],
)
def test_a_mesh_that_cannot_be(vertices, faces, message):
    with pytest.raises(LayoutError, match=message):
        Primitive.from_mesh(np.array(vertices), np.array(faces), label="road", id="m")


@pytest.mark.parametrize("shape", ["box", "ellipsoid", "cylinder", "plane"])
def test_shapes_without_extent_or_without_end_are_refused(shape: str) -> None:
    """Rays missed some shapes of less than a millionth of a metre and met others in the wrong places."""
    said = r"car_1: size is .*; (every extent must|a plane needs|no number may|it must)"
    for extent in (-2.0, 0.0, 5e-324, 1e-160, 1e-30, 1e-7, 1.1e9, math.nan, math.inf):
        for axes in ((0,), (1,), (0, 1, 2)):
            size = [extent if axis in axes else 2.0 for axis in range(3)]
            with pytest.raises(LayoutError, match=said):
                dataclasses.replace(CAR, shape=shape, size=(*size[:2], 0.0) if shape == "plane" else size)


@pytest.mark.parametrize(
    "vertices",
    [
        np.zeros((3, 3)),
        [[0, 0, 0], [1, 0, 0], [2, 0, 0]],
        [[0, 0, 0], [1, 1, 1], [2, 2, 2]],
        np.array([[0, 0, 0], [1, 2, 3], [3, 6, 9]]) / 7 + 1234.5,
        1e-30 * TRIANGLE,
        TRIANGLE * (1, 1e-30, 1),
        1e-7 * TRIANGLE,
    ],
    ids=["points", "line", "diagonal", "far line", "crumb", "needle", "grain"],
)
def test_meshes_without_a_surface_are_refused(vertices: list[list[float]]) -> None:
    for faces in ([[0, 1, 2]], [[0, 0, 1], [1, 1, 2]] * 9):
        with pytest.raises(LayoutError, match=r"m: size is .*; all its triangles are points or lines"):
            Primitive.from_mesh(np.array(vertices), np.array(faces), label="road", id="m")
        assert placed_mesh(np.eye(4), np.array(vertices, float), np.array(faces), **FIELDS) is None


def test_a_surface_among_lines_is_seen() -> None:
    lines = [[0, 0, 1]] * 20
    mesh = Primitive.from_mesh(TRIANGLE * (1, 1e-3, 1) + 500.0, np.array([*lines, [0, 1, 2]]), label="road", id="m")
    assert mesh.size == pytest.approx((1, 1e-3, 0))


def test_ids_must_be_distinct():
    with pytest.raises(LayoutError, match=r"car_1: two primitives have this id; ids must be distinct"):
        Layout(primitives=(CAR, CAR))


def test_as_many_primitives_as_a_layout_may_have_are_not_too_much_to_read():
    row = json.dumps(dataclasses.replace(CAR, material="glass", extinction=0.5, open=True).to_dict())
    check_brackets("[" + ",".join([row] * MOST_PRIMITIVES) + "]")
    with pytest.raises(LayoutError, match="100001 primitives; a layout has 100000 at most"):
        Layout([CAR] * 100_001)


@pytest.mark.parametrize(
    ("provenance", "message"),
    [
        ({"sentence": "a" * 2**26}, r"layout.json: 671089\d\d bytes of JSON; up to 67108864 are read"),
        ({"parts": [[]] * 3_000_000}, r"layout.json: 30000\d\d lists and objects; JSON of up to 3000000 is read"),
    ],
)
def test_what_could_not_be_read_is_not_saved(provenance, message, tmp_path):
    Layout([CAR]).save(tmp_path / "layout.json")
    with pytest.raises(FormatError, match=message):
        Layout(provenance=provenance).save(tmp_path / "layout.json")
    assert Layout.load(tmp_path / "layout.json") == Layout([CAR])


@pytest.mark.parametrize("coverage", [(0.0,), (0.0, math.nan), "ab", (0.0, "1"), 3.0])
def test_a_coverage_is_two_finite_numbers(coverage):
    with pytest.raises(LayoutError, match=r"layout: coverage is .*; it must be 2 finite numbers"):
        Layout(coverage=coverage)


def test_a_coverage_is_a_pair_of_floats():
    assert Layout(coverage=np.array([-1, 2])).coverage == (-1.0, 2.0)
    assert [type(edge) for edge in Layout(coverage=[-1, 2]).coverage] == [float, float]


def document(**changes):
    return json.dumps({"schema": SCHEMA, "provenance": {}, "coverage": None, "primitives": [CAR.to_dict()], **changes})


def row(**changes):
    return [{**CAR.to_dict(), **changes}]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{}", r"schema is None; this version reads 'lidardraft.layout/2'"),
        (document(schema="lidardraft.layout/9"), r"schema is 'lidardraft.layout/9'; this version reads"),
        (document(primitives={}), r"primitives is {}; it must be a list of objects"),
        (document(primitives=[{"id": "a"}]), r"a: 'center' is missing"),
        (document(primitives=row(colour="red")), r"car_1: unknown field 'colour'"),
        (document(primitives=row(shape="mesh", vertices=[[0, 0]], faces=[[0, 1, 2]])), r"car_1: a mesh needs vertices"),
        (document(primitives=row(shape="mesh", vertices="x", faces=[[0, 1, 2]])), r"car_1: "),
        (document(primitives=row(center=[1e308, 0, 0])), r"car_1: center is \[1e\+308, 0, 0\]; no number may be"),
        (document(primitives=row(size=[1, 10**400, 1])), r"car_1: size is .*; it must be 3 finite numbers"),
        (
            document(primitives=row(shape="mesh", vertices=[[0, 0, 10**400]], faces=[[0, 1, 2]])),
            r"car_1: a mesh needs vertices",
        ),
    ],
)
def test_text_that_is_no_layout(tmp_path, text, message):
    with pytest.raises(LidarDraftError, match=message):
        Layout.from_json(text)
    (tmp_path / "a.json").write_text(text)
    with pytest.raises(LidarDraftError, match=r"a.json: " + message):
        Layout.load(tmp_path / "a.json")


def test_a_box_around_a_turned_part_bounds_it():
    long = Primitive(shape="box", center=(0, 0, 0.5), size=(4, 2, 1), label="car", id="a", instance=1)
    turned = Primitive(
        shape="box", center=(0, 0, 0.5), size=(3, 0.2, 1), label="car", id="b", instance=1, yaw=math.pi / 2
    )
    box = box_around([turned, long])
    np.testing.assert_allclose(box.size, (4, 3, 1))
    assert (box.id, box.yaw) == ("a", 0.0)


BOX = Box("car_1", "car", 1, (1, 2, 3), (4, 2, 1), 0.0)


@pytest.mark.parametrize("one", [CAR, BOX], ids=["primitive", "box"])
@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"center": (0, 0, math.nan)}, r"car_1: center is \(0, 0, nan\); it must be 3 finite numbers"),
        ({"center": (0, math.inf, 0)}, r"car_1: center is \(0, inf, 0\); it must be 3 finite numbers"),
        ({"center": (0, 0)}, r"car_1: center is \(0, 0\); it must be 3 finite numbers"),
        ({"center": "abc"}, r"car_1: center is 'abc'; it must be 3 finite numbers"),
        ({"label": "cow"}, r"car_1: label is 'cow'; it must be one of"),
        ({"label": ["car"]}, r"car_1: label is \['car'\]; it must be one of"),
        ({"yaw": math.nan}, r"car_1: yaw is nan; it must be a finite number of radians"),
        ({"yaw": "north"}, r"car_1: yaw is 'north'; it must be a finite number of radians"),
        ({"size": (4.2, -1.0, 1.5)}, r"car_1: size is \[4.2, -1.0, 1.5\]; (no|every) extent m"),
        ({"instance": 0.5}, r"car_1: instance is 0.5; it must be "),
        ({"id": ""}, r"id is ''; it must be a non-empty string"),
    ],
)
def test_primitives_and_boxes_have_numbers_and_a_class(one, change, message):
    with pytest.raises(LayoutError, match=message):
        dataclasses.replace(one, **change)


@pytest.mark.parametrize("id", ["", None, 3, "\ud800", "car\x1b[2J", "car\n", "a\x9b31m", "a\u202eb", "a\u2028b"])
def test_a_name_has_printable_characters(id):
    with pytest.raises(LayoutError, match="it must be a non-empty string of printable characters"):
        check_id(id)


VOLUMES = {"box": 1.0, "cylinder": math.pi / 4, "ellipsoid": math.pi / 6}


def volume(mesh: TriangleMesh) -> float:
    """By the divergence theorem: positive if the mesh is closed and faces outwards."""
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    return float(np.einsum("fi,fi->f", a, np.cross(b, c)).sum() / 6)


@pytest.mark.parametrize("shape", sorted(VOLUMES))
@settings(max_examples=15, deadline=None)
@given(
    size=st.tuples(*[st.floats(0.2, 20)] * 3),
    center=st.tuples(*[st.floats(-50, 50)] * 3),
    yaw=st.floats(-4, 4),
)
def test_solids(shape: str, size: tuple[float, ...], center: tuple[float, ...], yaw: float) -> None:
    primitive = Primitive(shape=shape, center=center, size=size, label="other", id="a", yaw=yaw)  # type: ignore[arg-type]
    mesh = primitive_mesh(primitive)
    unit = VOLUMES[shape] * math.prod(size)
    moved = TriangleMesh(mesh.vertices - center, mesh.faces)
    assert unit * 0.96 <= volume(moved) <= unit * (1 + 1e-9)
    assert mesh.is_closed()
    assert mesh.vertices[:, 2].min() == pytest.approx(center[2] - size[2] / 2)
    assert mesh.vertices[:, 2].max() == pytest.approx(center[2] + size[2] / 2)


def test_yaw_turns_counter_clockwise() -> None:
    box = Primitive(shape="box", center=(5, 0, 0), size=(4, 1, 1), label="car", id="a", yaw=math.pi / 2)
    vertices = primitive_mesh(box).vertices
    assert np.ptp(vertices, axis=0) == pytest.approx([1, 4, 1])
    mark = Primitive.from_mesh(
        np.array([[0, 0, 0], [2, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]]), label="other", id="b", yaw=math.pi / 2
    )
    # About the middle of its bounds (1, 0.5): (2, 0) goes to (1.5, 1.5).
    assert primitive_mesh(mark).vertices[1] == pytest.approx([1.5, 1.5, 0])


def test_plane_is_its_rectangle() -> None:
    plane = Primitive(shape="plane", center=(1, 2, 3), size=(4, 6, 0), label="road", id="a")
    mesh = primitive_mesh(plane)
    assert mesh.vertices.min(axis=0).tolist() == [-1, -1, 3]
    assert mesh.vertices.max(axis=0).tolist() == [3, 5, 3]
    normal = np.cross(mesh.vertices[1] - mesh.vertices[0], mesh.vertices[2] - mesh.vertices[0])
    assert normal[2] > 0


def test_meshes_are_compared_by_value_and_read_only() -> None:
    mesh = TriangleMesh(np.eye(3), np.array([[0, 1, 2]]))
    assert mesh == TriangleMesh(np.eye(3), np.array([[0, 1, 2]]))
    assert mesh != TriangleMesh(2 * np.eye(3), np.array([[0, 1, 2]]))
    with pytest.raises(ValueError, match="read-only"):
        mesh.vertices[0, 0] = 5


FIELDS = {"label": "car", "id": "car_1", "instance": 1}


def turned(angles: tuple[float, float, float], size: tuple[float, float, float]) -> np.ndarray:
    x, y, z = angles
    about_x = np.array([[1, 0, 0], [0, math.cos(x), -math.sin(x)], [0, math.sin(x), math.cos(x)]])
    about_y = np.array([[math.cos(y), 0, math.sin(y)], [0, 1, 0], [-math.sin(y), 0, math.cos(y)]])
    about_z = np.array([[math.cos(z), -math.sin(z), 0], [math.sin(z), math.cos(z), 0], [0, 0, 1]])
    matrix = np.eye(4)
    matrix[:3, :3] = about_z @ about_y @ about_x * size
    matrix[:3, 3] = (5, -3, 2)
    return matrix


@pytest.mark.parametrize("shape", ["box", "ellipsoid", "cylinder", "plane"])
@pytest.mark.parametrize("yaw", [0.0, 0.7, -2.5, math.pi / 2])
@pytest.mark.parametrize("offset", [0.0, 40.0])
def test_a_mesh_of_a_shape_is_that_shape(shape: str, yaw: float, offset: float) -> None:
    """Also after float32, of vertices that are far from the mesh's own origin."""
    mesh = unit_mesh(shape)
    vertices = (mesh.vertices * (4, 2, 1.5) + offset).astype(np.float32).astype(np.float64)
    found = placed_mesh(turned((0, 0, yaw), (1, 1, 1)), vertices, mesh.faces, **FIELDS)
    assert found is not None
    assert found.shape == shape
    np.testing.assert_allclose(found.size, (4, 2, 0 if shape == "plane" else 1.5), atol=1e-4)
    assert math.remainder(found.yaw - yaw, math.tau) == pytest.approx(0, abs=1e-5)


@pytest.mark.parametrize("shape", ["box", "ellipsoid", "cylinder", "plane"])
def test_any_place_keeps_the_bounds(shape: str) -> None:
    mesh = unit_mesh(shape)
    random = np.random.default_rng(1)
    for k in range(20):
        angles = random.uniform(-3, 3, 3) * ((1, 1, 1) if k % 2 else (0, 0, 1))
        matrix = turned(tuple(angles), tuple(random.uniform(0.5, 4, 3)))
        found = placed_mesh(matrix, mesh.vertices, mesh.faces, **FIELDS)
        assert found is not None
        expected = mesh.vertices @ matrix[:3, :3].T + matrix[:3, 3]
        off = 0.15 if found.shape == "ellipsoid" else 1e-6  # a turned ellipsoid has its vertices elsewhere
        np.testing.assert_allclose(primitive_mesh(found).vertices.min(axis=0), expected.min(axis=0), atol=off)
        np.testing.assert_allclose(primitive_mesh(found).vertices.max(axis=0), expected.max(axis=0), atol=off)


def test_what_only_resembles_a_shape_is_a_mesh() -> None:
    box = unit_mesh("box")
    assert shape_of(box.vertices, box.faces) == "box"
    assert shape_of(box.vertices, box.faces[2:]) == "mesh"  # open on one side
    dented = box.vertices.copy()
    dented[0] *= 0.9
    assert shape_of(dented, box.faces) == "mesh"
    plane = unit_mesh("plane")
    assert shape_of(plane.vertices, plane.faces[:1]) == "mesh"
    ball = unit_mesh("ellipsoid")
    assert shape_of(ball.vertices, ball.faces[: len(ball.faces) // 2]) == "mesh"


def test_a_mesh_keeps_its_yaw_and_a_tight_box() -> None:
    roof = np.array([(0, 0, 0), (4, 0, 0), (4, 2, 0), (0, 2, 0), (2, 1, 3)], dtype=float)
    faces = np.array([(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4), (0, 2, 1), (0, 3, 2)])
    found = placed_mesh(turned((0, 0, 0.5), (1, 1, 1)), roof, faces, **FIELDS)
    assert isinstance(found, Primitive)
    assert (found.shape, found.size, found.yaw) == ("mesh", pytest.approx((4, 2, 3)), pytest.approx(0.5))
    leaning = placed_mesh(turned((0.5, 0, 0.5), (1, 1, 1)), roof, faces, **FIELDS)
    assert leaning is not None
    assert leaning.yaw == 0


def test_what_has_no_surface_is_none() -> None:
    box = unit_mesh("box")
    assert placed_mesh(turned((0, 0, 0), (1, 0, 0)), box.vertices, box.faces, **FIELDS) is None
    slab = placed_mesh(turned((0, 0, 0), (2, 1, 0)), box.vertices, box.faces, **FIELDS)
    assert slab is not None
    assert slab.shape == "plane"


def test_sheared_and_leaning_maps() -> None:
    assert size_and_yaw(np.diag([1.0, 2.0, 3.0]), "box") == ([1, 2, 3], 0)
    assert size_and_yaw(np.array([[1.0, 0.5, 0], [0, 1, 0], [0, 0, 1]]), "box") is None
    assert size_and_yaw(np.array([[1.0, 0, 0.1], [0, 1, 0], [0, 0, 1]]), "cylinder") is None
    size_yaw = size_and_yaw(np.array([[2.0, 0.5, 0], [0, 1, 0], [0, 0, 1]]), "cylinder")
    assert size_yaw is not None
    assert size_yaw[0][0] * size_yaw[0][1] == pytest.approx(2)  # a sheared circle is an ellipse of the same area


@pytest.mark.parametrize("number", [np.inf, np.nan, 1e10])
def test_transforms_that_are_no_transforms(number: float) -> None:
    box = unit_mesh("box")
    matrix = np.eye(4)
    matrix[0, 0] = number
    with pytest.raises(LayoutError, match=r"car_1: a transform or an extent is larger than 1e.09, or no number"):
        placed_mesh(matrix, box.vertices, box.faces, **FIELDS)


def test_a_mesh_away_from_its_origin_is_placed_by_its_middle():
    box = unit_mesh("box")
    found = placed_mesh(np.eye(4), np.add(box.vertices, (2.0, 4.0, 6.0)), box.faces, **FIELDS)
    assert found is not None
    assert found.center == pytest.approx((2.0, 4.0, 6.0))
