"""A folder has one writer at a time."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from lidardraft.errors import FormatError
from lidardraft.training.folder_lock import locked_folder

HOLD = """
import sys
from pathlib import Path
from lidardraft.training.folder_lock import locked_folder
with locked_folder(Path(sys.argv[1])):
    print("held", flush=True)
    sys.stdin.read()
"""


def test_a_lock_names_who_holds_it_and_ends_with_the_block(tmp_path: Path) -> None:
    with (
        locked_folder(tmp_path),
        pytest.raises(FormatError, match=f"is being written by process {os.getpid()} on "),
        locked_folder(tmp_path),
    ):
        pass
    with locked_folder(tmp_path):
        pass


def test_a_lock_ends_with_a_process_that_is_killed(tmp_path: Path) -> None:
    command = [sys.executable, "-c", HOLD, str(tmp_path)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == "held\n"
        with pytest.raises(FormatError, match=f"process {other.pid} on "), locked_folder(tmp_path):
            pass
        other.kill()
        other.wait()
        with locked_folder(tmp_path):
            pass
