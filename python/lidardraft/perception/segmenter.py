"""Points -> classes: a range-image network that says what each return of a scan is.

Points are put on a spherical grid (RangeNet++, Milioto et al., IROS 2019), so the scan may be of any sensor within the
grid's view; a convolutional encoder and decoder labels the grid, and the labels are projected back to the points.
"""

from __future__ import annotations

import dataclasses
import itertools
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional

from lidardraft.errors import LayoutError, LidarDraftError
from lidardraft.networks.convolution import RangeImageConv, fold, unfold
from lidardraft.networks.residual import Chain, ResidualBlock
from lidardraft.networks.weight_file import Network
from lidardraft.perception.spherical_grid import FEATURES, SphericalGrid, features
from lidardraft.scene.range_image import RangeImage
from lidardraft.semantics import NUM_CLASSES

_CELL = (1, 2)  # pixels that the network sees as one: thin objects are one column wide, but rarely two rows high
_WRAPS = True  # the grid has all azimuths, whatever part of them the sensor sees


@dataclass(frozen=True, kw_only=True)
class SegmenterConfig:
    """The form of the network: the channels of each stage, which has half the rows and columns of the one before.

    Raises `LidarDraftError` where there is no stage, or the columns of the grid do not pair up.
    """

    grid: SphericalGrid = field(default_factory=SphericalGrid)
    widths: tuple[int, ...] = (24, 40, 80, 160)

    def __post_init__(self) -> None:
        if not self.widths or self.grid.columns % _CELL[1]:
            raise LidarDraftError(
                f"widths are {self.widths} on {self.grid.columns} columns; it needs one, and even columns"
            )

    def to_dict(self) -> dict[str, Any]:
        """The fields as JSON types."""
        return dataclasses.asdict(self)

    @classmethod
    def from_dict(cls, fields: dict[str, Any]) -> SegmenterConfig:
        """The inverse of `to_dict`; raises `TypeError` on an unknown or missing field."""
        return cls(grid=SphericalGrid(**fields["grid"]), widths=tuple(fields["widths"]))


class Segmenter(Network):
    """Labels scans; `forward` works on features, `label_points` and `label` on what sensors give."""

    SCHEMA = "lidardraft.segmenter/1"

    def __init__(self, config: SegmenterConfig | None = None) -> None:
        super().__init__()
        self.config: SegmenterConfig = config or SegmenterConfig()
        widths = self.config.widths
        self.stem = RangeImageConv(FEATURES * _CELL[0] * _CELL[1], widths[0])
        self.encoder = nn.ModuleList([ResidualBlock(widths[0], widths[0])])
        for above, width in itertools.pairwise(widths):
            self.encoder.append(Chain(ResidualBlock(above, width, stride=2), ResidualBlock(width, width, dilation=2)))
        self.lift = nn.ModuleList(nn.Conv2d(b, a, 1) for a, b in itertools.pairwise(widths))
        self.decoder = nn.ModuleList(ResidualBlock(width, width) for width in widths[:-1])
        self.head = nn.Conv2d(widths[0], (NUM_CLASSES - 1) * _CELL[0] * _CELL[1], 1)

    @classmethod
    def from_dict(cls, fields: dict[str, Any]) -> Segmenter:
        """The segmenter of `SegmenterConfig.to_dict`, with fresh weights."""
        return cls(SegmenterConfig.from_dict(fields))

    def forward(self, x: Tensor) -> Tensor:
        """Features [B, FEATURES, H, W] -> logits [B, K - 1, H, W] of the classes 1 to K - 1."""
        x = self.stem(fold(x, _CELL), _WRAPS)
        stages = []
        for stage in self.encoder:
            x = stage(x, _WRAPS)
            stages.append(x)
        for lift, block, skip in reversed(list(zip(self.lift, self.decoder, stages[:-1], strict=True))):
            x = block(skip + functional.interpolate(lift(x), size=skip.shape[-2:], mode="nearest"), _WRAPS)
        return unfold(self.head(functional.silu(x)), _CELL)

    @torch.no_grad()
    def label_points(self, points: np.ndarray, intensity: np.ndarray | None, mount_height: float) -> np.ndarray:
        """Class ids u8 [N] of sensor-frame points [N, 3] with intensities [N] in [0, 1], where these are known.

        `mount_height` [m] is that of the sensor over the road. Raises `LayoutError` where the arrays do not fit.
        """
        points = np.asarray(points, dtype=np.float32)
        if points.ndim != 2 or points.shape[1] != 3 or not np.isfinite(points).all():
            raise LayoutError(f"points are {points.shape}; they must be finite and [N, 3]")
        if intensity is not None and intensity.shape != points.shape[:1]:
            raise LayoutError(f"intensity is {intensity.shape} for {len(points)} points; it must be [N]")
        grid = self.config.grid
        pixels = grid.pixels(points)
        index = grid.nearest(points, pixels)
        x = torch.from_numpy(features(points, intensity, mount_height, index))[None]
        winners = (self(x.to(self.head.weight.device))[0].argmax(0) + 1).to(torch.uint8).cpu().numpy()
        return grid.back_project(winners, points, pixels, index)

    def label(self, image: RangeImage) -> np.ndarray:
        """The label image u8 [H, W] of a scan of any sensor: 0 where there is no return."""
        label = np.zeros(image.sensor.shape, dtype=np.uint8)
        intensity = None if image.intensity is None else image.intensity[image.valid]
        label[image.valid] = self.label_points(image.points(), intensity, image.sensor.mount_height)
        return label
