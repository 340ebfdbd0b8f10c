"""A folder of numbered scans, made and written by this process or by several."""

from __future__ import annotations

import argparse
import itertools
import os
import shutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Generic, TypeVar

from lidardraft.cli.arguments import check_empty, whole_number
from lidardraft.cli.command import say
from lidardraft.files import locked_folder

if TYPE_CHECKING:
    from lidardraft.cli.arguments import Options
T = TypeVar("T")

_MANY = 16  # the least scans for a process on each core, which takes a second to start
_PICTURES = 8  # made by default: one takes longer than a scan


def add_folder(parser: Options) -> None:
    """Add --output, --overwrite, --pictures and --no-picture."""
    parser.add_argument("-o", "--output", required=True, metavar="FOLDER", help="folder for scans: new or empty")
    parser.add_argument("--overwrite", action="store_true", help="replace the scans that are in FOLDER already")
    text = f"make pictures of the first N scans (default {_PICTURES})"
    parser.add_argument("--pictures", type=whole_number(0), default=_PICTURES, metavar="N", help=text)
    text = "make no pictures of scans"
    parser.add_argument("--no-picture", dest="pictures", action="store_const", const=0, help=text)


def add_jobs(parser: Options) -> None:
    """Add --jobs, for `jobs_of`."""
    text = f"processes that make scans (default 1 for fewer than {_MANY} scans, else {cores()}, one a core)"
    parser.add_argument("--jobs", type=whole_number(1), metavar="N", help=text)


def jobs_of(arguments: argparse.Namespace, num: int, run: int = 1) -> int:
    """The number of processes that make `num` scans, each of them `run` in a row."""
    return min(arguments.jobs or (cores() if num >= _MANY else 1), -(-num // run))


def cores() -> int:
    """The number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def check_output(arguments: argparse.Namespace) -> None:
    """Raises `FormatError` if the folder is not empty and --overwrite is not given."""
    otherwise = ", or --overwrite to replace its scans"
    check_empty(Path(arguments.output), otherwise, but=".*" if arguments.overwrite else "")


@dataclass(frozen=True, slots=True)
class ScanFolder(Generic[T]):
    """Scan `number` is `make(number)`, written by `save` under its number, with a picture if it is one of the first
    `pictures`; `notes` are lines about it for the user. All of these must be picklable."""

    path: Path
    pictures: int
    make: Callable[[int], T]
    save: Callable[..., None]
    notes: Callable[[int, T], list[str]] | None = None

    def write(self, num: int, *, jobs: int = 1, run: int = 1) -> Iterator[int]:
        """Write scans 0 to `num` - 1, by `jobs` processes, each of which makes `run` scans in a row; yields the count
        of written scans. Scans of an earlier call are removed once the first one is written. Raises `FormatError` if
        another process writes to the folder."""
        first = self.make(0)
        self.path.mkdir(parents=True, exist_ok=True)
        with locked_folder(self.path):
            _clear(self.path)
            made = itertools.chain([self._saved(0, first)], self._rest(num, jobs, run))
            for count, notes in enumerate(made):
                for note in notes:
                    say(note)
                yield count

    def _rest(self, num: int, jobs: int, run: int) -> Iterator[list[str]]:
        """The notes on each scan after the first, in order or, with several processes, in any order."""
        if jobs == 1:
            return map(self.written, range(1, num))
        from lidardraft.streets.worker_processes import in_processes

        runs = (range(max(first, 1), min(first + run, num)) for first in range(0, num, run))
        return itertools.chain.from_iterable(in_processes(self._run, runs, jobs))

    def _run(self, numbers: range) -> list[list[str]]:
        return [self.written(number) for number in numbers]

    def written(self, number: int) -> list[str]:
        """Make and write one scan; returns the notes on it."""
        return self._saved(number, self.make(number))

    def _saved(self, number: int, scan: T) -> list[str]:
        self.save(scan, self.path / f"{number:06d}", picture=number < self.pictures)
        return [] if self.notes is None else self.notes(number, scan)


def _clear(folder: Path) -> None:
    """Remove the scans of an earlier call, which are numbers with a sensor beside them, their tracks, and numbered
    folders of drives. The rest stays."""
    from lidardraft.scan import CASTS_FILE, SCAN_ENDINGS, TRACK_FILES

    names = [path.name.removesuffix(".sensor.json") for path in folder.glob("*.sensor.json")]
    numbers = [name for name in names if name.isdigit()]
    files = [f"{name}{ending}" for name in numbers for ending in SCAN_ENDINGS]
    for file in [*files, *((*TRACK_FILES, CASTS_FILE) if numbers else ())]:
        (folder / file).unlink(missing_ok=True)
    for drive in folder.glob("*/tracks.json"):
        if drive.parent.name.isdigit():
            shutil.rmtree(drive.parent)
