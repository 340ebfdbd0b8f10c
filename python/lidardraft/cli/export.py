"""`lidardraft export`: folders of scans as data sets that other people's readers open."""

from __future__ import annotations

import argparse
import importlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lidardraft.cli.command import progress
from lidardraft.cli.scan_folder import scans_in

if TYPE_CHECKING:
    from lidardraft.formats.frame import Frame

# The module of `formats` and the function that writes each format, and what it is.
FORMATS = {
    "kitti": ("kitti_object", "write_kitti_object", "KITTI's 3D object benchmark"),
    "semantickitti": ("semantickitti", "write_sequences", "SemanticKITTI, a sequence a folder"),
    "nuscenes": ("nuscenes_tables", "write_nuscenes", "nuScenes with lidarseg"),
    "openpcdet": ("openpcdet", "write_openpcdet", "OpenPCDet's custom data sets"),
    "mmdet3d": ("mmdet3d", "write_mmdet3d", "MMDetection3D's custom data sets"),
    "pcd": ("pcd", "write_pcd_folder", "PCD files with ring, time, label and instance"),
    "ply": ("ply", "write_ply_folder", "PLY files with the same"),
    "laz": ("las", "write_laz", "LAZ files with the same"),
    "mcap": ("mcap", "write_mcap", "MCAP files with Foxglove's messages, one a folder"),
    "webdataset": ("webdataset", "write_webdataset", "WebDataset shards"),
}


def export(arguments: argparse.Namespace) -> None:
    """Write folders of scans as one data set in a format that other people's readers open."""
    module, function, _ = FORMATS[arguments.format]
    write: Callable[..., None] = getattr(importlib.import_module(f"lidardraft.formats.{module}"), function)
    drives = [scans_in(Path(folder)) for folder in arguments.folders]
    count = sum(map(len, drives))
    with progress(count, "scan") as bar:
        write(arguments.output, (_frames(drive, bar) for drive in drives))
    print(f"{arguments.output}: {count} scan{'s' * (count > 1)} as {arguments.format}")


def export_options(parser: argparse.ArgumentParser) -> None:
    """The options of `export`."""
    parser.epilog = (
        "Each folder is a drive: its scans follow one another, at the times of a sequence or a sweep time apart. "
        "Frames, axes, box centres and class ids of each format: docs/formats.md. The data set is there "
        "whole or not at all."
    )
    parser.add_argument("folders", nargs="+", metavar="FOLDER", help="scans of `simulate`, `generate` or `observe`")
    text = "; ".join(f"{name}: {what}" for name, (_, _, what) in FORMATS.items())
    parser.add_argument("--format", required=True, choices=FORMATS, metavar="NAME", help=text)
    parser.add_argument("-o", "--output", required=True, metavar="FOLDER", help="where it goes: new or empty")


def _frames(scans: list[Path], bar: Any) -> Iterator[Frame]:
    from lidardraft.scan import Scan

    for name in scans:
        yield Scan.load(name).frame()
        bar.update()
