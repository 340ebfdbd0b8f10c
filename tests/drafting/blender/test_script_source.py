import ast

import pytest

from lidardraft.drafting.blender.script.limits import Limits, RefusalError
from lidardraft.drafting.blender.script.source import parse


def test_only_code_counts_as_tokens() -> None:
    text = 'x = "1 2 3 4 5"  # and 6 7 8\ny = """\n9 10\n""" + \'it\\\'s\'\n'
    tree, tokens = parse(text, Limits())
    assert isinstance(tree, ast.Module)
    assert tokens == 3 + 5  # x = ""; y = "" + ""
    assert parse("x = f'{a} {b}'", Limits())[1] > 8  # an f-string holds code


@pytest.mark.parametrize(
    ("text", "line", "said"),
    [
        ("x = 1\ny = '\0'", 2, "a null byte"),
        ("x = 1\n\ny = (", 3, "not Python: '\\(' was never closed"),
        ("x = 1\n  y = 2", 2, "not Python: unexpected indent"),
        ("x = '''\n\n", 1, "not Python"),
        ("a = 1\nb = " + "-" * 20000 + "1", 2, "nested too deeply"),
    ],
)
def test_what_is_no_script_is_refused_with_its_line(text: str, line: int, said: str) -> None:
    with pytest.raises(RefusalError, match=said) as refused:
        parse(text, Limits())
    assert refused.value.line == line


@pytest.mark.parametrize("quotes", ['"', "'", '"""', "'''", '"""\\', "f'''{", '"""\\"'])
def test_quotes_without_end_take_no_time(quotes: str) -> None:
    """What matches them goes on to the end of the text, once."""
    with pytest.raises(RefusalError):
        parse(quotes * 60_000 + "\n'", Limits())


def test_warnings_of_python_are_not_passed_on() -> None:
    parse("x = '\\d'", Limits())


@pytest.mark.parametrize(
    ("text", "said", "line"),
    [
        ("x = 1\ny = '" + 'a"' * 250_001 + "'", "more than 250000 quotes, backslashes and number signs", 2),
        ("#\n" * 250_001, "more than 250000 quotes", 250_001),
        ("\n" * 1_000_001, "more than 1000000 characters of code", 1_000_001),
        ("x = 1\ny = " + "a" * 1_000_000, "more than 1000000 characters of code", 2),
        ("x = f'" + "{a} " * 9000 + "'", "more than 25000 names", 1),
        ("x = rF'" + "{a} " * 9000 + "'", "more than 25000 names", 1),
        ("x = Fr'" + "{a} " * 9000 + "'", "more than 25000 names", 1),
    ],
    ids=["quotes", "comments", "lines", "name", "f", "rF", "Fr"],
)
def test_a_text_that_takes_long_to_split_is_refused(text: str, said: str, line: int) -> None:
    with pytest.raises(RefusalError, match=said) as refused:
        parse(text, Limits())
    assert refused.value.line == line


def test_a_long_text_in_quotes_is_data() -> None:
    for quote in ('"', "'", '"""', "'''"):
        assert parse(f"x = {quote}{'a ' * 1_000_000}{quote}", Limits())[1] == 3
