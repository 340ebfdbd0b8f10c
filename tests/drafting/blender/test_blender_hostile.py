"""Hostile scripts are refused: with the line, in bounded time and memory. Nothing of them is run."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from hostile_scripts import HOSTILE, says_where

MEMORY = 100 * 2**20  # bytes beside what an import of lidardraft takes
SECONDS = 0.04  # of processor time that each is allowed
WITHIN = 0.5  # s of processor time each is refused

ALL_IN_ONE_PROCESS = f"""
import json, resource, sys, time
from pathlib import Path
from hostile_scripts import HOSTILE
from lidardraft.drafting.blender.layout import layout_from_blender
from lidardraft.drafting.blender.script.limits import ScriptLimits
from lidardraft.errors import ScriptError
try: layout_from_blender("import bpy")  # what is imported late is imported now
except ScriptError: pass
if Path("/proc/self/statm").exists():
    taken = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (taken + {MEMORY}, taken + {MEMORY}))
said = {{}}
for name, script, line in HOSTILE:
    start = time.process_time()
    try:
        layout_from_blender(script, limits=ScriptLimits(seconds={SECONDS}))
    except ScriptError as error:
        said[name] = str(error), time.process_time() - start
print(json.dumps(said))
"""


@pytest.fixture(scope="module")
def refusals() -> dict[str, tuple[str, float]]:
    """What each is refused with, and the seconds that it takes, in a process whose memory is limited."""
    command = [sys.executable, "-c", ALL_IN_ONE_PROCESS]
    run = subprocess.run(command, cwd=Path(__file__).parent, capture_output=True, text=True, timeout=300)
    assert run.returncode == 0, run.stderr[-2000:]
    return json.loads(run.stdout)


@pytest.mark.parametrize(("name", "script", "line"), HOSTILE, ids=[case[0] for case in HOSTILE])
def test_it_is_refused_with_its_line(refusals: dict[str, tuple[str, float]], name: str, script: str, line: int) -> None:
    said, seconds = refusals[name]
    assert says_where(said, script, line), said
    assert len(said) < 400
    assert "\n" not in said
    assert "too large to be read" not in said, "it has taken all memory"
    assert seconds < WITHIN


def test_there_are_as_many_as_the_page_says() -> None:
    assert len({script for _, script, _ in HOSTILE}) == len(HOSTILE)
    page = (Path(__file__).parents[3] / "docs" / "reference" / "blender.md").read_text(encoding="utf-8")
    assert f" {len(HOSTILE)} hostile scripts" in page
    assert f"within {WITHIN} s of its processor time, and all of them in {MEMORY // 2**20} MB" in page
