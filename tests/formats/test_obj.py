"""Wavefront OBJ, and the layouts in it."""

import numpy as np
import pytest
from exported_layouts import EVERYTHING, drafted
from hypothesis import given, settings
from hypothesis import strategies as st

from lidardraft.drafting import models
from lidardraft.drafting.models import layout_from_obj
from lidardraft.errors import FormatError, LayoutError, LidarDraftError
from lidardraft.formats.obj import write_obj
from lidardraft.scene import mesh
from lidardraft.scene.layout import object_of, primitive_mesh
from lidardraft.scene.raycast import raycast
from lidardraft.scene.sensor import Sensor

TRIANGLE = "v 0 0 0\nv 4 0 0\nv 0 0 1\nf -3 -2 -1\n"


def write(path, *names):
    lines = []
    for name in names:
        lines.append(f"o {name}\n")
        lines.append(TRIANGLE)
    path.write_text("".join(lines))
    return path


def test_names_say_the_class(tmp_path):
    layout = layout_from_obj(write(tmp_path / "a.obj", "car.001", "Car_left", "road", "traffic-sign.2"))
    assert [p.label for p in layout] == ["car", "car", "road", "traffic-sign"]
    assert [p.instance for p in layout] == [1, 2, 0, 0]
    assert [p.id for p in layout] == ["car_001", "Car_left", "road", "traffic-sign_2"]
    assert layout.provenance == {"source": "a.obj"}


def test_names_that_say_no_class_are_listed(tmp_path):
    path = write(tmp_path / "a.obj", "Cube.001", "road", "careful")
    with pytest.raises(
        LayoutError,
        match=r"a.obj: no class for Cube.001 \(no material\), careful \(no material\); say which by --class NAME=CLASS",
    ):
        layout_from_obj(path)
    assert [p.label for p in layout_from_obj(path, classes={"Cube.001": "building", "careful": "other"})] == [
        "building",
        "road",
        "other",
    ]


def test_materials_say_the_class_and_are_parts_of_one_thing(tmp_path):
    (tmp_path / "a.mtl").write_text("newmtl car\nKd 1 0 0\nnewmtl paint\nKd 0 1 0\n")
    (tmp_path / "a.obj").write_text(
        "mtllib a.mtl\no Cube\nv 0 0 0\nv 4 0 0\nv 0 0 1\nv 4 0 1\nusemtl car\nf 1 2 3\nusemtl paint\nf 2 4 3\n"
    )
    layout = layout_from_obj(tmp_path / "a.obj", classes={"paint": "car"})
    assert [p.label for p in layout] == ["car", "car"]
    assert [p.instance for p in layout] == [1, 1]
    assert len({p.id for p in layout}) == 2


def test_axes_and_unit(tmp_path):
    path = tmp_path / "a.obj"
    path.write_text("o car\nv 1 2 3\nv 5 2 3\nv 1 4 3\nf 1 2 3\n")
    z_up = layout_from_obj(path, scale=0.5).primitives[0]
    np.testing.assert_allclose(z_up.center, (1.5, 1.5, 1.5))
    np.testing.assert_allclose(z_up.size, (2, 1, 0))
    y_up = layout_from_obj(path, up="y").primitives[0]
    np.testing.assert_allclose(y_up.center, (3, -3, 3))
    np.testing.assert_allclose(y_up.size, (4, 0, 2))


@pytest.mark.parametrize("layout", [EVERYTHING, *drafted()])
def test_a_layout_comes_back_as_the_same_triangles(tmp_path, layout):
    """The same corners to 1e-9 m, the same class and id, and things that are one thing stay one."""
    write_obj(tmp_path / "a.obj", layout)
    found = layout_from_obj(tmp_path / "a.obj")
    assert [p.label for p in found] == [p.label for p in layout]
    assert [p.id for p in found] == [p.id.replace(" ", "_") for p in layout]
    for was, is_ in zip(layout, found, strict=True):
        corners, expected = (mesh.vertices[mesh.faces] for mesh in (primitive_mesh(is_), primitive_mesh(was)))
        np.testing.assert_allclose(corners, expected, atol=1e-9)
        assert (is_.instance > 0) == (was.instance > 0)
    for a, b in zip(layout, found, strict=True):
        assert [object_of(p) == object_of(a) for p in layout if p.instance and a.instance] == [
            p.instance == b.instance for p in found if p.instance and b.instance
        ]


def test_words_of_names_say_the_class_too(tmp_path):
    layout = layout_from_obj(
        write(tmp_path / "a.obj", "ParkedCar.001", "StreetLamp_3", "House_Wall", "car_1.body", "car_1.roof")
    )
    assert [p.label for p in layout] == ["car", "pole", "building", "car", "car"]
    assert [p.instance for p in layout] == [1, 0, 0, 2, 2]
    assert [p.id for p in layout][3:] == ["car_1.body", "car_1.roof"]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("\n" * 4_000_001, "4000001 lines; OBJ files of up to 4000000"),
        ("f " + "1 " * 8_000_000, "8000001 words; OBJ files of up to 8000000"),
        ("\no car\nf 1 1 1" * 65_536, "65536 objects; OBJ files of up to 65535"),
    ],
)
def test_what_takes_too_long_to_read_is_refused_before(tmp_path, text, said):
    (tmp_path / "a.obj").write_text(text)
    with pytest.raises(FormatError, match=rf"a.obj has {said}"):
        layout_from_obj(tmp_path / "a.obj")


def test_numbered_parts_are_one_thing(tmp_path):
    """As Blender writes objects with the option of material groups."""
    corners = "v 0 0 0\nv 1 0 0\nv 0 0 1\n"
    (tmp_path / "a.obj").write_text(
        "".join(f"o {name}\n{corners}f -3 -2 -1\n" for name in ("Car_1_Paint", "Car_1_Glass", "Car_2_Paint"))
    )
    assert [(p.id, p.instance) for p in layout_from_obj(tmp_path / "a.obj")] == [
        ("Car_1.Paint", 1),
        ("Car_1.Glass", 1),
        ("Car_2.Paint", 2),
    ]


SENSOR = Sensor(name="few", elevations=(0.2, 0.0, -0.2), columns=8)
NAMES = st.sampled_from(["car", "car.001", "road", "building_2", "bus.Ünïcode", "traffic-sign"])
NUMBERS = st.one_of(st.integers(-50, 50), st.floats(-1e6, 1e6), st.floats(-1e-6, 1e-6))
TOKENS = [
    b"v ",
    b"f ",
    b"o ",
    b"g ",
    b"usemtl ",
    b"vt ",
    b"l ",
    b"p ",
    b"s off",
    b"mtllib x",
    b"#",
    b"/",
    b"//",
    b"\\\n",
]
TOKENS += [b"nan", b"inf", b"-0", b"0", b"-1", b"1e999", b"9" * 30, b"18446744073709551615", b"\xff", b"\x00", b"\r\n"]
TOKENS += [b"f 1 2 3\n", b"v 1e308 -1e308 1e-320\n", b"v 1e9 2 3\n"]


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return tmp_path_factory.mktemp("obj") / "a.obj"


@st.composite
def documents(draw):
    """A valid file, and for each of its objects the name, the material and the corners of its faces."""
    lines, positions, objects = ["# made"], [], []
    for number in range(draw(st.integers(1, 4))):
        name, material = f"{draw(NAMES)}-{number}", draw(NAMES)
        lines += [f"o {name}", f"usemtl {material}"]
        for _ in range(draw(st.integers(3, 9))):
            positions.append([float(draw(NUMBERS)) for _ in range(3)])
            lines.append("v " + " ".join(map(repr, positions[-1])))
        lines += ["vn 0 0 1", "vt 0.5 0.5"]
        faces = []
        for _ in range(draw(st.integers(1, 6))):
            corners = draw(st.permutations(range(len(positions))))[: draw(st.integers(3, 5))]
            # Later vertices than the last one so far count back from it.
            numbers = [k - len(positions) if draw(st.booleans()) else k + 1 for k in corners]
            lines.append("f " + " ".join(f"{k}{draw(st.sampled_from(['', '/1', '//1', '/1/1']))}" for k in numbers))
            faces.append([positions[k] for k in corners])
        objects.append((name, material, faces))
    return draw(st.sampled_from(["\n", "\r\n"])).join([*lines, ""]), objects


@settings(max_examples=60, deadline=None)
@given(documents())
def test_a_valid_file_comes_back_as_it_was_written(path, document):
    text, objects = document
    path.write_text(text, newline="")
    found = mesh.read_obj(path)
    assert [(name, material) for name, material, _ in found] == [(name, material) for name, material, _ in objects]
    for (_, _, shape), (_, _, faces) in zip(found, objects, strict=True):
        triangles = shape.vertices[shape.faces].tolist()
        assert len(triangles) == sum(len(face) - 2 for face in faces)
        for face in faces:
            own, triangles = triangles[: len(face) - 2], triangles[len(face) - 2 :]
            assert own == [face] if len(face) == 3 else all(corner in face for each in own for corner in each)


def attempt(function, *arguments, **options):
    """What the function gives and None, or None and the one error of ours that it may raise."""
    try:
        return function(*arguments, **options), None
    except LidarDraftError as error:
        return None, error


def survives(path, data: bytes) -> None:
    """Meshes that can be cast, or one error of ours; the same through the core and as a layout."""
    path.write_bytes(data)
    objects, error = attempt(mesh.read_obj, path)
    if error is None:
        assert all(len(shape.faces) and np.isfinite(shape.vertices).all() for _, _, shape in objects)
        labels = {name: "other" for entry in objects for name in entry[:2]}
        layout, error = attempt(models.layout_from_obj, path, classes=labels)
        image, error = (None, error) if error else attempt(raycast, layout, SENSOR)
        assert error or np.isfinite(image.depth).all()
    else:
        assert type(attempt(models.layout_from_obj, path)[1]) is type(error)
    assert error is None or len(str(error).splitlines()) == 1


@settings(max_examples=100, deadline=None)
@given(st.lists(st.one_of(st.sampled_from(TOKENS), st.sampled_from([b" ", b"\n", b"1 ", b"2 ", b"3 "])), max_size=80))
def test_words_in_any_order(path, words):
    survives(path, b"v 0 0 0\nv 4 0 0\nv 0 0 1\n" + b"".join(words))


@pytest.mark.parametrize(
    "vertices",
    [
        "v 1e308 -1e308 0\nv -1e308 1e308 0\nv 0 1e308 1",
        "v 1e308 0 0\nv 1.1e308 0 0\nv 1.2e308 1 0",
        "v 9 0 0\nv 1e12 0 0\nv 0 9 0",
    ],
)
def test_vertices_too_far_away_for_arithmetic(path, vertices):
    survives(path, f"o car\n{vertices}\nf 1 2 3\n".encode())
    with pytest.raises(LidarDraftError, match=r"car: the mesh reaches|vertex|center"):
        raycast(models.layout_from_obj(path), SENSOR)
    with pytest.raises(LidarDraftError, match="finite"):
        models.layout_from_obj(path, scale=1e308)
