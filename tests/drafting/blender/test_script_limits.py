"""What a script may cost, and texts that are no script."""

import ast

import pytest
from script_reading import reads, refuses

from lidardraft.drafting.blender.script.limits import Limits, RefusalError, Script
from lidardraft.drafting.blender.script.reading import parse


def test_each_limit_is_a_whole_number() -> None:
    with pytest.raises(ValueError, match=r"steps is 0; a limit is a whole number of 1 or more"):
        Limits(steps=0)
    with pytest.raises(ValueError, match=r"cells is 1.5"):
        Limits(cells=1.5)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("limits", "script", "said"),
    [
        (Limits(file=5), "x = 100", "the script has 7 characters; 5 are read"),
        (Limits(tokens=4), "x = 1 + 2", "more than 4 names, numbers and signs"),
        (Limits(steps=20), "while 1: pass", "the script takes more than"),
        (Limits(levels=4), "[[[[[1]]]]]", "nested more than 4 levels deep"),
        (Limits(length=10), "[0] * 11", "a value of 11 elements; 10 are the most"),
        (Limits(length=10), "'a' * 81", "a text of 81 characters; 80 are the most"),
        (Limits(cells=100), "[[0] * 30 for i in range(9)]", "all values together have more than 100 elements"),
    ],
)
def test_each_limit_is_held_to(limits: Limits, script: str, said: str) -> None:
    refuses(script, said, 1, limits)
    reads(script.replace("while 1: pass", "x = 1") if "while" in script else "x = 1", Limits())


def test_what_is_counted_is_counted_before_it_is_made() -> None:
    budget = Script(Limits(length=8, cells=10))
    budget.take_cells(8)
    with pytest.raises(RefusalError, match="all values together"):
        budget.take_cells(3)
    with pytest.raises(RefusalError, match="a value of 9 elements"):
        budget.take_cells(9)
    assert Script(Limits(steps=5)).steps == 5


def test_a_line_is_kept_once_it_is_known() -> None:
    assert RefusalError("x").at(3).at(5).line == 3


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
