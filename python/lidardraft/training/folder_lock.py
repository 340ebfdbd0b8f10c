"""A lock on a folder that one process at a time may write to; the operating system ends it with the process."""

from __future__ import annotations

import os
import platform
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from lidardraft.errors import FormatError

if sys.platform == "win32":
    import msvcrt

    def _lock(file: int) -> None:
        os.lseek(file, 2**30, os.SEEK_SET)  # others may read what lies before: who holds the lock
        msvcrt.locking(file, msvcrt.LK_NBLCK, 1)

else:
    import fcntl

    def _lock(file: int) -> None:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)


@contextmanager
def locked_folder(folder: Path) -> Iterator[None]:
    """Hold the lock of an existing folder while the block runs; the file `.lock` stays in it.

    Raises `FormatError` naming the process that holds the lock.
    """
    path = folder / ".lock"
    # the system closes the file, and so ends the lock, when this process ends; processes started by it do not get it
    with path.open("a+") as file:
        try:
            _lock(file.fileno())
        except (BlockingIOError, PermissionError):
            holder = path.read_text().strip() or "another process"
            raise FormatError(
                f"{folder} is being written by {holder}; wait until it has ended, or use another folder"
            ) from None
        except OSError as error:
            raise FormatError(f"{folder} cannot be locked: {error.strerror}") from None
        file.truncate(0)
        file.write(f"process {os.getpid()} on {platform.node()}")
        file.flush()
        yield
