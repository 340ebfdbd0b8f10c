"""A sensor's scan of a cast by another renderer: drop, noise and intensity are added, labels stay as they are.

A cast has one ray a beam, so no return here lies between two surfaces (docs/how-to/other-renderers.md). Without given
incidence, it is the angle between each ray and the surface through its neighbours.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from lidardraft.errors import LayoutError, SensorError, one_of
from lidardraft.scene.effects import observe
from lidardraft.scene.materials import CLASS_MATERIALS, MATERIAL_BY_NAME, MATERIALS
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.sensor import Sensor
from lidardraft.scene.sensor_model import SensorModel
from lidardraft.scene.surfaces import Surfaces
from lidardraft.scene.weather import Weather
from lidardraft.semantics import BY_NAME, CLASSES, GROUND, NUM_CLASSES

_INDEX = {material.name: i for i, material in enumerate(MATERIALS)}
_OF_CLASS = np.array([_INDEX[material.name] for material in CLASS_MATERIALS])
_FOLIAGE = _INDEX["foliage"]
_ROUNDING = 1e-3  # by how much a cosine may be over 1
_MOST_LOST = 0.1  # share of points


def observe_cast(
    depth: np.ndarray,
    label: np.ndarray,
    sensor: Sensor,
    *,
    instance: np.ndarray | None = None,
    incidence: np.ndarray | None = None,
    materials: Mapping[str, str] | np.ndarray | None = None,
    seed: int = 0,
    model: SensorModel | None = None,
    weather: Weather | None = None,
) -> RangeImage:
    """The scan that `sensor` reports of a cast of its rays, with intensity and incidence.

    `depth` [H, W] is along the ray [m], 0 without a hit; `label` [H, W] holds ids of `CLASSES`, `instance` [H, W]
    numbers of objects. `incidence` [H, W] is the cosine between ray and surface normal, by default from the depth
    image's own normals. `materials` are names by class (`{"car": "dark-paint"}`), the default for the rest; or
    indices of `MATERIALS` [H, W], -1 for the default of the class. Leaves face every way: foliage has incidence 1.
    `seed`, `model` and `weather` are those of `observe`; rain, snow and fog have label 0.

    Every return keeps its label and instance. Hits out of the sensor's range or hidden by its vehicle are dropped.
    Raises `SensorError` naming the first invalid value and its pixel, `LayoutError` on an unknown material or class.
    """
    shape, weather = sensor.shape, weather or Weather()
    depth = _numbers("depth", depth, shape, "it must be 0 or more, and 0 where there is no return")
    label = _whole_numbers("label", label, shape, 0, NUM_CLASSES - 1)
    instance = np.zeros(shape, np.uint32) if instance is None else instance
    instance = _whole_numbers("instance", instance, shape, 0, 2**32 - 1).astype(np.uint32)
    material = _material_image(materials, label, shape)
    seen = (depth >= sensor.min_range) & (depth <= sensor.max_range) & (depth > 0)
    if sensor.blocked:
        seen &= ~sensor.blocked_pixels
    depth = np.where(seen, depth, 0.0).astype(np.float32)
    if incidence is None:
        incidence = incidence_from_depth(depth, label, instance, sensor)
    else:
        incidence = _numbers("incidence", incidence, shape, "a cosine is -1 to 1", -1.0 - _ROUNDING, 1.0 + _ROUNDING)
    incidence = np.where(material == _FOLIAGE, 1.0, np.minimum(np.abs(incidence), 1.0))

    # a separate surface for each object and material
    key = instance.astype(np.uint64) << 16 | label.astype(np.uint64) << 8 | material.astype(np.uint64)
    keys, first, primitive = np.unique(key[seen], return_index=True, return_inverse=True)
    is_object = keys >> 16 > 0
    surfaces = Surfaces.from_materials(material[seen][first], np.where(is_object, keys, 0), wetness=weather.wetness)
    images: dict[str, np.ndarray] = {
        "depth": depth,
        "label": np.where(seen, label, 0).astype(np.uint8),
        "instance": np.where(seen, instance, np.uint32(0)),
        "incidence": np.where(seen, incidence, 0.0).astype(np.float32),
        "primitive": np.full(shape, -1, np.int32),
    }
    images["primitive"][seen] = primitive
    model = model or sensor.assumed_model
    scan = observe(RangeImage.unchecked(sensor, **images), surfaces, seed=seed, model=model, weather=weather)
    names = ("depth", "label", "instance", "intensity", "incidence")
    return RangeImage.unchecked(sensor, **{name: getattr(scan, name) for name in names})


def observe_points(
    points: np.ndarray,
    label: np.ndarray,
    sensor: Sensor,
    *,
    instance: np.ndarray | None = None,
    incidence: np.ndarray | None = None,
    materials: Mapping[str, str] | np.ndarray | None = None,
    seed: int = 0,
    model: SensorModel | None = None,
    weather: Weather | None = None,
) -> RangeImage:
    """As `observe_cast`, for points [N, 3] in the sensor frame [m], with one value a point [N] for each image.

    Each point goes to the pixel that it lies in; of several, the nearest counts. Many points without a pixel of their
    own mean that they are those of another sensor: a `UserWarning`. Raises `LayoutError` on invalid points too.
    """
    points = np.asarray(points)
    count = len(points) if points.ndim else 0
    image = RangeImage.project(points, sensor, instance=np.arange(1, count + 1))
    where = image.instance[image.valid] - 1
    if len(where) < (1.0 - _MOST_LOST) * count:
        lost = 1.0 - len(where) / count
        warnings.warn(f"{lost:.0%} of the points have no pixel of {sensor.name} of their own", stacklevel=2)

    def picture(name: str, values: Any, empty: float = 0) -> np.ndarray:
        values = np.asarray(values)
        if values.shape != (count,):
            raise LayoutError(f"{name} has shape {values.shape}; {count} points need [{count}]")
        pixels = np.full(sensor.shape, empty, values.dtype)
        pixels[image.valid] = values[where]
        return pixels

    return observe_cast(
        image.depth,
        picture("label", label),
        sensor,
        instance=None if instance is None else picture("instance", instance),
        incidence=None if incidence is None else picture("incidence", incidence),
        materials=materials if isinstance(materials, Mapping | None) else picture("materials", materials, -1),
        seed=seed,
        model=model,
        weather=weather,
    )


def _material_image(
    materials: Mapping[str, str] | np.ndarray | None, label: np.ndarray, shape: tuple[int, int]
) -> np.ndarray:
    """Indices of `MATERIALS`, [H, W]."""
    if not isinstance(materials, Mapping | None):
        given = _whole_numbers("materials", materials, shape, -1, len(MATERIALS) - 1)
        return np.where(given < 0, _OF_CLASS[label], given)
    of_class = _OF_CLASS.copy()
    for name, material in (materials or {}).items():
        if name not in BY_NAME:
            raise LayoutError(f"materials names the class {name!r}; it must be {one_of(BY_NAME, name)}")
        if material not in MATERIAL_BY_NAME:
            raise LayoutError(f"the material of {name} is {material!r}; it must be {one_of(_INDEX, material)}")
        of_class[BY_NAME[name].id] = _INDEX[material]
    return of_class[label]


def _numbers(
    name: str, values: Any, shape: tuple[int, int], rule: str, least: float = 0.0, most: float = np.inf
) -> np.ndarray:
    """Finite numbers within limits, [H, W]."""
    image = _image(name, values, shape)
    if image.dtype.kind not in "fiu":
        raise SensorError(f"{name} is {image.dtype}; it must hold numbers")
    _check_all(name, image, np.isfinite(image) & (image >= least) & (image <= most), rule)
    return image


def _whole_numbers(name: str, values: Any, shape: tuple[int, int], least: int, most: int) -> np.ndarray:
    """Whole numbers within limits, [H, W]."""
    image = _image(name, values, shape)
    if image.dtype.kind not in "iu":
        raise SensorError(f"{name} is {image.dtype}; it must hold whole numbers")
    rule = f"ids of CLASSES are 0 to {len(CLASSES) - 1}" if name == "label" else f"it must be {least} to {most}"
    _check_all(name, image, (image >= least) & (image <= most), rule)
    return image


def _image(name: str, values: Any, shape: tuple[int, int]) -> np.ndarray:
    try:
        image = np.asarray(values)
    except ValueError:  # rows of different lengths
        raise SensorError(f"{name} is no array; the sensor's images have {shape}") from None
    if image.shape != shape:
        raise SensorError(f"{name} has shape {image.shape}; the sensor's images have {shape}")
    return image


def _check_all(name: str, image: np.ndarray, fits: np.ndarray, rule: str) -> None:
    if not fits.all():
        row, column = np.argwhere(~fits)[0]
        raise SensorError(f"{name} is {image[row, column]} in row {row}, column {column}; {rule}")


def incidence_from_depth(depth: np.ndarray, label: np.ndarray, instance: np.ndarray, sensor: Sensor) -> np.ndarray:
    """The cosine of incidence of each return of a clean cast, f32 [H, W]; 0 without a return.

    `depth` f32 [H, W] is along the ray [m]; `label` u8 and `instance` u32 [H, W] separate surfaces. A pixel's normal
    is that of the plane through it, one neighbour in its row and one in its column. Both are on the same surface; of
    two, the one that continues more smoothly counts, so that edges do not look like slanted surfaces. Surfaces one
    pixel wide face the sensor as much as they can, except ground, which is level.
    """
    surface = label.astype(np.int64) << 32 | instance
    rows, columns, inside = sensor.azimuth_grid()
    grid = _Grid(
        points=sensor.pattern.points(depth)[rows, columns],
        inverse=np.divide(1.0, depth, where=depth > 0, out=np.zeros(depth.shape))[rows, columns],
        surface=np.where(inside, np.where(depth > 0, surface, -1)[rows, columns], -1),
    )
    directions = sensor.pattern.directions()[rows, columns]
    across = grid.tangent(axis=1, places=np.arange(columns.shape[1])[None, :], wraps=sensor.wraps)
    along = grid.tangent(axis=0, places=np.array(sensor.elevations)[:, None], wraps=False)
    normal = np.cross(across, along)
    square = _dot(normal, normal)
    facing = np.abs(_dot(normal, directions)) / np.sqrt(np.maximum(square, 1e-30))
    tangent = np.where(_dot(across, across)[..., None] > 0, across, along)
    grazing = _dot(tangent, directions) ** 2 / np.maximum(_dot(tangent, tangent), 1e-30)
    level = np.isin(label, [BY_NAME[name].id for name in GROUND])[rows, columns]
    narrow = np.where(level, np.abs(directions[..., 2]), np.sqrt(np.maximum(1.0 - grazing, 0.0)))
    cosine = np.where(square > 0, facing, narrow)
    incidence = np.zeros(depth.shape, np.float32)
    seen = grid.surface >= 0
    incidence[rows[seen], columns[seen]] = np.minimum(cosine[seen], 1.0)
    return incidence


@dataclass(frozen=True, slots=True, eq=False)
class _Grid:
    """Points f64 [H, W, 3], inverse depths [H, W] and surfaces [H, W], -1 without a return."""

    points: np.ndarray
    inverse: np.ndarray
    surface: np.ndarray

    def tangent(self, *, axis: int, places: np.ndarray, wraps: bool) -> np.ndarray:
        """From each pixel to the better of its two neighbours along an axis, f64 [H, W, 3]; 0 without one.

        On a plane the inverse depth is nearly linear in the angle; `places` has the angle of each pixel.
        """
        least = np.full(self.inverse.shape, np.inf)
        tangent = np.zeros(self.points.shape)
        for side in (1, -1):
            beside, beyond = _shifted(self.inverse, side, axis), _shifted(self.inverse, 2 * side, axis)
            near, far = (_shifted(places, side * steps, axis) for steps in (1, 2))
            slope = (
                1.0
                if axis == 1
                else np.divide(near - places, far - near, where=far != near, out=np.zeros(places.shape))
            )
            mine = self._same(side, axis, wraps)
            further = mine & self._same(2 * side, axis, wraps)
            off = np.abs(np.where(further, beside + (beside - beyond) * slope, beside) - self.inverse)
            better = mine & (off < least)
            least = np.where(better, off, least)
            tangent = np.where(better[..., None], _shifted(self.points, side, axis) - self.points, tangent)
        return tangent

    def _same(self, by: int, axis: int, wraps: bool) -> np.ndarray:
        """Whether the neighbour `by` pixels on is of the same surface, bool [H, W]; False beyond an edge."""
        same: np.ndarray = (self.surface == _shifted(self.surface, by, axis)) & (self.surface >= 0)
        if not wraps:
            edge = [slice(None), slice(None)]
            edge[axis] = slice(-by, None) if by > 0 else slice(None, -by)
            same[tuple(edge)] = False
        return same


def _shifted(image: np.ndarray, by: int, axis: int) -> np.ndarray:
    """Each pixel's neighbour `by` pixels on, around the edge."""
    return np.roll(image, -by, axis=axis)


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.einsum("hwc,hwc->hw", a, b)
