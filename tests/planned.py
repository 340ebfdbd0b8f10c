"""Plans of streets in all districts, made once for the tests of what stands where."""

import math
from functools import cache

import numpy as np

from lidardraft.arranging.ground import Ground
from lidardraft.arranging.occupancy import Occupancy
from lidardraft.arranging.plan import plan_street
from lidardraft.arranging.relief import Land
from lidardraft.scene.road import Road
from lidardraft.scene.street import Path, paths_of

FLAT = Land(grade=0.0, hillside=0.0, rolling=0.0)


def empty(road: Road) -> Occupancy:
    """A street on flat land with nothing in it."""
    return Occupancy(road, Ground(road, np.random.default_rng(0), FLAT))


def surface(ground: Ground, along: float, across: float) -> str:
    """The class of the ground at a place."""
    return ("road", "sidewalk", "terrain", "terrain")[int(ground.kinds(np.array(along), np.array(across)))]


@cache
def plans() -> list[tuple[Occupancy, tuple[Path, ...], str]]:
    planned = (plan_street(np.random.default_rng([seed, 9]), 90.0) for seed in range(90))
    return [(frame.occupancy, paths_of(frame.street), name) for frame, name in planned]


def occupancies() -> list[Occupancy]:
    return [occupancy for occupancy, _, _ in plans()]


def frame_corners(occupancy: Occupancy, index: int) -> np.ndarray:
    """Corners [4, 2] along and across of an object as it was placed."""
    placed = occupancy._placed[index]
    half = np.array([(1, 1), (1, -1), (-1, -1), (-1, 1)]) * placed.size[:2] / 2
    cos, sin = math.cos(placed.angle), math.sin(placed.angle)
    return half @ np.array([[cos, sin], [-sin, cos]]) + (placed.along, placed.across)


def corners_of(space: np.ndarray) -> np.ndarray:
    x, y, cos, sin, length, width, _, _ = space
    local = np.array([(length, width), (length, -width), (-length, -width), (-length, width)])
    return local @ np.array([[cos, sin], [-sin, cos]]) + (x, y)


def overlap(one: np.ndarray, two: np.ndarray) -> bool:
    """Whether two upright boxes overlap, by projecting their corners: another way than `penetration`."""
    if one[6] >= two[7] or two[6] >= one[7]:
        return False
    a, b = corners_of(one), corners_of(two)
    for ring in (a, b):
        for edge in np.diff(ring, axis=0):
            normal = np.array([-edge[1], edge[0]])
            # neighbours in a row share a side, but for rounding
            if (a @ normal).max() <= (b @ normal).min() + 1e-9 or (b @ normal).max() <= (a @ normal).min() + 1e-9:
                return False
    return True
