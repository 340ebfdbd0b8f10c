import dataclasses
import warnings

import numpy as np
import pytest
import torch

from lidardraft import Pipeline, Sensor, layout_from_text, raycast, simulate
from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.diffusion.sampling_defaults import START
from lidardraft.scene.sensor_limits import SensorLimits
from lidardraft.training import recipes

SMALL = Sensor(name="small", elevations=tuple(np.deg2rad(np.linspace(2, -24, 16)).tolist()), columns=128)


@pytest.fixture(scope="module")
def pipeline() -> Pipeline:
    return Pipeline(Pipeline.from_pretrained("street").denoiser, steps=2)


def test_a_sensor_that_the_weights_know_is_no_warning(pipeline: Pipeline) -> None:
    known = Pipeline(pipeline.denoiser, steps=2, trained=SensorLimits.from_sensor(SMALL))
    unknown = Pipeline(pipeline.denoiser, steps=2)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for each in (known, unknown):
            each("a car ahead", sensor=SMALL)


def test_another_sensor_is_warned_of_once(pipeline: Pipeline) -> None:
    known = Pipeline(pipeline.denoiser, steps=2, trained=SensorLimits.from_sensor(SMALL))
    high = dataclasses.replace(SMALL, mount_height=2.5)
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("default")
        for seed in range(2):
            known("a car ahead", sensor=high, seed=seed)
    assert [str(warning.message) for warning in found] == [
        "these weights were trained on mount height of 1.73 to 1.73, and small has 2.5; its scans may be poor"
    ]


def test_the_same_seed_gives_the_same_scan(pipeline: Pipeline) -> None:
    first, again, other = (pipeline("a car ahead", sensor=SMALL, seed=seed).image for seed in (1, 1, 2))
    np.testing.assert_array_equal(first.depth, again.depth)
    assert not np.array_equal(first.depth, other.depth)
    assert (first.label > 0)[first.valid].mean() > 0.9


def test_a_moving_sensor_generates_what_it_sees_on_its_way(pipeline: Pipeline) -> None:
    layout = layout_from_text("a car ahead, houses on both sides", seed=0)
    moving = pipeline(layout, sensor=SMALL, speed=30.0)
    assert moving.speed == 30.0
    depths = {speed: simulate(layout, SMALL, speed=speed).image.depth for speed in (0.0, 30.0)}
    same = {speed: (np.abs(moving.image.depth - depth) < 1e-3)[depth > 0].mean() for speed, depth in depths.items()}
    assert same[30.0] > 0.95
    assert same[0.0] < 0.9  # the rest is road, whose range is the same from anywhere
    assert (moving.image.label > 0)[moving.image.valid].mean() > 0.9


def test_every_step_is_told(pipeline: Pipeline) -> None:
    steps: list[int] = []
    Pipeline(pipeline.denoiser, steps=3)("a car ahead", sensor=SMALL, on_step=lambda: steps.append(len(steps)))
    assert steps == [0, 1, 2]


def test_weights_that_do_not_see_the_simulated_scan_start_from_noise() -> None:
    (generator,), (_, control) = recipes.tiny().stages, recipes.tiny_paper().stages
    assert Pipeline(Denoiser.from_config(generator.denoiser)).start == START
    assert Pipeline(Denoiser.from_config(control.denoiser)).start is None


def test_weights_that_do_not_see_the_simulated_scan_get_nothing_of_it() -> None:
    torch.manual_seed(0)
    pipeline = Pipeline(Denoiser.from_config(recipes.tiny_paper().stages[-1].denoiser), steps=2)
    layout = layout_from_text("a car ahead", seed=0)
    condition_image = raycast(layout, SMALL)
    one, other = (pipeline.generate(condition_image, simulate(layout, SMALL, seed=seed).image) for seed in (0, 1))
    np.testing.assert_array_equal(one.depth, other.depth)
    np.testing.assert_array_equal(one.intensity, other.intensity)


def test_the_papers_sampler_takes_as_many_steps_and_gives_another_scan() -> None:
    torch.manual_seed(0)
    denoiser = Denoiser.from_config(recipes.tiny_paper().stages[-1].denoiser)
    scans, steps = [], list[int]()
    for langevin in (None, 2):
        made = Pipeline(denoiser, steps=3, langevin=langevin)
        scans.append(made("a car ahead", sensor=SMALL, on_step=lambda: steps.append(1)).image)
    assert len(steps) == 6
    assert not np.array_equal(scans[0].depth, scans[1].depth)
