import pytest
from script_reading import agrees, refuses


@pytest.mark.parametrize(
    "script",
    [
        "a = [1, *range(2), 3]\nassert a == [1, 0, 1, 3] and (*a, 4)[-1] == 4",
        "d = {'a': 1, **{'b': 2}, 3: (4,)}\nassert d['b'] == 2 and d[3] == (4,) and list(d) == ['a', 'b', 3]",
        "assert [x * y for x in range(3) if x for y in range(x)] == [0, 0, 2]",
        "assert [[i, j] for i, j in zip('ab', 'cd')] == [['a', 'c'], ['b', 'd']]",
        "x = 5\ny = [x for x in range(3)]\nassert x == 5 and y == [0, 1, 2]",
        "assert {k: v for k, v in [('a', 1)]} == {'a': 1} and len({i % 2 for i in range(9)}) == 2",
        "assert sum(i * i for i in range(4)) == 14 and max(len(w) for w in 'a bc'.split()) == 2",
        "n, w = 3.14159, 8\nassert f'{n:.2f}|{n:>{w}.1f}|{n!r}|{{}}|{w:03d}' == '3.14|     3.1|3.14159|{}|008'",
        "f = lambda a, b=2, *c, d=4, **e: (a, b, c, d, e)\nassert f(1) == (1, 2, (), 4, {})",
        "f = lambda a, b=2, *c, d=4, **e: (a, b, c, d, e)\n"
        "assert f(1, 3, 5, 6, d=7, g=8) == (1, 3, (5, 6), 7, {'g': 8})",
        "fs = [lambda x, k=k: x + k for k in range(3)]\nassert [f(10) for f in fs] == [10, 11, 12]",
    ],
)
def test_they_hold_what_pythons_do(script: str) -> None:
    agrees(script)


def test_what_cannot_be_a_key() -> None:
    refuses("x = 1\ny = {[1]: 2}", "a list cannot be a key", 2)
    refuses("{**[1]}", "1 cannot be looped over")
