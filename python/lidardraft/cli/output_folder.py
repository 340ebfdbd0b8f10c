"""Folders that a command fills: nothing of somebody else's is mixed with what it writes."""

from __future__ import annotations

import re
from pathlib import Path

from lidardraft.errors import FormatError


def check_empty(folder: Path, otherwise: str, *, but: str = "") -> None:
    """Raises `FormatError` where the folder is a file or holds anything, but hidden files and what `but` matches.

    `otherwise` says what else the user can do.
    """
    if folder.exists() and not folder.is_dir():
        raise FormatError(f"{folder} is a file; it must be a folder")
    content = sorted(path.name for path in folder.glob("[!.]*") if not re.fullmatch(but, path.name))
    if content:
        more = f" and {len(content) - 1} more" if len(content) > 1 else ""
        raise FormatError(f"{folder} is not empty ({content[0]}{more}); use another folder{otherwise}")
