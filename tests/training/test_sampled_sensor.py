import dataclasses
import math

import numpy as np

from lidardraft.scene.effects import sub_rays
from lidardraft.training.sampled_sensor import LIMITS, sample_sensor

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


def test_a_generator_gives_the_same_sensor() -> None:
    first, again = (sample_sensor(np.random.default_rng(3)) for _ in range(2))
    assert first == again
    assert math.isclose(sum(first.elevations), sum(again.elevations))
