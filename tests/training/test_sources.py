"""Pairs made meanwhile, of any sensor, and mixtures of sources."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
import torch
from box_pairs import SENSOR, noted

from lidardraft.errors import TrainingError
from lidardraft.formats.pairs import write_pairs
from lidardraft.scene.effects import sub_rays
from lidardraft.training import sources
from lidardraft.training.sampled_sensor import ELEVATIONS, LIMITS, ROWS, _sample_elevations, sample_sensor
from lidardraft.training.sources import MixedSource, PairFolder, StreetSource, free_memory

SOURCE = StreetSource(seed=3, sensor=SENSOR)


def test_pairs_of_a_step_are_the_same_each_time_and_of_other_streets_at_each_step() -> None:
    first, again, other = (SOURCE.stack(step, 2).images for step in (1, 1, 2))
    assert {len(rows) for rows in first.values()} == {2}
    for name, rows in first.items():
        assert torch.equal(rows, again[name])
        assert not torch.equal(rows[0], rows[1]) or not rows.any()
    assert not torch.equal(first["scan_depth"], other["scan_depth"])


def test_any_sensor_is_another_one_at_each_step() -> None:
    source = StreetSource(seed=3)
    first, second = (source.stack(step, 1).sensor for step in (0, 1))
    assert first != second
    assert source.stack(0, 1).sensor == first
    assert "drawn at random" in source.source


def test_another_seed_or_sensor_is_another_source() -> None:
    other = dataclasses.replace(SENSOR, columns=64)
    sources = [SOURCE, StreetSource(seed=4, sensor=SENSOR), StreetSource(seed=3), StreetSource(seed=3, sensor=other)]
    assert len({source.checksum for source in sources}) == 4


def test_steps_are_drawn_from_each_source_by_its_weight(pairs: PairFolder) -> None:
    mixed = MixedSource((pairs, StreetSource()), (9.0, 1.0))
    drawn = [mixed.stack(step, 1).sensor == SENSOR for step in range(20)]
    assert drawn == [mixed.stack(step, 1).sensor == SENSOR for step in range(20)]
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


def test_more_pairs_than_memory_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    list(write_pairs(tmp_path / "pairs", [noted(0), noted(1)]))
    free = free_memory()
    assert free is None or 10**7 < free < 10**15
    monkeypatch.setattr(sources, "free_memory", lambda: 20_000)
    message = r"pairs with its 2 pairs needs 0\.0 GB of memory; 0\.0 GB are free"
    with pytest.raises(TrainingError, match=message):
        PairFolder(tmp_path / "pairs")
    monkeypatch.setattr(sources, "free_memory", lambda: 2 * 16 * 128 * 10)  # two uint16 and three uint8 images are 10
    assert len(PairFolder(tmp_path / "pairs")) == 2


# the columns of a sector are whole cells of the network, so a turn of them is not quite what was drawn
WIDER = dataclasses.replace(LIMITS, columns=(LIMITS.columns[0] - 10, LIMITS.columns[1] + 10))


def test_sensors_differ_and_can_all_be_cast_and_learned_from() -> None:
    sensors = [sample_sensor(np.random.default_rng(seed)) for seed in range(60)]
    for sensor in sensors:
        assert WIDER.difference(sensor) is None
        assert sensor.model is not None
        sub_rays(sensor, sensor.model)  # raises where beams overlap
        assert sensor.shape[0] % 4 == sensor.shape[1] % 8 == 0  # cells of every second beam and column too
    assert len({sensor.elevations for sensor in sensors}) > 20
    assert {sensor.shape[0] for sensor in sensors} >= {16, 32, 64, 128}
    assert 0 < sum(not sensor.wraps for sensor in sensors) < 20
    steps = [np.diff(sensor.elevations) for sensor in sensors if len(sensor.elevations) > 16]
    assert any(step.min() < 3 * step.max() for step in steps)  # beams are bunched, in some


@pytest.mark.parametrize("count", [10_000, pytest.param(100_000, marks=pytest.mark.slow)])
def test_every_table_of_beams_is_strictly_decreasing(count: int) -> None:
    rng, closest, lowest = np.random.default_rng(0), np.inf, np.inf
    for _ in range(count):
        elevations = _sample_elevations(rng)
        assert len(elevations) in ROWS
        closest = min(closest, -np.diff(elevations).max())
        lowest = min(lowest, elevations[-1])
        assert elevations[0] <= ELEVATIONS[1]
    assert closest > np.deg2rad(0.04)
    assert lowest == ELEVATIONS[0]  # some need all the room that there is
