import pytest
from script_reading import agrees, refuses


@pytest.mark.parametrize(
    ("script", "said", "line"),
    [
        ("x = 1\nclass A(metaclass=x):\n    pass", "a class with a metaclass", 2),
        ("class A:\n    pass\nclass B(A, A):\n    pass", "derived from several", 3),
        ("class A(1):\n    pass", "a class derived from 1 is not supported", 1),
        ("with 1:\n    pass", "`with` of 1 is not supported", 1),
        (
            "def d(f):\n    return f\n@d\nclass A:\n    pass",
            "a function of the script as a decorator is not supported",
            3,
        ),
    ],
)
def test_what_they_refuse(script: str, said: str, line: int) -> None:
    refuses(script, said, line)


def test_errors_that_are_suppressed() -> None:
    agrees(
        "from contextlib import suppress\nx = []\nwith suppress(KeyError, ValueError):\n    x.append(1)\n    {}['a']\n"
        "    x.append(2)\nwith suppress(Exception):\n    raise RuntimeError('a')\nassert x == [1]\n"
        "def f():\n    with suppress(KeyError):\n        return 5\nassert f() == 5"
    )
    refuses("from contextlib import suppress\nwith suppress(KeyError):\n    [][1]", "has no place 1", 3)
    refuses("from contextlib import suppress\nwith suppress(5):\n    pass", "no class of errors", 2)
    refuses("from contextlib import suppress\nwith suppress(Exception):\n    raise SystemExit(2)", "ends itself", 3)


def test_classes_of_errors_of_the_scripts_own() -> None:
    agrees(
        "class SceneError(Exception):\n    pass\ntry:\n    raise SceneError('no road')\nexcept SceneError as e:\n"
        "    assert str(e) == 'no road'\nelse:\n    assert False"
    )
