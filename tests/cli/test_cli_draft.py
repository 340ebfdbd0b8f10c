from collections.abc import Callable

import pytest

from lidardraft import Layout
from lidardraft.cli import main as cli


def test_a_sentence_becomes_a_layout(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["draft", "--text", "a car ahead", "--seed", "0", "-o", "layout.json"]) == 0
    captured = capsys.readouterr()
    layout = Layout.load("layout.json")
    assert [box.label for box in layout.boxes()] == ["car"]
    assert captured.out == f"layout.json: shapes: {len(layout)}, objects with a box: 1\n"
    assert captured.err == ""


def test_the_ending_says_the_format_before_anything_is_made(refused: Callable[..., str]) -> None:
    for path in ("layout", "layout.txt", "layout.blend"):
        said = refused("draft", "--text", "a car ahead", "-o", path)
        assert f"{path}: a layout is written as .json, .obj, .glb, .py; the ending says which" in said
