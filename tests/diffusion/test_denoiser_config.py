"""What decides the shape of a denoiser: its limits, its JSON, and the channels that follow from it."""

import dataclasses
from typing import Any

import pytest

from lidardraft.diffusion.denoiser_config import DenoiserConfig
from lidardraft.errors import LidarDraftError
from lidardraft.training import recipes

TINY = DenoiserConfig(cell=(2, 4), widths=(8, 8, 16, 16), strides=(1, 2, 2, 1), dilations=(1, 1, 1, 2), condition=())
CONDITIONED = dataclasses.replace(TINY, condition=("class", "depth", "simulated"))
CONTROLLED = dataclasses.replace(CONDITIONED, controlnet=True)


def test_what_is_not_said_is_as_in_the_weights_that_ship() -> None:
    given = {"cell", "widths", "strides", "dilations"}
    shipped = recipes.small().stages[-1].denoiser
    for field in dataclasses.fields(DenoiserConfig):
        assert field.name in given or getattr(shipped, field.name) == field.default


def test_the_simulated_scan_stands_beside_the_state_and_the_cast_in_the_context() -> None:
    assert (TINY.inputs, TINY.context) == (6, 4) == (CONTROLLED.inputs, CONTROLLED.context)
    assert (CONDITIONED.inputs, CONDITIONED.context) == (6 + 3, 4 + len(CONDITIONED.in_context))
    assert len(CONDITIONED.in_context) + len(CONDITIONED.beside_state) == len(CONTROLLED.condition_channels)


def test_the_config_survives_json() -> None:
    for config in (TINY, CONDITIONED, dataclasses.replace(CONTROLLED, copy_gate=False, cell=(1, 1))):
        assert DenoiserConfig.from_dict(config.to_dict()) == config
    with pytest.raises(TypeError):
        DenoiserConfig.from_dict({**TINY.to_dict(), "depth": 3})


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"cell": (2, 0)}, r"cell is \(2, 0\); it must be whole numbers from 1 to 4096"),
        ({"widths": (8, "8")}, r"widths is \(8, '8'\); it must be whole numbers from 1 to 4096"),
        ({"cell": (2, 4, 1)}, r"cell is \(2, 4, 1\); it must be \(rows, columns\)"),
        ({"strides": (1, 2)}, r"strides \(1, 2\) and dilations \(1, 1, 1, 2\) must match"),
        ({"blocks": 0}, "blocks is 0; it must be 1 to 64"),
        (
            {"condition": ("depth", "class")},
            r"condition is \('depth', 'class'\); it must be some of class, depth, simul",
        ),
        ({"condition": ("smell",)}, r"condition is \('smell',\); it must be some of class, depth, simulated, in this"),
        ({"controlnet": True}, "a ControlNet needs a condition"),
        ({"pools": 2.5}, "pools is 2.5; it must be 0 to 64"),
    ],
)
def test_a_config_that_cannot_be_is_refused(fields: dict[str, Any], message: str) -> None:
    with pytest.raises(LidarDraftError, match=message):
        dataclasses.replace(TINY, **fields)
