"""A recorded sweep beside its layouts: `python benches/picture_cloud.py [--data FOLDER] [-o clouds.png]`.

The sweep is one of PandaSet's (Xiao et al., ITSC 2021; CC BY 4.0), in FOLDER (by default LIDARDRAFT_DATA).
"""

from __future__ import annotations

import argparse
import os
from pathlib import Path

import numpy as np

import recordings
from lidardraft import layout_from_cloud, view
from lidardraft.scene.sensor import PRESETS


def main() -> None:
    """Write the picture."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--data", type=Path, default=os.environ.get("LIDARDRAFT_DATA"), metavar="FOLDER")
    parser.add_argument("-o", "--output", type=Path, default="clouds.png", metavar="PICTURE.png")
    given = parser.parse_args()
    if given.data is None:
        parser.error("give the folder of the recordings as --data or LIDARDRAFT_DATA")
    sensor = PRESETS["pandar64"]
    sweep = recordings.pandar64(given.data, 1800).labelled["PandaSet 002"][0]
    assert sweep.label is not None
    seen = sweep.valid & (sweep.label > 0)
    points, labels = sweep.points[seen], sweep.label[seen]
    picture = view.render_points(points + np.array([0.0, 0.0, sensor.mount_height]), view.colour_by_label(labels))
    pictures = [view.caption(picture, "PandaSet: returns by class")]
    for detail in ("fine", "objects"):
        layout = layout_from_cloud(points, labels, sensor_height=sensor.mount_height, detail=detail)
        picture = view.render_layout(layout)
        pictures.append(view.caption(picture, f'detail="{detail}": {len(layout)} shapes'))
    view.save_png(given.output, view.stack(pictures))


if __name__ == "__main__":
    main()
