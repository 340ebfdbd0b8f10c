import dataclasses

import pytest

from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.training import recipes


@pytest.mark.parametrize("recipe", [recipes.small, recipes.paper, recipes.tiny])
def test_both_stages_of_a_recipe_share_a_network(recipe: "type[recipes.Recipe]") -> None:
    assert recipe().base.denoiser == recipe().control.denoiser


def test_the_recipe_that_ships_fits_in_eight_megabytes() -> None:
    denoiser = Denoiser.from_config(dataclasses.replace(recipes.small().base.denoiser, controlnet=True))
    assert 2 * sum(weight.numel() for weight in denoiser.state_dict().values()) < 7.95e6


def test_the_papers_recipe_has_the_papers_widths() -> None:
    config = recipes.paper().base.denoiser
    assert config.widths == (128, 128, 256, 256)
    assert not config.copy_gate
    assert config.cell == (1, 1)
