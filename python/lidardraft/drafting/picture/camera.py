"""A pinhole camera: the rays of a picture's pixels."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from lidardraft.errors import LayoutError
from lidardraft.json_fields import are_numbers, is_number

_NARROWEST, _WIDEST = math.radians(5), math.radians(170)  # wider or narrower pictures are not a pinhole's
_FILM_DIAGONAL = math.hypot(36, 24)  # mm


@dataclass(frozen=True, kw_only=True, slots=True)
class Pinhole:
    """Focal lengths fx, fy and principal point cx, cy of a picture of width times height, all in pixels.

    As in OpenCV and KITTI, the centre of the upper left pixel is (0, 0). Lens distortion is ignored. Raises
    `LayoutError` on invalid values.
    """

    fx: float
    fy: float
    cx: float
    cy: float
    width: int
    height: int

    def __post_init__(self) -> None:
        given = (self.fx, self.fy, self.cx, self.cy)
        if not are_numbers(given, 4) or min(self.fx, self.fy) <= 0:
            raise LayoutError(f"intrinsics are {list(given)}; fx, fy, cx, cy must be finite, fx and fy greater than 0")
        if not (0 <= self.cx < self.width and 0 <= self.cy < self.height):
            place, size = f"({self.cx:g}, {self.cy:g})", f"{self.width} x {self.height}"
            raise LayoutError(f"intrinsics: the principal point {place} lies outside the picture of {size} pixels")
        for name, length, focal in (("fx", self.width, self.fx), ("fy", self.height, self.fy)):
            if (angle := 2 * math.atan(length / 2 / focal)) > _WIDEST or (name == "fx" and angle < _NARROWEST):
                said = f"{name} is {focal:g} pixels, so {length} pixels are {math.degrees(angle):.3g} degrees"
                raise LayoutError(f"intrinsics: {said}; a pinhole sees {_limits()}")

    @classmethod
    def from_matrix(cls, matrix: object, width: int, height: int) -> Pinhole:
        """From K, [3, 3] or the left of KITTI's P [3, 4], or from (fx, fy, cx, cy)."""
        try:
            values = np.asarray(matrix, dtype=np.float64)
        except (TypeError, ValueError, OverflowError):
            values = np.empty(0)
        if values.shape == (4,):
            fx, fy, cx, cy = values.tolist()
        elif values.shape in ((3, 3), (3, 4)):
            fx, fy, cx, cy = (float(values[at]) for at in ((0, 0), (1, 1), (0, 2), (1, 2)))
        else:
            raise LayoutError(f"intrinsics have shape {values.shape}; they must be [3, 3] or (fx, fy, cx, cy)")
        return cls(fx=fx, fy=fy, cx=cx, cy=cy, width=width, height=height)

    @classmethod
    def from_hfov(cls, hfov: float, width: int, height: int) -> Pinhole:
        """Square pixels and a centred axis; `hfov` [rad] is the angle from the left edge to the right one."""
        if not is_number(hfov) or not _NARROWEST <= hfov <= _WIDEST:
            degrees = f" ({math.degrees(hfov):.4g} degrees)" if is_number(hfov) else ""
            raise LayoutError(f"hfov is {hfov} rad{degrees}; a pinhole sees {_limits()}")
        focal = width / 2 / math.tan(hfov / 2)
        return cls(fx=focal, fy=focal, cx=(width - 1) / 2, cy=(height - 1) / 2, width=width, height=height)

    @classmethod
    def from_film(cls, focal_length: float, width: int, height: int) -> Pinhole:
        """From the focal length [mm] with the same view on film of 36 x 24 mm, measured along the diagonal."""
        focal = focal_length * math.hypot(width, height) / _FILM_DIAGONAL
        return cls(fx=focal, fy=focal, cx=(width - 1) / 2, cy=(height - 1) / 2, width=width, height=height)

    def resized(self, width: int, height: int) -> Pinhole:
        """The camera of the same picture at another resolution."""
        across, down = width / self.width, height / self.height
        return Pinhole(
            fx=self.fx * across,
            fy=self.fy * down,
            cx=(self.cx + 0.5) * across - 0.5,
            cy=(self.cy + 0.5) * down - 0.5,
            width=width,
            height=height,
        )

    def rays(self, rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
        """Directions [..., 3] through pixels, x forward, y left, z up, with x = 1: multiplied by depth they are
        points."""
        left, up = (self.cx - columns) / self.fx, (self.cy - rows) / self.fy
        return np.stack([np.ones(np.broadcast(left, up).shape), *np.broadcast_arrays(left, up)], axis=-1)


def _limits() -> str:
    return f"{math.degrees(_NARROWEST):.0f} to {math.degrees(_WIDEST):.0f} degrees"
