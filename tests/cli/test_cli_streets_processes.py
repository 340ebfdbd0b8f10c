"""`lidardraft streets` and `simulate`, and the processes that they start, under real signals."""

import contextlib
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from processes import Command, wait_for

from lidardraft import Sensor
from lidardraft.scan import SCAN_ENDINGS
from lidardraft.training.sources import PairFolder

pytestmark = pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="there is no process table in /proc")
SIMULATE = ("simulate", "--text", "a car ahead", "--surroundings", "bare", "--sensor", "small.json", "-o", "out")
ENDLESS = ("streets", "--sensor", "small.json", "--num", "1000000", "--poses", "32", "--output", "pairs")


@pytest.fixture(autouse=True)
def few_rays(folder: Path) -> None:
    """In small.json: these tests hold for any scan."""
    Sensor(name="few", elevations=(0.0, -0.1, -0.2, -0.3), columns=16).save(folder / "small.json")


@pytest.fixture
def start(folder: Path) -> Iterator[Callable[..., Command]]:
    commands: list[Command] = []

    def begin(*argv: str) -> Command:
        commands.append(Command(*argv, folder=folder))
        return commands[-1]

    yield begin
    for command in commands:
        command.stop()


@pytest.mark.parametrize("early", [True, False])
def test_workers_end_with_a_parent_that_is_killed(start: Callable[..., Command], early: bool) -> None:
    command = start(*ENDLESS, "--workers", "2")
    # early: the workers are still loading
    wait_for(lambda: len(command.workers()) == 2 if early else Path("pairs/index.json").exists())
    os.kill(command.process.pid, signal.SIGKILL)
    wait_for(lambda: not command.members(), seconds=20)
    assert command.ended()[0] == -signal.SIGKILL


@pytest.mark.parametrize("send", [os.killpg, pytest.param(os.kill, marks=pytest.mark.slow)])
def test_termination_is_clean(start: Callable[..., Command], send: Callable[[int, int], None]) -> None:
    command = start(*ENDLESS, "--workers", "2")
    wait_for(Path("pairs/index.json").exists)
    send(command.process.pid, signal.SIGTERM)
    assert command.ended()[::2] == (143, "")
    wait_for(lambda: not command.members(), seconds=20)
    assert not list(Path("pairs").glob("*.partial"))


@pytest.mark.parametrize(("early", "times"), [(True, 1), pytest.param(False, 20, marks=pytest.mark.slow)])
def test_an_interrupt_and_impatience_are_one_line(start: Callable[..., Command], early: bool, times: int) -> None:
    command = start(*ENDLESS, "--workers", "2")
    # early: the workers are still loading
    wait_for(lambda: len(command.workers()) == 2 if early else Path("pairs/index.json").exists())
    for _ in range(times):  # while it cleans up and ends
        with contextlib.suppress(ProcessLookupError):
            command.interrupt()
        time.sleep(0.05)
    status, _, err = command.ended()
    assert (status, err) == (130, "lidardraft: interrupted\n")
    wait_for(lambda: not command.members(), seconds=20)
    assert not list(Path("pairs").glob("*.partial"))


def test_a_killed_worker_is_one_line(start: Callable[..., Command]) -> None:
    command = start(*ENDLESS, "--workers", "2")
    wait_for(Path("pairs/index.json").exists)
    os.kill(command.workers()[0], signal.SIGKILL)
    status, _, err = command.ended()
    assert status == 2
    assert err.count("\n") == 1
    assert "worker" in err
    wait_for(lambda: not command.members(), seconds=20)


@pytest.mark.slow
def test_a_folder_that_is_being_written_is_refused(start: Callable[..., Command]) -> None:
    first = start(*ENDLESS, "--workers", "1")
    wait_for(Path("pairs/.lock").exists)
    status, _, err = start(*ENDLESS, "--workers", "1").ended()
    assert status == 2
    assert err.count("\n") == 1
    assert f"pairs is being written by process {first.process.pid} on " in err
    wait_for(Path("pairs/index.json").exists)
    os.kill(first.process.pid, signal.SIGKILL)
    first.ended()
    # the lock has died with its holder
    argv = ("streets", "--sensor", "small.json", "--poses", "32", "--workers", "1", "--output", "pairs", "--num")
    held = len(PairFolder("pairs"))
    assert start(*argv, str(held + 1)).ended()[0] == 0
    assert [note["index"] for note in PairFolder("pairs").notes] == list(range(held + 1))


@pytest.mark.parametrize("terminal", [True, False])
def test_a_terminal_without_a_size_shows_progress_and_a_file_none(folder: Path, terminal: bool) -> None:
    at_once = "import sys\nfrom lidardraft.cli import command, main\ncommand._SHOWN_AFTER = 0.0\nsys.exit(main.main())"
    words = [*SIMULATE, "-n", "3", "--no-picture"]
    end, stderr = os.openpty() if terminal else os.pipe()
    process = subprocess.Popen([sys.executable, "-c", at_once, *words], cwd=folder, stderr=stderr)
    os.close(stderr)
    shown = b""
    with contextlib.suppress(OSError):  # the end of a terminal
        while read := os.read(end, 4096):
            shown += read
    os.close(end)
    assert process.wait(timeout=60) == 0
    assert (b"3/3" in shown, b"scan/s" in shown) == (terminal, terminal)


def test_an_interrupted_simulation_leaves_whole_scans(start: Callable[..., Command]) -> None:
    command = start(*SIMULATE, "-n", "100000", "--jobs", "2")
    wait_for(Path("out/000005.bin").exists)
    command.interrupt()
    assert command.ended()[0] == 130
    wait_for(lambda: not command.members(), seconds=20)
    files = [path.name for path in Path("out").iterdir()]
    assert not [name for name in files if name.startswith(".")]
    numbers = {name.partition(".")[0] for name in files}
    assert "000005" in numbers
    for number in numbers:
        assert {name.removeprefix(number) for name in files if name.startswith(number)} >= set(SCAN_ENDINGS) - {".png"}
