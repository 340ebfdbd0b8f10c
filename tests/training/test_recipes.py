from collections.abc import Callable

import pytest

from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.training import recipes


@pytest.mark.parametrize("recipe", [recipes.paper, recipes.small_paper, recipes.tiny_paper])
def test_the_papers_stages_are_a_base_and_its_controlnet(recipe: Callable[[], recipes.Recipe]) -> None:
    *bases, control = recipe().stages
    (denoiser,) = {base.denoiser for base in bases}
    assert not denoiser.condition
    assert Denoiser.from_config(denoiser).with_controlnet(control.denoiser).controlnet is not None
    assert control.zero_conv_steps > 0


def test_the_stages_for_two_cores_begin_on_every_second_beam_and_column() -> None:
    for recipe in (recipes.small(), recipes.small_paper()):
        assert recipe.stages[0].thinnings == (2,)
        assert all(1 in stage.thinnings for stage in recipe.stages[1:])
    assert recipes.small().stages[:2] == recipes.small_paper().stages[:2]


def test_what_ships_is_a_base_that_learns_to_complete() -> None:
    *_, base, last = recipes.small().stages
    assert Denoiser.from_config(base.denoiser).with_condition(last.denoiser).config.completes


def test_the_recipe_that_ships_fits_in_sixteen_megabytes() -> None:
    denoiser = Denoiser.from_config(recipes.small().stages[-1].denoiser)
    assert 2 * sum(weight.numel() for weight in denoiser.state_dict().values()) < 16e6


def test_the_papers_recipe_has_the_papers_widths() -> None:
    config = recipes.paper().stages[-1].denoiser
    assert config.widths == (128, 128, 256, 256)
    assert config.condition == ("depth", "class")
    assert config.cell == (1, 1)
