"""Surfaces: how much of a 905 nm pulse comes back, and in which direction.

Sources of `MATERIALS`, by column; a value with several sources is typical of them, not of one sample:

- `reflectance`: the ECOSTRESS spectral library (Meerdink et al., Remote Sensing of Environment 230, 2019) at 0.9 um for
  mineral, wooden, metal and vegetable surfaces, soil and asphalt; NIST's skin reference (Cooksey and Allen, SPIE 8734,
  2013) for skin; dyed cloth is bright in the near infrared whatever its colour. Car paint and rubber are
  such that the medians and quartiles of the Pandar64 in PandaSet come out, see docs/explanation/sensor-model.md. Dark
  paint is a gloss black under a clear coat: two dark cars beside Ouster's OS1-128 return whole sides at 10 m, and
  0.010 to 0.015 give the quartiles of PandaSet's cars. Road paint is worn or full of glass beads, all of a street
  alike: the brightest hundredth of recorded roads reads 2 to 13 times their median.
- `roughness`: Oren and Nayar's slope spread [rad]; 0.35 of walls and 1 of asphalt are fitted to the fall of PandaSet's
  intensities with incidence, the others lie between by analogy.
- `specular`, `rms_slope`: Fresnel reflectance at normal incidence (0.04 for an index of 1.5, clear coats and glass; 0.6
  for chromium) and root mean square slope of the facets, as in the laser radar cross-sections of Steinvall (Applied
  Optics 39, 2000). Metallic paint (mid-paint) is a lobe of flakes, fitted to PandaSet's cars; other slopes are
  estimates.
- `transmission`: float glass of 4 to 6 mm at 905 nm, two-way for objects behind it; solar control coatings take more.
  Car glass absorbs heat: of visible light at least 0.70 passes (UN regulation 43), at 905 nm less; 0.32 for it and 0.45
  for windows, with tints that differ from pane to pane, are such that they read as dark as PandaSet's do.
- `retroreflection`: the coefficients of EN 12899-1 (class RA2, white, 0.2 and 5 degrees: 250 cd/lx/m2); a white surface
  that faces the sensor has 1 / pi of these units.
- `rms_height`: of grass from the rows of terrain in PandaSet within 15 m, whose returns lie 4 mm off the line between
  their neighbours in height (5 mm root mean square) and 38 mm in range (8 to 17 mm); of bark, gravel and soil
  estimates.
- `unevenness`: waves of 0.3 to 4 m. Of asphalt between ISO 8608's classes C and D (2 to 5 mm); of grass and soil an
  estimate: the random roughness of grassland in the RUSLE (Renard et al., Agriculture Handbook 703, 1997) is 8 to
  25 mm.
- `variation`, `grain`: the spread between objects of one material (dirt, age, colour), an estimate, and within one
  from firing to firing, in addition to the sensor's (`speckle`): such that neighbouring readings of PandaSet
  (roads, sidewalks, walls, leaves) and of ika's VLP-32C differ as recorded, see docs/explanation/sensor-model.md.
- `texture`: the share of `SensorModel.texture`, which is fitted to asphalt: of walls a half, such that as few of their
  readings are over 2.5 medians as recorded; of seamless surfaces, paint, glass or cloth, none.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from lidardraft.semantics import CLASSES

_COAT = 0.04  # Fresnel reflectance of a dielectric of index 1.5 at normal incidence
# A ray meets a leaf with a density of its projected area: the mean cosine of a spherical distribution of leaf
# angles (G = 1/2; Ross, The radiation regime and architecture of plant stands, 1981) is then 2/3.
_LEAF = 2.0 / 3.0
# Entrance angles of EN 12899-1: RA2 has 250, 150 and 110 cd/lx/m2 at 5, 30 and 40 degrees.
_RETRO_FALL = 3.3


@dataclass(frozen=True, slots=True)
class Material:
    """Shares of light at 905 nm; see the module for units and sources.

    `reflectance` is the diffuse share, `specular` that of a mirror whose facets have slopes of `rms_slope` (root mean
    square). `transmission` is the share that passes through once. `retroreflection` is the peak of the light returned
    to its source over that of a white surface. `variation` is the relative spread of the whole between objects, `grain`
    that from pixel to pixel of one object. `texture` is its share of the world's texture; `rms_height` [m] is the
    standard deviation of the heights of its surface from return to return, `unevenness` [m] that from place to place.
    """

    name: str
    reflectance: float
    roughness: float = 0.4
    specular: float = 0.0
    rms_slope: float = 0.2
    transmission: float = 0.0
    retroreflection: float = 0.0
    variation: float = 0.2
    grain: float = 0.03
    texture: float = 1.0
    rms_height: float = 0.0
    unevenness: float = 0.0


MATERIALS: tuple[Material, ...] = (
    Material("asphalt", 0.12, roughness=1.0, grain=0.03, unevenness=0.004),
    Material("concrete", 0.32, roughness=0.5, texture=0.5),
    Material("paving", 0.22, roughness=0.8, grain=0.04, unevenness=0.004),
    Material("gravel", 0.25, roughness=1.0, grain=0.2, rms_height=0.008, unevenness=0.012),
    Material("plaster", 0.45, roughness=0.35, texture=0.5),
    Material("brick", 0.36, roughness=0.35, texture=0.5),
    Material("stone", 0.33, texture=0.5),
    Material("roof-tile", 0.28, texture=0.5),
    Material("wood", 0.45, roughness=0.3, grain=0.12, texture=0.5),
    Material("metal", 0.25, roughness=0.3, specular=0.08, rms_slope=0.35, variation=0.35, texture=0.0),
    Material("rusty-metal", 0.25, roughness=0.5),
    Material("chrome", 0.03, specular=0.6, rms_slope=0.05, texture=0.0),
    Material("foliage", 0.50, variation=0.15, grain=0.23),
    Material("bark", 0.32, roughness=0.6, grain=0.15, rms_height=0.01),
    Material("grass", 0.45, roughness=0.8, variation=0.25, grain=0.2, rms_height=0.008, unevenness=0.022),
    Material("soil", 0.27, roughness=0.8, grain=0.15, rms_height=0.008, unevenness=0.022),
    Material("cloth", 0.48, roughness=0.6, variation=0.3, grain=0.15, texture=0.0),
    Material("dark-cloth", 0.22, roughness=0.6, variation=0.4, grain=0.15, texture=0.0),
    Material("skin", 0.55, texture=0.0),
    Material("light-paint", 0.45, roughness=0.3, specular=_COAT, rms_slope=0.1, texture=0.0),
    Material("mid-paint", 0.06, roughness=0.3, specular=0.25, rms_slope=0.4, variation=0.4, texture=0.0),
    Material("dark-paint", 0.012, roughness=0.3, specular=_COAT, rms_slope=0.15, variation=0.5, texture=0.0),
    Material("rubber", 0.03, roughness=0.6, texture=0.0),
    Material("plastic", 0.10, specular=_COAT, rms_slope=0.3, variation=0.5, texture=0.0),
    Material("glass", 0.01, specular=2 * _COAT, rms_slope=0.006, transmission=0.75, variation=0.5, texture=0.0),
    Material("car-glass", 0.003, specular=2 * _COAT, rms_slope=0.006, transmission=0.32, variation=0.5, texture=0.0),
    Material("window", 0.02, specular=2 * _COAT, rms_slope=0.006, transmission=0.45, variation=0.5, texture=0.0),
    Material("retroreflector", 0.30, retroreflection=math.pi * 250.0, variation=0.3, texture=0.0),
    Material("road-paint", 0.50, roughness=1.0, variation=0.6, grain=0.15, unevenness=0.004),
    Material("sign-back", 0.35, roughness=0.3, specular=0.3, rms_slope=0.2, texture=0.0),
)

MATERIAL_BY_NAME: dict[str, Material] = {material.name: material for material in MATERIALS}

_BY_CLASS = {
    "none": "asphalt",
    "road": "asphalt",
    "sidewalk": "paving",
    "building": "plaster",
    "wall": "brick",
    "fence": "wood",
    "pole": "metal",
    "traffic-light": "metal",
    "traffic-sign": "retroreflector",
    "vegetation": "foliage",
    "terrain": "grass",
    "person": "cloth",
    "rider": "cloth",
    "car": "mid-paint",
    "truck": "light-paint",
    "bus": "light-paint",
    "train": "light-paint",
    "motorcycle": "metal",
    "bicycle": "metal",
    "trunk": "bark",
    "other": "plaster",
}

# The material of a class for primitives without one, by class id.
CLASS_MATERIALS: tuple[Material, ...] = tuple(MATERIAL_BY_NAME[_BY_CLASS[row.name]] for row in CLASSES)


def diffuse_response(material: Material, cosine: np.ndarray) -> np.ndarray:
    """The diffuse light returned to its source, relative to a white surface that faces the sensor.

    Oren and Nayar (SIGGRAPH 1994) with light and eye in one place: rough surfaces lose less at grazing incidence than
    Lambert's cosine says. A clear coat transmits by Fresnel (after Schlick, 1994) on the way in and out.
    """
    variance = material.roughness**2
    a, b = 1.0 - 0.5 * variance / (variance + 0.33), 0.45 * variance / (variance + 0.09)
    response = material.reflectance * (cosine + b / a * (1.0 - cosine**2))
    return response * ((1.0 - fresnel(cosine)) / (1.0 - _COAT)) ** 2 if material.specular else response


def specular_response(material: Material, cosine: np.ndarray) -> np.ndarray:
    """The light that facets facing the sensor mirror back: Beckmann's distribution of slopes."""
    if not material.specular:
        return np.zeros_like(cosine)
    cosine = np.maximum(cosine, 1e-3)
    slope = (1.0 / cosine**2 - 1.0) / material.rms_slope**2
    return material.specular * np.exp(-slope) / (4.0 * material.rms_slope**2 * cosine**5)


def retro_response(material: Material, cosine: np.ndarray) -> np.ndarray:
    """The light that cube corners and glass beads return, less the further they are turned away."""
    return material.retroreflection * cosine**_RETRO_FALL


def response(material: Material, cosine: np.ndarray) -> np.ndarray:
    """All returned light at incidences of these cosines, relative to a white surface that faces the sensor."""
    return diffuse_response(material, cosine) + specular_response(material, cosine) + retro_response(material, cosine)


def leaf_response(material: Material) -> float:
    """The light returned by a medium of small surfaces in all directions alike."""
    return _LEAF * material.reflectance


def fresnel(cosine: np.ndarray) -> np.ndarray:
    """The share that a coat of index 1.5 mirrors away, by the cosine of incidence."""
    return _COAT + (1.0 - _COAT) * (1.0 - cosine) ** 5
