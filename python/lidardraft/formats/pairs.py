"""Training pairs: a folder of shards with scans and condition images of the same places; compact, whole or absent."""

from __future__ import annotations

import itertools
import json
import os
import zipfile
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from lidardraft import array_files
from lidardraft.errors import FormatError
from lidardraft.files import locked_folder, named, read_text, write_text, written_whole
from lidardraft.json_fields import check_object, parse_document, parse_list
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.sensor import Sensor
from lidardraft.semantics import CLASSES

SCHEMA = "lidardraft.pairs/5"
SHARD = 64  # pairs a file
_LARGEST_SHARD = 2**16  # pairs that an index may claim
DEPTH_STEP = 0.002  # m, the unit of depth in the uint16 images; up to 131 m, and anything further is 131 m
INTENSITY_STEP = 1 / 255  # the unit of intensity in the uint8 images
IMAGES = {
    "scan_depth": np.uint16,
    "scan_label": np.uint8,
    "scan_intensity": np.uint8,
    "condition_depth": np.uint16,
    "condition_label": np.uint8,
}

_NOTES = "notes.json"
_CLASSES = [row.name for row in CLASSES]
# Noise does not compress: a scan's ranges and intensities are stored uncompressed.
_COMPRESSED = ("scan_label", "condition_depth", "condition_label")

Images = dict[str, np.ndarray]
Notes = list[dict[str, Any]]


class Pair(NamedTuple):
    """A scan, and the condition image of a layout of the same place."""

    scan: RangeImage
    condition_image: RangeImage

    @classmethod
    def from_compact(cls, sensor: Sensor, images: Images) -> Pair:
        """The pair of compact images [H, W], named as in `IMAGES`; instances are not kept."""
        none = np.zeros(sensor.shape, dtype=np.uint32)

        def image_of(name: str) -> RangeImage:
            intensity = images.get(f"{name}_intensity")
            return RangeImage(
                sensor=sensor,
                depth=images[f"{name}_depth"] * np.float32(DEPTH_STEP),
                label=images[f"{name}_label"],
                instance=none,
                intensity=None if intensity is None else intensity * np.float32(INTENSITY_STEP),
            )

        return cls(image_of("scan"), image_of("condition"))

    def compact(self) -> Images:
        """The stored images, named and typed as in `IMAGES`. Raises `FormatError` if an intensity is not finite."""
        if not all(image.intensity is None or np.isfinite(image.intensity).all() for image in self):
            raise FormatError("a pair holds an intensity that is not finite")
        images = {"scan": self.scan, "condition": self.condition_image}
        return {name: _COMPACT[part](images[of]) for name in IMAGES for of, part in [name.split("_")]}


NotedPair = tuple[Pair, dict[str, Any]]


class PairIndex(NamedTuple):
    """The index.json of a folder: the sensor of the pairs, their source, and the number of pairs in each shard."""

    folder: Path
    sensor: Sensor
    source: str
    counts: list[int]

    @classmethod
    def load(cls, folder: Path) -> PairIndex:
        """The index of a folder; raises `FormatError` if it is missing or broken."""
        path = folder / "index.json"
        text = read_text(path)
        with named(path):
            index = parse_document(text, SCHEMA, ("classes", "sensor", "shards"), ("source",))
            if index["classes"] != _CLASSES:
                raise FormatError(f"the pairs have another class table than this version: {index['classes']!r:.60}")
            counts = index["shards"]
            if not isinstance(counts, list) or not all(type(c) is int and 0 < c <= _LARGEST_SHARD for c in counts):
                raise FormatError(f"shards is {counts!r}; it must be counts of 1 to {_LARGEST_SHARD} pairs")
            sensor = Sensor.from_json(json.dumps(index["sensor"]))
        return cls(folder, sensor, str(index.get("source", "")), counts)

    def save(self) -> None:
        """Write the index."""
        fields = json.loads(self.sensor.to_json())
        index = {"schema": SCHEMA, "source": self.source, "classes": _CLASSES, "sensor": fields, "shards": self.counts}
        write_text(self.folder / "index.json", json.dumps(index))

    def shard(self, number: int) -> tuple[Images, Notes]:
        """The compact images [N, H, W] of a shard, and the note on each pair; raises `FormatError`."""
        shape = (self.counts[number], *self.sensor.shape)
        with array_files.opened(_shard_path(self.folder, number)) as archive:
            images = {
                name: array_files.read_array(archive, name, np.dtype(dtype), shape) for name, dtype in IMAGES.items()
            }
            return images, _read_notes(archive, shape[0])


def pairs_on_disk(directory: str | os.PathLike[str], *, source: str = "") -> int:
    """The number of pairs in a folder, 0 without an index. A seeded source goes on from here.

    Raises `FormatError` if they are from another `source`.
    """
    index = _index_of_source(Path(directory), source)
    return sum(index.counts) if index else 0


def notes_on_disk(directory: str | os.PathLike[str], sensor: Sensor, *, source: str = "") -> Notes:
    """The notes on each pair of a folder; an empty list without an index.

    Raises `FormatError` if they are from another `source` or another sensor.
    """
    index = _index_of_source(Path(directory), source)
    if index is None:
        return []
    if index.sensor != sensor:
        raise FormatError(f"{index.folder} holds pairs of another {index.sensor.name}; use another folder")
    notes = []
    for number, count in enumerate(index.counts):
        with array_files.opened(_shard_path(index.folder, number)) as archive:
            notes += _read_notes(archive, count)
    return notes


def write_pairs(
    directory: str | os.PathLike[str], pairs: Iterable[NotedPair], *, source: str = "", start: int | None = None
) -> Iterator[int]:
    """Add pairs of one sensor, each with a note, to a folder; yields the number of pairs on disk after each shard.

    A note is any JSON value, such as the style of the coarse layout. `source` describes the origin of the pairs; a
    folder holds pairs of one source and sensor, else `FormatError`. `start` is the number of pairs that the folder must
    hold already: `FormatError` if another process has added some since they were counted. One process at a time can
    write to a folder; others get a `FormatError`.

    Shards hold `SHARD` pairs, the last one fewer. The index is written last, so an interruption leaves the folder as it
    was after the previous shard.
    """
    folder = Path(directory)
    folder.mkdir(parents=True, exist_ok=True)
    with locked_folder(folder):
        index = _index_of_source(folder, source)
        number = sum(index.counts) if index else 0
        if start is not None and start != number:
            raise FormatError(f"{folder} holds {number} pairs, no longer {start}: another process has added some")
        for left in folder.glob("*.partial"):  # by a process that was killed
            left.unlink()
        pairs = iter(pairs)
        while shard := list(itertools.islice(pairs, SHARD)):
            index = index or PairIndex(folder, shard[0][0].scan.sensor, source, [])
            for other in (image.sensor for pair, _ in shard for image in pair if image.sensor != index.sensor):
                raise FormatError(f"{folder} holds pairs of {index.sensor.name}; this one is of {other.name}")
            rows = [pair.compact() for pair, _ in shard]
            images = {name: np.stack([row[name] for row in rows]) for name in IMAGES}
            _write(_shard_path(folder, len(index.counts)), images, [note for _, note in shard])
            index.counts.append(len(rows))
            index.save()
            yield sum(index.counts)


def is_shard(path: str | os.PathLike[str]) -> bool:
    """Whether an .npz file is a shard of pairs, judged by its names of images; raises `FormatError`."""
    return set(IMAGES).issubset(array_files.names_in(path))


def read_shard(path: str | os.PathLike[str]) -> list[NotedPair]:
    """The pairs of one file of a folder, whose index names their sensor; raises `FormatError`."""
    shard = Path(path)
    index = PairIndex.load(shard.parent)
    names = [_shard_path(shard.parent, number).name for number in range(len(index.counts))]
    if shard.name not in names:
        raise FormatError(f"{shard} is not in the index.json beside it")
    images, notes = index.shard(names.index(shard.name))
    rows = ({name: rows[i] for name, rows in images.items()} for i in range(len(notes)))
    return [(Pair.from_compact(index.sensor, row), note) for row, note in zip(rows, notes, strict=True)]


def _index_of_source(folder: Path, source: str) -> PairIndex | None:
    """The index of a folder of pairs of that source; None if there is none yet."""
    if not (folder / "index.json").exists():
        return None
    index = PairIndex.load(folder)
    if index.source != source:
        raise FormatError(f"{folder} holds pairs of {index.source!r}, not of {source!r}; use another folder")
    return index


def _shard_path(folder: Path, number: int) -> Path:
    return folder / f"{number:05d}.npz"


def _compact_intensity(image: RangeImage) -> np.ndarray:
    intensity = np.zeros(image.sensor.shape) if image.intensity is None else image.intensity
    return np.rint(np.clip(intensity, 0, 1) * 255).astype(np.uint8)


def _compact_depth(image: RangeImage) -> np.ndarray:
    # the furthest that fits is beyond the range that a network distinguishes (`codec.MAX_DEPTH`)
    steps = np.minimum(np.rint(image.depth / DEPTH_STEP), 65535)
    return np.where(image.valid, np.maximum(steps, 1), 0).astype(np.uint16)


_COMPACT = {"depth": _compact_depth, "label": lambda image: image.label, "intensity": _compact_intensity}


def _write(path: Path, images: Images, notes: Notes) -> None:
    """Write an .npz file of the images and notes; images that gain from it are compressed."""
    with written_whole(path) as temporary, zipfile.ZipFile(temporary, "w", compresslevel=1) as archive:
        for name, image in images.items():
            archive.compression = zipfile.ZIP_DEFLATED if name in _COMPRESSED else zipfile.ZIP_STORED
            with archive.open(f"{name}.npy", "w", force_zip64=True) as file:
                np.lib.format.write_array(file, image, allow_pickle=False)
        archive.writestr(_NOTES, json.dumps(notes))


def _read_notes(archive: zipfile.ZipFile, count: int) -> Notes:
    with named(_NOTES):
        notes = [check_object(note) for note in parse_list(archive.read(_NOTES))]
    if len(notes) != count:
        raise FormatError(f"{len(notes)} notes on {count} pairs")
    return notes
