"""Points -> classes: a range-image network that says what each return of a scan is.

Points are put on a spherical grid (RangeNet++, Milioto et al., IROS 2019), so the scan may be of any sensor within the
grid's view; a convolutional encoder and decoder labels the grid, and the points take their labels back.
"""

from __future__ import annotations

import dataclasses
import itertools
import json
import os
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import save as serialise
from torch import Tensor, nn
from torch.nn import functional

from lidardraft.diffusion.layers import RingConv, fold, group_norm, unfold
from lidardraft.errors import CheckpointError, LayoutError, SensorError
from lidardraft.files import written_whole
from lidardraft.perception.grid import FEATURES, Grid, features
from lidardraft.scene.range_image import RangeImage
from lidardraft.semantics import NUM_CLASSES

SCHEMA = "lidardraft.segmenter/1"
_CELL = (1, 2)  # pixels that the network sees as one: thin things are one column wide, but rarely two rows high


@dataclass(frozen=True, kw_only=True)
class SegmenterConfig:
    """The form of the network: the channels of each stage, which has half the rows and columns of the one before.

    Raises `SensorError` where there is no stage, or the columns of the grid do not pair up.
    """

    grid: Grid = field(default_factory=Grid)
    widths: tuple[int, ...] = (24, 40, 80, 160)

    def __post_init__(self) -> None:
        if not self.widths or self.grid.columns % _CELL[1]:
            raise SensorError(
                f"widths are {self.widths} on {self.grid.columns} columns; it needs one, and even columns"
            )

    def to_dict(self) -> dict[str, Any]:
        """The fields as JSON types."""
        return dataclasses.asdict(self)

    @classmethod
    def from_dict(cls, fields: dict[str, Any]) -> SegmenterConfig:
        """The inverse of `to_dict`; raises `TypeError` on an unknown or missing field."""
        return cls(grid=Grid(**fields["grid"]), widths=tuple(fields["widths"]))


class Segmenter(nn.Module):
    """Labels scans; `forward` works on features, `label_points` and `label` on what sensors give."""

    def __init__(self, config: SegmenterConfig | None = None) -> None:
        super().__init__()
        self.config = config or SegmenterConfig()
        widths = self.config.widths
        self.stem = RingConv(FEATURES * _CELL[0] * _CELL[1], widths[0])
        self.encoder = nn.ModuleList([_Block(widths[0], widths[0])])
        for above, width in itertools.pairwise(widths):
            self.encoder.append(nn.Sequential(_Block(above, width, stride=2), _Block(width, width, dilation=2)))
        self.lift = nn.ModuleList(nn.Conv2d(b, a, 1) for a, b in itertools.pairwise(widths))
        self.decoder = nn.ModuleList(_Block(width, width) for width in widths[:-1])
        self.head = nn.Conv2d(widths[0], (NUM_CLASSES - 1) * _CELL[0] * _CELL[1], 1)

    def forward(self, x: Tensor) -> Tensor:
        """Features [B, FEATURES, H, W] -> logits [B, K - 1, H, W] of the classes 1 to K - 1."""
        x = self.stem(fold(x, _CELL))
        stages = []
        for stage in self.encoder:
            x = stage(x)
            stages.append(x)
        for lift, block, skip in reversed(list(zip(self.lift, self.decoder, stages[:-1], strict=True))):
            x = block(skip + functional.interpolate(lift(x), size=skip.shape[-2:], mode="nearest"))
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
        return grid.take_back(winners, points, pixels, index)

    def label(self, image: RangeImage) -> np.ndarray:
        """The label image u8 [H, W] of a scan of any sensor: 0 where there is no return."""
        label = np.zeros(image.sensor.shape, dtype=np.uint8)
        intensity = None if image.intensity is None else image.intensity[image.valid]
        label[image.valid] = self.label_points(image.points(), intensity, image.sensor.mount_height)
        return label

    def save(self, path: str | os.PathLike[str], card: dict[str, Any]) -> None:
        """Write weights, config and a card of JSON types as one safetensors file."""
        tensors = {name: t.detach().cpu().contiguous() for name, t in self.state_dict().items()}
        metadata = {"schema": SCHEMA, "config": json.dumps(self.config.to_dict()), "card": json.dumps(card)}
        with written_whole(path) as temporary:
            temporary.write_bytes(serialise(tensors, metadata))

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Segmenter:
        """The segmenter of a weight file, in evaluation mode; raises `CheckpointError`."""
        name = os.fspath(path)
        try:
            with safe_open(path, framework="pt") as file:
                metadata = file.metadata() or {}
                tensors = {key: file.get_tensor(key) for key in file.keys()}  # noqa: SIM118
        except (SafetensorError, OSError) as error:
            raise CheckpointError(f"{name} is no whole safetensors file: {error}") from None
        if metadata.get("schema") != SCHEMA:
            raise CheckpointError(f"{name}: schema is {metadata.get('schema')!r}; this version reads {SCHEMA!r}")
        try:
            segmenter = cls(SegmenterConfig.from_dict(json.loads(metadata["config"])))
            segmenter.load_state_dict(tensors)
        except (KeyError, TypeError, ValueError, RuntimeError) as error:
            message = " ".join(str(error).split())  # torch writes several lines
            raise CheckpointError(f"{name}: its config and weights make no segmenter: {message}") from None
        broken = [key for key, tensor in tensors.items() if not tensor.isfinite().all()]
        if broken:
            raise CheckpointError(f"{name}: tensor {broken[0]!r} holds values that are not finite")
        return segmenter.eval()


class _Block(nn.Module):
    """norm, SiLU, convolution, twice, on a shortcut."""

    def __init__(self, inputs: int, outputs: int, *, stride: int = 1, dilation: int = 1) -> None:
        super().__init__()
        self.stride = stride
        self.norm_in, self.norm_out = group_norm(inputs), group_norm(outputs)
        self.conv_in = RingConv(inputs, outputs, stride=stride, dilation=dilation)
        self.conv_out = RingConv(outputs, outputs, dilation=dilation)
        self.shortcut = nn.Conv2d(inputs, outputs, 1) if inputs != outputs else nn.Identity()

    def forward(self, x: Tensor) -> Tensor:
        """[B, inputs, H, W] -> [B, outputs, ceil(H / stride), ceil(W / stride)]."""
        h = self.conv_in(functional.silu(self.norm_in(x)))
        h = self.conv_out(functional.silu(self.norm_out(h)))
        if self.stride > 1:
            x = functional.avg_pool2d(x, self.stride, ceil_mode=True, count_include_pad=False)
        return self.shortcut(x) + h
