"""A piece of a sketch, as a mask of pixels, is a blob or one or more strokes."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from scipy import ndimage

from lidardraft.drafting.sketch.centre_lines import centre_lines
from lidardraft.drafting.sketch.shapes import Blob, SketchFrame, Stroke
from lidardraft.semantics import GROUND

STROKE_CLASSES = ("road", "sidewalk", "wall", "fence", "vegetation")  # which come as strokes, and as blobs too
_SLENDER = 2.5  # times as long as wide: a stroke
_NARROW = 0.5  # of the width of an area: a strip that is narrower leads to it
_ARM = 0.4  # of the square of that: what is smaller is a corner
_NEARLY_SQUARE = 1.3  # times as long as wide: moments no longer tell the direction well


def shapes_of_mask(
    mask: np.ndarray, frame: SketchFrame, label: str, names: tuple[str, ...], where: str
) -> Iterator[Blob | Stroke]:
    """What a mask bool [H, W] shows, whose pixel 0, 0 lies at 0, 0 of the frame. Outlines of objects are filled."""
    if label not in STROKE_CLASSES:
        mask = ndimage.binary_fill_holes(mask)
    slender = label in STROKE_CLASSES and _is_slender(mask)
    if label in GROUND and not slender:
        mask, arms = _without_arms(mask)
        for arm in arms:
            yield from shapes_of_mask(arm, frame, label, names, where)
    lines = list(centre_lines(mask)) if slender else []
    grain = frame.metres_per_unit
    for line in lines:
        points = frame.to_layout(line.points[:, ::-1])
        yield Stroke(label, names, where, points, line.width * grain, line.closed, grain)
    if not lines:
        points = frame.to_layout(np.argwhere(mask)[:, ::-1].astype(np.float64))
        yield Blob(label, names, where, *_rectangle(points, grain))


def _is_slender(mask: np.ndarray) -> bool:
    inner = float(ndimage.distance_transform_edt(np.pad(mask, 1)).max())
    return bool(np.count_nonzero(mask) >= _SLENDER * (2 * inner) ** 2)


def _without_arms(mask: np.ndarray) -> tuple[np.ndarray, list[np.ndarray]]:
    """An area bool [H, W] without the narrow strips that lead to it, as to a parking lot, and these strips."""
    padded = np.pad(mask, 1)
    depth = ndimage.distance_transform_edt(padded)
    reach = _NARROW * float(depth.max())
    core = (ndimage.distance_transform_edt(depth <= reach) < reach)[1:-1, 1:-1] & mask
    pieces, count = ndimage.label(mask & ~core, np.ones((3, 3)))
    sizes = np.bincount(pieces.ravel(), minlength=count + 1)
    arms = [pieces == number for number in range(1, count + 1) if sizes[number] > _ARM * reach**2]
    return (mask & ~np.any(arms, axis=0) if arms else mask), arms


def _rectangle(points: np.ndarray, grain: float) -> tuple[np.ndarray, float, float, float]:
    """Centre [2], length, width and yaw of the rectangle that has the moments of pixels at `points` [N, 2].

    A rectangle of length L has the variance L^2 / 12 along it; wobbles of an outline hardly move that.
    """
    center = points.mean(axis=0)
    off = points - center
    # a pixel is a square, and no point: its own variance is a twelfth
    covariance = off.T @ off / len(off) + np.eye(2) * grain**2 / 12
    values, vectors = np.linalg.eigh(covariance)
    yaw = math.atan2(vectors[1, 1], vectors[0, 1])
    if values[1] < _NEARLY_SQUARE**2 * values[0] and len(points) > 3:
        yaw = _tightest_yaw(off)
    axes = np.array([[math.cos(yaw), math.sin(yaw)], [-math.sin(yaw), math.cos(yaw)]])
    extents = np.sqrt(12.0 * np.diag(axes @ covariance @ axes.T))
    if extents[1] > extents[0]:
        extents, yaw = extents[::-1], yaw + math.pi / 2
    return center, float(extents[0]), float(extents[1]), yaw


def _tightest_yaw(off: np.ndarray) -> float:
    """The heading of the smallest rectangle around pixels, row by row, to a degree."""
    rows = np.flatnonzero(np.diff(off[:, 0]))  # where the next one begins: no pixel is further out than its ends
    corners = off[[0, *rows, *rows + 1, -1]]
    headings = np.deg2rad(np.arange(90.0))
    along = corners @ np.stack([np.cos(headings), np.sin(headings)])
    across = corners @ np.stack([-np.sin(headings), np.cos(headings)])
    return float(headings[np.argmin(np.ptp(along, axis=0) * np.ptp(across, axis=0))])
