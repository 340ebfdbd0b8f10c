"""The spherical grid that scans are put on for a network, and what the network is told of each pixel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lidardraft.errors import SensorError

FEATURES = 10  # log depth, x, y, height twice, intensity and whether it is known, validity, normal upwards and towards
_WINDOW = 2  # columns and rows around a point's pixel where its label may come from


@dataclass(frozen=True, kw_only=True)
class SphericalGrid:
    """`rows` by `columns` pixels over all azimuths and the elevations `top` to `bottom` [degrees].

    The default is the 64 x 1024 image of +3 to -25 degrees that RangeNet++ projects SemanticKITTI to.
    """

    rows: int = 64
    columns: int = 1024
    top: float = 3.0
    bottom: float = -25.0

    def __post_init__(self) -> None:
        if self.rows < 1 or self.columns < 1 or not self.bottom < self.top:
            raise SensorError(
                f"grid is {self.rows} x {self.columns}, {self.top} to {self.bottom} degrees; it needs a row, a column "
                "and a top above its bottom"
            )

    def pixels(self, points: np.ndarray) -> np.ndarray:
        """The flat pixel i64 [N] of each point [N, 3]; those above or below the view belong to the row at the edge."""
        x, y, z = points.T
        elevation = np.rad2deg(np.arctan2(z, np.hypot(x, y)))
        row = np.floor((self.top - elevation) * (self.rows / (self.top - self.bottom))).astype(np.int64)
        column = np.floor((0.5 - np.arctan2(y, x) / (2 * np.pi)) * self.columns).astype(np.int64) % self.columns
        return np.clip(row, 0, self.rows - 1) * self.columns + column

    def nearest(self, points: np.ndarray, pixels: np.ndarray) -> np.ndarray:
        """The index i64 [H, W] of the nearest of the points in each pixel, -1 where there is none."""
        index = np.full(self.rows * self.columns, -1, dtype=np.int64)
        order = np.argsort(-np.einsum("nk,nk->n", points, points), kind="stable")  # the last one written stays
        index[pixels[order]] = order
        return index.reshape(self.rows, self.columns)

    def back_project(self, label: np.ndarray, points: np.ndarray, pixels: np.ndarray, index: np.ndarray) -> np.ndarray:
        """Of each point [N], the label in `label` [H, W] of the pixel around it that is nearest to it in depth.

        Points that are hidden behind another of their pixel would else take the label of what hides them.
        """
        depth = np.linalg.norm(points, axis=1)
        image = np.where(index < 0, np.inf, depth[index]) if len(points) else np.full(index.shape, np.inf)
        row, column = np.divmod(pixels, self.columns)
        best, result = np.full(len(points), np.inf), np.zeros(len(points), dtype=np.uint8)
        steps = [(r, c) for r in range(-_WINDOW, _WINDOW + 1) for c in range(-_WINDOW, _WINDOW + 1)]
        for r, c in sorted(steps, key=lambda step: abs(step[0]) + abs(step[1])):
            at = np.clip(row + r, 0, self.rows - 1), (column + c) % self.columns
            # A neighbour has to be nearer by more than the own pixel's return may be off.
            off = np.abs(image[at] - depth) + 0.1 * (abs(r) + abs(c))
            better = off < best
            best, result = np.where(better, off, best), np.where(better, label[at], result)
        return result


def features(points: np.ndarray, intensity: np.ndarray | None, mount_height: float, index: np.ndarray) -> np.ndarray:
    """What the network is told, f32 [FEATURES, H, W], of points [N, 3] at the pixels that `index` [H, W] gives them.

    Intensities are taken relative to their mean, for their scale is each sensor's own.
    """
    valid = index >= 0
    if len(points) == 0:
        return np.zeros((FEATURES, *index.shape), dtype=np.float32)
    xyz = np.where(valid[..., None], points[index], 0).astype(np.float32)
    depth = np.linalg.norm(xyz, axis=-1)
    height = xyz[..., 2] + np.float32(mount_height)
    out = np.zeros((FEATURES, *index.shape), dtype=np.float32)
    out[0] = np.log2(depth + 1) / 3.5 - 1
    out[1], out[2] = xyz[..., 0] / 40, xyz[..., 1] / 40
    out[3], out[4] = height / 4, np.tanh(2 * height)  # the second resolves kerbs
    if intensity is not None:
        out[5] = np.sqrt(np.minimum(intensity[index] / max(float(intensity.mean()), 1e-6), 9)) - 1
        out[6] = 1
    out[7] = 1
    out[8], out[9] = _normals(xyz, valid, depth)
    return out * valid


def _normals(xyz: np.ndarray, valid: np.ndarray, depth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of the surface at each pixel: |z| of its normal, and |cosine| to the ray; 0 where unknown."""
    across, there = _difference(xyz, valid, 1)
    down, below = _difference(xyz, valid, 0)
    normal = np.cross(across, down)
    length = np.linalg.norm(normal, axis=-1)
    good = there & below & (length > 1e-9)
    scale = np.where(good, 1 / np.maximum(length, 1e-9), 0)
    towards = np.abs(np.einsum("hwk,hwk->hw", normal, xyz)) / np.maximum(depth, 1e-6)
    return np.abs(normal[..., 2]) * scale, towards * scale


def _difference(xyz: np.ndarray, valid: np.ndarray, axis: int) -> tuple[np.ndarray, np.ndarray]:
    """From the return up to two pixels before to the one up to two after, and where both are there."""

    def neighbour(step: int) -> tuple[np.ndarray, np.ndarray]:
        one, two = np.roll(valid, -step, axis), np.roll(valid, -2 * step, axis)
        near, far = np.roll(xyz, -step, axis), np.roll(xyz, -2 * step, axis)
        return np.where(one[..., None], near, far), one | two

    (after, is_after), (before, is_before) = neighbour(1), neighbour(-1)
    there = is_after & is_before
    if axis == 0:
        there[:2] = there[-2:] = False  # rows do not wrap
    return after - before, there
