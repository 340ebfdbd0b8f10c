"""What any rays hit, one value a ray."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Hits:
    """The closest hits of R rays, in the world frame.

    `distance` f32 [R] is that from the ray's origin [m], `label` u8 a class id, `instance` u32 the object, `primitive`
    i32 the index of the primitive; `normal` f32 [R, 3] is the unit normal of the surface, turned towards the origin. No
    hit is distance 0, label 0, instance 0, primitive -1, normal 0, and False in `valid`.
    """

    origins: np.ndarray
    directions: np.ndarray
    distance: np.ndarray
    label: np.ndarray
    instance: np.ndarray
    primitive: np.ndarray
    normal: np.ndarray

    def __len__(self) -> int:
        return len(self.distance)

    @property
    def valid(self) -> np.ndarray:
        """bool [R]: which rays hit something."""
        return self.primitive >= 0

    def points(self) -> np.ndarray:
        """Where the rays of `valid` hit, f64 [N, 3], in their order."""
        hit = self.valid
        along = self.directions[hit] / np.linalg.norm(self.directions[hit], axis=1, keepdims=True)
        points: np.ndarray = self.origins[hit] + along * self.distance[hit, None]
        return points
