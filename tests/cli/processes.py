"""Commands as processes of their own: signals go to them, and the process table says what is left of them."""

import contextlib
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path


class Command:
    """A `lidardraft` command in a session of its own, as a terminal starts it."""

    def __init__(self, *argv: str, folder: Path) -> None:
        command = [sys.executable, "-m", "lidardraft.cli.main", *argv]
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(
            command, cwd=folder, stdout=pipe, stderr=pipe, text=True, start_new_session=True, preexec_fn=_hear_signals
        )

    def members(self) -> dict[int, str]:
        """The living processes of the session: id and command line."""
        found = {}
        for folder in Path("/proc").glob("[0-9]*"):
            with contextlib.suppress(OSError, ValueError):  # it has ended meanwhile
                state, _, _, session = (folder / "stat").read_text().rpartition(")")[2].split()[:4]
                if int(session) == self.process.pid and state != "Z":
                    found[int(folder.name)] = (folder / "cmdline").read_text().replace("\0", " ")
        return found

    def workers(self) -> list[int]:
        """The processes that make pairs."""
        return [number for number, line in self.members().items() if "spawn_main" in line]

    def interrupt(self) -> None:
        """What Ctrl-C in a terminal does: the signal goes to every process of the session."""
        os.killpg(self.process.pid, signal.SIGINT)

    def ended(self) -> tuple[int, str, str]:
        """Exit status, stdout and stderr once it has ended."""
        out, err = self.process.communicate(timeout=60)
        return self.process.returncode, out, err

    def stop(self) -> None:
        """End whatever is left of the session."""
        for number in self.members():
            os.kill(number, signal.SIGKILL)
        self.process.communicate()


def _hear_signals() -> None:
    """As in a terminal, also where the tests themselves run in the background, which ignores Ctrl-C."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_DFL)


def wait_for(condition: Callable[[], object], seconds: float = 60) -> None:
    """Return when the condition holds; fail if it never does."""
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "it never happened"
        time.sleep(0.02)
