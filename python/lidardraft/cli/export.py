"""`lidardraft export`: folders of scans as data sets that other people's readers open."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from lidardraft.cli.command import progress
from lidardraft.cli.scan_folder import scans_in
from lidardraft.formats.frame import FORMATS, Frame, writer_of


def export(arguments: argparse.Namespace) -> None:
    """Write folders of scans as one data set in a format that other people's readers open."""
    write = writer_of(arguments.format)
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
