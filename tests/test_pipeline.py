import warnings

import numpy as np
import pytest

from lidardraft import Pipeline, Sensor

SMALL = Sensor(name="small", elevations=tuple(np.deg2rad(np.linspace(2, -24, 16)).tolist()), columns=128)


@pytest.fixture(scope="module")
def pipeline() -> Pipeline:
    return Pipeline.from_pretrained("street", steps=2)


def test_a_sensor_that_the_weights_know_is_no_warning(pipeline: Pipeline) -> None:
    known = Pipeline(pipeline.denoiser, steps=2, sensors=("small",))
    unknown = Pipeline(pipeline.denoiser, steps=2)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for each in (known, unknown):
            each("a car ahead", sensor=SMALL)


def test_another_sensor_is_warned_of_once(pipeline: Pipeline) -> None:
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("default")
        for seed in range(2):
            pipeline("a car ahead", sensor=SMALL, seed=seed)
    assert [str(warning.message) for warning in found] == [
        "these weights were trained on hdl64e; scans of small may be poor"
    ]


def test_every_step_is_told(pipeline: Pipeline) -> None:
    steps: list[int] = []
    known = Pipeline(pipeline.denoiser, steps=3, sensors=("small",))
    known("a car ahead", sensor=SMALL, on_step=lambda: steps.append(len(steps)))
    assert steps == [0, 1, 2]
