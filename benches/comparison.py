"""Properties of generated scans beside those of recorded ones.

Recordings come in groups of one drive or place each. Recorded against recorded is the mean distance between two groups
or, if that is more, between the two halves of one: two drives can be equal by chance. For generated against recorded,
generated sweeps replace one of two groups, in equal number, so that both figures suffer alike from small numbers. The
protocol is our own.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from lidardraft.metrics import lifelike
from lidardraft.metrics.lifelike import Property

FEWEST_TO_HALVE = 4  # sweeps
MOST_SUBSETS = 8  # disjoint sets of generated sweeps in place of one group


@dataclass(frozen=True)
class Comparison:
    """A measured property; NaN without anything to measure. `recorded` and `generated` are its summaries."""

    name: str
    recorded: float
    generated: float
    recorded_vs_recorded: float
    generated_vs_recorded: float

    @property
    def ratio(self) -> float:
        """The distance of generated from recorded sweeps over that of recorded ones from each other."""
        return self.generated_vs_recorded / self.recorded_vs_recorded if self.recorded_vs_recorded > 0 else math.nan


def compare(measured: Property, groups: Mapping[str, lifelike.Features], generated: lifelike.Features) -> Comparison:
    """The comparison of a property's measurements, by group of recorded sweeps, with generated ones; groups without a
    count are left out."""
    known = [list(features) for features in groups.values() if sum(np.nansum(np.abs(f)) for f in features) > 0]
    between = [measured.distance(first, second) for first, second in itertools.combinations(known, 2)]
    halves = [(g[: len(g) // 2], g[len(g) // 2 :]) for g in known if len(g) >= FEWEST_TO_HALVE]
    within = [measured.distance(first, second) for first, second in halves]
    recorded = lifelike.mean_known(between)
    if len(known) > 1 and not math.isnan(lifelike.mean_known(within)):
        recorded = max(recorded, lifelike.mean_known(within))
    others = []
    for number, features in enumerate(known):
        sizes = [len(other) for at, other in enumerate(known) if at != number] or [len(features)]
        others += [measured.distance(part, features) for part in subsets(generated, round(float(np.mean(sizes))))]
    summaries = lifelike.mean_known([measured.summary(features) for features in known]), measured.summary(generated)
    return Comparison(measured.name, *summaries, recorded, lifelike.mean_known(others))


def subsets(generated: lifelike.Features, count: int) -> list[lifelike.Features]:
    """Disjoint sets of `count` sweeps each, spread over all generated ones: a few sets have all kinds of places."""
    number = max(1, min(MOST_SUBSETS, len(generated) // max(count, 1)))
    stride = len(generated) // number
    return [generated[start * stride : start * stride + count] for start in range(number)]
