"""A real Chromium that looks at a studio in this process, and where things are on its screen.

WebGL runs in software, so that it needs no graphics card.
"""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

import numpy as np

from lidardraft.errors import LidarDraftError
from lidardraft.scene.pose import point_at

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
FLAGS = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
SIZE = {"width": 1100, "height": 760}


@contextmanager
def chromium() -> Iterator[Any]:
    """A browser, of `CHROMIUM`."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        try:
            yield browser
        finally:
            browser.close()


def until(is_so: Callable[[], object], seconds: float = 20.0) -> None:
    """Wait until it is so, also where the thread of a studio has its world just then."""
    end = time.monotonic() + seconds
    while True:
        with suppress(LidarDraftError):
            if is_so():
                return
        assert time.monotonic() < end, "it did not come to that"
        time.sleep(0.05)


def pixel_of(camera: Any, point: Any) -> tuple[float, float]:
    """Where a point in the world is on the screen of a client's camera."""
    w, x, y, z = camera.wxyz
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    right, down, ahead = turn.T @ (np.array(point) - camera.position)
    focal = camera.image_height / 2 / np.tan(camera.fov / 2)
    return camera.image_width / 2 + focal * right / ahead, camera.image_height / 2 + focal * down / ahead


def handle_of(session: Any) -> tuple[float, float]:
    """The pixel of the arrow of the gizmo that points ahead of the selected object."""
    gizmo = session.page._canvas._gizmo[1]
    tip = point_at((*gizmo.position[:2], session.editor.world[session.selected].pose[2]), 0.8 * gizmo.scale, 0.0)
    return pixel_of(session.page.client.camera, (*tip, gizmo.position[2]))
