"""Our own caster as a peer of the benchmarks, with shapes kept as they are or everything as triangles.

`peer_analytic.py`, `peer_triangles.py` and `peer_fresh.py` offer it to anything that times peers through a hook
`bench_peer(n_threads)`; `compare.py` uses more of it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from lidardraft import CLASSES, Layout, Primitive, RangeImageBatch, Raycaster, Sensor, _core

_SHAPES = {"cuboid": "box", "ellipsoid": "ellipsoid", "plane": "plane"}


def layout_of(scene: Any, *, triangles: bool) -> Layout:
    """The scene's primitives, in their order, as a layout; meshes, or all if `triangles`, with exactly its vertices."""
    return Layout(tuple(_primitive(k, body, triangles) for k, body in enumerate(scene.primitives)))


def _primitive(index: int, body: Any, triangles: bool) -> Primitive:
    label = CLASSES[body.semantic].name
    if triangles or body.kind == "mesh":
        return Primitive.from_mesh(body.verts, body.faces, label=label, id=str(index), instance=body.instance)
    (x, y, z), (length, width, height) = body.center, body.half
    return Primitive(
        shape=_SHAPES[body.kind],
        center=(float(x), float(y), float(z)),
        size=(2.0 * length, 2.0 * width, 2.0 * height),
        yaw=float(body.yaw),
        label=label,
        id=str(index),
        instance=body.instance,
    )


def sensor_of(pattern: Any) -> Sensor:
    """The sensor whose rays are those of the pattern; any distance up to 120 m counts."""
    azimuth = np.asarray(pattern.azimuth)
    step = (azimuth[0] - azimuth[-1]) / (len(azimuth) - 1)
    start, span = float(azimuth[0] + step / 2), float(step * len(azimuth))
    assert np.allclose(azimuth, start - (np.arange(len(azimuth)) + 0.5) * span / len(azimuth), rtol=0, atol=1e-12)
    return Sensor(
        name="bench",
        elevations=tuple(np.asarray(pattern.elevation).tolist()),
        columns=len(azimuth),
        azimuth_start=start,
        azimuth_span=min(span, 2 * np.pi),
        min_range=0.0,
        max_range=120.0,
    )


class Peer:
    """Build, cast and scan, as the benchmarks time them.

    `cast` is the core alone, into buffers that stay; `scan` is `Raycaster.scan` with `out=`, or with new arrays each
    time where the peer is `fresh`. A scan is asked for one image more than it needs, the index of the primitive: unlike
    `instance` it is -1 where nothing returns, as the benchmarks want it, and equals the instance everywhere else.
    """

    version = f"lidardraft ({_core.backends()[0]})"

    def __init__(self, threads: int, *, triangles: bool, fresh: bool = False) -> None:
        self.threads, self.triangles, self.fresh = threads, triangles, fresh

    def build(self, scene: Any) -> None:
        """Make a layout of the scene's arrays, and compile it."""
        assert all(body.instance == k for k, body in enumerate(scene.primitives)), "instance k must be primitive k"
        self.layout = layout_of(scene, triangles=self.triangles)
        self.caster = Raycaster(self.layout)

    def compile(self, _scene: Any) -> None:
        """Compile the layout that is there."""
        self.caster = Raycaster(self.layout)

    def prepare(self, pattern: Any) -> None:
        """Make the sensor and the buffers."""
        self.sensor = sensor_of(pattern)
        self.image = self.caster.scan(self.sensor, np.eye(4), primitive=True)
        empty = RangeImageBatch.empty(self.sensor, 1)
        self.buffers: dict[str, Any] = {"depth": empty.depth, "label": empty.label, "instance": empty.instance}
        self.batch_out: Any = None

    def cast(self, pose: np.ndarray) -> dict[str, np.ndarray]:
        """Depth, label and instance [1, H, W], straight from the core."""
        self.caster._scene.scan(self.sensor.pattern, pose[None, None], **self.buffers, threads=self.threads)
        return self.buffers

    def scan(self, pose: np.ndarray) -> tuple[np.ndarray, ...]:
        """Range f32, semantic u8 and instance i32 [H, W], end to end."""
        out = None if self.fresh else self.image
        image = self.caster.scan(self.sensor, pose, out=out, primitive=True, threads=self.threads)
        assert image.primitive is not None
        return image.depth, image.label, image.primitive

    def scan_fresh(self, pose: np.ndarray) -> Any:
        """A scan into new arrays."""
        return self.caster.scan(self.sensor, pose, threads=self.threads)

    def rolling(self, poses: np.ndarray) -> Any:
        """A scan with one pose for each column [W, 4, 4], into arrays that stay."""
        return self.caster.scan(self.sensor, poses=poses, out=self.image, primitive=True, threads=self.threads)

    def batch(self, poses: np.ndarray) -> Any:
        """Scans from all poses [N, 4, 4], into arrays that stay from one call to the next of the same size."""
        self.batch_out = self.caster.scan_batch(self.sensor, poses, out=self.batch_out, threads=self.threads)
        return self.batch_out

    def reference(self, pose: np.ndarray) -> tuple[np.ndarray, ...]:
        """What `scan` returns, by the reference path: one ray at a time, in float64, through a tree of bounds."""
        primitive = np.zeros((1, *self.sensor.shape), np.int32)
        self.caster._scene.scan(
            self.sensor.pattern, pose[None, None], **self.buffers, primitive=primitive, backend="reference"
        )
        return self.buffers["depth"][0].copy(), self.buffers["label"][0].copy(), primitive[0]
