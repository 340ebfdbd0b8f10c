"""The pictures of docs/how-to/studio.md: a studio in a real Chromium, step by step.

python benches/picture_studio.py [docs/images]
"""

from __future__ import annotations

import io
import sys
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from chromium import chromium, handle_of, pixel_of, until
from lidardraft import Sensor, layout_from_text, surround
from lidardraft.cli.studio import inputs_of
from lidardraft.studio.editor import Editor
from lidardraft.studio.page import SENTENCE
from lidardraft.studio.server import served
from lidardraft.studio.session import Session

_LARGEST = 150_000  # bytes of a file
_SIZE = {"width": 1280, "height": 760}


def save(pictures: list[Image.Image], path: Path) -> None:
    """Write pictures beside each other, as small as it has to be."""
    height = min(picture.height for picture in pictures)
    whole = Image.new("RGB", (sum(picture.width for picture in pictures) + 6 * (len(pictures) - 1), height), "white")
    left = 0
    for picture in pictures:
        whole.paste(picture, (left, 0))
        left += picture.width + 6
    for quality in range(86, 30, -6):
        content = io.BytesIO()
        whole.save(content, "JPEG", quality=quality, optimize=True)
        if content.tell() <= _LARGEST:
            break
    path.write_bytes(content.getvalue())
    print(path, content.tell())


def shot(page: Any, session: Session, clip: dict[str, int] | None = None) -> Image.Image:
    """What is on the screen when all is settled."""
    session.join()
    page.wait_for_timeout(2500)
    return Image.open(io.BytesIO(page.screenshot(clip=clip))).convert("RGB")


def press(page: Any, name: str) -> None:
    """A button of that name."""
    page.get_by_role("button", name=name, exact=True).first.click()


def choose(page: Any, label: str, option: str) -> None:
    """An option of a dropdown."""
    box = page.get_by_label(label, exact=True).first
    box.click()
    box.fill(option)
    page.get_by_role("option", name=option, exact=True).first.click()
    page.wait_for_timeout(800)


def pictures(page: Any, session: Session, folder: Path) -> None:
    """Step by step."""
    if page.locator(".mantine-Notification-closeButton").count():  # a note on WebGL in software
        page.locator(".mantine-Notification-closeButton").first.click()
    session.post(lambda one: one.select("car_8"))
    save([shot(page, session)], folder / "studio.jpg")
    view = {"x": 120, "y": 140, "width": 640, "height": 430}
    session.post(lambda one: one.page._see_from(one, "Object"))
    before = shot(page, session, view)
    x, y = handle_of(session)
    page.mouse.move(x, y)
    page.wait_for_timeout(400)
    page.mouse.down()
    for k in range(1, 9):
        page.mouse.move(x + 14 * k, y - 5 * k)
    page.mouse.up()
    until(lambda: len(session.editor.document.states) > 1)
    save([before, shot(page, session, view)], folder / "studio-drag.jpg")
    page.get_by_role("tab", name="Look").click()
    session.post(lambda one: one.page._see_from(one, "Behind"))
    choose(page, "Colours", "range")
    page.get_by_label("Labels", exact=True).first.click()
    session.join()
    page.wait_for_timeout(1500)
    frame = session.frame()
    label = frame.scans[0].layout.boxes()
    bus = next(box for box in label if box.label == "bus")
    near = frame.points[np.argmin(np.linalg.norm(frame.points - np.array(bus.center), axis=1))]
    page.mouse.click(*pixel_of(session.page.client.camera, near))
    save([shot(page, session)], folder / "studio-look.jpg")
    choose(page, "Colours", "objects and height")
    page.get_by_label("Labels", exact=True).first.click()
    page.get_by_role("tab", name="Sensor").click()
    choose(page, "Beside it", "os1-32")
    save([shot(page, session)], folder / "studio-sensor.jpg")
    choose(page, "Beside it", "none")
    page.get_by_role("tab", name="Play").click()
    press(page, "Seat")
    press(page, "Run")
    until(lambda: session.editor.world.time > 1.0, 60.0)
    press(page, "Pause")
    save([shot(page, session)], folder / "studio-play.jpg")
    page.get_by_role("tab", name="Keep").click()
    session.post(lambda one: one.page._see_from(one, "Behind"))
    press(page, "Command")
    save([shot(page, session)], folder / "studio-keep.jpg")


def main() -> None:
    """All pictures."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "docs/images")
    layout = surround(layout_from_text(SENTENCE, seed=7), seed=7)
    with (
        served(lambda: Editor(layout, (Sensor.preset("hdl64e"),), seed=7), inputs_of("hdl64e", None), 8700) as studio,
        chromium() as browser,
    ):
        page = browser.new_page(viewport=_SIZE)
        page.goto(studio.url)
        page.wait_for_selector("text=returns", timeout=60_000)
        (session,) = studio.sessions.values()
        pictures(page, session, folder)


if __name__ == "__main__":
    main()
