"""Extents of placed objects, kind by kind: numbers or ranges, each with a source or an estimate."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

Range = tuple[float, float]  # from, to
Size = tuple[float, float, float]  # length, width, height [m]


@dataclass(frozen=True, slots=True)
class Extents:
    """Length, width and height [m] of one kind: each a number, or a range to sample from."""

    length: float | Range
    width: float | Range
    height: float | Range

    def sample(self, rng: np.random.Generator) -> Size:
        """Random extents: one draw from `rng` for each range, in order."""
        return _sampled(self.length, rng), _sampled(self.width, rng), _sampled(self.height, rng)


def _sampled(extent: float | Range, rng: np.random.Generator) -> float:
    return rng.uniform(*extent) if isinstance(extent, tuple) else extent


# Vehicles: at most 2.55 m wide, 4.0 m high, 12 m long, 16.5 m with a trailer (directive 96/53/EC); trams at most
# 2.65 m wide (BOStrab), low-floor cars of 20 to 30 m; the ranges within these limits are estimates.
TRAILER_TRUCK = Extents((15.5, 16.5), 2.55, (3.7, 4.0))
TRUCK = Extents((6.0, 11.0), 2.5, (2.8, 3.8))
PARKED_TRUCK = Extents((5.5, 7.5), 2.1, (2.6, 3.0))
BUS = Extents((10.0, 12.5), 2.55, (3.0, 3.3))
TRAM = Extents((20.0, 30.0), 2.4, 3.5)
MOTORCYCLE = Extents(2.1, 0.8, 1.2)
MOTORCYCLIST = Extents(2.1, 0.8, (1.5, 1.65))
BICYCLE = Extents(1.78, 0.58, 1.06)
CYCLIST = Extents(1.75, 0.58, (1.65, 1.8))

# Furniture. Wheeled bins: EN 840, 240 litres. Hydrants stand 0.9 m over the ground (EN 14384). Cabinets are as usual
# for telephone lines. Large posters measure 3.56 x 2.52 m. Delineators are 1 m high (HLB). Else estimates.
WHEELED_BIN = Extents(0.58, 0.62, 1.07)
LITTER_BIN = Extents(0.4, 0.4, 0.9)
BENCH = Extents(1.8, 0.6, 0.85)
HYDRANT = Extents(0.3, 0.3, 0.9)
CABINET = Extents((0.7, 1.6), 0.4, (1.0, 1.6))
STREET_LETTERBOX = Extents(0.4, 0.5, 1.3)
GARDEN_LETTERBOX = Extents(0.35, 0.4, 1.2)
POLE = Extents((0.08, 0.3), 0.2, (0.9, 7.0))
BILLBOARD, BILLBOARD_CLEARANCE = Extents(0.3, 3.6, 2.4 + 2.6), 2.4
SHELTER = Extents((3.5, 5.0), 1.5, 2.5)
GROUND_COVER = Extents((0.8, 3.5), (0.6, 2.0), (0.12, 0.4))
CRATE = Extents((0.3, 1.2), (0.3, 0.9), (0.35, 1.3))
PLANT_TUB = Extents((0.5, 1.6), (0.5, 0.8), (0.7, 1.6))
CAFE_TABLE = Extents((1.4, 1.8), (0.7, 0.9), 0.9)
BOLLARD = Extents((0.1, 0.25), 0.2, (0.7, 1.1))
RAILING, SITE_FENCE, HOARDING = Extents(1.98, 0.1, (0.9, 1.1)), Extents(3.5, 0.06, 2.0), Extents(3.5, 0.2, (1.8, 2.2))
DELINEATOR = Extents(0.12, 0.12, 1.0)
CONE = Extents(0.36, 0.36, 0.75)
# Lenses 2.4 to 3.3 m over the sidewalk: RiLSA wants 2.1 m and more.
TRAFFIC_LIGHT, TRAFFIC_LIGHT_CLEARANCE = Extents(0.25, 0.32, 3.3), 2.4
SIGN_DEPTH = 0.12  # m
LAMP_WIDTH = 0.2  # m
# m of fences, walls and hedges across their run: estimates
FENCE_WIDTH, MESH_FENCE_WIDTH, GARDEN_WALL_WIDTH, HEDGE_WIDTH = 0.1, 0.06, 0.3, (0.6, 1.2)
# Enclosures of plots without plants and with them: share, m across the run, m high. Estimates; of the walls and fences
# of PandaSet, 13 % of its returns, most are 0.3 to 2.5 m high and flat.
_BUILT: tuple[tuple[str, float, Range, Range], ...] = (
    ("fence", 0.35, (FENCE_WIDTH, FENCE_WIDTH), (0.7, 1.9)),
    ("garden_wall", 0.34, (GARDEN_WALL_WIDTH, GARDEN_WALL_WIDTH), (0.5, 1.6)),
    ("wall", 0.16, (GARDEN_WALL_WIDTH, GARDEN_WALL_WIDTH), (1.5, 2.3)),
    ("mesh_fence", 0.15, (MESH_FENCE_WIDTH, MESH_FENCE_WIDTH), (0.9, 2.0)),
)
_GREEN: tuple[tuple[str, float, Range, Range], ...] = (
    ("overgrown_fence", 0.38, (0.25, 0.9), (0.6, 2.0)),
    ("hedge", 0.62, HEDGE_WIDTH, (0.6, 2.4)),
)

_STATURE = (1.72, 0.09)  # m of adults, mean and deviation (NCD-RisC, 2016, Europe); those below are estimates
_ADULTS = 0.9  # share
_CHILD = (1.0, 1.45)  # m
_STATURES = (1.0, 2.0)  # m, limits
_STRIDE = (0.35, 0.7)  # m of an adult of mean stature
STANDING = 0.28  # m, the length of a standing person
_SHOULDERS = 0.28  # of the stature

# Trees: estimates; crowns measure 2 to 9 m.
_TREE = (4.5, 13.0)  # m of height
_CROWN = (0.42, 0.68)  # of the height
_OVAL = (0.9, 1.1)  # length of a crown over its width
_STEM = (0.08, 0.32)  # bare share of the height


def sample_enclosure(green: float, rng: np.random.Generator) -> tuple[str, float, float]:
    """Kind, width and height [m] of a fence or wall, or, in a share of `green`, of a hedge or an overgrown fence."""
    kinds = _GREEN if rng.random() < green else _BUILT
    pick = int(rng.choice(len(kinds), p=[share for _, share, *_ in kinds]))
    kind, _, widths, heights = kinds[pick]
    return kind, rng.uniform(*widths), rng.uniform(*heights)


def sample_person(rng: np.random.Generator, *, standing: bool) -> Size:
    """Extents of a person: the length is the stride, or `STANDING` for a standing person."""
    height = rng.normal(*_STATURE) if rng.random() < _ADULTS else rng.uniform(*_CHILD)
    height = min(max(height, _STATURES[0]), _STATURES[1])
    stride = STANDING if standing else rng.uniform(*_STRIDE) * height / _STATURE[0]
    return stride, _SHOULDERS * height, height


def sample_tree(rng: np.random.Generator) -> tuple[Size, float]:
    """Extents of a tree, and the height of its bare stem [m]."""
    height = rng.uniform(*_TREE)
    crown = height * rng.uniform(*_CROWN)
    return (crown * rng.uniform(*_OVAL), crown, height), height * rng.uniform(*_STEM)
