"""An SVG sketch of named shapes becomes blobs and strokes."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator

import numpy as np
from PIL import Image, ImageChops, ImageDraw

from lidardraft.drafting.sketches.colours import nearest_colour
from lidardraft.drafting.sketches.drawn_shapes import FURTHEST, Blob, Sketch, SketchFrame, Stroke
from lidardraft.drafting.sketches.mask_shapes import STROKE_CLASSES, shapes_of_mask
from lidardraft.drafting.sketches.svg_document import Figure, read_page
from lidardraft.errors import LayoutError
from lidardraft.scene.class_names import class_of, words_of
from lidardraft.semantics import CLASSES, NUM_CLASSES

_SCALE = re.compile(r"scale[\s_:=-]*(\d+(?:\.\d+)?)[\s_-]*m(?:et(?:er|re)s?)?(?![a-z])")
_MARKINGS = ("marking", "markings", "crosswalk", "crosswalks", "zebra")
_EGO = ("ego", "sensor")
_SAME_COLOUR = 12.0  # in RGB: files say colours exactly, programs change them by little
_MASK_PIXELS = 20_000_000  # of the masks of all areas together
_MASK_SIDE = (60, 1200)  # pixels of the longer side of one
_MASK_WORK = 12_000_000  # rows times corners: filling an area asks each corner in each row
_SCRIBBLED = 0.6  # of its length: an open line of a blob's class whose ends are nearer is its outline


def read_svg(text: str, metres_per_unit: float | None) -> Sketch:
    """The shapes of the text of an SVG file.

    Its names say what a shape is: Inkscape's label, the title, the id, the class; then those of the groups that it is
    in; then its colour, if that is one of a class. A shape named "scale 10 m" says the scale by its longer side,
    unless `metres_per_unit` [m] of a CSS pixel is given; one named "ego" says where the ego vehicle is.
    """
    page = read_page(text)
    marks = [
        figure for figure in page.figures if any(word in _EGO for name in figure.all_names for word in words_of(name))
    ]
    bars = [figure for figure in page.figures if _scale_said(figure) is not None]
    scale = metres_per_unit or _scale_of(bars)
    frame = SketchFrame(_middle(marks) if marks else page.middle(), scale)
    sketch = Sketch(scale, bool(marks), ignored=page.ignored)
    if metres_per_unit and bars:
        sketch.ignored.append("the scale bar: the scale is given in metres per pixel")
    named = set(map(id, marks + bars))
    shown = [figure for figure in page.figures if id(figure) not in named]
    side = math.sqrt(_MASK_PIXELS / max(len(shown), 1))
    for figure in shown:
        label = _label(figure)
        if label == "road" and any(word in _MARKINGS for name in figure.all_names for word in words_of(name)):
            sketch.ignored.append(f"{figure.where}: markings are not read")
        elif label is None:
            sketch.ignored.append(f"{figure.where}: neither a name nor a colour says its class")
        elif label != "terrain":
            sketch.add(_shapes(figure, label, frame, min(max(side, _MASK_SIDE[0]), _MASK_SIDE[1])))
    return sketch


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


def _middle(figures: list[Figure]) -> np.ndarray:
    points = np.concatenate([points for figure in figures for points, _ in figure.pieces])
    middle: np.ndarray = (points.min(axis=0) + points.max(axis=0)) / 2
    return middle


def _label(figure: Figure) -> str | None:
    if label := class_of(figure.all_names, {}):
        return label
    for colour in (figure.style.fill, figure.style.stroke):
        if isinstance(colour, tuple):
            away, nearest = nearest_colour(np.array(colour))
            if away <= _SAME_COLOUR and 0 < nearest < NUM_CLASSES:
                return CLASSES[int(nearest)].name
    return None


def _shapes(figure: Figure, label: str, frame: SketchFrame, side: float) -> Iterator[Blob | Stroke]:
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
    if label in STROKE_CLASSES and areas:  # a hole is a piece of its own
        yield from _area(areas, figure, label, frame, side)
        return
    for piece in areas:
        yield from _area([piece], figure, label, frame, side)


def _line_as_blob(line: np.ndarray, width: float, label: str, figure: Figure) -> Blob | None:
    """A car that is drawn as a line from its rear to its front; None for a line that runs around something."""
    along, chord = float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum()), line[-1] - line[0]
    if float(np.linalg.norm(chord)) < _SCRIBBLED * along:
        return None
    yaw = math.atan2(chord[1], chord[0])
    return Blob(label, figure.names, figure.where, (line[0] + line[-1]) / 2, along, width, yaw, points=along > 0)


def _area(
    pieces: list[np.ndarray], figure: Figure, label: str, frame: SketchFrame, side: float
) -> Iterator[Blob | Stroke]:
    """What a filled area is; where its pieces lie in each other the inner one is a hole."""
    points = np.concatenate(pieces)
    side = min(side, max(_MASK_WORK / len(points), _MASK_SIDE[0]))
    low, extent = points.min(axis=0), float(np.ptp(points, axis=0).max())
    unit = max(extent / side, 1e-9)
    size = tuple((np.ceil(np.ptp(points, axis=0) / unit) + 3).astype(int).tolist())
    mask = Image.new("1", size)
    for piece in pieces:
        one = Image.new("1", size)
        ImageDraw.Draw(one).polygon([tuple(place) for place in ((piece - low) / unit + 1).tolist()], fill=1)
        mask = ImageChops.logical_xor(mask, one)
    filled = np.asarray(mask)
    if filled.any():
        here = SketchFrame((frame.ego - low) / unit + 1, frame.metres_per_unit * unit)
        yield from shapes_of_mask(filled, here, label, figure.names, figure.where)
