import pytest
from script_reading import agrees, refuses


@pytest.mark.parametrize(
    "script",
    [
        "assert '%s is %5.2f and %03d%%' % ('x', 1.005, 7) == 'x is  1.00 and 007%'",
        "assert '%r %x' % ('a', 255) == \"'a' ff\" and '%s' % [1] == '[1]'",
        "assert '{} {1}'.replace('{1}', '{}').format(1, 'b') == '1 b' and "
        "'{0:>4}|{name:.1f}'.format(1, name=2.0) == '   1|2.0'",
        "assert f'{12345:,} {0.5:%} {3:b} {\"x\":*^5}' == '12,345 50.000000% 11 **x**'",
        "assert str({'a': (1,), 2: None}) == \"{'a': (1,), 2: None}\" and f'{[1, True]}' == '[1, True]'",
    ],
)
def test_text_is_what_python_makes(script: str) -> None:
    agrees(script)


@pytest.mark.parametrize(
    ("script", "said"),
    [
        ("f'{1:>300}'", "a width of 300 characters; 200 are the most"),
        ("f'{1:y}'", "the format 'y' is not supported"),
        ("f'{\"a\":d}'", "'a' cannot be formatted as 'd'"),
        ("f'{[]:5}'", "a list cannot be formatted as '5'"),
        ("'%d %d' % 1", "more fields than it is given values"),
        ("'%d' % (1, 2)", "fewer fields than it is given values"),
        ("'%(a)s' % {'a': 1}", "the format .* is not supported"),
        ("'{'.format()", "is no format"),
        ("'{a.b}'.format(a=1)", "no value for 'a.b'"),
        ("'{}'.format()", "is given no value for .0."),
    ],
)
def test_formats_that_are_not_read(script: str, said: str) -> None:
    refuses(script, said)
