"""A mesh that is made once and stretched to every object of its form."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lidardraft.objects.placed_object import Vector
from lidardraft.scene.mesh import TriangleMesh


@dataclass(frozen=True, slots=True, eq=False)
class MeshTemplate:
    """A mesh within the unit box [-1/2, 1/2]^3, and the `center` and `size` of that box in shares of an object.

    An object of extents E has the mesh with the extents `size * E`, its middle at `center * E`. Templates are cached by
    those who make them, so that objects share their meshes.
    """

    mesh: TriangleMesh
    center: Vector
    size: Vector

    @classmethod
    def from_triangles(cls, vertices: np.ndarray, faces: np.ndarray) -> MeshTemplate:
        """Triangles [F, 3] over vertices [V, 3] given in shares of an object."""
        low, high = vertices.min(axis=0), vertices.max(axis=0)
        center, size = (low + high) / 2, high - low
        unit = np.clip((vertices - center) / np.where(size > 0, size, 1.0), -0.5, 0.5)
        return cls(TriangleMesh(unit, faces), tuple(center.tolist()), tuple(size.tolist()))
