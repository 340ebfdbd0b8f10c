"""Text made of values: `str`, f-strings, `%` and `format`, with widths that are bounded."""

from __future__ import annotations

import re
import string
from collections.abc import Iterator
from contextlib import contextmanager

from lidardraft.drafting.blender.script.limits import RefusalError, Script
from lidardraft.drafting.blender.script.values import Record, Value, describe

_WIDEST = 200  # characters that a number or a name is padded to, and digits behind the point
_PERCENT = re.compile(r"%[-+ #0]*([\d.*]*)[^\d.*]")


def to_text(value: Value, script: Script, level: int = 0) -> str:
    """What `str` makes of a value; what is in a list looks as in Python's own."""
    if isinstance(value, Record):
        return value.text(level > 0)
    if not isinstance(value, list | tuple | dict):
        return repr(value) if level and isinstance(value, str) else str(value)
    script.take_step()
    if level > 8:
        raise RefusalError("lists within lists, too deep to be written")
    if isinstance(value, dict):
        parts = [f"{to_text(key, script, 9)}: {to_text(item, script, level + 1)}" for key, item in value.items()]
    else:
        parts = [to_text(item, script, level + 1) for item in value]
    script.take_text(sum(map(len, parts)) + 2 * len(parts) + 2)
    inner = ", ".join(parts)
    if isinstance(value, dict):
        return f"{{{inner}}}"
    return f"[{inner}]" if isinstance(value, list) else f"({inner}{',' * (len(parts) == 1)})"


def to_repr(value: Value, script: Script) -> str:
    """What `repr` makes of a value."""
    return to_text([value], script)[1:-1]


def format_value(value: Value, spec: str, script: Script) -> str:
    """What an f-string makes of a value with what stands behind its colon."""
    _check_widths(spec)
    if spec and not isinstance(value, str | int | float):
        raise RefusalError(f"{describe(value)} cannot be formatted as {spec!r}")
    with _telling():
        return format(_plain(value, script), spec)


def brace_format(template: str, arguments: tuple[Value, ...], keywords: dict[str, Value], script: Script) -> str:
    """What `template.format(...)` gives; a field is a number or a name, and nothing of what it stands for."""
    script.take_cells(4 * template.count("{"))
    for _, field, spec, conversion in string.Formatter().parse(template):
        if conversion or "{" in (spec or "") or not re.fullmatch(r"\w*", field or ""):
            raise RefusalError(f"the format {template[:40]!r} is not supported")
        _check_widths(spec or "")
    plain = {name: _plain(value, script) for name, value in keywords.items()}
    text = template.format(*[_plain(value, script) for value in arguments], **plain)
    script.take_text(len(text))
    return text


def percent_format(template: str, values: Value, script: Script) -> str:
    """What `template % values` gives."""
    for match in _PERCENT.finditer(template):
        _check_widths(match[1].replace("*", str(10 * _WIDEST)))
    given = values if isinstance(values, tuple) else (values,)
    with _telling():
        text = template % tuple([_plain(value, script) for value in given])
    script.take_text(len(text))
    return text


@contextmanager
def _telling() -> Iterator[None]:
    try:
        yield
    except (TypeError, ValueError, OverflowError) as error:
        raise RefusalError(f"a format that is not supported: {error}") from None


def _plain(value: Value, script: Script) -> str | int | float:
    """The value as one that Python itself can write."""
    return value if isinstance(value, str | int | float) else to_text(value, script)


def _check_widths(spec: str) -> None:
    for width in re.findall(r"\d+", spec):
        if len(width) > 4 or int(width) > _WIDEST:
            raise RefusalError(f"a width of {width[:12]} characters; {_WIDEST} are the most")
