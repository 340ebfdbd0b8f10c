"""The data of an SVG path become polylines, one for each of its pieces; curves are flattened."""

from __future__ import annotations

import re

import numpy as np

from lidardraft.drafting.sketches.svg_geometry import LARGEST, arc, bezier
from lidardraft.errors import FormatError

_SPACE = re.compile(r"[\s,]*")
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
_FLAG = re.compile(r"[01]")
_COUNTS = {"M": 2, "L": 2, "H": 1, "V": 1, "C": 6, "S": 4, "Q": 4, "T": 2, "A": 7, "Z": 0}
_FLAGS = (3, 4)  # of the seven numbers of an arc, which may stand without a space
MOST_COMMANDS = 30_000  # of all paths of a file


class PathReader:
    """Reads the data of a path from left to right; `commands` says how many it had."""

    def __init__(self, data: str) -> None:
        self.commands = 0
        self._data = data
        self._at = 0
        self._here = np.zeros(2)
        self._control: tuple[str, np.ndarray] | None = None  # of the last curve, with its kind
        self._pieces: list[tuple[list[np.ndarray], bool]] = []
        self._begin = np.zeros(2)

    def pieces(self) -> list[tuple[np.ndarray, bool]]:
        """The points [N, 2] of each piece, and whether it is closed. Raises `FormatError` at what is no path."""
        command = ""
        while self.commands < MOST_COMMANDS:
            self.commands += 1
            self._skip()
            if self._at == len(self._data):
                return [(np.array(points), closed) for points, closed in self._pieces if len(points) > 1 or closed]
            letter = self._data[self._at]
            if letter.upper() in _COUNTS and letter.isalpha():
                command, self._at = letter, self._at + 1
            elif not command or command in "Zz":
                raise self._wrong()
            elif command in "Mm":
                command = "L" if command == "M" else "l"
            self._carry_out(command)
        raise FormatError(f"a path of more than {MOST_COMMANDS} commands")

    def _carry_out(self, command: str) -> None:
        kind = command.upper()
        if not self._pieces and kind != "M":
            raise self._wrong()
        values = [self._number(flag=kind == "A" and k in _FLAGS) for k in range(_COUNTS[kind])]
        origin = self._here if command.islower() else np.zeros(2)
        before, self._control = self._control, None
        if kind == "Z":
            points, _ = self._pieces[-1]
            self._pieces[-1] = (points, True)
            self._here = self._begin
            return
        if kind == "M":
            self._here = self._begin = origin + values
            self._pieces.append(([self._here], False))
            return
        if self._pieces[-1][1]:  # what follows a closed piece begins where that did
            self._pieces.append(([self._begin], False))
        if kind in "HV":
            axis = "HV".index(kind)
            target = self._here.copy()
            target[axis] = origin[axis] + values[0]
            new = target[None]
        elif kind == "A":
            rx, ry, turn, large, sweep = values[:5]
            new = arc(self._here, (rx, ry), turn, bool(large), bool(sweep), origin + values[5:])
        elif kind == "L":
            new = (origin + values)[None]
        else:
            new = self._curve(kind, origin + np.array(values).reshape(-1, 2), before)
        if not (np.abs(new) < LARGEST).all():
            raise FormatError(f"a path that reaches further than {LARGEST:g}")
        self._pieces[-1][0].extend(new)
        self._here = new[-1]

    def _curve(self, kind: str, points: np.ndarray, before: tuple[str, np.ndarray] | None) -> np.ndarray:
        order = "C" if kind in "CS" else "Q"
        if kind in "ST":  # the first control point is the last one of the curve before, mirrored
            mirrored = 2 * self._here - before[1] if before and before[0] == order else self._here
            points = np.concatenate([mirrored[None], points])
        self._control = (order, points[-2])
        return bezier(np.concatenate([self._here[None], points]))

    def _number(self, *, flag: bool) -> float:
        self._skip()
        match = (_FLAG if flag else _NUMBER).match(self._data, self._at)
        if not match:
            raise self._wrong()
        self._at = match.end()
        value = float(match[0])
        if not abs(value) < LARGEST:
            raise FormatError(f"a path that reaches further than {LARGEST:g}")
        return value

    def _skip(self) -> None:
        match = _SPACE.match(self._data, self._at)
        assert match
        self._at = match.end()

    def _wrong(self) -> FormatError:
        return FormatError(f"path data that cannot be read at character {self._at}: {self._data[self._at :][:20]!r}")
