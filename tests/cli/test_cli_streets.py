import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from processes import shown_on_a_terminal

from lidardraft.cli import main as cli
from lidardraft.training.pairs import PairFolder

SMALL = ["streets", "--sensor", "small.json", "--workers", "1"]


def height(path: str) -> int:
    with Image.open(path) as picture:
        return picture.height


def test_pairs_on_disk_go_on_where_they_stopped(capsys: pytest.CaptureFixture[str]) -> None:
    argv = [*SMALL, "--seed", "3", "--output", "pairs"]
    assert cli.main([*argv, "--num", "2"]) == 0
    assert capsys.readouterr().out == "pairs: 2 pairs, 2 of them new\n"
    first = PairFolder("pairs")
    assert cli.main([*argv, "--num", "5"]) == 0
    assert capsys.readouterr().out == (
        "pairs: goes on after the 2 pairs that are there\npairs: 5 pairs, 3 of them new\n"
    )
    pairs = PairFolder("pairs")
    assert [note["index"] for note in pairs.notes] == [0, 1, 2, 3, 4]
    assert {note["style"]["source"] for note in pairs.notes} <= {"text", "cloud", "picture", "boxes"}
    np.testing.assert_array_equal(pairs[1].scan.depth, first[1].scan.depth)
    assert cli.main([*argv, "--num", "3"]) == 0
    assert capsys.readouterr().out == "pairs: 5 pairs are there already; nothing to do\n"
    assert len(PairFolder("pairs")) == 5


def test_the_bar_moves_with_every_pair() -> None:
    shown = shown_on_a_terminal(*SMALL, "--output", "pairs", "-n", "20", "--poses", "20")
    assert {int(count) for count in re.findall(r"(\d+)/20", shown)} == set(range(21))


def test_pairs_of_another_seed_are_refused(refused: Callable[..., str]) -> None:
    assert cli.main([*SMALL, "--seed", "3", "--output", "pairs", "--num", "1"]) == 0
    assert "seed 3" in refused(*SMALL, "--output", "pairs", "--num", "9")


def test_pairs_are_not_mixed_with_other_files(refused: Callable[..., str]) -> None:
    Path("mine").mkdir()
    Path("mine/notes.txt").write_text("")
    assert "mine is not empty (notes.txt); use another folder" in refused(*SMALL, "--output", "mine")
    assert "small.json is a file; it must be a folder" in refused(*SMALL, "--output", "small.json")
    Path("killed").mkdir()
    for name in ("00000.npz", "00000.npz.1.partial"):  # before there was an index
        Path("killed", name).write_text("")
    assert cli.main([*SMALL, "--output", "killed", "-n", "1"]) == 0
    assert len(PairFolder("killed")) == 1


def test_a_picture_to_look_at(capsys: pytest.CaptureFixture[str]) -> None:
    for num in ("1", "2"):
        assert cli.main([*SMALL, "-n", num, "--look", f"{num}.png"]) == 0
    assert capsys.readouterr().out == "1.png\n2.png\n"
    assert height("2.png") > 1.9 * height("1.png")


def test_a_picture_has_a_limit_and_a_place(refused: Callable[..., str]) -> None:
    assert "there is no folder nowhere" in refused(*SMALL, "-n", "1", "--look", "nowhere/a.png")
    assert "--num is 101; a picture shows up to 100 streets" in refused(*SMALL, "-n", "101", "--look")


@pytest.mark.parametrize("to", [[], ["--look", "a.png", "--output", "pairs"]])
def test_one_output_is_asked_for(capsys: pytest.CaptureFixture[str], to: list[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        cli.main([*SMALL, *to])
    assert "--look" in capsys.readouterr().err
