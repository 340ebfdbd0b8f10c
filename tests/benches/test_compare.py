"""The whole comparison, as `make compare` runs it, with as little as it can measure."""

import json
import subprocess
import sys
from pathlib import Path

COMPARE = Path(__file__).parents[2] / "benches" / "compare.py"


def run(*arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, str(COMPARE), "--scenes", "small", "--rounds", "1", "--batch", "2", *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_one_table_and_a_line_for_who_is_not_there(tmp_path: Path) -> None:
    result = run("--threads", "1", "--peers", "analytic,triangles,nobody", "--json", str(tmp_path / "rounds.json"))
    assert result.returncode == 0, result.stderr
    assert "without nobody on 1 threads" in result.stderr
    rows = [line.split(" | ") for line in result.stdout.splitlines() if line.startswith("| small")]
    measured = [row[1] for row in rows]
    assert measured[:4] == ["build from arrays", "compile a layout", "bare cast", "end to end, `out=`"]
    assert measured[4:] == ["end to end, new arrays", "a pose for each column", "batch, one scan of it"]
    assert all(float(cell) > 0 for row in rows for cell in row[6:8])  # ours, analytic and triangles
    assert rows[2][12] == "100.000%, 100.000%"  # as the reference path
    assert "scans/s" in result.stdout
    rounds = json.loads((tmp_path / "rounds.json").read_text())
    assert ["small", "triangles", 1, "cast"] in [entry[:4] for entry in rounds["seconds"]]


def test_a_scene_that_is_not_there() -> None:
    result = run("--scenes", "moon")
    assert result.returncode == 2
    assert "scenes are small, street, heavy" in result.stderr
