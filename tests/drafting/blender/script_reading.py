"""Scripts for the tests of the reader: each says by its own `assert` what must come out."""

import pytest

from lidardraft.drafting.blender.script.limits import RefusalError, Script, ScriptLimits
from lidardraft.drafting.blender.script.modules import modules
from lidardraft.drafting.blender.script.reading import read


def agrees(script: str) -> Script:
    """Python carries the script out without an error, and so does the reader."""
    exec(compile(script, "script", "exec"), {"__name__": "__main__"})
    return reads(script)


def reads(script: str, limits: ScriptLimits | None = None) -> Script:
    """The reader carries the script out."""
    reading = Script(limits or ScriptLimits())
    reading.modules = modules(reading)
    read(script, reading)
    return reading


def refuses(script: str, said: str, line: int = 1, limits: ScriptLimits | None = None) -> None:
    """The reader refuses it, naming the line or, where it takes too long, any line of it."""
    with pytest.raises(RefusalError, match=said) as refused:
        reads(script, limits)
    named = refused.value.line or 0
    assert named == line or ("; `limits`" in str(refused.value) and 1 <= named <= 1 + script.count("\n"))
