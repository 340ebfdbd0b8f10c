"""Text made of values: `str`, f-strings, `%` and `format`, with widths that are bounded."""

from __future__ import annotations

import re
import string
from collections.abc import Callable

from lidardraft.drafting.blender.script.limits import RefusalError, Script
from lidardraft.drafting.blender.script.values import Record, Value, describe

_STEPS = 20  # that a format costs
_WIDEST = 200  # characters that a number or a name is padded to, and digits behind the point
_SPEC = re.compile(r"(?:.?[<>=^])?[-+ ]?#?(\d*)[,_]?(?:\.(\d+))?[bdeEfFgGosxX%]?", re.DOTALL)
_PERCENT = re.compile(r"%(?:%|[-+ #0]*(\d*)(?:\.(\d+))?[dioxXeEfFgGsr])")


def to_text(value: Value, script: Script, level: int = 0) -> str:
    """What `str` makes of a value; what is in a list looks as in Python's own."""
    if isinstance(value, Record):
        return value.text(level > 0)
    if not isinstance(value, list | tuple | dict):
        return repr(value) if level and isinstance(value, str) else str(value)
    if level > 8:
        raise RefusalError("lists within lists, too deep to be written")
    script.take_steps(len(value) + 1)
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
    if not spec:
        return to_text(value, script)
    match = _SPEC.fullmatch(spec)
    if not match:
        raise RefusalError(f"the format {spec[:40]!r} is not supported")
    _check_width(*match.groups())
    return _formatted(format, value, spec)


def brace_format(template: str, arguments: tuple[Value, ...], keywords: dict[str, Value], script: Script) -> str:
    """What `template.format(...)` gives; a field is a number or a name, and nothing of what it stands for."""
    script.take_steps(_STEPS)
    script.take_cells(2 * template.count("{"))
    try:
        fields = list(string.Formatter().parse(template))
    except ValueError as error:
        raise RefusalError(f"{template[:40]!r} is no format: {error}") from None
    named = {str(place): value for place, value in enumerate(arguments)} | keywords
    parts: list[str] = []
    unnumbered = 0
    for literal, field, spec, conversion in fields:
        parts.append(literal)
        if field is None:
            continue
        if conversion or "{" in (spec or ""):
            raise RefusalError(f"the format {template[:40]!r} is not supported")
        name = field or str(unnumbered)
        unnumbered += not field
        if name not in named:
            raise RefusalError(f"the format {template[:40]!r} is given no value for {name[:40]!r}")
        parts.append(format_value(named[name], spec or "", script))
    script.take_text(sum(map(len, parts)))
    return "".join(parts)


def percent_format(template: str, values: Value, script: Script) -> str:
    """What `template % values` gives."""
    script.take_steps(_STEPS + template.count("%"))
    given = list(values) if isinstance(values, tuple) else [values]
    parts, end = [], 0
    if "%" in _PERCENT.sub("", template):
        raise RefusalError(f"the format {template[:40]!r} is not supported")
    for match in _PERCENT.finditer(template):
        parts.append(template[end : match.start()])
        end = match.end()
        if match.group() == "%%":
            parts.append("%")
            continue
        _check_width(*match.groups())
        if not given:
            raise RefusalError(f"the format {template[:40]!r} has more fields than it is given values")
        value = given.pop(0)
        if match.group()[-1] in "sr" and not isinstance(value, str | int | float):
            value = to_text(value, script)
        parts.append(_formatted(lambda item, spec: spec % item, value, match.group()))
    parts.append(template[end:])
    script.take_text(sum(map(len, parts)))
    if given:
        raise RefusalError(f"the format {template[:40]!r} has fewer fields than it is given values")
    return "".join(parts)


def _formatted(write: Callable[[Value, str], str], value: Value, spec: str) -> str:
    try:
        if isinstance(value, str | int | float):
            return write(value, spec)
    except (TypeError, ValueError, OverflowError):
        pass
    raise RefusalError(f"{describe(value)} cannot be formatted as {spec!r}")


def _check_width(*numbers: str | None) -> None:
    for number in numbers:
        if number and (len(number) > 4 or int(number) > _WIDEST):
            raise RefusalError(f"a width of {number[:12]} characters; {_WIDEST} are the most")
