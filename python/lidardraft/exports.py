"""Scans become a data set in a foreign format."""

from __future__ import annotations

import os
import re
import warnings
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import chain, groupby
from pathlib import Path
from typing import TypeVar

from lidardraft.errors import FormatError, check_that
from lidardraft.files import new_folder
from lidardraft.formats.frame import AS_SEEN, UNBOXED, Frame, writer_of
from lidardraft.scan import Scan

T = TypeVar("T")
Saved = Scan | str | os.PathLike[str]  # a scan, or the name of a saved one


Scans = Saved | Iterable[Saved | Iterable[Saved]]


def export(
    scans: Scans | Mapping[str, Scans],
    format: str,
    output: str | os.PathLike[str],
    *,
    as_seen: bool | None = None,
    box_margin: float = 0.0,
) -> None:
    """Write a data set of scans into the new folder `output`, in a format of docs/reference/formats.md ("kitti", ...).

    `scans` are a scan, a drive of scans or of names of saved ones, all scans of a folder or of the drives in it, or
    several drives, in order. For several sensors of one vehicle, `scans` maps the name of each channel to its scans.
    "nuscenes" makes one data set of them, in which a sample has a sweep of each channel; other formats get a folder
    OUTPUT/CHANNEL for each.

    Points and boxes are those of `Scan.frame`, by default `as_seen` for "ros2". If the format has boxes and
    there are none at all, a `UserWarning` says so. Raises `FormatError` for an unknown format, no scans, an `output`
    that exists already, invalid names of channels, and channels with different numbers of scans.
    """
    write, boxes, seen = writer_of(format), 0, format in AS_SEEN if as_seen is None else as_seen

    def frames(drive: Iterable[Saved], channel: str) -> Iterator[Frame]:
        nonlocal boxes
        for scan in drive:
            frame = (scan if isinstance(scan, Scan) else Scan.load(scan)).frame(as_seen=seen, box_margin=box_margin)
            boxes += len(frame.annotations)
            yield replace(frame, channel=channel)

    def drives(scans: Scans, channel: str = "") -> Iterator[Iterator[Frame]]:
        return (frames(drive, channel) for drive in _drives(scans))

    if not isinstance(scans, Mapping):
        write(output, drives(scans))
    else:
        for channel in scans:
            check_that(_is_name(channel), "channel", channel, "a name of letters, digits, _ and -")
        if format == "nuscenes":
            write(output, map(_by_moment, _together(drives(each, channel) for channel, each in scans.items())))
        else:
            with new_folder(output) as folder:
                for channel, each in scans.items():
                    write(folder / channel, drives(each))
    if not boxes and format not in UNBOXED:
        said = "no scan has a box; `observe` takes those of NAME.boxes.json or NAME.layout.json beside its casts"
        warnings.warn(f"{os.fspath(output)}: {said}", stacklevel=2)


def _drives(scans: Scans) -> Iterator[Iterable[Saved]]:
    if isinstance(scans, Scan):
        scans = [scans]
    elif isinstance(scans, str | os.PathLike):
        scans = drives_in(Path(scans))
    runs = groupby(scans, lambda each: isinstance(each, Scan | str | os.PathLike))
    return chain.from_iterable([run] if of_scans else run for of_scans, run in runs)  # type: ignore[list-item, misc]


def _is_name(channel: object) -> bool:
    return isinstance(channel, str) and re.fullmatch(r"[\w-]+", channel) is not None


def _together(channels: Iterable[Iterable[T]]) -> Iterator[tuple[T, ...]]:
    """The first item of all channels, the second of all, and so on; raises `FormatError` if one has fewer."""
    try:
        yield from zip(*channels, strict=True)
    except ValueError:
        raise FormatError("the channels have different numbers of scans; a moment needs one of each") from None


def _by_moment(channels: Iterable[Iterable[Frame]]) -> Iterator[Frame]:
    return chain.from_iterable(_together(channels))


def drives_in(folder: Path) -> list[list[Path]]:
    """The scans of a folder as one drive, or one drive for each folder in it, in order."""
    inner = sorted(each.parent for each in folder.glob("*/tracks.json"))
    return [scans_in(each) for each in inner or [folder]]


def scans_in(folder: Path) -> list[Path]:
    """The scans of a folder in order, without their endings."""
    if not folder.is_dir():
        raise FormatError(f"{folder} is not a folder of scans")
    endings = sorted(path.name for path in folder.glob("*.sensor.json"))
    if not endings:
        raise FormatError(f"{folder} holds no scans of `simulate`, `generate` or `observe`: no .sensor.json found")
    return [folder / name.removesuffix(".sensor.json") for name in endings]
