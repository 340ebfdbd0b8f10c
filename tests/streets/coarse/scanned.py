"""A street, and what one scan of it saw: what the tests of coarse layouts look at."""

from dataclasses import replace

import numpy as np

from lidardraft import CLASSES
from lidardraft.scene.sensor import PRESETS
from lidardraft.scene.shape_table import ShapeTable
from lidardraft.simulation.sweeps import Sweeper
from lidardraft.streets.coarse.coarse_layout import Style, coarse_layout
from lidardraft.streets.pairs import StreetScene, scan_street
from lidardraft.streets.street import make_street

STREET = make_street(seed=2)
OBJECTS = STREET.occupancy.objects
SENSOR = PRESETS["hdl64e"]
SCENE = StreetScene.of(STREET, Sweeper.of(SENSOR, None, None))
EGO, VISIBLE, _ = scan_street(SCENE, 0)
SCAN = VISIBLE.scan
NAMES = [row.name for row in CLASSES]


def made(style: Style, seed: int = 0) -> ShapeTable:
    """The coarse layout in that style."""
    return coarse_layout(STREET.coarse, style, np.random.default_rng(seed), EGO.pose, VISIBLE)


def ids(table: ShapeTable) -> set[str]:
    """The objects that a layout has shapes of."""
    return {id.partition(".")[0] for id in table.ids}


def labels(table: ShapeTable) -> set[str]:
    """The names of the classes in a layout."""
    return {NAMES[label] for label in table.labels}


def in_street(table: ShapeTable) -> ShapeTable:
    """The table of the ego vehicle's frame in that of the road."""
    x, y, yaw = VISIBLE.place
    back = table.seen_from(0.0, 0.0, -yaw)
    return replace(back, centers=back.centers + np.array([x, y, 0.0]))
