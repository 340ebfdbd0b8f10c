"""The pipeline, with small networks that have not learned."""

import dataclasses
import math
import warnings
from typing import Any

import numpy as np
import pytest
import torch

from lidardraft import Layout, Pipeline, Sensor, layout_from_text, raycast, simulate
from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.diffusion.denoiser_config import DenoiserConfig
from lidardraft.diffusion.sensor_limits import SensorLimits
from lidardraft.errors import LidarDraftError
from lidardraft.evaluation import unseen_streets, untrained_weights
from lidardraft.metrics.adherence import adherence
from lidardraft.scene.semantic_map import standing_on_ground
from lidardraft.training import recipes

SMALL = Sensor(name="small", elevations=tuple(np.deg2rad(np.linspace(2, -24, 16)).tolist()), columns=128)
IMAGES = ("depth", "label", "instance", "intensity")
BASE, CONTROLLED = (stage.denoiser for stage in recipes.tiny())


def of(config: DenoiserConfig, *, steps: int = 2) -> Pipeline:
    """With random weights, none of which is zero."""
    torch.manual_seed(0)
    denoiser = Denoiser.from_config(config)
    with torch.no_grad():
        for weight in denoiser.parameters():
            weight += 0.05 * torch.randn_like(weight)
    return Pipeline(denoiser, steps=steps)


@pytest.fixture(scope="module")
def pipeline() -> Pipeline:
    return of(CONTROLLED)


@pytest.fixture(scope="module")
def layout() -> Layout:
    return layout_from_text("a car ahead, houses on both sides", seed=0)


def test_the_packaged_weights_say_how_they_are_sampled_and_are_known_by_their_sensors() -> None:
    for made, steps, noise in (
        (Pipeline.from_pretrained(), 12, 0.1),
        (Pipeline.from_pretrained("paper-small"), 10, 1.0),
    ):
        assert made.denoiser.config.controlnet
        assert (made.steps, made.guidance, made.last_noise) == (steps, 2, noise)
        assert made.trained is not None
        assert made.trained.difference(Sensor.preset("hdl64e")) is None


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
        "these weights were trained on mount height of 1.73, and small has 2.5; its scans may be poor"
    ]


def test_the_same_seed_gives_the_same_scan_and_another_one_another_world(pipeline: Pipeline, layout: Layout) -> None:
    first, again, other = (pipeline(layout, sensor=SMALL, seed=seed).image for seed in (1, 1, 2))
    for name in IMAGES:
        np.testing.assert_array_equal(getattr(first, name), getattr(again, name))
    assert (first.depth != other.depth).mean() > 0.5
    assert (first.label > 0)[first.valid].mean() > 0.9


@pytest.mark.parametrize("config", [BASE, CONTROLLED], ids=["base", "controlled"])
def test_the_whole_scan_is_made_and_nothing_of_the_simulated_one(config: DenoiserConfig, layout: Layout) -> None:
    scan, simulated = of(config)(layout, sensor=SMALL, speed=30.0), simulate(layout, SMALL, speed=30.0)
    assert scan.speed == 30.0
    assert (scan.image.depth == simulated.image.depth)[scan.image.valid].mean() < 0.05


def test_a_moving_sensor_is_given_what_it_sees_on_its_way(layout: Layout) -> None:
    made = of(CONTROLLED)
    still, moving = (made(layout, sensor=SMALL, speed=speed).image for speed in (0.0, 30.0))
    assert not np.array_equal(still.depth, moving.depth)


def test_another_layout_gives_another_scan_of_the_same_noise(layout: Layout) -> None:
    made = of(CONTROLLED)
    one, again = (made.generate(raycast(layout, SMALL)) for _ in range(2))
    np.testing.assert_array_equal(one.depth, again.depth)
    heeded = made.generate(raycast(layout_from_text("a bus behind", seed=0), SMALL))
    assert not np.array_equal(one.depth, heeded.depth)


def test_scans_that_are_made_at_once_are_those_made_alone(layout: Layout, monkeypatch: pytest.MonkeyPatch) -> None:
    made, steps, sizes = of(CONTROLLED), list[int](), list[int]()
    sources = [(layout, 3), ("a bus behind", 4), (layout, 5), (layout, 6), (layout, 7)]
    alone = [made(source, sensor=SMALL, seed=seed).image for source, seed in sources]
    monkeypatch.setattr(Pipeline, "_at_once", lambda *_: 3)
    denoise = made.denoiser.denoise

    def counted(x: torch.Tensor, *given: Any, **options: Any) -> torch.Tensor:
        sizes.append(len(x))
        return denoise(x, *given, **options)

    monkeypatch.setattr(made.denoiser, "denoise", counted)
    scans = list(made.scans(sources, sensor=SMALL, on_step=lambda: steps.append(1)))
    assert set(sizes) == {3, 2}
    assert len(steps) == 2 * 5
    assert [scan.seed for scan in scans] == [3, 4, 5, 6, 7]
    for scan, image in zip(scans, alone, strict=True):
        np.testing.assert_array_equal(scan.image.valid, image.valid)
        np.testing.assert_allclose(scan.image.depth, image.depth, rtol=1e-4)
        assert (scan.image.label == image.label).mean() > 0.999
        np.testing.assert_array_equal(scan.image.instance, image.instance)


THREE_BEAMS = Sensor(name="small", elevations=(0.1, 0.0, -0.1), columns=100, mount_height=1.5)


def test_what_is_outside_is_said_with_the_limits() -> None:
    limits = SensorLimits(beams=(2, 4), columns=(50, 200), elevation=(-10.0, 10.0), mount_height=(1.0, 2.0))
    assert limits.difference(THREE_BEAMS) is None
    for change, words in (
        ({"columns": 300}, "columns of 50 to 200, and small has 300"),
        ({"mount_height": 2.5}, "mount height of 1 to 2, and small has 2.5"),
        ({"elevations": (0.2, 0.0)}, "elevation of -10 to 10, and small has 0 to 11.46"),
        ({"elevations": (0.1,)}, "beams of 2 to 4, and small has 1"),
    ):
        assert limits.difference(dataclasses.replace(THREE_BEAMS, **change)) == words


def test_columns_are_those_of_a_full_turn() -> None:
    sector = dataclasses.replace(THREE_BEAMS, azimuth_start=math.pi / 4, azimuth_span=math.pi / 2)
    limits = SensorLimits(beams=(3, 3), columns=(390, 410), elevation=(-10.0, 10.0), mount_height=(1.0, 2.0))
    assert limits.difference(sector) is None


def test_a_semantic_map_becomes_a_scan_and_weights_that_see_classes_alone_heed_no_ranges() -> None:
    label = raycast(layout_from_text("a car ahead", seed=0), SMALL).label
    for parts in (("depth", "class"), ("class",)):
        made = of(dataclasses.replace(CONTROLLED, condition=parts))
        image = made.from_map(label, sensor=SMALL)
        assert image.valid.any()
        lower = dataclasses.replace(SMALL, mount_height=1.2)  # of a lower sensor ranges are shorter
        guessed = (standing_on_ground(label, sensor) for sensor in (SMALL, lower))
        scans = [made.generate(dataclasses.replace(cast, sensor=SMALL)) for cast in guessed]
        assert np.array_equal(scans[0].depth, scans[1].depth) == (parts == ("class",))


@pytest.mark.parametrize(
    "wrong", [{"steps": 0}, {"steps": 1.5}, {"last_noise": 0}, {"guidance": -1.0}, {"guidance": math.nan}]
)
def test_a_pipeline_that_cannot_be(pipeline: Pipeline, wrong: dict[str, Any]) -> None:
    (name,) = wrong
    with pytest.raises(LidarDraftError, match=f"^{name} is "):
        Pipeline(pipeline.denoiser, **wrong)


@pytest.mark.slow
def test_the_packaged_paper_weights_obey_their_layout_from_noise() -> None:
    (pair,) = unseen_streets(1, sensor=Sensor.preset("hdl64e"))
    trained = Pipeline.from_pretrained("paper")
    untrained = Pipeline(untrained_weights(trained.denoiser), steps=2)
    made, random = (each.generate(pair.condition_image, seed=0) for each in (trained, untrained))
    assert adherence(made, pair.condition_image).objects > 0.4
    assert adherence(random, pair.condition_image).objects < 0.2
