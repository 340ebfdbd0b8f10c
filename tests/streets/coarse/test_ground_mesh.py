"""The ground of coarse layouts, with relief."""

import numpy as np
from scanned import NAMES, STREET

from lidardraft.scene.raycast import Raycaster
from lidardraft.streets.coarse.as_boxes import BoxStyle, as_boxes


def test_the_mesh_follows_the_ground():
    rng = np.random.default_rng(0)
    along, across = rng.uniform(-30, 30, 60), rng.uniform(-1, 1, 60) * STREET.occupancy.road.edge
    caster = Raycaster(as_boxes(STREET.coarse, BoxStyle(relief=True), np.eye(4)).layout({}))
    places = np.array([STREET.occupancy.road.at(s, d)[:2] for s, d in zip(along, across, strict=True)])
    hits = caster.cast(np.column_stack([places, np.full(60, 60.0)]), np.tile([0.0, 0.0, -1.0], (60, 1)))
    bare = hits.label == NAMES.index("road")
    true = np.array([STREET.occupancy.ground.height(s, d) for s, d in zip(along, across, strict=True)])
    wrong = np.abs(60.0 - hits.distance - true)[bare]
    assert bare.mean() > 0.5
    assert np.median(wrong) < 0.03
    assert wrong.max() < 0.2
