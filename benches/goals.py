"""What generated scans must reach, and what they did reach."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from markdown_table import digits


@dataclass(frozen=True)
class Goal:
    """A row of the table of goals: `values` by what they are of must be `least` to `most`."""

    name: str
    values: Mapping[str, float]
    least: float = -math.inf
    most: float = math.inf

    @property
    def met(self) -> bool:
        """Whether all values are; what could not be measured is not."""
        return all(self.least <= value <= self.most for value in self.values.values())

    @property
    def bounds(self) -> str:
        """Both ends, or the one that is."""
        if math.isinf(self.least):
            return f"<= {self.most:g}"
        return f">= {self.least:g}" if math.isinf(self.most) else f"{self.least:g} to {self.most:g}"


def goal_table(goals: Sequence[Goal]) -> str:
    """One row a goal; values that miss it are bold."""
    lines = ["| | goal | measured | met |", "|---|---|---|---|"]
    for goal in goals:
        cells = [
            f"{name} {digits(value)}" if goal.least <= value <= goal.most else f"{name} **{digits(value)}**"
            for name, value in goal.values.items()
        ]
        lines.append(f"| {goal.name} | {goal.bounds} | {', '.join(cells)} | {'yes' if goal.met else 'no'} |")
    return "\n".join(lines)


def ratio(first: float, second: float) -> float:
    """How many times `second` `first` is; NaN where that is nothing."""
    return first / second if second else math.nan
