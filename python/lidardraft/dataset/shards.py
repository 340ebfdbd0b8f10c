"""A data set on disk: shards that are written whole or not at all, with the counts of their contents beside each.

Shard NNNNNN is NNNNNN.tar or a folder of that name; NNNNNN.json marks it as done. So remains of a crash are recognised,
and made again, to the same bytes. Once all are done, they are merged into a folder named as the format; summary.json,
written last, marks that as whole.
"""

from __future__ import annotations

import dataclasses
import itertools
import json
import math
import random
import shutil
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from lidardraft.dataset.card import card
from lidardraft.dataset.merge import merge
from lidardraft.dataset.recipe import SCANS, Recipe
from lidardraft.errors import FormatError
from lidardraft.files import locked_folder, named, new_folder, read_text, write_text
from lidardraft.formats.frame import AS_SEEN, BY_DRIVE, Annotation, Frame, by_split, with_riders_merged, writer_of
from lidardraft.formats.webdataset import write_shard
from lidardraft.json_fields import parse_object
from lidardraft.scan import Scan
from lidardraft.semantics import CLASSES

_RING, _RINGS = 10, 8  # m, the width of the ranges in which boxes are counted; their number, the last without end
_LOOKS = 8  # tries for a lock while other processes try it too
_UNMERGED = ("webdataset", SCANS)  # formats whose shards need no merge
_SPARE = 2**30  # bytes of the disk to keep free
Tally = dict[str, Any]  # numbers, or tallies, by name
Item = TypeVar("Item")
T = TypeVar("T")


@dataclass(frozen=True)
class DataSet:
    """The shards of a recipe in a folder."""

    recipe: Recipe
    folder: Path

    def write(self, share: tuple[int, int], by: Callable[..., Iterator[Tally]]) -> Iterator[int]:
        """Make the shards of share (i, n), every n-th from the i-th on, that are not done; yields the number of their
        scans made so far, at first and after each. Once all shards of all shares are done, summary.json is written.

        `by(make, numbers)` yields `make(number)` for each number, in any order, as `map` does. Raises `FormatError` if
        the folder holds another recipe's shards, if another process writes the same ones, or if the disk is too small.
        """
        with self._locked(share):
            self._check_recipe()
            held: Tally = {"scans": 0, "bytes": 0}
            mine = self._of(share)
            done = {number for number in self._begun() if number in mine and _add(held, self.done(number))}
            yield held["scans"]
            for tally in by(self.make, (number for number in mine if number not in done and self._has_room(held))):
                _add(held, tally)
                yield held["scans"]
            self._summarise()

    def scans_of(self, share: tuple[int, int]) -> int:
        """The number of scans of a share."""
        mine = self._of(share)
        return sum(len(self._items(number)) for number in mine[-1:]) + len(mine[:-1]) * self.recipe.shard_size

    def make(self, number: int) -> Tally:
        """Make a shard, unless it is done, and count its contents."""
        if done := self.done(number):
            return done
        self._remove(number)
        tally: Tally = {}
        path, format, drives = self.folder / self.name(number), self.recipe.format, self._drives(number, tally)
        if format == "webdataset":
            write_shard(path, ((f"{k:06d}", self._frame(k, scan)) for drive in drives for k, scan in drive))
        elif format == SCANS:
            with new_folder(path) as folder:
                for k, scan in itertools.chain.from_iterable(drives):
                    scan.save(folder / f"{k:06d}", picture=False)
        else:
            frames, first = self.recipe.frames if format in BY_DRIVE else 0, self._items(number).start
            runs = ((self._frame(k, scan) for k, scan in drive) for drive in drives)
            writer_of(format)(path, runs, first=first // (frames or 1))
        files = [path, *path.rglob("*")] if path.is_dir() else [path]
        tally["bytes"] = sum(file.stat().st_size for file in files if file.is_file())
        write_text(self.folder / f"{number:06d}.json", json.dumps(tally, sort_keys=True))
        return tally

    def name(self, number: int) -> str:
        """The name of a shard's file or folder."""
        return f"{number:06d}{'.tar' * (self.recipe.format == 'webdataset')}"

    def done(self, number: int) -> Tally | None:
        """The counts of a shard; None if it is not done, or has fewer scans than it now needs."""
        tally = self._held(number)
        return tally if tally and tally.get("scans") == len(self._items(number)) else None

    def _held(self, number: int) -> Tally | None:
        path = self.folder / f"{number:06d}.json"
        return parse_object(read_text(path)) if path.exists() and (self.folder / self.name(number)).exists() else None

    def _of(self, share: tuple[int, int]) -> range:
        return range(share[0], self._shards(), share[1])

    def _shards(self) -> int:
        return -(-self.recipe.scans // self.recipe.shard_size)

    def _begun(self) -> list[int]:
        """The shards that are done, or were done for another number of scans."""
        return [int(path.stem) for path in self.folder.glob("*.json") if path.stem.isdigit()]

    def _items(self, number: int) -> range:
        size = self.recipe.shard_size
        return range(number * size, min((number + 1) * size, self.recipe.scans))

    def _drives(self, number: int, tally: Tally) -> Iterator[Iterator[tuple[int, Scan]]]:
        """The scans of a shard with their numbers, drive by drive, each counted as it is made."""

        def counted(drive: Iterator[tuple[int, Scan]]) -> Iterator[tuple[int, Scan]]:
            for k, scan in drive:
                place, air = self.recipe.drawn(k)
                _add(tally, _count(scan, place, air, self.recipe.split(k), apart=self.recipe.format == SCANS))
                yield k, scan

        return map(counted, self.recipe.made(self._items(number)))

    def _frame(self, number: int, scan: Scan) -> Frame:
        seen = self.recipe.format in AS_SEEN
        return dataclasses.replace(scan.frame(as_seen=seen), split=self.recipe.split(number))

    def _remove(self, number: int) -> None:
        """Remove the remains of a crash, or of a shorter run, of a shard: its count first, so that it is not done."""
        (self.folder / f"{number:06d}.json").unlink(missing_ok=True)
        self._remove_all(self.name(number), f"{number:06d}")

    def _remove_all(self, name: str, stem: str) -> None:
        partial = [path for start in ("", ".") for path in self.folder.glob(f"{start}{stem}.*.partial")]
        for path in (self.folder / name, *partial):
            if path.is_dir():
                shutil.rmtree(path)
            else:
                path.unlink(missing_ok=True)

    @contextmanager
    def _locked(self, share: tuple[int, int]) -> Iterator[None]:
        """Hold the lock of a share. Shares of one size write at the same time, others one after the other."""
        self.folder.mkdir(parents=True, exist_ok=True)
        mine, size = f".lock-{share[0]}-of-{share[1]}", f"-of-{share[1]}"
        with locked_folder(self.folder, mine):
            for other in self.folder.glob(".lock-*"):
                if not other.name.endswith(size):
                    _check_free(self.folder, other.name)
            yield

    def _check_recipe(self) -> None:
        """Keep the recipe in the folder; raises `FormatError` if the folder has another recipe, or more scans than this
        one."""
        path = self.folder / "recipe.json"
        if not path.exists():
            self._remove_all(path.name, path.name)
            found = sorted(each.name for each in self.folder.glob("[!.]*"))
            if found:
                raise FormatError(f"{self.folder} is not empty ({found[0]}); use another folder")
            write_text(path, self.recipe.text)
        elif (begun := read_text(path)) != self.recipe.text:
            with named(path):
                raise FormatError(_difference(parse_object(begun), parse_object(self.recipe.text)))
        last = max(self._begun(), default=0)
        held = last * self.recipe.shard_size + (self._held(last) or {"scans": 0})["scans"]
        if held > self.recipe.scans:
            raise FormatError(f"{self.folder} holds {held} scans; ask for as many or more, or use another folder")

    def _has_room(self, held: Tally) -> bool:
        """True; raises `FormatError` if the disk is too small for the remaining scans, at the mean size of the `held`
        ones."""
        left = max(self.recipe.scans - self.recipe.shard_size * len(self._begun()), 0)
        needed, free = left * held["bytes"] // max(held["scans"], 1), shutil.disk_usage(self.folder).free
        if needed + _SPARE > free:
            room = f"{free / 1e9:.1f} GB are free, of which {_SPARE / 1e9:.1f} stay so"
            raise FormatError(f"{self.folder}: {left} scans are left and take {needed / 1e9:.1f} GB; {room}")
        return True

    def _summarise(self) -> None:
        """Write summary.json, the sum of all shards, if all are done; first merge them into one data set."""
        total: Tally = {}
        if not all(_add(total, self.done(number)) for number in range(self._shards())):
            return
        path, text = self.folder / "summary.json", json.dumps(total, indent=1, sort_keys=True)
        whole, merged = self.folder / self.recipe.format, self.recipe.format not in _UNMERGED
        with ExitStack() as held:
            try:
                held.enter_context(locked_folder(self.folder, ".merging"))
            except FormatError:  # another share does it
                return
            if path.exists() and read_text(path) == text and whole.exists() == merged:
                return
            for old in (path.name, whole.name):
                self._remove_all(old, old)
            if merged:
                merge([self.folder / self.name(number) for number in range(self._shards())], whole)
            if self.recipe.splits:
                parts = by_split({f"{k:06d}": self.recipe.split(k) for k in range(self.recipe.scans)})
                write_text(self.folder / "splits.json", json.dumps(parts))
            write_text(self.folder / "README.md", card(self.recipe, total))
            write_text(path, text)


def _difference(begun: Tally, asked: Tally) -> str:
    """The difference between the recipe of a folder and the given one, and how to go on."""
    version, here = begun.get("version"), asked["version"]
    if version is None:
        said = f"an earlier lidardraft wrote it without a version, so scans of {here} may differ; go on with that one"
    elif version != here:
        said = f"the folder holds scans of lidardraft {version}, and this is {here}; go on with {version}"
    elif begun | {"weights": asked["weights"]} == asked:
        said = "the folder holds scans of other weights than the recipe names now; give the former files back"
    else:
        said = "the folder holds scans of another recipe; go on with that one"
    return f"{said}, or use another folder"


def _check_free(folder: Path, lock: str) -> None:
    """Raise `FormatError` if another process holds a lock for longer than a try, as in this function, takes."""
    for _ in range(_LOOKS):
        with suppress(FormatError), locked_folder(folder, lock):
            return
        time.sleep(random.uniform(0.02, 0.1))
    with locked_folder(folder, lock):
        return


def _count(scan: Scan, scene: int, weather: dict[str, Any], split: str, *, apart: bool) -> Tally:
    """The contents of a scan; riders `apart` from their vehicles, or both as one box, as formats have them."""
    returns = np.bincount(scan.labels(), minlength=len(CLASSES))
    each = [Annotation(box, count, 0.0) for box, count in zip(scan.boxes(), scan.returns_per_box(), strict=True)]
    boxes = [found.box for found in (each if apart else with_riders_merged(each)) if found.num_points]
    tens = (min(int(math.hypot(*box.center[:2]) // _RING), _RINGS) * _RING for box in boxes)
    return {
        "ranges": Counter(f"from {ten} m" for ten in tens),
        "splits": {split or "all": 1},
        "scans": 1,
        "points": {row.name: int(returns[row.id]) for row in CLASSES if returns[row.id]},
        "boxes": Counter(box.label for box in boxes),
        "scenes": {str(scene): 1},
        "sensors": {scan.image.sensor.name: 1},
        "weather": {", ".join(weather) or "clear": 1},
    }


def _add(total: Tally, tally: Tally | None) -> bool:
    """Add numbers, and those of each name, to a total; returns whether there were any."""
    for what, counted in (tally or {}).items():
        if isinstance(counted, dict):
            _add(total.setdefault(what, {}), counted)
        else:
            total[what] = total.get(what, 0) + counted
    return tally is not None
