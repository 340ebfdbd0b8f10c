"""nuScenes sweeps: .pcd.bin files of float32 x y z intensity ring (Caesar et al., CVPR 2020).

Their frame has x to the right, y ahead and z up; intensities are 0 to 255, and ring 0 is the lowest laser.
"""

from __future__ import annotations

import os

import numpy as np

from lidardraft.errors import FormatError
from lidardraft.files import read_bytes, written_whole

_POINT_BYTES = 20
_MOST_RINGS = 512


def read_pcd_bin(path: str | os.PathLike[str]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points f32 [N, 3] in metres in our sensor frame, intensity f32 [N] in [0, 1], and ring i64 [N] as it stands.

    Raises `FormatError` on a missing, empty or truncated file, a value that is not finite, and an intensity or a ring
    out of range.
    """
    name, data = os.fspath(path), read_bytes(path)
    if not data or len(data) % _POINT_BYTES:
        raise FormatError(
            f"{name} has {len(data)} bytes; a nuScenes sweep has {_POINT_BYTES} a point, and one at least"
        )
    sweep = np.frombuffer(data, dtype="<f4").reshape(-1, 5).astype(np.float32)
    _check(name, sweep)
    points = np.stack([sweep[:, 1], -sweep[:, 0], sweep[:, 2]], axis=1)
    return points, sweep[:, 3] / np.float32(255), sweep[:, 4].astype(np.int64)


def write_pcd_bin(path: str | os.PathLike[str], points: np.ndarray, intensity: np.ndarray, ring: np.ndarray) -> None:
    """Write points [N, 3] in our sensor frame, intensity [N] in [0, 1] and nuScenes' ring [N]; the inverse of
    `read_pcd_bin`, with the same limits."""
    right, ahead, up = -points[:, 1], points[:, 0], points[:, 2]
    sweep = np.stack([right, ahead, up, intensity * np.float32(255), ring], axis=1).astype("<f4")
    _check(os.fspath(path), sweep)
    with written_whole(path) as temporary:
        temporary.write_bytes(sweep.tobytes())


def _check(name: str, sweep: np.ndarray) -> None:
    intensity, ring = sweep[:, 3], sweep[:, 4]
    whole = (ring == np.floor(ring)) & (ring >= 0) & (ring < _MOST_RINGS)
    for right, limit in (
        (np.isfinite(sweep).all(axis=1), "every value must be finite"),
        ((intensity >= 0) & (intensity <= 255), "the fourth value, intensity, must be 0 to 255"),
        (whole, f"the fifth value, the ring, must be a whole number from 0 to {_MOST_RINGS - 1}"),
    ):
        if not right.all():
            first = int(np.argmin(right))
            raise FormatError(f"{name}: point {first} is {sweep[first].tolist()}; {limit}")
