"""A sweep: returns in the order of lasers and firings, the form in which scans are compared."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from lidardraft.errors import LidarDraftError
from lidardraft.scene.range_image import RangeImage


@dataclass(frozen=True, eq=False)
class Sweep:
    """Returns `points` f32 [H, W, 3] in the sensor frame, zero without a return; row 0 is the highest laser.

    `label` u8 [H, W] and `intensity` f32 [H, W] in [0, 1], if known. A RangeImage keeps points on its sensor's table of
    angles only; this keeps the measured points, since a recorded sensor differs from its table.
    """

    points: np.ndarray
    label: np.ndarray | None = None
    intensity: np.ndarray | None = None

    @classmethod
    def from_image(cls, image: RangeImage) -> Sweep:
        """The sweep of an image."""
        points = image.sensor.pattern.points(image.depth).astype(np.float32)
        points[~image.valid] = 0.0
        return cls(points, image.label, image.intensity)

    @classmethod
    def by_azimuth(cls, image: RangeImage) -> Sweep:
        """The sweep of an image with each laser's firings in the columns of their azimuths, as in `from_points`.

        By firing, returns in one column would not be neighbours. The sweep of a sector is wider than its image
        (`Sensor.azimuth_grid`).
        """
        sweep = cls.from_image(image)
        if not image.sensor.azimuth_offsets:
            return sweep
        rows, columns, inside = image.sensor.azimuth_grid()

        def moved(values: np.ndarray) -> np.ndarray:
            found = values[rows, columns]
            found[~inside] = 0
            return found

        known = (None if values is None else moved(values) for values in (sweep.label, sweep.intensity))
        return cls(moved(sweep.points), *known)

    @classmethod
    def from_points(
        cls,
        points: np.ndarray,
        rows: np.ndarray,
        *,
        height: int,
        columns: int,
        label: np.ndarray | None = None,
        intensity: np.ndarray | None = None,
    ) -> Sweep:
        """Points [N, 3] and the `rows` [N] of their lasers, one firing a column: the nearest to the column's azimuth.

        Each laser's firings are counted by the steps between its returns, so that missing ones are known even if the
        head turns unevenly. If a sensor has more firings than `columns`, the others are left out: an image of the
        nearest of several firings would hide dropped ones. Raises `LidarDraftError` for a row out of range.
        """
        if len(rows) and (rows.min() < 0 or rows.max() >= height):
            raise LidarDraftError(f"rows are {rows.min()} to {rows.max()}; they must be 0 to {height - 1}")
        turned = (math.pi - np.arctan2(points[:, 1], points[:, 0]).astype(np.float64)) % (2 * math.pi)
        order = np.lexsort((turned, rows))
        turned, sorted_rows = turned[order], rows[order]
        step = firing_step(turned, sorted_rows)
        chosen = np.full((height, columns), -1)
        starts = np.searchsorted(sorted_rows, np.arange(height + 1)).tolist()
        for row, (start, end) in enumerate(itertools.pairwise(starts)):
            if start < end:
                chosen[row] = _nearest_firings(turned[start:end], order[start:end], step, columns)
        hit = chosen >= 0

        def image(values: np.ndarray | None, dtype: type) -> np.ndarray | None:
            if values is None:
                return None
            picture = np.zeros((height, columns, *values.shape[1:]), dtype=dtype)
            picture[hit] = values[chosen[hit]]
            return picture

        organised = image(points, np.float32)
        assert organised is not None
        return cls(organised, image(label, np.uint8), image(intensity, np.float32))

    @cached_property
    def depth(self) -> np.ndarray:
        """Distance f32 [H, W]; 0 without a return."""
        x, y, z = np.moveaxis(self.points, 2, 0)
        depth: np.ndarray = np.sqrt(x * x + y * y + z * z)  # a tenth of the time of `np.linalg.norm`
        return depth

    @property
    def valid(self) -> np.ndarray:
        """The mask of returns, bool [H, W]."""
        return self.depth > 0

    def part(self, start: int, stop: int) -> Sweep:
        """The columns from `start` to `stop`."""
        images = (None if image is None else image[:, start:stop] for image in (self.label, self.intensity))
        return Sweep(self.points[:, start:stop], *images)


def firing_step(turned: np.ndarray, rows: np.ndarray) -> float:
    """The angle [rad] between two firings of a laser: the mean step between returns of one row, without gaps."""
    order = np.lexsort((turned, rows))
    steps = np.diff(turned[order])[np.diff(rows[order]) == 0]
    steps = steps[steps > 1e-4]
    if not len(steps):
        raise LidarDraftError("no row has two returns; the step between firings is unknown")
    return float(np.mean(steps[steps < 1.5 * np.median(steps)]))


def _nearest_firings(turned: np.ndarray, index: np.ndarray, step: float, columns: int) -> np.ndarray:
    """For each column the `index` of the firing next to its middle, -1 if that did not return."""
    firing = np.concatenate([[0], np.cumsum(np.maximum(1, np.rint(np.diff(turned) / step)))])
    around = 2 * math.pi + turned[0] - turned[-1]
    seam = max(1.0, float(np.rint(around / step)))
    angles = np.concatenate([[turned[0] - around], turned, [turned[-1] + around]])
    numbers = np.concatenate([[-seam], firing, [firing[-1] + seam]])
    middles = (np.arange(columns) + 0.5) / columns * 2 * math.pi
    wanted = np.rint(np.interp(middles, angles, numbers))
    # beyond the seam the same firings come again
    wanted = np.where(wanted <= -seam, firing[-1], np.where(wanted >= firing[-1] + seam, 0, wanted))
    at = np.minimum(np.searchsorted(firing, wanted), len(firing) - 1)
    return np.where(firing[at] == wanted, index[at], -1)
