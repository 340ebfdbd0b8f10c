"""Values of scripts: numbers, texts, lists, dicts, sets, iterators, what is calculated with them, their functions."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from script_reading import agrees, reads, refuses

from lidardraft.drafting.blender.script.limits import Limits

NUMBERS = st.one_of(st.integers(-(2**40), 2**40), st.floats(-1e6, 1e6), st.booleans())
_PLACED = "at = []\ndef placed():\n    for k in range(3):\n        at.append(0)\n        yield k\n"
AGREED: list[str] = [
    # what stands before += is looked up once, and what can change does
    "assert 1 < 2 <= 2 < 3 and not 1 < 3 < 2 and not 1 < 2 > 2 and 'a' < 'b' and (1, 2) < (1, 3)",
    "x = 3\nassert 1 < x <= 3 != 4 and not x > 5 and (x if x else 0) == 3 and -x == ~x + 1",
    "x = 5\ny = [x for x in range(3)]\nassert x == 5 and y == [0, 1, 2]",
    "assert {k: v for k, v in [('a', 1)]} == {'a': 1} and len({i % 2 for i in range(9)}) == 2",
    "assert 2 ** 10 == 1024 and 2 ** -1 == 0.5 and 7 & 3 | 8 ^ 1 == 11 or True",
    "assert 1 << 5 == 32 and -33 >> 2 == -9 and ~5 == -6 and +True == 1 and not 0",
    "made = []\nx = [1, 2]\ndef f():\n    made.append(1)\n    return 0\nx[f()] += 5\n"
    "assert x == [6, 2] and made == [1]",
    "a = b = [1, 2]\na *= 2\na += (3,)\nassert b == [1, 2, 1, 2, 3]\na = a * 2\nassert len(b) == 5",
    "s = t = {1}\ns |= {2}\ns -= {1}\nassert t == {2}\nd = e = {'a': 1}\nd |= {'b': 2}\nassert e == {'a': 1, 'b': 2}",
    "x = (1, [2])\ny = x[1]\ny += [3]\nassert x == (1, [2, 3])\nt = u = (1,)\nt += (2,)\nassert u == (1,)",
    # a list that changes while it is gone through
    "a, b = [1, 2, 3], []\nfor k, x in enumerate(a):\n    if k < 4:\n        a.append(x)\n"
    "    b.append(x)\nassert len(b) == 7",
    "a = [1, 2, 3]\nfor x, y in zip(a, 'abc'):\n    a.pop()\nassert a == [1]",
    "x = [1]\ntry:\n    x[3] = 1\nexcept IndexError:\n    x.append(2)\ntry:\n    del x[9]\n"
    "except IndexError:\n    pass",
    "assert 2 in [1, 2] and 'b' in 'abc' and 3 in range(5) and 2.5 not in range(5) and 'a' in {'a': 1}",
    "assert [1] in [[1], [2]] and (1, 2) not in [(2, 1)] and None is None and [] is not []",
    "assert {'a': 1, 'b': 2} | {'a': 3} == {'a': 3, 'b': 2}",
    "assert 'Car.001'.rsplit('.', 1) == ['Car', '001'] and 'a b c'.split(maxsplit=1) == ['a', 'b c']",
    "import math\nassert math.isqrt(17) == 4 and math.modf(1.5) == (0.5, 1.0)",
    "calls = []\ndef f(x):\n    calls.append(x)\n    return x\nassert not f(1) > f(2) > f(3) and calls == [1, 2]",
    "a = [1, *range(2), 3]\nassert a == [1, 0, 1, 3] and (*a, 4)[-1] == 4",
    "d = {'a': 1, **{'b': 2}, 3: (4,)}\nassert d['b'] == 2 and d[3] == (4,) and list(d) == ['a', 'b', 3]",
    "assert [x * y for x in range(3) if x for y in range(x)] == [0, 0, 2]",
    "assert [[i, j] for i, j in zip('ab', 'cd')] == [['a', 'c'], ['b', 'd']]",
    "n, w = 3.14159, 8\nassert f'{n:.2f}|{n:>{w}.1f}|{n!r}|{{}}|{w:03d}' == '3.14|     3.1|3.14159|{}|008'",
    "f = lambda a, b=2, *c, d=4, **e: (a, b, c, d, e)\nassert f(1) == (1, 2, (), 4, {})",
    "f = lambda a, b=2, *c, d=4, **e: (a, b, c, d, e)\nassert f(1, 3, 5, 6, d=7, g=8) == (1, 3, (5, 6), 7, {'g': 8})",
    "fs = [lambda x, k=k: x + k for k in range(3)]\nassert [f(10) for f in fs] == [10, 11, 12]",
    # text is what python makes
    "assert '%s is %5.2f and %03d%%' % ('x', 1.005, 7) == 'x is  1.00 and 007%'",
    "assert '%r %x' % ('a', 255) == \"'a' ff\" and '%s' % [1] == '[1]'",
    "assert '{} {1}'.replace('{1}', '{}').format(1, 'b') == '1 b' and "
    "'{0:>4}|{name:.1f}'.format(1, name=2.0) == '   1|2.0'",
    "assert f'{12345:,} {0.5:%} {3:b} {\"x\":*^5}' == '12,345 50.000000% 11 **x**'",
    "assert str({'a': (1,), 2: None}) == \"{'a': (1,), 2: None}\" and f'{[1, True]}' == '[1, True]'",
    "assert ' Ab '.strip().lower() == 'ab' and 'a-b'.title() == 'A-B' and 'x'.isalpha() and '7'.isdigit()",
    "assert 'abcabc'.find('c', 3) == 5 and 'aab'.count('a') == 2 and 'abc'.startswith(('x', 'a'))",
    "assert 'a b  c'.split() == ['a', 'b', 'c'] and 'a,b,c'.split(',', 1) == ['a', 'b,c']",
    "assert 'a\\nb\\r\\nc\\n'.splitlines() == ['a', 'b', 'c'] and ''.splitlines() == []",
    "assert '-'.join(['a', 'b']) == 'a-b' and 'aXbX'.replace('X', '', 1) == 'abX' and '7'.zfill(3) == '007'",
    "assert 'a'.ljust(3, '.') == 'a..' and 'a'.rjust(2) == ' a' and 'a'.center(3) == ' a '",
    "x = [3, 1]\nx.append(2)\nx.extend((5, 4))\nx.insert(0, 9)\nx.remove(1)\n"
    "assert x == [9, 3, 2, 5, 4] and x.pop() == 4",
    "x = [3, 1, 2]\nx.sort(key=lambda v: -v)\nassert x == [3, 2, 1] and x.index(2) == 1 and x.count(1) == 1",
    "x = [1, 2]\ny = x.copy()\nx.reverse()\nx.clear()\nassert y == [1, 2] and x == []",
    "d = {'a': 1}\nd.update({'b': 2}, c=3)\nassert d.get('z', 0) == 0 and list(d.items())[1] == ('b', 2) and "
    "d.pop('a') == 1",
    "d = {}\nd.setdefault('a', []).append(1)\nassert d == {'a': [1]} and list(d.keys()) == ['a'] and "
    "list(d.values()) == [[1]]",
    "assert (1, 2, 1).count(1) == 2 and (1, 2).index(2) == 1",
    "s = set()\ns.add((1, 2))\ns.add((1, 2))\nassert len(s) == 1 and (1, 2) in s and (2, 1) not in s\n"
    "assert s and not set()",
    "s = {1, 2, 3}\ns.discard(9)\ns.remove(1)\ns.update([5], (6,))\nassert sorted(s) == [2, 3, 5, 6] and sum(s) == 16",
    "s = {1, 2}\nt = s.copy()\nt.add(3)\nassert s.issubset(t) and not t.issubset(s)\n"
    "assert t.difference(s) == {3} and s.union([7], [8]) == {1, 2, 7, 8}\n"
    "assert s.isdisjoint({5}) and s.intersection([2]) == {2} and s.symmetric_difference([2, 3]) == {1, 3}",
    "try:\n    {1}.remove(2)\nexcept KeyError:\n    x = 1\n"
    "assert x == 1 and str(set()) == 'set()' and str({1}) == '{1}'",
    # values are handed out once
    "g = (x * x for x in range(4))\nassert next(g) == 0 and next(g) == 1 and list(g) == [4, 9] and list(g) == []",
    "assert next((x for x in [1, 2, 3] if x > 1), None) == 2 and next((x for x in [] if x), 'none') == 'none'",
    "assert sorted(x for x in (3, 1, 2)) == [1, 2, 3] and ''.join(c for c in 'ab') == 'ab'",
    "i = iter([1, 2, 3, 4])\nassert list(zip(i, i)) == [(1, 2), (3, 4)]",
    "i = iter([1, 2, 3])\nassert list(zip(range(2), i)) == [(0, 1), (1, 2)] and list(i) == [3]",
    "from itertools import islice\ni = iter(range(9))\n"
    "assert list(islice(i, 2)) == [0, 1] and list(islice(i, 1, 4, 2)) == [3, 5] and next(i) == 6",
    f"{_PLACED}for i, _ in enumerate(placed()):\n    at[-1] = 10 * i\nassert at == [0, 10, 20]",
    f"{_PLACED}for i in (at[-1] for _ in placed()):\n    at[-1] = i + 1\nassert at == [1, 1, 1]",
    f"{_PLACED}for k in map(lambda k: k * 10, placed()):\n    at[-1] = k\nassert at == [0, 10, 20]",
    f"{_PLACED}for k in filter(lambda k: k != 1, placed()):\n    at[-1] = k + 5\nassert at == [5, 0, 7]",
    f"{_PLACED}for k, x in zip(placed(), range(10**6)):\n    at[-1] = x\nassert at == [0, 1, 2]",
    "def f():\n    while True:\n        yield 1\nfor i, _ in enumerate(f(), 3):\n    if i > 5:\n        break\n"
    "assert i == 6 and any(x for x in f()) and not all(x - 1 for x in f())",
    "from itertools import count\ndef f():\n    yield 1\n    yield 2\n"
    "assert list(zip(count(), f())) == [(0, 1), (1, 2)]\nassert list(zip([1, 2], f(), strict=True)) == [(1, 1), (2, "
    "2)]\ntry:\n    list(zip([1], f(), strict=True))\n    assert False\nexcept ValueError:\n    pass",
    "a = [1, 2]\ng = (x for x in a)\na = [3]\nassert list(g) == [1, 2]",
    "made = []\ng = (made.append(x) for x in range(3))\nassert made == []\nnext(g)\nassert made == [0]",
    "i = iter([1, 2, 3, 4])\nfor x in i:\n    if x == 2:\n        break\nassert [x for x in i] == [3, 4]",
    "assert int('12') == 12 and int(3.9) == 3 and int('ff', 16) == 255",
    "assert float('1e3') == 1000.0 and bool([]) is False",
    "assert abs(-2) == 2 and round(2.675, 2) == 2.67 and round(7, -1) == 10 and pow(2, 5) == 32 and "
    "divmod(7, 2) == (3, 1)",
    "assert list(range(5, 0, -2)) == [5, 3, 1] and len(range(10)) == 10 and range(10)[3] == 3",
    "assert str(1.5) == '1.5' and repr('a') == \"'a'\" and str([1, 'a', (2,)]) == \"[1, 'a', (2,)]\"",
    "assert isinstance(1, int) and isinstance('a', (int, str)) and not isinstance([], dict)",
    "assert len('abc') == 3 and tuple([1, 2]) == (1, 2) and dict(a=1) == {'a': 1} and dict([('a', 1)]) == {'a': 1}",
    "assert list(map(lambda a, b: a + b, [1, 2], [3, 4])) == [4, 6] and list(map(float, '1 2'.split())) == [1.0, 2.0]",
    "assert list(filter(None, [0, 1, 2])) == [1, 2] and list(filter(lambda x: x > 1, [0, 1, 2])) == [2]",
    "assert print('x', end='') is None",
    "class A:\n    x = 1\n    def f(self):\n        return 2\n"
    "assert getattr(A(), 'x') == 1 and getattr(A(), 'f')() == 2 and getattr(A(), 'y', 3) == 3",
    "assert getattr('ab', 'upper')() == 'AB'",
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
    ("from collections import Counter\nCounter('a') | Counter('b')", "a Counter . a Counter is not supported", 2),
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
    ("f'{1:>300}'", "a width of 300 characters; 200 are the most", 1),
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
    ("len(iter([1]))", "an iterator has no length", 1),
    ("from itertools import islice\nislice([1], -1)", "a bound of islice is -1; it must be 0 or more", 2),
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
    reads("((((1))))", Limits(levels=3))
    refuses("x = 1\ny = -(-(-(-(-1))))", "nested more than 5 levels deep", 2, Limits(levels=5))
    recursion = "def f(n):\n    return n and f(n - 1)\nf(%d)"
    reads(recursion % 10)
    refuses(recursion % 1000, "nested more than 150 levels deep", 2)
