"""Folders of scans: new or empty, or --overwrite, which replaces scans and nothing else."""

from collections.abc import Callable
from pathlib import Path

import pytest

from lidardraft.cli import main as cli
from lidardraft.scan import SCAN_ENDINGS

SIMULATE = ["simulate", "--text", "a car ahead", "-o", "out", "--sensor", "small.json"]


def test_scans_are_replaced_only_where_that_is_said(refused: Callable[..., str]) -> None:
    assert cli.main([*SIMULATE, "-n", "2"]) == 0
    Path("out/notes.txt").write_text("mine")
    Path("out/000007.bin").write_bytes(b"a scan that no layout lies beside")
    before = Path("out/000000.bin").read_bytes()
    message = refused(*SIMULATE, "--seed", "9")
    assert "out is not empty (000000.bin and" in message
    assert "--overwrite" in message
    assert cli.main([*SIMULATE, "--seed", "9", "--overwrite"]) == 0
    names = {path.name for path in Path("out").iterdir()}
    assert names == {*(f"000000{end}" for end in SCAN_ENDINGS), "notes.txt", "000007.bin"}
    assert Path("out/000000.bin").read_bytes() != before


@pytest.mark.parametrize("command", ["simulate", "generate"])
def test_what_fails_replaces_nothing(refused: Callable[..., str], command: str) -> None:
    assert cli.main(SIMULATE) == 0
    assert "xyzzy" in refused(command, "--text", "xyzzy", "-o", "out", "--overwrite")
    again = [command, "--text", "a car ahead", "-o", "out", "--overwrite"]
    assert "smal.json: No such file" in refused(*again, "--sensor", "smal.json")
    Path("file").write_text("")
    assert "file is a file; it must be a folder" in refused(command, "--text", "a car ahead", "-o", "file")
