"""What a script imports that is not read: it may be imported, and is refused where anything is done with it."""

from __future__ import annotations

from typing import NoReturn

from lidardraft.drafting.script.limits import RefusalError
from lidardraft.drafting.script.values import Record, Value

_LONGEST = 60  # characters of its name


class Outside(Record):
    """A module that is not read, or a part of one. Nothing is known of it but its name, and nothing of it is loaded."""

    def __init__(self, name: str) -> None:
        self.kind = name[:_LONGEST]

    def attribute(self, name: str) -> Value:
        return Outside(f"{self.kind}.{name[:_LONGEST]}")

    def call(self, _arguments: list[Value], _keywords: dict[str, Value]) -> Value:
        raise RefusalError(f"a call of {self.kind}: a script is read, not run, and this module is not known")

    def truth(self) -> bool:
        return self._unknown()

    def equals(self, _other: Value) -> bool:
        return self._unknown()

    def text(self, _as_repr: bool) -> str:
        return self._unknown()

    def _unknown(self) -> NoReturn:
        raise RefusalError(f"the value of {self.kind}: a script is read, not run, and this module is not known")
