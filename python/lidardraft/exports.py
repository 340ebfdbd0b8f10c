"""Scans become a data set in a format of others."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterable, Iterator
from itertools import chain, groupby
from pathlib import Path

from lidardraft.errors import FormatError
from lidardraft.formats.frame import AS_SEEN, UNBOXED, Frame, writer_of
from lidardraft.scan import Scan

Saved = Scan | str | os.PathLike[str]  # a scan, or the name of a saved one


def export(
    scans: Saved | Iterable[Saved | Iterable[Saved]],
    format: str,
    output: str | os.PathLike[str],
    *,
    as_seen: bool | None = None,
    box_margin: float = 0.0,
) -> None:
    """Write a scan, a drive of scans or of names of saved ones, all of a folder, or several drives, one scan after the
    other, into the new folder `output` in a format of docs/formats.md ("kitti", "nuscenes", ...).

    Points and boxes are those of `Scan.frame`, by default `as_seen` for "mcap" and "ros2". No box at all is a
    `UserWarning` if the format has boxes. Raises `FormatError` for an unknown format, no scans, or an `output` that is
    there already.
    """
    write, boxes, seen = writer_of(format), 0, format in AS_SEEN if as_seen is None else as_seen

    def frames(drive: Iterable[Saved]) -> Iterator[Frame]:
        nonlocal boxes
        for scan in drive:
            frame = (scan if isinstance(scan, Scan) else Scan.load(scan)).frame(as_seen=seen, box_margin=box_margin)
            boxes += len(frame.annotations)
            yield frame

    if isinstance(scans, Scan):
        scans = [scans]
    elif isinstance(scans, str | os.PathLike):
        scans = scans_in(Path(scans))
    runs = groupby(scans, lambda each: isinstance(each, Scan | str | os.PathLike))
    drives = chain.from_iterable([run] if of_scans else run for of_scans, run in runs)
    write(output, map(frames, drives))  # type: ignore[arg-type]
    if not boxes and format not in UNBOXED:
        said = "no scan has a box; `observe` takes those of NAME.boxes.json or NAME.layout.json beside its casts"
        warnings.warn(f"{os.fspath(output)}: {said}", stacklevel=2)


def scans_in(folder: Path) -> list[Path]:
    """The scans of a folder in order, without their endings."""
    if not folder.is_dir():
        raise FormatError(f"{folder} is not a folder of scans")
    endings = sorted(path.name for path in folder.glob("*.sensor.json"))
    if not endings:
        raise FormatError(f"{folder} holds no scans of `simulate`, `generate` or `observe`: there is no .sensor.json")
    return [folder / name.removesuffix(".sensor.json") for name in endings]
