"""A painted sketch, a colour for each class, becomes blobs and strokes."""

from __future__ import annotations

import math

import numpy as np
from scipy import ndimage

from lidardraft.drafting.sketches.colours import (
    BAR,
    EGO,
    FURTHEST_COLOUR,
    PAPER,
    UNKNOWN,
    WHITE,
    classes_of_pixels,
    filled,
    paper_of,
    unknown_colours,
    without_specks,
)
from lidardraft.drafting.sketches.drawn_shapes import (
    FURTHEST,
    MOST_SHAPES,
    Sketch,
    SketchFrame,
)
from lidardraft.drafting.sketches.mask_shapes import shapes_of_mask
from lidardraft.errors import FormatError, LayoutError
from lidardraft.semantics import BY_NAME, CLASSES, GROUND

_MOST_PIXELS = 1_000_000  # of a sketch that is read whole; of a larger one every second pixel, every third, ...
_SPECK = 8  # pixels; a smaller piece is noise
_NARROWEST = 1.0  # m, of a sketch
_LEAST_GROUND = 1.0  # m^2 of road or sidewalk
_MOST_UNKNOWN = 0.5  # of the pixels may have no class
_ROAD = BY_NAME["road"].id
_MARKING = 0.8  # m, as wide as a stripe of a crossing may be
_BAR_FILLED, _BAR_SLENDER = 0.6, 3.0  # of the rectangle around it, and times as long as wide
_GROUND = [BY_NAME[name].id for name in GROUND]
_MOVERS = [EGO, *(row.id for row in CLASSES if row.is_thing)]
_DRIVEN = 2.5  # m further away than paper, a road still goes on under a vehicle
# Colours that differ by less than noise: a piece is what most of it is nearer to.
_ALIKE = {BY_NAME["train"].id: BY_NAME["bus"].id}


def read_painting(pixels: np.ndarray, metres_per_pixel: float | None, scale_bar: float | None) -> Sketch:
    """The shapes of pixels u8 [H, W, 3].

    A metre is given by `metres_per_pixel`, or by a black bar that is `scale_bar` [m] long. The ego vehicle is where
    pure green is, or else in the middle.
    """
    height, width = pixels.shape[:2]
    step = max(1, math.ceil(math.sqrt(height * width / _MOST_PIXELS)))
    pixels = pixels[::step, ::step]
    paper = paper_of(pixels)
    found = classes_of_pixels(pixels, paper)
    if (unknown := float(np.mean(found == UNKNOWN))) > _MOST_UNKNOWN:
        raise LayoutError(f"{unknown:.0%} of the pixels have no class's colour; a sketch has one for each class")
    colours = unknown_colours(pixels, found)
    found, ignored = without_specks(found, _SPECK)
    scale = metres_per_pixel * step if metres_per_pixel else _scale_of_bar(found, scale_bar)
    marks = np.argwhere(found == EGO)
    ego = (marks.mean(axis=0) if len(marks) else (np.array(found.shape) - 1) / 2)[::-1]
    if not _NARROWEST <= (wide := scale * max(found.shape)) <= FURTHEST:
        raise LayoutError(f"the sketch is {wide:g} m wide; {_NARROWEST:g} to {FURTHEST:.0f} m are read")
    sketch = Sketch(scale / step, bool(len(marks)), ignored=colours)
    if math.dist(paper, WHITE) > FURTHEST_COLOUR:
        sketch.ignored.append(f"colour {' '.join(map(str, paper))}: taken for the paper")
    if ignored:
        sketch.ignored.append(f"{ignored / found.size:.2%} of the pixels: specks, and colours of no class")
    if metres_per_pixel and (found == BAR).any():
        sketch.ignored.append("black: the scale is given in metres per pixel")
    _read_pieces(_without_markings(found, scale), pixels, SketchFrame(ego, scale), step, sketch)
    return sketch


def _scale_of_bar(found: np.ndarray, length: float | None) -> float:
    if length is None:
        raise LayoutError(
            "a painted sketch needs metres_per_pixel (--metres-per-pixel), or a black bar and its length in metres, "
            "scale_bar (--scale-bar)"
        )
    pieces, _ = ndimage.label(found == BAR, np.ones((3, 3)))
    spans = []
    for number, box in enumerate(ndimage.find_objects(pieces), start=1):
        down, right = (part.stop - part.start for part in box)
        # letters, frames and arrows fill less of the rectangle around them, or are no longer than wide
        whole = np.count_nonzero(pieces[box] == number) >= _BAR_FILLED * down * right
        spans.append((whole and max(down, right) >= _BAR_SLENDER * min(down, right), max(down, right)))
    if not spans:
        raise LayoutError("the sketch has no black bar that could be its scale")
    return length / max(spans)[1]


def _without_markings(found: np.ndarray, scale: float) -> np.ndarray:
    """Classes [H, W] where narrow lines of paper on a road, such as lane markings and crossings, are road."""
    road, reach = np.pad(found == _ROAD, 1, mode="edge"), _MARKING / 2 / scale
    if reach < 1 or not road.any():
        return found
    near = ndimage.distance_transform_edt(~road) <= reach
    closed = (ndimage.distance_transform_edt(near) > reach) if not near.all() else near
    return np.where((found == PAPER) & closed[1:-1, 1:-1], _ROAD, found)


def _read_pieces(found: np.ndarray, pixels: np.ndarray, frame: SketchFrame, step: int, sketch: Sketch) -> None:
    ground = _ground(found, round(_DRIVEN / frame.metres_per_unit))
    standing = found.copy()
    for other, one in _ALIKE.items():
        standing[standing == other] = one
    for row in CLASSES[1:]:
        name = row.name
        on_ground = name in GROUND
        of_class = (ground if on_ground else standing) == row.id
        if name == "terrain" or not of_class.any():
            continue
        pieces, count = ndimage.label(of_class, np.ones((3, 3)))
        if count > MOST_SHAPES:
            raise FormatError(f"more than {MOST_SHAPES} shapes of one colour; is it a photograph?")
        for number, box in enumerate(ndimage.find_objects(pieces), start=1):
            mask = pieces[box] == number
            corner = np.array([part.start for part in box])
            if on_ground and np.count_nonzero(mask) * frame.metres_per_unit**2 < _LEAST_GROUND:
                continue
            label = _likely(name, pixels[box][mask])
            down, right = (np.argwhere(mask).mean(axis=0) + corner) * step
            here = SketchFrame(frame.ego - corner[::-1], frame.metres_per_unit)
            sketch.add(shapes_of_mask(mask, here, label, (), f"{label} at pixel {right:.0f}, {down:.0f}"))


def _ground(found: np.ndarray, reach: int) -> np.ndarray:
    """What is under the objects: what is nearest, but under vehicles and people a road within some pixels more."""
    ground = filled(found, ~np.isin(found, [*_GROUND, PAPER]))
    movers = np.isin(found, _MOVERS)
    if not movers.any() or not (roads := np.isin(found, _GROUND)).any():
        return ground
    to_paper = ndimage.distance_transform_edt(found != PAPER)
    to_road, (down, right) = ndimage.distance_transform_edt(~roads, return_indices=True)
    return np.where(movers & (to_road < to_paper + reach), found[down, right], ground)


def _likely(name: str, colours: np.ndarray) -> str:
    """The class of a piece among those of like colours."""
    like = [name, *(CLASSES[other].name for other, one in _ALIKE.items() if CLASSES[one].name == name)]
    mean = colours.mean(axis=0)
    return min(like, key=lambda each: float(np.linalg.norm(mean - BY_NAME[each].colour)))
