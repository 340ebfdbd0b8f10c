"""Values of scripts: numbers, texts, lists, dicts, sets, iterators, what is calculated with them, their functions."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from script_reading import agrees, reads, refuses

from lidardraft.drafting.blender.script.limits import ScriptLimits

NUMBERS = st.one_of(st.integers(-(2**40), 2**40), st.floats(-1e6, 1e6), st.booleans())
_PLACED = "at = []\ndef placed():\n    return (at.append(0) or k for k in range(3))\n"
AGREED: list[str] = [
    # a list that changes while it is gone through
    "a, b = [1, 2, 3], []\nfor k, x in enumerate(a):\n    if k < 4:\n        a.append(x)\n"
    "    b.append(x)\nassert len(b) == 7",
    "a = [1, 2, 3]\nfor x, y in zip(a, 'abc'):\n    a.pop()\nassert a == [1]",
    "x = [1]\ntry:\n    x[3] = 1\nexcept IndexError:\n    x.append(2)\ntry:\n    del x[9]\n"
    "except IndexError:\n    pass",
    "import math\nassert math.isqrt(17) == 4 and math.modf(1.5) == (0.5, 1.0)",
    "n, w = 3.14159, 8\nassert f'{n:.2f}|{n:>{w}.1f}|{n!r}|{{}}|{w:03d}' == '3.14|     3.1|3.14159|{}|008'",
    # text is what python makes
    "assert '{} {1}'.replace('{1}', '{}').format(1, 'b') == '1 b' and "
    "'{0:>4}|{name:.1f}'.format(1, name=2.0) == '   1|2.0'",
    "assert f'{12345:,} {0.5:%} {3:b} {\"x\":*^5}' == '12,345 50.000000% 11 **x**'",
    "assert 'a\\nb\\r\\nc\\n'.splitlines() == ['a', 'b', 'c'] and ''.splitlines() == []",
    # values are handed out once
    "i = iter([1, 2, 3])\nassert list(zip(range(2), i)) == [(0, 1), (1, 2)] and list(i) == [3]",
    f"{_PLACED}for i, _ in enumerate(placed()):\n    at[-1] = 10 * i\nassert at == [0, 10, 20]",
    f"{_PLACED}for i in (at[-1] for _ in placed()):\n    at[-1] = i + 1\nassert at == [1, 1, 1]",
    f"{_PLACED}for k in map(lambda k: k * 10, placed()):\n    at[-1] = k\nassert at == [0, 10, 20]",
    f"{_PLACED}for k in filter(lambda k: k != 1, placed()):\n    at[-1] = k + 5\nassert at == [5, 0, 7]",
    f"{_PLACED}for k, x in zip(placed(), range(10**6)):\n    at[-1] = x\nassert at == [0, 1, 2]",
    "from itertools import count, repeat\nfor i, _ in enumerate(repeat(1), 3):\n    if i > 5:\n        break\n"
    "assert i == 6 and any(x for x in repeat(1)) and not all(x - 1 for x in repeat(1))\n"
    "assert list(zip(count(), iter([1, 2]))) == [(0, 1), (1, 2)]\ntry:\n    list(zip([1], [1, 2], strict=True))\n"
    "    assert False\nexcept ValueError:\n    pass",
    "a = [1, 2]\ng = (x for x in a)\na = [3]\nassert list(g) == [1, 2]",
    "made = []\ng = (made.append(x) for x in range(3))\nassert made == []\nnext(g)\nassert made == [0]",
    "i = iter([1, 2, 3, 4])\nfor x in i:\n    if x == 2:\n        break\nassert [x for x in i] == [3, 4]",
    "assert len('abc') == 3 and tuple([1, 2]) == (1, 2) and dict(a=1) == {'a': 1} and dict([('a', 1)]) == {'a': 1}",
    # types in brackets and unions of types
    "from typing import Union\nPoint = tuple[float, float]\nTable = dict[str, list[Point]]\n"
    "Number = Union[int, float]\n"
    "def f(a: Number, b: Table = None) -> Point:\n    return (a, a)\nassert f(1) == (1, 1)\n"
    "assert isinstance(1.5, int | float) and not isinstance('a', int | float) and list((1, 2)) == [1, 2]",
    "class A:\n    pass\nNumber = int | float | None\nMany = None | str | (A | Number)\n"
    "assert isinstance(None, Number) and isinstance(1, Number) and not isinstance('a', Number)\n"
    "assert isinstance(A(), Many) and isinstance(2.5, Many) and isinstance(A(), (str, Number, A | None))\n"
    "assert not isinstance([], Many) and not isinstance(A(), (Number, list))",
]
REFUSED: list[tuple[str, str, int]] = [
    # what cannot be calculated
    ("1 + 'a'", "1 . 'a' is not supported", 1),
    ("[1] - [2]", "a list - a list is not supported", 1),
    ("2 ** 62 * 2 + 1", "more than 63 bits", 1),
    ("-'a'", "'a' cannot have this sign", 1),
    ("1 < 'a'", "1 and 'a' have no order", 1),
    ("x = 1\ny = 'a' + x", "'a' . 1 is not supported", 2),
    ("x = 1\ny = 1 if x < 'a' else 2", "1 and 'a' have no order", 2),
    # what cannot be a key
    ("x = 1\ny = {[1]: 2}", "a list cannot be a key", 2),
    ("{**[1]}", "1 cannot be looped over", 1),
    # the innermost line is named
    ("x = [\n  1,\n  unknown,\n]", "the name 'unknown' is not known", 3),
    ("x = dict(\n  a=1,\n  b=2 + (\n    1 / 0),\n)", "division by zero", 4),
    ("[1, 2][5]", "a list of 2 has no place 5", 1),
    ("{'a': 1}['b']", "the key 'b' is not in the dict", 1),
    # formats that are not read
    ("f'{1:>300}'", "a width of 300 characters; the limit is 200", 1),
    ("f'{1:y}'", "not supported: Unknown format code 'y'", 1),
    ("f'{\"a\":d}'", "not supported: Unknown format code 'd'", 1),
    ("f'{[]:5}'", "a list cannot be formatted as '5'", 1),
    # wrong uses are named
    ("[].pop()", "pop: pop from empty list", 1),
    ("[1].remove(2)", "2 is not in the list", 1),
    ("{}.pop('a')", "pop: 'a'", 1),
    ("{}.setdefault([])", "a list cannot be a key", 1),
    ("{[1]}", "a list cannot be a key", 1),
    ("x = 1\n{1}.add([1])", "a list cannot be a key", 2),
    ("{1}.pop()", "a set has no 'pop' that is supported", 1),
    ("{1} + {2}", "a set . a set is not supported", 1),
    ("{1} | [2]", "a set . a list is not supported", 1),
    ("len(iter([1]))", "an iterator has no length", 1),
    ("next([1])", "a list is no iterator", 1),
    ("next(x for x in [])", "there is no value left", 1),
    # wrong arguments are named
    ("len(5)", "5 has no length", 1),
    ("len(range(-(2**63), 2**63))", "a range without end", 1),
    ("int('x')", "int: invalid literal", 1),
    ("float([])", "a list is no number", 1),
    ("sum(['a'])", "sum: only numbers", 1),
    # types in brackets and unions of types
    ("x = int | 5", "a function . 5 is not supported", 1),
    ("x = int + float", "a function . a function is not supported", 1),
]


@pytest.mark.parametrize("script", AGREED)
def test_it_is_what_python_makes_of_it(script: str) -> None:
    agrees(script)


@pytest.mark.parametrize(("script", "said", "line"), REFUSED)
def test_it_is_refused(script: str, said: str, line: int) -> None:
    refuses(script, said, line)


@settings(deadline=None)
@given(NUMBERS, st.sampled_from(["+", "-", "*", "/", "//", "%"]), NUMBERS)
def test_numbers_are_calculated_as_python_does(left: float, operator: str, right: float) -> None:
    text = f"{left!r} {operator} {right!r}"
    try:
        expected = eval(text)
    except ZeroDivisionError as error:
        refuses(text, str(error))
        return
    if isinstance(expected, int) and abs(expected) > 2**63:
        refuses(text, "more than 63 bits")
    else:
        reads(f"assert repr({text}) == {repr(expected)!r}")


def test_nesting_and_calls_share_one_limit() -> None:
    reads("((((1))))", ScriptLimits(levels=3))
    refuses("x = 1\ny = -(-(-(-(-1))))", "nested more than 5 levels deep", 2, ScriptLimits(levels=5))
    recursion = "def f(n):\n    return n and f(n - 1)\nf(%d)"
    reads(recursion % 10)
    refuses(recursion % 1000, "nested more than 150 levels deep", 2)
