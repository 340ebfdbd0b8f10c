"""What a weight file says of itself: read without torch, which takes a second to load."""

from __future__ import annotations

import os

from safetensors import SafetensorError, safe_open

from lidardraft.errors import CheckpointError, FormatError
from lidardraft.files import regular_size


def read_metadata(path: str | os.PathLike[str]) -> dict[str, str]:
    """The metadata of a safetensors file; raises `CheckpointError` where it is no whole one."""
    try:
        regular_size(path)
        with safe_open(path, framework="np") as file:
            return file.metadata() or {}
    except FormatError as error:
        raise CheckpointError(str(error)) from None
    except (SafetensorError, OSError) as error:
        raise CheckpointError(f"{os.fspath(path)} is no whole safetensors file: {error}") from None
