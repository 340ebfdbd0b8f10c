import pytest
from script_reading import agrees, refuses


@pytest.mark.parametrize(
    "script",
    [
        "x = 1\ndef f():\n    x = 2\n    return x\nassert f() == 2 and x == 1",
        "x = 1\ndef f():\n    global x\n    x = 2\nf()\nassert x == 2",
        "def f():\n    n = 0\n    def g():\n        nonlocal n\n        n += 1\n        return n\n    g()\n"
        "    return g()\nassert f() == 2",
        "def f():\n    return later()\ndef later():\n    return 3\nassert f() == 3",
        "len = 5\nassert len == 5",
        "def f(a, /, b, *, c=3):\n    return a + b + c\nassert f(1, b=2) == 6",
        "x = 1\ndel x\nx = 2\nassert x == 2",
    ],
)
def test_names_are_found_where_python_finds_them(script: str) -> None:
    agrees(script)


def test_names_that_are_not_there() -> None:
    refuses("x = 1\ndef f():\n    y = 2\nf()\ny", "the name 'y' is not known", 5)
    refuses("del x", "the name 'x' is not known")
    refuses("def f():\n    nonlocal x\nf()", "no function around this one has the name 'x'", 2)
    refuses("__x__ = 1", "the name '__x__' cannot be set")
