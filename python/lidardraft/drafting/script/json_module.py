"""`json` as a script sees it: data in a text, and back."""

from __future__ import annotations

import json
import re

from lidardraft.drafting.script.formatting import to_text
from lidardraft.drafting.script.limits import Budget, RaisedError, RefusalError
from lidardraft.drafting.script.source import lone_surrogate
from lidardraft.drafting.script.values import Builtin, Value, checked, text

_WIDEST_INDENT, _LONGEST_NUMBER = 8, 40
_SIGN, _HALF_CHARACTER = re.compile(r"[,:\[{]"), re.compile(r"\\u[dD][89a-fA-F]")


def json_module(budget: Budget) -> dict[str, Value]:
    """`loads` and `dumps`, which read and write no file."""

    def whole_number(digits: str) -> int:
        if len(digits) > _LONGEST_NUMBER:
            raise RefusalError(f"a number of {len(digits)} digits")
        return int(checked(int(digits)))

    def loads(s: Value) -> Value:
        written = text(s, "what json.loads is given")
        budget.take_text(len(written))
        signs = len(_SIGN.findall(written))
        budget.take_steps(signs // 4)
        budget.take_cells(3 * signs)
        try:
            found = json.loads(written, parse_int=whole_number)
        except json.JSONDecodeError as error:
            raise RaisedError("JSONDecodeError", f"json.loads: {error}") from None
        if _HALF_CHARACTER.search(written):
            _check_texts(found)
        return found

    def dumps(obj: Value, *, indent: Value = None, sort_keys: Value = False, ensure_ascii: Value = True) -> str:
        if indent is not None and not (isinstance(indent, int) and 0 <= indent <= _WIDEST_INDENT):
            raise RefusalError(f"json.dumps with an indent that is no number of 0 to {_WIDEST_INDENT}")
        to_text(obj, budget)  # counts what is written, and refuses what is too deep
        written = json.dumps(obj, indent=indent, sort_keys=bool(sort_keys), ensure_ascii=bool(ensure_ascii))
        budget.take_text(len(written))
        return written

    return {"loads": Builtin("json.loads", loads), "dumps": Builtin("json.dumps", dumps)}


def _check_texts(value: Value) -> None:
    """Raise `RefusalError` where a text in the value holds half a character."""
    waiting = [value]
    while waiting:
        item = waiting.pop()
        if isinstance(item, str) and (wrong := lone_surrogate(item)) is not None:
            raise RefusalError(f"the text holds half a character, {item[wrong]!r}")
        waiting += [*item, *item.values()] if isinstance(item, dict) else item if isinstance(item, list) else []
