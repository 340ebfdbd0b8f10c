"""Folders that a command fills."""

from pathlib import Path

import pytest

from lidardraft.cli.output_folder import check_empty
from lidardraft.errors import FormatError


def test_new_empty_and_hidden_are_fine(tmp_path: Path) -> None:
    folder = tmp_path / "new"
    check_empty(folder, "")
    folder.mkdir()
    check_empty(folder, "")
    (folder / ".lock").touch()
    check_empty(folder, "")


def test_what_is_there_is_named(tmp_path: Path) -> None:
    folder = tmp_path / "used"
    folder.mkdir()
    (folder / "notes.txt").touch()
    with pytest.raises(FormatError, match=r"is not empty \(notes.txt\); use another folder or ask"):
        check_empty(folder, " or ask")
    check_empty(folder, "", but=r"notes\.txt")
    (folder / "more").mkdir()
    with pytest.raises(FormatError, match=r"is not empty \(more and 1 more\)"):
        check_empty(folder, "")


def test_a_file_is_no_folder(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(FormatError, match="file is a file; it must be a folder"):
        check_empty(tmp_path / "file", "")
