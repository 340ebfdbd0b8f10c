"""Wavefront OBJ files that nobody wrote: whatever the bytes are, meshes or one error of ours come back."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from lidardraft.drafting import models
from lidardraft.errors import LidarDraftError
from lidardraft.scene import mesh
from lidardraft.scene.raycast import raycast
from lidardraft.scene.sensor import Sensor

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
    """A valid file, and for each of its objects the name, the material and the corners [F, 3, 3] of its triangles."""
    lines, positions, objects = ["# made"], [], []
    for number in range(draw(st.integers(1, 4))):
        name, material = f"{draw(NAMES)}-{number}", draw(NAMES)
        lines += [f"o {name}", f"usemtl {material}"]
        for _ in range(draw(st.integers(3, 9))):
            positions.append([float(draw(NUMBERS)) for _ in range(3)])
            lines.append("v " + " ".join(map(repr, positions[-1])))
        lines += ["vn 0 0 1", "vt 0.5 0.5"]
        triangles = []
        for _ in range(draw(st.integers(1, 6))):
            corners = draw(st.permutations(range(len(positions))))[: draw(st.integers(3, 5))]
            # Later vertices than the last one so far count back from it.
            numbers = [k - len(positions) if draw(st.booleans()) else k + 1 for k in corners]
            lines.append("f " + " ".join(f"{k}{draw(st.sampled_from(['', '/1', '//1', '/1/1']))}" for k in numbers))
            triangles += [[positions[k] for k in (corners[0], b, c)] for b, c in pairwise(corners[1:])]
        objects.append((name, material, triangles))
    return draw(st.sampled_from(["\n", "\r\n"])).join([*lines, ""]), objects


@settings(max_examples=150, deadline=None)
@given(documents())
def test_a_valid_file_comes_back_as_it_was_written(path, document):
    text, objects = document
    path.write_text(text, newline="")
    found = mesh.read_obj(path)
    assert [(name, material) for name, material, _ in found] == [(name, material) for name, material, _ in objects]
    for (_, _, shape), (_, _, triangles) in zip(found, objects, strict=True):
        np.testing.assert_array_equal(shape.vertices[shape.faces], triangles)


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


@settings(max_examples=200, deadline=None)
@given(st.binary(max_size=400))
@example(b"")
@example(b"f")
@example(b"v 1 2\nf 1 1 1")
@example(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3")
def test_bytes_that_mean_nothing(path, data):
    survives(path, data)


@settings(max_examples=300, deadline=None)
@given(st.lists(st.one_of(st.sampled_from(TOKENS), st.sampled_from([b" ", b"\n", b"1 ", b"2 ", b"3 "])), max_size=80))
def test_words_in_any_order(path, words):
    survives(path, b"v 0 0 0\nv 4 0 0\nv 0 0 1\n" + b"".join(words))


@settings(max_examples=300, deadline=None)
@given(
    documents(), st.lists(st.tuples(st.floats(0, 1), st.integers(0, 9), st.sampled_from([b"", *TOKENS])), max_size=6)
)
def test_valid_files_with_errors_in_them(path, document, edits):
    data = document[0].encode()
    for share, gone, put in edits:
        at = int(share * len(data))
        data = data[:at] + put + data[at + gone :]
    survives(path, data)


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
    with pytest.raises(LidarDraftError, match=r"car: the mesh reaches from|vertex|center"):
        raycast(models.layout_from_obj(path), SENSOR)
    with pytest.raises(LidarDraftError, match="finite"):
        models.layout_from_obj(path, scale=1e308)
