import pytest
from script_reading import agrees, reads, refuses

from lidardraft.drafting.blender.script.limits import Limits


@pytest.mark.parametrize(
    "script",
    [
        "x = [1, 2, 3, 4]\nassert x[0] == 1 and x[-1] == 4 and x[1:3] == [2, 3] and "
        "x[::-1] == [4, 3, 2, 1] and 'abc'[1] == 'b'",
        "d = {'a': [1, {'b': 2}]}\nassert d['a'][1]['b'] == 2",
        "assert (1 if [] else 2) == 2 and (0 or 'x') == 'x' and (1 and 0) == 0",
        "def f(a, *b, c=1, **d):\n    return a, b, c, d\n"
        "assert f(*[1, 2], **{'c': 3, 'e': 4}) == (1, (2,), 3, {'e': 4})",
        "assert (lambda x: x * 2)(4) == 8 and 'a,b'.split(',')[1].upper() == 'B'",
    ],
)
def test_their_values_are_pythons(script: str) -> None:
    agrees(script)


@pytest.mark.parametrize(
    ("script", "said", "line"),
    [
        ("x = [\n  1,\n  unknown,\n]", "the name 'unknown' is not known", 3),
        ("x = dict(\n  a=1,\n  b=2 + (\n    1 / 0),\n)", "division by zero", 4),
        ("[1, 2][5]", "a list of 2 has no place 5", 1),
        ("{'a': 1}['b']", "the key 'b' is not in the dict", 1),
        ("[1][0.5]", "a place is 0.5; it must be a whole number", 1),
        ("'abc'[::0]", "the step of a slice is 0", 1),
        ("(5)()", "5 cannot be called", 1),
        ("x = 3\nx.y", "3 has no 'y' that is supported", 2),
        ("def f(a):\n    pass\nf()", r"f\(\) is not given 'a'", 3),
        ("def f(a):\n    pass\nf(1, 2)", r"f\(\) takes 1 arguments; it is given 2", 3),
        ("def f(a):\n    pass\nf(1, a=2)", r"f\(\) is given 'a' twice", 3),
        ("def f(a):\n    pass\nf(1, b=2)", r"f\(\) has no argument 'b'", 3),
        ("len(**[1])", r"a list behind \*\* is no dict", 1),
        ("b'bytes'", "` is not supported in a script", 1),
        ("1j", "` is not supported in a script", 1),
    ],
)
def test_the_innermost_line_is_named(script: str, said: str, line: int) -> None:
    refuses(script, said, line)


def test_nesting_and_calls_share_one_limit() -> None:
    reads("((((1))))", Limits(levels=3))
    refuses("x = 1\ny = -(-(-(-(-1))))", "nested more than 5 levels deep", 2, Limits(levels=5))
    recursion = "def f(n):\n    return n and f(n - 1)\nf(%d)"
    reads(recursion % 10)
    refuses(recursion % 1000, "nested more than 150 levels deep", 2)
