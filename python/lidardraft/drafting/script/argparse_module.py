"""`argparse` as a script sees it: there are no arguments, so all of them have their defaults."""

from __future__ import annotations

from collections.abc import Callable

from lidardraft.drafting.script.limits import Budget, RefusalError
from lidardraft.drafting.script.values import Builtin, Namespace, Record, Value, describe, text, truth

_MOST = 100  # arguments of one parser
Call = Callable[[Value, list[Value], dict[str, Value]], Value]
_WITHOUT_A_VALUE = {"store_true": False, "store_false": True, "store": None, "append": None, "count": None}


class Parser(Record):
    """An `ArgumentParser`, or a group of its arguments."""

    kind = "an ArgumentParser"

    def __init__(self, budget: Budget, call: Call) -> None:
        self._budget = budget
        self._call = call
        self._defaults: dict[str, Value] = {}

    def attribute(self, name: str) -> Value:
        methods: dict[str, Callable[..., Value]] = {
            "add_argument": self._add,
            "add_argument_group": lambda *_, **__: self,
            "set_defaults": lambda **named: self._defaults.update(named),
            "parse_args": self._parsed,
            "parse_known_args": lambda *arguments, **named: (self._parsed(*arguments, **named), []),
        }
        return Builtin(name, methods[name]) if name in methods else super().attribute(name)

    def _add(
        self,
        *flags: Value,
        default: Value = None,
        action: Value = "store",
        dest: Value = None,
        required: Value = False,
        nargs: Value = None,
        type: Value = None,  # the name that Python has for it
        **_: Value,
    ) -> None:
        self._budget.take_steps(5)
        names = [text(flag, "the name of an argument") for flag in flags]
        if len(self._defaults) >= _MOST or not names:
            raise RefusalError(f"a parser of no argument, or of more than {_MOST}")
        is_option = names[0].startswith("-")
        if truth(required) or not (is_option or nargs in ("?", "*")):
            raise RefusalError(f"the argument {names[0]!r:.60} has no default; there is nobody to give it")
        if action not in _WITHOUT_A_VALUE:
            raise RefusalError(f"the action {describe(action)} of an argument is not read")
        longest = next((name for name in names if name.startswith("--")), names[0])
        key = text(longest.lstrip("-").replace("-", "_") if dest is None else dest, "the name of an argument")
        if default is None:
            default = [] if nargs == "*" and not is_option else _WITHOUT_A_VALUE[action]
        elif isinstance(default, str) and type is not None:  # as it would stand in the command
            default = self._call(type, [default], {})
        self._defaults[key] = default

    def _parsed(self, args: Value = None) -> Namespace:
        self._budget.take_cells(3 * len(self._defaults))
        if args:
            raise RefusalError("arguments that a script gives itself are not read")
        return Namespace("the arguments", dict(self._defaults))


def argparse_module(budget: Budget, call: Call) -> dict[str, Value]:
    """The parser."""
    return {"ArgumentParser": Builtin("argparse.ArgumentParser", lambda *_, **__: Parser(budget, call))}
