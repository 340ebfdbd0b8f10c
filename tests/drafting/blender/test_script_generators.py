import pytest
from script_reading import agrees, refuses

_EACH_OTHER = """def first():
    yield 1
    for x in h:
        pass
    yield 2
def other():
    for x in g:
        yield x
g, h = first(), other()
next(h)
next(g)
"""


@pytest.mark.parametrize(
    "script",
    [
        "def f(n):\n    for i in range(n):\n        if i % 2:\n            yield i\n        else:\n"
        "            yield -i\n"
        "assert list(f(4)) == [0, 1, -2, 3] and sum(f(4)) == 2 and [x for x in f(2)] == [0, 1]",
        "made = []\ndef f():\n    made.append(1)\n    yield 1\n    made.append(2)\n    yield 2\n    made.append(3)\n"
        "g = f()\nassert made == []\nassert next(g) == 1 and made == [1]\nassert list(g) == [2] and made == [1, 2, 3]\n"
        "assert next(g, 'end') == 'end' and list(g) == []",
        "def f():\n    x = 0\n    while True:\n        x += 1\n        if x == 3:\n            continue\n"
        "        if x > 5:\n            break\n        yield x\n    else:\n        yield 'never'\n    yield 'last'\n"
        "assert list(f()) == [1, 2, 4, 5, 'last']",
        "def f():\n    for i in range(3):\n        yield i\n    else:\n        yield 'else'\n"
        "    return\n    yield 'never'\n"
        "assert tuple(f()) == (0, 1, 2, 'else')",
        "def f(n):\n    if n:\n        yield n\n        yield from f(n - 1)\n        yield from [n * 10]\n"
        "assert list(f(3)) == [3, 2, 1, 10, 20, 30]",
        "def count():\n    n = 0\n    while True:\n        yield n\n        n += 1\n"
        "assert list(zip(count(), 'ab')) == [(0, 'a'), (1, 'b')]\n"
        "from itertools import islice\nassert list(islice(count(), 2, 5)) == [2, 3, 4]\n"
        "for a in count():\n    if a > 3:\n        break\nassert a == 4",
        "def f(a):\n    yield from a\nassert list(zip(f([1, 2]), f([3, 4, 5]))) == [(1, 3), (2, 4)]",
        "class A:\n    def __init__(self):\n        self.x = [1, 2]\n"
        "    def each(self, k=2):\n        for x in self.x:\n"
        "            yield x * k\nassert sorted(A().each(), reverse=True) == [4, 2] and max(A().each(k=5)) == 10",
        "def f():\n    yield\n    (yield)\nassert list(f()) == [None, None]",
        "def f():\n    def g():\n        yield 1\n    return list(g())\nassert f() == [1]",
        "def f():\n    yield 1\n    raise ValueError('x')\ntry:\n    list(f())\n    assert False\nexcept ValueError:\n"
        "    pass\ng = f()\nnext(g)\ntry:\n    next(g)\nexcept ValueError:\n    pass\nassert list(g) == []",
        "def f():\n    yield 1\ntry:\n    g = f()\n    next(g)\n    next(g)\n    assert False\n"
        "except StopIteration:\n    pass",
    ],
)
def test_they_give_what_pythons_do(script: str) -> None:
    agrees(script)


@pytest.mark.parametrize(
    ("script", "said", "line"),
    [
        ("def f():\n    x = yield 1\nlist(f())", "is not supported in a script", 2),
        ("def f():\n    while True:\n        yield 1\nlist(f())", "more than 1[57]", 4),
        ("def f():\n    while True:\n        yield 1\nlist(zip(f(), f()))", "more than 1[57]", 3),
        ("def f(n):\n    yield from f(n + 1)\nlist(f(0))", "nested more than 150", 2),
        (_EACH_OTHER, "a generator that goes on with itself", 7),
        ("def f():\n    yield from g\ng = f()\nlist(g)", "a generator that goes on with itself", 2),
        ("def f():\n    yield 1\nlen(f())", "a generator has no length", 3),
        (
            "def f():\n    yield 1\nx = []\nwhile True:\n    x.append(f())",
            "more than 175000 steps",
            5,
        ),
        ("x = lambda: (yield)\nx()", "is not supported in a script", 1),
        ("def f():\n    yield 1 / 0\n\nlist(f())", "division by zero", 2),
    ],
)
def test_a_generator_that_is_not_read_or_goes_on_too_long_is_refused(script: str, said: str, line: int) -> None:
    refuses(script, said, line)
