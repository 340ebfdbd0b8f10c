"""Files that are written whole or not at all, and checks that a file can be read to its end."""

from __future__ import annotations

import os
import platform
import secrets
import shutil
import stat
import sys
import tempfile
from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import TypeVar

from lidardraft.errors import FormatError, LidarDraftError

if sys.platform == "win32":
    import msvcrt

    def _lock(file: int) -> None:
        os.lseek(file, 2**30, os.SEEK_SET)  # others may read the name of the holder before this byte
        msvcrt.locking(file, msvcrt.LK_NBLCK, 1)

else:
    import fcntl

    def _lock(file: int) -> None:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)


_Json = TypeVar("_Json", bound="JsonFile")
MAX_BYTES = 2**32  # larger than any weight file that fits into memory together with its network
MAX_WHOLE, MAX_TEXT = 2**27, 2**26  # of a file read at once, a scan or a model, and of a text file such as JSON
LOCK = ".lock"  # the file of a folder that its writer holds
_KINDS = {
    stat.S_IFDIR: "a directory",
    stat.S_IFIFO: "a FIFO",
    stat.S_IFSOCK: "a socket",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
}


@contextmanager
def written_whole(path: str | os.PathLike[str]) -> Iterator[Path]:
    """A temporary path beside `path`: renamed to it if the block succeeds, removed if it raises.

    Each writer gets its own. Raises `FormatError` if the file cannot be written.
    """
    target = Path(path)
    check_replaceable(target)
    temporary = target.with_name(f"{target.name}.{secrets.token_hex(4)}.partial")
    try:
        yield temporary
        temporary.replace(target)
    except OSError as error:
        raise FormatError(f"{target} cannot be written: {error.strerror or error}") from None
    finally:  # after the rename there is no such file
        with suppress(OSError):  # a read-only disk raises even for a missing file
            temporary.unlink()


@contextmanager
def written_together(name: str | os.PathLike[str], endings: Sequence[str] = ()) -> Iterator[str]:
    """The stem of temporary files that get the stem `name` if the block succeeds: all of them or none.

    A set of files that has the first of `endings` is replaced whole: its files that are not written again are removed.
    Raises `FormatError` if one cannot be written; the earlier files then stay unchanged.
    """
    target = Path(name)
    try:
        with tempfile.TemporaryDirectory(prefix=f".{target.name}.", dir=target.parent) as folder:
            new, old = Path(folder, "new"), Path(folder, "old")
            new.mkdir()
            old.mkdir()
            try:
                yield f"{new}/{target.name}"
            except FormatError as error:  # it names a temporary file
                raise FormatError(str(error).replace(str(new), str(target.parent))) from None
            _replace_all(new, old, target.parent, [f"{target.name}{ending}" for ending in endings])
    except OSError as error:
        raise FormatError(f"{target} cannot be written: {error.strerror or error}") from None


@contextmanager
def new_folder(path: str | os.PathLike[str]) -> Iterator[Path]:
    """A hidden temporary folder beside `path`: renamed to it if the block succeeds, removed if it raises.

    Raises `FormatError` if `path` exists and is not an empty folder, or if something cannot be written.
    """
    target = Path(os.path.abspath(path))
    temporary = target.with_name(f".{target.name}.{secrets.token_hex(4)}.partial")
    try:
        if os.path.lexists(target) and (not target.is_dir() or any(target.iterdir())):
            raise FormatError(f"{path} exists already; write to a new or empty folder")
        target.parent.mkdir(parents=True, exist_ok=True)
        temporary.mkdir()
        yield temporary
        temporary.replace(target)  # fails if another process has filled the folder meanwhile
    except OSError as error:
        raise FormatError(f"{path} cannot be written: {error.strerror or error}") from None
    except FormatError as error:  # it may name a temporary file
        raise FormatError(str(error).replace(str(temporary), os.fspath(path))) from None
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


def _replace_all(new: Path, old: Path, folder: Path, earlier: Sequence[str]) -> None:
    """Move the files of `new` to `folder`, and the files that they replace to `old`. If the first of the `earlier`
    files exists, move all of those to `old` too. If a move fails, undo all."""
    written = {path.name for path in new.iterdir()}
    names = sorted(written.union(earlier if earlier and os.path.lexists(folder / earlier[0]) else ()))
    for name in names:
        check_replaceable(folder / name)
    try:
        for name in names:
            if os.path.lexists(folder / name):
                (folder / name).replace(old / name)
            if name in written:
                (new / name).replace(folder / name)
    except BaseException:
        for name in names:
            if os.path.lexists(old / name):
                (old / name).replace(folder / name)
            elif not os.path.lexists(new / name):
                (folder / name).unlink(missing_ok=True)
        raise


def check_replaceable(target: Path) -> None:
    """Raise `FormatError` if the target exists and is not a regular file: a rename would replace a device."""
    if "\0" in str(target):
        raise FormatError(f"{target} cannot be written: invalid file name")
    if target.exists() and not target.is_file():
        raise FormatError(f"{target} cannot be written: it exists and is not a regular file")


def check_other_file(output: str | os.PathLike[str], given: str | os.PathLike[str]) -> None:
    """Raise `FormatError` if the output would replace its own input."""
    try:
        is_same = os.path.samefile(output, given)
    except (OSError, ValueError):  # one of them does not exist
        return
    if is_same:
        raise FormatError(f"{os.fspath(output)} is the input too; write to another file")


def write_text(path: str | os.PathLike[str], text: str) -> None:
    """Write a text in UTF-8; raises `FormatError` if it cannot be written or is larger than `read_text` accepts."""
    content = text.encode("utf-8")
    if len(content) > MAX_TEXT:
        raise FormatError(f"{os.fspath(path)} would have {len(content)} bytes; such files of up to {MAX_TEXT} are read")
    with written_whole(path) as temporary:
        temporary.write_bytes(content)


def regular_size(path: str | os.PathLike[str], most: int = MAX_BYTES) -> int:
    """The number of bytes of a file, links followed.

    Raises `FormatError` if it is missing, is not a regular file (a FIFO or a device may never end) or has more than
    `most` bytes.
    """
    name = os.fspath(path) or "''"
    try:
        status = os.stat(path)
    except OSError as error:
        raise FormatError(f"{name}: {error.strerror}") from None
    except ValueError as error:  # an invalid file name
        raise FormatError(f"{name}: {error}") from None
    if not stat.S_ISREG(status.st_mode):
        kind = _KINDS.get(stat.S_IFMT(status.st_mode), "something else")
        raise FormatError(f"{name} is {kind}; it must be a regular file")
    if status.st_size > most:
        raise FormatError(f"{name} has {status.st_size} bytes; such files of up to {most} are read")
    return status.st_size


def read_bytes(path: str | os.PathLike[str], most: int = MAX_WHOLE) -> bytes:
    """The content of a regular file of up to `most` bytes; raises `FormatError` naming it."""
    size = regular_size(path, most)
    try:
        with open(path, "rb") as file:
            return file.read(size)
    except OSError as error:
        raise FormatError(f"{os.fspath(path)}: {error.strerror}") from None


def read_text(path: str | os.PathLike[str], most: int = MAX_TEXT) -> str:
    """The content of a regular file of up to `most` bytes in UTF-8; raises `FormatError` naming it."""
    try:
        return read_bytes(path, most).decode("utf-8")
    except UnicodeDecodeError as error:
        raise FormatError(f"{os.fspath(path)} is not text in UTF-8: byte {error.start} is wrong") from None


def read_sentences(path: str | os.PathLike[str]) -> dict[int, str]:
    """The sentences of a file by line number; a line holds one or none. Raises `FormatError` if there are none at
    all."""
    lines = enumerate(map(str.strip, read_text(path).splitlines()), start=1)
    if not (sentences := {number: line for number, line in lines if line}):
        raise FormatError(f"{os.fspath(path)} holds no sentence; it must hold one a line")
    return sentences


class JsonFile(ABC):
    """A value with a JSON text, in files."""

    __slots__ = ()

    @abstractmethod
    def to_json(self) -> str:
        """The value as JSON text."""

    @classmethod
    @abstractmethod
    def from_json(cls: type[_Json], text: str) -> _Json:
        """The inverse of `to_json`."""

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the JSON of `to_json`; raises `FormatError` if the file cannot be written."""
        write_text(path, self.to_json())

    @classmethod
    def load(cls: type[_Json], path: str | os.PathLike[str]) -> _Json:
        """The value in a JSON file, as in `from_json`; errors name the file."""
        text = read_text(path)
        with named(path):
            return cls.from_json(text)


@contextmanager
def named(name: str | os.PathLike[str]) -> Iterator[None]:
    """Prefix errors of the block with the name of the file, or of the part of it, that they are about."""
    try:
        yield
    except LidarDraftError as error:
        raise type(error)(f"{os.fspath(name)}: {error}") from None


@contextmanager
def expecting(what: str) -> Iterator[None]:
    """Turn whatever a library raises in the block, on a foreign file, into one `FormatError`: not `what`."""
    try:
        yield
    except LidarDraftError:
        raise
    except MemoryError:
        raise FormatError(f"not {what}: it asks for more memory than there is") from None
    except Exception as error:  # parsers raise anything, a lack of depth too
        lines = filter(str.strip, str(error).splitlines())
        said = getattr(error, "strerror", None) or next(lines, type(error).__name__)
        raise FormatError(f"not {what}: {said.strip():.200}") from None


@contextmanager
def locked_folder(folder: Path, lock: str = LOCK) -> Iterator[None]:
    """Hold a lock of an existing folder while the block runs: a file of that name, removed at the end.

    Raises `FormatError` naming the process that holds the lock.
    """
    path = folder / lock
    with ExitStack() as opened:
        while True:
            # the system closes the file, and so ends the lock, when this process ends; its child processes do not hold
            # it
            file = opened.enter_context(path.open("a+"))
            try:
                _lock(file.fileno())
            except (BlockingIOError, PermissionError):
                file.seek(0)
                held = f"{folder} is being written by {file.read().strip() or 'another process'}"
                raise FormatError(f"{held}; wait for it, or use another folder") from None
            except OSError as error:
                raise FormatError(f"{folder} cannot be locked: {error.strerror}") from None
            with suppress(FileNotFoundError):
                if os.path.samestat(os.fstat(file.fileno()), os.stat(path)):
                    break  # and the last holder has not removed it since it was opened
        file.truncate(0)
        file.write(f"process {os.getpid()} on {platform.node()}")
        file.flush()
        try:
            yield
        finally:
            with suppress(OSError):  # Windows keeps open files
                path.unlink()
