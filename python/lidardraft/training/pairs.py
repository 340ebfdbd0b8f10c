"""Prepared pairs: a folder of shards with scans, condition images and simulated scans of the same places, compact,
whole or absent."""

from __future__ import annotations

import itertools
import json
import math
import os
import zipfile
import zlib
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from lidardraft.errors import FormatError
from lidardraft.files import named, read_text, write_text, written_whole
from lidardraft.json_fields import check_fields, check_object, parse_list, parse_object
from lidardraft.scene import image_archive
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.sensor import Sensor
from lidardraft.semantics import CLASSES
from lidardraft.training.folder_lock import locked_folder
from lidardraft.training.free_memory import check_memory
from lidardraft.training.processes import ALONE, Processes

SCHEMA = "lidardraft.pairs/4"
SHARD = 64  # pairs a file
_LARGEST_SHARD = 2**16  # pairs that an index may claim
_STEP = 0.002  # m, what a depth of 1 in the uint16 images stands for: up to 131 m, what is further is 131 m
_IMAGES = {
    "scan_depth": np.uint16,
    "scan_label": np.uint8,
    "scan_intensity": np.uint8,
    "condition_depth": np.uint16,
    "condition_label": np.uint8,
    "simulated_depth": np.uint16,
    "simulated_intensity": np.uint8,
}

_PIXELS = 64 * 1024  # of the images that memory is counted in
_PAIR_BYTES = sum(np.dtype(dtype).itemsize for dtype in _IMAGES.values())  # a pixel
_NOTES = "notes.json"
_CLASSES = [row.name for row in CLASSES]
# Noise does not get smaller: a scan's ranges and intensities are stored as they are.
_COMPRESSED = ("scan_label", "condition_depth", "condition_label")


class Pair(NamedTuple):
    """A scan, and what a layout of the same place says: its condition image and its simulated scan."""

    scan: RangeImage
    condition_image: RangeImage
    simulated: RangeImage


NotedPair = tuple[Pair, dict[str, Any]]


def pairs_on_disk(directory: str | os.PathLike[str], *, source: str = "") -> int:
    """How many pairs a folder holds: 0 where there is no index. A seeded source goes on from here.

    Raises `FormatError` where they came from another `source`.
    """
    index = Path(directory) / "index.json"
    return sum(_of_source(Path(directory), _read_index(index), source)["shards"]) if index.exists() else 0


def notes_on_disk(directory: str | os.PathLike[str], sensor: Sensor, *, source: str = "") -> list[dict[str, Any]]:
    """What was noted of each pair that a folder holds; nothing where there is no index.

    Raises `FormatError` where they came from another `source` or are of another sensor.
    """
    folder = Path(directory)
    if not (folder / "index.json").exists():
        return []
    index = _of_source(folder, _read_index(folder / "index.json"), source)
    if _sensor(folder, index) != sensor:
        raise FormatError(f"{folder} holds pairs of another {index['sensor']['name']}; use another folder")
    notes = []
    for number, count in enumerate(index["shards"]):
        with image_archive.opened(folder / f"{number:05d}.npz") as archive:
            notes += _read_notes(archive, count)
    return notes


def write_pairs(
    directory: str | os.PathLike[str], pairs: Iterable[NotedPair], *, source: str = "", start: int | None = None
) -> Iterator[int]:
    """Add pairs of one sensor, each with a note, to a folder, yielding the number of pairs on disk after each
    shard.

    A note holds what JSON can, such as the style of the coarse layout.
    `source` says in words where the pairs come from; a folder holds those of one source and sensor, else `FormatError`.
    `start` is how many pairs the folder must hold already: `FormatError` where another process has added some since
    they were counted. One process at a time can write to a folder, the others get a `FormatError`.
    Shards hold `SHARD` pairs, the last one fewer. The index is written last: what is interrupted leaves the folder as
    it was after the shard before.
    """
    folder = Path(directory)
    folder.mkdir(parents=True, exist_ok=True)
    with locked_folder(folder):
        there = (folder / "index.json").exists()
        index = _of_source(folder, _read_index(folder / "index.json"), source) if there else None
        counts: list[int] = index["shards"] if index else []
        if start is not None and start != sum(counts):
            raise FormatError(f"{folder} holds {sum(counts)} pairs, no longer {start}: another process has added some")
        for left in folder.glob("*.partial"):  # by a process that was killed
            left.unlink()
        sensor = _sensor(folder, index) if index else None
        for shard in _shards(pairs):
            for pair, _ in shard:
                sensor = sensor or pair.scan.sensor
                for image in pair:
                    if image.sensor != sensor:
                        raise FormatError(f"{folder} holds pairs of {sensor.name}; this one is of {image.sensor.name}")
            rows = [_compact(pair) for pair, _ in shard]
            images = {name: np.stack([row[name] for row in rows]) for name in _IMAGES}
            _write(folder / f"{len(counts):05d}.npz", images, [note for _, note in shard])
            counts.append(len(rows))
            _write_index(folder / "index.json", sensor, counts, source)
            yield sum(counts)


class PairFolder:
    """The pairs of a prepared folder, held in memory: 0.66 MB for each pair of 64 x 1024.

    `folder[i]` is a `Pair` with depth to the millimetre and intensity; instances, and labels of the simulated scan, are
    not kept. `notes[i]` is what was noted of it, `checksum` that of all images. Raises `FormatError`
    naming the file that is missing, truncated or not ours.
    """

    def __init__(self, directory: str | os.PathLike[str]) -> None:
        folder = Path(directory)
        index = _read_index(folder / "index.json")
        self.sensor = _sensor(folder, index)
        self.path = folder.resolve()
        self.source: str = index["source"]
        self.checksum = zlib.crc32(self.sensor.to_json().encode())
        counts = index["shards"]
        check_memory(f"{folder} with its {sum(counts)} pairs", sum(counts) * math.prod(self.sensor.shape) * _PAIR_BYTES)
        self._images = {name: np.empty((sum(counts), *self.sensor.shape), dtype) for name, dtype in _IMAGES.items()}
        self.notes: list[dict[str, Any]] = []
        start = 0
        for number, count in enumerate(counts):
            shard, notes = _read(folder / f"{number:05d}.npz", (count, *self.sensor.shape))
            self.notes += notes
            for name, images in shard.items():
                self._images[name][start : start + count] = images
                self.checksum = zlib.crc32(images.tobytes(), self.checksum)
            start += count

    def __len__(self) -> int:
        return len(self._images["scan_depth"])

    @property
    def sensors(self) -> tuple[Sensor, ...]:
        """The one of all pairs."""
        return (self.sensor,)

    def pairs(self, step: int, scans: int, processes: Processes = ALONE) -> list[Pair]:
        """Pairs drawn at random, as many as `scans` of 64 x 1024 are worth: the same for a step; of several processes,
        this one's."""
        drawn = np.random.default_rng([self.checksum, step]).integers(len(self), size=scans_of_step(scans, self.sensor))
        return [self[int(drawn[number])] for number in processes.share(len(drawn))]

    def __getitem__(self, i: int) -> Pair:
        return _pair(self.sensor, {name: images[i] for name, images in self._images.items()})


def scans_of_step(scans: int, sensor: Sensor) -> int:
    """How many scans of a sensor a step learns from that has room for so many of 64 x 1024."""
    return max(1, min(scans, scans * _PIXELS // math.prod(sensor.shape)))


def is_shard(path: str | os.PathLike[str]) -> bool:
    """Whether an .npz file is a shard of pairs, as far as its names of images tell; raises `FormatError`."""
    with image_archive.opened(path) as archive:
        return all(image_archive.holds(archive, name) for name in _IMAGES)


def read_shard(path: str | os.PathLike[str]) -> list[NotedPair]:
    """The pairs of one file of a folder, whose index says their sensor; raises `FormatError`."""
    shard = Path(path)
    index = _read_index(shard.parent / "index.json")
    sensor = _sensor(shard.parent, index)
    counts = {f"{number:05d}.npz": count for number, count in enumerate(index["shards"])}
    if shard.name not in counts:
        raise FormatError(f"{shard} is not in the index.json beside it")
    images, notes = _read(shard, (counts[shard.name], *sensor.shape))
    return [(_pair(sensor, {name: rows[i] for name, rows in images.items()}), note) for i, note in enumerate(notes)]


def _pair(sensor: Sensor, image: dict[str, np.ndarray]) -> Pair:
    none = np.zeros(sensor.shape, dtype=np.uint32)

    def image_of(name: str) -> RangeImage:
        intensity = image.get(f"{name}_intensity")
        return RangeImage(
            sensor=sensor,
            depth=image[f"{name}_depth"] * np.float32(_STEP),
            label=image.get(f"{name}_label", none.astype(np.uint8)),
            instance=none,
            intensity=None if intensity is None else intensity * np.float32(1 / 255),
        )

    return Pair(image_of("scan"), image_of("condition"), image_of("simulated"))


def _shards(pairs: Iterable[NotedPair]) -> Iterator[list[NotedPair]]:
    pairs = iter(pairs)
    while shard := list(itertools.islice(pairs, SHARD)):
        yield shard


def _compact(pair: Pair) -> dict[str, np.ndarray]:
    return {
        "scan_depth": _compact_depth(pair.scan),
        "scan_label": pair.scan.label,
        "scan_intensity": _compact_intensity(pair.scan),
        "condition_depth": _compact_depth(pair.condition_image),
        "condition_label": pair.condition_image.label,
        "simulated_depth": _compact_depth(pair.simulated),
        "simulated_intensity": _compact_intensity(pair.simulated),
    }


def _compact_intensity(image: RangeImage) -> np.ndarray:
    intensity = np.zeros(image.sensor.shape) if image.intensity is None else image.intensity
    return np.rint(np.clip(intensity, 0, 1) * 255).astype(np.uint8)


def _compact_depth(image: RangeImage) -> np.ndarray:
    # the furthest that fits is beyond what a network tells apart (`codec.MAX_DEPTH`)
    steps = np.minimum(np.rint(image.depth / _STEP), 65535)
    return np.where(image.valid, np.maximum(steps, 1), 0).astype(np.uint16)


def _write(path: Path, images: dict[str, np.ndarray], notes: list[dict[str, Any]]) -> None:
    """An .npz file with the images that are worth it compressed, and the notes."""
    with written_whole(path) as temporary, zipfile.ZipFile(temporary, "w", compresslevel=1) as archive:
        for name, image in images.items():
            archive.compression = zipfile.ZIP_DEFLATED if name in _COMPRESSED else zipfile.ZIP_STORED
            with archive.open(f"{name}.npy", "w", force_zip64=True) as file:
                np.lib.format.write_array(file, image, allow_pickle=False)
        archive.writestr(_NOTES, json.dumps(notes))


def _of_source(folder: Path, index: dict[str, Any], source: str) -> dict[str, Any]:
    if index["source"] != source:
        raise FormatError(f"{folder} holds pairs of {index['source']!r}, not of {source!r}; use another folder")
    return index


def _write_index(path: Path, sensor: Sensor | None, counts: list[int], source: str) -> None:
    fields = json.loads(sensor.to_json()) if sensor else None
    index = {"schema": SCHEMA, "source": source, "classes": _CLASSES, "sensor": fields, "shards": counts}
    write_text(path, json.dumps(index))


def _read_index(path: Path) -> dict[str, Any]:
    text = read_text(path)
    with named(path):
        index = parse_object(text)
        if index.get("schema") != SCHEMA:
            raise FormatError(f"schema is {index.get('schema')!r}; this version reads {SCHEMA!r}")
        check_fields(index, ("schema", "classes", "sensor", "shards"), ("source",))
        if index["classes"] != _CLASSES:
            raise FormatError(f"the pairs have another class table than this version: {index['classes']!r:.60}")
        counts = index["shards"]
        if not isinstance(counts, list) or not all(type(c) is int and 0 < c <= _LARGEST_SHARD for c in counts):
            raise FormatError(f"shards is {counts!r}; it must be counts of 1 to {_LARGEST_SHARD} pairs")
        index["source"] = str(index.get("source", ""))
    return index


def _sensor(folder: Path, index: dict[str, Any]) -> Sensor:
    with named(folder / "index.json"):
        return Sensor.from_json(json.dumps(index["sensor"]))


def _read(path: Path, shape: tuple[int, ...]) -> tuple[dict[str, np.ndarray], list[dict[str, Any]]]:
    with image_archive.opened(path) as archive:
        images = {
            name: image_archive.read_array(archive, name, np.dtype(dtype), shape) for name, dtype in _IMAGES.items()
        }
        return images, _read_notes(archive, shape[0])


def _read_notes(archive: zipfile.ZipFile, count: int) -> list[dict[str, Any]]:
    with named(_NOTES):
        notes = [check_object(note) for note in parse_list(archive.read(_NOTES))]
    if len(notes) != count:
        raise FormatError(f"{len(notes)} notes on {count} pairs")
    return notes
