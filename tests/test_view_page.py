"""The page of a scan in a real Chromium, whose pictures are drawn by software."""

import io
import shutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from lidardraft import Layout, Primitive, Scan, Sensor, simulate, view
from lidardraft.drawing import Eye

pytest.importorskip("playwright.sync_api", reason="playwright, of the development extra, is missing")
from playwright.sync_api import Browser, sync_playwright

CHROMIUM = shutil.which("chromium") or shutil.which("google-chrome")
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="there is no Chromium")
WIDTH, HEIGHT = 700, 800
CAR_BLUE, BUS_CYAN = view.PALETTE[13], view.PALETTE[15]


def box(label: str, number: int, x: float, y: float, height: float = 1.5) -> Primitive:
    center, size = (x, y, height / 2), (4, 2, height)
    return Primitive(shape="box", center=center, size=size, label=label, id=f"{label}_1", instance=number)


ROAD = Primitive(shape="plane", center=(0, 0, 0), size=(100, 8, 0), label="road", id="road")
WALL = Primitive(shape="box", center=(20, 0, 2), size=(1, 30, 4), label="building", id="wall")
LAYOUT = Layout((ROAD, WALL, box("car", 1, 10, 0), box("person", 2, 8, 4), box("bus", 3, 26, 0, 3.0)))


@pytest.fixture(scope="module")
def scan() -> Scan:
    return simulate(LAYOUT, replace(Sensor.preset("vlp16"), columns=450), speed=9.0)


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    drawn_by_software = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=CHROMIUM, args=drawn_by_software)
        yield chromium
        chromium.close()


class Opened:
    """A page that is open, and what was wrong in it."""

    focal = 1.1 * (WIDTH * HEIGHT) ** 0.5  # pixels

    def __init__(self, browser: Browser, file: Path, html: str) -> None:
        file.write_text(html)
        self.context = browser.new_context(viewport={"width": WIDTH, "height": HEIGHT}, has_touch=True, offline=True)
        self.tab, self.wrong = self.context.new_page(), list[str]()
        self.fingers = self.context.new_cdp_session(self.tab)
        self.tab.on("pageerror", lambda error: self.wrong.append(str(error)))
        self.tab.goto(file.as_uri())
        self.tab.evaluate("shown")

    def press(self, name: str) -> None:
        self.tab.get_by_role("button", name=name, exact=True).click()

    def picture(self) -> np.ndarray:
        """The middle of the page, which no text lies over: int [H, W, 3]."""
        self.tab.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
        shot = Image.open(io.BytesIO(self.tab.screenshot())).convert("RGB")
        return np.asarray(shot)[240:-110].astype(int)

    def pixels(self, colour: np.ndarray) -> int:
        return int((np.abs(self.picture() - colour).max(axis=2) < 4).sum())

    def values(self) -> dict[str, str]:
        """What is shown of the point that was picked."""
        rows = self.tab.inner_text("#picked").splitlines()
        return {row[:11].strip(): row[11:] for row in rows}

    def state(self, name: str) -> float:
        return self.tab.evaluate(name)

    def seen(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Column, row and depth of points, by the pinhole camera of all other pictures."""
        bearing, pitch, distance, target = map(self.state, ("bearing", "pitch", "distance", "target"))
        ahead = -np.array([np.cos(bearing) * np.cos(pitch), np.sin(bearing) * np.cos(pitch), np.sin(pitch)])
        left = np.array([np.sin(bearing), -np.cos(bearing), 0.0])
        pose = np.eye(4)
        pose[:3] = np.stack([ahead, left, np.cross(ahead, left), target - distance * ahead], axis=1)
        return Eye(pose, self.focal, WIDTH, HEIGHT).seen(points)


@pytest.fixture
def page(browser: Browser, scan: Scan, tmp_path: Path) -> Iterator[Opened]:
    opened = Opened(browser, tmp_path / "scan.html", scan.html())
    yield opened
    opened.context.close()
    assert opened.wrong == []


def alone(page: Opened, points: np.ndarray, label: np.ndarray, wanted: int) -> tuple[int, float, float]:
    """A point of a class with no other within 9 pixels, and its place on the page."""
    column, row, depth = page.seen(points)
    places = np.stack([column, row], axis=1)
    inside = (np.abs(column - WIDTH / 2) < WIDTH / 2 - 20) & (row > 240) & (row < HEIGHT - 110) & (depth > 1)
    for n in np.flatnonzero(inside & (label == wanted)):
        if (np.abs(places - places[n]).max(axis=1) < 9).sum() == 1:
            return int(n), float(column[n]), float(row[n])
    raise AssertionError("all points have others beside them")


@pytest.mark.parametrize(
    ("name", "wanted", "owner", "press"),
    [
        ("road", 1, "none", "click"),
        ("building", 3, "none", "click"),
        ("car", 13, "car_1", "click"),
        ("car", 13, "car_1", "tap"),
    ],
)
def test_a_click_on_a_point_shows_its_values(
    page: Opened, scan: Scan, name: str, wanted: int, owner: str, press: str
) -> None:
    points = np.add(scan.points(), (0, 0, scan.pose[2, 3]))
    middle = points[np.flatnonzero(scan.labels() == wanted)[9]].tolist()
    page.tab.evaluate("middle => { distance = 9; target = middle; draw(); }", middle)  # so near that points lie apart
    n, x, y = alone(page, points, scan.labels(), wanted)
    (page.tab.touchscreen.tap if press == "tap" else page.tab.mouse.click)(x, y)
    said = page.values()
    rows, columns = np.nonzero(scan.image.valid)
    assert (said["row"], said["column"]) == (str(rows[n]), str(columns[n]))
    assert (said["class"], said["object"]) == (name, owner)
    assert float(said["range"].removesuffix(" m")) == pytest.approx(scan.image.depth[rows[n], columns[n]], abs=0.011)
    assert float(said["intensity"]) == pytest.approx(scan.intensities()[n], abs=0.008)
    assert float(said["time"].split()[0]) == pytest.approx(1000 * scan.image.times()[n], abs=0.006)
    np.testing.assert_allclose([float(v) for v in said["x, y, z"][:-2].split(",")], points[n], atol=0.01)


def test_a_click_on_nothing_and_a_drag_pick_nothing(page: Opened) -> None:
    page.tab.evaluate("pitch = 0.1; draw()")
    bearing = page.state("bearing")
    page.tab.mouse.click(WIDTH - 40, 60)  # the sky
    page.tab.mouse.move(450, 400)
    page.tab.mouse.down()
    page.tab.mouse.move(550, 400)
    page.tab.mouse.up()
    assert page.values() == {}
    assert page.state("bearing") == pytest.approx(bearing - 0.6, abs=0.03)


def test_boxes_and_labels_of_a_hidden_class_are_hidden(page: Opened) -> None:
    assert page.pixels(CAR_BLUE) > 100
    page.press("car")
    assert page.pixels(CAR_BLUE) == 0
    assert page.pixels(view.PALETTE[11]) > 100  # the person stays
    page.press("car")
    assert page.pixels(CAR_BLUE) > 100


def test_points_boxes_and_labels_go_each_by_itself(page: Opened) -> None:
    whole, drawn = page.picture(), {}
    for name in ("points", "boxes", "labels"):
        page.press(name)
        drawn[name] = (page.picture() != whole).any(axis=2)
        page.press(name)
    assert (page.picture() == whole).all()
    assert drawn["points"].sum() > 3000
    assert drawn["boxes"].sum() > 300
    assert 50 < drawn["labels"].sum() < drawn["boxes"].sum()
    for name in drawn:
        page.press(name)
    assert len(np.unique(page.picture().reshape(-1, 3), axis=0)) < 40  # rings alone


def test_objects_without_a_return_are_drawn_on_demand(page: Opened) -> None:
    assert "3 objects, 1 of them without a return" in page.tab.inner_text("#count")
    assert page.pixels(BUS_CYAN) == 0
    page.press("objects without a return")
    assert page.pixels(BUS_CYAN) > 30


def test_a_colour_bar_ends_where_the_data_do(page: Opened, scan: Scan) -> None:
    image = scan.image
    data = {"range [m]": image.depth[image.valid], "intensity": scan.intensities(), "ring": image.beams()}
    data["height [m]; objects by class"] = scan.points()[:, 2] + scan.pose[2, 3]
    before = page.picture()
    for name, values in data.items():
        page.press(name.split()[0])
        text, *ticks = page.tab.inner_text("#bar").splitlines()
        assert text == name
        ends = [float(tick) for tick in ticks]
        assert ends == sorted(ends)
        assert (ends[0], ends[-1]) == pytest.approx((values.min(), values.max()), abs=0.06)
        if name == "ring":
            assert (page.picture() != before).any()


def test_each_object_has_a_colour_of_its_own(page: Opened) -> None:
    page.press("boxes")
    page.press("labels")
    car, person = (140 + 110 * np.cos(number * 2.4 - np.arange(3) * 2 * np.pi / 3) for number in (1, 2))
    assert (page.pixels(car), page.pixels(person)) == (0, 0)
    page.press("instance")
    assert min(page.pixels(car), page.pixels(person)) > 10
    assert page.pixels(np.array([62, 70, 88])) > 300  # of all that is no object
    assert page.tab.inner_text("#bar") == ""


def touch(page: Opened, kind: str, *places: tuple[float, float]) -> None:
    points = [{"x": x, "y": y, "id": number} for number, (x, y) in enumerate(places)]
    page.fingers.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})


def test_two_fingers_zoom_and_move(page: Opened) -> None:
    distance, target, bearing = map(page.state, ("distance", "target", "bearing"))
    touch(page, "touchStart", (400, 400), (500, 400))
    touch(page, "touchMove", (350, 400), (550, 400))  # twice as far apart
    assert page.state("distance") == pytest.approx(distance / 2, rel=0.02)
    np.testing.assert_allclose(page.state("target"), target, atol=0.2)
    touch(page, "touchMove", (350, 300), (550, 300))
    touch(page, "touchEnd")
    assert page.state("distance") == pytest.approx(distance / 2, rel=0.02)
    assert np.linalg.norm(np.subtract(page.state("target"), target)) == pytest.approx(
        100 * distance / 2 / page.focal, rel=0.1
    )
    assert (page.state("bearing"), page.values()) == (bearing, {})


def test_one_finger_turns(page: Opened) -> None:
    distance, bearing = map(page.state, ("distance", "bearing"))
    touch(page, "touchStart", (400, 400))
    touch(page, "touchMove", (500, 400))
    touch(page, "touchEnd")
    assert page.state("bearing") == pytest.approx(bearing - 0.6, abs=0.1)
    assert (page.state("distance"), page.values()) == (distance, {})


@pytest.mark.parametrize("count", [0, 300])
def test_points_of_which_nothing_is_known_are_shown(browser: Browser, tmp_path: Path, count: int) -> None:
    points = np.random.default_rng(0).uniform(-9, 9, (count, 3))
    page = Opened(browser, tmp_path / "bare.html", view.html_page(points, {}, boxes=LAYOUT.boxes(), title="<b>"))
    assert page.tab.inner_text("#count") == f"{count} returns, 3 objects"
    assert page.tab.inner_text("#title") == "<b>"
    assert page.pixels(BUS_CYAN) > 30  # whose returns these are is not known
    assert page.wrong == []
    page.context.close()
