"""Range images of any cloud, projected as LiDARGen, LiDM and R2DM project KITTI's scans.

64 x 1024 pixels from +3 to -25 degrees all around. Of several points in a pixel the nearest stays. A point above or
below the field of view lies in the first or last row. The authors unproject along the upper left corner of a pixel.
Sources: vzyrianov/lidargen, metrics/histogram; hancyran/LiDAR-Diffusion, lidm/eval; kazuto1011/r2dm.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

ROWS, COLUMNS = 64, 1024
_UP, _DOWN = np.deg2rad(3.0), np.deg2rad(-25.0)


@dataclass(frozen=True, eq=False)
class SphericalImage:
    """`depth` f32 [64, 1024] in metres, 0 without a return; `points` f32 [64, 1024, 3] and, if known, `intensity` f32
    [64, 1024] of the returns."""

    depth: np.ndarray
    points: np.ndarray
    intensity: np.ndarray | None = None

    def within(self, near: float, far: float) -> np.ndarray:
        """The mask of returns more than `near` and less than `far` metres off, bool [64, 1024]."""
        return (self.depth > near) & (self.depth < far)


def spherical_image(
    points: np.ndarray, intensity: np.ndarray | None = None, *, near: float = 0.0, far: float = np.inf
) -> SphericalImage:
    """The image of points [N, 3] in the sensor frame that are more than `near` and less than `far` metres off."""
    depth = np.linalg.norm(points.astype(np.float64), axis=1)
    order = np.argsort(-depth, kind="stable")  # the nearest is written last
    order = order[(depth[order] > near) & (depth[order] < far)]
    x, y, z = points[order].astype(np.float64).T
    row = np.floor(ROWS * (1 - (np.arcsin(z / depth[order]) - _DOWN) / (_UP - _DOWN)))
    column = np.floor(COLUMNS * (1 - np.arctan2(y, x) / np.pi) / 2)
    where = tuple(np.clip(at, 0, most - 1).astype(np.int64) for at, most in ((row, ROWS), (column, COLUMNS)))

    def image_of(values: np.ndarray) -> np.ndarray:
        image = np.zeros((ROWS, COLUMNS, *values.shape[1:]), dtype=np.float32)
        image[where] = values[order]
        return image

    return SphericalImage(image_of(depth), image_of(points), None if intensity is None else image_of(intensity))


def corner_points(depth: np.ndarray) -> np.ndarray:
    """Points at depths [64, 1024] along the upper left corners of their pixels, f64 [64, 1024, 3]."""
    pitch = (_UP - (_UP - _DOWN) * np.arange(ROWS) / ROWS)[:, None]
    azimuth = np.pi * (1 - 2 * np.arange(COLUMNS) / COLUMNS)
    rays = np.broadcast_arrays(np.cos(azimuth) * np.cos(pitch), np.sin(azimuth) * np.cos(pitch), np.sin(pitch))
    return depth[..., None].astype(np.float64) * np.stack(rays, axis=-1)
