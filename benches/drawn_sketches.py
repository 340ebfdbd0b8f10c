"""Sketches of known scenes, as a hand would draw them: what the tests and the report of sketches read."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

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


def crossroads() -> np.ndarray:
    """The painted example: a crossroads with a scale bar of 10 m, the ego vehicle marked."""
    shapes: list[DrawnBox | DrawnLine] = [
        DrawnLine("road", np.array([(-40.0, 0.0), (40.0, 0.0)]), 7.4),
        DrawnLine("road", np.array([(16.0, -40.0), (16.0, 40.0)]), 6.6),
        *(DrawnLine("sidewalk", np.array([(-40.0, y), (11.5, y)]), 2.0) for y in (-4.9, 4.9)),
        *(DrawnLine("sidewalk", np.array([(20.5, y), (40.0, y)]), 2.0) for y in (-4.9, 4.9)),
        DrawnLine("vegetation", np.array([(-38.0, -7.6), (-12.0, -7.6)]), 1.1),
        DrawnLine("wall", np.array([(24.0, -8.5), (37.0, -8.5), (37.0, -20.0)]), 0.5),
        DrawnLine("fence", np.array([(-36.0, 7.6), (-6.0, 7.6)]), 0.4),
        DrawnBox("building", (-28.0, 15.0), 14.0, 9.0, 0.05),
        DrawnBox("building", (-8.0, 15.0), 11.0, 9.5, -0.1),
        DrawnBox("building", (30.0, 18.0), 12.0, 12.0, 0.5),
        DrawnBox("building", (-22.0, -18.0), 16.0, 10.0, 0.0),
        DrawnBox("vegetation", (4.0, 9.0), 4.5, 4.5, 0.3),
        DrawnBox("vegetation", (-4.0, -13.0), 5.5, 5.5, 0.6),
        DrawnBox("vegetation", (26.0, -14.0), 4.0, 4.0, 0.1),
        DrawnBox("car", (8.0, 1.9), 4.4, 1.8, math.pi + 0.05),
        DrawnBox("car", (-24.0, -2.2), 4.2, 1.8, 0.0),
        DrawnBox("car", (17.8, 14.0), 4.5, 1.9, math.pi / 2 - 0.06),
        DrawnBox("bus", (29.0, 1.9), 11.5, 2.6, math.pi),
        DrawnBox("bicycle", (-14.0, -3.0), 1.8, 0.7, 0.1),
        DrawnBox("person", (10.0, -5.0), 0.8, 0.8, 0.0),
        DrawnBox("person", (22.0, 5.0), 0.8, 0.8, 0.0),
        DrawnBox("traffic-light", (11.0, -5.6), 0.9, 0.9, 0.0),
        DrawnBox("pole", (-18.0, -5.6), 0.8, 0.8, 0.0),
    ]
    return painted(shapes, ego=(-8.0, -1.9), hand=Hand(7, 0.12), bar=10.0)


def bend() -> str:
    """The example of named shapes: a bend with a side road, drawn freehand, as the text of an SVG file."""
    hand = Hand(11, 0.12)

    def path(name: str, points: list[tuple[float, float]], *, width: float | None = None, colour: str = "gray") -> str:
        line = hand.outline(np.array(points), closed=width is None, step=1.0)
        data = " ".join(f"{'L' if k else 'M'}{x:.2f} {y:.2f}" for k, (x, y) in enumerate(line.tolist()))
        look = f'fill="{colour}"' if width is None else f'fill="none" stroke="{colour}" stroke-width="{width}"'
        return f'<path id="{name}" d="{data}{" Z" if width is None else ""}" {look}/>'

    def box(name: str, x: float, y: float, across: float, down: float, turn: float, colour: str = "gray") -> str:
        corners = DrawnBox("car", (x, y), across, down, math.radians(turn)).corners()
        return path(name, [tuple(corner) for corner in corners.tolist()], colour=colour)

    road = [(44 - 14 * (t / 80) ** 2, 98.0 - t) for t in range(0, 97, 4)]
    rows = [
        '<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" '
        'width="180mm" height="200mm" viewBox="0 0 90 100">',
        "<title>a bend with a side road, a unit is a metre</title>",
        '<g inkscape:label="ground">',
        path("road", road, width=7, colour="dimgray"),
        path("side road", [(43, 66), (90, 63)], width=6, colour="dimgray"),
        path("sidewalk", [(49, 98), (48.7, 84), (48.3, 71)], width=2, colour="silver"),
        "</g>",
        '<g inkscape:label="parked cars">',
        *(box(f"car-{k}", 41.2 - 0.1 * k, 92.0 - 7 * k, 1.8, 4.3, 1.0 + k, "navy") for k in range(4)),
        "</g>",
        box("bus", 38.6, 38.0, 2.6, 11.5, -17.0, "teal"),
        box("delivery van", 66.0, 66.0, 5.2, 2.0, -4.0, "navy"),
        '<line class="cyclist" x1="46.6" y1="60" x2="46" y2="58.3" stroke="red" stroke-width="0.6"/>',
        path("hedge", [(53, 96), (52.5, 84), (53, 72)], width=1.0, colour="olive"),
        path("garden wall", [(60, 72), (78, 71), (79, 84)], width=0.3, colour="black"),
        path("row of trees", [(34, 92), (33.5, 76), (32, 60)], width=4.0, colour="green"),
        box("house", 66, 84, 13, 9, 4.0),
        box("house", 18, 82, 10, 12, -3.0),
        box("office tower", 62, 46, 18, 15, 10.0),
        *(f'<circle class="tree" cx="{x}" cy="{y}" r="{r}" fill="green"/>' for x, y, r in ((22, 40, 2.4), (25, 30, 3))),
        '<circle id="street lamp" cx="48.6" cy="78" r="0.4"/>',
        '<line class="pedestrian" x1="49" y1="88" x2="49" y2="87.4" stroke="crimson" stroke-width="0.6"/>',
        '<ellipse id="ego" cx="45.6" cy="82" rx="1" ry="2.2" fill="lime"/>',
        '<line id="scale 10 m" x1="3" y1="97" x2="13" y2="97" stroke="black" stroke-width="0.5"/>',
        '<text x="3" y="95" font-size="3">10 m</text>',
        "</svg>",
    ]
    return "\n".join(rows) + "\n"


def main() -> None:
    """Write both examples into a folder."""
    folder = Path(sys.argv[1])
    Image.fromarray(crossroads()).save(folder / "crossroads.png", optimize=True)
    (folder / "bend.svg").write_text(bend())


if __name__ == "__main__":
    main()
