"""Shards of a format become one data set with the same files, and one copy of each list."""

from __future__ import annotations

import filecmp
import hashlib
import json
import os
import shutil
from collections.abc import Iterator, Sequence
from pathlib import Path

from lidardraft.errors import FormatError
from lidardraft.files import new_folder, written_whole

_ROWS = "data_list"  # of MMDetection3D's infos


def merge(shards: Sequence[Path], output: Path) -> None:
    """Link the files of the shards, or copy them on a disk without links, into the new folder `output`.

    Files of one name are joined: lines of texts, rows of tables and names of splits in order, and equal rows once.
    Raises `FormatError` if other files of one name differ, or if `output` exists already or cannot be written.
    """
    with new_folder(output) as folder:
        shared = dict[Path, list[Path]]()
        for shard in shards:
            for source in sorted(shard.rglob("*")):
                target = folder / source.relative_to(shard)
                if source.is_dir():
                    target.mkdir(exist_ok=True)
                elif target.exists() and source.suffix in (".json", ".txt"):
                    shared.setdefault(target, [target]).append(source)
                elif target.exists() and not filecmp.cmp(source, target, shallow=False):
                    raise FormatError(f"{source} is in another shard too, and another file there; use another folder")
                elif not target.exists():
                    try:
                        os.link(source, target)
                    except OSError:
                        shutil.copyfile(source, target)
        for target, sources in shared.items():
            with written_whole(target) as temporary, temporary.open("wb") as file:
                if target.name == "splits.json":
                    file.write(_joined(sources))
                else:
                    file.writelines(_rows(sources) if target.suffix == ".json" else map(Path.read_bytes, sources))


def _joined(sources: Sequence[Path]) -> bytes:
    """A JSON object of lists, each with the items of all sources."""
    whole = dict[str, list[str]]()
    for source in sources:
        for name, rows in json.loads(source.read_bytes()).items():
            whole.setdefault(name, []).extend(rows)
    return json.dumps(whole).encode()


def _rows(sources: Sequence[Path]) -> Iterator[bytes]:
    """A JSON list of all rows, or the first object with all rows in place of its rows."""
    first, seen = json.loads(sources[0].read_bytes()), set[bytes]()
    head = "" if isinstance(first, list) else json.dumps(first | {_ROWS: []})[: -len("[]}")]
    yield f"{head}[\n".encode()
    for source in sources:
        document = json.loads(source.read_bytes())
        for row in document if isinstance(document, list) else document[_ROWS]:
            text = json.dumps(row).encode()
            if (digest := hashlib.sha256(text).digest()) not in seen:
                yield b",\n" * bool(seen) + text
                seen.add(digest)
    yield b"\n]}" if head else b"\n]"
