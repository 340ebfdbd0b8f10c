"""`lidardraft evaluate` of folders of scans, by published protocols."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from lidardraft.cli import main as cli
from lidardraft.formats.kitti import write_bin

FOLDERS = ["--real", "real", "--generated", "made"]


@pytest.fixture(autouse=True)
def scans(folder: Path) -> None:
    drawn = np.random.default_rng(0)
    for name, spread in (("real/sequences/08/velodyne", 15), ("made", 25)):
        (folder / name).mkdir(parents=True)
        for number in range(4):
            points = drawn.normal(0, [spread, spread, 1], (500, 3)).astype(np.float32)
            write_bin(folder / name / f"{number:06d}.bin", points, np.full(500, 0.5, dtype=np.float32))


def test_scores_of_folders_with_their_cards(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["evaluate", "--protocol", "r2dm", *FOLDERS]) == 0
    out = capsys.readouterr().out
    assert out.startswith("r2dm: 4 generated beside 4 recorded scans; kazuto1011/r2dm")
    assert "Gaussian kernel of width 0.5 in the Euclidean norm" in out
    assert "FRD  needs darknet53-1024/backbone and darknet53-1024/segmentation_decoder in the folder of" in out
    assert cli.main(["evaluate", "--protocol", "r2dm", *FOLDERS, "--json"]) == 0
    cards = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [card["metric"] for card in cards] == ["JSD", "MMD", "FRD", "FPD"]
    shown = f"MMD  {1e4 * cards[1]['value']:10.4g}   floor {1e4 * min(cards[1]['floor']):.4g} to "
    assert shown in out
    assert cards[2]["value"] is None


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--protocol", "lidm"], "a published protocol takes all three: --protocol, --real and --generated"),
        (["--real", "real", "--generated", "made"], "a published protocol takes all three"),
        (["--protocol", "lidm", "--real", "none.bin", "--generated", "made"], "lidardraft: none.bin: no such file"),
        (["--protocol", "lidm", "--real", "empty", "--generated", "made"], "empty: there is no .bin"),
    ],
)
def test_what_cannot_be_scored(refused: Callable[..., str], words: list[str], message: str) -> None:
    Path("empty").mkdir()
    assert message in refused("evaluate", *words)
