"""What a script tells its reader, and no shape depends on: `logging`, `warnings`, `traceback`, and files such as
`sys.stdout`. It is passed over, and nothing is written."""

from __future__ import annotations

from lidardraft.drafting.script.limits import RefusalError
from lidardraft.drafting.script.values import Builtin, Record, Value

_LEVELS = {"DEBUG": 10, "INFO": 20, "WARNING": 30, "ERROR": 40, "CRITICAL": 50}
_MESSAGES = ("debug", "info", "warning", "warn", "error", "critical", "exception", "log")
_OF_LOGGERS = (*_MESSAGES, "setLevel", "addHandler", "removeHandler", "setFormatter", "flush", "close")


class Silent(Record):
    """What has methods that do nothing."""

    def __init__(self, kind: str, methods: tuple[str, ...]) -> None:
        self.kind = kind
        self._methods = methods

    def attribute(self, name: str) -> Value:
        if name not in self._methods:
            return super().attribute(name)
        return Builtin(f"{self.kind}.{name}", _nothing)

    def set_attribute(self, name: str, value: Value) -> None:
        if name != "propagate":
            super().set_attribute(name, value)


def _nothing(*_: Value, **__: Value) -> None:
    pass


def output_stream(name: str) -> Silent:
    """`sys.stdout`, `sys.stderr`."""
    return Silent(name, ("write", "writelines", "flush"))


def silent_modules() -> dict[str, dict[str, Value]]:
    """The contents of the modules by their names."""

    def basic_config(**named: Value) -> None:
        if named.get("filename") is not None:
            raise RefusalError("a log that is written to a file")

    def logger(*_: Value, **__: Value) -> Silent:
        return Silent("a logger", _OF_LOGGERS)

    makers = {name: Builtin(f"logging.{name}", logger) for name in ("getLogger", "StreamHandler", "Formatter")}
    messages = {name: Builtin(f"logging.{name}", _nothing) for name in (*_MESSAGES, "disable", "captureWarnings")}
    names = {"warnings": ("warn", "simplefilter", "filterwarnings"), "traceback": ("print_exc",), "gc": ("collect",)}
    silent = {
        module: {name: Builtin(f"{module}.{name}", _nothing) for name in table} for module, table in names.items()
    }
    basics = {"basicConfig": Builtin("logging.basicConfig", basic_config)}
    return {"logging": {**_LEVELS, **messages, **makers, **basics}, **silent}
