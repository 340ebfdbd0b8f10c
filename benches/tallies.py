"""What was measured of coarse layouts, by kind and by what made them: statistics, tables, and where two differ."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

import numpy as np

SIZES = ("length", "width", "height")
NUMBERS = (*SIZES, "across", "yaw")
FIELDS = ("count", *NUMBERS)

# By how much a stand-in may differ from what it stands in for: steps that the spread within a kind hides. On top of
# each comes twice the standard error of so many values. A spread is half the width of the middle 68 %.
COUNT = 1.2  # times as many
OF_SPREAD = 0.25  # share of the spread of a place
OFF = {"across": 0.1, "yaw": 1.0}  # m, deg
SPREADS = 1.5  # times the spread of places
POSSIBLE = 0.9  # share of shapes
FEWEST = 50  # shapes; of fewer nothing is said


@dataclass
class Tally:
    """What was measured of one kind by one draughtsman: lists of numbers for each of `FIELDS`."""

    values: dict[str, list[float]] = field(default_factory=lambda: defaultdict(list))

    def add(self, **values: Iterable[float]) -> None:
        for name, some in values.items():
            self.values[name] += [float(value) for value in some]

    def median(self, name: str) -> float:
        return float(np.median(self.values[name])) if self.values[name] else math.nan

    def mean(self, name: str) -> float:
        return float(np.mean(self.values[name])) if self.values[name] else math.nan

    def spread(self, name: str) -> float:
        """Half the width of the middle 68 % of the values: the standard deviation of a normal distribution."""
        low, high = np.percentile(self.values[name], [16, 84]) if self.values[name] else (math.nan, math.nan)
        return float(high - low) / 2

    def possible(self, other: Tally) -> float:
        """The share of these shapes of which `other` drew some at least as large and some at most as large."""
        mine, theirs = (np.array([tally.values[name] for name in SIZES]) for tally in (self, other))
        if not mine.size or not theirs.size:
            return math.nan
        # a few samples do not reach the ends of a range
        low, high = 0.95 * theirs.min(axis=1), 1.05 * theirs.max(axis=1)
        return float((mine.T.clip(low, high) == mine.T).all(axis=1).mean())


Tallies = dict[str, dict[str, Tally]]  # by kind, then by draughtsman


def new_tallies() -> Tallies:
    """Tallies without a value."""
    return defaultdict(lambda: defaultdict(Tally))


def drift(tallies: Tallies, real: str, quick: str) -> list[str]:
    """Where `quick` differs from `real`, by more than is tolerated and chance explains.

    Sizes are those of the street as far as `real` could have made them, so that is asked.
    """
    return [text for label, by in tallies.items() for text in _drift(label, by[quick], by[real])]


def _drift(label: str, mine: Tally, theirs: Tally) -> Iterator[str]:
    number = min(len(mine.values["length"]), len(theirs.values["length"]))
    if number < FEWEST:
        return
    ours, other = mine.mean("count"), theirs.mean("count")
    most = COUNT + 2 / math.sqrt(number)
    if not 1 / most <= ours / other <= most:
        yield f"{label}: count {ours:.2f}, not {other:.2f}"
    yield from _other_places(label, mine, theirs, 2 / math.sqrt(number))
    if mine.possible(theirs) < POSSIBLE:
        yield f"{label}: {mine.possible(theirs):.2f} of the sizes possible"


def _other_places(label: str, mine: Tally, theirs: Tally, chance: float) -> Iterator[str]:
    for name, off in OFF.items():
        if not (mine.values[name] and theirs.values[name]):
            continue
        ours, other = mine.median(name), theirs.median(name)
        if abs(ours - other) > off + (OF_SPREAD + chance) * theirs.spread(name):
            yield f"{label}: {name} {ours:.2f}, not {other:.2f}"
        ours, other, most = mine.spread(name), theirs.spread(name), SPREADS + 2 * chance
        if not other / most - off <= ours <= other * most + off:
            yield f"{label}: {name} spreads {ours:.2f}, not {other:.2f}"


def rows(tallies: Tallies, real: str, quick: str) -> Iterator[str]:
    """The table, line by line: each cell is that of `real` and that of `quick`; what has no value has no column."""
    fields = [name for name in FIELDS if any(by[quick].values[name] for by in tallies.values())]
    yield f"| class | {' | '.join([*fields, 'possible'])} |"
    yield "|---" * (len(fields) + 2) + "|"
    for label in sorted(tallies):
        theirs, mine = tallies[label][real], tallies[label][quick]
        pairs = [(_cell(theirs, name), _cell(mine, name)) for name in fields]
        cells = [" / ".join(cell or "-" for cell in pair) if any(pair) else "" for pair in pairs]
        yield f"| {label} | {' | '.join([*cells, f'{mine.possible(theirs):.2f}'])} |"


def _cell(tally: Tally, name: str) -> str:
    if not tally.values[name]:
        return ""
    if name in NUMBERS:
        return f"{tally.median(name):.2f} ± {tally.spread(name):.2f}"
    return f"{tally.mean(name):.2f}"
