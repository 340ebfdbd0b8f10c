import pytest
from script_reading import agrees, refuses

from lidardraft.drafting.blender.script.limits import Limits, RefusalError, Script
from lidardraft.drafting.blender.script.values import (
    Builtin,
    Namespace,
    Record,
    checked,
    describe,
    elements,
    length,
    real,
    reals,
)


def test_a_record_has_nothing_of_its_own() -> None:
    record = Record()
    for use in (
        lambda: record.attribute("x"),
        lambda: record.set_attribute("x", 1),
        lambda: record.item(0),
        lambda: record.set_item(0, 1),
        record.elements,
        record.negative,
        lambda: record.call([], {}),
    ):
        with pytest.raises(RefusalError, match="a value"):
            use()
    assert record.truth()
    assert record.equals(record)
    assert not record.equals(Record())


def test_what_python_says_of_wrong_arguments_is_passed_on() -> None:
    double = Builtin("double", lambda x: 2 * x)
    assert double.call([4], {}) == 8
    with pytest.raises(RefusalError, match=r"^double\(\) does not take the arguments \(\)"):
        double.call([], {})
    with pytest.raises(RefusalError, match=r"math\.tau is not supported"):
        Namespace("math", {"pi": 3}).attribute("tau")


def test_numbers_are_finite_and_not_too_large() -> None:
    assert real(True, "x") == 1.0
    assert reals([1, 2.5], 2, "x") == (1.0, 2.5)
    for bad in (float("nan"), float("inf"), 1e301, "1", None):
        with pytest.raises(RefusalError, match=r"x is .*; it must be a finite number"):
            real(bad, "x")
    for bad in ([1], [1, 2, 3], "ab", 5):
        with pytest.raises(RefusalError, match=r"x is .*; it must be 2 numbers"):
            reals(bad, 2, "x")
    assert checked(2**63) == 2**63
    with pytest.raises(RefusalError, match="more than 63 bits"):
        checked(2**63 + 1)


def test_lengths_and_elements() -> None:
    budget = Script(Limits(length=5))
    assert elements("ab", budget) == ["a", "b"]
    assert elements({"a": 1}, budget) == ["a"]
    assert length(range(3)) == 3
    with pytest.raises(RefusalError, match="a range without end"):
        length(range(-(2**63), 2**63))
    with pytest.raises(RefusalError, match="a value of 6 elements; 5 are the most"):
        elements(range(6), budget)
    assert describe("a" * 100) == repr("a" * 40)


def test_types_in_brackets_and_unions_of_types() -> None:
    agrees(
        "from typing import Union\nPoint = tuple[float, float]\nTable = dict[str, list[Point]]\n"
        "Number = Union[int, float]\n"
        "def f(a: Number, b: Table = None) -> Point:\n    return (a, a)\nassert f(1) == (1, 1)\n"
        "assert isinstance(1.5, int | float) and not isinstance('a', int | float) and list((1, 2)) == [1, 2]"
    )
    agrees(
        "class A:\n    pass\nNumber = int | float | None\nMany = None | str | (A | Number)\n"
        "assert isinstance(None, Number) and isinstance(1, Number) and not isinstance('a', Number)\n"
        "assert isinstance(A(), Many) and isinstance(2.5, Many) and isinstance(A(), (str, Number, A | None))\n"
        "assert not isinstance([], Many) and not isinstance(A(), (Number, list))"
    )
    refuses("x = int | 5", "a function . 5 is not supported")
    refuses("k = int\nwhile True:\n    k = k | int", "a union of 51 types; 50 are the most", 3)
    refuses("x = int + float", "a function . a function is not supported")
