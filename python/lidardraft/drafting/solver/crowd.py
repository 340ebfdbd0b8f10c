"""How many objects of a crowd can find room at most, from how seldom a place taken at random is free."""

from __future__ import annotations

import math

_LEAST = 200  # tries before anything is said
# Objects placed at random saturate at 0.56 (squares) or 0.75 (along a line) of their area (Feder, J. Theor. Biol. 1980;
# Renyi, 1958). With the share r of places still free, at most (1 + c sqrt(r) / (1 - r)) times those that stand then
# do; c is 1.2 to 2.3 for these, whatever their density, so that what has room is never given up.
_FACTOR = 2.6


class Crowd:
    """The share of free places, from the latest tries."""

    def __init__(self) -> None:
        self.tries = self.free = 0.0

    def add(self, *, found: bool) -> None:
        """A place at random that was free or not."""
        forget = 1.0 - 1.0 / _LEAST if self.tries >= _LEAST else 1.0
        self.tries, self.free = self.tries * forget + 1.0, self.free * forget + found

    def most(self, placed: int) -> float:
        """How many find room at most when so many have; infinite while too little is known."""
        # two standard deviations more than counted, and two
        share = (self.free + 2 * math.sqrt(self.free) + 2) / self.tries if self.tries >= _LEAST else 1.0
        return math.inf if share >= 1.0 else math.ceil(placed * (1.0 + _FACTOR * math.sqrt(share) / (1.0 - share)))
