import gc

import pytest
from script_reading import agrees, reads, refuses

from lidardraft.drafting.blender.script.limits import Limits


@pytest.mark.parametrize(
    "script",
    [
        "import math\nimport random as r\nfrom math import pi, sin as s\nassert math.pi == pi and "
        "s(0) == 0 and r.seed(1) is None",
        "from math import *\nassert sqrt(4) == 2 and tau > pi",
        "assert __name__ == '__main__'",
    ],
)
def test_modules_are_those_of_python(script: str) -> None:
    agrees(script)


def test_other_modules_may_be_imported_and_nothing_is_done_with_them() -> None:
    reads("import math, subprocess, os.path\nfrom shutil import rmtree as remove\nfrom functools import wraps")
    for use in ("m.a.b()", "m()", "not m", "m == 1", "str(m)", "m[0]", "m + 1", "1 in m", "len(m)", "list(m)"):
        refuses(f"import socket as m\n{use}", "socket", 2)
    refuses("from shutil import rmtree\nx = list(map(rmtree, ['/']))", "a call of shutil.rmtree: a script is read", 2)
    refuses("import socket\nx = socket\nwhile True:\n    x = x.a", "more than 175000 steps", 3)
    refuses("from os import *\nsystem('ls')", "the name 'system' is not known", 2)


def test_other_parts_are_refused() -> None:
    refuses("from math import _x\n_x()", r"a call of math\._x", 2)


def test_what_is_said_of_types_is_passed_over() -> None:
    agrees(
        "from __future__ import annotations\nimport typing as t\nfrom typing import List\nNumbers = List[float]\n"
        "def f(a: Numbers, b: t.Optional[int] = None) -> Numbers:\n    return a\nassert f([1]) == [1]"
    )


def test_a_number_of_random_without_a_seed_is_noted_once() -> None:
    evaluator = reads("import random\nx = 1\nfor i in range(3):\n    x += random.random()\nx += random.random()")
    assert evaluator.notes == {"random numbers without a seed: the seed 0 is taken": 4}
    assert reads("import random\nrandom.seed(5)\nrandom.random()").notes == {}


def test_the_length_of_a_script_counts_as_steps() -> None:
    """Parsing takes as long as going through it, so a script may be long or take many rounds, and not both."""
    script = "x = 1 + 2\n" * 900  # 4500 tokens
    reads(script, Limits(steps=40_000))
    refuses(script, "more than 15000 steps; `limits` allows more", 900, Limits(steps=15_000))
    refuses("for i in range(10000):\n    x = 1", "more than 100 steps", 2, Limits(steps=100))


def test_the_collector_of_python_is_left_as_it_was() -> None:
    refuses("x = 1\nx.y", "has no 'y'", 2)
    assert gc.isenabled()
    gc.disable()
    try:
        reads("x = 1")
        assert not gc.isenabled()
    finally:
        gc.enable()
