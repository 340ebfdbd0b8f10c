import errno
import itertools
import os
import socket
import stat
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from lidardraft import files
from lidardraft.errors import FormatError, LayoutError
from lidardraft.files import (
    expecting,
    locked_folder,
    named,
    read_bytes,
    read_text,
    regular_size,
    write_text,
    written_together,
    written_whole,
)


def test_a_failure_keeps_what_was_there(tmp_path: Path) -> None:
    (tmp_path / "a.txt").write_text("old")

    def write_half() -> None:
        with written_whole(tmp_path / "a.txt") as temporary:
            temporary.write_text("half")
            raise KeyError

    with pytest.raises(KeyError):
        write_half()
    assert [file.name for file in tmp_path.iterdir()] == ["a.txt"]
    assert (tmp_path / "a.txt").read_text() == "old"


@pytest.mark.parametrize("failing", range(6))  # two files move out of the way, four come
def test_files_are_written_together_or_not_at_all(
    tmp_path: Path, failing: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = {"scan.bin": "old points", "scan.png": "old picture"}
    for name, text in before.items():
        (tmp_path / name).write_text(text)
    rename, calls = Path.replace, itertools.count()

    def replace(path: Path, target: Path) -> Path:
        if next(calls) == failing:
            raise OSError(errno.EIO, "Input/output error")
        return rename(path, target)

    def write() -> None:
        with written_together(tmp_path / "scan") as stem:
            for ending in ("bin", "label", "json", "png"):
                Path(f"{stem}.{ending}").write_text("new")

    with monkeypatch.context() as patch:
        patch.setattr(Path, "replace", replace)
        with pytest.raises(FormatError, match="scan cannot be written: Input/output error"):
            write()
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == before
    write()
    assert {path.name for path in tmp_path.iterdir()} == {"scan.bin", "scan.label", "scan.json", "scan.png"}
    assert {path.read_text() for path in tmp_path.iterdir()} == {"new"}


def test_a_reader_beside_many_writers_finds_one_of_them_whole(tmp_path: Path) -> None:
    path, failures = tmp_path / "a.txt", []
    path.write_text("0" * 5000)

    def write(letter: str) -> None:
        try:
            for _ in range(50):
                with written_whole(path) as temporary:
                    temporary.write_text(letter * 5000)
        except FormatError as error:
            failures.append(error)

    writers = [threading.Thread(target=write, args=[letter]) for letter in "abcd"]
    for writer in writers:
        writer.start()
    while any(writer.is_alive() for writer in writers):
        text = path.read_text()
        assert text == text[0] * 5000
    assert not failures
    assert list(tmp_path.iterdir()) == [path]


def test_a_written_file_has_the_mode_of_any_other(tmp_path: Path) -> None:
    (tmp_path / "usual.txt").write_text("")
    with written_whole(tmp_path / "a.txt") as temporary:
        temporary.write_text("")
        assert temporary.parent == tmp_path  # on the same disk
    modes = [stat.S_IMODE((tmp_path / name).stat().st_mode) for name in ("usual.txt", "a.txt")]
    assert modes[0] == modes[1]


def test_a_path_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    said = r"a.txt cannot be written: No such file or directory"
    with pytest.raises(FormatError, match=said), written_whole(tmp_path / "nowhere" / "a.txt") as temporary:
        temporary.write_text("")


def test_a_device_is_not_replaced_by_a_file(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "null").symlink_to("/dev/null")
    for name in ("pipe", "null"):
        said = rf"{name} cannot be written: it exists and is not a regular file"
        with pytest.raises(FormatError, match=said), written_whole(tmp_path / name) as temporary:
            temporary.write_text("")
    assert not (tmp_path / "pipe").is_file()


def test_a_regular_file_is_read_also_through_a_link(tmp_path: Path) -> None:
    (tmp_path / "a.txt").write_bytes("café".encode())
    (tmp_path / "link").symlink_to("a.txt")
    assert regular_size(tmp_path / "link") == 5
    assert read_bytes(tmp_path / "link") == "café".encode()
    assert read_text(tmp_path / "link") == "café"


def test_what_is_no_regular_file_is_refused_at_once(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "link").symlink_to("/dev/null")
    with socket.socket(socket.AF_UNIX) as server:
        server.bind(os.path.relpath(tmp_path / "socket"))  # the name of a socket must be short
    for name, kind in (("pipe", "a FIFO"), ("link", "a device"), ("socket", "a socket"), (".", "a directory")):
        with pytest.raises(FormatError, match=rf"is {kind}; it must be a regular file"):
            read_bytes(tmp_path / name)


def test_a_missing_file_and_an_impossible_name_are_named(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match=r"none.txt: No such file or directory"):
        read_bytes(tmp_path / "none.txt")
    with pytest.raises(FormatError, match=r"a\\x00b: embedded null"):
        read_bytes("a\0b")


def test_a_file_that_does_not_fit_into_memory_is_refused(tmp_path: Path) -> None:
    with (tmp_path / "large").open("wb") as file:
        file.truncate(files.MAX_BYTES + 1)  # a hole: it takes no room
    with pytest.raises(
        FormatError, match=rf"large has {files.MAX_BYTES + 1} bytes; such files of up to {files.MAX_BYTES}"
    ):
        regular_size(tmp_path / "large")
    for read, limit in ((read_bytes, files.MAX_WHOLE), (read_text, files.MAX_TEXT)):
        os.truncate(tmp_path / "large", limit + 1)
        with pytest.raises(FormatError, match=rf"large has {limit + 1} bytes; such files of up to {limit} are read"):
            read(tmp_path / "large")


def test_a_text_is_written_where_it_can_be_read(tmp_path: Path) -> None:
    write_text(tmp_path / "a.txt", "é")
    assert read_text(tmp_path / "a.txt") == "é"
    with pytest.raises(FormatError, match=rf"a.txt would have {files.MAX_TEXT + 1} bytes; such files of up to"):
        write_text(tmp_path / "a.txt", "é" * (files.MAX_TEXT // 2) + "e")
    assert read_text(tmp_path / "a.txt") == "é"
    assert len(list(tmp_path.iterdir())) == 1


HOLD = """
import sys
from pathlib import Path
from lidardraft.files import expecting, locked_folder
with locked_folder(Path(sys.argv[1])):
    print("held", flush=True)
    sys.stdin.read()
"""


def test_a_lock_names_who_holds_it_and_ends_with_the_block(tmp_path: Path) -> None:
    with (
        locked_folder(tmp_path),
        pytest.raises(FormatError, match=f"is being written by process {os.getpid()} on "),
        locked_folder(tmp_path),
    ):
        pass
    with locked_folder(tmp_path):
        pass


def test_a_lock_ends_with_a_process_that_is_killed(tmp_path: Path) -> None:
    command = [sys.executable, "-c", HOLD, str(tmp_path)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == "held\n"
        with pytest.raises(FormatError, match=f"process {other.pid} on "), locked_folder(tmp_path):
            pass
        other.kill()
        other.wait()
        with locked_folder(tmp_path):
            pass


def test_a_lock_that_is_removed_while_it_is_waited_for_is_taken_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Else two writers would hold a lock each, of which only one has a name."""
    lock, taken = files._lock, list[int]()

    def after_its_holder(file: int) -> None:
        if not taken:
            (tmp_path / files.LOCK).unlink()
        taken.append(file)
        lock(file)

    monkeypatch.setattr(files, "_lock", after_its_holder)
    with locked_folder(tmp_path):
        assert len(taken) == 2
        with pytest.raises(FormatError, match="is being written by"), locked_folder(tmp_path):
            pass
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (ValueError("\nno magic number\nat all"), "a.dat: not a whole file: no magic number"),
        (OSError(5, "Input/output error"), "a.dat: not a whole file: Input/output error"),
        (MemoryError(), "a.dat: not a whole file: it asks for more memory than there is"),
        (RecursionError("too deep"), "a.dat: not a whole file: too deep"),
        (LayoutError("x is 1"), "a.dat: x is 1"),
    ],
)
def test_what_a_library_raises_becomes_one_line(error: Exception, said: str) -> None:
    kind = FormatError if said.startswith("a.dat: not") else LayoutError
    with pytest.raises(kind) as raised, named("a.dat"), expecting("a whole file"):
        raise error
    assert str(raised.value) == said
