"""Statements of scripts: loops, functions, classes, errors, and the names that they set."""

import gc

import pytest
from script_reading import agrees, reads, refuses

DATACLASS = "from dataclasses import dataclass\n"
_EACH_OTHER = "g = (next(h) for _ in [1])\nh = (next(g) for _ in [1])\nnext(g)"
AGREED: list[str] = [
    "x: int = 3\ny: int\nx += 2\nx -= 1\nx *= 3\nx //= 2\nassert x == 6",
    "len = 5\nassert len == 5",
    "x = 1\ndel x\nx = 2\nassert x == 2",
    "n = 0\nwhile n < 5:\n    n += 1\nelse:\n    n = 9\nassert n == 9",
    "t = 0\nfor i in range(10):\n    if i == 2:\n        continue\n    if i == 5:\n        break\n"
    "    t += i\nelse:\n    t = -1\nassert t == 8",
    "def f(x):\n    for i in range(9):\n        while True:\n            if i == x:\n"
    "                return i\n            break\nassert f(3) == 3 and f(99) is None",
    "a = [1, 2]\nfor x in a:\n    if len(a) < 5:\n        a.append(x)\nassert a == [1, 2, 1, 2, 1]",
    "pass\n'text alone'\n1",
    # names are found where python finds them
    "x = 1\ndef f():\n    global x\n    x = 2\nf()\nassert x == 2",
    "def f():\n    n = 0\n    def g():\n        nonlocal n\n        n += 1\n        return n\n    g()\n"
    "    return g()\nassert f() == 2",
    "def f():\n    return later()\ndef later():\n    return 3\nassert f() == 3",
    "def f(a, /, b, *, c=3):\n    return a + b + c\nassert f(1, b=2) == 6",
    # decorators may be called with what changes no shape
    DATACLASS + "@dataclass(frozen=True, order=True)\nclass A:\n    x: int\nassert A(1).x == 1",
    # classes of errors of the scripts own
    "class SceneError(Exception):\n    pass\ntry:\n    raise SceneError('no road')\nexcept SceneError as e:\n"
    "    assert str(e) == 'no road'\nelse:\n    assert False",
    "class A:\n    made = []\n    @staticmethod\n    def f(x):\n        return x + 1\n    @classmethod\n"
    "    def g(cls, x):\n        cls.made.append(x)\n        return cls()\nassert A.f(1) == A().f(1) == 2\nA.g(5)\n"
    "assert A.made == [5]",
    "x = 1\nclass A:\n    x = 2\n    def f(self):\n        return x\nassert A().f() == 1",
    "from enum import Enum, auto\nclass K(Enum):\n    CAR = 5\n    BUS = auto()\nsizes = {K.CAR: 4, K.BUS: 12}\n"
    "assert sizes[K.CAR] == 4 and K(5) is K.CAR and K.BUS.value == 6 and K['BUS'] is K.BUS and [k.name for k "
    "in K] == ['CAR', 'BUS']",
    "from typing import NamedTuple\nclass P(NamedTuple):\n    x: int\n    y: int = 2\na, b = P(1)\n"
    "assert (a, b) == (1, 2)",
    "from dataclasses import dataclass\n@dataclass(frozen=True)\nclass A:\n    x: int\n"
    "assert {A(1): 5}[A(1)] == 5 and len({A(1), A(1), A(2)}) == 2",
    "from collections import namedtuple\nP = namedtuple('P', 'x y')\n"
    "assert P(1, 2) == P(1, 2) == (1, 2) and (1, 2) == P(1, 2) and P(1, 2) != P(2, 1)\n"
    "assert {P(1, 2): 5}[P(1, 2)] == 5 and {P(1, 2): 5}[(1, 2)] == 5",
    "class A:\n    def __str__(self):\n        return 'Tree_1'\n    def __repr__(self):\n        return 'A()'\n"
    "assert f'{A()}' == str(A()) == 'Tree_1' and '%s' % A() == 'Tree_1' and repr(A()) == f'{A()!r}' == 'A()'\n"
    "assert str([A()]) == '[A()]'",
    "class A:\n    def __repr__(self):\n        return 'A()'\nclass B(A):\n    pass\nassert str(B()) == 'A()'",
    # what python catches is caught
    "def f(n):\n    if n == 0:\n        raise KeyError\n    f(n - 1)\nfor k in range(20):\n    try:\n"
    "        f(3)\n    except Exception:\n        pass",
    "try:\n    next(iter([]))\nexcept StopIteration:\n    x = 1\nassert x == 1",
    "def f():\n    try:\n        return 1\n    finally:\n        x = 2\nassert f() == 1",
    "x = []\ntry:\n    try:\n        raise KeyError\n    finally:\n        x.append(1)\nexcept KeyError:\n"
    "    x.append(2)\nassert x == [1, 2]",
    "x = []\ntry:\n    try:\n        {}['a']\n    except KeyError:\n        x.append(1)\n        raise\n"
    "except KeyError:\n    x.append(2)\nassert x == [1, 2]",
    # modules are those of python
    "import math\nimport random as r\nfrom math import pi, sin as s\nassert math.pi == pi and "
    "s(0) == 0 and r.seed(1) is None",
    "from math import *\nassert sqrt(4) == 2 and tau > pi",
    "assert __name__ == '__main__'",
    # what is said of types is passed over
    "from __future__ import annotations\nimport typing as t\nfrom typing import List\nNumbers = List[float]\n"
    "def f(a: Numbers, b: t.Optional[int] = None) -> Numbers:\n    return a\nassert f([1]) == [1]",
]
REFUSED: list[tuple[str, str, int]] = [
    ("a, b = 1, 2, 3", "3 values for 2 names", 1),
    ("*a, b = []", "0 values for 2 names", 1),
    ("x = 5\nx.y = 1", "the attribute 'y' of 5 cannot be set", 2),
    ("x = (1, 2)\nx[0] = 1", "a tuple has no place 0 that can be set", 2),
    # names that are not there
    ("x = 1\ndef f():\n    y = 2\nf()\ny", "the name 'y' is not known", 5),
    ("del x", "the name 'x' is not known", 1),
    ("def f():\n    nonlocal x\nf()", "no function around this one has the name 'x'", 2),
    ("__x__ = 1", "the name '__x__' cannot be set", 1),
    ("x = 1\nclass A(metaclass=x):\n    pass", "one base class and no metaclass", 2),
    ("class A:\n    pass\nclass B(A, A):\n    pass", "one base class and no metaclass", 3),
    ("class A(1):\n    pass", "a class derived from 1 is not supported", 1),
    ("with 1:\n    pass", "`with` of 1 is not supported", 1),
    ("class A:\n    @staticmethod\n    def f():\n        pass\n    @f.setter\n    def f(x): pass", "'setter'", 5),
    ("class A:\n    def __getattr__(self, name):\n        return 1", "the name '__getattr__' cannot be set", 2),
    ("class A(dict):\n    pass", "a class derived from a function is not supported", 1),
    ("class A:\n    pass\nA(1)", "the class A takes no arguments", 3),
    ("class A:\n    pass\nA().x", "an instance of the class A has no 'x'", 3),
    # generators are not read, and iterators that go on with each other neither
    ("def f():\n    yield 1\nlist(f())", "`.yield 1.` is not supported in a script", 2),
    (_EACH_OTHER, "an iterator that goes on with itself", 2),
    # what is not read or too much is not caught
    ("try:\n    x = {}['a']\nexcept ValueError:\n    pass", "the key 'a' is not in the dict", 2),
    ("try:\n    import os\n    os.fork()\nexcept Exception:\n    pass", "os.fork is not supported", 3),
    ("try:\n    while True:\n        pass\nexcept:\n    pass", "more than 1[57]", 3),
    ("try:\n    x = 1\nfinally:\n    raise ValueError", "the script ends here", 4),
    # other parts are refused
    ("from math import _x\n_x()", r"a call of math\._x", 2),
]


@pytest.mark.parametrize("script", AGREED)
def test_it_is_what_python_makes_of_it(script: str) -> None:
    agrees(script)


@pytest.mark.parametrize(("script", "said", "line"), REFUSED)
def test_it_is_refused(script: str, said: str, line: int) -> None:
    refuses(script, said, line)


def test_what_is_never_reached_is_not_refused() -> None:
    reads("def never():\n    import os\n    with open('a') as f:\n        yield f\nif 0:\n    class A: pass")


def test_other_modules_may_be_imported_and_nothing_is_done_with_them() -> None:
    reads("import math, subprocess, os.path\nfrom shutil import rmtree as remove\nfrom functools import wraps")
    for use in ("m.a.b()", "m()", "not m", "m == 1", "str(m)", "m[0]", "m + 1", "1 in m", "len(m)", "list(m)"):
        refuses(f"import socket as m\n{use}", "socket", 2)
    refuses("from shutil import rmtree\nx = list(map(rmtree, ['/']))", "a call of shutil.rmtree: a script is read", 2)
    refuses("import socket\nx = socket\nwhile True:\n    x = x.a", "more than 175000 steps", 3)
    refuses(f"import {'a' * 99} as m\nm()", f"a call of {'a' * 60}: ", 2)
    refuses("from os import *\nsystem('ls')", "the name 'system' is not known", 2)


def test_a_number_of_random_without_a_seed_is_noted_once() -> None:
    evaluator = reads("import random\nx = 1\nfor i in range(3):\n    x += random.random()\nx += random.random()")
    assert evaluator.notes == {"random numbers without a seed: the seed 0 is taken": 4}
    assert reads("import random\nrandom.seed(5)\nrandom.random()").notes == {}


def test_the_collector_of_python_is_left_as_it_was() -> None:
    refuses("x = 1\nx.y", "has no 'y'", 2)
    assert gc.isenabled()
    gc.disable()
    try:
        reads("x = 1")
        assert not gc.isenabled()
    finally:
        gc.enable()
