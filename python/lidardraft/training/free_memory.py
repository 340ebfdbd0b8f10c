"""Whether what is asked for fits into memory: a process that takes more is killed, without a word."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from lidardraft.errors import TrainingError

_MEMINFO = Path("/proc/meminfo")  # of Linux; other systems say it elsewhere, and are not asked


def check_memory(what: str, needed: int) -> None:
    """Raise `TrainingError` where `what` needs more bytes than are free."""
    free = free_memory()
    if free is not None and needed > free:
        raise TrainingError(f"{what} needs {needed / 1e9:.1f} GB of memory; {free / 1e9:.1f} GB are free")


@contextmanager
def memory_of(what: str) -> Iterator[None]:
    """Raise `TrainingError` where the block asks for more memory than there is, on whatever device."""
    try:
        yield
    except (MemoryError, RuntimeError) as error:  # torch raises RuntimeErrors, of one kind for a GPU alone
        text = str(error).splitlines()[0] if str(error) else ""
        if isinstance(error, MemoryError) or "out of memory" in text or "t allocate memory" in text:
            raise TrainingError(f"{what} needs more memory than there is; use a smaller --batch ({text})") from None
        raise


def free_memory() -> int | None:
    """Bytes that can be had without swapping; None where the system does not say."""
    try:
        lines = _MEMINFO.read_text().splitlines()
    except OSError:
        return None
    found = [line.split()[1] for line in lines if line.startswith("MemAvailable:")]
    return 1024 * int(found[0]) if found else None
