"""What a sensor reports of a cast that another renderer made: drop, noise and intensity, with its labels as they are.

A cast is one ray a beam, so no return here lies between two surfaces (docs/simulation.md).
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
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
from lidardraft.semantics import BY_NAME, CLASSES, NUM_CLASSES
from lidardraft.simulation.depth_incidence import incidence_from_depth

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
    """What `sensor` reports of a cast of its rays, with intensity and incidence.

    `depth` [H, W] is along the ray [m], 0 where nothing was hit; `label` [H, W] holds ids of `CLASSES`, `instance`
    [H, W] numbers of objects. `incidence` [H, W] is the cosine between ray and surface normal, by default that of the
    depth image's own normals. `materials` are those of each class, except for the classes that are named here
    (`{"car": "dark-paint"}`), or indices of `MATERIALS` [H, W], -1 for that of the class. Leaves face every way, so
    that foliage has incidence 1. `seed`, `model` and `weather` are those of `observe`; rain, snow and fog have label 0.

    Every return keeps its label and instance. What is out of the sensor's range or hidden by its vehicle is dropped.
    Raises `SensorError` naming the first value that cannot be and where it is, `LayoutError` on a material or a class
    that is unknown.
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

    # a surface of its own for each object and material
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
    model = model or SensorModel.from_sensor(sensor)
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
    """As `observe_cast`, of points [N, 3] in the sensor frame [m], with one value a point [N] for each image.

    Each point goes to the pixel that it lies in, of several the nearest. Many points without a pixel of their own are a
    `UserWarning`: then the points are those of another sensor. Raises `LayoutError` on points that cannot be too.
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
