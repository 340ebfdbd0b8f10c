from pathlib import Path

import pytest
from box_pairs import SENSOR

from lidardraft.errors import TrainingError
from lidardraft.training.mixed_source import MixedSource
from lidardraft.training.pairs import PairFolder
from lidardraft.training.street_source import StreetSource


def test_steps_are_drawn_from_each_source_by_its_weight(pairs: PairFolder) -> None:
    mixed = MixedSource((pairs, StreetSource()), (9.0, 1.0))
    drawn = [mixed.pairs(step, 1)[0].scan.sensor == SENSOR for step in range(20)]
    assert drawn == [mixed.pairs(step, 1)[0].scan.sensor == SENSOR for step in range(20)]
    assert 14 <= sum(drawn) < 20
    assert mixed.sensor is None
    assert mixed.source == f"90% {pairs.source}; 10% {StreetSource().source}"
    assert mixed.checksum != MixedSource((pairs, StreetSource()), (1.0, 1.0)).checksum


def test_sources_of_one_sensor_have_it(pairs: PairFolder) -> None:
    assert MixedSource((pairs, StreetSource(sensor=SENSOR)), (1.0, 1.0)).sensor == SENSOR
    assert MixedSource((pairs,), (1.0,)).path == Path(pairs.path)


def test_no_source_and_weights_that_cannot_be_are_refused(pairs: PairFolder) -> None:
    with pytest.raises(TrainingError, match="no pairs to learn from"):
        MixedSource((), ())
    for weight in (0.0, -1.0, float("nan"), float("inf")):
        with pytest.raises(TrainingError, match="must be positive numbers"):
            MixedSource((pairs,), (weight,))
