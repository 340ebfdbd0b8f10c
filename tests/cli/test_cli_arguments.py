import argparse

import pytest

from lidardraft.cli import main as cli
from lidardraft.cli import train
from lidardraft.cli.arguments import minutes, whole_number


def test_whole_numbers_within_limits() -> None:
    assert [whole_number(0, 9)(text) for text in ("0", "9")] == [0, 9]
    assert whole_number(1)("123456789") == 123456789


@pytest.mark.parametrize("text", ["abc", "", "1.5", "-1", "10", "nan"])
def test_other_texts_are_named_with_the_limits(text: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError, match=rf"^'{text}' is not a whole number from 0 to 9$"):
        whole_number(0, 9)(text)


def test_minutes_are_over_zero() -> None:
    assert [minutes(text) for text in ("0.5", "90", "inf")] == [0.5, 90, float("inf")]
    for text in ("0", "-5", "nan", "", "soon"):
        with pytest.raises(argparse.ArgumentTypeError, match=rf"^'{text}' is not a number over 0$"):
            minutes(text)


@pytest.mark.parametrize(
    ("argv", "said"),
    [
        ("generate --text car -o out -n abc", "argument -n/--num: 'abc' is not a whole number of 1 or more"),
        ("generate --text car -o out --steps 0", "argument --steps: '0' is not a whole number of 1 or more"),
        ("generate --text car -o out --seed -1", "argument --seed: '-1' is not a whole number from 0 to 4294967295"),
        ("streets --look -n 0", "argument -n/--num: '0' is not a whole number of 1 or more"),
        ("streets --look --poses 0", "argument --poses: '0' is not a whole number of 1 or more"),
        ("streets --look --workers 0", "argument --workers: '0' is not a whole number of 1 or more"),
        ("streets --look --seed -1", "argument --seed: '-1' is not a whole number from 0"),
        ("evaluate -n x", "argument -n/--num: 'x' is not a whole number of 1 or more"),
    ],
)
def test_a_bad_number_is_named_in_plain_words(argv: str, said: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        cli.main(argv.split())
    assert said in capsys.readouterr().err


@pytest.mark.parametrize(
    ("argv", "said"),
    [
        ("segmenter --seed -1", "argument --seed: '-1' is not a whole number from 0 to 4294967295"),
        ("segmenter --steps abc", "argument --steps: 'abc' is not a whole number of 1 or more"),
        ("segmenter --batch 0", "argument --batch: '0' is not a whole number of 1 or more"),
        ("segmenter --minutes nan", "argument --minutes: 'nan' is not a number over 0"),
        ("street --minutes -5", "argument --minutes: '-5' is not a number over 0"),
        ("street --steps 0", "argument --steps: '0' is not a whole number of 1 or more"),
        ("segmenter --steps 0", "argument --steps: '0' is not a whole number of 1 or more"),
        ("ablation --base-steps 0", "argument --base-steps: '0' is not a whole number of 1 or more"),
        ("street --evaluate 0", "argument --evaluate: '0' is not a whole number of 1 or more"),
    ],
)
def test_so_is_a_bad_number_of_a_training(argv: str, said: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        train.main(argv.split())
    assert said in capsys.readouterr().err
