from collections.abc import Callable
from pathlib import Path

import pytest

from lidardraft.errors import LidarDraftError
from spoiled_files import odd_paths, outcome, readers, special_files, spoilings

READERS = readers()
LARGEST = 2**21  # bytes of a file that a test writes; `python benches/spoiled_files.py` reads the larger ones too
SPECIAL = [(reader, name, data) for reader, name, data in special_files() if len(data) <= LARGEST]

NAMES = [f"{reader}-{name}" for reader, name, _ in SPECIAL]


def read_or_named(read: Callable[[Path], object], path: Path) -> None:
    said = path.name
    try:
        read(path)
    except LidarDraftError as error:
        said = str(error)
    assert path.name in said
    assert said.isprintable()


@pytest.mark.parametrize("name", READERS)
def test_a_good_file_is_read(tmp_path: Path, name: str) -> None:
    path = tmp_path / f"good{READERS[name].ending}"
    path.write_bytes(READERS[name].good)
    READERS[name].read(path)


@pytest.mark.parametrize("name", READERS)
def test_a_spoiled_file_is_read_or_ends_in_one_line_that_names_it(tmp_path: Path, name: str) -> None:
    path = tmp_path / f"spoiled{READERS[name].ending}"
    for _, data in spoilings(READERS[name]):
        if len(data) <= LARGEST:
            path.write_bytes(data)
            read_or_named(READERS[name].read, path)


@pytest.mark.parametrize("name", READERS)
def test_what_is_no_file_that_can_be_read_ends_in_one_line(tmp_path: Path, name: str) -> None:
    for _, path in odd_paths(tmp_path, READERS[name].ending):
        with pytest.raises(LidarDraftError, match=path.stem):
            READERS[name].read(path)


@pytest.mark.parametrize(("reader", "data"), [(reader, data) for reader, _, data in SPECIAL], ids=NAMES)
def test_a_hostile_file_is_read_or_ends_in_one_line(tmp_path: Path, reader: str, data: bytes) -> None:
    path = tmp_path / f"hostile{READERS[reader].ending}"
    path.write_bytes(data)
    read_or_named(READERS[reader].read, path)


def test_what_a_reader_costs_is_measured(tmp_path: Path) -> None:
    (tmp_path / "a.txt").touch()

    def take(path: Path) -> None:
        raise LidarDraftError(f"{path} of {len(bytearray(2**26)) >> 20} MB")

    found = outcome("reader", "file", take, tmp_path / "a.txt")
    assert found.clear
    assert str(found.said).endswith("of 64 MB")
    assert found.memory > 50 * 2**20
    assert not outcome("reader", "file", lambda path: [path][1], tmp_path / "a.txt").clear
