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
