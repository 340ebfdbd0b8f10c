"""`lidardraft draft` and `raycast`."""

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from lidardraft import Layout, Primitive, RangeImage, Sensor, layout_from_text, simulate
from lidardraft.cli import main as cli
from lidardraft.scene import edit
from lidardraft.semantics import BY_NAME
from lidardraft.view import render_from_above, render_scan


def test_a_sentence_becomes_a_layout(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["draft", "--text", "a car ahead", "--seed", "0", "-o", "layout.json"]) == 0
    captured = capsys.readouterr()
    layout = Layout.load("layout.json")
    assert [box.id for box in layout.boxes() if not box.id.startswith("around/")] == ["car_1"]
    said, picture = captured.out.splitlines()
    assert said.startswith(
        f"layout.json: shapes: {len(layout)}, objects with a box: {len(layout.boxes())}, around it a"
    )
    assert "100% of the lines of sight are open" in said
    assert picture == "layout.preview.png: the layout from above, and a simulated scan of it"
    assert captured.err == ""
    bare = ["--surroundings", "bare", "--no-preview", "-o", "bare.json"]
    assert cli.main(["draft", "--text", "a car ahead", "--seed", "0", *bare]) == 0
    assert edit.remove(layout, "around/*").primitives == Layout.load("bare.json").primitives
    assert "around it" not in capsys.readouterr().out
    assert cli.main(["draft", "--layout", "bare.json", "--surroundings", "street", "-o", "again.json"]) == 0
    assert Layout.load("again.json").primitives == layout.primitives


def test_the_preview_shows_the_layout_and_a_scan_of_the_asked_sensor() -> None:
    assert (
        cli.main(
            ["draft", "--text", "a car ahead", "--sensor", "small.json", "--surroundings", "bare", "-o", "layout.py"]
        )
        == 0
    )
    picture = np.asarray(Image.open("layout.py.preview.png"))
    assert picture.shape[1] > picture.shape[0]
    layout = layout_from_text("a car ahead", seed=0)
    above = render_from_above(layout)
    shown = picture[40 : len(above), : above.shape[1]]  # below the caption
    np.testing.assert_array_equal(shown, above[40:])
    small = Sensor.load("small.json")
    scan = render_scan(simulate(layout, small).image, small.pose(), by_label=True)
    np.testing.assert_array_equal(picture[40 : len(scan), -scan.shape[1] :], scan[40:])


def test_no_preview_is_written_if_none_is_asked_for(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["draft", "--text", "a car ahead", "--no-preview", "-o", "layout.json"]) == 0
    assert not list(folder.glob("*.png"))
    assert "preview" not in capsys.readouterr().out


def test_a_layout_without_ground_is_previewed_without_a_word(capsys: pytest.CaptureFixture[str]) -> None:
    Layout((Primitive(shape="box", center=(9, 0, 1), size=(4, 2, 2), label="car", id="car"),)).save("a.json")
    assert cli.main(["draft", "--layout", "a.json", "--sensor", "small.json", "-o", "b.json"]) == 0
    assert Layout.load("b.json") == Layout.load("a.json")
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(
    ("ending", "begins"),
    [("json", b'{"schema": "lidardraft.layout/2"'), ("obj", b"# a layout"), ("GLB", b"glTF"), ("py", b'"""A layout')],
)
def test_each_ending_is_its_format(ending: str, begins: bytes) -> None:
    assert cli.main(["draft", "--text", "a car ahead", "--no-preview", "-o", f"a.{ending}"]) == 0
    assert Path(f"a.{ending}").read_bytes().startswith(begins)


def test_the_ending_says_the_format_before_anything_is_made(refused: Callable[..., str]) -> None:
    for path in ("layout", "layout.txt", "layout.blend"):
        said = refused("draft", "--text", "a car ahead", "-o", path)
        assert f"{path}: a layout is written as .json, .obj, .glb, .py; the ending decides" in said


def test_a_layout_that_cannot_be_simulated_replaces_nothing(refused: Callable[..., str]) -> None:
    far = Primitive(shape="box", center=(1e9, 1e9, 1e9), size=(1e9, 1e9, 1e9), label="car", id="car_1", instance=1)
    Layout((far,)).save("far.json")
    Path("layout.json").write_text("older")
    said = refused("draft", "--layout", "far.json", "-o", "layout.json")
    assert "far.json: no preview can be made (--no-preview leaves it out)" in said
    assert cli.main(["draft", "--layout", "far.json", "-o", "layout.json", "--no-preview"]) == 0


def test_no_older_preview_stays_beside_another_layout(capsys: pytest.CaptureFixture[str]) -> None:
    many = (Primitive(shape="box", center=(9, k, 1), size=(1, 1, 1), label="building", id=f"b{k}") for k in range(2001))
    Layout(tuple(many)).save("many.json")
    assert cli.main(["draft", "--text", "a car ahead", "--sensor", "small.json", "-o", "layout.json"]) == 0
    assert Path("layout.preview.png").exists()
    assert cli.main(["draft", "--layout", "many.json", "-o", "layout.json"]) == 0
    assert not Path("layout.preview.png").exists()
    assert "and the older one is removed" in capsys.readouterr().err


def test_the_input_is_not_replaced(refused: Callable[..., str]) -> None:
    assert cli.main(["draft", "--text", "a car ahead", "-o", "a.obj", "--no-preview"]) == 0
    os.link("a.obj", "b.obj")
    for name in ("a.obj", "b.obj"):
        assert f"{name} is the input too" in refused("draft", "--obj", "a.obj", "-o", name)


def test_layouts_of_one_name_keep_their_previews(folder: Path) -> None:
    for ending in ("json", "glb", "py"):
        assert cli.main(["draft", "--text", "a car ahead", "--sensor", "small.json", "-o", f"x.{ending}"]) == 0
    assert {path.name for path in folder.glob("x*.png")} == {
        *("x.preview.png", "x.glb.preview.png", "x.py.preview.png")
    }


def test_layouts_and_sentences_are_cast() -> None:
    assert cli.main(["draft", "--text", "a car ahead", "--seed", "3", "-o", "layout.json"]) == 0
    assert cli.main(["raycast", "--layout", "layout.json", "-o", "layout.npz"]) == 0
    assert cli.main(["raycast", "--text", "a car ahead", "--seed", "3", "-o", "sentence.npz"]) == 0
    image, same = RangeImage.load("layout.npz"), RangeImage.load("sentence.npz")
    assert image.sensor == Sensor.preset("hdl64e")
    assert BY_NAME["car"].id in image.label
    np.testing.assert_array_equal(image.depth, same.depth)


def test_bad_input_of_raycast_is_one_line(refused: Callable[..., str]) -> None:
    assert "nowhere.json" in refused("raycast", "--layout", "nowhere.json", "-o", "a.npz")
    Path("broken.json").write_text('{"schema": ')
    assert "broken.json: not JSON" in refused("raycast", "--layout", "broken.json", "-o", "a.npz")
    sensor = refused("raycast", "--text", "a car ahead", "--sensor", "hdl65e", "-o", "a.npz")
    assert "did you mean 'hdl64e'?" in sensor
