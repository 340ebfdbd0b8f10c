"""What decides the shape of a denoiser: its limits, its JSON, and the channels that follow from it."""

import dataclasses
from typing import Any

import pytest

from lidardraft.diffusion.channels import RAY_CHANNELS
from lidardraft.diffusion.denoiser_config import DenoiserConfig
from lidardraft.errors import LidarDraftError
from lidardraft.training import recipes

TINY = DenoiserConfig(cell=(2, 4), widths=(8, 8, 16, 16), strides=(1, 2, 2, 1), dilations=(1, 1, 1, 2))
CONDITIONED = dataclasses.replace(TINY, condition=("depth", "class"))
CONTROLLED = dataclasses.replace(TINY, condition=("depth", "class"), controlnet=True)


def test_what_is_not_said_is_as_in_the_base_of_the_weights_that_ship() -> None:
    given = {"cell", "widths", "strides", "dilations"}
    base = recipes.paper_small()[0].denoiser
    for field in dataclasses.fields(DenoiserConfig):
        assert field.name in given or getattr(base, field.name) == field.default


def test_a_condition_stands_beside_the_rays_unless_a_controlnet_sees_it() -> None:
    assert TINY.context == CONTROLLED.context == RAY_CHANNELS
    assert CONDITIONED.context == RAY_CHANNELS + len(CONDITIONED.condition_channels)
    assert len(CONDITIONED.condition_channels) == 2 + 5


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"cell": (2, 0)}, r"cell is \(2, 0\); it must be whole numbers from 1 to 4096"),
        ({"widths": (8, "8")}, r"widths is \(8, '8'\); it must be whole numbers from 1 to 4096"),
        ({"cell": (2, 4, 1)}, r"cell is \(2, 4, 1\); it must be \(rows, columns\)"),
        ({"strides": (1, 2)}, r"strides \(1, 2\) and dilations \(1, 1, 1, 2\) must match"),
        ({"blocks": 0}, "blocks is 0; it must be 1 to 64"),
        ({"condition": ("class", "depth")}, r"condition is \('class', 'depth'\); it must be some of depth, class"),
        ({"condition": ("smell",)}, r"condition is \('smell',\); it must be some of depth, class,"),
        ({"controlnet": True}, "condition is empty; a ControlNet sees depth, class or both"),
        ({"pools": 2.5}, "pools is 2.5; it must be 0 to 64"),
    ],
)
def test_a_config_that_cannot_be_is_refused(fields: dict[str, Any], message: str) -> None:
    with pytest.raises(LidarDraftError, match=message):
        dataclasses.replace(TINY, **fields)
