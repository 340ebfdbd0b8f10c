"""The relief of the land of a street around a layout: that of streets, but level under the ego vehicle and under the
objects that were asked for."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from lidardraft.arranging.ground import Ground, graded
from lidardraft.scene.pose import Place, point_at
from lidardraft.scene.relief import Relief

_WHEELS = np.array([(1.35, 0.8), (1.35, -0.8), (-1.35, 0.8), (-1.35, -0.8)])  # m, x, y of the ego vehicle's wheels
_REACH = 150.0  # m of the lines over a bend
_TURN, _MIDDLE = 1.0, 0.5  # rad before the far side of a bend, and share of its radius, over which its land is level
_SHOULDER = 3.0  # m from the road, over which the land beside it may change its height
_APRON = 6.0  # m around a level area, over which the land comes to its height


def drawn_relief(
    ground: Ground, place: Place, ego: Place, level: Iterable[tuple[Place, tuple[float, float]]]
) -> Relief:
    """The relief of a `ground` whose road frame is at `place` in the layout.

    The ego vehicle is at `ego` in that frame; the relief is 0 and even there. Off the road it is level in the
    rectangles `level`.
    """
    road = ground.road
    if road.curvature:
        x = y = graded(_REACH)
    else:
        along, across = ground.relief_lines()
        x, y = along, across - road.lane(road.ego_lane)
    points = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
    along, across = road.along_across(points[..., 0], points[..., 1])
    heights = ground.rises(along, across) * _share(road.curvature, along, across)
    relief = Relief(x, y, heights)
    wheels = np.column_stack(point_at(ego, *_WHEELS.T))
    plane, *_ = np.linalg.lstsq(np.column_stack([wheels, np.ones(4)]), relief.at(wheels), rcond=None)
    heights = heights - points @ plane[:2] - plane[2]
    cell = np.maximum(np.gradient(x)[:, None], np.gradient(y)[None, :])
    off_road = np.clip((np.abs(across) - road.verge) / _SHOULDER, 0.0, 1.0)
    for spot, (length, width) in level:
        here = Relief(x, y, heights).at(np.array([spot[:2]]))[0]
        away = points - spot[:2]
        turned = [(math.cos(spot[2]), math.sin(spot[2]), length), (-math.sin(spot[2]), math.cos(spot[2]), width)]
        out = [np.maximum(np.abs(away @ (a, b)) - extent / 2 - cell, 0.0) for a, b, extent in turned]
        share = off_road * np.clip(1.0 - np.hypot(*out) / _APRON, 0.0, 1.0)
        heights = heights + share * (here - heights)
    row, column = (int(np.searchsorted(lines, at, side="right")) for lines, at in zip((x, y), ego, strict=False))
    heights[row - 1 : row + 1, column - 1 : column + 1] = 0.0
    return Relief(x, y, heights, place)


def _share(curvature: float, along: np.ndarray, across: np.ndarray) -> np.ndarray | float:
    """The share of its relief that land in a bend keeps: none in its middle and on the far side, to avoid breaks."""
    if not curvature:
        return 1.0
    around = np.clip((math.pi - np.abs(curvature * along)) / _TURN, 0.0, 1.0)
    share: np.ndarray = around * np.clip(np.abs(1.0 - curvature * across) / _MIDDLE, 0.0, 1.0)
    return share
