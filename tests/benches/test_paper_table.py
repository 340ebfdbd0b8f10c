"""The scans of the paper's table have a row for each input."""

import dataclasses
from collections import Counter

import numpy as np
import pytest

from lidardraft import Pipeline, Sensor
from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.training import recipes
from paper_table import scans

SMALL = Sensor(name="small", elevations=tuple(np.deg2rad(np.linspace(2, -24, 16)).tolist()), columns=64)


@pytest.mark.slow
def test_a_row_for_each_input_and_of_weights_that_see_classes_the_maps_alone() -> None:
    config = recipes.tiny()[-1].denoiser
    for parts, rows in (
        (("depth", "class"), ("streets", "map", "text", "none", "image", "cloud")),
        (("class",), ("streets", "map")),
    ):
        pipeline = Pipeline(Denoiser.from_config(dataclasses.replace(config, condition=parts)), steps=1)
        made = list(scans(pipeline, 2, SMALL))
        assert Counter(name for name, _, _ in made) == dict.fromkeys(rows, 2)
        assert all(image.intensity is not None for _, image, _ in made)
