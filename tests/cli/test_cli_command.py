"""How commands end: one line on stderr whatever was wrong."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from lidardraft.cli import main as cli


def test_files_that_cannot_be_read_or_written(refused: Callable[..., str]) -> None:
    assert refused("view", "nowhere.bin") == "lidardraft: nowhere.bin: No such file or directory\n"
    Path("file").write_text("")
    assert "file" in refused("draft", "--text", "a car ahead", "-o", "file/layout.json")
    assert "cannot be written" in refused("draft", "--text", "a car ahead", "-o", "nowhere/layout.json")


def test_nothing_that_a_terminal_obeys_reaches_it(refused: Callable[..., str]) -> None:
    message = refused("view", "red\x1b[31m\nname.json")
    assert "red\\x1b[31m\\nname.json" in message


def test_a_reader_that_goes_away_is_no_error() -> None:
    command = [sys.executable, "-m", "lidardraft", "draft", "--text", "a car ahead", "-o", "layout.json"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None
    process.stdout.close()
    _, err = process.communicate(timeout=60)
    assert err == ""
    assert process.returncode == 141


def test_words_that_are_not_understood_are_said_once(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["draft", "--text", "a car ahead and a purple dinosaur", "-o", "layout.json"]) == 0
    captured = capsys.readouterr()
    assert captured.err.count("dinosaur") == 1
    assert captured.out.startswith("layout.json: ")
