"""`time` and `datetime` as a script sees them: the clock stands still, at the beginning of 1970, which is noted."""

from __future__ import annotations

import ast
import re
from collections.abc import Callable

from lidardraft.drafting.script.limits import RefusalError
from lidardraft.drafting.script.values import Builtin, Namespace, Record, Value, text

_FIRST = "1970-01-01 00:00:00"
_CODES = (
    {"%Y": "1970", "%y": "70", "%%": "%"} | dict.fromkeys(("%m", "%d"), "01") | dict.fromkeys(("%H", "%M", "%S"), "00")
)
_LONGEST_FORMAT = 100  # characters
_READINGS = ("time", "perf_counter", "monotonic", "process_time")
_PARTS = {"year": 1970, "month": 1, "day": 1} | dict.fromkeys(("hour", "minute", "second", "microsecond"), 0)
Note = Callable[[str], None]


class Moment(Record):
    """A time, of which there is one."""

    kind = "a moment"

    def attribute(self, name: str) -> Value:
        if name in _PARTS:
            return _PARTS[name]
        methods: dict[str, Callable[..., Value]] = {
            "isoformat": lambda *_, **__: _FIRST.replace(" ", "T"),
            "strftime": _formatted,
            "timestamp": lambda: 0.0,
            "date": lambda: self,
        }
        return Builtin(name, methods[name]) if name in methods else super().attribute(name)

    def binary(self, operator: type[ast.operator], other: Value, *, reflected: bool = False) -> Value:
        if operator is not ast.Sub or not isinstance(other, Moment):
            return super().binary(operator, other, reflected=reflected)
        return Duration()

    def text(self, _as_repr: bool) -> str:
        return _FIRST


class Duration(Record):
    """The time between two moments, which is none."""

    kind = "a duration"

    def attribute(self, name: str) -> Value:
        if name in ("seconds", "days", "microseconds"):
            return 0
        return Builtin(name, lambda: 0.0) if name == "total_seconds" else super().attribute(name)

    def text(self, _as_repr: bool) -> str:
        return "0:00:00"


def _formatted(form: Value, *_: Value) -> str:
    if len(text(form, "the format")) > _LONGEST_FORMAT:
        raise RefusalError(f"a format of {len(form)} characters; {_LONGEST_FORMAT} are the most")
    return re.sub("%.?", _coded, form)


def _coded(code: re.Match[str]) -> str:
    if code[0] not in _CODES:
        raise RefusalError(f"{code[0]!r} in the format of a time is not read; {', '.join(_CODES)} are")
    return _CODES[code[0]]


def clock_modules(note: Note) -> dict[str, dict[str, Value]]:
    """The contents of the modules by their names."""

    def noted(value: Value) -> Callable[..., Value]:
        def call(*_: Value, **__: Value) -> Value:
            note("the time is taken as 0")
            return value

        return call

    def formatted(*arguments: Value) -> str:
        note("the time is taken as 0")
        return _formatted(*arguments)

    time = {name: Builtin(f"time.{name}", noted(0.0)) for name in _READINGS}
    time |= {"sleep": Builtin("time.sleep", lambda _: None), "strftime": Builtin("time.strftime", formatted)}
    time |= {name: Builtin(f"time.{name}", noted(_FIRST)) for name in ("ctime", "asctime")}
    moments = {name: Builtin(f"datetime.{name}", noted(Moment())) for name in ("now", "today", "utcnow")}
    kinds = {name: Namespace(f"datetime.{name}", moments) for name in ("datetime", "date")}
    return {"time": time, "datetime": kinds}
