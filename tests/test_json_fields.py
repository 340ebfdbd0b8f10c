import math

import numpy as np
import pytest

from lidardraft.errors import FormatError
from lidardraft.json_fields import are_numbers, check_fields, is_number, parse_list, parse_object


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", r"not JSON: "),
        ("{", r"not JSON: "),
        ("import bpy\n", r"not JSON: .*; it begins with 'import bpy"),
        ('{"a": 1' + "0" * 1_000_000 + "}", r"not JSON: "),
        ("[" * 1_000_000, r"not JSON that can be read: it is nested too deeply"),
        ('{"a":' * 1_000_000, r"not JSON that can be read: it is nested too deeply"),
        ("[" + "[]," * 3_000_000 + "1]", "3000001 lists and objects; JSON of up to 3000000 is read"),
        ("[1]", r"\[1\] is not a JSON object"),
        ("null", r"None is not a JSON object"),
    ],
)
def test_a_text_without_an_object_is_refused(text: str, message: str) -> None:
    with pytest.raises(FormatError, match=message):
        parse_object(text)


def test_a_list_is_parsed_and_nothing_else() -> None:
    assert parse_list('[{"a": 1}, 2]') == [{"a": 1}, 2]
    with pytest.raises(FormatError, match=r"\{\} is not a JSON list"):
        parse_list("{}")
    with pytest.raises(FormatError, match="not JSON: "):
        parse_list("[")


def test_fields_are_all_that_must_be_there_and_no_others() -> None:
    check_fields({"a": 1, "b": 2}, ("a",), ("b", "c"))
    with pytest.raises(FormatError, match="'a' is missing"):
        check_fields({"b": 2}, ("a",), ("b",))
    with pytest.raises(FormatError, match="unknown field 'd'"):
        check_fields(iter(("a", "d")), ("a",), ("b",))


@pytest.mark.parametrize("value", [0, -1.5, 10**300, np.float32(1), np.int64(7)])
def test_numbers(value: object) -> None:
    assert is_number(value)
    assert are_numbers([value, value], 2)
    assert not are_numbers([value], 2)


@pytest.mark.parametrize("value", [True, math.nan, -math.inf, 10**400, "1", None, 1j, [1.0], np.complex128(1j)])
def test_what_is_no_number(value: object) -> None:
    assert not is_number(value)
    assert not are_numbers([1.0, value], 2)


def test_more_fields_than_are_read() -> None:
    with pytest.raises(FormatError, match="1500001 fields; JSON of up to 1500000 is read"):
        parse_object("{" + '"a":1,' * 1_500_000 + '"a":1}')
    with pytest.raises(FormatError, match="67108865 bytes of JSON; up to 67108864 are read"):
        parse_object(b" " * (2**26 + 1))
