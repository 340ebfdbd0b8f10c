import sys
from collections.abc import Callable
from functools import partialmethod
from pathlib import Path

import numpy as np
import pytest
from tqdm import tqdm

from lidardraft import Sensor
from lidardraft.cli import command
from lidardraft.cli import main as cli


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty working directory with a small sensor."""
    monkeypatch.chdir(tmp_path)
    sensor = Sensor(name="small", elevations=tuple(np.deg2rad(np.linspace(2, -24, 16)).tolist()), columns=128)
    sensor.save("small.json")
    return tmp_path


@pytest.fixture
def shown_on_a_terminal(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Callable[..., str]:
    """Runs a command that ends well and gives what a terminal shows of its stderr, with every move of a bar."""

    def shown(*argv: str) -> str:
        monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
        monkeypatch.setattr(tqdm, "__init__", partialmethod(tqdm.__init__, mininterval=0))
        monkeypatch.setattr(command, "_SHOWN_AFTER", 0.0)
        assert cli.main(argv) == 0
        return capsys.readouterr().err

    return shown


@pytest.fixture
def refused(folder: Path, capsys: pytest.CaptureFixture[str]) -> Callable[..., str]:
    """Runs a command on bad input and gives the one line that it gets; nothing new may be on the disk."""

    def refuse(*argv: str) -> str:
        before = {path: path.stat().st_mtime_ns for path in folder.rglob("*") if path.is_file()}
        capsys.readouterr()
        assert cli.main(argv) == 2
        captured = capsys.readouterr()
        assert captured.err.startswith("lidardraft: ")
        assert captured.err.count("\n") == 1
        assert {path: path.stat().st_mtime_ns for path in folder.rglob("*") if path.is_file()} == before
        return captured.err

    return refuse
