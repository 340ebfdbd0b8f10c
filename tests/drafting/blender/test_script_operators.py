import pytest
from script_reading import agrees, refuses


@pytest.mark.parametrize(
    "script",
    [
        "x = 3\nassert 1 < x <= 3 != 4 and not x > 5 and (x if x else 0) == 3 and -x == ~x + 1",
        "assert (0 or '' or 'a') == 'a' and (1 and [] and x) == []",
        "assert {'a': 1, 'b': 2} | {'a': 3} == {'a': 3, 'b': 2}",
        "assert 'Car.001'.rsplit('.', 1) == ['Car', '001'] and 'a b c'.split(maxsplit=1) == ['a', 'b c']",
        "import math\nassert math.isqrt(17) == 4 and math.modf(1.5) == (0.5, 1.0)",
        "calls = []\ndef f(x):\n    calls.append(x)\n    return x\nassert not f(1) > f(2) > f(3) and calls == [1, 2]",
    ],
)
def test_they_give_what_python_gives(script: str) -> None:
    agrees(script)


def test_what_they_refuse() -> None:
    refuses("x = 1\ny = 'a' + x", "'a' . 1 is not supported", 2)
    refuses("from collections import Counter\nCounter('a') | Counter('b')", "a Counter . a Counter is not supported", 2)
    refuses("x = 1\ny = 1 if x < 'a' else 2", "1 and 'a' have no order", 2)
