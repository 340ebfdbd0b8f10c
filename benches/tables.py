"""Numbers as tables in Markdown, and goals that were to be reached."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

Row = dict[str, float]  # by column


def table(rows: Mapping[str, Row]) -> str:
    """Rows by name; the columns are those of all, "-" where a row has none."""
    columns = list(dict.fromkeys(column for row in rows.values() for column in row))
    lines = [f"| | {' | '.join(columns)} |", f"|---|{'---:|' * len(columns)}"]
    for name, row in rows.items():
        lines.append(f"| {name} | {' | '.join(digits(row.get(column, math.nan)) for column in columns)} |")
    return "\n".join(lines)


def digits(value: float) -> str:
    """Three digits, or all of those before the point; "-" for NaN."""
    if math.isnan(value):
        return "-"
    return f"{value:.3g}" if abs(value) < 1000 else f"{value:.0f}"


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
