"""A scan in each format, drawn as other people's readers find it: docs/images/formats.png.

    python benches/export_pictures.py [PICTURE]

Boxes are drawn over the points; formats without boxes show objects by what they say of each point.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np

from foreign_readers import READERS, Found
from lidardraft import Box, Sensor, layout_from_text, simulate, surround
from lidardraft.drawing import Drawing, Eye
from lidardraft.formats.frame import writer_of
from lidardraft.view import caption, colour_by_height, save_png, sheet

SENTENCE = "a busy crossroads with a bus, cyclists and pedestrians"
EYE = Eye.above(width=360, height=360, reach=32.0)
ORANGE, RED = (255, 190, 70), (255, 80, 80)


def picture(name: str, found: Found, mount: float) -> np.ndarray:
    """What a reader found, from above: uint8 [360, 360, 3]."""
    drawing, points = Drawing(EYE, rings=(10, 20, 30)), found.points[:, :3] + (0.0, 0.0, mount)
    colours = colour_by_height(points[:, 2])
    said = f"{name}: {len(points):,} points"
    if found.boxes is None:
        colours[found.fields["instance"] > 0] = RED
    drawing.points(points, colours)
    if found.boxes is not None:
        boxes = [Box(each.name, "car", 1, tuple(each.center), tuple(each.size), each.yaw) for each in found.boxes]
        boxes = [box.raised(mount) for box in boxes]
        drawing.boxes(boxes, [ORANGE] * len(boxes))
        said += f", {len(boxes)} boxes"
    drawing.ego()
    return caption(drawing.picture(), said, size=13)


def main() -> None:
    """Write the picture."""
    sensor = Sensor.preset("hdl32e")
    frame = simulate(surround(layout_from_text(SENTENCE, seed=3), seed=3), sensor, seed=3).frame()
    pictures = []
    with tempfile.TemporaryDirectory() as folder:
        for name, read in READERS.items():
            writer_of(name)(Path(folder, name), [[frame]])
            pictures.append(picture(name, next(iter(read(Path(folder, name)))), sensor.mount_height))
    output = Path(sys.argv[1] if len(sys.argv) > 1 else "docs/images/formats.png")
    output.parent.mkdir(parents=True, exist_ok=True)
    save_png(output, sheet(pictures, columns=5))


if __name__ == "__main__":
    main()
