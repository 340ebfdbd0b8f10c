"""Recipes have the stages that they say."""

import dataclasses
from collections.abc import Callable

import pytest

from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.training import recipes


@pytest.mark.parametrize("recipe", [recipes.paper, recipes.paper_small, recipes.paper_large, recipes.tiny])
def test_the_papers_stages_are_a_base_and_its_controlnet(recipe: Callable[[], recipes.Stages]) -> None:
    *bases, control = recipe()
    (denoiser,) = {base.denoiser for base in bases}
    assert not denoiser.condition
    assert Denoiser.from_config(denoiser).with_controlnet(control.denoiser).controlnet is not None
    assert control.zero_conv_steps > 0


def test_the_stages_for_two_cores_begin_on_every_second_beam_and_column() -> None:
    first, *others = recipes.paper_small()
    assert first.thinnings == (2,)
    assert all(1 in stage.thinnings for stage in others)


@pytest.mark.parametrize(
    ("recipe", "of"), [(recipes.paper_map, recipes.paper), (recipes.small_map, recipes.paper_small)]
)
def test_semantic_maps_have_a_controlnet_on_the_same_base(
    recipe: Callable[[], recipes.Stages], of: Callable[[], recipes.Stages]
) -> None:
    assert recipe()[:-1] == of()[:-1]
    control = of()[-1]
    assert recipe()[-1] == dataclasses.replace(
        control, denoiser=dataclasses.replace(control.denoiser, condition=("class",))
    )
