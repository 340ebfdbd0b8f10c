import dataclasses
import json
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lidardraft.errors import FormatError, LayoutError, LidarDraftError
from lidardraft.scene.layout import SCHEMA, Layout, Primitive
from lidardraft.semantics import BY_NAME, CLASSES

CAR = Primitive(shape="box", center=(10, 2, 0.75), size=(4.2, 1.8, 1.5), label="car", id="car_1", instance=1)
numbers = st.floats(-1e3, 1e3)
extents = st.floats(0.01, 1e3)
primitives = st.builds(
    Primitive,
    shape=st.sampled_from(["box", "ellipsoid", "cylinder"]),
    center=st.tuples(numbers, numbers, numbers),
    size=st.tuples(extents, extents, extents),
    label=st.sampled_from([row.name for row in CLASSES[1:]]),
    id=st.text(min_size=1, max_size=8).filter(str.isprintable),
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


def test_the_json_says_of_open_shapes_alone_that_they_are():
    text = Layout(primitives=(dataclasses.replace(CAR, open=True),)).to_json()
    assert json.loads(text)["primitives"][0] == {**CAR.to_dict(), "open": True}
    assert "open" not in CAR.to_dict()


def test_the_class_table_is_its_own_index():
    assert [row.id for row in CLASSES] == list(range(len(CLASSES)))
    assert len(BY_NAME) == len(CLASSES)
    assert all(row.size is not None for row in CLASSES if row.is_thing)


def test_a_layout_is_a_sequence_with_names():
    layout = Layout(primitives=(CAR,))
    assert (len(layout), list(layout), layout["car_1"]) == (1, [CAR], CAR)
    with pytest.raises(KeyError, match="car_2"):
        layout["car_2"]


def test_from_mesh_bounds_its_vertices():
    mesh = Primitive.from_mesh(
        np.array([[1.0, 2, 3], [5, 2, 3], [1, 4, 3]]), np.array([[0, 1, 2]]), label="road", id="m"
    )
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
        ({"center": (0, 0, math.nan)}, r"car_1: center is \(0, 0, nan\); it must be 3 finite numbers"),
        ({"center": (0, math.inf, 0)}, r"car_1: center is \(0, inf, 0\); it must be 3 finite numbers"),
        ({"center": (0, 0)}, r"car_1: center is \(0, 0\); it must be 3 finite numbers"),
        ({"center": "abc"}, r"car_1: center is 'abc'; it must be 3 finite numbers"),
        ({"size": (1, 0, 1)}, r"car_1: size is \[1.0, 0.0, 1.0\]; every extent must be > 0"),
        ({"size": (1, -2, 1)}, r"car_1: size is \[1.0, -2.0, 1.0\]; every extent must be > 0"),
        ({"shape": "plane"}, r"car_1: size is .*; a plane needs x > 0, y > 0 and z = 0"),
        ({"shape": "cone"}, r"car_1: shape is 'cone'; it must be one of box, ellipsoid, cylinder, plane, mesh"),
        ({"shape": "mesh"}, r"car_1: shape is 'mesh'; shape 'mesh', and no other, comes with a mesh"),
        ({"label": "cow"}, r"car_1: label is 'cow'; it must be one of road, sidewalk, building"),
        ({"label": "none"}, r"car_1: label is 'none'; it must be one of road"),
        ({"yaw": math.nan}, r"car_1: yaw is nan; it must be a finite number of radians"),
        ({"yaw": "north"}, r"car_1: yaw is 'north'; it must be a finite number of radians"),
        ({"instance": 65536}, r"car_1: instance is 65536; it must be 0 to 65535"),
        ({"instance": -1}, r"car_1: instance is -1; it must be 0 to 65535"),
        ({"open": 1}, r"car_1: open is 1; it must be true or false"),
        ({"id": ""}, r"id is ''; it must be a non-empty string"),
        ({"id": "car_\ud800"}, r"id is 'car_.ud800'; it must be a non-empty string of printable"),
    ],
)
def test_a_primitive_that_cannot_be(change, message):
    with pytest.raises(LayoutError, match=message):
        dataclasses.replace(CAR, **change)


TRIANGLE = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])


@pytest.mark.parametrize(
    ("vertices", "faces", "message"),
    [
        (TRIANGLE * [1, np.nan, 1], [[0, 1, 2]], r"vertex 0 of a mesh is \[0.0, nan, 0.0\]; every coordinate"),
        (
            TRIANGLE + np.array([0, 0, np.inf]),
            [[0, 1, 2]],
            r"vertex 0 of a mesh is \[0.0, 0.0, inf\]; every coordinate",
        ),
        (TRIANGLE, [[0, 1, 3]], r"face 0 is \[0, 1, 3\]; the mesh has 3 vertices"),
        (TRIANGLE, [[0, 1, -1]], r"face 0 is \[0, 1, -1\]; the mesh has 3 vertices"),
        (TRIANGLE, np.zeros((0, 3)), r"at least one face \[F, 3\]; got \(3, 3\) and \(0, 3\)"),
        (np.zeros((3, 3)), [[0, 1, 2]], r"m: size is \[0.0, 0.0, 0.0\]; a mesh needs two extents > 0"),
    ],
)
def test_a_mesh_that_cannot_be(vertices, faces, message):
    with pytest.raises(LayoutError, match=message):
        Primitive.from_mesh(vertices, np.array(faces), label="road", id="m")


def test_ids_must_be_distinct():
    with pytest.raises(LayoutError, match=r"car_1: two primitives have this id; ids must be distinct"):
        Layout(primitives=(CAR, CAR))


def test_a_layout_that_is_built_can_be_read(tmp_path):
    many = Layout([dataclasses.replace(CAR, id=f"c{k}") for k in range(66_000)])
    many.save(tmp_path / "layout.json")
    assert len(Layout.load(tmp_path / "layout.json")) == 66_000
    with pytest.raises(LayoutError, match="100001 primitives; a layout has 100000 at most"):
        Layout([CAR] * 100_001)


@pytest.mark.parametrize(
    ("provenance", "message"),
    [
        ({"sentence": "a" * 2**26}, r"layout.json would have 671089\d\d bytes; such files of up to 67108864 are read"),
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
        ("{", r"not JSON: "),
        ("[]", r"\[\] is no JSON object"),
        ("{}", r"schema is None; this version reads 'lidardraft.layout/1'"),
        ("[" * 100_000, r"not JSON that can be read: it is nested too deeply"),
        ('{"schema": 1' + "0" * 1_000_000 + "}", r"not JSON: "),
        (document(sky="blue"), r"unknown field 'sky'"),
        (document(schema="lidardraft.layout/9"), r"schema is 'lidardraft.layout/9'; this version reads"),
        (document(primitives={}), r"primitives is {}; it must be a list of objects"),
        (document(primitives=[3]), r"3 is no JSON object"),
        (document(primitives=[{"id": "a"}]), r"a: 'center' is missing"),
        (document(primitives=row(colour="red")), r"car_1: unknown field 'colour'"),
        (document(primitives=row(size=[1, 1])), r"car_1: size is \[1, 1\]; it must be 3 finite numbers"),
        (document(primitives=row(shape="mesh", vertices=[[0, 0]], faces=[[0, 1, 2]])), r"car_1: a mesh needs vertices"),
        (document(primitives=row(shape="mesh", vertices="x", faces=[[0, 1, 2]])), r"car_1: "),
        (
            document(primitives=row(center=[1e308, 0, 0])),
            r"car_1: center is \[1e\+308, 0, 0\]; no number may be larger than",
        ),
        (document(primitives=row(size=[1, 10**400, 1])), r"car_1: size is .*; it must be 3 finite numbers"),
        (document(primitives=row(material=["glass"])), r"car_1: material is \['glass'\]; it must be one of"),
        (
            document(primitives=row(shape="mesh", vertices=[[0, 0, 10**400]], faces=[[0, 1, 2]])),
            r"car_1: a mesh needs vertices",
        ),
        (document(primitives=row(open="yes")), r"car_1: open is 'yes'; it must be true or false"),
        (document(coverage=[0]), r"layout: coverage is \[0\]; it must be 2 finite numbers"),
    ],
)
def test_text_that_is_no_layout(tmp_path, text, message):
    with pytest.raises(LidarDraftError, match=message):
        Layout.from_json(text)
    (tmp_path / "a.json").write_text(text)
    with pytest.raises(LidarDraftError, match=r"a.json: " + message):
        Layout.load(tmp_path / "a.json")


def test_a_file_of_bytes_is_no_layout(tmp_path):
    (tmp_path / "a.json").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(FormatError, match=r"a.json is no text in UTF-8: byte 0 is wrong"):
        Layout.load(tmp_path / "a.json")


def test_a_missing_file_is_no_layout(tmp_path):
    with pytest.raises(FormatError, match=r"none.json: No such file or directory"):
        Layout.load(tmp_path / "none.json")
