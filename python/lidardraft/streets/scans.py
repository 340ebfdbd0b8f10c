"""Labelled scans of procedural streets."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from lidardraft.errors import check_number, check_seed
from lidardraft.simulation.carrier import carried
from lidardraft.streets.coarse.coarse_layout import BoxStyle, as_boxes
from lidardraft.streets.pairs import as_sent, scan_street, street_scene
from lidardraft.streets.street import StreetConfig

if TYPE_CHECKING:
    from lidardraft.scan import Scan
    from lidardraft.scene.layout import Layout


def street_scan(
    index: int,
    *,
    seed: int = 0,
    config: StreetConfig | None = None,
    carrier: bool | Layout = True,
    threads: int | None = None,
) -> Scan:
    """The scan of pair `index` of `streets(seed=seed, config=config)`, with all its objects as its layout.

    `config.poses_per_street` scans in a row are of one street, which is built once. The layout holds simple shapes on
    the ground with its relief; the detailed street is scanned, from a `carrier` as in `simulate`. The same arguments
    give the same scan, for any number of threads. Raises `LayoutError` for a number that is negative or no integer.
    """
    from lidardraft.scan import Scan  # pictures come with it, which pairs do not need

    seed, index = check_seed(seed), check_number("index", index)
    config = config or StreetConfig()
    found = carried(config.sensor, carrier)
    config = replace(config, sensor=found.sensor)
    number = index // config.poses_per_street
    scene = street_scene(seed, config, number, threads)
    street, (ego, visible, _) = scene.street, scan_street(scene, index)
    provenance = {"source": "streets", "seed": seed, "index": index, "district": street.district}
    shapes = as_boxes(street.coarse, BoxStyle(relief=True), ego.pose)
    layout = street.with_roads(shapes.layout(provenance, intent=street.scene.intent), ego.pose, relief=True)
    ahead = (1.0, 0.0, 0.0)  # in the layout's frame, which is fixed to the road; the sensor leans with the car's body
    image, pose = as_sent(visible.scan), visible.pose
    return Scan(image=image, layout=layout, pose=pose, seed=seed, speed=ego.speed, heading=ahead, assumed=found.notes)
