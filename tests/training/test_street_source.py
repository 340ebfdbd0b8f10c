import dataclasses

import numpy as np
from box_pairs import SENSOR

from lidardraft.training.street_source import StreetSource

SOURCE = StreetSource(seed=3, sensor=SENSOR)


def test_pairs_of_a_step_are_the_same_each_time_and_of_other_streets_at_each_step() -> None:
    first, again, other = (SOURCE.pairs(step, 2) for step in (1, 1, 2))
    assert len(first) == 2
    for pair, same, another in zip(first, again, other, strict=True):
        np.testing.assert_array_equal(pair.scan.depth, same.scan.depth)
        np.testing.assert_array_equal(pair.simulated.depth, same.simulated.depth)
        assert not np.array_equal(pair.scan.depth, another.scan.depth)


def test_a_pair_is_of_one_place_and_one_unit() -> None:
    for pair in SOURCE.pairs(0, 2):
        both = pair.scan.valid & pair.simulated.valid
        assert both.mean() > 0.5
        near = np.abs(pair.scan.depth - pair.simulated.depth) < 0.05 * pair.scan.depth + 0.5
        assert near[both].mean() > 0.5
        assert not np.array_equal(pair.scan.depth, pair.simulated.depth)


def test_any_sensor_is_another_one_at_each_step() -> None:
    source = StreetSource(seed=3)
    first, second = (source.pairs(step, 1)[0].scan.sensor for step in (0, 1))
    assert first != second
    assert source.pairs(0, 1)[0].scan.sensor == first
    assert "drawn at random" in source.source


def test_another_seed_or_sensor_is_another_source() -> None:
    other = dataclasses.replace(SENSOR, columns=64)
    sources = [SOURCE, StreetSource(seed=4, sensor=SENSOR), StreetSource(seed=3), StreetSource(seed=3, sensor=other)]
    assert len({source.checksum for source in sources}) == 4
