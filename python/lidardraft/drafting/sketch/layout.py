"""A sketch from above, painted or of named shapes, becomes a layout; up on the sheet is ahead of the ego vehicle."""

from __future__ import annotations

import math
import os
from collections import Counter
from collections.abc import Iterator
from itertools import count
from pathlib import Path

import numpy as np

from lidardraft.drafting.sketch.figures import read_svg
from lidardraft.drafting.sketch.objects import NotDrawnError, Placed, objects_of_blob, objects_of_stroke
from lidardraft.drafting.sketch.painting import read_painting
from lidardraft.drafting.sketch.shapes import Blob, Sketch, Stroke
from lidardraft.drafting.sketch.surfaces import (
    DrawnSurface,
    Nearest,
    drawn_surfaces,
    ground_primitives,
    heading,
    height_at,
)
from lidardraft.errors import FormatError, LayoutError, check_seed, check_type
from lidardraft.files import named, read_text
from lidardraft.formats.picture import opened_picture
from lidardraft.json_fields import is_number
from lidardraft.objects.coarse_shapes import CoarseShape
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.road_surfaces import terrain
from lidardraft.semantics import BY_NAME, GROUND

_EXTENT = 200.0  # m of terrain to each side, or more for a larger sketch
_MOST_OBJECTS = 20_000
_MOST_PIXELS = 2**25  # of a picture; several copies of it are in memory at once
_MOST_LINES = 40  # on ignored content


def layout_from_sketch(
    sketch: np.ndarray | str | os.PathLike[str],
    *,
    metres_per_pixel: float | None = None,
    scale_bar: float | None = None,
    seed: int = 0,
) -> Layout:
    """The layout of a sketch: the path of a picture (PNG, JPEG, WebP) or of an .svg file, or pixels u8 [H, W, 3].

    In a picture the colours of `semantics.CLASSES` give the classes, white is paper, pure green marks the ego vehicle
    and black is a scale bar, `scale_bar` [m] long. In an SVG file the names of shapes or of their groups give the
    classes, or else these colours; "ego" is the ego vehicle and "scale 10 m" the scale. `metres_per_pixel` replaces a
    scale. Without a mark the ego vehicle is in the middle.

    Values that a view from above leaves open, such as heights, are drawn at random from `seed`. `layout.provenance`
    lists in "understood" the number of objects of each kind; `layout.notes` list the omissions.

    Raises `FormatError` if the file is broken, `LayoutError` if it has no scale or shows nothing.
    """
    check_type("sketch", sketch, np.ndarray, str, os.PathLike)
    for name, value in (("metres_per_pixel", metres_per_pixel), ("scale_bar", scale_bar)):
        if value is not None and not (is_number(value) and value > 0):
            raise LayoutError(f"{name} is {value!r}; it must be a finite number of metres > 0")
    seed = check_seed(seed)
    if isinstance(sketch, np.ndarray):
        return _layout(_painting(sketch, metres_per_pixel, scale_bar), "sketch", seed)
    path = Path(sketch)
    if path.suffix.lower() == ".svg":
        text = read_text(path)
        with named(path):
            return _layout(read_svg(text, metres_per_pixel), path.name, seed)
    pixels = _on_paper(path)
    with named(path):
        return _layout(_painting(pixels, metres_per_pixel, scale_bar), path.name, seed)


def _painting(pixels: np.ndarray, metres_per_pixel: float | None, scale_bar: float | None) -> Sketch:
    if pixels.dtype != np.uint8 or pixels.ndim != 3 or pixels.shape[2] != 3 or min(pixels.shape) < 1:
        raise LayoutError(f"pixels are {pixels.dtype} {pixels.shape}; they must be uint8 [H, W, 3]")
    return read_painting(pixels, metres_per_pixel, scale_bar)


def _on_paper(path: Path) -> np.ndarray:
    """The pixels u8 [H, W, 3] of a picture; transparent ones are paper."""
    from PIL import Image

    image = opened_picture(path)
    if image.width * image.height > _MOST_PIXELS:
        pixels = f"{image.width} x {image.height} pixels"
        raise FormatError(f"{path} has {pixels}; sketches of up to {_MOST_PIXELS} pixels are read")
    if image.mode in ("RGBA", "LA", "PA") or "transparency" in image.info:
        image = image.convert("RGBA")
        paper = Image.new("RGBA", image.size, (255, 255, 255, 255))
        image = Image.alpha_composite(paper, image)
    return np.asarray(image.convert("RGB"))


def _layout(sketch: Sketch, source: str, seed: int) -> Layout:
    if not sketch.blobs and not sketch.strokes:
        raise LayoutError("the sketch shows nothing of a class" + "".join(f"; {line}" for line in sketch.ignored[:3]))
    surfaces = drawn_surfaces(sketch)
    objects = list(_objects(sketch, surfaces, np.random.default_rng(seed)))
    counts = Counter(surface.label for surface in surfaces) + Counter(name for name, *_ in objects)
    if counts.total() > _MOST_OBJECTS:
        raise LayoutError(f"the sketch has {counts.total()} objects; up to {_MOST_OBJECTS} are read")
    primitives = [terrain(_reach(sketch)), *ground_primitives(surfaces)]
    numbers: Counter[str] = Counter()
    instances, walks = count(1), Nearest(surfaces, "sidewalk")
    for name, parts, place in objects:
        numbers[name] += 1
        floor = height_at(walks, place)
        primitives += _standing(f"{name}_{numbers[name]}", parts, (*place.tolist(), floor), instances)
    provenance = {
        "source": source,
        "seed": seed,
        "metres_per_pixel": float(sketch.metres_per_unit),
        "ego": "marked" if sketch.ego_marked else "middle",
        "understood": [f"{name}: {number}" for name, number in sorted(counts.items())],
    }
    notes = tuple(f"ignored: {line}" for line in _shortened(sketch.ignored))
    return Layout(primitives=tuple(primitives), provenance=provenance, notes=notes)


def _objects(sketch: Sketch, surfaces: list[DrawnSurface], rng: np.random.Generator) -> Iterator[Placed]:
    roads = Nearest(surfaces, "road")
    shapes: list[Blob | Stroke] = [*sketch.blobs, *sketch.strokes]
    for shape in shapes:
        if shape.label in GROUND:
            continue
        try:
            if isinstance(shape, Blob):
                yield from objects_of_blob(shape, heading(shape, roads), rng)
            else:
                yield from objects_of_stroke(shape, rng)
        except NotDrawnError as error:
            sketch.ignored.append(f"{shape.where}: {error}")


def _reach(sketch: Sketch) -> float:
    """The reach of the terrain to each side [m]."""
    places = [blob.center for blob in sketch.blobs] + [stroke.line for stroke in sketch.strokes]
    return max(_EXTENT, max(float(np.abs(place).max()) for place in places) + 50.0)


def _standing(
    id: str, parts: list[tuple[CoarseShape, float]], place: tuple[float, float, float], instances: Iterator[int]
) -> Iterator[Primitive]:
    for part, yaw in parts:
        x, y, level = place
        instance = next(instances) if BY_NAME[part.label].is_thing else 0
        turned = x, y, math.remainder(yaw, math.tau)
        yield part.placed(turned, level, f"{id}.{part.name}" if part.name else id, instance)


def _shortened(lines: list[str]) -> list[str]:
    """The lines up to a limit, and a last one with the number of further ones."""
    if len(lines) <= _MOST_LINES:
        return lines
    return [*lines[:_MOST_LINES], f"and {len(lines) - _MOST_LINES} more"]
