"""What layouts are made of: sentences, labelled scans, boxes, 3D models, layout files."""

import math
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import torch
from PIL import Image

from lidardraft import Box, Layout, Primitive, Sensor, layout_from_text, simulate
from lidardraft.cli import main as cli
from lidardraft.drafting.cloud.layout import layout_from_cloud
from lidardraft.drafting.picture.camera import Pinhole
from lidardraft.formats import kitti, semantickitti
from lidardraft.formats.boxes import write_boxes
from lidardraft.networks import weight_file
from lidardraft.perception.segmenter import Segmenter, SegmenterConfig, SphericalGrid
from lidardraft.semantics import BY_NAME
from rendered_pictures import RenderedPicture, render

# A cube of a metre on the ground, its y axis up.
CUBE = """\
o Cube.001
v 9 0 0
v 10 0 0
v 10 1 0
v 9 1 0
v 9 0 1
v 10 0 1
v 10 1 1
v 9 1 1
f 1 2 3 4
f 5 6 7 8
f 1 2 6 5
f 2 3 7 6
f 3 4 8 7
f 4 1 5 8
"""
SCRIPT = "import bpy\nbpy.ops.mesh.primitive_cube_add(size=1, location=(9, 0, 0.5))\nbpy.context.object.name = 'Blob'\n"


def test_an_obj_file_is_read_with_its_classes_axis_and_unit() -> None:
    Path("scene.obj").write_text(CUBE)
    options = ["--class", "Cube.001=car", "--up", "y", "--scale", "2"]
    assert cli.main(["draft", "--obj", "scene.obj", *options, "-o", "layout.json"]) == 0
    (box,) = Layout.load("layout.json").boxes()
    assert box.label == "car"
    np.testing.assert_allclose(box.center, (19, -1, 1))
    np.testing.assert_allclose(box.size, (2, 2, 2))
    assert cli.main(["raycast", "--obj", "scene.obj", *options, "--sensor", "small.json", "-o", "image.npz"]) == 0


def test_what_is_wrong_with_an_obj_file(refused: Callable[..., str]) -> None:
    Path("scene.obj").write_text(CUBE)
    draft = ("draft", "-o", "layout.json", "--obj", "scene.obj")
    assert "scene.obj: no class for Cube.001" in refused(*draft)
    assert "--class" in refused(*draft)
    assert "did you mean 'car'?" in refused(*draft, "--class", "Cube.001=carr")
    assert "--class is 'Cube.001'; it must be NAME=CLASS" in refused(*draft, "--class", "Cube.001")
    assert "scale is 0" in refused(*draft, "--class", "Cube.001=car", "--scale", "0")


@pytest.mark.parametrize(
    ("option", "said"),
    [
        (["--labels", "a.label"], "--labels goes with --points"),
        (["--segmenter", "a.safetensors"], "--segmenter goes with --points"),
        (["--detail", "objects"], "--detail goes with --points"),
        (["--class", "a=car"], "--class goes with --obj or --glb or --blender"),
        (["--metres-per-pixel", "1"], "--metres-per-pixel goes with --sketch"),
        (["--scale-bar", "1"], "--scale-bar goes with --sketch"),
        (["--up", "y"], "--up goes with --obj or --glb"),
        (["--scale", "1"], "--scale goes with --obj"),
        (["--depth", "a.npy"], "--depth goes with --image"),
        (["--camera-height", "2"], "--camera-height goes with --image"),
    ],
)
def test_options_of_other_inputs_are_refused(refused: Callable[..., str], option: list[str], said: str) -> None:
    assert said in refused("draft", "--text", "a car ahead", *option, "-o", "layout.json")


def test_a_sentence_or_a_scan_that_says_nothing(refused: Callable[..., str]) -> None:
    assert "xyzzy" in refused("draft", "--text", "xyzzy", "-o", "layout.json")
    Path("short.bin").write_bytes(b"12345")
    Path("short.label").write_bytes(b"1234")
    short = ["--points", "short.bin", "-o", "layout.json"]
    assert "short.bin" in refused("draft", *short, "--labels", "short.label")
    Path("short.label").unlink()
    assert "short.bin has 5 bytes" in refused("draft", *short)


def test_the_file_that_is_wrong_is_named(refused: Callable[..., str]) -> None:
    scan = ["draft", "--points", "scan.bin", "-o", "layout.json"]
    Path("scan.bin").write_bytes(b"")
    Path("scan.label").write_bytes(bytes(20))
    assert "scan.bin is empty: a scan without returns" in refused(*scan)
    kitti.write_bin("scan.bin", np.ones((5, 3)), np.zeros(5))
    assert "scan.bin: all 5 points have label 0" in refused(*scan)
    Path("far.json").write_text(
        '{"schema": "lidardraft.layout/2", "primitives": [{"shape": "box", "center": [1e308, 0, 0], '
        '"size": [1, 1, 1], "label": "car", "id": "car_1"}]}'
    )
    assert "far.json: car_1: center is [1e+308, 0, 0]" in refused("raycast", "--layout", "far.json", "-o", "a.npz")


def test_a_scan_is_read_from_the_height_of_its_own_sensor() -> None:
    """The sensor that is written beside a scan comes before the one that scans are asked of."""
    ground = np.stack([*np.meshgrid(np.linspace(2, 20, 60), np.linspace(-8, 8, 60)), np.full((60, 60), -3.0)], axis=-1)
    points = ground.reshape(-1, 3).astype(np.float32)
    kitti.write_bin("scan.bin", points, np.zeros(len(points), np.float32))
    road = np.full(len(points), BY_NAME["road"].id)
    semantickitti.write_label("scan.label", road, np.zeros_like(road))
    high = Sensor(name="high", elevations=(0.0, -0.1), columns=64, mount_height=3.0)
    Path("scan.sensor.json").write_text(high.to_json())
    assert cli.main(["draft", "--points", "scan.bin", "-o", "layout.json"]) == 0
    heights = [primitive.center[2] for primitive in Layout.load("layout.json") if primitive.label == "road"]
    np.testing.assert_allclose(heights, 0, atol=0.05)


def test_scans_are_read_from_other_files_than_kittis(refused: Callable[..., str]) -> None:
    """The same points as KITTI's .bin, an .npz and a .pcd of text are the same layout; a sweep of nuScenes is one by
    its sensor, which stands higher."""
    y, x = np.meshgrid(np.linspace(-8, 8, 60), np.linspace(2, 20, 60))
    points = np.stack([x, y, np.full_like(x, -1.73)], axis=-1).reshape(-1, 3).astype(np.float32)
    label = np.full(len(points), BY_NAME["road"].id)
    kitti.write_bin("a.bin", points, np.zeros(len(points), np.float32))
    np.savez("a.npz", xyz=points, label=label)
    head = f"FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nPOINTS {len(points) + 1}\nDATA ascii\n"
    lines = "\n".join(" ".join(map(str, point)) for point in [*points.tolist(), ["nan"] * 3])
    Path("a.pcd").write_text(head + lines)
    np.stack([-points[:, 1], points[:, 0], points[:, 2], 255 * (x.ravel() > 9), 0 * label], axis=1).astype(
        "<f4"
    ).tofile("a.pcd.bin")
    semantickitti.write_label("a.label", label, np.zeros_like(label))
    semantickitti.write_label("one_more.label", np.append(label, 0), np.zeros(len(label) + 1, np.uint32))
    draft = ("draft", "--no-preview", "--points")
    for name, labels in (("a.pcd.bin", "a.label"), ("a.pcd", "one_more.label"), ("a.npz", None), ("a.bin", None)):
        given = ["--labels", labels] if labels else []
        assert cli.main([*draft, name, *given, "-o", f"{name}.json"]) == 0
    assert Layout.load("a.bin.json") == Layout.load("a.npz.json") == Layout.load("a.pcd.json")
    higher = Sensor.preset("hdl32e").mount_height - Sensor.preset("hdl64e").mount_height
    roads = [part.center[2] for part in Layout.load("a.pcd.bin.json") if part.label == "road"]
    np.testing.assert_allclose(roads, higher, atol=0.02)
    assert "a.xyz: a recorded scan is one of .bin, .pcd.bin, .pcd, .ply, .npz, .npy, .las" in refused(
        *draft, "a.xyz", "-o", "b.json"
    )


def test_a_sketch_is_read_and_what_is_ignored_is_said(capsys: pytest.CaptureFixture[str]) -> None:
    shapes = '<rect id="car" x="45" y="30" width="4" height="8"/><text>a car</text>'
    Path("a.svg").write_text(f'<svg width="100" height="100">{shapes}</svg>')
    draft = ["draft", "--no-preview", "-o", "layout.json", "--sketch"]
    assert cli.main([*draft, "a.svg", "--metres-per-pixel", "0.5"]) == 0
    captured = capsys.readouterr()
    bare = "no street around it: it has no road under the ego vehicle that could be followed"
    assert captured.err == f"lidardraft: a.svg: ignored: text: not read\nlidardraft: a.svg: {bare}\n"
    (box,) = Layout.load("layout.json").boxes()
    np.testing.assert_allclose(box.center[:2], (8, 1.5), atol=0.05)
    pixels = np.full((100, 100, 3), 255, np.uint8)
    pixels[30:38, 45:49] = (0, 0, 142)
    pixels[90:92, 10:30] = 0
    Image.fromarray(pixels).save("a.png")
    assert cli.main([*draft, "a.png", "--scale-bar", "10"]) == 0
    (box,) = Layout.load("layout.json").boxes()
    np.testing.assert_allclose(box.center[:2], (8, 1.5), atol=0.05)


def test_what_is_wrong_with_a_sketch(refused: Callable[..., str]) -> None:
    draft = ("draft", "-o", "layout.json", "--sketch")
    assert "a.png: No such file" in refused(*draft, "a.png")
    Image.new("RGB", (50, 50), "white").save("a.png")
    assert "a.png: a painted sketch needs metres_per_pixel (--metres-per-pixel)" in refused(*draft, "a.png")
    assert "metres_per_pixel is -1.0" in refused(*draft, "a.png", "--metres-per-pixel", "-1")


def test_boxes_are_read_from_the_height_of_their_sensor() -> None:
    """That of --sensor, or of the sensor that a scan was written with, which lies beside its boxes."""
    box = Box("car_1", "car", 1, (9.0, 2.0, -0.9), (4.0, 2.0, 1.6), 0.5)
    write_boxes("scan.boxes.json", [box], [30])
    draft = ["draft", "--boxes", "scan.boxes.json", "--surroundings", "bare", "-o", "layout.json"]
    assert cli.main([*draft, "--sensor", "small.json"]) == 0
    (read,) = Layout.load("layout.json").boxes()
    np.testing.assert_allclose(read.center, (9.0, 2.0, -0.9 + Sensor.load("small.json").mount_height))
    assert (read.size, read.yaw) == (box.size, box.yaw)
    high = Sensor(name="high", elevations=(0.0, -0.1), columns=64, mount_height=3.0)
    Path("scan.sensor.json").write_text(high.to_json())
    assert cli.main([*draft, "--sensor", "small.json"]) == 0
    np.testing.assert_allclose(Layout.load("layout.json").boxes()[0].center, (9.0, 2.0, 2.1))


def test_what_is_wrong_with_boxes(refused: Callable[..., str]) -> None:
    draft = ("draft", "-o", "layout.json", "--boxes", "a.json")
    write_boxes("a.json", [], [])
    assert "a.json: there are 0 boxes" in refused(*draft)
    write_boxes("a.json", [Box("flat", "car", 1, (9.0, 0.0, 0.0), (4.0, 2.0, 0.0), 0.0)], [3])
    assert "a.json: flat: size is [4.0, 2.0, 0.0]; every extent must be >= 1e-06 m" in refused(*draft)


@cache
def two_cars() -> RenderedPicture:
    """A rendered picture of two cars on a road."""
    road = Primitive(shape="plane", center=(0, 0, 0), size=(200, 60, 0), label="road", id="road")
    cars = (
        Primitive(shape="box", center=(x, y, 0.75), size=(4, 1.8, 1.5), label="car", id=f"car_{k}", instance=k)
        for k, (x, y) in enumerate([(12, 2), (18, -3)], start=1)
    )
    return render(Layout((road, *cars)), Pinhole.from_hfov(math.radians(80), 640, 400))


@pytest.fixture
def photo(folder: Path) -> list[str]:
    """Options for a rendered picture of two cars with the files of its depth and its train ids."""
    picture = two_cars()
    Image.fromarray(picture.pixels).save(folder / "photo.png")
    np.save(folder / "depth.npy", picture.depth * 1.1)
    train_ids = np.array([10, 0, *[255] * 11, 13], dtype=np.uint8)  # of none, road and car
    Image.fromarray(train_ids[picture.labels]).save(folder / "classes.png")
    return ["--image", "photo.png", "--depth", "depth.npy", "--semantics", "classes.png"]


def test_a_picture_with_its_depth_and_classes_is_read(photo: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    bare = ["--surroundings", "bare"]
    assert cli.main(["draft", *photo, "--hfov", "80", *bare, "--no-preview", "-o", "layout.json"]) == 0
    said = "lidardraft: photo.png: depth times 0.91, so that the camera is 1.65 m over the road\n"
    assert capsys.readouterr().err == said
    layout = Layout.load("layout.json")
    assert layout.coverage == pytest.approx([-math.radians(40), math.radians(40)])
    centers = sorted(box.center[:2] for box in layout.boxes())
    np.testing.assert_allclose(centers, [(12, 2), (18, -3)], atol=0.5)
    high = ["--hfov", "80", "--camera-height", "1.8", *bare, "--sensor", "small.json", "-o", "out"]
    assert cli.main(["simulate", *photo, *high]) == 0
    assert "so that the camera is 1.8 m over the road" in capsys.readouterr().err
    (scan,) = Path("out").glob("*.layout.json")
    centers = sorted(box.center[:2] for box in Layout.load(scan).boxes())
    np.testing.assert_allclose(centers, np.array([(12, 2), (18, -3)]) * 1.8 / 1.65, atol=0.6)


def test_masks_and_the_camera_of_a_picture_are_read_from_files(photo: list[str]) -> None:
    camera = Pinhole.from_hfov(math.radians(80), 640, 400)
    four = f"{camera.fx},{camera.fy},{camera.cx},{camera.cy}"
    Path("calib.txt").write_text(f"P2: {camera.fx} 0 {camera.cx} 0 0 {camera.fy} {camera.cy} 0 0 0 1 0")
    car = np.asarray(Image.open("classes.png")) == 13
    np.savez("masks.npz", masks=np.stack([car & (np.arange(640) < 320), car & (np.arange(640) >= 320)]))
    for number, intrinsics in enumerate((four, "calib.txt")):
        given = ["--intrinsics", intrinsics, "--masks", "masks.npz", "--no-preview", "-o", f"layout_{number}.json"]
        assert cli.main(["draft", *photo, *given, "--surroundings", "bare"]) == 0
    layout = Layout.load("layout_0.json")
    assert layout == Layout.load("layout_1.json")
    assert len(layout.boxes()) == 2


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--intrinsics", "1,2,3"], "--intrinsics is '1,2,3'; it must be FX,FY,CX,CY"),
        (["--intrinsics", "9,9,9000,9"], "the principal point (9000, 9) lies outside the picture"),
        (["--intrinsics", "none.json"], "none.json: No such file"),
        (["--intrinsics", "700,700,320,200", "--hfov", "80"], "intrinsics and hfov both set the focal length"),
        (["--hfov", "80", "--masks", "none.npz"], "none.npz: No such file"),
        (["--hfov", "80", "--masks", "depth.npy"], "depth.npy: it holds float32 [400, 640]; masks are bool"),
    ],
)
def test_masks_and_intrinsics_that_cannot_be(
    photo: list[str], refused: Callable[..., str], options: list[str], said: str
) -> None:
    assert said in refused("draft", *photo, *options, "-o", "layout.json")


def test_what_is_wrong_with_a_picture(photo: list[str], refused: Callable[..., str]) -> None:
    draft = ("draft", "-o", "layout.json", *photo)
    assert "photo.png: the picture has no focal length; give hfov (--hfov)" in refused(*draft)
    for degrees in ("0", "200"):
        assert f"hfov is {math.radians(float(degrees))} rad ({degrees} degrees)" in refused(*draft, "--hfov", degrees)
    np.save("depth.npy", np.ones((3, 3)))
    assert "photo.png: depth has shape [3, 3]" in refused(*draft, "--hfov", "80")
    Path("depth.npy").write_bytes(b"no array")
    assert "depth.npy: not a whole .npy file" in refused(*draft, "--hfov", "80")
    Image.fromarray(np.full((9, 9), 33, np.uint8)).save("classes.png")
    assert "classes.png: 33 at row 0, column 0 is not a train id" in refused(
        "draft", *photo[:2], *photo[4:], "-o", "a.json"
    )
    plain = ["draft", "--image", "plain.png", "--hfov", "80", "-o", "layout.json"]
    Image.new("RGB", (64, 64), (9, 9, 9)).save("plain.png")
    assert "plain.png: the picture is of one colour" in refused(*plain)
    Path("plain.png").unlink()
    assert "plain.png: No such file" in refused(*plain)


def test_a_blender_script_is_read_and_what_is_passed_over_is_said(capsys: pytest.CaptureFixture[str]) -> None:
    Path("scene.py").write_text(SCRIPT + "bpy.ops.render.render()\nopen_ = 5\n")
    assert cli.main(["draft", "--blender", "scene.py", "--class", "Blob=car", "-o", "layout.json"]) == 0
    captured = capsys.readouterr()
    assert captured.err == "lidardraft: scene.py: line 4: bpy.ops.render.render is passed over\n"
    assert captured.out.splitlines()[0] == "layout.json: shapes: 1, objects with a box: 1"
    arguments = ["--blender", "scene.py", "--class", "Blob=car", "--sensor", "small.json"]
    assert cli.main(["raycast", *arguments, "-o", "image.npz"]) == 0
    assert cli.main(["simulate", *arguments, "-o", "scans"]) == 0


def test_what_is_wrong_with_a_blender_script(refused: Callable[..., str]) -> None:
    draft = ("draft", "-o", "layout.json", "--blender", "scene.py")
    Path("scene.py").write_text(SCRIPT)
    assert "scene.py: no class for Blob (line 2); say which by --class" in refused(*draft, "--strict")
    assert "did you mean 'car'?" in refused(*draft, "--class", "Blob=carr")
    Path("scene.py").write_text("import bpy\nimport os\nos.system('ls')\n")
    assert "scene.py: line 3: os.system is not supported" in refused(*draft)


def test_what_a_sentence_became_is_explained(capsys: pytest.CaptureFixture[str]) -> None:
    text = "a black car ahead, a wibble"
    assert cli.main(["draft", "--text", text, "--explain", "--no-preview", "-o", "a.json"]) == 0
    said = capsys.readouterr().err
    assert "a black car  car [0]: 1, in front, dark paint" in said
    assert "a wibble     not understood\n" in said
    assert "\\n" not in said


def test_strict_refuses_a_sentence_whose_scene_is_another(
    refused: Callable[..., str], capsys: pytest.CaptureFixture[str]
) -> None:
    draft, line = (
        ("draft", "--no-preview", "-o", "a.json"),
        "the sentence names 1 motorcycle; the scene has motorcycle: 2",
    )
    text = ("--text", "two people on a motorbike ahead")
    assert f"{line}; rephrase it; --llm-url takes free text" in refused(*draft, *text, "--strict")
    assert cli.main([*draft, *text]) == 0
    assert capsys.readouterr().err == f"lidardraft: {line}\n"
    assert cli.main([*draft, "--text", "two cars ahead", "--strict"]) == 0


def test_what_is_drafted_is_read_again(capsys: pytest.CaptureFixture[str]) -> None:
    source = ["--text", "two cars ahead, a house on the left", "--no-preview"]
    assert cli.main(["draft", *source, "-o", "a.json"]) == 0
    for ending, option in ((".py", "--blender"), (".glb", "--glb"), (".obj", "--obj")):
        assert cli.main(["draft", *source, "-o", f"a{ending}"]) == 0
        assert cli.main(["draft", option, f"a{ending}", "--no-preview", "-o", f"back{ending}.json"]) == 0
    layout = Layout.load("a.json")
    assert Layout.load("back.py.json") == layout
    assert [p.id for p in Layout.load("back.glb.json")] == [p.id for p in layout]
    assert [p.label for p in Layout.load("back.obj.json")] == [p.label for p in layout]
    assert "passed over" not in capsys.readouterr().err


def test_a_scan_is_labelled_by_a_segmenter_and_drafted_for_hands(refused: Callable[..., str]) -> None:
    torch.manual_seed(0)
    segmenter = Segmenter(SegmenterConfig(grid=SphericalGrid(rows=16, columns=64), widths=(8, 8)))
    with torch.no_grad():
        segmenter.head.weight *= 30  # so that it is sure of most points
    weight_file.save(segmenter, "segmenter.safetensors", {})
    random = np.random.default_rng(0)
    points = random.uniform((2, -8, -2), (20, 8, 1), (800, 3)).astype(np.float32)
    kitti.write_bin("scan.bin", points, np.zeros(len(points), np.float32))
    scan = ["draft", "--points", "scan.bin", "--segmenter", "segmenter.safetensors", "-o", "layout.json"]
    assert cli.main([*scan, "--detail", "objects"]) == 0
    points, intensity = kitti.read_bin("scan.bin")
    labels = weight_file.load("segmenter.safetensors", Segmenter).label_points(points, intensity, 1.73, least=0.5)
    assert Layout.load("layout.json") == layout_from_cloud(points, labels, detail="objects")
    assert "--labels and --segmenter both give the classes" in refused(*scan, "--labels", "scan.label")


def test_a_scan_without_labels_is_labelled_by_the_packaged_segmenter(capsys: pytest.CaptureFixture[str]) -> None:
    street = simulate(
        layout_from_text("two cars ahead, a building on the left", seed=0), Sensor.preset("hdl64e"), seed=0
    )
    street.save("street")
    Path("street.label").unlink()
    assert cli.main(["draft", "--points", "street.bin", "-o", "layout.json", "--no-preview"]) == 0
    said = capsys.readouterr().err
    assert "street.bin has no labels: the packaged segmenter predicted them, with a mean probability of 0." in said
    assert {"car", "road", "building"} <= {each.label for each in Layout.load("layout.json")}


def test_a_scan_and_labels_that_do_not_fit_are_both_named(refused: Callable[..., str]) -> None:
    kitti.write_bin("a.bin", np.ones((3, 3), np.float32), np.ones(3, np.float32))
    Path("b.label").write_bytes(bytes(8))
    said = refused("draft", "--points", "a.bin", "--labels", "b.label", "-o", "layout.json")
    assert "a.bin" in said
    assert "b.label has 8 bytes" in said


def test_points_that_cannot_be_are_not_put_down_to_their_labels(refused: Callable[..., str]) -> None:
    kitti.write_bin("a.bin", np.array([[5000, 0, 0], [1, 2, 3]], np.float32), np.ones(2, np.float32))
    Path("b.label").write_bytes(np.array([10, 10], "<u4").tobytes())
    assert "a.bin" in refused("draft", "--points", "a.bin", "--labels", "b.label", "-o", "layout.json")


@pytest.mark.parametrize(
    ("option", "file", "said"),
    [
        ("obj", "a.png", "; .png is read by --image or --sketch"),
        ("image", "a.obj", "; .obj is read by --obj"),
        ("layout", "a.glb", "; .glb is read by --glb"),
        ("points", "a.PY", "; .py is read by --blender"),
        ("sketch", "a.pcd", "; .pcd is read by --points"),
    ],
)
def test_a_file_of_another_kind_says_which_option_reads_it(
    option: str, file: str, said: str, refused: Callable[..., str]
) -> None:
    Path(file).write_text("a")
    assert refused("draft", f"--{option}", file, "-o", "layout.json").endswith(f"{said}\n")


def test_a_scan_that_makes_no_shape_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    kitti.write_bin("a.bin", np.array([[9, 1, 1], [30, 2, 1]], np.float32), np.ones(2, np.float32))
    Path("a.label").write_bytes(np.array([10, 10], "<u4").tobytes())
    assert cli.main(["draft", "--points", "a.bin", "--sensor", "small.json", "-o", "layout.json"]) == 0
    assert "the 2 points show no ground and no object" in capsys.readouterr().err


def test_depth_may_be_left_as_it_is(photo: list[str], refused: Callable[..., str]) -> None:
    words = ["draft", *photo, "--hfov", "80", "--no-preview", "-o", "layout.json", "--metric-depth"]
    assert cli.main(words) == 0
    layout = Layout.load("layout.json")
    found = layout.provenance
    assert layout.notes[0] == f"depth times 1.00, so that the camera is {found['sensor_height']:g} m over the road"
    assert (found["scale"], found["sensor_height"]) == (1.0, pytest.approx(1.1 * 1.65, abs=0.02))
    assert "both set the scale" in refused(*words, "--camera-height", "2")


@pytest.fixture
def options() -> dict[str, str]:
    """A picture of 4 x 6 pixels with all that can be said of it; nothing is to be seen in it."""
    Image.fromarray(np.arange(72, dtype=np.uint8).reshape(4, 6, 3)).save("a.png")
    np.save("depth.npy", np.full((4, 6), 9.0))
    np.save("classes.npy", np.full((4, 6), 2))
    np.save("masks.npy", np.ones((4, 6), np.uint8))
    Path("camera.json").write_text("[5, 5, 3, 2]")
    files = {"semantics": "classes.npy", "depth": "depth.npy", "masks": "masks.npy", "intrinsics": "camera.json"}
    return {"image": "a.png", **files}


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("depth", np.ones((5, 6))),
        ("semantics", np.full((4, 7), 2)),
        ("masks", np.ones((3, 6), np.uint8)),
        ("intrinsics", "[-5, 5, 3, 2]"),
    ],
)
def test_the_file_that_does_not_fit_is_named(
    name: str, content: object, options: dict[str, str], refused: Callable[..., str]
) -> None:
    if isinstance(content, str):
        Path(options[name]).write_text(content)
    else:
        np.save(options[name], content)
    words = [word for option, file in options.items() for word in (f"--{option}", file)]
    assert f"--{name} {options[name]}" in refused("draft", *words, "-o", "layout.json")
