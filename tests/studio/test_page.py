"""The studio in a real browser: what a visitor types, drags, drops, plays and keeps."""

from __future__ import annotations

import io
import json
import re
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from chromium import CHROMIUM, SIZE, chromium, handle_of, pixel_of, until
from lidardraft import Layout, Scan, Sensor, WorldState, layout_from_text
from lidardraft.cli.studio import inputs_of

pytest.importorskip("viser", reason="viser is not installed (lidardraft[studio])")
from lidardraft.studio.editor import Editor
from lidardraft.studio.page import SENTENCE
from lidardraft.studio.server import Studio, served

SENSOR = Sensor.preset("vlp16")
FIRST = layout_from_text("a car ahead, a parked bus on the right, a tree on the left", seed=3)


class Visitor:
    """A page of a studio, and the session behind it."""

    def __init__(self, browser: Any, studio: Studio) -> None:
        before = set(studio.sessions)
        self.context = browser.new_context(viewport=SIZE)
        self.page = self.context.new_page()
        self.page.goto(studio.url)
        self.page.wait_for_selector("text=returns", timeout=30_000)
        (name,) = set(studio.sessions) - before
        self.session = studio.sessions[name]
        self.editor = self.session.editor
        self.session.join()

    def tab(self, name: str) -> None:
        self.page.get_by_role("tab", name=name).click()

    def press(self, name: str) -> None:
        self.page.get_by_role("button", name=name, exact=True).first.click()

    def says(self, text: str) -> None:
        self.page.get_by_text(text).first.wait_for(timeout=20_000)

    def draft(self, sentence: str) -> None:
        self.tab("Scene")
        self.page.locator("textarea").first.fill(sentence)
        self.press("Make the scene")

    def drop(self, file: Path | dict[str, Any], number: int = 0) -> None:
        self.page.locator("input[type=file]").nth(number).set_input_files(file)

    def choose(self, label: str, option: str) -> None:
        box = self.page.get_by_label(label, exact=True).first
        box.click()
        box.fill(option)
        self.page.get_by_role("option", name=option, exact=True).first.click()

    def names(self) -> set[str]:
        return set(self.editor.names)


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    pytest.importorskip("playwright", reason="playwright is not installed (lidardraft[dev])")
    if CHROMIUM is None:
        pytest.skip("there is no Chromium; install the package chromium")
    with chromium() as running:
        yield running


@pytest.fixture(scope="module")
def studio() -> Iterator[Studio]:
    with served(lambda: Editor(FIRST, (SENSOR,), seed=3), inputs_of("vlp16", None), 8490) as running:
        yield running


@pytest.fixture(scope="module")
def visitor(browser: Any, studio: Studio) -> Visitor:
    return Visitor(browser, studio)


@pytest.fixture(autouse=True)
def first_scene(visitor: Visitor) -> None:
    """Each test begins with the same scene, and the same page."""
    visitor.session.post(lambda one: one.editor.begin(FIRST, 3))
    visitor.session.post(lambda one: one.look_at(hidden=frozenset(), layout=False, labels=False))
    visitor.session.post(lambda one: one.select("car_1"))
    visitor.session.join()
    visitor.tab("Scene")


def test_a_sentence_is_typed_and_scanned_and_what_was_not_understood_is_said(visitor: Visitor) -> None:
    visitor.draft("two trucks ahead and a flibbertigibbet")
    visitor.says("flibbertigibbet")
    until(lambda: "truck_2" in visitor.names())
    visitor.draft("qwertz")
    visitor.says("This did not work")
    assert "truck_2" in visitor.names()


def test_a_car_is_dragged_with_the_mouse_and_its_points_move_and_come_back(visitor: Visitor) -> None:
    def middle() -> np.ndarray:
        (scan,) = visitor.editor.scans()
        number = next(part.instance for part in scan.layout if part.id.startswith("car_1"))
        frame = visitor.session.frame()
        is_car = scan.image.instance[frame.pixels[:, 1], frame.pixels[:, 2]] == number
        assert is_car.sum() > 5
        return frame.points[is_car].mean(axis=0)

    mouse, before, pose = visitor.page.mouse, middle(), visitor.editor.world["car_1"].pose
    x, y = handle_of(visitor.session)
    mouse.move(x, y)
    visitor.page.wait_for_timeout(300)
    mouse.down()
    for k in range(1, 6):
        mouse.move(x + 6 * k, y - 4 * k)
    until(lambda: visitor.session.is_dragging)
    mouse.up()
    until(lambda: not visitor.session.is_dragging)
    visitor.session.join()
    moved = visitor.editor.world["car_1"].pose
    assert np.hypot(moved[0] - pose[0], moved[1] - pose[1]) > 0.3
    np.testing.assert_allclose((middle() - before)[:2], np.subtract(moved, pose)[:2], atol=0.8)
    visitor.press("Undo")
    until(lambda: visitor.editor.world["car_1"].pose == pose)
    visitor.session.join()
    np.testing.assert_allclose(middle(), before)


SCRIPT = """import bpy
bpy.ops.mesh.primitive_cube_add(size=1, location=(9, 2, 0.75), scale=(4.2, 1.8, 1.5))
bpy.context.object.name = "Car"
"""
OBJ = "o car\nv 8 1 0\nv 12 1 0\nv 12 3 0\nv 8 3 0\nv 8 1 1.5\nv 12 1 1.5\nv 12 3 1.5\nv 8 3 1.5\n" + "".join(
    f"f {face}\n" for face in ("1 4 3 2", "5 6 7 8", "1 2 6 5", "2 3 7 6", "3 4 8 7", "4 1 5 8")
)
SKETCH = (
    '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 60 40" width="60" height="40">'
    '<rect id="road" x="0" y="14" width="60" height="12"/><rect id="car" x="40" y="16" width="4" height="2"/>'
    '<line id="scale 10 m" x1="0" y1="39" x2="10" y2="39"/></svg>'
)


def files(folder: Path) -> dict[str, bytes]:
    layout = layout_from_text("a bus ahead", seed=1)
    editor = Editor(layout, (SENSOR,))
    (scan,) = editor.scans()
    scan.save(folder / "one", picture=False)
    np.savez(folder / "points.npz", xyz=scan.points(), label=scan.labels())
    return {
        "a.layout.json": layout.to_json().encode(),
        "a.world.json": editor.world.state().to_json().encode(),
        "a.boxes.json": (folder / "one.boxes.json").read_bytes(),
        "a.npz": (folder / "points.npz").read_bytes(),
        "a.py": SCRIPT.encode(),
        "a.obj": OBJ.encode(),
        "a.svg": SKETCH.encode(),
    }


@pytest.mark.filterwarnings("default:the layout has no ground")  # a model may be of a car alone
def test_each_input_is_dropped_and_a_broken_one_is_a_message(visitor: Visitor, tmp_path: Path) -> None:
    wanted = {"a.layout.json": "bus_1", "a.world.json": "bus_1", "a.py": "Car", "a.obj": "car", "a.svg": "car_1"}
    for name, content in files(tmp_path).items():
        document = visitor.editor.document
        visitor.drop({"name": name, "mimeType": "application/octet-stream", "buffer": content})
        until(lambda document=document: visitor.editor.document is not document)
        visitor.session.join()
        assert name not in wanted or wanted[name] in visitor.names(), (name, visitor.names())
        assert (len(visitor.session.recorded) > 0) == (name == "a.npz")
    document = visitor.editor.document
    broken = {"a.layout.json": b"{", "a.npz": b"PK", "../../etc/a.obj": b"f 1 2 3\n", "a.py": b"while", "a.xyz": b"1"}
    for name, content in broken.items():
        visitor.drop({"name": name, "mimeType": "application/octet-stream", "buffer": content})
        visitor.page.get_by_text(Path(name).name).first.wait_for(timeout=10_000)
    visitor.session.join()
    assert visitor.editor.document is document
    assert "/tmp" not in visitor.page.inner_text("body")


def test_colours_classes_boxes_and_shapes_are_chosen_and_a_point_is_clicked(visitor: Visitor) -> None:
    visitor.tab("Look")
    visitor.choose("Colours", "range")
    until(lambda: visitor.session.look.colour == "range")
    visitor.says("80 m")
    frame = visitor.session.frame()
    (scan,) = frame.scans
    number = next(part.instance for part in scan.layout if part.id.startswith("bus_1"))
    is_bus = scan.image.instance[frame.pixels[:, 1], frame.pixels[:, 2]] == number
    camera, mouse = visitor.session.page.client.camera, visitor.page.mouse
    points = frame.points[is_bus]
    middle = points[np.argmin(np.linalg.norm(points - np.median(points, axis=0), axis=1))]
    mouse.click(*pixel_of(camera, middle))
    visitor.says("Row ")
    until(lambda: visitor.session.selected == "bus_1")
    visitor.page.get_by_text("Classes").first.click()
    visitor.page.get_by_label("bus", exact=True).click()
    until(lambda: visitor.session.look.hidden)
    visitor.session.join()
    assert not any(box.label == "bus" for box in visitor.session.frame().boxes())
    for name in ("Labels", "Layout"):
        visitor.page.get_by_label(name, exact=True).first.click()
        until(lambda name=name: getattr(visitor.session.look, name.lower()))


def test_things_are_added_changed_and_removed(visitor: Visitor) -> None:
    visitor.choose("New", "van")
    visitor.press("Add it")
    until(lambda: "van_1" in visitor.names() and visitor.session.selected == "van_1")
    visitor.press("Duplicate")
    until(lambda: "van_2" in visitor.names())
    visitor.press("Delete")
    until(lambda: "van_2" not in visitor.names())
    visitor.choose("Object", "bus_1")
    until(lambda: visitor.session.selected == "bus_1")
    visitor.choose("Make it a", "tram")
    until(lambda: visitor.session.join() or visitor.editor.box("bus_1").label == "train")


def test_another_sensor_and_weather_are_chosen(visitor: Visitor) -> None:
    visitor.tab("Sensor")
    visitor.choose("Sensor", "os1-32")
    until(lambda: visitor.editor.document.sensors[0].name == "os1-32")
    visitor.choose("Beside it", "vlp16")
    until(lambda: len(visitor.editor.document.sensors) == 2)
    visitor.choose("Weather", "fog")
    until(lambda: visitor.editor.document.weather is not None)
    visitor.says("os1-32 and vlp16")
    own = Sensor(name="mine", elevations=(0.0, -0.1), columns=180).to_json().encode()
    visitor.drop({"name": "m.sensor.json", "mimeType": "application/json", "buffer": own}, 1)
    until(lambda: visitor.editor.document.sensors[0].name == "mine")
    visitor.session.post(lambda one: one.editor.equip((SENSOR,), None))


def test_time_runs_stands_and_is_gone_back_in_while_an_actor_is_commanded(visitor: Visitor) -> None:
    visitor.tab("Play")
    visitor.press("Run")
    until(lambda: visitor.editor.world.time > 0.5)
    visitor.press("Stop")
    until(lambda: visitor.editor.world["car_1"].speed == 0.0)
    visitor.press("Seat")
    visitor.press("Pause")
    until(lambda: not visitor.session.is_running)
    visitor.session.join()
    end = visitor.editor.world.time
    visitor.page.get_by_role("slider").first.press("Home")
    until(lambda: visitor.editor.world.time < end)


def test_a_scan_is_downloaded_and_read_back(visitor: Visitor, tmp_path: Path) -> None:
    visitor.tab("Keep")
    with visitor.page.expect_download() as download:
        visitor.press("Save")
    zipfile.ZipFile(io.BytesIO(Path(download.value.path()).read_bytes())).extractall(tmp_path)
    ours = visitor.editor.scans()[0]
    assert Scan.load(tmp_path / "000000").points().tobytes() == ours.points().tobytes()
    with visitor.page.expect_download() as download:
        visitor.press("Command")
    visitor.says("lidardraft simulate")
    archive = zipfile.ZipFile(io.BytesIO(Path(download.value.path()).read_bytes()))
    state = WorldState.from_json(archive.read("studio.world.json").decode())
    assert Editor(state, (SENSOR,)).scans()[0].points().tobytes() == ours.points().tobytes()
    with visitor.page.expect_download() as download:
        visitor.press("Save the layout")
    assert len(Layout.from_json(Path(download.value.path()).read_text())) == len(FIRST)


def test_two_visitors_have_worlds_of_their_own_and_a_reload_keeps_it(
    visitor: Visitor, browser: Any, studio: Studio
) -> None:
    other = Visitor(browser, studio)
    other.draft("three people ahead")
    until(lambda: "person_3" in other.names())
    assert "person_3" not in visitor.names()
    other.session.join()
    x, y = handle_of(other.session)
    other.page.mouse.move(x, y)
    other.page.mouse.down()
    other.page.mouse.move(x + 9, y - 6)
    other.page.reload()  # while something is dragged
    other.page.wait_for_selector("text=returns", timeout=30_000)
    until(lambda: other.session.page is not None and not other.session.is_dragging)
    assert other.session in studio.sessions.values()
    assert "person_3" in other.names()
    assert len(studio.sessions) == 2
    other.context.close()
    until(lambda: other.session.page is None)


def test_the_page_outlives_a_server_that_is_killed_during_a_drag(browser: Any, studio: Studio) -> None:
    with served(lambda: Editor(FIRST, (SENSOR,), seed=3), inputs_of("vlp16", None), studio.port) as second:
        assert second.port != studio.port
        visitor = Visitor(browser, second)
        x, y = handle_of(visitor.session)
        visitor.page.mouse.move(x, y)
        visitor.page.mouse.down()
        visitor.page.mouse.move(x + 5, y - 5)
    visitor.page.mouse.move(x + 15, y - 9)
    visitor.page.mouse.up()
    visitor.page.wait_for_timeout(500)
    assert visitor.page.locator("canvas").count() >= 1
    assert re.search(r"[\d,]+ returns", visitor.page.inner_text("body"))
    visitor.context.close()


def test_examples_are_sentences_that_are_understood() -> None:
    assert not [note for note in layout_from_text(SENTENCE, seed=0).notes if note.startswith("not understood")]
    assert json.loads(FIRST.to_json())["primitives"]
