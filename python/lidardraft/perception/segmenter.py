"""Points -> classes: a range-image network that predicts the class of each return of a scan.

Points are put on a spherical grid (RangeNet++, Milioto et al., IROS 2019), so the scan may be of any sensor within the
grid's view. A convolutional encoder and decoder labels the grid, and the labels are projected back to the points.
"""

from __future__ import annotations

import dataclasses
import itertools
import os
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional

from lidardraft.errors import LayoutError, LidarDraftError, SensorError
from lidardraft.networks import weight_file, weight_header
from lidardraft.networks.layers import Chain, RangeImageConv, ResidualBlock, fold, reduced_precision, unfold
from lidardraft.networks.weight_file import Network
from lidardraft.scene.range_image import RangeImage
from lidardraft.semantics import NUM_CLASSES

# Log depth, x, y, height over the ground twice, intensity and whether it is known, validity, normal up and to the ray.
FEATURES = 10
SURE = 0.5  # the least probability of a predicted class that replaces a label
_SIDEWAYS = 2  # which of them is y
_WINDOW = 2  # columns and rows around a point's pixel that may give its label
_AROUND = ((1, 1), (2, 3))  # axes of [K, H, W], and the reach of a pixel's neighbours along each
_LIKE = 0.5, 0.01  # m, and of the range: returns about this near are of the same class
# Rows, and columns, before and after a pixel, of the pairs for a normal; a grid may have rows without a beam.
_PAIRS = ((1, 1), (1, 2), (2, 1), (2, 2)), ((1, 1), (2, 2), (3, 3))
_STEEP = 0.1  # of the range, and m: the largest difference of two returns of a surface a pixel apart
_FITTED = 8192  # the most points for the fit of the ground
_SPREADS = (
    1.0,
    0.7,
    0.5,
    0.35,
    0.25,
    0.2,
)  # m over the ground, within which points count as ground, by steps
_DENSE = 30.0  # m, beyond which points count fully
_REACH = 50.0  # m, beyond which the ground is level
_HELD = np.diag([1e-3, 30, 30, 30, 30, 30])  # how firmly the ground is held to the plane under the sensor
_CELL = (1, 2)  # pixels that the network folds into one: thin objects are one column wide, but rarely two rows high
_WRAPS = True  # the grid has all azimuths, even if the sensor has a part of them


@dataclass(frozen=True, kw_only=True)
class SphericalGrid:
    """`rows` by `columns` pixels over all azimuths and the elevations `top` to `bottom` [degrees].

    The default is the 64 x 1024 image of +3 to -25 degrees to which RangeNet++ projects SemanticKITTI.
    """

    rows: int = 64
    columns: int = 1024
    top: float = 3.0
    bottom: float = -25.0

    def __post_init__(self) -> None:
        if self.rows < 1 or self.columns < 1 or not self.bottom < self.top:
            raise SensorError(
                f"grid is {self.rows} x {self.columns}, {self.top} to {self.bottom} degrees; it needs a row, a column "
                "and a top above its bottom"
            )

    def pixels(self, points: np.ndarray) -> np.ndarray:
        """The flat pixel i64 [N] of each point [N, 3]; points above or below the view are in the row at the edge."""
        x, y, z = points.T
        elevation = np.rad2deg(np.arctan2(z, np.hypot(x, y)))
        row = np.floor((self.top - elevation) * (self.rows / (self.top - self.bottom))).astype(np.int64)
        column = np.floor((0.5 - np.arctan2(y, x) / (2 * np.pi)) * self.columns).astype(np.int64) % self.columns
        return np.clip(row, 0, self.rows - 1) * self.columns + column

    def nearest(self, points: np.ndarray, pixels: np.ndarray) -> np.ndarray:
        """The index i64 [H, W] of the nearest point in each pixel, -1 if there is none."""
        index = np.full(self.rows * self.columns, -1, dtype=np.int64)
        order = np.argsort(-np.einsum("nk,nk->n", points, points), kind="stable")  # the last one written stays
        index[pixels[order]] = order
        return index.reshape(self.rows, self.columns)

    def back_project(self, points: np.ndarray, pixels: np.ndarray, index: np.ndarray) -> np.ndarray:
        """For each point [N], the flat pixel around its own, `pixels` [N], whose point in `index` [H, W] is nearest to
        it in depth.

        Points hidden behind another in their pixel would else get the label of that one.
        """
        depth = np.linalg.norm(points, axis=1)
        image = np.where(index < 0, np.inf, depth[index])
        row, column = np.divmod(pixels, self.columns)
        best, result = np.full(len(points), np.inf), pixels.copy()
        steps = [(r, c) for r in range(-_WINDOW, _WINDOW + 1) for c in range(-_WINDOW, _WINDOW + 1)]
        for r, c in sorted(steps, key=lambda step: abs(step[0]) + abs(step[1])):
            at = np.clip(row + r, 0, self.rows - 1), (column + c) % self.columns
            # A neighbour has to be nearer by more than the error of the own pixel's return.
            off = np.abs(image[at] - depth) + 0.1 * (abs(r) + abs(c))
            better = off < best
            best = np.where(better, off, best)
            result[better] = (at[0] * self.columns + at[1])[better]
        return result


@dataclass(frozen=True, kw_only=True)
class SegmenterConfig:
    """The form of the network: the channels of each stage, which has half the rows and columns of the one before.

    Raises `LidarDraftError` if there is no stage, or the columns of the grid do not pair up.
    """

    grid: SphericalGrid = field(default_factory=SphericalGrid)
    widths: tuple[int, ...] = (32, 64, 96, 160)

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
    """Labels scans; `forward` works on features, `label_points` and `label` on sensor data."""

    SCHEMA = "lidardraft.segmenter/2"

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

    @classmethod
    def from_pretrained(cls, name: str | os.PathLike[str] = "segmenter") -> Segmenter:
        """The packaged weights of that name, or the weight file at that path; raises `CheckpointError`."""
        return weight_file.load(weight_header.find(name), cls)

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

    @torch.inference_mode()
    def predict(
        self, points: np.ndarray, intensity: np.ndarray | None, mount_height: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """Class ids u8 [N] of sensor-frame points [N, 3] with intensities [N] in [0, 1], None if unknown, and the
        probability of each, f32 [N].

        The scan and its mirror image are labelled, and their probabilities averaged; then those of near returns are
        averaged (a bilateral filter, as the votes of RangeNet++'s nearest neighbours are). `mount_height` [m] is that
        of the sensor over the road. Raises `LayoutError` if the arrays do not fit.
        """
        points = np.asarray(points, dtype=np.float32)
        if points.ndim != 2 or points.shape[1] != 3 or not np.isfinite(points).all():
            raise LayoutError(f"points are {points.shape}; they must be finite and [N, 3]")
        if intensity is not None and intensity.shape != points.shape[:1]:
            raise LayoutError(f"intensity is {intensity.shape} for {len(points)} points; it must be [N]")
        if len(points) == 0:
            return np.zeros(0, np.uint8), np.zeros(0, np.float32)
        grid = self.config.grid
        pixels = grid.pixels(points)
        index = grid.nearest(points, pixels)
        x = torch.from_numpy(features(points, intensity, mount_height, index))
        x = torch.stack([x, mirrored(x)]).to(self.head.weight.device)
        with reduced_precision(x.device):
            seen, in_mirror = self(x).float().softmax(1)
        xyz = torch.from_numpy(np.where(index < 0, 0, points[index].transpose(2, 0, 1))).to(x.device)
        probability, winners = averaged((seen + in_mirror.flip(-1)) / 2, xyz).max(0)
        source = grid.back_project(points, pixels, index)
        label, sure = (winners + 1).to(torch.uint8).cpu().numpy(), probability.cpu().numpy()
        return label.ravel()[source], sure.ravel()[source]

    def label_points(
        self, points: np.ndarray, intensity: np.ndarray | None, mount_height: float, *, least: float = 0.0
    ) -> np.ndarray:
        """The class ids of `predict`, 0 if they are less probable than `least`."""
        label, probability = self.predict(points, intensity, mount_height)
        return np.where(probability < least, np.uint8(0), label)

    def label(self, image: RangeImage) -> np.ndarray:
        """The label image u8 [H, W] of a scan of any sensor; 0 without a return."""
        label = np.zeros(image.sensor.shape, dtype=np.uint8)
        intensity = None if image.intensity is None else image.intensity[image.valid]
        label[image.valid] = self.label_points(image.points(), intensity, image.sensor.mount_height)
        return label


def features(points: np.ndarray, intensity: np.ndarray | None, mount_height: float, index: np.ndarray) -> np.ndarray:
    """The input of the network, f32 [FEATURES, H, W], for points [N, 3] at the pixels that `index` [H, W] gives them.

    Intensities are relative to their mean, as each sensor has its own scale.
    """
    valid = index >= 0
    if len(points) == 0:
        return np.zeros((FEATURES, *index.shape), dtype=np.float32)
    xyz = np.where(valid[..., None], points[index], 0).astype(np.float32)
    depth = np.linalg.norm(xyz, axis=-1)
    height = (points[:, 2] - ground_heights(points, mount_height)).astype(np.float32)[index]
    out = np.zeros((FEATURES, *index.shape), dtype=np.float32)
    out[0] = np.log2(depth + 1) / 3.5 - 1
    out[1], out[2] = xyz[..., 0] / 40, xyz[..., 1] / 40
    out[3], out[4] = height / 4, np.tanh(5 * height)  # the second resolves kerbs
    if intensity is not None:
        out[5] = np.sqrt(np.minimum(intensity[index] / max(float(intensity.mean()), 1e-6), 9)) - 1
        out[6] = 1
    out[7] = 1
    out[8], out[9] = _normals(xyz, valid, depth)
    return out * valid


def averaged(probability: Tensor, xyz: Tensor) -> Tensor:
    """Probabilities [K, H, W], each the mean over the pixels around, weighted by the distance of their returns to its
    own, xyz [3, H, W].

    Without a return xyz is 0, which is far from all returns.
    """
    scale = 2 * (_LIKE[0] + _LIKE[1] * xyz.norm(dim=0)) ** 2
    for axis, reach in _AROUND:
        total, weights = probability.clone(), torch.ones_like(scale)
        for step in (*range(-reach, 0), *range(1, reach + 1)):
            weight = torch.exp(-(xyz.roll(step, axis) - xyz).square().sum(0) / scale)
            total += weight * probability.roll(step, axis)
            weights += weight
        probability = total / weights
    return probability


def mirrored(x: Tensor) -> Tensor:
    """The features [FEATURES, H, W] of the scan's mirror image, left for right."""
    x = x.flip(-1)
    x[_SIDEWAYS] *= -1
    return x


def ground_heights(points: np.ndarray, mount_height: float) -> np.ndarray:
    """The height [m] of the ground, f64 [N], at points [N, 3] in the sensor's frame: a paraboloid through low points.

    Sensors are tilted and roads are crowned: heights over this surface are alike in all recordings, heights over a
    level plane are not. A least-squares fit starts from that plane. Points off the ground count less and less, and
    those above it, as on objects, less than those below.
    """
    some = points[:: len(points) // _FITTED + 1]
    basis, height = _paraboloid(some), some[:, 2].astype(np.float64)
    start = np.array([-mount_height, 0, 0, 0, 0, 0])
    ground = start
    for spread in _SPREADS:
        off = height - basis @ ground
        weight = np.exp(-((off / np.where(off > 0, spread, 2 * spread)) ** 2))
        weight *= np.minimum(np.hypot(some[:, 0], some[:, 1]), _DENSE)  # far points are few
        left = (basis * weight[:, None]).T
        ground = np.linalg.solve(left @ basis + _HELD, left @ height + _HELD @ start)
    return np.asarray(_paraboloid(points) @ ground)


def _paraboloid(points: np.ndarray) -> np.ndarray:
    x, y = (np.clip(points[:, :2], -_REACH, _REACH) / _REACH).T.astype(np.float64)
    return np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=1)


def _normals(xyz: np.ndarray, valid: np.ndarray, depth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """|z| of the surface normal at each pixel, and its |cosine| to the ray; 0 if unknown."""
    across, there = _slope(xyz, valid, depth, 1)
    down, below = _slope(xyz, valid, depth, 0)
    normal = np.cross(across, down)
    length = np.linalg.norm(normal, axis=-1)
    good = there & below & (length > 1e-9)
    scale = np.where(good, 1 / np.maximum(length, 1e-9), 0)
    towards = np.abs(np.einsum("hwk,hwk->hw", normal, xyz)) / np.maximum(depth, 1e-6)
    return np.abs(normal[..., 2]) * scale, towards * scale


def _slope(xyz: np.ndarray, valid: np.ndarray, depth: np.ndarray, axis: int) -> tuple[np.ndarray, np.ndarray]:
    """The step from a pixel to the next, by least squares over pairs of returns of similar range on either side, and
    whether there is one. The pairs are wide, as else the noise of ranges would dominate."""
    total, count = np.zeros_like(xyz), np.zeros(valid.shape, dtype=np.float32)
    for back, on in _PAIRS[axis]:
        (before, after), (near, far), (one, other) = (
            (np.roll(image, back, axis), np.roll(image, -on, axis)) for image in (xyz, depth, valid)
        )
        apart = np.float32(back + on)
        pair = one & other & (np.abs(far - near) < _STEEP * (apart / 2 * depth + 1))
        if axis == 0:
            pair[:back] = pair[-on:] = False  # rows do not wrap
        total += (after - before) * (apart * pair)[..., None]
        count += apart**2 * pair
    return total / np.maximum(count, 1)[..., None], count > 0
