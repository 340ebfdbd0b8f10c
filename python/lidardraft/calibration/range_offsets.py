"""By how much each laser reports more than its range, out of recorded surfaces that are flat.

A laser whose range is a little off puts its returns a little before or behind the plane that its neighbours see. That
tells lasers from their neighbours; what a whole block has in common bends no plane, and is left at 0.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lidardraft.calibration.beam_table import BeamTable
from lidardraft.metrics.sweep import Sweep

_LASERS, _FIRINGS, _STRIDE = 8, 16, 4  # of a patch, and lasers from one to the next
_FILLED = 0.9  # of a patch
_FARTHEST = 30.0  # m
_FLAT = 0.03  # m off the plane, along the rays: the median of a patch
_STEEPEST = 0.05  # cosine of incidence: at more grazing ones millimetres of height are centimetres of range
_FEWEST = 20  # patches of a laser
_ROUNDS = 5
_MOST = 0.2  # m


def fit_range_offsets(recorded: Sequence[Sweep], table: BeamTable) -> np.ndarray:
    """Range offset of each laser [H], m; 0 for lasers that saw too little that is flat."""
    origins = np.stack([np.zeros_like(table.heights), np.zeros_like(table.heights), table.heights], axis=1)
    offsets = np.zeros(len(table.heights))
    if len(offsets) < _LASERS:
        return offsets
    patches, lasers = _patches(recorded)
    if not len(patches):
        return offsets
    rays = patches - origins[lasers][:, :, None]
    rays /= np.maximum(np.linalg.norm(rays, axis=3, keepdims=True), 1e-6)
    for _ in range(_ROUNDS):
        off, flat = _off_plane(patches - offsets[lasers][:, :, None, None] * rays, rays)
        for laser in range(len(offsets)):
            found = off[(lasers == laser) & flat[:, None]]
            if len(found) >= _FEWEST:
                offsets[laser] += np.median(found)
    return np.clip(offsets, -_MOST, _MOST)


def _patches(recorded: Sequence[Sweep]) -> tuple[np.ndarray, np.ndarray]:
    """Points [N, _LASERS, _FIRINGS, 3] of patches that are filled and near, and their lasers [N, _LASERS]."""
    found, lasers = [], []
    for sweep in recorded:
        height, width = sweep.depth.shape
        there = (sweep.depth > 0) & (sweep.depth < _FARTHEST)
        for row in range(0, height - _LASERS + 1, _STRIDE):
            rows, columns = slice(row, row + _LASERS), width - width % _FIRINGS
            filled = there[rows, :columns].reshape(_LASERS, -1, _FIRINGS).mean(axis=(0, 2)) >= _FILLED
            points = sweep.points[rows, :columns].reshape(_LASERS, -1, _FIRINGS, 3).transpose(1, 0, 2, 3)[filled]
            found.append(points.astype(np.float64))
            lasers.append(np.broadcast_to(np.arange(row, row + _LASERS), (len(points), _LASERS)))
    return np.concatenate(found), np.concatenate(lasers)


def _off_plane(points: np.ndarray, rays: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """How far beyond the plane of its patch each laser reports [N, _LASERS], m, and which patches are flat [N]."""
    weight = (np.linalg.norm(points, axis=3) > 0).astype(np.float64)
    off = np.zeros_like(weight)
    for _ in range(3):
        # planes are n p = 1: those through the sensor are seen by no ray
        moments = np.einsum("nij,nija,nijb->nab", weight, points, points) + 1e-9 * np.eye(3)
        normal = np.linalg.solve(moments, np.einsum("nij,nija->na", weight, points)[..., None])[..., 0]
        along = np.einsum("na,nija->nij", normal, rays)
        off = (np.einsum("na,nija->nij", normal, points) - 1.0) / np.where(np.abs(along) > 1e-6, along, 1e-6)
        weight = (weight > 0) / (1.0 + (off / _FLAT) ** 2)
    steep = np.median(along, axis=(1, 2)) / np.linalg.norm(normal, axis=1)
    flat: np.ndarray = (np.median(np.abs(off), axis=(1, 2)) < _FLAT) & (steep > _STEEPEST)
    return np.median(off, axis=2), flat
