import re

import pytest

from lidardraft.cli import main as cli


def test_scores_of_unseen_streets(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["evaluate", "-n", "1", "--sensor", "small.json", "--steps", "2"]) == 0
    captured = capsys.readouterr()
    assert captured.out.startswith("1 street, small, 2 steps\n")
    rows = re.findall(r"^(\S.*?) +\d\.\d{3} +\d\.\d{3} +\d\.\d{3} +\d\.\d{3}$", captured.out, re.MULTILINE)
    assert rows == ["detailed scan", "condition image", "generated", "random weights"]
    assert captured.err == "lidardraft: these weights were trained on hdl64e; scans of small may be poor\n"
