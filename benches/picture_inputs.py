"""The pictures of docs: each input with the layout that it becomes.

`python benches/picture_inputs.py docs/images` writes them anew; `tests/benches/test_report_inputs.py` says when.
"""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from PIL import Image

import lidardraft
from lidardraft.drafting.picture.camera import Pinhole
from lidardraft.drafting.solver.layout import layout_from_spec
from lidardraft.drafting.solver.scene_spec import SceneSpec
from lidardraft.scene.layout import Layout
from lidardraft.view import caption, render_from_above, render_layout, render_scan, save_png, stack
from rendered_pictures import render

SENTENCE = "a busy crossroads, a bus turning left, people on the right pavement, trees and houses on both sides"
SKETCHES = Path(__file__).parents[1] / "examples" / "sketches"
MODELS_PAGE = Path(__file__).parents[1] / "docs" / "how-to" / "language-models.md"


def pictures() -> Iterator[tuple[str, np.ndarray]]:
    """Name and pixels u8 [H, W, 3] of each picture."""
    layout = lidardraft.layout_from_text(SENTENCE, seed=1)
    yield "sentences", _shown(layout)
    yield "boxes", _shown(lidardraft.layout_from_boxes(layout.boxes()))
    yield "language-models", _shown(layout_from_spec(_reply_of_the_page()))
    yield "images", _photograph()
    with Image.open(SKETCHES / "crossroads.png") as image:
        sheet = np.asarray(image.convert("RGB").resize((480, 480), Image.Resampling.BOX))
    painted = lidardraft.layout_from_sketch(SKETCHES / "crossroads.png", scale_bar=10.0)
    named = lidardraft.layout_from_sketch(SKETCHES / "bend.svg")
    rows = [[caption(sheet, "crossroads.png"), _shown(painted)], [_shown(named, "bend.svg as a layout"), _cast(named)]]
    yield "sketches", stack([stack(row, across=True) for row in rows])


def _reply_of_the_page() -> SceneSpec:
    """What a language model wrote, as the page shows it."""
    return SceneSpec.from_dict(json.loads(MODELS_PAGE.read_text(encoding="utf-8").split("```json")[1].split("```")[0]))


def _photograph() -> np.ndarray:
    """A rendered picture, and what its layout shows."""
    sentence = "a street with three parked cars on the left, two cars ahead, a person on the right, trees and houses"
    picture = render(lidardraft.layout_from_text(sentence, seed=3), Pinhole.from_hfov(math.radians(80), 720, 480))
    known = {"depth": picture.depth, "semantics": picture.labels, "hfov": math.radians(80)}
    layout = lidardraft.layout_from_image(picture.pixels, **known)
    return stack([caption(picture.pixels, "picture"), _shown(layout)], across=True)


def _shown(layout: Layout, name: str = "layout") -> np.ndarray:
    return stack([caption(render_from_above(layout), name), render_layout(layout)], across=True)


def _cast(layout: Layout) -> np.ndarray:
    """What a sensor sees of it, bare: the sensor model, which may change, has no part in these pictures."""
    sensor = lidardraft.Sensor.preset("hdl64e")
    cast = render_scan(lidardraft.raycast(layout, sensor), sensor.pose(), by_label=True)
    return caption(cast[:, :480], "its cast, by class")


def main() -> None:
    """Write the pictures into a folder."""
    for name, picture in pictures():
        save_png(Path(sys.argv[1]) / f"{name}.png", picture)


if __name__ == "__main__":
    main()
