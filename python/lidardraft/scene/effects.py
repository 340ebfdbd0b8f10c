"""What a real sensor makes of clean returns: intensity, penetration, noise and dropped rays, one function an effect."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from lidardraft.errors import LayoutError, SensorError
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.materials import CLASS_MATERIALS, MATERIAL_BY_NAME, Material
from lidardraft.scene.range_image import RangeImage
from lidardraft.semantics import BY_NAME

_ROUGHNESS = 0.4  # rad, slope spread of the surfaces in the model of Oren and Nayar
# Velodyne HDL-64E S2 manual: pavement (reflectance 0.10) is seen to 50 m. From a roof it is seen at grazing incidence.
_FAINTEST = 0.10 / 50.0**2
_COMPENSATED = 40.0  # m to which the stored intensity is corrected for range, as the HDL-64E's manual describes


@dataclass(frozen=True, slots=True)
class Surface:
    """What each pixel hit, 0 where nothing: numbers of its `Material` and the cosine of `incidence`, each [H, W]."""

    reflectance: np.ndarray
    transmission: np.ndarray
    gloss: np.ndarray
    penetration: np.ndarray
    incidence: np.ndarray

    @classmethod
    def of(cls, image: RangeImage, layout: Layout) -> Surface:
        """The surfaces of `layout` in an image that was cast of it.

        Raises `SensorError` for an image without primitive and incidence, `LayoutError` for a material that is unknown.
        """
        if image.primitive is None or image.incidence is None:
            raise SensorError("the image lacks primitive or incidence; cast it with primitive=True, incidence=True")
        if image.primitive.max() >= len(layout.primitives):
            raise SensorError(
                f"the image shows primitive {image.primitive.max()}; the layout has {len(layout.primitives)}"
            )
        materials = [_material(primitive) for primitive in layout.primitives]
        rows = [(m.reflectance, m.transmission, m.gloss, m.penetration) for m in materials]
        # the last row is that of primitive -1, no return
        table = np.array([*rows, (0.0, 0.0, 0.0, 0.0)])
        reflectance, transmission, gloss, penetration = np.moveaxis(table[image.primitive], -1, 0)
        return cls(reflectance, transmission, gloss, penetration, image.incidence)


def _material(primitive: Primitive) -> Material:
    if primitive.material is None:
        return CLASS_MATERIALS[BY_NAME[primitive.label].id]
    try:
        return MATERIAL_BY_NAME[primitive.material]
    except KeyError:
        known = ", ".join(MATERIAL_BY_NAME)
        raise LayoutError(f"{primitive.id}: material is {primitive.material!r}; it must be one of {known}") from None


def response(surface: Surface) -> np.ndarray:
    """Share of the light that comes back where it came from, over that of a white surface that faces the sensor.

    Oren and Nayar (SIGGRAPH 1994) with light and eye in one place: rough surfaces lose less at grazing incidence than
    Lambert's cosine says.
    """
    variance = _ROUGHNESS**2
    a, b = 1.0 - 0.5 * variance / (variance + 0.33), 0.45 * variance / (variance + 0.09)
    return surface.reflectance * (surface.incidence + b / a * (1.0 - surface.incidence**2))


def power(image: RangeImage, surface: Surface) -> np.ndarray:
    """Received power [H, W] over that of a pulse which is detected half the time; 0 where there is no return.

    The lidar equation for targets larger than the beam: response over range squared.
    """
    depth = np.where(image.valid, image.depth, np.inf)
    return response(surface) / (depth**2 * _FAINTEST)


def intensity(image: RangeImage, surface: Surface) -> RangeImage:
    """The image with `intensity` in [0, 1]: the response of the surface, corrected for range up to a limit."""
    echo = response(surface) / (1.0 + (image.depth / _COMPENSATED) ** 2)
    return replace(image, intensity=np.where(image.valid, np.clip(echo, 0.0, 1.0), 0.0).astype(np.float32))


def speckle(image: RangeImage, rng: np.random.Generator, *, spread: float = 0.15) -> RangeImage:
    """The image with its intensity scattered by `spread` from pixel to pixel, and half as much from beam to beam.

    Raises `SensorError` for an image without intensity.
    """
    if image.intensity is None:
        raise SensorError("the image has no intensity; speckle scatters it")
    gain = rng.normal(0.0, spread / 2, (image.depth.shape[0], 1))
    scattered = image.intensity * np.exp(rng.normal(0.0, spread, image.depth.shape) + gain)
    return replace(image, intensity=np.clip(scattered, 0.0, 1.0).astype(np.float32))


def penetrate(image: RangeImage, surface: Surface, rng: np.random.Generator) -> RangeImage:
    """The image with porous surfaces seen from a little behind them: an exponential free path (Beer-Lambert)."""
    return _moved(image, surface.penetration * rng.standard_exponential(image.depth.shape))


def range_noise(image: RangeImage, surface: Surface, rng: np.random.Generator) -> RangeImage:
    """The image with Gaussian noise of the sensor's `range_sigma`, up to three times as much where the power is low.

    The timing error of a pulse grows with the inverse root of its signal-to-noise ratio (Jutzi and Stilla, ISPRS 2006).
    """
    sigma = image.sensor.range_sigma * np.clip(power(image, surface) / 8.0, 1 / 9, 1.0) ** -0.5
    return _moved(image, sigma * rng.standard_normal(image.depth.shape))


def drop(image: RangeImage, surface: Surface, rng: np.random.Generator, *, chance: float = 0.02) -> RangeImage:
    """The image without the rays that never come back.

    A ray is lost where the material lets it through, with `transmission`; where it is mirrored away, with `gloss` times
    the squared sine of incidence; where its power p is too low, with 1 / (1 + p ** 4), a threshold that speckle makes
    soft; and by `chance`. Raises `SensorError` where `chance` is no share.
    """
    if not 0.0 <= chance <= 1.0:
        raise SensorError(f"chance is {chance}; the share of rays lost by chance must be 0 to 1")
    # far below and far above the threshold the fourth power says no more
    detected = np.clip(power(image, surface), 0.0, 1e3) ** 4
    kept = (1.0 - surface.transmission) * (1.0 - surface.gloss * (1.0 - surface.incidence**2)) * (1.0 - chance)
    return keep(image, rng.random(image.depth.shape) < kept * detected / (1.0 + detected))


def keep(image: RangeImage, where: np.ndarray) -> RangeImage:
    """The image with returns only where the mask [H, W] is True."""
    blanks = {"depth": 0, "label": 0, "instance": 0, "intensity": 0, "incidence": 0, "primitive": -1, "normal": 0}
    images = {name: getattr(image, name) for name in blanks}
    kept = {
        name: np.where(where if pixels.ndim == 2 else where[..., None], pixels, pixels.dtype.type(blanks[name]))
        for name, pixels in images.items()
        if pixels is not None
    }
    return replace(image, **kept)


def observe(image: RangeImage, layout: Layout, rng: np.random.Generator) -> RangeImage:
    """What the sensor reports of the clean image cast of `layout`: all effects in turn."""
    surface = Surface.of(image, layout)
    bright = speckle(intensity(image, surface), rng)
    return drop(range_noise(penetrate(bright, surface, rng), surface, rng), surface, rng)


def _moved(image: RangeImage, along: np.ndarray) -> RangeImage:
    """The image with its returns moved along their rays [m], never out of the sensor's limits."""
    depth = np.clip(image.depth + along, image.sensor.min_range, image.sensor.max_range)
    return replace(image, depth=np.where(image.valid, depth, 0.0).astype(np.float32))
