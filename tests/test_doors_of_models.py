"""The doors for models, scripts, sketches and boxes: whatever unit, place, axis, naming, face or mode a file has, the
layout is right, or one line says why it is not."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lidardraft import Box, Layout, layout_from_blender, layout_from_boxes, layout_from_glb, layout_from_obj
from lidardraft import layout_from_sketch as read_sketch
from lidardraft.cli.main import main
from lidardraft.drafting.blender.script.limits import ScriptLimits
from lidardraft.errors import FormatError, LayoutError, ScriptError
from lidardraft.formats.glb import glb_bytes
from lidardraft.scene.layout import primitive_mesh
from lidardraft.scene.mesh import TriangleMesh, triangles_of

SIDES = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
STRIP = [3, 2, 7, 6, 5, 2, 1, 3, 0, 7, 4, 5, 0, 1]  # around a box
Things = dict[str, tuple[tuple[float, float, float], tuple[float, float, float]]]  # center and size by names


def corners(center: Any, size: Any) -> np.ndarray:
    """The corners of a box, in the order of `SIDES`."""
    signs = [(-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1), (-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1)]
    return np.array(signs) * np.array(size) / 2 + center


def written_obj(folder: Path, things: Things, end: str = "\n") -> Path:
    lines, count = ["# made"], 1
    for name, (center, size) in things.items():
        lines += [f"o {name}", *(f"v {x!r} {y!r} {z!r}" for x, y, z in corners(center, size).tolist())]
        lines += [f"f {' '.join(str(k + count) for k in side)}" for side in SIDES]
        count += 8
    (folder / "a.obj").write_text(end.join([*lines, ""]), newline="")
    return folder / "a.obj"


class Glb:
    """A binary glTF that grows."""

    def __init__(self) -> None:
        self.fields: dict[str, Any] = {"asset": {"version": "2.0"}, "scenes": [{"nodes": []}]}
        self.fields |= {name: [] for name in ("nodes", "meshes", "accessors", "bufferViews")}
        self.binary = b""

    def array(self, values: Any, dtype: str, kind: str) -> int:
        data = np.array(values, dtype)
        codes = {"<f4": 5126, "<u2": 5123, "u1": 5121}
        self.fields["bufferViews"].append(
            {"buffer": 0, "byteOffset": len(self.binary), "byteLength": data.nbytes},
        )
        self.binary += data.tobytes() + bytes(-data.nbytes % 4)
        view = len(self.fields["bufferViews"]) - 1
        self.fields["accessors"].append(
            {"bufferView": view, "componentType": codes[dtype], "type": kind, "count": len(data)}
        )
        return len(self.fields["accessors"]) - 1

    def node(self, name: str, places: Any, indices: Any = None, mode: int | None = None, **more: Any) -> None:
        part: dict[str, Any] = {"attributes": {"POSITION": self.array(places, "<f4", "VEC3")}} | more.pop("part", {})
        if indices is not None:
            part["indices"] = self.array(np.ravel(indices), "<u2", "SCALAR")
        if mode is not None:
            part["mode"] = mode
        self.fields["meshes"].append({"primitives": [part], **more.pop("mesh", {})})
        self.add({"name": name, "mesh": len(self.fields["meshes"]) - 1, **more})

    def add(self, node: dict[str, Any]) -> None:
        self.fields["nodes"].append(node)
        self.fields["scenes"][0]["nodes"].append(len(self.fields["nodes"]) - 1)

    def written(self, folder: Path) -> Path:
        fields = {name: value for name, value in self.fields.items() if value}
        fields["buffers"] = [{"byteLength": len(self.binary)}]
        (folder / "a.glb").write_bytes(glb_bytes(fields, self.binary))
        return folder / "a.glb"


TRIANGLES = [each for a, b, c, d in SIDES for each in ((a, b, c), (a, c, d))]


def y_up(places: Any) -> np.ndarray:
    return np.array(places, float)[..., [0, 2, 1]] * (1, 1, -1)


def written_glb(folder: Path, things: Things) -> Path:
    file = Glb()
    for name, (center, size) in things.items():
        file.node(name, y_up(corners((0, 0, 0), size)), TRIANGLES, translation=y_up(center).tolist())
    return file.written(folder)


def written_script(folder: Path, things: Things) -> Path:
    lines = ["import bpy"]
    for name, (center, size) in things.items():
        lines += [f"bpy.ops.mesh.primitive_cube_add(size=1, location={center}, scale={size})"]
        lines += [f"bpy.context.object.name = {name!r}"]
    (folder / "a.py").write_text("\n".join(lines))
    return folder / "a.py"


READERS: dict[str, tuple[Callable[[Path, Things], Path], Callable[..., Layout]]] = {
    "obj": (written_obj, layout_from_obj),
    "glb": (written_glb, layout_from_glb),
    "blender": (written_script, layout_from_blender),
}
UNITS = {"centimetres": 0.01, "millimetres": 0.001, "inches": 0.0254, "feet": 0.3048}
CAR, PERSON, ROAD = (
    ((12.0, 3.0, 0.75), (4.2, 1.8, 1.5)),
    ((8.0, -2.0, 0.9), (0.5, 0.6, 1.8)),
    ((0.0, 0.0, -0.1), (60.0, 8.0, 0.2)),
)


def times(thing: Any, factor: float) -> Any:
    return tuple(tuple(factor * value for value in each) for each in thing)


@pytest.mark.parametrize("door", READERS)
@pytest.mark.parametrize("unit", UNITS)
@pytest.mark.parametrize("name", ["Car", "Person"])
def test_a_model_in_another_unit(tmp_path: Path, door: str, unit: str, name: str) -> None:
    write, read = READERS[door]
    thing = CAR if name == "Car" else PERSON
    path = write(tmp_path, {name: times(thing, 1 / UNITS[unit])})
    with pytest.raises(
        LayoutError, match=rf"{path.name}: {name} is .* are these {unit}\? --scale {UNITS[unit]:g} .*--as-is"
    ):
        read(path)
    (found,) = read(path, scale=UNITS[unit])
    assert np.allclose([found.center, found.size], thing, rtol=1e-6)
    assert np.allclose(read(path, as_is=True).primitives[0].size, times(thing, 1 / UNITS[unit])[1], rtol=1e-6)


@pytest.mark.parametrize("door", READERS)
@pytest.mark.parametrize("scale", [0, -1.0, math.nan, "1"])
def test_a_scale_is_a_length(tmp_path: Path, door: str, scale: Any) -> None:
    write, read = READERS[door]
    with pytest.raises(LayoutError, match=rf"scale is {scale}; it must be a finite number of metres > 0"):
        read(write(tmp_path, {"Car": CAR}), scale=scale)


@pytest.mark.parametrize("door", READERS)
def test_a_toy(tmp_path: Path, door: str) -> None:
    write, read = READERS[door]
    path = write(tmp_path, {"Car": times(CAR, 0.01)})
    with pytest.raises(
        LayoutError, match=r"Car is 0\.042 x 0\.018 x 0\.015 m large.*scaled twice\? --scale 100 .*--as-is"
    ):
        read(path)
    assert np.allclose(read(path, scale=100).primitives[0].size, CAR[1], rtol=1e-5)


@pytest.mark.parametrize(
    ("id", "label", "size"),
    [
        ("car", "car", (2.4, 1.3, 1.1)),
        ("microcar", "car", (1.4, 0.8, 0.8)),
        ("limousine", "car", (12.0, 2.2, 1.8)),
        ("Cars", "car", (240.0, 30.0, 12.0)),
        ("fused", "car", (240.0, 30.0, 1.6)),
        ("wheel", "car", (0.6, 0.2, 0.6)),
        ("haul_truck", "truck", (15.0, 9.5, 7.7)),
        ("bus", "bus", (30.0, 2.6, 3.5)),
        ("train", "train", (400.0, 3.0, 4.0)),
        ("child", "person", (0.2, 0.3, 0.75)),
        ("People", "person", (5.0, 4.0, 2.9)),
        ("sheet", "person", (0.5, 0.01, 1.7)),
        ("t_pose", "person", (0.3, 1.8, 1.8)),
        ("house", "building", (900.0, 600.0, 500.0)),
        ("statue", "person", (1.5, 1.5, 5.0)),
    ],
)
def test_sizes_that_there_are(id: str, label: str, size: tuple[float, float, float]) -> None:
    layout = layout_from_boxes([Box(id, label, 1, (10.0, 0.0, size[2] / 2), size, 0.0)])
    assert layout[id].size == size
    assert layout.notes == ()


def test_boxes_of_another_unit_or_place() -> None:
    box = Box("car_1", "car", 1, (1200.0, 0.0, 75.0), (420.0, 180.0, 150.0), 0.3)
    with pytest.raises(LayoutError, match=r"car_1 is 420 x 180 x 150 m large.*are these centimetres\? --as-is"):
        layout_from_boxes([box])
    assert layout_from_boxes([box], as_is=True)["car_1"].size == (420.0, 180.0, 150.0)
    (note,) = layout_from_boxes([Box("car_1", "car", 1, (5000.0, 0.0, 0.8), CAR[1], 0.0)]).notes
    assert note.startswith("all of it is 4,998 m or more from the origin")
    assert note.endswith("boxes are read in the frame of the sensor")
    (note,) = layout_from_boxes([Box("car_1", "car", 1, (12.0, 0.0, 30.75), CAR[1], 0.0)], sensor_height=1.25).notes
    assert note.startswith("its vehicles and people are 31.2 m off the ground")
    assert note.endswith("boxes are read in the frame of the sensor")


@pytest.mark.parametrize("door", ["obj", "glb"])
@pytest.mark.parametrize("has_ground", [False, True])
def test_another_axis_is_up(tmp_path: Path, door: str, has_ground: bool) -> None:
    write, read = READERS[door]
    things = {"Car": CAR} | ({"Road": ROAD} if has_ground else {})
    turned = {
        name: ((x, z, -y), (length, height, width)) for name, ((x, y, z), (length, width, height)) in things.items()
    }
    if door == "glb":  # whose writer turns y up once more
        turned = {name: ((x, -z, y), (a, c, b)) for name, ((x, y, z), (a, b, c)) in things.items()}
    path = write(tmp_path, turned)
    notes = read(path).notes
    assert any("m off the ground; is another axis up (--up, for models)? --recentre" in note for note in notes)
    layout = read(path, up="y" if door == "obj" else "z")
    assert layout.notes == ()
    assert np.allclose([layout["Car"].center, layout["Car"].size], CAR, atol=1e-6)


@pytest.mark.parametrize("door", READERS)
def test_houses_of_another_unit(tmp_path: Path, door: str) -> None:
    write, read = READERS[door]
    path = write(tmp_path, {"House": ((15000.0, 0.0, 4000.0), (30000.0, 6000.0, 8000.0))})
    assert read(path).notes == ("House is 8,000 m high; --scale (`scale` in Python) is for units other than the metre",)
    assert read(path, scale=0.001).notes == read(path, as_is=True).notes == ()


@pytest.mark.parametrize("door", READERS)
@pytest.mark.parametrize("place", [(389025.0, 5712020.0, 40.0), (0.0, 0.0, 40.0), (0.0, 0.0, -3.0)])
def test_a_model_somewhere_else(tmp_path: Path, door: str, place: tuple[float, float, float]) -> None:
    write, read = READERS[door]
    things = {"Car": CAR, "Road": ROAD}
    path = write(
        tmp_path, {name: (tuple(np.add(place, center).tolist()), size) for name, (center, size) in things.items()}
    )
    (note,) = read(path).notes
    far = "all of it is 5,725,246 m or more from the origin"
    assert note.startswith(far if place[0] else f"its ground is at z = {place[2] - 0.2:.1f} to {place[2]:.1f} m")
    assert "--recentre" in note
    layout = read(path, recentre=True)
    assert layout.notes == (
        f"moved by ({0 - place[0]:.3f}, {0 - place[1]:.3f}, {-place[2]:.3f}) m: the middle of its ground is the origin",
    )
    for name, (center, size) in things.items():
        assert np.allclose([layout[name].center, layout[name].size], (center, size), atol=1e-7)
    assert read(write(tmp_path, things)).notes == ()


def test_the_options_of_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = str(tmp_path / "out.json")
    far = {"Car": (tuple(np.add(CAR[0], (4e5, 0, 0)).tolist()), CAR[1])}
    for option, (write, _) in {
        "--obj": READERS["obj"],
        "--glb": READERS["glb"],
        "--blender": READERS["blender"],
    }.items():
        draft = ["draft", option, str(write(tmp_path, {"Car": times(CAR, 100)})), "--no-preview", "-o", out]
        assert main(draft) == 2
        assert "--scale 0.01" in capsys.readouterr().err
        assert main([*draft, "--scale", "0.01"]) == 0
        assert np.allclose(Layout.load(out)["Car"].size, CAR[1], rtol=1e-5)
        assert main([*draft, "--as-is"]) == 0
        assert Layout.load(out)["Car"].size[0] == pytest.approx(420)
        assert main(["draft", option, str(write(tmp_path, far)), "--recentre", "--no-preview", "-o", out]) == 0
        assert "moved by (-400012.000, -3.000, 0.000) m" in capsys.readouterr().err
        assert Layout.load(out)["Car"].center == pytest.approx((0, 0, 0.75))


def test_what_we_wrote_is_not_doubted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A layout that is exported and read again stays as it is, whatever is in it."""
    from lidardraft.formats.blender_script import write_blender_script
    from lidardraft.formats.glb import write_glb

    layout = layout_from_boxes([Box("car_1", "car", 1, (9000.0, 0.0, 75.0), (420.0, 180.0, 150.0), 0.0)], as_is=True)
    write_glb(tmp_path / "a.glb", layout)
    write_blender_script(tmp_path / "a.py", layout)
    for read, name in ((layout_from_glb, "a.glb"), (layout_from_blender, "a.py")):
        found = read(tmp_path / name)
        assert found["car_1"].size == pytest.approx((420.0, 180.0, 150.0))
        assert found.notes == layout.notes
    out = str(tmp_path / "out.json")
    assert main(["draft", "--glb", str(tmp_path / "a.glb"), "--recentre", "--no-preview", "-o", out]) == 0
    assert "a.glb: moved by (0.000, 0.000, 0.000) m" in capsys.readouterr().err


@pytest.mark.parametrize("indexed", [True, False])
def test_strips_and_fans_of_gltf(tmp_path: Path, indexed: bool) -> None:
    file, box = Glb(), y_up(corners((0, 0, 0), (8.0, 2.5, 3.2)))
    ring = [(math.cos(k * math.tau / 16), math.sin(k * math.tau / 16), 0.0) for k in range(17)]
    disc = y_up(np.array([(0.0, 0.0, 0.0), *ring]) * 8)
    for name, places, mode, order in (("Truck", box, 5, STRIP), ("Terrain", disc, 6, list(range(18)))):
        file.node(
            name, places if indexed else places[order], order if indexed else None, mode, translation=[25, 1.6, 4]
        )
    truck, terrain = layout_from_glb(file.written(tmp_path))
    assert (truck.shape, truck.center, truck.size) == (
        "box",
        pytest.approx((25, -4, 1.6)),
        pytest.approx((8, 2.5, 3.2)),
    )
    mesh = primitive_mesh(terrain)
    assert doubled(mesh)[:, 2].min() > 0  # all faces look up
    assert doubled(mesh)[:, 2].sum() / 2 == pytest.approx(64 * 8 * math.sin(math.tau / 16))


@pytest.mark.parametrize("mode", [0, 1, 2, 3])
def test_what_of_gltf_has_no_surface_is_named(tmp_path: Path, mode: int) -> None:
    file, box = Glb(), y_up(corners(*CAR))
    file.node("Car", box, TRIANGLES)
    for number in range(7):
        file.node(f"Wire_{number}", box, mode=mode)
    with pytest.warns(UserWarning, match=r"a\.glb: points and lines are left out: Wire_0, .*Wire_4 and 2 more$"):
        (car,) = layout_from_glb(file.written(tmp_path))
    assert car.size == pytest.approx(CAR[1])


@pytest.mark.parametrize("weights", [[0.0], [0.5]])
def test_morph_targets_are_left_out_where_they_count(tmp_path: Path, weights: list[float], recwarn: Any) -> None:
    file = Glb()
    file.node("Car", y_up(corners(*CAR)), TRIANGLES, part={"targets": [{"POSITION": 0}]}, mesh={"weights": weights})
    layout_from_glb(file.written(tmp_path))
    assert [str(each.message).partition(": ")[2] for each in recwarn] == ["morph targets are left out: Car"] * any(
        weights
    )


def test_float32_far_from_its_node_is_said(tmp_path: Path) -> None:
    file = Glb()
    file.node("House", y_up(corners((389025.0, 5712020.0, 44.0), (10.0, 8.0, 8.0))), TRIANGLES)
    with pytest.warns(
        UserWarning, match=r"places so far from their node are rounded to 0\.5, as float32 has them: House"
    ):
        layout_from_glb(file.written(tmp_path), recentre=True)


def test_skins_are_in_their_bind_pose(tmp_path: Path) -> None:
    """The node of a skinned mesh does not count; its joints do: here the armature is in centimetres, and turned."""
    file, places = Glb(), y_up(corners((0, 0, 0.9), PERSON[1])) * 100
    bind = np.eye(4)
    bind[1, 3] = -50.0  # the joint is 50 cm up
    part = {"attributes": {"POSITION": file.array(places, "<f4", "VEC3")}}
    part["attributes"]["JOINTS_0"] = file.array([[0, 1, 0, 0]] * 8, "u1", "VEC4")
    part["attributes"]["WEIGHTS_0"] = file.array([[0.25, 0.75, 0, 0]] * 8, "<f4", "VEC4")
    inverse = file.array([bind.T.ravel()] * 2, "<f4", "MAT4")
    file.fields["skins"] = [{"joints": [2, 2], "inverseBindMatrices": inverse}]
    file.node("Person", places, TRIANGLES, part=part, skin=0, translation=[1e4, 1e4, 1e4], scale=[7, 7, 7])
    file.add({"name": "Armature", "children": [2], "translation": [8, 0, 2], "scale": [0.01] * 3})
    file.fields["nodes"].append({"name": "Hips", "translation": [0, 50, 0]})
    (person,) = layout_from_glb(file.written(tmp_path))
    assert (person.label, person.shape) == ("person", "box")
    assert np.allclose([person.center, person.size], PERSON, atol=1e-5)
    file.fields["skins"][0]["joints"] = [2, 9]
    with pytest.raises(FormatError, match=r"a\.glb: Person: not a skin on nodes of the scene: 9"):
        layout_from_glb(file.written(tmp_path))


# A notch, a comb, a hole that is cut open, and corners on lines: outline and area.
OUTLINES = {
    "square": ([(0, 0), (4, 0), (4, 4), (0, 4)], 16.0),
    "notch": ([(4, 0), (4, 3), (2, 1), (0, 3), (0, 2), (0, 0)], 8.0),
    "first corner between": ([(2, 0), (4, 0), (4, 4), (2, 4), (2, 3), (3, 3), (3, 1), (0, 1), (0, 0)], 8.0),
    "comb": ([(0, 0), (5, 0), (5, 3), (4, 3), (4, 1), (3, 1), (3, 3), (2, 3), (2, 1), (1, 1), (1, 3), (0, 3)], 11.0),
    "hole": ([(0, 0), (6, 0), (6, 6), (0, 6), (0, 0), (2, 2), (2, 4), (4, 4), (4, 2), (2, 2)], 32.0),
}


def doubled(mesh: TriangleMesh) -> np.ndarray:
    a, b, c = mesh.vertices[mesh.faces.T]
    return np.cross(b - a, c - a)


@pytest.mark.parametrize("door", ["obj", "pydata", "bmesh"])
@pytest.mark.parametrize("turn", [1, -1])
@pytest.mark.parametrize("name", OUTLINES)
def test_faces_of_any_outline(tmp_path: Path, door: str, turn: int, name: str) -> None:
    outline, area = OUTLINES[name]
    places = [(float(x), float(y), 2.0) for x, y in outline[::turn]]
    if door == "obj":
        lines = [
            *(f"v {x} {y} {z}" for x, y, z in places),
            "o building",
            f"f {' '.join(map(str, range(1, len(places) + 1)))}",
        ]
        (tmp_path / "a.obj").write_text("\n".join(lines))
        (found,) = layout_from_obj(tmp_path / "a.obj")
    else:
        lines = ["import bpy, bmesh", "mesh = bpy.data.meshes.new('m')"]
        if door == "pydata":
            lines += [f"mesh.from_pydata({places}, [], [tuple(range({len(places)}))])"]
        else:
            lines += [
                "made = bmesh.new()",
                f"made.faces.new([made.verts.new(place) for place in {places}])",
                "made.to_mesh(mesh)",
            ]
        lines += ["bpy.context.collection.objects.link(bpy.data.objects.new('building', mesh))"]
        (found,) = layout_from_blender("\n".join(lines))
    turns = doubled(primitive_mesh(found))
    assert np.abs(turns[:, :2]).max() < 1e-9
    assert (turn * turns[:, 2]).min() > -1e-9 if found.shape == "mesh" else name == "square"
    assert abs(turns[:, 2].sum()) / 2 == pytest.approx(area)


@settings(max_examples=150, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(4, 40), st.booleans(), st.booleans())
def test_triangles_cover_a_polygon_once(seed: int, count: int, is_comb: bool, is_far: bool) -> None:
    """As much area as the outline encloses, all of it on one side, and the edges of the outline, each once."""
    rng = np.random.default_rng(seed)
    if is_comb:  # of whole numbers: many corners are on lines
        heights = rng.integers(1, 4, count)
        top = [place for k, height in enumerate(heights) for place in ((k, height), (k + 1, height))]
        flat = np.array([(k, 0) for k in range(count, 0, -1)] + [(0, 0)] + top, float)
        flat = flat[(flat != np.roll(flat, 1, axis=0)).any(axis=1)]
    else:
        angles = (np.arange(count) + rng.uniform(0, 0.99, count)) * math.tau / count  # around the origin
        flat = rng.uniform(0.2, 1, count)[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    flat = np.roll(flat, rng.integers(len(flat)), axis=0)
    axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    places = np.column_stack([flat, np.zeros(len(flat))]) @ axes + (5e6 if is_far else 0.0)
    x, y = flat.T
    enclosed = (x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2
    faces = triangles_of(places, np.arange(len(flat)), np.array([len(flat)]))
    a, b, c = flat[faces.T]
    areas = ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) / 2
    assert areas.sum() == pytest.approx(enclosed)
    assert (areas * np.sign(enclosed)).min() > -1e-6 * abs(enclosed)
    edges = [tuple(edge) for face in faces.tolist() for edge in zip(face, face[1:] + face[:1], strict=True)]
    outline = {(k, (k + 1) % len(flat)) for k in range(len(flat))}
    assert len(set(edges)) == len(edges)
    assert {edge for edge in edges if edge[::-1] not in edges} == outline


def test_concave_faces_take_the_time_of_their_script() -> None:
    script = "import bpy\nmesh = bpy.data.meshes.new('m')\n"
    script += "mesh.from_pydata([(0,0,0), (4,0,0), (4,3,0), (2,1,0), (0,3,0)], [], [(1, 2, 3, 4, 0)] * 30000)\n"
    script += "bpy.context.collection.objects.link(bpy.data.objects.new('building', mesh))\n"
    with pytest.raises(ScriptError, match=r"line 4: the script takes more than 0\.3 s"):
        layout_from_blender(script, limits=ScriptLimits(seconds=0.3))


def test_convex_faces_keep_their_fans() -> None:
    ring = np.array([(math.cos(k), math.sin(k), 0.0) for k in np.linspace(0, math.tau, 12, endpoint=False)])
    fan = [(0, k, k + 1) for k in range(1, 11)]
    assert triangles_of(ring, np.arange(12), np.array([12])).tolist() == [list(each) for each in fan]
    assert triangles_of(ring, np.array([0, 1, 2, 3, 4, 5, 6]), np.array([3, 4])).tolist() == [
        [0, 1, 2],
        [3, 4, 5],
        [3, 5, 6],
    ]


def test_an_obj_of_rhino(tmp_path: Path) -> None:
    lines = [
        "# Rhino",
        "",
        "g building",
        "usemtl ",
        *(f"v {x} {y} {z}" for x, y, z in corners((5, 3, 2.5), (10, 6, 5))),
    ]
    lines += [f"f {a + 1} {b + 1} \\\r\n {c + 1} {d + 1}" for a, b, c, d in SIDES]
    (tmp_path / "a.obj").write_text("\r\n".join(lines), newline="")
    (found,) = layout_from_obj(tmp_path / "a.obj")
    assert (found.label, found.center, found.size) == ("building", (5, 3, 2.5), (10, 6, 5))
    assert len(found.mesh.faces) == 12


@pytest.mark.parametrize("up", ["y", "z"])
@pytest.mark.parametrize("door", ["obj", "glb"])
def test_the_axis_that_points_up(tmp_path: Path, door: str, up: str) -> None:
    write, read = READERS[door]
    own = {"obj": "z", "glb": "y"}[door]
    center, size = CAR
    if up != own:  # as the reader of this axis finds it again
        turned = y_up(center) if door == "obj" else np.array([center[0], -center[2], center[1]])
        center, size = tuple(turned.tolist()), (size[0], size[2], size[1])
    (found,) = read(write(tmp_path, {"Car": (center, size)}), up=up)
    assert np.allclose([found.center, found.size], CAR, atol=1e-6)


FENCES = [
    "```python\n{}\n```",
    "Here is the script:\n\n```py\n{}\n```\nIt makes a car. Run it:\n```\nblender -P a.py\n```\n",
    "~~~\n{}",
]


@pytest.mark.parametrize("text", FENCES)
def test_a_script_in_markdown(tmp_path: Path, text: str) -> None:
    script = written_script(tmp_path, {"Car": CAR}).read_text()
    layout = layout_from_blender(text.format(script))
    assert np.allclose([layout["Car"].center, layout["Car"].size], CAR)
    assert "text outside the longest block between Markdown fences is ignored" in layout.notes[0]
    line = text.count("\n", 0, text.index("{}")) + 2
    with pytest.raises(ScriptError, match=rf"^line {line}: "):
        layout_from_blender(text.format("import bpy\nunknown()"))


def test_fences_in_a_script_are_its_own() -> None:
    script = 'import bpy\n"""\n```\nnothing()\n```\n"""\nbpy.ops.mesh.primitive_cube_add()\n'
    script += 'bpy.context.object.name = "Car"\n'
    assert layout_from_blender(script, as_is=True).notes == ()


# A viewBox of 100 x 100 on a page of 800 x 400: where its middle is, in pixels from left and top, and scales.
ASPECTS = {
    "": (400, 200, 4, 4),
    "none": (400, 200, 8, 4),
    "xMinYMid": (200, 200, 4, 4),
    "xMaxYMin meet": (600, 200, 4, 4),
    "xMidYMid slice": (400, 200, 8, 8),
    "xMinYMin slice": (400, 400, 8, 8),
    "xMidYMax slice": (400, 0, 8, 8),
}


def test_strokes_are_stretched_with_the_page(tmp_path: Path) -> None:
    (tmp_path / "a.svg").write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" width="800" height="400" viewBox="0 0 100 100" '
        'preserveAspectRatio="none"><line id="road_1" x1="50" y1="0" x2="50" y2="100" stroke="#888" stroke-width="2"/>'
        '<line id="road_2" x1="0" y1="50" x2="40" y2="50" stroke="#888" stroke-width="2"/></svg>'
    )
    roads = [each.size[:2] for each in read_sketch(tmp_path / "a.svg", metres_per_pixel=0.5) if each.label == "road"]
    assert np.allclose(sorted(roads), [(160, 4), (200, 8)])


@pytest.mark.parametrize("aspect", ASPECTS)
def test_the_aspect_ratio_of_an_svg(tmp_path: Path, aspect: str) -> None:
    right, down, across, along = ASPECTS[aspect]
    (tmp_path / "a.svg").write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" width="800" height="400" viewBox="0 0 100 100"'
        f"{f' preserveAspectRatio={chr(34)}{aspect}{chr(34)}' if aspect else ''}>"
        '<rect id="building" x="45" y="45" width="10" height="10"/></svg>'
    )
    layout = read_sketch(tmp_path / "a.svg", metres_per_pixel=0.5)
    house = layout["building_1"] if "building_1" in [each.id for each in layout] else layout["house_1"]
    assert np.allclose(house.center[:2], ((200 - down) * 0.5, (400 - right) * 0.5))
    assert sorted(house.size[:2]) == pytest.approx(sorted((5 * across, 5 * along)))
