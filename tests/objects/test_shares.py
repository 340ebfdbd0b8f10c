"""Names by their shares."""

from collections import Counter

import numpy as np
import pytest

from lidardraft.objects.shares import sample_name


def test_names_come_as_often_as_their_shares_say():
    rng = np.random.default_rng(0)
    shares = {"brick": 0.7, "wood": 0.3, "stone": 0.0}
    counts = Counter(sample_name(shares, rng) for _ in range(2000))
    assert counts["brick"] / 2000 == pytest.approx(0.7, abs=0.04)
    assert set(counts) == {"brick", "wood"}


def test_shares_that_do_not_add_up_are_an_error():
    with pytest.raises(ValueError, match="sum to 1"):
        sample_name({"brick": 0.7, "wood": 0.2}, np.random.default_rng(0))
