"""Open3D's RaycastingScene (Embree with threads) as a peer: all bodies as one mesh."""

from __future__ import annotations

import numpy as np
import open3d
from open3d.core import Tensor

from scenes import Pattern, Scene


class Peer:
    """Build, cast and scan, as the benchmarks time them."""

    version = "Open3D " + open3d.__version__

    def __init__(self, threads: int) -> None:
        self.threads = threads

    def build(self, scene: Scene) -> None:
        """Compile the mesh."""
        self.scene = scene
        self.caster = open3d.t.geometry.RaycastingScene(nthreads=self.threads)
        self.caster.add_triangles(Tensor(scene.verts), Tensor(scene.faces))
        # The hierarchy is built when the first ray is cast; this one looks up from above everything.
        self.caster.cast_rays(Tensor(np.array([[0, 0, 1e4, 0, 0, 1]], np.float32)), nthreads=self.threads)

    def prepare(self, pattern: Pattern) -> None:
        """Keep the pattern, and rays for the bare cast."""
        self.pattern = pattern
        self.cast_rays = self._rays(np.eye(4))

    def aim_cast(self, pose: np.ndarray) -> None:
        """Rays for the next casts, before the clock starts."""
        self.cast_rays = self._rays(pose)

    def cast(self, _pose: np.ndarray) -> object:
        """Cast the rays that `aim_cast` made; the answer stays in Open3D's form."""
        return self.caster.cast_rays(self.cast_rays, nthreads=self.threads)

    def scan(self, pose: np.ndarray) -> tuple[np.ndarray, ...]:
        """Range f32, semantic u8 and instance i32 [H, W], end to end."""
        answer = self.caster.cast_rays(self._rays(pose), nthreads=self.threads)
        return self.scene.images(answer["t_hit"].numpy(), answer["primitive_ids"].numpy(), self.pattern.shape)

    def _rays(self, pose: np.ndarray) -> Tensor:
        origin, directions = self.pattern.rays(pose)
        rays = np.empty((len(directions), 6), np.float32)
        rays[:, :3], rays[:, 3:] = origin, directions
        return Tensor(rays)


def bench_peer(n_threads: int) -> Peer:
    """Open3D on a mesh."""
    return Peer(n_threads)
