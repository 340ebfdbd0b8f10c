"""Numbers as a table in Markdown."""

from __future__ import annotations

import math
from collections.abc import Mapping

Row = dict[str, float]  # by column


def table(rows: Mapping[str, Row]) -> str:
    """Rows by name; the columns are those of all, "-" where a row has none."""
    columns = list(dict.fromkeys(column for row in rows.values() for column in row))
    lines = [f"| | {' | '.join(columns)} |", f"|---|{'---:|' * len(columns)}"]
    for name, row in rows.items():
        lines.append(f"| {name} | {' | '.join(digits(row.get(column, math.nan)) for column in columns)} |")
    return "\n".join(lines)


def digits(value: float) -> str:
    """Three digits, or all of those before the point; "-" for what is not a number."""
    if math.isnan(value):
        return "-"
    return f"{value:.3g}" if abs(value) < 1000 else f"{value:.0f}"
