"""WebDataset shards: .tar files of samples, the files of each side by side under its name.

`NAME.points.npy` f32 [N, 4] (x y z intensity), `NAME.ring.npy` u16 [N], `NAME.label.npy` u8 [N], `NAME.instance.npy`
u32 [N], for raw points `NAME.time.npy` f32 [N], and `NAME.json`: sensor, pose, boxes as in boxes.json, and the
provenance, the intent and the notes of the layout. `index.json` counts the samples of each shard.
"""

from __future__ import annotations

import io
import itertools
import json
import tarfile
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np

from lidardraft.files import written_whole
from lidardraft.formats.boxes import fields_of
from lidardraft.formats.frame import Drives, Frame, npy, numbered

SHARD = 256  # frames of a shard


def write_webdataset(folder: Path, drives: Drives, first: int) -> None:
    """Write 000000.tar, 000001.tar, ... and index.json."""
    frames, counts = iter(numbered(drives, first)), dict[str, int]()
    while head := next(frames, None):
        shard = f"{len(counts):06d}.tar"
        counts[shard] = write_shard(folder / shard, itertools.chain([head], itertools.islice(frames, SHARD - 1)))
    (folder / "index.json").write_text(json.dumps(counts))


def write_shard(path: Path, frames: Iterable[tuple[str, Frame]]) -> int:
    """Write named frames into one .tar file, whole or not at all; returns their number."""
    count = 0
    with written_whole(path) as temporary, tarfile.open(temporary, "w") as tar:
        for name, frame in frames:
            count += 1
            for ending, content in _files(frame):
                member = tarfile.TarInfo(f"{name}.{ending}")
                member.size = len(content)
                tar.addfile(member, io.BytesIO(content))
    return count


def _files(frame: Frame) -> Iterator[tuple[str, bytes]]:
    yield "points.npy", npy(np.column_stack([frame.points, frame.intensity]))
    for field, values in frame.fields().items():
        yield f"{field}.npy", npy(values)
    boxes = [fields_of(a.box) | {"num_points": a.num_points} for a in frame.annotations]
    sensor = json.loads(frame.sensor.to_json())
    said = {"boxes": boxes, "pose": frame.pose.tolist(), "sensor": sensor}
    said |= {"split": frame.split} if frame.split else {}
    yield "json", json.dumps(said | json.loads(frame.world or "{}")).encode()
