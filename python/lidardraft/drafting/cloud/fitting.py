"""Shapes around the points of an object, and the completion of its sides that the sensor did not see.

A box is a row of 7 numbers: its center (x, y, z), its size along its yaw, across and up [m], and its yaw [rad]. The z
axis passes through the sensor, so "away from the sensor" is away from x = y = 0.
"""

from __future__ import annotations

import math

import numpy as np

from lidardraft import _core
from lidardraft.drafting.cloud.rules import LONGER_THAN_WIDE, MIN_EXTENT, SEEN_WHOLE

_SLICE = 0.3  # m of height
OUTLIERS = 0.01  # of the points, at either end of an extent


def fit_box(points: np.ndarray) -> np.ndarray:
    """The box [7] whose sides fit points [N, 3] most closely. Extents are at least 0.1 m."""
    return np.array(_core.fit_box(points, OUTLIERS))


def fit_post(points: np.ndarray) -> np.ndarray:
    """The box [7] of the upright cylinder whose near side holds the points [N, 3]; its width is their usual spread
    across the line of sight."""
    middle = points[:, :2].mean(axis=0)
    away = middle / max(float(np.linalg.norm(middle)), 1e-6)
    along, across = points[:, :2] @ away, points[:, :2] @ [-away[1], away[0]]
    low, high = points[:, 2].min(), points[:, 2].max()
    slices = np.floor((points[:, 2] - low) / _SLICE).astype(int)
    widths = [np.ptp(across[slices == index]) for index in np.unique(slices)]
    width = max(float(np.median(widths)), MIN_EXTENT)
    x, y = (np.median(along) + width / 2) * away + np.median(across) * np.array([-away[1], away[0]])
    return np.array([x, y, (low + high) / 2, width, width, max(high - low, MIN_EXTENT), 0.0])


def completions(boxes: np.ndarray, size: tuple[float, float, float], headings: np.ndarray) -> np.ndarray:
    """The seven possible boxes [7, B, 7] of partly seen objects, likeliest first; `boxes` [B, 7] are their seen parts.

    `size` is the usual (length, width, height) [m] of their class, `headings` [B, rad] those of adjacent objects, NaN
    without one.

    The longer seen side is the length if it is too long for a width of the class. Else the side along the heading is
    the length, or without a heading the shorter side; the second guess is the other side. A side of at least 0.7 of the
    class's was seen whole. A shorter one grows to the class's, away from the sensor; the side across the line of sight
    may also grow to the other hand, which something may hide. The next two are these guesses for a small object, with
    sides of 0.7 of the class's. The last has the seen sides, each at least 0.7 of the class's width.
    """
    turned = boxes[:, [0, 1, 2, 4, 3, 5, 6]]
    turned[:, 6] += np.copysign(math.pi / 2, -turned[:, 6])
    lies = (boxes[:, 3] > boxes[:, 4])[:, None]
    longer, other = np.where(lies, boxes, turned), np.where(lies, turned, boxes)
    sure = is_length(longer[:, 3], size)
    along = np.abs(np.cos(longer[:, 6] - headings)) > np.abs(np.cos(other[:, 6] - headings))
    likely = np.where((sure | along)[:, None], longer, other)
    second = np.where((along & ~sure)[:, None], other, longer)
    usual = np.array(size[:2])
    small = np.tile(SEEN_WHOLE * usual, (len(boxes), 1))
    full = [
        _grown(one, np.where(one[:, 3:5] < small, usual, 0.0), hand) for one in (likely, second) for hand in (1, -1)
    ]
    return np.stack([*full, _grown(likely, small), _grown(second, small), _grown(longer, small[:, [1, 1]])])


def is_length(side: np.ndarray, size: tuple[float, float, float]) -> np.ndarray:
    """bool [B]: whether each of the seen sides [B, m] is too long to be the width of an object of the usual `size`."""
    return side > LONGER_THAN_WIDE * size[1]


def _grown(boxes: np.ndarray, least: np.ndarray, hand: int = 1) -> np.ndarray:
    """The boxes [B, 7] grown away from the sensor, to sides [B, 2] of at least `least` [m].

    With -1 for `hand` the side across the line of sight grows to the other hand.
    """
    seen = boxes[:, 3:5]
    grown = np.maximum(seen, least)
    cos, sin = np.cos(boxes[:, 6]), np.sin(boxes[:, 6])
    axes = np.stack([np.stack([cos, sin], axis=1), np.stack([-sin, cos], axis=1)], axis=1)
    along = (axes @ boxes[:, :2, None])[..., 0]
    away = np.where(along < 0, -1.0, 1.0)
    away[np.arange(len(boxes)), np.abs(along).argmin(axis=1)] *= hand
    shift = ((away * (grown - seen) / 2)[:, None] @ axes)[:, 0]
    return np.column_stack([boxes[:, :2] + shift, boxes[:, 2], grown, boxes[:, 5:]])


def contain(boxes: np.ndarray, place: np.ndarray, margin: float = 0.0) -> np.ndarray:
    """bool [B]: whether x, y [2] is in the footprint of each of the boxes [B, 7], by more than `margin` [m]."""
    x, y = (place - boxes[:, :2]).T
    cos, sin = np.cos(boxes[:, 6]), np.sin(boxes[:, 6])
    local = np.abs(np.column_stack([cos * x + sin * y, cos * y - sin * x]))
    inside: np.ndarray = (local < boxes[:, 3:5] / 2 - margin).all(axis=1)
    return inside
