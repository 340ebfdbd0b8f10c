"""Sketches of known scenes, as a hand would draw them: what the tests and the report of sketches read."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from PIL import Image, ImageDraw

from lidardraft.semantics import BY_NAME

PAPER, INK = (255, 255, 255), (0, 0, 0)
_FINE = 3  # times as many pixels are drawn to each side, for smooth edges


@dataclass(frozen=True, slots=True, eq=False)
class DrawnBox:
    """A rectangle of the layout's frame in the colour of a class: centre, length, width [m] and yaw [rad]."""

    label: str
    center: tuple[float, float]
    length: float
    width: float
    yaw: float

    def corners(self) -> np.ndarray:
        """The outline [4, 2] in the layout's frame."""
        half = np.array([(1, 1), (1, -1), (-1, -1), (-1, 1)]) * (self.length / 2, self.width / 2)
        cos, sin = math.cos(self.yaw), math.sin(self.yaw)
        corners: np.ndarray = half @ np.array([[cos, sin], [-sin, cos]]) + self.center
        return corners


@dataclass(frozen=True, slots=True, eq=False)
class DrawnLine:
    """A line [N, 2] of the layout's frame with a width [m]."""

    label: str
    line: np.ndarray
    width: float


class Hand:
    """Draws outlines that wobble by some metres, the same for the same seed."""

    def __init__(self, seed: int, wobble: float) -> None:
        self._rng = np.random.default_rng(seed)
        self._wobble = wobble

    def outline(self, corners: np.ndarray, *, closed: bool = True, step: float = 0.5) -> np.ndarray:
        """Points [N, 2] along a polyline, off it by a slow wobble."""
        ends = np.concatenate([corners, corners[:1]]) if closed else corners
        away = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(ends, axis=0), axis=1))])
        count = max(2, math.ceil(away[-1] / step) + 1)
        places = np.linspace(0.0, away[-1], count)
        line = np.stack([np.interp(places, away, ends[:, axis]) for axis in (0, 1)], axis=1)
        off = np.zeros_like(line)
        for waves in (3, 5, 9):
            phases, size = self._rng.uniform(0, math.tau, 2), self._rng.normal(0.0, self._wobble / math.sqrt(3), 2)
            off += size * np.sin(math.tau * waves * places[:, None] / max(away[-1], 1e-9) + phases)
        return (line + off)[: -1 if closed else None]


def _quads(line: np.ndarray, width: float) -> Iterator[np.ndarray]:
    """The area of a stroke along a line [N, 2]: corners [4, 2] or more of pieces that leave no gap."""
    turns = np.linspace(0.0, math.tau, 17)[:-1]
    disc = np.stack([np.cos(turns), np.sin(turns)], axis=1) * width / 2
    for a, b in pairwise(line):
        ahead = (b - a) / max(float(np.linalg.norm(b - a)), 1e-9)
        left = np.array([-ahead[1], ahead[0]]) * width / 2
        yield np.array([a + left, b + left, b - left, a - left])
    for point in line[1:-1]:
        yield point + disc


def painted(
    shapes: list[DrawnBox | DrawnLine],
    *,
    metres_per_pixel: float = 0.1,
    size: tuple[int, int] = (800, 800),
    ego: tuple[float, float] | None = None,
    hand: Hand | None = None,
    bar: float | None = None,
) -> np.ndarray:
    """A painted sketch of shapes, first to last, u8 [H, W, 3]; the middle of the picture is the ego vehicle.

    `ego` marks the ego vehicle there [m] instead; `bar` draws a scale bar of that length [m].
    """
    hand = hand or Hand(0, 0.0)
    width, height = size
    canvas = Image.new("RGB", (width * _FINE, height * _FINE), PAPER)
    pen = ImageDraw.Draw(canvas)

    def pixels(points: np.ndarray) -> list[tuple[float, float]]:
        middle = np.array([width, height]) * _FINE / 2
        places = middle - np.asarray(points, dtype=np.float64)[:, ::-1] * _FINE / metres_per_pixel
        return [tuple(place) for place in places.tolist()]

    for shape in shapes:
        colour = BY_NAME[shape.label].colour
        if isinstance(shape, DrawnBox):
            pen.polygon(pixels(hand.outline(shape.corners())), fill=colour)
        else:
            for quad in _quads(hand.outline(shape.line, closed=False), shape.width):
                pen.polygon(pixels(quad), fill=colour)
    if ego is not None:
        (x, y), radius = pixels(np.array([ego]))[0], 0.8 / metres_per_pixel * _FINE
        pen.ellipse((x - radius, y - radius, x + radius, y + radius), fill=(0, 255, 0))
    if bar is not None:
        x, y = 20 * _FINE, (height - 20) * _FINE
        pen.rectangle((x, y - 5 * _FINE, x + bar / metres_per_pixel * _FINE - 1, y), fill=INK)
    return np.asarray(canvas.resize(size, Image.Resampling.BOX))
