import pytest
from script_reading import agrees, refuses


@pytest.mark.parametrize(
    "script",
    [
        "assert int('12') == 12 and int(3.9) == 3 and int('ff', 16) == 255",
        "assert float('1e3') == 1000.0 and bool([]) is False",
        "assert abs(-2) == 2 and round(2.675, 2) == 2.67 and round(7, -1) == 10 and pow(2, 5) == 32 and "
        "divmod(7, 2) == (3, 1)",
        "assert list(range(5, 0, -2)) == [5, 3, 1] and len(range(10)) == 10 and range(10)[3] == 3",
        "assert str(1.5) == '1.5' and repr('a') == \"'a'\" and str([1, 'a', (2,)]) == \"[1, 'a', (2,)]\"",
        "assert isinstance(1, int) and isinstance('a', (int, str)) and not isinstance([], dict)",
        "assert len('abc') == 3 and tuple([1, 2]) == (1, 2) and dict(a=1) == {'a': 1} and dict([('a', 1)]) == {'a': 1}",
        "assert list(enumerate('ab', 1)) == [(1, 'a'), (2, 'b')] and list(zip([1, 2], 'ab')) == [(1, 'a'), (2, 'b')]",
        "assert list(reversed([1, 2])) == [2, 1] and any([0, 1]) and all([]) and sum([1, 2.5], 1) == 4.5",
        "assert min(3, 1, 2) == 1 and max([1, 5], key=lambda x: -x) == 1 and max([], default=0) == 0",
        "assert sorted([(1, 'b'), (1, 'a')]) == [(1, 'a'), (1, 'b')] and sorted('bca') == ['a', 'b', 'c']",
        "assert list(map(lambda a, b: a + b, [1, 2], [3, 4])) == [4, 6] and "
        "list(map(float, '1 2'.split())) == [1.0, 2.0]",
        "assert list(filter(None, [0, 1, 2])) == [1, 2] and list(filter(lambda x: x > 1, [0, 1, 2])) == [2]",
        "assert len(set([1, 1, 2])) == 2 and 1 in {1, 2}",
        "assert print('x', end='') is None",
        "class A:\n    x = 1\n    def f(self):\n        return 2\n"
        "assert getattr(A(), 'x') == 1 and getattr(A(), 'f')() == 2 and getattr(A(), 'y', 3) == 3",
        "assert getattr('ab', 'upper')() == 'AB'",
    ],
)
def test_they_give_what_pythons_do(script: str) -> None:
    agrees(script)


@pytest.mark.parametrize(
    ("script", "said"),
    [
        ("len(5)", "5 has no length"),
        ("int('x')", "int: invalid literal"),
        ("float([])", "a list is no number"),
        ("sum(['a'])", "sum: only numbers"),
        ("sorted([1, 'a'])", "values without an order are compared"),
        ("range(1.5)", "a bound of a range is 1.5; it must be a whole number"),
        ("min()", "min: "),
        ("list(zip([1], [1, 2], strict=True))", "is longer than argument 1"),
        ("dict(1)", "1 cannot be looped over"),
        ("getattr(1, 'a')", "1 has no 'a' that is supported"),
    ],
)
def test_wrong_arguments_are_named(script: str, said: str) -> None:
    refuses(script, said)
