"""What a script may cost, and texts that are no script."""

import ast

import pytest
from script_reading import refuses

from lidardraft.drafting.blender.script.limits import RefusalError, ScriptLimits
from lidardraft.drafting.blender.script.reading import parse


def test_each_limit_is_a_whole_number() -> None:
    with pytest.raises(ValueError, match=r"steps is 0; a limit is a whole number of 1 or more"):
        ScriptLimits(steps=0)
    with pytest.raises(ValueError, match=r"cells is 1.5"):
        ScriptLimits(cells=1.5)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("limits", "script", "said"),
    [
        (ScriptLimits(file=5), "x = 100", "the script has 7 characters; 5 are read"),
        (ScriptLimits(code=8), "x = 1 + 2", "more than 8 characters of code"),
        (ScriptLimits(steps=20), "while 1: pass", "more than 20 steps; `limits` allows more"),
        (
            ScriptLimits(seconds=0.01),
            "f = ('a' * 10**6).count\nwhile 1: f('b')",
            "more than 0.01 s; `limits` allows more",
        ),
        (ScriptLimits(levels=4), "[[[[[1]]]]]", "nested more than 4 levels deep"),
        (ScriptLimits(length=10), "[0] * 11", "a value of 11 elements; the limit is 10"),
        (ScriptLimits(length=10), "'a' * 81", "a text of 81 characters; the limit is 80"),
        (ScriptLimits(cells=100), "[[0] * 30 for i in range(9)]", "all values together have more than 100 elements"),
        (
            ScriptLimits(cells=10**5),
            "f = ('a' * 9000).upper; [f() for i in range(999)]",
            "all values together have more",
        ),
    ],
)
def test_each_limit_is_held_to(limits: ScriptLimits, script: str, said: str) -> None:
    refuses(script, said, 1, limits)


def test_only_code_counts_in_full() -> None:
    text = 'x = "1 2 3 4 5"  # and 6 7 8\ny = """\n9 10\n""" + \'it\\\'s\'\n'
    assert isinstance(parse(text, ScriptLimits(code=20)), ast.Module)
    with pytest.raises(RefusalError, match="more than 12 characters of code"):
        parse("x = f'{a} {b}'", ScriptLimits(code=12))  # an f-string holds code


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
        parse(text, ScriptLimits())
    assert refused.value.line == line


@pytest.mark.parametrize("quotes", ['"', "'", '"""', "'''", '"""\\', "f'''{", '"""\\"'])
def test_quotes_without_end_take_no_time(quotes: str) -> None:
    """What matches them goes on to the end of the text, once."""
    with pytest.raises(RefusalError):
        parse(quotes * 60_000 + "\n'", ScriptLimits())


def test_warnings_of_python_are_not_passed_on() -> None:
    parse("x = '\\d'", ScriptLimits())


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("x = 1\n" + "'' " * 62_500, 2),
        ("#\n" * 62_501, 62_501),
        ("\n" * 125_001, 125_001),
        ("x = 1\ny = " + "a" * 125_000, 2),
        ("x = f'" + "{a} " * 32_000 + "'", 1),
        ("x = rF'" + "{a} " * 32_000 + "'", 1),
        ("x = Fr'" + "{a} " * 32_000 + "'", 1),
    ],
    ids=["quotes", "comments", "lines", "name", "f", "rF", "Fr"],
)
def test_a_text_that_takes_long_to_parse_is_refused(text: str, line: int) -> None:
    with pytest.raises(RefusalError, match="more than 125000 characters of code") as refused:
        parse(text, ScriptLimits())
    assert refused.value.line == line


def test_a_long_text_in_quotes_is_data() -> None:
    for quote in ('"', "'", '"""', "'''"):
        parse(f"x = {quote}{'a ' * 1_000_000}{quote}", ScriptLimits())
