import re

import pytest
from processes import shown_on_a_terminal

from lidardraft.cli import main as cli


def test_streets_and_scans_show_their_progress() -> None:
    shown = shown_on_a_terminal("evaluate", "-n", "1", "--sensor", "small.json", "--steps", "1")
    assert "making streets" in shown
    assert "1/2" in shown


def test_scores_of_unseen_streets(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["evaluate", "-n", "1", "--sensor", "small.json", "--steps", "2"]) == 0
    captured = capsys.readouterr()
    assert captured.out.startswith("1 street, small, half of each open, 2 steps\n")
    names = captured.out.splitlines()[1].split()
    assert names == ["objects", "other", "all", "drop", "range", "height", "BEV", "classes", "holes", "lone", "own"]
    rows = re.findall(r"^(\S.*?)(?: +(?:\d\.\d{3}|nan)){11}$", captured.out, re.MULTILINE)
    assert rows == ["detailed scan", "other streets", "bare", "simulated", "generated", "untrained"]
    assert len(re.findall(r"^ {4}all, by class: .*road \d\.\d\d", captured.out, re.MULTILINE)) == 6
    assert len(re.findall(r"^ {4}intensity \(JSD\), by class: .*road \d\.\d\d", captured.out, re.MULTILINE)) >= 2
    assert captured.err == (
        "lidardraft: these weights were trained on beams of 64, and small has 16; its scans may be poor\n"
    )
