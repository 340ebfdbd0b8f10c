"""The page of one visitor: widgets of viser that post edits to a session, and show its results."""

from __future__ import annotations

import math
import re
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import viser

from lidardraft.errors import FormatError, LidarDraftError
from lidardraft.scene.check import Finding
from lidardraft.scene.sensor import PRESETS, Sensor
from lidardraft.scene.weather import WEATHERS, Weather
from lidardraft.semantics import CLASSES
from lidardraft.simulation.recorded.solid_object import WORDS
from lidardraft.studio import keep
from lidardraft.studio.canvas import Canvas
from lidardraft.studio.document import COLOURS
from lidardraft.studio.frame import Frame, Pick, colour_bar
from lidardraft.studio.session import MOST_CHECKED, STEP, Draft, Edit, Page, Session
from lidardraft.view import PALETTE
from lidardraft.world.state import EGO_NAME, WorldState

SENTENCE = "a busy crossroads with cars, a bus, cyclists and pedestrians"
_EXAMPLES = (
    SENTENCE,
    "a bus ahead, people crossing, cars parked on the right",
    "a quiet residential street with trees on both sides and a cyclist ahead",
    "a motorway in the rain with three trucks on the right lane",
)
_SEED = 2**31 - 1
_MOST_UPLOADED = 300 * 2**20  # bytes
_CLEAR, _AS_SAID, _OWN = "clear", "as the scene says", "as below"
_CLEAR_SIGHT = 2000.0  # m: a longer visibility counts as unlimited


@dataclass(frozen=True)
class Inputs:
    """The readers of inputs: `layout` takes an option of the command line, its value, a seed and the length of a unit
    [m], or 0 for that of the file; `sensor` takes a file. `endings` are those of the files of each input. `generator`
    loads the diffusion model; `folder` is the place of files on the server, or None."""

    layout: Callable[[str, str, int, float], Draft]
    sensor: Callable[[str], Sensor]
    endings: dict[str, tuple[str, ...]]
    generator: Callable[[], Any]
    folder: Path | None = None

    def kind_of(self, name: str) -> str:
        """The kind of input of a file with that name."""
        if name.endswith(".json"):
            return "boxes" if name.endswith(".boxes.json") else "layout"
        return next((kind for kind, endings in self.endings.items() if name.lower().endswith(endings)), "layout")


class BrowserPage(Page):
    """The widgets and the view of one client."""

    def __init__(self, client: viser.ClientHandle, session: Session, inputs: Inputs) -> None:
        self.client, self.session, self.inputs = client, session, inputs
        self.gui, self._own = client.gui, dict[str, Sensor]()
        self._pick: Pick | None = None
        self._canvas = Canvas(client, self._dragged)
        self._build()
        client.scene.on_click()(self._clicked)
        session.page = self
        session.post(lambda _: None)

    def _post(self, edit: Edit, key: object = None) -> None:
        self.session.post(edit, key)

    def _on(self, widget: Any, edit: Callable[[Session, Any], object], key: object = None) -> Any:
        """Post an edit with the value of a widget if a visitor changes it, but not if the page does."""

        def changed(event: Any) -> None:
            if event.client is not None:
                value = event.target.value
                self._post(lambda session: edit(session, value), key)

        (widget.on_click if hasattr(widget, "on_click") else widget.on_update)(changed)
        return widget

    def _button(self, label: str, icon: Any, edit: Callable[[Session], object], colour: Any = None) -> None:
        self.gui.add_button(label, icon=icon, color=colour).on_click(lambda _: self._post(edit))

    def _build(self) -> None:
        gui: Any = self.gui
        gui.configure_theme(dark_mode=True, show_logo=False, show_share_button=False, brand_color=(64, 160, 255))
        gui.set_panel_label("lidardraft studio")
        gui.main_panel.dock_right()
        gui.main_panel.set_width(390)
        self._status = gui.add_markdown("")
        self._progress = gui.add_progress_bar(0.0, visible=False, animated=True)
        tabs = gui.add_tab_group()
        icons = viser.Icon
        rows = {"Scene": (icons.EDIT, self._scene_tab), "Look": (icons.EYE, self._look_tab),
                "Sensor": (icons.RADAR, self._sensor_tab), "Play": (icons.PLAYER_PLAY, self._play_tab),
                "Keep": (icons.DOWNLOAD, self._keep_tab)}  # fmt: skip
        for name, (icon, fill) in rows.items():
            with tabs.add_tab(name, icon):
                fill(gui)
        panel = gui.add_panel()
        with panel.add_tab("Range image"):
            self._strip = gui.add_image(np.zeros((64, 1024, 3), np.uint8), format="jpeg")
            self._bar = gui.add_html("")
        panel.float(x=12, y=-12, width=560)

    # fmt: off
    def _scene_tab(self, gui: Any) -> None:
        with gui.add_folder("1. Describe a scene"):
            self._text = gui.add_text("Sentence", SENTENCE, multiline=True, hint="In English: objects and traffic.")
            examples = gui.add_dropdown("Examples", ("choose one ...", *_EXAMPLES))
            self._seed = gui.add_number("Seed", 0, min=0, max=_SEED, step=1, hint="Another seed, another scene.")
            self._button("Make the scene", viser.Icon.WAND, self._draft, "blue")
            self._button("Roll the dice", viser.Icon.DICE, self._roll)
            self._notes = gui.add_markdown("")
        with gui.add_folder("or open a file", expand_by_default=False):
            self._kind = gui.add_dropdown("It is", ("what its name says", *self.inputs.endings))
            self._scale = gui.add_number("A unit is [m]", 0.0, min=0.0, step=0.01,
                                         hint="Of sketches and models; 0: as the file says.")
            upload = gui.add_upload_button("Scan, picture, sketch, boxes, model, layout ...", icon=viser.Icon.UPLOAD)
        with gui.add_folder("2. Change it"):
            self._objects = self._on(gui.add_dropdown("Object", ("-",)), Session.select)
            gui.add_markdown("*Click an object, then drag its arrows or its arc.*")
            self._size = self._on(gui.add_vector3("L, W, H [m]", (1.0, 1.0, 1.0), min=(0.05,) * 3, step=0.05),
                                  lambda s, size: s.of_selected(s.editor.resize, size), "size")
            self._become = self._on(gui.add_dropdown("Make it a", ("-", *WORDS)), self._change)
            self._on(gui.add_button_group("It", ("Duplicate", "Delete")), self._copy_or_delete)
            self._on(gui.add_checkbox("Snap to lanes", False), lambda s, on: setattr(s, "snaps", on))
            self._new = gui.add_dropdown("New", WORDS, initial_value="car")
            self._button("Add it", viser.Icon.PLUS, self._add)
            self._on(gui.add_button_group("History", ("Undo", "Redo")), lambda s, to: s.go(-1 if to == "Undo" else 1))
            self._findings = gui.add_markdown("")
        upload.on_upload(self._uploaded)
        examples.on_update(lambda _: setattr(self._text, "value", examples.value))

    def _look_tab(self, gui: Any) -> None:
        look = self.session.look
        self._on(gui.add_dropdown("Colours", COLOURS, initial_value=look.colour), lambda s, to: s.look_at(colour=to))
        for name in ("points", "boxes", "labels", "layout", "recorded"):
            label = "Recorded scan" if name == "recorded" else name.capitalize()
            self._on(gui.add_checkbox(label, getattr(look, name)), _part_shown(name))
        self._on(gui.add_slider("Point size", 0.02, 0.2, 0.01, self._canvas.point_size),
                 lambda _, size: setattr(self._canvas, "point_size", size), "point size")
        self._on(gui.add_button_group("Camera", ("Behind", "Seat", "Above", "Object")), self._see_from)
        self._picked = gui.add_markdown("*Click a point: its row, column, range, class and object.*")
        with gui.add_folder("Classes", expand_by_default=False):
            for row in CLASSES[1:]:
                self._on(gui.add_checkbox(row.name, row.id not in look.hidden), _class_shown(row.id))

    def _sensor_tab(self, gui: Any) -> None:
        first, *second = [sensor.name for sensor in self.session.editor.document.sensors]
        names = tuple(dict.fromkeys((*PRESETS, first, *second)))
        self._first = self._on(gui.add_dropdown("Sensor", names, initial_value=first), self._equip)
        self._second = self._on(gui.add_dropdown("Beside it", ("none", *names), initial_value=[*second, "none"][0]),
                                self._equip)
        gui.add_upload_button("A sensor of your own (.json)", icon=viser.Icon.UPLOAD).on_upload(self._uploaded_sensor)
        self._weather = self._on(gui.add_dropdown("Weather", (_AS_SAID, _CLEAR, *WEATHERS, _OWN)), self._set_weather)
        limits = (("Rain [mm/h]", 0.0, 50.0, 0.5, 0.0), ("Snow [mm/h]", 0.0, 10.0, 0.1, 0.0),
                  ("Visibility [m]", 20.0, _CLEAR_SIGHT, 10.0, _CLEAR_SIGHT), ("Wetness", 0.0, 1.0, 0.05, 0.0))
        self._amounts = [self._on(gui.add_slider(*row), self._set_amounts, "weather") for row in limits]
        self._speed = self._on(gui.add_number("Own speed [m/s]", 0.0, min=0.0, max=60.0, step=0.5),
                               lambda s, speed: s.editor.set_own_speed(speed), "own speed")
        self._button("Generate with the diffusion model", viser.Icon.SPARKLES,
                     lambda s: s.generate(self.inputs.generator))
        self._stale = gui.add_markdown("")

    def _play_tab(self, gui: Any) -> None:
        self._on(gui.add_button_group("Time", ("Run", "Pause", "Step")), self._play)
        self._time = self._on(gui.add_slider("Time line", 0, 1, 1, 0, disabled=True), lambda s, k: s.scrub(k), "time")
        self._clock = gui.add_markdown("0.0 s")
        self._on(gui.add_button_group("Camera", ("Free", "Seat", "Above")), self._see_from)
        self._actor = gui.add_markdown("")
        self._pace = self._on(gui.add_number("Its speed [m/s]", 0.0, min=-60.0, max=60.0, step=0.5),
                              lambda s, speed: s.of_selected(s.editor.set_speed, speed), "speed")
        self._on(gui.add_button_group("Let it", ("Drive its lane", "Stop")), self._command)

    def _keep_tab(self, gui: Any) -> None:
        self._what = gui.add_dropdown("What", ("this scan", "the time line"))
        self._format = gui.add_dropdown("As", keep.KINDS, hint="lidardraft: the files of `lidardraft simulate`")
        self._button("Save", viser.Icon.DOWNLOAD, self._save_scans, "blue")
        self._button("Save the layout", None,
                     lambda s: self._save("studio.layout.json", s.editor.world.layout().to_json().encode()))
        self._on(gui.add_button_group("Copy as", ("Command", "Python")), self._copy)
        self._words = gui.add_markdown("")
        folder = self.inputs.folder
        self._into = None if folder is None else gui.add_checkbox(f"Into {folder.name}/ on the server", True)
        if folder is None:
            gui.add_markdown("*Files are downloads. Start with `-o FOLDER` to have them in a folder.*")
    # fmt: on

    def _add(self, session: Session) -> None:
        """Add an object at the centre of the view, within reach of the sensor."""
        x, y, _ = np.clip(self.client.camera.look_at, -100.0, 100.0).tolist()
        session.select(session.editor.add(self._new.value, x, y))

    def _draft(self, session: Session) -> None:
        text, seed = self._text.value, int(self._seed.value)
        session.begin(lambda: self.inputs.layout("text", text, seed, 0.0), seed)

    def _roll(self, session: Session) -> None:
        self._seed.value = (int(self._seed.value) * 31 + 17) % 10_000
        self._draft(session)

    def _uploaded(self, event: Any) -> None:
        file, chosen, seed, scale = event.target.value, self._kind.value, int(self._seed.value), self._scale.value
        kind = chosen if chosen in self.inputs.endings else self.inputs.kind_of(file.name)

        def read(path: str) -> Draft:
            if file.name.endswith(".world.json"):
                return Draft(WorldState.load(path))
            return self.inputs.layout(kind, path, seed, scale)

        self._post(lambda session: session.begin(lambda: _read(file, read), seed))

    def _uploaded_sensor(self, event: Any) -> None:
        file = event.target.value

        def add(session: Session) -> None:
            sensor = _read(file, self.inputs.sensor)
            self._own[sensor.name] = sensor
            names = tuple(dict.fromkeys((*self._first.options, sensor.name)))
            self._first.options, self._second.options = names, ("none", *names)
            self._first.value = sensor.name
            self._equip(session, None)

        self._post(add)

    def _sensor(self, name: str) -> Sensor:
        known = {sensor.name: sensor for sensor in self.session.editor.document.sensors} | self._own
        return known[name] if name in known else Sensor.preset(name)

    def _equip(self, session: Session, _: object) -> None:
        names = (self._first.value, self._second.value)
        session.editor.equip([self._sensor(name) for name in names if name != "none"], session.editor.document.weather)
        self._see_from(session, "Behind" if self._second.value == "none" else "Both")

    def _set_weather(self, session: Session, name: str) -> None:
        if name == _OWN:
            self._set_amounts(session, None)
            return
        weather = None if name == _AS_SAID else WEATHERS.get(name, Weather())
        shown = weather or Weather()
        values = (shown.rain, shown.snow, min(shown.visibility, _CLEAR_SIGHT), shown.wetness)
        for slider, value in zip(self._amounts, values, strict=True):
            slider.value = value
        session.editor.equip(session.editor.document.sensors, weather)

    def _set_amounts(self, session: Session, _: object) -> None:
        rain, snow, sight, wetness = (slider.value for slider in self._amounts)
        self._weather.value = _OWN
        sight = math.inf if sight >= _CLEAR_SIGHT else sight
        weather = Weather(rain=rain, snow=snow, visibility=sight, wetness=wetness)
        session.editor.equip(session.editor.document.sensors, weather)

    def _change(self, session: Session, kind: str) -> None:
        if kind in WORDS:
            session.of_selected(session.editor.become, kind)
        self._become.value = "-"

    def _copy_or_delete(self, session: Session, what: str) -> None:
        if what == "Delete":
            session.of_selected(session.editor.remove)
            session.select_any()
        else:
            session.select(session.of_selected(session.editor.duplicate))

    def _clicked(self, event: Any) -> None:
        def pick(session: Session) -> None:
            self._pick = session.pick(event.ray_origin, event.ray_direction)
            if self._pick is not None:
                self._picked.content = _said(self._pick)

        self._post(pick)

    def _dragged(self, x: float, y: float, yaw: float, phase: str) -> None:
        ends = phase == "end"
        self._post(lambda session: session.drag(x, y, yaw, ends=ends), None if ends else "drag")

    def _see_from(self, session: Session, camera: str) -> None:
        self._canvas.camera = camera
        if camera == "Object" and session.selected is not None:
            self._canvas.see(None, session.editor.box(session.selected))
        elif camera != "Free":
            self._canvas.see(session.editor.box(EGO_NAME), None)

    def _play(self, session: Session, what: str) -> None:
        if what == "Run":
            session.is_running = True
        elif what == "Pause":
            session.pause()
        else:
            session.pause()
            session.editor.step(STEP)
            session.editor.commit()

    def _command(self, session: Session, what: str) -> None:
        if what == "Stop":
            session.of_selected(session.editor.set_speed, 0.0)
        else:
            session.of_selected(session.editor.drive)

    def _save(self, name: str, content: bytes) -> None:
        """Download a file, or write it into the server's folder."""
        folder = self.inputs.folder
        if folder is None or self._into is None or not self._into.value:
            self.client.send_file_download(name, content, save_immediately=True)
            return
        keep.put(folder, name, content)
        self.tell(f"{name} is in {folder.name}/ on the server.")

    def _save_scans(self, session: Session) -> None:
        document, kind = session.editor.document, self._format.value
        several = self._what.value != "this scan" and document.played
        scans = keep.scans_of(document, document.played) if several else iter([session.frame().scans[0]])
        count = len(document.played) if several else 1

        def work(_: Session) -> None:
            done = iter(range(1, count + 1))
            content = keep.data_set(scans, kind, on_scan=lambda: self.progress(next(done) / count))
            self._save(f"studio-{kind}.zip", content)
            self.progress(None)

        session.aside(work)

    def _copy(self, session: Session, what: str) -> None:
        document, state = session.editor.document, session.editor.world.state()
        said = keep.as_command(document) if what == "Command" else keep.as_python(document)
        said = said.replace(" --", " \\\n  --") if what == "Command" else said
        self._words.content = f"```\n{said}\n```\nThe files that it reads are in *studio-recipe.zip*."
        self._save("studio-recipe.zip", keep.recipe(document, state))

    def show(self, session: Session, frame: Frame) -> None:
        """Show the picture, and the time that it took."""
        self._canvas.show(session, frame)
        rate = f"{1e3 * session.seconds:.0f} ms"
        names = " and ".join(scan.image.sensor.name for scan in frame.scans)
        some = "" if frame.whole else " shown"
        self._status.content = f"**{names}**: {len(frame.points):,} returns{some}, {rate}"
        self._clock.content = f"{session.editor.world.time:.1f} s"

    def settle(self, session: Session, frame: Frame) -> None:
        """Update the widgets for the scene, and everything that a drag does not need."""
        self._canvas.settle(session, frame)
        self._strip.image = frame.strips(self._pick)
        self._bar.content = _bar_html(frame)
        names, selected = session.editor.names, session.selected
        if self._objects.options != names:
            self._objects.options = names
        if selected is not None and selected in names:
            self._objects.value = selected
            self._size.value = tuple(round(extent, 2) for extent in session.editor.box(selected).size)
            self._pace.value = round(session.editor.world[selected].speed, 2)
            self._actor.content = f"Of **{_plain(selected)}**, which is selected:"
        self._speed.value = round(session.editor.world.ego.speed, 2)
        played = session.editor.document.played
        self._time.disabled, self._time.max = len(played) < 2, max(len(played) - 1, 1)
        self._time.value = session.editor.document.position
        self._findings.content = _faults(session.findings())
        made = {True: "This is the diffusion model's scan.", None: "The generated scan is stale: the scene was edited."}
        self._stale.content = made.get(session.is_generated, "")

    def tell(self, message: str, *, is_error: bool = False) -> None:
        """Show a line under the sentence, and for an error a notice too."""
        self._notes.content = _plain(message)
        if is_error:
            self.client.add_notification("This did not work", message, color="red", auto_close_seconds=12.0)

    def progress(self, share: float | None) -> None:
        """Set the bar at the top."""
        self._progress.visible = share is not None
        self._progress.value = 100.0 * (share or 0.0)


def _read(file: Any, read: Callable[[str], Any]) -> Any:
    """The draft that a reader makes of an uploaded file, stored under another name; errors give the visitor's name."""
    if len(file.content) > _MOST_UPLOADED:
        raise FormatError(f"{file.name} has {len(file.content) >> 20} MB; {_MOST_UPLOADED >> 20} MB are read at most")
    with tempfile.TemporaryDirectory(prefix="lidardraft-studio-") as folder:
        path = Path(folder, f"upload{_suffix_of(file.name)}")
        path.write_bytes(file.content)
        try:
            return read(str(path))
        except LidarDraftError as error:
            raise type(error)(str(error).replace(str(path), file.name)) from None


def _faults(findings: Sequence[Finding] | None) -> str:
    if findings is None:
        return f"Not checked: more than {MOST_CHECKED} shapes."
    lines = [f"- {_plain(finding.message)}" for finding in findings[:5]] or ["Nothing collides or floats."]
    return "\n".join([*lines, *([f"- and {len(findings) - 5} more"] if len(findings) > 5 else [])])


def _suffix_of(name: str) -> str:
    """The ending of a file's name for its reader, as in ".pcd.bin"; "" for a name without one."""
    return "".join(one for one in Path(name).suffixes[-2:] if one[1:].isalnum() and len(one) < 9)


def _part_shown(name: str) -> Callable[[Session, bool], None]:
    return lambda session, on: session.look_at(**{name: on})


def _class_shown(number: int) -> Callable[[Session, bool], None]:
    def show(session: Session, on: bool) -> None:
        hidden = session.look.hidden
        session.look_at(hidden=hidden - {number} if on else hidden | {number})

    return show


def _plain(text: str) -> str:
    """The text in Markdown that shows it unchanged."""
    return re.sub(r"([\\`*{}<>\[\]#])", r"\\\1", text)


def _hex(number: int) -> str:
    return "#{:02x}{:02x}{:02x}".format(*PALETTE[number].tolist())


def _said(pick: Pick) -> str:
    strength = "" if pick.intensity is None else f", intensity {pick.intensity:.3f}"
    named = f", **{_plain(pick.object)}**" if pick.object else ""
    return f"Row {pick.row}, column {pick.column}: {pick.range:.2f} m, {pick.label}{strength}{named}"


def _bar_html(frame: Frame) -> str:
    bar = colour_bar(frame.look.colour, frame.scans[0].image.sensor.shape[0])
    style = "font-size:11px;padding:0 8px 6px;"
    ramp = f'<div style="height:8px;border-radius:3px;background:linear-gradient(90deg,{",".join(bar.colours)})"></div>'
    present = np.unique(np.concatenate([scan.image.label[scan.image.valid] for scan in frame.scans])).tolist()
    chip = '<span style="white-space:nowrap;margin-right:9px"><span style="color:{}">&#9632;</span> {}</span>'
    chips = "".join(
        chip.format(_hex(k), CLASSES[k].name)
        for k in present
        if k and k not in frame.look.hidden and (frame.look.colour == "class" or CLASSES[k].is_thing)
    )
    texts = "".join(f"<span>{text}</span>" for text in bar.texts)
    legend = chips if frame.look.colour in ("class", "objects and height") else ""
    return (
        f'<div style="{style}">{ramp if bar.colours else ""}<div style="display:flex;justify-content:space-between">'
        f"{texts}</div><div>{legend}</div></div>"
    )
