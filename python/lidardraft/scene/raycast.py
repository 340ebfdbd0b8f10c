"""A layout as a sensor sees it. The rays are in the core."""

from __future__ import annotations

import numpy as np

from lidardraft import _core
from lidardraft.errors import LayoutError
from lidardraft.scene.layout import SHAPES, Layout
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.sensor import Sensor
from lidardraft.semantics import BY_NAME


class Raycaster:
    """A layout compiled once, to be scanned from many poses."""

    def __init__(self, layout: Layout) -> None:
        primitives = layout.primitives
        self.layout = layout
        self._scene = _core.Scene(
            shapes=np.array([SHAPES.index(p.shape) for p in primitives], dtype=np.uint8),
            centers=np.array([p.center for p in primitives], dtype=np.float64).reshape(-1, 3),
            sizes=np.array([p.size for p in primitives], dtype=np.float64).reshape(-1, 3),
            yaws=np.array([p.yaw for p in primitives], dtype=np.float64),
            labels=np.array([BY_NAME[p.label].id for p in primitives], dtype=np.uint8),
            instances=np.array([p.instance for p in primitives], dtype=np.uint32),
            meshes=[(p.mesh.vertices, p.mesh.faces) for p in primitives if p.mesh is not None],
        )

    def scan(self, sensor: Sensor, pose: np.ndarray | None = None) -> RangeImage:
        """What `sensor` sees from `pose`, world_from_sensor [4, 4]; by default on its mount over the origin.

        The image has depth, label, instance, primitive and incidence. Raises `LayoutError` where the pose is not rigid.
        """
        pose = sensor.pose() if pose is None else np.ascontiguousarray(pose, dtype=np.float64)
        if pose.shape != (4, 4):
            raise LayoutError(f"pose has shape {pose.shape}; it must be [4, 4]")
        depth, label, instance, primitive, incidence = self._scene.scan(sensor.pattern, pose)
        return RangeImage(
            sensor=sensor, depth=depth, label=label, instance=instance, primitive=primitive, incidence=incidence
        )


def raycast(layout: Layout, sensor: Sensor, pose: np.ndarray | None = None) -> RangeImage:
    """What `sensor` sees of `layout`: `Raycaster(layout).scan(sensor, pose)`."""
    return Raycaster(layout).scan(sensor, pose)
