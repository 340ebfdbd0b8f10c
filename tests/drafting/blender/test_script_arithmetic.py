import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from script_reading import agrees, reads, refuses

NUMBERS = st.one_of(st.integers(-(2**40), 2**40), st.floats(-1e6, 1e6), st.booleans())


@settings(deadline=None)
@given(NUMBERS, st.sampled_from(["+", "-", "*", "/", "//", "%"]), NUMBERS)
def test_numbers_are_calculated_as_python_does(left: float, operator: str, right: float) -> None:
    text = f"{left!r} {operator} {right!r}"
    try:
        expected = eval(text)
    except ZeroDivisionError as error:
        refuses(text, str(error))
        return
    if isinstance(expected, int) and abs(expected) > 2**63:
        refuses(text, "more than 63 bits")
    else:
        reads(f"assert repr({text}) == {repr(expected)!r}")


@pytest.mark.parametrize(
    "script",
    [
        "assert 2 ** 10 == 1024 and 2 ** -1 == 0.5 and 7 & 3 | 8 ^ 1 == 11 or True",
        "assert 1 << 5 == 32 and -33 >> 2 == -9 and ~5 == -6 and +True == 1 and not 0",
        "assert 'ab' + 'c' == 'abc' and 2 * 'ab' == 'abab' and [1] * 3 == [1, 1, 1] and (1,) + (2,) == (1, 2)",
        "assert 1 < 2 <= 2 < 3 and not 1 < 2 > 2 and 'a' < 'b' and (1, 2) < (1, 3)",
        "assert [1, [2, 3]] == [1, [2, 3]] and {'a': [1]} == {'a': [1]} and [1] != (1,) and 1 == 1.0 == True",
        "assert 2 in [1, 2] and 'b' in 'abc' and 3 in range(5) and 2.5 not in range(5) and 'a' in {'a': 1}",
        "assert [1] in [[1], [2]] and (1, 2) not in [(2, 1)] and None is None and [] is not []",
        "a = b = []\nassert a is b\na += [1]\nassert b == [1]\na = a + [2]\nassert b == [1]",
    ],
)
def test_values_are_what_python_makes_of_them(script: str) -> None:
    agrees(script)


@pytest.mark.parametrize(
    ("script", "said"),
    [
        ("1 + 'a'", "1 . 'a' is not supported"),
        ("[1] - [2]", "a list - a list is not supported"),
        ("-'a'", "'a' cannot have this sign"),
        ("1 < 'a'", "1 and 'a' have no order"),
        ("1 in 2", "nothing can be in 2"),
        ("2 ** 65", "2 \\*\\* 65 is too large"),
        ("(-1) ** 0.5", "a complex number"),
    ],
)
def test_what_cannot_be_calculated(script: str, said: str) -> None:
    refuses(script, said)
