import pytest
from script_reading import refuses


@pytest.mark.parametrize(
    ("script", "said", "line"),
    [
        ("x = 1\nclass A(metaclass=x):\n    pass", "a class with a metaclass", 2),
        ("class A:\n    pass\nclass B(A, A):\n    pass", "derived from several", 3),
        ("class A(1):\n    pass", "a class derived from 1 is not read", 1),
        ("with 1:\n    pass", "`with` of 1 is not read", 1),
        ("def d(f):\n    return f\n@d\nclass A:\n    pass", "a function of the script as a decorator is not read", 3),
    ],
)
def test_what_they_refuse(script: str, said: str, line: int) -> None:
    refuses(script, said, line)
