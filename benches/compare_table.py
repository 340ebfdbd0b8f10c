"""Measured seconds as one Markdown table with ratios."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from math import floor, log10
from statistics import median

import numpy as np

# What is measured: its name, our method, and that of Open3D and embreex beside it. Packet Embree has a bare cast only,
# and stands with it beside all: rays from several origins cost it the same or more.
ROWS = (
    ("build from arrays", "build", "build"),
    ("compile a layout", "compile", "build"),
    ("bare cast", "cast", "cast"),
    ("end to end, `out=`", "scan", "scan"),
    ("end to end, new arrays", "scan_fresh", "scan"),
    ("a pose for each column", "rolling", "cast"),
    ("batch, one scan of it", "batch", "scan"),
)
QUANTITIES = ("build", "compile", "cast", "scan", "scan_fresh", "rolling", "batch", "single")
RIVALS = ("Open3D", "embreex", "packet Embree")
RATIOS = ("analytic / Open3D", "analytic / packets", "triangles / Open3D", "triangles / packets")
COLUMNS = ("scene", "measured", "threads", *RIVALS, "analytic", "triangles", *RATIOS, "same analytic", "same triangles")


@dataclass
class Results:
    """What was measured: `seconds` of each round, by scene, peer, threads and quantity; `agreement`, by scene and peer,
    the shares of rays with the same range and with the same instance."""

    seconds: dict[tuple[str, str, int, str], list[float]] = field(default_factory=dict)
    agreement: dict[tuple[str, str], tuple[float, float]] = field(default_factory=dict)

    def add(self, scene: str, peer: str, threads: int, quantity: str, seconds: float) -> None:
        """One more round."""
        self.seconds.setdefault((scene, peer, threads, quantity), []).append(seconds)

    def median(self, scene: str, peer: str, threads: int, quantity: str) -> float | None:
        """Seconds, or None where nothing was measured."""
        measured = self.seconds.get((scene, peer, threads, quantity))
        return median(measured) if measured else None


def agreement(expected: tuple[np.ndarray, ...], got: tuple[np.ndarray, ...]) -> tuple[float, float]:
    """Shares of rays with the same range, within 2 mm + 1e-5 of it, and with the same instance."""
    near = np.abs(expected[0] - got[0]) <= 2e-3 + 1e-5 * expected[0]
    return float(near.mean()), float((expected[2] == got[2]).mean())


def markdown(results: Results, scenes: list[str], threads: list[int]) -> str:
    """The table: times in ms, ratios as how many times faster we are."""
    lines = ["| " + " | ".join(COLUMNS) + " |", "|---|---|" + "---:|" * (len(COLUMNS) - 2)]
    for scene in scenes:
        for number in threads:
            lines += ["| " + " | ".join(cells) + " |" for cells in _rows(results, scene, number)]
    return "\n".join(lines)


def _rows(results: Results, scene: str, threads: int) -> Iterator[list[str]]:
    for name, ours, theirs in ROWS:
        mine = [results.median(scene, peer, threads, ours) for peer in ("analytic", "triangles")]
        open3d, embreex = (results.median(scene, peer, threads, theirs) for peer in ("open3d", "embreex"))
        packets = results.median(scene, "packets", threads, "build" if theirs == "build" else "cast")
        if not any(mine) and (ours != theirs or not any((open3d, embreex))):
            continue
        times = [_milliseconds(seconds) for seconds in (open3d, embreex, packets, *mine)]
        ratios = [_ratio(rival, own) for own in mine for rival in (open3d, packets)]
        same = [
            _same(results.agreement.get((scene, peer)) if ours == "cast" else None)
            for peer in ("analytic", "triangles")
        ]
        yield [scene, name, str(threads), *times, *ratios, *same]


def _milliseconds(seconds: float | None) -> str:
    return "" if seconds is None else three_digits(1e3 * seconds)


def _ratio(rival: float | None, own: float | None) -> str:
    return "" if rival is None or own is None else three_digits(rival / own) + "x"


def three_digits(value: float) -> str:
    """A number above 0 with three digits, all of those before the point: 0.0123, 12.3, 1234."""
    return f"{value:.{max(0, 2 - floor(log10(value)))}f}"


def _same(shares: tuple[float, float] | None) -> str:
    return "" if shares is None else "{:.3%}, {:.3%}".format(*shares)
