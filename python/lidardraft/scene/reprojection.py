"""What a scan showed, as the sensor sees it from elsewhere."""

from __future__ import annotations

import numpy as np

from lidardraft.scene.range_image import RangeImage
from lidardraft.semantics import BY_NAME, GROUND

_FAR, _EDGE = 100.0, 0.99  # times the range of the sensor: where what found nothing is, and is put to be seen
_GROUND = [BY_NAME[name].id for name in GROUND]


def reprojected(
    image: RangeImage, where: np.ndarray, poses: np.ndarray, to: np.ndarray
) -> tuple[RangeImage, np.ndarray]:
    """The pixels `where`, bool [H, W], of a scan from `poses`, seen from the poses `to` (both [4, 4] or [W, 4, 4]), and
    which pixels they reach, bool [H, W]; a ray that found nothing finds nothing in its direction.

    Each point is moved into the ray of its pixel: ground at its height, all else at its distance over the ground.
    """
    sensor = image.sensor
    one = sensor.pattern.points(np.ones(sensor.shape, np.float32))
    rays = sensor.pattern.points(np.full(sensor.shape, 2, np.float32)) - one
    row, column = np.nonzero(where)
    depth, label = image.depth[row, column], image.label[row, column]
    local = one[row, column] + (np.where(depth > 0, depth, _FAR * sensor.max_range) - 1)[:, None] * rays[row, column]
    poses, to = (np.broadcast_to(each, (sensor.columns, 4, 4)) for each in (poses, to))
    world = np.einsum("nij,nj->ni", poses[column, :3, :3], local) + poses[column, :3, 3]

    def seen(by: np.ndarray) -> np.ndarray:
        points: np.ndarray = np.einsum("nji,nj->ni", by[:, :3, :3], world - by[:, :3, 3])
        return np.where(
            depth[:, None] > 0,
            points,
            points * (_EDGE * sensor.max_range / np.linalg.norm(points, axis=1, keepdims=True)),
        )

    at = np.full(len(world), sensor.columns // 2)
    for _ in range(2):  # which column sees a point depends on where the sensor is then
        points = seen(to[at])
        beam, found, _ = sensor.pattern.project(points)
        at = np.where(beam >= 0, found, at)
    kept = beam >= 0
    beam, found, points, depth, label = beam[kept], found[kept], points[kept], depth[kept], label[kept]
    start, ray = one[beam, found] - rays[beam, found], rays[beam, found]
    flat = np.isin(label, _GROUND) & (ray[:, 2] < -1e-3) & (depth > 0)
    across = np.hypot(*(points - start)[:, :2].T) / np.hypot(*ray[:, :2].T)
    along = np.where(flat, (points[:, 2] - start[:, 2]) / np.where(flat, ray[:, 2], 1.0), across)
    intensity = None if image.intensity is None else image.intensity[where][kept]
    lost = depth == 0
    moved = start + along[:, None] * ray
    made = RangeImage.project(moved, sensor, label=label, instance=lost, intensity=intensity)
    reached = made.valid
    return made.keep(made.instance == 0), reached
