"""embreex, the Embree binding that trimesh uses (one ray at a time, one thread), as a peer: all bodies as one mesh."""

from __future__ import annotations

import embreex
import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

from scenes import Pattern, Scene


class Peer:
    """Build, cast and scan, as the benchmarks time them."""

    version = "embreex " + embreex.__version__

    def __init__(self, threads: int) -> None:
        if threads != 1:
            raise RuntimeError("embreex casts on one thread")

    def build(self, scene: Scene) -> None:
        """Compile the mesh."""
        self.scene = scene
        self.caster = EmbreeScene()
        self.mesh = TriangleMesh(self.caster, scene.verts, scene.faces.astype(np.int32))
        # The hierarchy is built when the first ray is cast; this one looks up from above everything.
        self.caster.run(np.array([[0, 0, 1e4]], np.float32), np.array([[0, 0, 1]], np.float32))

    def prepare(self, pattern: Pattern) -> None:
        """Keep the pattern, and rays for the bare cast."""
        self.pattern = pattern
        self.cast_rays = self._rays(np.eye(4))

    def aim_cast(self, pose: np.ndarray) -> None:
        """Rays for the next casts, before the clock starts."""
        self.cast_rays = self._rays(pose)

    def cast(self, _pose: np.ndarray) -> object:
        """Cast the rays that `aim_cast` made; the answer stays in embreex's form."""
        return self.caster.run(*self.cast_rays, query="INTERSECT", output=True)

    def scan(self, pose: np.ndarray) -> tuple[np.ndarray, ...]:
        """Range f32, semantic u8 and instance i32 [H, W], end to end."""
        answer = self.caster.run(*self._rays(pose), query="INTERSECT", output=True)
        return self.scene.images(answer["tfar"], answer["primID"], self.pattern.shape)

    def _rays(self, pose: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        origin, directions = self.pattern.rays(pose)
        return np.ascontiguousarray(np.broadcast_to(origin, directions.shape)), np.ascontiguousarray(directions)


def bench_peer(n_threads: int) -> Peer:
    """embreex on a mesh."""
    return Peer(n_threads)
