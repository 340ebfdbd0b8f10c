"""Incidence from a depth image alone: the angle between each ray and the surface that its neighbours lie on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lidardraft.scene.azimuth_grid import azimuth_grid
from lidardraft.scene.sensor import Sensor
from lidardraft.semantics import BY_NAME, GROUND


def incidence_from_depth(depth: np.ndarray, label: np.ndarray, instance: np.ndarray, sensor: Sensor) -> np.ndarray:
    """The cosine of incidence of each return of a clean cast, f32 [H, W]; 0 where there is none.

    `depth` f32 [H, W] is along the ray [m], `label` u8 and `instance` u32 [H, W] tell surfaces apart. A pixel's normal
    is that of the plane through it and a neighbour in its row and one in its column: on the same surface, and of two
    the one that continues more smoothly, so that edges are not mistaken for slanted surfaces. What is one pixel wide
    faces the sensor as much as it can, but for ground, which is level.
    """
    surface = label.astype(np.int64) << 32 | instance
    rows, columns, inside = azimuth_grid(sensor)
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
    """Points f64 [H, W, 3], inverse depths [H, W] and surfaces [H, W], -1 where there is no return."""

    points: np.ndarray
    inverse: np.ndarray
    surface: np.ndarray

    def tangent(self, *, axis: int, places: np.ndarray, wraps: bool) -> np.ndarray:
        """From each pixel to the better of its two neighbours along an axis, f64 [H, W, 3]; 0 where there is none.

        On a plane the inverse depth is nearly linear in the angle, of which `places` has one for each pixel.
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
        """Whether the neighbour `by` pixels on is of the same surface, bool [H, W]; beyond an edge there is none."""
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
