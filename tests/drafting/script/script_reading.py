"""Scripts for the tests of the reader: each says by its own `assert` what must come out."""

import pytest

from lidardraft.drafting.script.evaluator import Evaluator
from lidardraft.drafting.script.limits import Limits, RefusalError


def agrees(script: str) -> Evaluator:
    """Python carries the script out without an error, and so does the reader."""
    exec(compile(script, "script", "exec"), {"__name__": "__main__"})
    return reads(script)


def reads(script: str, limits: Limits | None = None) -> Evaluator:
    """The reader carries the script out."""
    evaluator = Evaluator(limits or Limits())
    evaluator.read(script)
    return evaluator


def refuses(script: str, said: str, line: int = 1, limits: Limits | None = None) -> None:
    """The reader refuses it, naming the line."""
    with pytest.raises(RefusalError, match=said) as refused:
        reads(script, limits)
    assert refused.value.line == line
