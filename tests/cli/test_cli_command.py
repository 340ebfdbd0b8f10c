"""How commands end: one line on stderr whatever was wrong."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from lidardraft.cli import main as cli
from lidardraft.cli import train


@pytest.mark.parametrize(
    ("command", "said"),
    [
        ("simulate --sensr vlp16 --text car -o out", "there is no option --sensr; did you mean '--sensor'?"),
        ("simulate --txet=car -o out", "there is no option --txet; did you mean '--text'?"),
        ("simulate --text car --layout a.json -o out", "argument --layout: not allowed with argument --text"),
        ("simulate -o out", "one of the arguments --text --image"),
        ("simulate --text car", "the following arguments are required: -o/--output"),
        ("simulate --text car -o out -n some", "argument -n/--num: 'some' is not a whole number of 1 or more"),
        ("simulate --text car -o out -z 3", "not understood: -z 3"),
        ("draft --text car -o a.json --detail fin", "'fin' is not one of fine, objects; did you mean 'fine'?"),
        ("draft --sketch a.png --scale-bar long -o a.json", "argument --scale-bar: 'long' is not a number"),
        ("street --recipe smal", "'smal' is not one of small, paper"),
        ("segmenter --pair folder", "the following arguments are required: -o/--output"),
    ],
)
def test_arguments_that_cannot_be_are_one_line(command: str, said: str, capsys: pytest.CaptureFixture[str]) -> None:
    words = command.split()
    main, name = (train.main, "lidardraft-train") if words[0] in ("street", "segmenter") else (cli.main, "lidardraft")
    with pytest.raises(SystemExit, match="2"):
        main(words)
    message = capsys.readouterr().err
    assert message.startswith(f"{name} {words[0]}: error: ")
    assert message.endswith(f" (see `{name} {words[0]} --help`)\n")
    assert message.count("\n") == 1
    assert said in message


def test_so_are_a_command_and_an_option_before_it(capsys: pytest.CaptureFixture[str]) -> None:
    for words, said in ((["simulat"], "did you mean 'simulate'?"), (["--versoin"], "did you mean '--version'?")):
        with pytest.raises(SystemExit, match="2"):
            cli.main(words)
        message = capsys.readouterr().err
        assert message.startswith("lidardraft: error: ")
        assert said in message
        assert message.count("\n") == 1


def test_a_value_may_look_like_an_option(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["draft", "--text", "--two cars ahead", "--no-preview", "--out", "layout.json"]) == 0
    assert "objects with a box: 2" in capsys.readouterr().out


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
