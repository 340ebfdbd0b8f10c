"""Tables of shares: names, and how often each is chosen."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np


def sample_name(shares: Mapping[str, float], rng: np.random.Generator) -> str:
    """One of the names of a table whose shares add up to 1."""
    return str(rng.choice(list(shares), p=list(shares.values())))
