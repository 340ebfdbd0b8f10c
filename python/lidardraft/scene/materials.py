"""Surfaces: how much of a 905 nm pulse comes back.

Diffuse reflectances are rounded from the ECOSTRESS spectral library (Meerdink et al., Remote Sensing of Environment
230, 2019; man-made and vegetation spectra at 0.9 um) and, for car paint and clothing, from the spread of published
automotive measurements; they are typical values, not any one sample's. Shares of lost rays and depths of penetration
are estimates of ours.
"""

from __future__ import annotations

from dataclasses import dataclass

from lidardraft.semantics import CLASSES


@dataclass(frozen=True, slots=True)
class Material:
    """`reflectance` is the diffuse share at 905 nm.

    Two shares of rays give no return at all: `transmission` passes through from any direction, `gloss` is mirrored away
    at grazing incidence. `penetration` [m] is the mean depth from which a porous surface sends light back.
    """

    name: str
    reflectance: float
    transmission: float = 0.0
    gloss: float = 0.0
    penetration: float = 0.0


MATERIALS: tuple[Material, ...] = (
    Material("asphalt", 0.15),
    Material("paving", 0.30),
    Material("plaster", 0.45),
    Material("brick", 0.35),
    Material("roof-tile", 0.25),
    Material("wood", 0.40),
    Material("metal", 0.45, gloss=0.3),
    Material("foliage", 0.50, penetration=0.08),
    Material("bark", 0.30),
    Material("grass", 0.45, penetration=0.04),
    Material("cloth", 0.40),
    Material("light-paint", 0.60, gloss=0.2),
    Material("dark-paint", 0.06, gloss=0.7),
    Material("rubber", 0.05),
    Material("glass", 0.08, transmission=0.85),
    Material("window", 0.15, transmission=0.60),  # of a house: glass with a frame, and curtains behind
    Material("retroreflector", 1.00),
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
    "car": "light-paint",
    "truck": "light-paint",
    "bus": "light-paint",
    "train": "light-paint",
    "motorcycle": "metal",
    "bicycle": "metal",
    "trunk": "bark",
    "other": "plaster",
}

# The material of a class where a primitive names none, by class id.
CLASS_MATERIALS: tuple[Material, ...] = tuple(MATERIAL_BY_NAME[_BY_CLASS[row.name]] for row in CLASSES)
