from collections.abc import Callable
from pathlib import Path

import laspy
import numpy as np
import pytest
from PIL import Image

from lidardraft import Layout, Primitive, RangeImage, Sensor, raycast
from lidardraft.cli import main as cli
from lidardraft.formats import kitti
from lidardraft.formats.pairs import Pair, write_pairs
from lidardraft.formats.ply import write_ply
from lidardraft.view import PALETTE

ROAD = Primitive(shape="plane", center=(0, 0, 0), size=(100, 8, 0), label="road", id="road")


def size(path: str) -> tuple[int, int]:
    with Image.open(path) as picture:
        return picture.size


@pytest.fixture
def image() -> RangeImage:
    return raycast(Layout((ROAD,)), Sensor.load("small.json"))


def test_layouts_and_range_images(image: RangeImage, capsys: pytest.CaptureFixture[str]) -> None:
    image.save("image.npz")
    Layout((ROAD,)).save("layout.json")
    assert cli.main(["view", "image.npz"]) == 0
    assert cli.main(["view", "layout.json", "--sensor", "small.json", "-o", "picture.png"]) == 0
    captured = capsys.readouterr()
    assert (captured.out, captured.err) == ("image.view.png\npicture.png\n", "")
    assert Path("image.view.png").stat().st_size > 1000
    assert Path("picture.png").stat().st_size > 1000


def test_the_sensor_of_a_scan_is_known_given_or_said(image: RangeImage, capsys: pytest.CaptureFixture[str]) -> None:
    points = image.points()
    kitti.write_bin("scan.bin", points, np.zeros(len(points), np.float32))
    assert cli.main(["view", "scan.bin", "-o", "guessed.png"]) == 0
    assert "scan.bin is taken for a scan of hdl64e; if it is not, give its --sensor\n" in capsys.readouterr().err
    assert cli.main(["view", "scan.bin", "--sensor", "small.json", "-o", "given.png"]) == 0
    Path("scan.sensor.json").write_text(image.sensor.to_json())
    assert cli.main(["view", "scan.bin", "-o", "known.png"]) == 0
    assert capsys.readouterr().err == ""
    assert Path("given.png").read_bytes() == Path("known.png").read_bytes() != Path("guessed.png").read_bytes()


def test_the_file_itself_is_not_replaced(image: RangeImage, refused: Callable[..., str]) -> None:
    image.save("image.npz")
    assert "image.npz is the input too" in refused("view", "image.npz", "-o", "image.npz")


def test_training_pairs(image: RangeImage, capsys: pytest.CaptureFixture[str]) -> None:
    list(write_pairs("pairs", [(Pair(image, image), {})] * 7))
    list(write_pairs("pairs", [(Pair(image, image), {})]))
    assert cli.main(["view", "pairs/00000.npz"]) == 0
    assert "holds 7 pairs; the picture shows the first 6" in capsys.readouterr().err
    assert cli.main(["view", "pairs/00001.npz"]) == 0
    (width, height), (one_width, one_height) = (size(f"pairs/0000{number}.view.png") for number in range(2))
    assert width == pytest.approx(2 * one_width, abs=10)  # two columns, three rows
    assert height == pytest.approx(3 * one_height, abs=20)


def test_bad_input_is_one_line(image: RangeImage, refused: Callable[..., str]) -> None:
    assert "there is no picture of .txt" in refused("view", "small.txt")
    assert "holds no scans" in refused("view", ".")
    image.save("image.npz")
    Path("film").mkdir()
    Path("film/000000.sensor.json").touch()
    for name in ("film.avi", "film.html"):
        assert f"{name} would hold a film; its name must end in .gif or .mp4" in refused("view", "film", "-o", name)
    assert "--boxes are for one file" in refused("view", "film", "--boxes", "a.boxes.json")
    assert "its name must end in .png or .html" in refused("view", "image.npz", "-o", "a.jpg")
    assert "--sensor is for" in refused("view", "image.npz", "--sensor", "hdl64e")
    list(write_pairs("pairs", [(Pair(image, image), {})]))
    Path("pairs/index.json").unlink()
    assert "index.json" in refused("view", "pairs/00000.npz")


def test_a_saved_scan_is_shown_with_its_boxes(capsys: pytest.CaptureFixture[str]) -> None:
    text = "a parked bus on the right, 8 m ahead"
    assert cli.main(["simulate", "--text", text, "--sensor", "small.json", "--carrier", "none", "-o", "out"]) == 0
    views = {}
    for name, options in {"boxes": [], "classes": ["--classes"], "large": ["--large"], "bare": []}.items():
        if name == "bare":
            Path("out/000000.boxes.json").unlink()
        assert cli.main(["view", "out/000000.bin", "-o", f"{name}.png", *options]) == 0
        views[name] = np.asarray(Image.open(f"{name}.png"))
    assert capsys.readouterr().err == ""
    edges = {name: (picture == PALETTE[15]).all(axis=2).sum() for name, picture in views.items()}
    assert min(edges["boxes"], edges["classes"]) > edges["bare"] + 100
    assert (views["boxes"] != views["classes"]).any()
    assert views["large"].shape == (900, 1800, 3)


def test_a_scan_becomes_a_page(capsys: pytest.CaptureFixture[str], refused: Callable[..., str]) -> None:
    text = "a parked bus on the right, 8 m ahead"
    assert (
        cli.main(
            ["simulate", "--text", text, "--sensor", "small.json", "--carrier", "none", "--no-picture", "-o", "out"]
        )
        == 0
    )
    for name in ("000000.bin", "000000.npz"):
        assert cli.main(["view", f"out/{name}", "-o", "scan.html"]) == 0
        page = Path("scan.html").read_text()
        assert '"id": "bus_1"' in page
        assert text in page
    Path("out/000000.boxes.json").rename("boxes.json")
    assert cli.main(["view", "out/000000.bin", "-o", "bare.html"]) == 0
    assert '"boxes": []' in Path("bare.html").read_text()
    assert cli.main(["view", "out/000000.bin", "--boxes", "boxes.json", "-o", "given.html"]) == 0
    assert '"id": "bus_1"' in Path("given.html").read_text()
    capsys.readouterr()
    said = refused("view", "out/000000.layout.json", "-o", "page.html")
    assert "000000.layout.json is not a scan; a page of HTML shows scans alone" in said


def test_a_page_knows_rows_and_columns_from_the_image_of_the_same_scan_alone() -> None:
    options = ["--sensor", "small.json", "--speed", "20", "--no-picture"]
    assert cli.main(["simulate", "--text", "a bus ahead", *options, "-o", "out"]) == 0
    assert cli.main(["simulate", "--text", "a wall on the left", *options, "-o", "other"]) == 0
    held = []
    for image in ("out/000000.npz", "other/000000.npz", None):
        if image is None:
            Path("out/000000.npz").unlink()
        else:
            Path("out/000000.npz").write_bytes(Path(image).read_bytes())
        assert cli.main(["view", "out/000000.bin", "-o", "scan.html"]) == 0
        page = Path("scan.html").read_text()
        held.append([name for name in ("range", "row", "column", "time", "instance") if f'["{name}", ' in page])
    assert held == [["range", "row", "column", "time", "instance"], *[["range", "instance"]] * 2]


@pytest.mark.parametrize("name", ["a.ply", "a.npy", "a.las"])
def test_clouds_of_other_formats_are_shown(image: RangeImage, name: str) -> None:
    points = image.points()
    if name == "a.npy":
        np.save(name, points)
    elif name == "a.ply":
        write_ply(name, points.view([(axis, "<f4") for axis in "xyz"])[:, 0])
    else:
        cloud = laspy.LasData(laspy.LasHeader(point_format=6, version="1.4"))
        cloud.xyz = points
        cloud.write(name)
    assert cli.main(["view", name, "--sensor", "small.json", "-o", "a.png"]) == 0
    assert Path("a.png").stat().st_size > 1000
