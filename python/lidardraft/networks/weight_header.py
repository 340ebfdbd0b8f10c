"""The place of a weight file, and its metadata: without torch, which takes a second to load."""

from __future__ import annotations

import os
from pathlib import Path

from safetensors import SafetensorError, safe_open

from lidardraft.errors import CheckpointError, FormatError, one_of
from lidardraft.files import regular_size

PACKAGED = Path(__file__).parents[1] / "weights"


def find(name: str | os.PathLike[str]) -> Path:
    """The packaged weights of that name, or the weight file at that path; raises `CheckpointError`."""
    packaged = PACKAGED / f"{os.fspath(name)}.safetensors"
    path = packaged if packaged.exists() else Path(name)
    if not path.exists():
        known = one_of(sorted(file.stem for file in PACKAGED.glob("*.safetensors")), os.fspath(name))
        raise CheckpointError(f"weights are {os.fspath(name)!r}; they must be a file or {known}")
    return path


def read_metadata(path: str | os.PathLike[str]) -> dict[str, str]:
    """The metadata of a safetensors file; raises `CheckpointError` if it is not a complete one."""
    try:
        regular_size(path)
        with safe_open(path, framework="np") as file:
            return file.metadata() or {}
    except FormatError as error:
        raise CheckpointError(str(error)) from None
    except (SafetensorError, OSError) as error:
        raise CheckpointError(f"{os.fspath(path)} is not a complete safetensors file: {error}") from None
