"""Hostile scripts are refused: with the line, within few steps, in little memory. Nothing of them is run."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from hostile_scripts import HOSTILE, says_where

from lidardraft.drafting.blender.layout import layout_from_blender
from lidardraft.errors import ScriptError

MEMORY = 100 * 2**20  # bytes beside what an import of lidardraft takes
SECONDS = 1.0  # of processor time for one script

ALL_IN_ONE_PROCESS = f"""
import json, resource, sys, time
from hostile_scripts import HOSTILE
from lidardraft.drafting.blender.layout import layout_from_blender
from lidardraft.errors import ScriptError
try: layout_from_blender("import bpy")  # what is imported late is imported now
except ScriptError: pass
with open("/proc/self/statm") as file:
    taken = int(file.read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (taken + {MEMORY}, taken + {MEMORY}))
seconds = {{}}
for name, script, line in HOSTILE:
    start = time.process_time()
    try:
        layout_from_blender(script)
    except ScriptError as error:
        seconds[name] = time.process_time() - start
        assert "MemoryError" not in str(error) and "too large to be read" not in str(error), name
print(json.dumps(seconds))
"""


@pytest.mark.parametrize(("script", "line"), [case[1:] for case in HOSTILE], ids=[case[0] for case in HOSTILE])
def test_it_is_refused_with_its_line(script: str, line: int) -> None:
    with pytest.raises(ScriptError, match=r"^line \d+: ") as refused:
        layout_from_blender(script)
    assert says_where(str(refused.value), script, line)
    assert len(str(refused.value)) < 400
    assert "\n" not in str(refused.value)


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="needs /proc")
def test_all_are_refused_in_100_megabytes() -> None:
    """A process whose memory is limited to so much more refuses each of them, and in a bounded time."""
    command = [sys.executable, "-c", ALL_IN_ONE_PROCESS]
    run = subprocess.run(command, cwd=Path(__file__).parent, capture_output=True, text=True, timeout=100)
    assert run.returncode == 0, run.stderr[-2000:]
    seconds = json.loads(run.stdout)
    assert seconds.keys() == {name for name, _, _ in HOSTILE}
    assert max(seconds.values()) < SECONDS


def test_there_are_as_many_as_the_page_says() -> None:
    assert len({script for _, script, _ in HOSTILE}) == len(HOSTILE)
    page = (Path(__file__).parents[3] / "docs" / "blender.md").read_text(encoding="utf-8")
    assert f" {len(HOSTILE)} hostile scripts" in page
    assert f"{SECONDS:.0f} s of processor time, and all of them {MEMORY // 2**20} MB" in page
