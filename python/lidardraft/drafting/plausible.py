"""Checks of the unit and the place of a model, a script or a file of boxes, by the sizes and places of its objects."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from lidardraft.errors import LayoutError
from lidardraft.json_fields import is_number
from lidardraft.scene.check import MAX_RANGE, SIZE_RANGES, LayoutGround
from lidardraft.scene.class_names import says_many
from lidardraft.scene.layout import Layout, corners_around
from lidardraft.semantics import BY_NAME, GROUND

_METRES = {"centimetres": 0.01, "millimetres": 0.001, "inches": 0.0254, "feet": 0.3048}
_TOY = 3.0  # times the extents of a class: a size beyond any of its objects
_STEP = 1.0  # m, the largest height of the ground over or under the road at the origin


def check_scale(scale: float) -> None:
    """Raise `LayoutError` unless a scale is the length of a unit in metres."""
    if not (is_number(scale) and scale > 0):
        raise LayoutError(f"scale is {scale}; it must be a finite number of metres > 0")


def check_sizes(layout: Layout, scales: str = "--scale {:g} (`scale` in Python) makes metres of them; ") -> None:
    """Raise `LayoutError` if the size of a thing shows that it is in another unit than the metre.

    All three extents have to be out, as many cars in one mesh are as high as one. A thing is too large by a factor of
    3, or if another unit makes all of its extents usual; plurals such as "Cars" are never too large. It is too small by
    a factor of 3, if it is the largest of its class.
    """
    boxes = sorted(layout.boxes(), key=lambda box: max(box.size))
    largest = {box.label: box for box in boxes}
    for box in boxes:
        if max(SIZE_RANGES[box.label][0]) / _TOY <= max(box.size) <= max(SIZE_RANGES[box.label][1]):
            continue
        (low, high), size = np.sort(SIZE_RANGES[box.label]), np.sort(box.size)
        usual = np.sort(BY_NAME[box.label].size or ())
        unit = min(_METRES, key=lambda unit: abs(math.log((size[2] or 1.0) * _METRES[unit] / usual[2])))
        is_unit = bool((np.abs(size * _METRES[unit] - usual) <= usual / 3).all())
        most = np.inf if says_many(box.id) else high if is_unit else _TOY * high
        is_small = (size < low / _TOY).all() and box is largest[box.label]
        if is_small or (size > most).all():
            cause = "were they scaled twice? " if is_small else f"are these {unit}? "
            said = [" x ".join(f"{extent:.3g}" for extent in one) for one in (box.size, *SIZE_RANGES[box.label])]
            raise LayoutError(
                f"{box.id} is {said[0]} m large, and a {box.label} {said[1]} to {said[2]} m; {cause}"
                f"{scales.format(100 if is_small else _METRES[unit])}--as-is (`as_is`) takes them as they are"
            )


def _too_high(layout: Layout) -> list[str]:
    """A line if an object that `check_sizes` does not judge, such as a house, is higher than the range of sensors."""
    height, id = max(((one.size[2], one.id) for one in layout if one.label not in GROUND), default=(0.0, ""))
    said = f"{id} is {height:,.0f} m high; --scale (`scale` in Python) is for units other than the metre"
    return [said] if height > MAX_RANGE else []


def out_of_reach(layout: Layout, remedy: str = "--recentre (`recentre` in Python) moves its ground there") -> list[str]:
    """A line, with its remedy, if all objects are out of the range of sensors, the ground is not near the level of the
    road, or the objects do not stand on it."""
    shapes = [one for one in layout if not one.open]
    if not shapes:
        return []
    (x, y, z), turn = np.array([one.center for one in shapes]).T, np.array([one.yaw for one in shapes])
    from_it = np.stack([x * np.cos(turn) + y * np.sin(turn), y * np.cos(turn) - x * np.sin(turn), z], axis=1)
    gaps = np.maximum(np.abs(from_it) - np.array([one.size for one in shapes]) / 2, 0.0)
    away = float(np.linalg.norm(gaps, axis=1).min())
    if away > MAX_RANGE:
        said = f"all of it is {away:,.0f} m or more from the origin, the place of the sensor"
        return [f"{said}; sensors reach {MAX_RANGE:.0f} m; {remedy}"]
    low, high = corners_around([one for one in shapes if one.label in GROUND], 0.0)
    if _STEP < low[2] < math.inf or -math.inf < high[2] < -_STEP:
        return [f"its ground is at z = {low[2]:.1f} to {high[2]:.1f} m; the vehicle stands at z = 0; {remedy}"]
    surface = LayoutGround(layout)
    off = [box.center[2] - box.size[2] / 2 - surface.height(*box.center[:2]) for box in layout.boxes()]
    if off and (most := float(np.median(np.abs(off)))) > _STEP:
        said = f"its vehicles and people are {most:.1f} m off the ground"
        return [f"{said}; is another axis up (--up, for models)? {remedy}"]
    return []


def recentred(layout: Layout) -> Layout:
    """The layout moved so that the middle of its roads, or else of its ground, or else of everything, is the origin,
    with a note of the move."""
    choices = ([one for one in layout if one.label in labels] for labels in (("road",), GROUND, tuple(BY_NAME)))
    ground = next(filter(None, choices))
    low, high = corners_around(ground, 0.0)
    x, y = ((low[axis] + high[axis]) / 2 for axis in (0, 1))
    under = LayoutGround(ground).at(x, y)
    move = (-x, -y, -(low[2] if under is None else under[0]))
    said = ", ".join(f"{round(value, 3) + 0.0:.3f}" for value in move)
    return _mapped(layout, 1.0, move).noted(f"moved by ({said}) m: the middle of its ground is the origin")


def _mapped(layout: Layout, scale: float, move: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Layout:
    """The layout with all places and extents multiplied by `scale`, then moved."""
    centers = (np.array([one.center for one in layout]) * scale + move).tolist()
    sizes = (np.array([one.size for one in layout]) * scale).tolist()
    shapes = zip(layout, centers, sizes, strict=True)
    return replace(layout, primitives=tuple(replace(one, center=center, size=size) for one, center, size in shapes))


def settled(
    layout: Layout, *, scale: float = 1.0, recentre: bool = False, as_is: bool = False, is_ours: bool = False
) -> Layout:
    """The layout of a model in its place, with notes on that; none for a model that lidardraft wrote, `is_ours`. Raises
    `LayoutError` for a thing in another unit than the metre, unless `as_is`."""
    check_scale(scale)
    if scale != 1:
        layout = _mapped(layout, scale)
    if not (as_is or is_ours):
        check_sizes(layout)
        layout = layout.noted(*_too_high(layout))
    if recentre:
        layout = recentred(layout)
    return layout if is_ours else layout.noted(*out_of_reach(layout))
