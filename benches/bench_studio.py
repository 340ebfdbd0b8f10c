"""What a studio costs: frames a second while something is dragged, and the time from an edit to its points.

python benches/bench_studio.py [--shapes 50 250 600] [--sensor vlp16 hdl64e os1-128] [--seconds 6] [--edits 1000]

The rows of "attached" have a Chromium on the same machine, which draws in software: an edit comes 60 times a second, as
from a mouse, and frames are those that the renderer sends; "drawn" are the browser's own. "alone" is without a page.
"""

from __future__ import annotations

import argparse
import math
import resource
import time
from statistics import median
from typing import Any

from chromium import CHROMIUM, SIZE, chromium
from lidardraft import Layout, Sensor, layout_from_text, surround
from lidardraft.cli.studio import inputs_of
from lidardraft.scene.layout import AROUND, object_of
from lidardraft.studio.editor import Editor
from lidardraft.studio.server import served
from lidardraft.studio.session import Session

SENTENCE = "a street with parked cars on both sides, three cars ahead, a bus and pedestrians"
_FRAMES = "(() => { window.frames_ = 0; const f = () => { frames_++; requestAnimationFrame(f) }; f() })()"


def street_of(shapes: int) -> Layout:
    """A street of that many shapes; what is furthest around it is left out."""
    for seed in range(20):
        layout = surround(layout_from_text(SENTENCE, seed=seed), seed=seed)
        if len(layout) >= shapes:
            break
    around = {
        object_of(part) for part in layout if part.id.startswith(AROUND) and part.label not in ("terrain", "road")
    }
    away = {name: max(math.hypot(*p.center[:2]) for p in layout if object_of(p) == name) for name in around}
    parts = list(layout)
    for name in sorted(away, key=lambda name: -away[name]):
        if len(parts) <= shapes:
            break
        parts = [part for part in parts if object_of(part) != name]
    return Layout(tuple(parts), roads=layout.roads, intent=layout.intent)


def dragged(session: Session, seconds: float) -> tuple[float, list[float], float]:
    """Frames a second, the seconds from edits to their frames, and CPU seconds a frame."""
    name = next(name for name in session.editor.names if name.startswith("car"))
    session.post(lambda one: one.select(name))
    session.join()
    (x, y, yaw), waits = session.editor.world[name].pose, list[float]()
    first, begin, cpu, number = session.frames, time.perf_counter(), time.process_time(), 0
    while time.perf_counter() - begin < seconds:
        number += 1
        to, posted = (x + math.sin(number / 9), y + math.sin(number / 7)), time.perf_counter()

        def edit(one: Session, to: tuple[float, float] = to, posted: float = posted) -> None:
            one.drag(*to, yaw, ends=False)
            waits.append(-posted)

        before = session.frames
        session.post(edit, "drag")
        time.sleep(1 / 60)
        if session.frames > before and waits and waits[-1] < 0:
            waits[-1] += time.perf_counter()
    spent = time.perf_counter() - begin
    frames, cpu = session.frames - first, time.process_time() - cpu
    session.post(lambda one: one.drag(x, y, yaw, ends=True))
    session.join()
    return frames / spent, [wait for wait in waits if wait > 0], cpu / max(frames, 1)


def row(what: str, session: Session, seconds: float, more: str = "") -> None:
    """Print one."""
    rate, waits, cpu = dragged(session, seconds)
    wait = f"{1e3 * median(waits):.0f}" if waits else "-"
    print(f"| {what} | {rate:.1f} | {1e3 * session.seconds:.0f} | {wait} | {1e3 * cpu:.0f} |{more}", flush=True)


def main() -> None:
    """Print a table of rates, and the memory of edits."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shapes", type=int, nargs="+", default=[50, 250, 600])
    parser.add_argument("--sensor", nargs="+", default=["vlp16", "hdl64e", "os1-128"])
    parser.add_argument("--seconds", type=float, default=6.0)
    parser.add_argument("--edits", type=int, default=1000)
    arguments = parser.parse_args()
    memory(street_of(250), arguments.edits)  # first: memory that was once taken stays
    print("| scene | frames/s sent | ms of the last | ms from edit to points | CPU ms a frame |\n|---|---|---|---|---|")
    if CHROMIUM is None:
        raise SystemExit("there is no Chromium")
    with chromium() as browser:
        for shapes in arguments.shapes:
            layout = street_of(shapes)
            for name in arguments.sensor:
                measure(browser, layout, name, arguments.seconds)


def measure(browser: Any, layout: Layout, name: str, seconds: float) -> None:
    """Print the rows of a layout and a sensor."""
    with served(lambda: Editor(layout, (Sensor.preset(name),)), inputs_of(name, None), 8600) as studio:
        page = browser.new_page(viewport=SIZE)
        page.goto(studio.url)
        page.wait_for_selector("text=returns")
        (session,) = studio.sessions.values()
        session.join()
        page.evaluate(_FRAMES)
        row(f"{len(layout)} shapes, {name}, attached", session, seconds)
        print(f"  (drawn {page.evaluate('frames_') / seconds:.1f}/s)")
        page.close()
    alone = Session(Editor(layout, (Sensor.preset(name),)))
    row(f"{len(layout)} shapes, {name}, alone", alone, seconds)
    alone.end()


def memory(layout: Layout, edits: int) -> None:
    """Print what a session has grown by after many edits."""
    editor = Editor(layout, (Sensor.preset("vlp16"),))
    name = next(name for name in editor.names if name.startswith("car"))
    x, y, yaw = editor.world[name].pose
    peaks = []
    for number in range(edits):
        editor.move(name, x + math.sin(number), y, yaw)
        editor.commit()
        editor.scans()
        if number in (20, edits - 1):
            peaks.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
    print(f"{edits} edits and scans: {peaks[-1] - peaks[0]:.0f} MB more than after 20")


if __name__ == "__main__":
    main()
