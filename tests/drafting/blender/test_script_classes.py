import pytest
from script_reading import agrees, refuses


@pytest.mark.parametrize(
    "script",
    [
        "class A:\n    n = 3\n    def __init__(self, x, y=2):\n        self.x = x + y\n    def f(self):\n"
        "        return self.x * self.n\n"
        "a = A(1)\nassert a.f() == 9 and A.n == 3\nA.n = 4\nassert a.f() == 12",
        "class A:\n    def f(self):\n        return 1\nclass B(A):\n    def f(self):\n        return super().f() + 1\n"
        "b = B()\n"
        "assert b.f() == 2 and isinstance(b, A) and not isinstance(A(), B) and type(b) is B and B.__name__ == 'B'",
        "class A:\n    def __init__(self, x):\n        self._x = x\n    @property\n    def x(self):\n"
        "        return self._x\n"
        "    @x.setter\n    def x(self, value):\n        self._x = 2 * value\na = A(1)\na.x = 4\nassert a.x == 8",
        "class A:\n    made = []\n    @staticmethod\n    def f(x):\n        return x + 1\n    @classmethod\n"
        "    def g(cls, x):\n"
        "        cls.made.append(x)\n        return cls()\nassert A.f(1) == A().f(1) == 2\nA.g(5)\n"
        "assert A.made == [5]",
        "class A:\n    kind = None\nassert A().kind is None and not hasattr(A(), 'other')",
        "x = 1\nclass A:\n    x = 2\n    def f(self):\n        return x\nassert A().f() == 1",
        "from dataclasses import dataclass, field\n@dataclass\nclass A:\n    x: float\n    y: int = 2\n"
        "    z: list = field(default_factory=list)\n    def __post_init__(self):\n        self.z.append(self.x)\n"
        "a, b = A(1), A(3, y=4)\nassert (a.x, a.y, a.z) == (1, 2, [1]) and (b.y, b.z) == (4, [3])",
        "from dataclasses import dataclass\n@dataclass(order=True)\nclass A:\n    x: int\n@dataclass\nclass B(A):\n"
        "    y: int = 1\nassert B(2).x == 2 and B(2).y == 1",
        "from enum import Enum, auto\nclass K(Enum):\n    CAR = 5\n    BUS = auto()\nsizes = {K.CAR: 4, K.BUS: 12}\n"
        "assert sizes[K.CAR] == 4 and K(5) is K.CAR and K.BUS.value == 6 and K['BUS'] is K.BUS and [k.name for k "
        "in K] == ['CAR', 'BUS']",
        "from typing import NamedTuple\nclass P(NamedTuple):\n    x: int\n    y: int = 2\na, b = P(1)\n"
        "assert (a, b) == (1, 2)",
        "from dataclasses import dataclass\n@dataclass(frozen=True)\nclass A:\n    x: int\n    y: tuple = ()\n"
        "@dataclass(frozen=True)\nclass B(A):\n    pass\n"
        "assert A(1) == A(1) and A(1) != A(2) and A(1) != B(1) and A(1) in [A(1)] and A(1) != 1",
        "from dataclasses import dataclass\n@dataclass(frozen=True)\nclass A:\n    x: int\n"
        "assert {A(1): 5}[A(1)] == 5 and len({A(1), A(1), A(2)}) == 2",
        "from collections import namedtuple\nP = namedtuple('P', 'x y')\n"
        "assert P(1, 2) == P(1, 2) == (1, 2) and (1, 2) == P(1, 2) and P(1, 2) != P(2, 1)\n"
        "assert {P(1, 2): 5}[P(1, 2)] == 5 and {P(1, 2): 5}[(1, 2)] == 5",
        "from enum import IntEnum, Enum\nclass E(IntEnum):\n    A = 1\nclass F(Enum):\n    A = 1\n"
        "assert E.A == 1 and 1 == E.A and F.A != 1 and f'{E.A}' == '1' and str(F.A) == 'F.A'",
        "class A:\n    def __str__(self):\n        return 'Tree_1'\n    def __repr__(self):\n        return 'A()'\n"
        "assert f'{A()}' == str(A()) == 'Tree_1' and '%s' % A() == 'Tree_1' and repr(A()) == f'{A()!r}' == 'A()'\n"
        "assert str([A()]) == '[A()]'",
        "class A:\n    def __repr__(self):\n        return 'A()'\nclass B(A):\n    pass\nassert str(B()) == 'A()'",
        "class A:\n    pass\na, b = A(), A()\nassert a == a and a != b and a in [b, a] and len({a: 1, b: 2}) == 2",
    ],
)
def test_they_are_what_python_makes_of_them(script: str) -> None:
    agrees(script)


@pytest.mark.parametrize(
    ("script", "said", "line"),
    [
        ("class A:\n    def __getattr__(self, name):\n        return 1", "the name '__getattr__' cannot be set", 2),
        ("class A(dict):\n    pass", "a class derived from a function is not supported", 1),
        ("class A:\n    pass\nA(1)", "the class A takes no arguments", 3),
        ("class A:\n    pass\nA().x", "an instance of the class A has no 'x'", 3),
        (
            "class A:\n    @property\n    def x(self):\n        return 1\nA().x = 2",
            "'x' of an instance of the class A cannot",
            5,
        ),
        ("class A:\n    pass\nA().__class__ = A", "'__class__' of an instance of the class A cannot be set", 3),
        ("class A:\n    pass\nfor i in range(20):\n    class A(A):\n        pass", "derived from more than 16", 4),
        (
            "from dataclasses import dataclass\n@dataclass\nclass A:\n    x: int\nA()",
            "the class A is not given 'x'",
            5,
        ),
        ("from dataclasses import dataclass\n@dataclass\nclass A:\n    x: int\nA(1, 2)", "other arguments than x", 5),
        ("from enum import Enum\nclass K(Enum):\n    A = 1\nK(2)", "the class K has no such member", 4),
        (
            "class A:\n    def __str__(self):\n        return 1\nstr(A())",
            "what __str__ gives is 1; it must be a text",
            4,
        ),
        ("class A:\n    def __str__(self):\n        return str(self)\nstr(A())", "nested", 3),
        ("super().f()", r"super\(\) outside of a method", 1),
    ],
)
def test_what_they_refuse(script: str, said: str, line: int) -> None:
    refuses(script, said, line)
