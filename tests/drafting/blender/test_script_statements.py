import pytest
from script_reading import agrees, reads, refuses


@pytest.mark.parametrize(
    "script",
    [
        "a, (b, *c), d = 1, (2, 3, 4), 5\nassert (a, b, c, d) == (1, 2, [3, 4], 5)\n*e, f = [1]\n"
        "assert e == [] and f == 1",
        "x = y = [0, 0]\nx[1] = 5\ny[0:1] = [7, 8]\nassert x == [7, 8, 5]\ndel x[0], x[-1]\nassert x == [8]",
        "x: int = 3\ny: int\nx += 2\nx -= 1\nx *= 3\nx //= 2\nassert x == 6",
        "d = {'a': 1}\nd['a'] += 4\nd['b'] = 2\ndel d['a']\nassert d == {'b': 2}",
        "t = 0\nfor i in range(10):\n    if i == 2:\n        continue\n    if i == 5:\n        break\n"
        "    t += i\nelse:\n    t = -1\nassert t == 8",
        "t = 0\nfor i in []:\n    pass\nelse:\n    t = 1\nassert t == 1",
        "n = 0\nwhile n < 5:\n    n += 1\nelse:\n    n = 9\nassert n == 9",
        "def f(x):\n    for i in range(9):\n        while True:\n            if i == x:\n"
        "                return i\n            break\nassert f(3) == 3 and f(99) is None",
        "def f():\n    try:\n        return 1\n    finally:\n        pass\nassert f() == 1",
        "log = []\ntry:\n    log.append(1)\nexcept ValueError:\n    log.append(2)\nelse:\n"
        "    log.append(3)\nfinally:\n    log.append(4)\nassert log == [1, 3, 4]",
        "a = [1, 2]\nfor x in a:\n    if len(a) < 5:\n        a.append(x)\nassert a == [1, 2, 1, 2, 1]",
        "pass\n'text alone'\n1",
    ],
)
def test_they_do_what_pythons_do(script: str) -> None:
    agrees(script)


@pytest.mark.parametrize(
    ("script", "said", "line"),
    [
        ("a, b = 1, 2, 3", "3 values for 2 names", 1),
        ("*a, b = []", "0 values for 2 names", 1),
        ("x = 5\nx.y = 1", "the attribute 'y' of 5 cannot be set", 2),
        ("x = (1, 2)\nx[0] = 1", "a tuple has no place 0 that can be set", 2),
        ("x = [1]\nx[3] = 1", "a list has no place 3 that can be set", 2),
        ("x = [1, 2, 3]\nx[::2] = [1]", "a list has no place", 2),
        ("for x in 5:\n    pass", "5 cannot be looped over", 1),
        ("del x.y", "`del x.y` is not supported", 1),
        ("x = {}\ndel x['a']", "a dict has no place 'a'", 2),
        ("assert 1 == 2", "what the script asserts is not so", 1),
        ("x = 1\nraise ValueError('x')", "the script ends itself here", 2),
        ("def f():\n    return 1 / 0\nx = 1\nf()", "division by zero", 2),
    ],
)
def test_what_they_refuse(script: str, said: str, line: int) -> None:
    refuses(script, said, line)


def test_what_is_never_reached_is_not_refused() -> None:
    reads("def never():\n    import os\n    with open('a') as f:\n        yield f\nif 0:\n    class A: pass")
