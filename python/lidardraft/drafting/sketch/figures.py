"""An SVG sketch of named shapes becomes blobs and strokes."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator

import numpy as np

from lidardraft.drafting.sketch.masks import STROKE_CLASSES, shapes_of_mask
from lidardraft.drafting.sketch.painting import nearest_colour
from lidardraft.drafting.sketch.shapes import FURTHEST, Blob, Sketch, SketchFrame, Stroke, resampled
from lidardraft.drafting.sketch.svg import Figure, middle_of, read_page
from lidardraft.errors import LayoutError
from lidardraft.scene.class_names import class_of, words_of
from lidardraft.semantics import CLASSES, NUM_CLASSES

_SCALE = re.compile(r"scale[\s_:=-]*(\d+(?:\.\d+)?)[\s_-]*m(?:et(?:er|re)s?)?(?![a-z])")
_MARKINGS = ("marking", "markings", "crosswalk", "crosswalks", "zebra")
_EGO = ("ego", "sensor")
_SAME_COLOUR = 12.0  # in RGB: files hold exact colours, which programs change a little
_MASK_PIXELS = 20_000_000  # of the masks of all areas together
_MASK_SIDE, _COARSEST = (200, 1200), 60  # pixels of the longer side of one; and if there are very many
_MASK_CROSSINGS = 4_000_000  # of outlines and rows of pixels, at most, in one
_FINE = 10  # pixels across the width of an area
_THIN = 2  # pixels: the centres of pixels may miss a narrower area, whose outline is then in the mask
_SCRIBBLED = 0.6  # of its length: an open line of a blob's class with its ends nearer is an outline


def read_svg(text: str, metres_per_unit: float | None) -> Sketch:
    """The shapes of the text of an SVG file.

    The class of a shape comes from its names: Inkscape's label, the title, the id, the class; then those of its groups;
    then from its colour, if that is a class's. A shape named "scale 10 m" gives the scale by its longer side, unless
    `metres_per_unit` [m] of a CSS pixel is given; one named "ego" is at the ego vehicle.
    """
    page = read_page(text)
    marks = [figure for figure in page.figures if _says(figure, _EGO)]
    bars = [figure for figure in page.figures if _scale_said(figure) is not None]
    scale = metres_per_unit or _scale_of(bars)
    frame = SketchFrame(middle_of(marks) if marks else page.middle(), scale)
    sketch = Sketch(scale, bool(marks), ignored=page.ignored)
    if metres_per_unit and bars:
        sketch.ignored.append("the scale bar: the scale is given in metres per pixel")
    named = set(map(id, marks + bars))
    shown = [figure for figure in page.figures if id(figure) not in named]
    wanted = sum(_side([points]) ** 2 for figure in shown for points, _ in figure.pieces)
    share = math.sqrt(min(1.0, _MASK_PIXELS / max(wanted, 1.0)))
    for figure in shown:
        label = _label(figure)
        if label == "road" and _says(figure, _MARKINGS):
            sketch.ignored.append(f"{figure.where}: markings are not read")
        elif label is None:
            sketch.ignored.append(f"{figure.where}: neither its name nor its colour gives a class")
        elif label != "terrain":
            sketch.add(_shapes(figure, label, frame, share))
    return sketch


def _says(figure: Figure, words: tuple[str, ...]) -> bool:
    return any(word in words for name in figure.all_names for word in words_of(name))


def _scale_said(figure: Figure) -> float | None:
    for name in figure.all_names:
        if match := _SCALE.search(name.lower()):
            return float(match[1])
    return None


def _scale_of(bars: list[Figure]) -> float:
    """Metres of a unit."""
    if not bars:
        raise LayoutError('the sketch has no scale: name a line of it "scale 10 m", or give metres_per_pixel')
    said = _scale_said(bars[0])
    points = np.concatenate([points for bar in bars if _scale_said(bar) == said for points, _ in bar.pieces])
    long = float(np.ptp(points, axis=0).max())
    if not said or long <= 0:
        raise LayoutError(f"{bars[0].where}: a scale of {said} m that is {long} units long")
    return said / long


def _label(figure: Figure) -> str | None:
    if label := class_of(figure.all_names, {}):
        return label
    for colour in (figure.fill, figure.stroke):
        if isinstance(colour, tuple):
            away, nearest = nearest_colour(np.array(colour))
            if away <= _SAME_COLOUR and 0 < nearest < NUM_CLASSES:
                return CLASSES[int(nearest)].name
    return None


def _shapes(figure: Figure, label: str, frame: SketchFrame, share: float) -> Iterator[Blob | Stroke]:
    """The shapes of a figure; its masks get a `share` of the usual pixels to a side."""
    points = frame.to_layout(np.concatenate([points for points, _ in figure.pieces]))
    if float(np.abs(points).max()) > FURTHEST:
        raise LayoutError(f"{figure.where}: it reaches further than {FURTHEST:.0f} m from the ego vehicle")
    width = figure.stroke_width * frame.metres_per_unit
    areas = []
    for piece, closed in figure.pieces:
        line = frame.to_layout(piece)
        if figure.is_line(closed) and label in STROKE_CLASSES:
            whole = np.concatenate([line, line[:1]]) if closed else line
            yield Stroke(label, figure.names, figure.where, whole, width, closed)
        elif figure.is_line(closed) and not closed and (blob := _line_as_blob(line, width, label, figure)):
            yield blob
        else:
            areas.append(piece)
    wholes = [areas] if label in STROKE_CLASSES and areas else [[piece] for piece in areas]  # others have no holes
    for pieces in wholes:
        yield from _area(pieces, figure, label, frame, share)


def _line_as_blob(line: np.ndarray, width: float, label: str, figure: Figure) -> Blob | None:
    """A car drawn as a line from its rear to its front; None for a line that is an outline."""
    along, chord = float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum()), line[-1] - line[0]
    if float(np.linalg.norm(chord)) < _SCRIBBLED * along:
        return None
    yaw = math.atan2(chord[1], chord[0])
    return Blob(label, figure.names, figure.where, (line[0] + line[-1]) / 2, along, width, yaw, points=along > 0)


def _side(pieces: list[np.ndarray]) -> float:
    """The number of pixels for the longer side of an area's mask."""
    extent = float(np.ptp(np.concatenate(pieces), axis=0).max())
    return min(max(_FINE * extent / max(_width(pieces), 1e-9), _MASK_SIDE[0]), _MASK_SIDE[1])


def _width(pieces: list[np.ndarray]) -> float:
    """The width of a long area: twice its area over its outline; the smaller pieces are holes in the largest."""
    steps = [(piece, np.roll(piece, -1, axis=0)) for piece in pieces]
    areas = [abs(float(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]))) / 2 for a, b in steps]
    outline = sum(float(np.linalg.norm(b - a, axis=1).sum()) for a, b in steps)
    return 2 * (2 * max(areas) - sum(areas)) / max(outline, 1e-9)


def _area(
    pieces: list[np.ndarray], figure: Figure, label: str, frame: SketchFrame, share: float
) -> Iterator[Blob | Stroke]:
    """The shapes of a filled area."""
    points = np.concatenate(pieces)
    low, extent = points.min(axis=0), np.ptp(points, axis=0)
    side = max(min(share * _side(pieces), _MASK_CROSSINGS / len(points)), _COARSEST)
    unit = max(float(extent.max()) / side, 1e-9)
    across, down = (np.ceil(extent / unit) + 3).astype(int).tolist()
    lines = [(piece - low) / unit + 0.5 for piece in pieces]
    turns = _turns(lines, down, across)
    filled = turns != 0 if figure.nonzero else turns % 2 != 0
    if _width(lines) < _THIN:
        for line in lines:
            right, below = np.rint(resampled(np.concatenate([line, line[:1]]), 0.5)[0]).astype(int).T
            filled[below, right] = True
    if filled.any():
        here = SketchFrame((frame.ego - low) / unit + 0.5, frame.metres_per_unit * unit)
        yield from shapes_of_mask(filled, here, label, figure.names, figure.where)


def _turns(lines: list[np.ndarray], height: int, width: int) -> np.ndarray:
    """The winding number of closed lines [N, 2] (right, down) around the centre of each pixel, f64 [H, W]: one way > 0,
    the other < 0. The centres of a row cross the edges that go up or down there; a crossing counts for all on its
    right."""
    begins = np.concatenate(lines)
    steps = np.concatenate([np.roll(line, -1, axis=0) for line in lines]) - begins
    rows = np.ceil([begins[:, 1], begins[:, 1] + steps[:, 1]]).astype(int)
    first, counts = rows.min(axis=0), np.abs(rows[1] - rows[0])
    edge = np.repeat(np.arange(len(begins)), counts)
    row = first[edge] + np.arange(len(edge)) - (np.cumsum(counts) - counts)[edge]
    slope = steps[edge, 0] / steps[edge, 1]
    right = np.ceil(begins[edge, 0] + (row - begins[edge, 1]) * slope).astype(int)
    crossings = np.bincount(row * width + right, np.sign(steps[edge, 1]), height * width)
    turns: np.ndarray = np.cumsum(crossings.reshape(height, width), axis=1)
    return turns
