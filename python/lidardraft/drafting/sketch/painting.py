"""A painted sketch, a colour for each class, becomes blobs and strokes, despite the effects of brushes and JPEG."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache
from itertools import islice

import numpy as np
from scipy import ndimage

from lidardraft.drafting.sketch.masks import around, how_many, shapes_of_mask
from lidardraft.drafting.sketch.shapes import FURTHEST, MOST_SHAPES, Sketch, SketchFrame
from lidardraft.errors import FormatError, LayoutError
from lidardraft.semantics import BY_NAME, CLASSES, GROUND, NUM_CLASSES

Colour = tuple[int, int, int]
_WHITE: Colour = (255, 255, 255)
PAPER, EGO, BAR, UNKNOWN = 0, NUM_CLASSES, NUM_CLASSES + 1, NUM_CLASSES + 2  # in addition to the ids of classes
_OTHER_COLOURS = ((0, 255, 0), (0, 0, 0))  # of the ego vehicle and of the scale bar; the paper is white
PALETTE = np.array([(255, 255, 255), *(row.colour for row in CLASSES[1:]), *_OTHER_COLOURS], dtype=np.float32)
_FURTHEST_COLOUR = 45.0  # from a colour of the palette, in RGB: noise of JPEG files and brushes
_BITS = 5  # of each channel, of the table of colours
_MIXED = 30.0  # from the line between two colours, in RGB
_DIFFERENT = 60.0  # an edge between colours closer than this cannot look like a third
_REACH = 3  # pixels that an edge is blurred over, to either side
_DARK = 96  # of 255: on paper darker than this, the scale bar is white
_LIGHT, _GREY = 180, 30  # of 255: paper is as light, or differs as little from grey
_MOST_PAPER = 0.4  # the least share of the paper's colour among the pixels along the edges
_MOST_REPORTED, _LEAST_REPORTED = 8, 0.002  # colours without a class, and the share of the pixels that each has
_LEAST_PAPER = 0.15  # of all pixels
_SAME = 2 ** (8 - _BITS)  # in each channel: colours closer than this are one in the table
_SUPPORTED = 5  # of the eight neighbours of the same class: the least away from an edge
_MOST_PIXELS = 1_000_000  # of a sketch read whole; of a larger one every second pixel is read, every third, ...
_SPECK = 8  # pixels; a smaller piece is noise
_NARROWEST = 1.0  # m, of a sketch
_LEAST_GROUND = 1.0  # m^2 of road or sidewalk
_MOST_UNKNOWN = 0.5  # the largest share of pixels without a class
_ROAD = BY_NAME["road"].id
_MARKING = 0.8  # m, the largest width of a stripe of a crossing
_BAR_FILLED, _BAR_SLENDER = 0.6, 3.0  # the least share of the rectangle around it, and times as long as wide
_GROUND = [BY_NAME[name].id for name in GROUND]
_MOVERS = [EGO, *(row.id for row in CLASSES if row.is_thing)]
_DRIVEN = 2.5  # m: a road goes on under a vehicle even if it is this much further than paper
# Colours that differ by less than noise: a piece gets the class nearest to most of it.
_ALIKE = {BY_NAME["train"].id: BY_NAME["bus"].id}


def read_painting(pixels: np.ndarray, metres_per_pixel: float | None, scale_bar: float | None) -> Sketch:
    """The shapes of pixels u8 [H, W, 3].

    The scale is `metres_per_pixel`, or that of a black bar `scale_bar` [m] long. The ego vehicle is at pure green, or
    else in the middle.
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
    if math.dist(paper, _WHITE) > _FURTHEST_COLOUR:
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
    """Classes [H, W] with narrow lines of paper on a road, such as lane markings and crossings, turned into road."""
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
    """The ground under the objects: the nearest one, but under vehicles and people a road within some more pixels."""
    ground = filled(found, ~np.isin(found, [*_GROUND, PAPER]))
    movers = np.isin(found, _MOVERS)
    if not movers.any() or not (roads := np.isin(found, _GROUND)).any():
        return ground
    to_paper = ndimage.distance_transform_edt(found != PAPER)
    to_road, (down, right) = ndimage.distance_transform_edt(~roads, return_indices=True)
    return np.where(movers & (to_road < to_paper + reach), found[down, right], ground)


def _likely(name: str, colours: np.ndarray) -> str:
    """The class of a piece among those of similar colours."""
    like = [name, *(CLASSES[other].name for other, one in _ALIKE.items() if CLASSES[one].name == name)]
    mean = colours.mean(axis=0)
    return min(like, key=lambda each: float(np.linalg.norm(mean - BY_NAME[each].colour)))


def paper_of(pixels: np.ndarray) -> Colour:
    """The colour of the paper of pixels u8 [H, W, 3]: white, or that of most of its edges if it is light or grey.

    The colour of a class is never paper, as city blocks may reach the edges.
    """
    edges = np.concatenate([pixels[0], pixels[-1], pixels[:, 0], pixels[:, -1]])
    count, colour = next(_commonest(edges))
    if count < _MOST_PAPER * len(edges) or not (colour.min() >= _LIGHT or np.ptp(colour) <= _GREY):
        return _WHITE
    if (np.abs(PALETTE[1:NUM_CLASSES] - colour) < _SAME).all(axis=1).any():
        return _WHITE
    if np.mean((np.abs(pixels[::2, ::2] - colour) < _SAME).all(axis=2)) < _LEAST_PAPER:
        return _WHITE  # a line of squared paper runs along the edge
    red, green, blue = (int(value) for value in colour)
    return red, green, blue


@lru_cache(maxsize=8)
def _palette(paper: Colour) -> np.ndarray:
    """The colours of all classes on some paper f32 [N, 3]."""
    palette = PALETTE.copy()
    palette[PAPER] = paper
    if max(paper) < _DARK:
        palette[BAR] = _WHITE
    return palette


@lru_cache(maxsize=8)
def _table(paper: Colour) -> np.ndarray:
    """The nearest colour of the palette by the leading bits of red, green and blue, u8 [2^15]."""
    levels = (np.arange(2**_BITS, dtype=np.float32) + 0.5) * 2 ** (8 - _BITS)
    colours = np.stack(np.meshgrid(levels, levels, levels, indexing="ij"), axis=-1).reshape(-1, 3)
    nearest, classes = nearest_colour(colours, _palette(paper))
    table: np.ndarray = np.where(nearest <= _FURTHEST_COLOUR, classes, UNKNOWN).astype(np.uint8)
    return table


def nearest_colour(colours: np.ndarray, palette: np.ndarray = PALETTE) -> tuple[np.ndarray, np.ndarray]:
    """The distance [...] of colours [..., 3] from the nearest colour of a palette, and its index."""
    distance = np.linalg.norm(colours[..., None, :].astype(np.float32) - palette, axis=-1)
    return distance.min(axis=-1), distance.argmin(axis=-1)


def classes_of_pixels(pixels: np.ndarray, paper: Colour = _WHITE) -> np.ndarray:
    """u8 [H, W] of pixels u8 [H, W, 3] on some paper: class ids, or `PAPER`, `EGO`, `BAR` or `UNKNOWN`.

    A pixel at an edge that mixes two colours gets the one that dominates.
    """
    short = pixels >> (8 - _BITS)
    codes = (short[..., 0].astype(np.uint16) << 2 * _BITS) | (short[..., 1].astype(np.uint16) << _BITS) | short[..., 2]
    found = _table(paper)[codes]
    down, right = np.nonzero(_at_edges(found))
    if len(down):
        found[down, right] = _unmixed(pixels, found, down, right, _palette(paper))
    return found


def _at_edges(found: np.ndarray) -> np.ndarray:
    """Whether most of the eight neighbours are of another class, bool [H, W]."""
    near = around(np.pad(found, 1, mode="edge"))
    alone: np.ndarray = how_many(each == found for each in near) < _SUPPORTED
    return alone


def _unmixed(
    pixels: np.ndarray, found: np.ndarray, down: np.ndarray, right: np.ndarray, palette: np.ndarray
) -> np.ndarray:
    """The classes of some pixels; a mixture of the classes on both sides gets that of one side."""
    height, width = found.shape
    result, open_ = found[down, right], np.ones(len(down), dtype=bool)
    colours = pixels[down, right].astype(np.float32)
    for reach in range(_REACH, 0, -1):
        for step_down, step_right in ((0, 1), (1, 0), (1, 1), (1, -1)):
            a, b = (
                (np.clip(down + s * step_down, 0, height - 1), np.clip(right + s * step_right, 0, width - 1))
                for s in (-reach, reach)
            )
            class_a, class_b = found[a], found[b]
            known = open_ & (class_a != class_b) & (class_a != UNKNOWN) & (class_b != UNKNOWN)
            first, second = palette[np.where(known, class_a, 0)], palette[np.where(known, class_b, 0)]
            way = second - first
            length = np.maximum((way**2).sum(axis=1), 1.0)
            share = ((colours - first) * way).sum(axis=1) / length
            off = np.linalg.norm(colours - first - share[:, None] * way, axis=1)
            mixed = known & (length > _DIFFERENT**2) & (off < _MIXED) & (share > 0.08) & (share < 0.92)
            result[mixed] = np.where(share < 0.5, class_a, class_b)[mixed]
            open_ &= ~mixed
    return result


def unknown_colours(pixels: np.ndarray, found: np.ndarray) -> list[str]:
    """A line for each of the commonest colours of pixels u8 [H, W, 3] that have no class."""
    lines = []
    for count, colour in islice(_commonest(pixels[found == UNKNOWN]), _MOST_REPORTED):
        if (share := count / found.size) >= _LEAST_REPORTED:
            said = " ".join(f"{value:.0f}" for value in colour)
            lines.append(f"colour {said}, {share:.1%} of the pixels: no class has it")
    return lines


def _commonest(pixels: np.ndarray) -> Iterator[tuple[int, np.ndarray]]:
    """The number of pixels u8 [N, 3] of nearly one colour, and that colour [3]; the commonest one first."""
    codes = (pixels >> (8 - _BITS)).astype(np.int64) @ [1, 2**_BITS, 4**_BITS]
    values, counts = np.unique(codes, return_counts=True)
    for index in np.argsort(-counts, kind="stable").tolist():
        yield counts[index], np.median(pixels[codes == values[index]], axis=0)


def without_specks(found: np.ndarray, least: int) -> tuple[np.ndarray, int]:
    """Classes u8 [H, W] in which lines of one pixel, pieces of fewer than `least` pixels and pixels without a class got
    the class of the nearest other pixel; and the number of those pixels."""
    speck = np.ones(found.shape, dtype=bool)
    for value in np.unique(found[found != UNKNOWN]).tolist():
        pieces, _ = ndimage.label(ndimage.binary_opening(found == value, np.ones((2, 2))), np.ones((3, 3)))
        large = np.bincount(pieces.ravel()) >= least
        large[0] = False
        speck &= ~large[pieces]
    return filled(found, speck), int(np.count_nonzero(speck))


def filled(found: np.ndarray, gone: np.ndarray) -> np.ndarray:
    """`found` [H, W] in which each pixel of `gone` has the value of the nearest remaining one."""
    if not gone.any():
        return found
    if gone.all():
        return np.full_like(found, PAPER)
    down, right = ndimage.distance_transform_edt(gone, return_distances=False, return_indices=True)
    values: np.ndarray = found[down, right]
    return values
