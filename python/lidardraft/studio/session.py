"""One visitor's studio without its page: any thread posts edits, and one thread carries them out and makes frames."""

from __future__ import annotations

import itertools
import threading
import time
import traceback
from collections.abc import Callable
from contextvars import ContextVar
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from lidardraft.errors import LidarDraftError
from lidardraft.scan import Scan
from lidardraft.scene.check import Finding, check
from lidardraft.scene.edit import placed
from lidardraft.scene.layout import Layout
from lidardraft.scene.pose import place_around
from lidardraft.studio.document import Look
from lidardraft.studio.editor import Editor
from lidardraft.studio.frame import Frame, Pick, frame_of
from lidardraft.world.state import WorldState

if TYPE_CHECKING:
    from lidardraft.pipeline import Pipeline

STEP = 0.1  # s, of the time line
MOST_CHECKED = 5000  # shapes of a scene that is checked after each edit
_MOST_NOTES = 8  # shown on a page
_HEARING: ContextVar[Session | None] = ContextVar("hearing", default=None)
T = TypeVar("T")
Edit = Callable[["Session"], object]


@dataclass(frozen=True, eq=False)
class Draft:
    """The result of an input: a layout, or the state of a world, and the points float32 [N, 3] of its recorded scan."""

    source: Layout | WorldState
    recorded: np.ndarray = field(default_factory=lambda: np.zeros((0, 3), np.float32))


class Page:
    """The output of a session; a page of a browser shows it, this one ignores it."""

    def show(self, session: Session, frame: Frame) -> None:
        """Show the points, at once."""

    def settle(self, session: Session, frame: Frame) -> None:
        """Show everything else, if no edit waits."""

    def tell(self, message: str, *, is_error: bool = False) -> None:
        """Show a line."""

    def progress(self, share: float | None) -> None:
        """Show the progress of a generation; None if there is none."""


class Session:
    """An editor and the thread that uses it.

    Of several edits with the same key, such as the places of one drag, only the newest is carried out. One frame is
    made after all waiting edits, so frames never queue up.
    """

    def __init__(self, editor: Editor) -> None:
        self.editor, self.look, self.selected = editor, Look(), None if not editor.names else editor.names[0]
        self._recorded: tuple[Layout | None, np.ndarray] = None, np.zeros((0, 3), np.float32)
        self.page: Page | None = None
        self.snaps, self.is_dragging, self.is_running = False, False, False
        self.used, self.frames, self.seconds = time.monotonic(), 0, 0.0
        self._edits: dict[object, Edit] = {}
        self._changed, self._ended, self._unsettled = threading.Condition(), False, True
        self._generated: tuple[WorldState, Scan] | None = None
        self._frame: Frame | None = None
        self._checked: tuple[WorldState, tuple[Finding, ...] | None] | None = None
        self._number, self._heard, self._when_settled = itertools.count(), list[str](), list[threading.Event]()
        self._thread = threading.Thread(target=self._run, name="studio", daemon=True)
        self._thread.start()

    def post(self, edit: Edit, key: object = None) -> None:
        """Queue an edit, in place of a waiting one with the same key; without a key it replaces none."""
        with self._changed:
            key = next(self._number) if key is None else key
            self._edits.pop(key, None)
            self._edits[key] = edit
            self.used = time.monotonic()
            self._changed.notify()

    def leave(self) -> None:
        """Continue without a page: a dragged object stays at its place, and time stops."""
        self.page = None

        def end(session: Session) -> None:
            session.is_dragging = session.is_running = False
            session.editor.commit()

        self.post(end)

    def end(self) -> None:
        """End the thread, after its current edit."""
        with self._changed:
            self._ended = True
            self._changed.notify()

    def join(self) -> None:
        """Wait until all edits posted before are carried out and shown."""
        done = threading.Event()
        self.post(lambda _: None)
        self.post(lambda session: session._when_settled.append(done))
        done.wait(60.0)

    def _run(self) -> None:
        _HEARING.set(self)
        while True:
            with self._changed:
                if not self._edits and not self._ended and not self.is_running and not self._unsettled:
                    self._changed.wait()
                if self._ended:
                    return
                edits, self._edits = list(self._edits.values()), {}
            begin = time.monotonic()
            for edit in edits:
                self._carry_out(edit)
            if self.is_running:
                self._carry_out(_step)
            if edits or self.is_running:
                self._unsettled = True
                self._carry_out(_show)
            elif self._unsettled and not self.is_dragging:
                self._unsettled = False
                self._carry_out(_settle)
                for done in self._when_settled:
                    done.set()
                self._when_settled = []
            else:
                self._unsettled = False
            if self.is_running:
                left = STEP - (time.monotonic() - begin)
                with self._changed:
                    if not self._edits and left > 0:
                        self._changed.wait(left)

    def _carry_out(self, edit: Edit) -> None:
        """Carry out an edit; one that fails becomes a message, and the scene stays unchanged."""
        try:
            edit(self)
        except LidarDraftError as error:
            self.is_running = False
            self.tell(str(error), is_error=True)
        except Exception as error:  # a page must survive faults of lidardraft
            self.is_running = False
            traceback.print_exc()
            self.tell(f"This is a fault of the studio's: {type(error).__name__}: {error}", is_error=True)

    def tell(self, message: str, *, is_error: bool = False) -> None:
        """Show a line in the page, if there is one."""
        if self.page is not None:
            self.page.tell(message, is_error=is_error)

    def frame(self) -> Frame:
        """The current frame, whole unless something is dragged."""
        whole = not (self.is_dragging or self.is_running)
        if self._generated and self.is_generated:
            scans: tuple[Scan, ...] = (self._generated[1],)
        else:
            scans = self.editor.scans() if whole else self.editor.quick_scans()
        last = self._frame
        if last and last.scans == scans and last.look == self.look and (last.whole or not whole):
            return last
        self._frame = frame_of(scans, self.look, whole=whole)
        return self._frame

    def findings(self) -> tuple[Finding, ...] | None:
        """The findings on the current scene; None if it has too many shapes for a check after each edit."""
        state, ego = self.editor.world.state(), self.editor.world.ego.pose
        if self._checked is None or self._checked[0] is not state:
            layout = self.editor.world.layout()
            if any(ego):  # checks assume it at the origin
                layout = replace(layout, primitives=tuple(placed(layout, place_around(ego))))
            self._checked = state, tuple(check(layout)) if len(layout) <= MOST_CHECKED else None
        return self._checked[1]

    @property
    def recorded(self) -> np.ndarray:
        """The points float32 [N, 3] of the recorded scan of the layout."""
        base, points = self._recorded
        return points if base is self.editor.world.state().layouts[0] else points[:0]

    @property
    def is_generated(self) -> bool | None:
        """Whether the frame is from the diffusion model; None if its scan is of the scene before the last edit."""
        if self._generated is None:
            return False
        return True if self._generated[0] is self.editor.world.state() else None

    def begin(self, read: Callable[[], Draft], seed: int) -> None:
        """Begin another scene, from the result of `read`."""
        self._heard.clear()
        draft = read()
        self.editor.begin(draft.source, seed)
        self._recorded = self.editor.world.state().layouts[0], draft.recorded
        self.is_running, self.selected = False, self.editor.names[0]
        self.tell("\n\n".join([*dict.fromkeys((*self.editor.scans()[0].notes, *self._heard))][:_MOST_NOTES]))

    def select(self, name: str | None) -> None:
        """Select an object, if it exists."""
        if name is None or name in self.editor.world:
            self.selected = name

    def of_selected(self, edit: Callable[..., T], *values: object) -> T | None:
        """Edit the selected object, if there is one."""
        return None if self.selected is None else edit(self.selected, *values)

    def drag(self, x: float, y: float, yaw: float, *, ends: bool) -> None:
        """Place the selected object; the end of a drag is an edit that can be undone."""
        self.is_dragging = not ends
        if self.selected is not None:
            self.editor.move(self.selected, x, y, yaw, snaps=self.snaps)
        if ends:
            self.editor.commit()

    def pick(self, origin: tuple[float, float, float], direction: tuple[float, float, float]) -> Pick | None:
        """Select the object of the return on a ray; returns that return."""
        pick = self.frame().picked(origin, direction)
        if pick is not None and pick.object:
            self.select(pick.object)
        return pick

    def look_at(self, **changes: object) -> None:
        """Change the settings of the view."""
        self.look = replace(self.look, **changes)  # type: ignore[arg-type]

    def go(self, by: int) -> None:
        """Undo or redo `by` edits."""
        self.is_running = False
        self.editor.go(by)
        self.select_any()

    def select_any(self) -> None:
        """Select another object if the selected one is gone."""
        if self.selected is None or self.selected not in self.editor.world:
            self.selected = self.editor.names[0]

    def scrub(self, position: int) -> None:
        """Show a moment of the time line."""
        self.is_running = False
        self.editor.show(position)

    def pause(self) -> None:
        """Stop time; the time that has passed becomes an edit."""
        self.is_running = False
        self.editor.commit()

    def generate(self, pipeline: Callable[[], Pipeline]) -> None:
        """Make the diffusion model generate the scan of the current layout; the next edit marks it stale."""
        state, scan = self.editor.world.state(), self.editor.scans()[0]
        self.tell("The diffusion model is loaded ...")
        self._heard.clear()

        def made(_: Session) -> None:
            run, done = pipeline(), itertools.count(1)

            def on_step() -> None:
                if self.page is not None:
                    self.page.progress(min(1.0, next(done) / run.steps))

            made = run.from_simulated(scan, on_step=on_step)
            self.post(lambda session: session._accept(state, made))

        self.aside(made)

    def aside(self, work: Edit) -> None:
        """Do slow work in a thread of its own; it may not touch the editor."""

        def run() -> None:
            _HEARING.set(self)
            self._carry_out(work)
            if self.page is not None:
                self.page.progress(None)

        threading.Thread(target=run, name="studio-aside", daemon=True).start()

    def _accept(self, state: WorldState, scan: Scan) -> None:
        self._generated = state, scan
        said = "This is the diffusion model's scan; the next edit shows the simulated one again."
        self.tell("\n\n".join((said, *dict.fromkeys(self._heard))))


def hear(message: str) -> None:
    """Keep a warning for the notes of the session whose thread it comes from."""
    if (session := _HEARING.get()) is not None:
        session._heard.append(message)


def _step(session: Session) -> None:
    session.editor.step(STEP)


def _show(session: Session) -> None:
    begin, before = time.perf_counter(), session._frame
    frame = session.frame()
    if frame is not before:
        session.seconds = time.perf_counter() - begin
    session.frames += 1
    if session.page is not None:
        session.page.show(session, frame)


def _settle(session: Session) -> None:
    if session.page is not None:
        session.page.settle(session, session.frame())
