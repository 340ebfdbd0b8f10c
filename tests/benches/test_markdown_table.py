"""A table of rows that need not have the same columns."""

import math

import pytest

from markdown_table import digits, table


def test_columns_are_those_of_all_rows() -> None:
    lines = table({"one": {"a": 1.0}, "two": {"b": 0.1234, "a": math.nan}}).splitlines()
    assert lines == ["| | a | b |", "|---|---:|---:|", "| one | 1 | - |", "| two | - | 0.123 |"]


@pytest.mark.parametrize(
    ("value", "text"), [(0.012345, "0.0123"), (-12.34, "-12.3"), (999.4, "999"), (25431.2, "25431"), (math.nan, "-")]
)
def test_three_digits_or_all_before_the_point(value: float, text: str) -> None:
    assert digits(value) == text
