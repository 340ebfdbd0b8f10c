"""The networks whose features published scores compare, from the public weight files: RangeNet++ and PointNet.

A file must have exactly the tensors of the published architecture, with their shapes. Only tensors are unpickled.
Architectures: Milioto et al., IROS 2019 (PRBonn/lidar-bonnetal); Qi et al., CVPR 2017 (as in microsoft/SpareNet).
Inputs: vzyrianov/lidargen, kazuto1011/r2dm (FRD, FPD), hancyran/LiDAR-Diffusion (FRID).
"""

from __future__ import annotations

import hashlib
import io
import os
import random
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from torch import nn
from torch.nn import functional

from lidardraft.errors import CheckpointError
from lidardraft.files import expecting, named, read_bytes
from lidardraft.metrics.spherical import SphericalImage, corner_points

_LARGEST = 2**30  # bytes of a weight file; DarkNet-53 has 0.2 GB
_BLOCKS = {21: (1, 1, 2, 2, 1), 53: (1, 2, 8, 8, 4)}  # residual blocks of each stage of DarkNet
# range, x, y, z, intensity over SemanticKITTI, as RangeNet++ standardises them
_MEANS, _DEVIATIONS = (12.12, 10.88, 0.23, -1.04, 0.21), (12.32, 11.47, 6.91, 0.86, 0.16)
_KEPT, _FEATURES = 4096, 32 * 64 * 1024  # drawn by FRD
_NEAR, _FAR, _POINTNET_SCALE = 0.5, 63.0, 80.0  # m

Images = Callable[[SphericalImage], torch.Tensor]
Features = Callable[[torch.Tensor], torch.Tensor]


@dataclass(frozen=True)
class LoadedNetwork:
    """`measure` gives the features f32 [D] of an image; `description` names the weights and their hash."""

    measure: Callable[[SphericalImage], np.ndarray]
    description: str


@dataclass(frozen=True)
class FeatureNetwork:
    """Public weights: the `files` below a folder, the `address` of their source, and the parts in them, in order.

    `images` makes the input [1, ...] of a spherical image, `features` the features [D] of an output.
    """

    files: str
    address: str
    parts: Callable[[], tuple[nn.Module, ...]]
    images: Images
    features: Features

    def is_in(self, folder: str | os.PathLike[str]) -> bool:
        """Whether all files are in a folder."""
        return all(path.exists() for path in self._paths(folder))

    def load(self, folder: str | os.PathLike[str], device: str) -> LoadedNetwork:
        """The network of these files; raises `CheckpointError` if they hold another one, or random weights."""
        parts, digest = self.parts(), hashlib.sha256()
        for path, part in zip(self._paths(folder), parts, strict=True):
            data = read_bytes(path, _LARGEST)
            digest.update(data)
            with named(path):
                _fill(part, data)
            part.to(device).eval().requires_grad_(False)

        def measure(image: SphericalImage) -> np.ndarray:
            with torch.inference_mode():
                output = self.images(image).to(device)
                for part in parts:
                    output = part(output)
                return self.features(output).cpu().numpy()

        return LoadedNetwork(measure, f"{self.files}, sha256 {digest.hexdigest()[:16]}")

    def _paths(self, folder: str | os.PathLike[str]) -> list[Path]:
        return [Path(folder, name) for name in self.files.split(" and ")]


def _fill(network: nn.Module, data: bytes) -> None:
    """Fill a network with the tensors of a file of torch."""
    with expecting("a weight file of torch with tensors alone"):
        tensors = torch.load(io.BytesIO(data), map_location="cpu", weights_only=True)
    if not isinstance(tensors, dict):
        raise CheckpointError(f"it holds a {type(tensors).__name__}; it must hold tensors by name")
    wanted = network.state_dict()
    # networks from before PyTorch 0.4.1 have not counted batches
    tensors = {name: torch.tensor(1) for name in wanted if name.endswith("num_batches_tracked")} | tensors
    for problem, names in (("missing", wanted.keys() - tensors.keys()), ("unknown", tensors.keys() - wanted.keys())):
        if names:
            raise CheckpointError(f"tensor {min(map(str, names))!r} is {problem}")
    for name, tensor in wanted.items():
        found = tensors[name]
        if not isinstance(found, torch.Tensor) or found.shape != tensor.shape:
            shape = list(getattr(found, "shape", []))
            raise CheckpointError(f"tensor {name!r} is {shape}; it must be {list(tensor.shape)}")
        if not found.isfinite().all():
            raise CheckpointError(f"tensor {name!r} holds values that are not finite")
    untrained = all((found == 0).all() for name, found in tensors.items() if name.endswith("running_mean"))
    if untrained:
        raise CheckpointError("these weights are random: their batch normalisation has seen no scan")
    network.load_state_dict(tensors)


def _normalised(channels: int) -> tuple[tuple[str, nn.Module], ...]:
    return ("bn", nn.BatchNorm2d(channels)), ("relu", nn.LeakyReLU(0.1))


class _Residual(nn.Module):
    def __init__(self, middle: int, channels: int) -> None:
        super().__init__()
        self.conv1, self.bn1 = nn.Conv2d(channels, middle, 1, bias=False), nn.BatchNorm2d(middle)
        self.conv2, self.bn2 = nn.Conv2d(middle, channels, 3, padding=1, bias=False), nn.BatchNorm2d(channels)

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        inner = functional.leaky_relu(self.bn1(self.conv1(x)), 0.1)
        return x + functional.leaky_relu(self.bn2(self.conv2(inner)), 0.1)


class _Backbone(nn.Module):
    """DarkNet, whose five stages halve the width: [B, C, H, W] -> the outputs of all stages, the last one first."""

    def __init__(self, channels: int, layers: int) -> None:
        super().__init__()
        self.conv1, self.bn1 = nn.Conv2d(channels, 32, 3, padding=1, bias=False), nn.BatchNorm2d(32)
        for number, blocks in enumerate(_BLOCKS[layers]):
            into, out = 32 << number, 64 << number
            conv = nn.Conv2d(into, out, 3, stride=(1, 2), padding=1, bias=False)
            residual = ((f"residual_{k}", _Residual(into, out)) for k in range(blocks))
            stage = nn.Sequential(OrderedDict([("conv", conv), *_normalised(out), *residual]))
            self.add_module(f"enc{number + 1}", stage)

    def forward(self, x: torch.Tensor) -> list[torch.Tensor]:
        outputs = [functional.leaky_relu(self.bn1(self.conv1(x)), 0.1)]
        for number in range(1, 6):
            outputs.append(self.get_submodule(f"enc{number}")(outputs[-1]))
        return outputs[::-1]


class _Decoder(nn.Module):
    """The outputs of a `_Backbone` -> features [B, 32, H, W]."""

    def __init__(self) -> None:
        super().__init__()
        for number in range(5, 0, -1):
            into, out = 32 << number, 16 << number
            upconv = nn.ConvTranspose2d(into, out, (1, 4), stride=(1, 2), padding=(0, 1))
            layers = [("upconv", upconv), *_normalised(out), ("residual", _Residual(into, out))]
            self.add_module(f"dec{number}", nn.Sequential(OrderedDict(layers)))

    def forward(self, outputs: list[torch.Tensor]) -> torch.Tensor:
        x, *skipped = outputs
        for number, skip in zip(range(5, 0, -1), skipped, strict=True):
            x = self.get_submodule(f"dec{number}")(x) + skip
        return x


def _add_point_layers(network: nn.Module) -> None:
    for number, (into, out) in enumerate(((3, 64), (64, 128), (128, 1024)), start=1):
        network.add_module(f"conv{number}", nn.Conv1d(into, out, 1))
        network.add_module(f"bn{number}", nn.BatchNorm1d(out))


def _largest_of_points(network: nn.Module, x: torch.Tensor) -> torch.Tensor:
    """Three layers on each point [B, 3, N], the last without ReLU, and the largest of each channel [B, 1024]."""
    for number in (1, 2, 3):
        x = network.get_submodule(f"bn{number}")(network.get_submodule(f"conv{number}")(x))
        x = functional.relu(x) if number < 3 else x
    return x.amax(dim=2)


class _Turn(nn.Module):
    """Points [B, 3, N] -> the matrix [B, 3, 3] that they are multiplied by."""

    def __init__(self) -> None:
        super().__init__()
        _add_point_layers(self)
        self.fc1, self.fc2, self.fc3 = nn.Linear(1024, 512), nn.Linear(512, 256), nn.Linear(256, 9)
        self.bn4, self.bn5 = nn.BatchNorm1d(512), nn.BatchNorm1d(256)

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        x = functional.relu(_largest_of_points(self, x))
        x = functional.relu(self.bn5(self.fc2(functional.relu(self.bn4(self.fc1(x))))))
        return self.fc3(x).view(-1, 3, 3) + torch.eye(3, device=x.device)


class _TurnedPoints(nn.Module):
    def __init__(self) -> None:
        super().__init__()
        self.stn = _Turn()
        _add_point_layers(self)

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        return _largest_of_points(self, (x.transpose(1, 2) @ self.stn(x)).transpose(1, 2))


class _PointNet(nn.Module):
    """Points [B, 3, N] -> the outputs of all layers behind the points, [B, 1808]."""

    def __init__(self) -> None:
        super().__init__()
        self.feat = _TurnedPoints()
        self.fc1, self.fc2, self.fc3 = nn.Linear(1024, 512), nn.Linear(512, 256), nn.Linear(256, 16)
        self.bn1, self.bn2 = nn.BatchNorm1d(512), nn.BatchNorm1d(256)

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        first = self.feat(x)
        second = functional.relu(self.bn1(self.fc1(first)))
        third = functional.relu(self.bn2(self.fc2(second)))
        return torch.cat([first, second, third, self.fc3(third)], dim=1)


def _standardised(image: SphericalImage) -> torch.Tensor:
    if image.intensity is None:
        raise CheckpointError("the scan has no intensities, which the network takes")
    channels = np.stack([image.depth, *np.moveaxis(image.points, -1, 0), image.intensity])
    means, deviations = (np.array(values)[:, None, None] for values in (_MEANS, _DEVIATIONS))
    return torch.from_numpy((channels - means) / deviations * image.within(_NEAR, _FAR)).float()[None]


def _in_metres(image: SphericalImage) -> torch.Tensor:
    channels = np.stack([image.depth, *np.moveaxis(corner_points(image.depth), -1, 0)])
    return torch.from_numpy(np.where(image.depth > 0, channels, -1)).float()[None]


def _scaled_points(image: SphericalImage) -> torch.Tensor:
    points = image.points * image.within(_NEAR, _FAR)[..., None] / np.float32(_POINTNET_SCALE)
    return torch.from_numpy(points.reshape(1, -1, 3)).transpose(1, 2)


def _drawn(output: torch.Tensor) -> torch.Tensor:
    return output.flatten()[random.Random(0).sample(range(_FEATURES), _KEPT)]


def _by_rows(output: torch.Tensor) -> torch.Tensor:
    return output.view(32, 16, -1).mean(dim=2).flatten()


def _range_net(
    name: str, channels: int, layers: int, address: str, images: Images, features: Features
) -> FeatureNetwork:
    files = f"{name}/backbone and {name}/segmentation_decoder"
    return FeatureNetwork(files, address, lambda: (_Backbone(channels, layers), _Decoder()), images, features)


NETWORKS = {
    "darknet53-1024": _range_net(
        "darknet53-1024",
        5,
        53,
        "http://www.ipb.uni-bonn.de/html/projects/bonnetal/lidar/semantic/models/darknet53-1024.tar.gz, unpacked",
        _standardised,
        _drawn,
    ),
    "rangenet21_lidm": _range_net(
        "rangenet21_lidm",
        4,
        21,
        "https://github.com/kazuto1011/r2flow/releases/download/weights/rangenet21_lidm.tar.gz, unpacked",
        _in_metres,
        _by_rows,
    ),
    "cls_model_39": FeatureNetwork(
        "cls_model_39.pth",
        "https://github.com/microsoft/SpareNet/raw/main/Frechet/cls_model_39.pth",
        lambda: (_PointNet(),),
        _scaled_points,
        torch.flatten,
    ),
}
