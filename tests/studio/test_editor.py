"""A document and the edits of a world, without a page."""

from __future__ import annotations

import io
import math
import shutil
import subprocess
import sys
import time
import zipfile
from pathlib import Path

import numpy as np
import pytest

from lidardraft import Layout, Primitive, Sensor, Weather, WorldState, layout_from_text
from lidardraft.cli import main as cli
from lidardraft.errors import LayoutError, LidarDraftError
from lidardraft.scene.check import check
from lidardraft.semantics import BY_NAME
from lidardraft.studio import keep
from lidardraft.studio.document import MOST_STATES, Document, Look
from lidardraft.studio.editor import Editor
from lidardraft.studio.frame import colour_bar, frame_of
from lidardraft.studio.session import Draft, Session, hear

SENSOR = Sensor.preset("vlp16")


@pytest.fixture(scope="module")
def layout() -> Layout:
    return layout_from_text("a car ahead, a parked bus on the right, a tree on the left, a road with two lanes", seed=3)


@pytest.fixture
def editor(layout: Layout) -> Editor:
    return Editor(layout, [SENSOR], seed=3)


def points_of(editor: Editor) -> bytes:
    return editor.scans()[0].points().tobytes()


def test_an_undone_edit_gives_the_same_scan_as_before_and_a_redone_one_as_after(editor: Editor) -> None:
    x, y, yaw = editor.world["car_1"].pose
    first = points_of(editor)
    editor.move("car_1", x + 3.0, y, yaw)
    editor.commit()
    second = points_of(editor)
    editor.remove("bus_1")
    assert len({first, second, points_of(editor)}) == 3
    editor.go(-2)
    assert points_of(editor) == first
    editor.go(1)
    assert points_of(editor) == second
    assert "bus_1" in editor.world


def test_an_edit_after_an_undone_one_takes_its_place(editor: Editor) -> None:
    editor.remove("bus_1")
    editor.go(-1)
    editor.remove("tree_1")
    editor.go(1)
    assert "bus_1" in editor.world
    assert "tree_1" not in editor.world


def test_places_of_one_drag_are_one_edit(editor: Editor) -> None:
    x, y, yaw = editor.world["bus_1"].pose
    for k in range(9):
        editor.move("bus_1", x + k / 3, y, yaw)
    editor.commit()
    assert len(editor.document.states) == 2
    editor.go(-1)
    assert editor.world["bus_1"].pose == (x, y, yaw)


def test_a_dragged_thing_keeps_its_speed_and_a_parked_one_stands(editor: Editor) -> None:
    for name in ("car_1", "bus_1"):
        speed, (x, y, yaw) = editor.world[name].speed, editor.world[name].pose
        editor.move(name, x + 1.0, y, yaw)
        assert editor.world[name].speed == pytest.approx(speed)


def test_things_snap_into_the_middle_of_a_lane_and_along_it(editor: Editor) -> None:
    lane = next(lane for lane in editor.world.layout().roads.lanes if lane.kind == "driving")
    middle, heading = lane.line.at(12.0), lane.line.heading(12.0)
    editor.move("bus_1", middle[0] + 0.3, middle[1] + 0.8, heading + 0.2, snaps=True)
    x, y, yaw = editor.world["bus_1"].pose
    assert abs(lane.line.along_across(np.array([[x, y]]))[1][0]) < 0.01
    assert math.remainder(yaw - heading, math.tau) == pytest.approx(0.0, abs=0.02)


def test_a_thing_is_added_duplicated_resized_and_becomes_another(editor: Editor) -> None:
    new = editor.add("van", 30.0, -8.0)
    twin = editor.duplicate(new)
    assert {new, twin} <= set(editor.names)
    editor.resize(twin, (6.0, 2.2, 3.0))
    assert editor.box(twin).size == pytest.approx((6.0, 2.2, 3.0), abs=1e-6)
    editor.become(twin, "person")
    assert editor.box(twin).label == "person"
    assert len(editor.document.states) == 5
    assert not [found for found in check(editor.world.layout()) if found.check == "grounded"]


@pytest.mark.parametrize("turn", [0.0, 0.7])
def test_a_turned_thing_grows_along_its_own_axes(editor: Editor, turn: float) -> None:
    x, y, _ = editor.world["bus_1"].pose
    editor.move("bus_1", x, y, turn)
    length, width, height = editor.box("bus_1").size
    editor.resize("bus_1", (length * 1.25, width, height))
    assert editor.box("bus_1").size == pytest.approx((length * 1.25, width, height), abs=1e-6)
    assert editor.world["bus_1"].pose[:2] == pytest.approx((x, y), abs=0.05)


def test_an_edit_that_raises_leaves_all_as_it_was(editor: Editor) -> None:
    before, scan = editor.document, points_of(editor)
    for bad in (
        lambda: editor.resize("bus_1", (1.0, -1.0, 1.0)),
        lambda: editor.become("bus_1", "submarine"),
        lambda: editor.remove("nobody"),
        lambda: editor.add("car", 9e5, 0.0),
        lambda: editor.begin(Layout(tuple(layout_from_text("a car ahead", seed=0)) * 0), -4),
    ):
        with pytest.raises(LidarDraftError):
            bad()
    assert editor.document == before
    assert points_of(editor) == scan


def test_what_collides_is_found(editor: Editor) -> None:
    x, y, yaw = editor.world["bus_1"].pose
    editor.move("car_1", x, y, yaw)
    assert any({"car_1", "bus_1"} <= {i.split(".")[0] for i in found.ids} for found in check(editor.world.layout()))


def test_a_document_keeps_a_bounded_number_of_states(editor: Editor) -> None:
    state = editor.world.state()
    document = Document((state,), (SENSOR,))
    for k in range(MOST_STATES + 50):
        document = document.edited(state.but({}, time=float(k)))
    assert len(document.states) == MOST_STATES
    assert document.state.time == MOST_STATES + 49.0


def test_time_is_played_gone_back_to_and_goes_on_from_there(editor: Editor) -> None:
    for _ in range(6):
        editor.step(0.1)
    last = editor.world["car_1"].pose
    editor.show(2)
    assert editor.world.time == pytest.approx(0.2)
    editor.set_speed("car_1", 0.0)
    editor.step(0.1)
    assert len(editor.document.played) == 4
    assert editor.world["car_1"].pose != last
    assert editor.world["car_1"].speed == 0.0


def test_another_sensor_and_weather_see_the_same_scene(editor: Editor) -> None:
    state = editor.world.state()
    editor.equip([Sensor.preset("os1-32"), SENSOR, SENSOR], Weather(visibility=60.0))
    assert editor.world.state() is state
    assert [scan.image.sensor.name for scan in editor.scans()] == ["os1-32", "vlp16", "vlp16"]


def test_points_are_where_the_scan_has_them(layout: Layout) -> None:
    editor = Editor(layout, [Sensor.preset("hdl64e")], seed=3)
    (scan,) = editor.scans()
    expected = scan.points() @ scan.pose[:3, :3].T + scan.pose[:3, 3]
    np.testing.assert_allclose(frame_of([scan], Look()).points, expected, atol=1e-3)


def test_a_quick_scan_sees_the_scene_of_now_with_fewer_columns(layout: Layout) -> None:
    editor = Editor(layout, [Sensor.preset("hdl64e")], seed=3)
    (x, y, yaw), places = editor.world["car_1"].pose, []
    for move in (0.0, 3.0):
        editor.move("car_1", x + move, y, yaw)
        (quick,), (whole,) = editor.quick_scans(), editor.scans()
        assert math.prod(quick.image.sensor.shape) <= math.prod(whole.image.sensor.shape) / 2
        middles = []
        for scan in (quick, whole):
            number = next(part.instance for part in scan.layout if part.id.startswith("car_1"))
            frame = frame_of([scan], Look())
            middles.append(frame.points[scan.instances() == number].mean(axis=0))
        np.testing.assert_allclose(*middles, atol=0.3)
        places.append(middles[0])
    assert abs(np.linalg.norm(places[1] - places[0]) - 3.0) < 0.5


def test_a_hidden_class_has_neither_points_nor_boxes(editor: Editor) -> None:
    (scan,) = editor.scans()
    car = BY_NAME["car"].id
    hidden = frame_of([scan], Look(hidden=frozenset({car})))
    assert any(box.label == "car" for box in frame_of([scan], Look()).boxes())
    assert not any(box.label == "car" for box in hidden.boxes())
    labels = [scan.image.label[row, column] for _, row, column in hidden.pixels]
    assert car not in labels


@pytest.mark.parametrize("colour", ["height", "class", "intensity", "range", "object", "ring"])
def test_every_colour_has_a_meaning(editor: Editor, colour: str) -> None:
    frame = frame_of(editor.scans(), Look(colour=colour))
    assert len(np.unique(frame.colours, axis=0)) > 2
    assert colour_bar(colour, 16).texts
    assert frame.strips().shape[1:] == (1024, 3)


def test_a_ray_through_a_point_picks_its_row_column_range_class_and_object(editor: Editor) -> None:
    frame = frame_of(editor.scans(), Look())
    image = frame.scans[0].image
    for number in np.flatnonzero(image.instance[image.valid])[::40].tolist():
        origin = np.array([-20.0, -9.0, 30.0])
        way = frame.points[number] - origin
        pick = frame.picked(origin, way / np.linalg.norm(way))
        assert pick is not None
        assert pick.range == pytest.approx(image.depth[pick.row, pick.column])
        near = frame.points[(frame.pixels[:, 1] == pick.row) & (frame.pixels[:, 2] == pick.column)][0]
        assert np.linalg.norm(np.cross(near - origin, way / np.linalg.norm(way))) < 0.3
    assert frame.picked((0.0, 0.0, 50.0), (0.0, 0.0, 1.0)) is None


def unpacked(content: bytes, folder: Path) -> Path:
    zipfile.ZipFile(io.BytesIO(content)).extractall(folder)
    return folder


@pytest.mark.parametrize(
    ("sensor", "weather"),
    [
        (SENSOR, None),
        (Sensor(name="own", elevations=(0.03, -0.05, -0.15), columns=360), Weather(rain=4.5, wetness=0.3)),
    ],
)
def test_the_command_and_the_script_make_the_same_scan_byte_for_byte(
    layout: Layout, sensor: Sensor, weather: Weather | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    editor = Editor(layout, [sensor], seed=3, weather=weather)
    editor.add("cyclist", 9.0, 2.0)
    editor.step(0.1)
    document, state = editor.document, editor.world.state()
    ours = unpacked(keep.data_set(iter(editor.scans()), keep.OURS), tmp_path / "ours")
    folder = unpacked(keep.recipe(document, state), tmp_path / "recipe")
    words = keep.as_command(document).split()
    assert words[0] == "lidardraft"
    monkeypatch.chdir(folder)
    assert cli.main(words[1:]) == 0
    subprocess.run([sys.executable, "scan.py"], cwd=folder, check=True, capture_output=True)
    for ending in (".bin", ".label", ".npz", ".boxes.json", ".layout.json"):
        expected = (ours / f"000000{ending}").read_bytes()
        assert (folder / "scan" / f"000000{ending}").read_bytes() == expected, ending
        assert (folder / f"000000{ending}").read_bytes() == expected, ending


@pytest.mark.parametrize("kind", [kind for kind in keep.KINDS if kind != "las"])
def test_the_time_line_leaves_in_every_format(editor: Editor, kind: str, tmp_path: Path) -> None:
    editor.step(0.1)
    editor.step(0.1)
    played = editor.document.played
    folder = unpacked(keep.data_set(keep.scans_of(editor.document, played), kind), tmp_path)
    assert any(path.stat().st_size for path in folder.rglob("*") if path.is_file())
    if kind == keep.OURS:
        assert len(list(folder.glob("*.bin"))) == len(played)


def test_what_is_kept_in_a_folder_replaces_nothing(editor: Editor, tmp_path: Path) -> None:
    archive = keep.recipe(editor.document, editor.world.state())
    for _ in range(2):
        keep.put(tmp_path, "studio-recipe.zip", archive)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["studio-recipe-1", "studio-recipe-2"]
    keep.put(tmp_path, "studio.layout.json", editor.world.layout().to_json().encode())
    assert len(Layout.load(tmp_path / "studio.layout.json")) == len(editor.world.layout())
    assert WorldState.load(tmp_path / "studio-recipe-1" / keep.STATE_FILE).seed == 3
    shutil.rmtree(tmp_path)


class Told:
    """What a page would show."""

    def __init__(self) -> None:
        self.lines, self.shown = list[tuple[str, bool]](), list[bool]()

    def show(self, _session: Session, frame: object) -> None:
        self.shown.append(frame.whole)

    def settle(self, session: Session, _frame: object) -> None:
        self.findings = session.findings()

    def tell(self, message: str, *, is_error: bool = False) -> None:
        self.lines.append((message, is_error))

    def progress(self, share: float | None) -> None:
        pass


@pytest.fixture
def session(editor: Editor) -> Session:
    running = Session(editor)
    running.page = Told()
    yield running
    running.end()


def test_of_many_places_of_a_drag_the_newest_wins_and_none_queues_up(session: Session) -> None:
    session.post(lambda one: one.select("bus_1"))
    x, y, yaw = session.editor.world["bus_1"].pose
    for k in range(400):
        session.post(lambda one, k=k: one.drag(x + k / 100, y, yaw, ends=False), "drag")
    session.post(lambda one: one.drag(x + 4.0, y, yaw, ends=True))
    session.join()
    assert session.editor.world["bus_1"].pose == pytest.approx((x + 4.0, y, yaw))
    assert len(session.editor.document.states) == 2
    assert session.frames < 100
    assert session.page.shown[-1]


def test_a_refused_sentence_is_a_message_and_the_scene_stays(session: Session) -> None:
    def read() -> Draft:
        return Draft(layout_from_text("qwertz uiop", seed=0))

    before = session.editor.document
    session.post(lambda one: one.begin(read, 0))
    session.join()
    assert session.page.lines[-1][1]
    assert "qwertz" in session.page.lines[-1][0]
    assert session.editor.document is before


def test_notes_of_a_layout_and_warnings_of_its_reader_are_shown(session: Session, layout: Layout) -> None:
    def read() -> Draft:
        hear("two points were left out")
        return Draft(layout.noted("the road is assumed to be straight"))

    session.post(lambda one: one.begin(read, 0))
    session.join()
    said, is_error = session.page.lines[-1]
    assert "two points were left out" in said
    assert "the road is assumed" in said
    assert not is_error


def test_a_layout_of_too_many_things_is_a_message_and_the_scene_stays(session: Session, layout: Layout) -> None:
    many = [part for part in layout if part.label == "road"] + [
        Primitive.unchecked(shape="box", center=(k % 500, k // 500, 1.0), size=(0.1,) * 3, label="pole", id=f"p{k}")
        for k in range(50_000)
    ]
    session.post(lambda one: one.begin(lambda: Draft(Layout(tuple(many))), 0))
    session.join()
    assert "5000 at most" in session.page.lines[-1][0].replace(",", "")
    assert "car_1" in session.editor.world


def test_the_page_is_told_what_is_wrong(session: Session) -> None:
    x, y, yaw = session.editor.world["bus_1"].pose
    session.post(lambda one: one.select("car_1"))
    session.post(lambda one: one.drag(x, y, yaw, ends=True))
    session.join()
    assert any("overlap" in found.message for found in session.page.findings)


def test_time_runs_until_it_is_paused(session: Session) -> None:
    session.post(lambda one: setattr(one, "is_running", True))
    for _ in range(200):
        if len(session.editor.document.played) > 3:
            break
        session.post(lambda _: None)
        time.sleep(0.05)
    session.post(Session.pause)
    session.join()
    assert len(session.editor.document.played) > 3
    assert session.editor.document.state is session.editor.world.state()


def test_who_leaves_during_a_drag_finds_the_thing_where_it_was_dragged(session: Session) -> None:
    session.post(lambda one: one.select("bus_1"))
    x, y, yaw = session.editor.world["bus_1"].pose
    session.post(lambda one: one.drag(x + 2.0, y, yaw, ends=False), "drag")
    session.leave()
    session.join()
    assert session.editor.document.state.actors["bus_1"].spot[0] == pytest.approx(x + 2.0)
    assert not session.is_dragging


def test_an_unknown_place_is_refused_with_a_message(editor: Editor) -> None:
    with pytest.raises(LayoutError, match="off the map"):
        editor.move("bus_1", 5000.0, 0.0, 0.0)
