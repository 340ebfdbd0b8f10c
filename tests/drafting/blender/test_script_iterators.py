import pytest
from script_reading import agrees, refuses

_PLACED = "at = []\ndef placed():\n    for k in range(3):\n        at.append(0)\n        yield k\n"


@pytest.mark.parametrize(
    "script",
    [
        "g = (x * x for x in range(4))\nassert next(g) == 0 and next(g) == 1 and list(g) == [4, 9] and list(g) == []",
        "assert next((x for x in [1, 2, 3] if x > 1), None) == 2 and next((x for x in [] if x), 'none') == 'none'",
        "i = iter([1, 2])\nassert next(i) == 1 and sum(i) == 2",
        "assert sorted(x for x in (3, 1, 2)) == [1, 2, 3] and ''.join(c for c in 'ab') == 'ab'",
        "i = iter([1, 2, 3, 4])\nassert list(zip(i, i)) == [(1, 2), (3, 4)]",
        "i = iter([1, 2, 3])\nassert list(zip(range(2), i)) == [(0, 1), (1, 2)] and list(i) == [3]",
        "from itertools import islice\ni = iter(range(9))\n"
        "assert list(islice(i, 2)) == [0, 1] and list(islice(i, 1, 4, 2)) == [3, 5] and next(i) == 6",
        # what is made between two values is seen
        f"{_PLACED}for i, _ in enumerate(placed()):\n    at[-1] = 10 * i\nassert at == [0, 10, 20]",
        f"{_PLACED}for i in (at[-1] for _ in placed()):\n    at[-1] = i + 1\nassert at == [1, 1, 1]",
        f"{_PLACED}for k in map(lambda k: k * 10, placed()):\n    at[-1] = k\nassert at == [0, 10, 20]",
        f"{_PLACED}for k in filter(lambda k: k != 1, placed()):\n    at[-1] = k + 5\nassert at == [5, 0, 7]",
        f"{_PLACED}for k, x in zip(placed(), range(10**6)):\n    at[-1] = x\nassert at == [0, 1, 2]",
        # as many values as are asked for
        "def f():\n    while True:\n        yield 1\nfor i, _ in enumerate(f(), 3):\n    if i > 5:\n        break\n"
        "assert i == 6 and any(x for x in f()) and not all(x - 1 for x in f())",
        "from itertools import count\ndef f():\n    yield 1\n    yield 2\n"
        "assert list(zip(count(), f())) == [(0, 1), (1, 2)]\n"
        "assert list(zip([1, 2], f(), strict=True)) == [(1, 1), (2, 2)]\n"
        "try:\n    list(zip([1], f(), strict=True))\n    assert False\nexcept ValueError:\n    pass",
        "a = [1, 2]\ng = (x for x in a)\na = [3]\nassert list(g) == [1, 2]",
        "made = []\ng = (made.append(x) for x in range(3))\nassert made == []\nnext(g)\nassert made == [0]",
        "i = iter([1, 2, 3, 4])\nfor x in i:\n    if x == 2:\n        break\nassert [x for x in i] == [3, 4]",
    ],
)
def test_values_are_handed_out_once(script: str) -> None:
    agrees(script)


def test_what_they_refuse() -> None:
    refuses("len(iter([1]))", "an iterator has no length")
    refuses("from itertools import islice\nislice([1], -1)", "a bound of islice is -1; it must be 0 or more", 2)
    refuses("next([1])", "a list is no iterator")
    refuses("next(x for x in [])", "there is no value left")
    refuses("from itertools import count\nx, y = count()", "more than 175000 steps", 2)
    refuses(
        "def f():\n    for x in g:\n        pass\n    yield 1\nm = map(abs, f())\ng = m\nlist(m)",
        "goes on with itself",
        2,
    )
    refuses("g = [1]\nfor _ in range(200):\n    g = (x for x in g)\nlist(g)", "nested more than 150", 4)
    refuses("g = (x for x in [1])\nfor _ in range(200):\n    g = enumerate(g)\nnext(g)", "more than 150 levels deep", 4)
    refuses("g = (x for x in [1])\ng.gi_frame", "an iterator has no 'gi_frame'", 2)
