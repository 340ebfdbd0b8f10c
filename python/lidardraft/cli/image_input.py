"""The options of --image, and its layout: what depth, classes and masks are may be files or names of networks."""

from __future__ import annotations

import argparse
import math
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from lidardraft.cli.arguments import number
from lidardraft.cli.command import say
from lidardraft.errors import FormatError, LidarDraftError
from lidardraft.scene.layout import Layout


def add_image_options(group: argparse._ArgumentGroup) -> None:
    """What says more about --image."""
    text = "depth of --image: a metric depth network (id or folder), or an .npy file [m], 0 where unknown"
    group.add_argument("--depth", metavar="MODEL", help=f"{text} (default: Depth Anything V2, outdoor, small)")
    text = "classes of --image: a segmentation network (id or folder), or an .npy or .png file of Cityscapes train ids"
    group.add_argument("--semantics", metavar="MODEL", help=f"{text} (default: EoMT on Cityscapes)")
    text = "objects of --image: an .npz, .npy or .png file of masks, or a network for them such as SAM (id or folder)"
    group.add_argument("--masks", metavar="FILE", help=f"{text} (default: points that touch)")
    text = "camera of --image in pixels, or a file that says it: .json, or a calibration of KITTI"
    group.add_argument("--intrinsics", metavar="FX,FY,CX,CY", help=text)
    text = "horizontal field of view of --image (default: what the file says of its focal length)"
    group.add_argument("--hfov", type=number, metavar="DEGREES", help=text)
    text = "height of the camera over the road, which sets the scale (default 1.65)"
    group.add_argument("--camera-height", type=number, metavar="M", help=text)
    text = "take depth of --image as metres: it sets the scale, and the height of the camera"
    group.add_argument("--metric-depth", action="store_true", default=None, help=text)
    text = "let a mirror image of --image stand where it shows nothing"
    group.add_argument("--fill", action="store_true", default=None, help=text)


def layout_of_image(arguments: argparse.Namespace) -> Layout:
    """The layout of --image; what scale it got is said on stderr."""
    from lidardraft.drafting.picture.layout import CAMERA_HEIGHT, DEPTH, SEMANTICS, layout_from_image
    from lidardraft.formats.cityscapes import read_semantics
    from lidardraft.formats.masks import read_masks

    if arguments.metric_depth and arguments.camera_height is not None:
        raise FormatError("--metric-depth and --camera-height both set the scale of --image; give one of them")
    height = CAMERA_HEIGHT if arguments.camera_height is None else arguments.camera_height
    depth, semantics = arguments.depth or DEPTH, arguments.semantics or SEMANTICS
    masks = arguments.masks
    with _naming_options(arguments, "depth", "semantics", "masks", "intrinsics"):
        layout = layout_from_image(
            Path(arguments.image),
            depth=_depths(depth) if depth.endswith(".npy") else depth,
            semantics=read_semantics(semantics) if semantics.endswith((".npy", ".png")) else semantics,
            masks=read_masks(masks) if masks and masks.lower().endswith((".npy", ".npz", ".png")) else masks,
            intrinsics=_intrinsics(arguments.intrinsics),
            hfov=None if arguments.hfov is None else math.radians(arguments.hfov),
            camera_height=None if arguments.metric_depth else height,
            fill=bool(arguments.fill),
        )
    height, scale = layout.provenance["sensor_height"], layout.provenance["scale"]
    say("lidardraft", f"{arguments.image}: depth times {scale:.2f}, so that the camera is {height:g} m over the road")
    return layout


@contextmanager
def _naming_options(arguments: argparse.Namespace, *names: str) -> Iterator[None]:
    """Errors about an argument that an option gives end with the option and its value, which may be a file."""
    try:
        yield
    except LidarDraftError as error:
        given = {name: getattr(arguments, name) for name in names if re.search(rf"\b{name}\b", str(error))}
        about = [f"--{name} {value}" for name, value in given.items() if value and value not in str(error)]
        raise type(error)(f"{error} ({', '.join(about)})" if about else str(error)) from None


def _depths(path: str) -> np.ndarray:
    """The depths [H, W] of a file, which is named where they are none."""
    from lidardraft.formats.npy import read_npy

    depth = read_npy(path)
    if depth.ndim != 2 or not depth.size:
        raise FormatError(f"{path}: its shape is {list(depth.shape)}; depths are [H, W], as many as --image has pixels")
    wrong = ~np.isfinite(depth) | (depth < 0)
    if wrong.any():
        row, column = np.argwhere(wrong)[0].tolist()
        raise FormatError(
            f"{path}: {depth[row, column]} at row {row}, column {column} is no depth [m], which is finite, and 0 where "
            "unknown"
        )
    return depth


def _intrinsics(given: str | None) -> object | None:
    """fx, fy, cx and cy where the text is numbers with commas between them, else the file that it names."""
    if given is None or "," not in given:
        return given
    try:
        values = [float(part) for part in given.split(",")]
    except ValueError:
        values = []
    if len(values) != 4:
        raise FormatError(f"--intrinsics is {given!r}; it must be FX,FY,CX,CY in pixels, or a file")
    return values
