"""The mesh of a roundabout: rings about its middle in a square that fits the ground's lines."""

from __future__ import annotations

import math

import numpy as np

from lidardraft.scene.road import Road

_RIM = 4.0  # m of land in the square beyond the sidewalk
_LAND = (0.12, 0.3, 0.6)  # where the rings between the outermost circle and the square are, in shares of the way


class RoundaboutMesh:
    """Rings [K] by spokes [J + 1] of points over the frame of a road with a roundabout, in place of the square of
    `half` [m] each way about the junction; `offsets` are the lines of the square both ways, against its middle.
    """

    def __init__(self, road: Road) -> None:
        assert road.junction is not None
        assert road.roundabout_radius is not None
        self.road, self._middle, self._radius = road, road.junction, road.roundabout_radius
        outer = road.roundabout_radius + road.sidewalk
        self.half = outer + _RIM
        between = road.verge + 0.5 * (self.half - road.verge)
        half_lines = [0.0, road.edge, road.verge, between, self.half]
        lines = sorted({*half_lines, *(-d for d in half_lines)})
        self.offsets = [d for i, d in enumerate(lines) if i == 0 or d - lines[i - 1] > 1e-3]
        square = self._square()
        heading = np.arctan2(square[:, 1], square[:, 0])
        rings = [np.zeros_like(square)]
        radii = (0.5 * road.island, road.island, road.roundabout_radius, *([outer] if road.sidewalk > 0 else []))
        rings += [self._ring(square, heading, radius) for radius in radii]
        # the land rises or falls most next to what is paved
        rings += [rings[-1] + share * (square - rings[-1]) for share in _LAND]
        rings.append(square)
        points = np.stack(rings)
        self.along, self.across = points[..., 0] + road.junction, points[..., 1]

    def lines_along(self) -> list[float]:
        """The lines of the square along the road."""
        return [self._middle + d for d in self.offsets]

    def covers(self, along: np.ndarray, across: np.ndarray) -> np.ndarray:
        """Whether points lie in the square."""
        inside: np.ndarray = (np.abs(along - self._middle) < self.half) & (np.abs(across) < self.half)
        return inside

    def middles(self) -> tuple[np.ndarray, np.ndarray]:
        """Points along and across [K - 1, J] within the cells between rings and spokes."""

        def mean(a: np.ndarray) -> np.ndarray:
            inner: np.ndarray = (a[:-1, :-1] + a[1:, :-1] + a[1:, 1:] + a[:-1, 1:]) / 4
            return inner

        return mean(self.along), mean(self.across)

    def kinds(self, along: np.ndarray, across: np.ndarray, kinds: np.ndarray) -> np.ndarray:
        """The kinds of `Ground.kinds` with the island, the lane and the sidewalk around it."""
        road = self.road
        radius = np.hypot(along - self._middle, across)
        # the chord of a ring between two spokes lies a little inside the circle
        kinds = np.where((radius <= self._radius + road.sidewalk) & (kinds != 0), 1 if road.sidewalk > 0 else 2, kinds)
        kinds = np.where(radius <= self._radius, 0, kinds)
        return np.where(radius <= road.island, 3, kinds)

    def _square(self) -> np.ndarray:
        """The lines' ends on the square [J + 1, 2], once around from a corner."""
        lines, half = np.array(self.offsets), np.full(len(self.offsets) - 1, self.half)
        up, down = lines[:-1], lines[:0:-1]
        sides = [(half, up), (down, half), (-half, down), (up, -half)]
        around = np.concatenate([np.stack(side, axis=-1) for side in sides])
        return np.concatenate([around, around[:1]])

    def _ring(self, square: np.ndarray, heading: np.ndarray, radius: float) -> np.ndarray:
        """Points of a circle: where the lines of the side roads meet it, else in the directions of the square's."""
        ring = radius * np.stack([np.cos(heading), np.sin(heading)], axis=-1)
        verge = self.road.verge + 1e-6
        if radius > verge:
            for axis in (0, 1):
                low = np.abs(square[:, axis]) <= verge
                rest = np.sqrt(np.maximum(radius**2 - square[:, axis] ** 2, 0.0)) * np.sign(square[:, 1 - axis])
                ring[low, axis] = square[low, axis]
                ring[low, 1 - axis] = rest[low]
            self._spread(ring, square, radius)
        return ring

    def _spread(self, ring: np.ndarray, square: np.ndarray, radius: float) -> None:
        """Put the points between a side road and a corner half way between them on the circle."""
        turn = np.arctan2(ring[:, 1], ring[:, 0])
        verge = math.asin(self.road.verge / radius)
        low = np.abs(square).min(axis=1)
        between = (low > self.road.verge + 1e-3) & (low < self.half - 1e-3)
        district = np.round(turn[between] / (math.pi / 2)) * (math.pi / 2)
        away = np.sign(turn[between] - district) * (verge + math.pi / 4) / 2
        ring[between] = radius * np.stack([np.cos(district + away), np.sin(district + away)], axis=-1)
