import pytest
from script_reading import agrees, refuses


@pytest.mark.parametrize(
    "script",
    [
        "try:\n    x = {}['a']\nexcept KeyError:\n    x = 1\nassert x == 1",
        "try:\n    x = [][3]\nexcept (KeyError, LookupError) as error:\n    x = 2\nassert x == 2",
        "x = []\ntry:\n    x.append(1)\nexcept:\n    x.append(2)\nelse:\n    x.append(3)\nfinally:\n"
        "    x.append(4)\nassert x == [1, 3, 4]",
        "def f():\n    raise ValueError('no')\ntry:\n    f()\nexcept ValueError:\n    x = 3\nassert x == 3",
        "def f(n):\n    if n == 0:\n        raise KeyError\n    f(n - 1)\nfor k in range(20):\n    try:\n"
        "        f(3)\n    except Exception:\n        pass",
        "try:\n    assert False\nexcept AssertionError:\n    x = 1\nassert x == 1",
        "try:\n    next(iter([]))\nexcept StopIteration:\n    x = 1\nassert x == 1",
        "def f():\n    try:\n        return 1\n    finally:\n        x = 2\nassert f() == 1",
        "x = []\ntry:\n    try:\n        raise KeyError\n    finally:\n        x.append(1)\nexcept KeyError:\n"
        "    x.append(2)\nassert x == [1, 2]",
        "try:\n    x = 1 / 0\nexcept ZeroDivisionError as e:\n    x = str(e)\nassert x == 'division by zero'",
        "try:\n    x = 1 % 0\nexcept ArithmeticError:\n    x = 1\nassert x == 1",
        "try:\n    x = int('a')\nexcept (ValueError, TypeError):\n    x = 1\nassert x == 1",
        "try:\n    [].pop()\nexcept IndexError:\n    x = 1\nassert x == 1",
        "try:\n    {}.pop('a')\nexcept KeyError:\n    x = 1\nassert x == 1",
        "try:\n    a, b = [1]\nexcept ValueError:\n    x = 1\nassert x == 1",
        "try:\n    [1].index(2)\nexcept ValueError:\n    x = 1\nassert x == 1",
        "try:\n    raise ValueError('too short: %d' % 3)\nexcept ValueError as e:\n    x = f'{e}'\n"
        "assert x == 'too short: 3'",
        "x = []\ntry:\n    try:\n        {}['a']\n    except KeyError:\n        x.append(1)\n        raise\n"
        "except KeyError:\n    x.append(2)\nassert x == [1, 2]",
    ],
)
def test_what_python_catches_is_caught(script: str) -> None:
    agrees(script)


@pytest.mark.parametrize(
    ("script", "said", "line"),
    [
        ("try:\n    x = {}['a']\nexcept ValueError:\n    pass", "the key 'a' is not in the dict", 2),
        ("try:\n    import os\n    os.fork()\nexcept Exception:\n    pass", "os.fork is not supported", 3),
        ("try:\n    while True:\n        pass\nexcept:\n    pass", "more than 1[57]", 3),
        ("try:\n    x = 1\nfinally:\n    raise ValueError", "the script ends itself here", 4),
        ("x = 1\nraise ValueError('the street is too short')", "ValueError: 'the street is too short'", 2),
        ("def f(x):\n    pass\ntry:\n    f()\nexcept TypeError:\n    pass", "is not given 'x'", 4),
        ("raise", "the script ends itself here", 1),
    ],
)
def test_what_is_not_read_or_too_much_is_not_caught(script: str, said: str, line: int) -> None:
    refuses(script, said, line)
