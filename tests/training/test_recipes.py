import pytest

from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.training import recipes


@pytest.mark.parametrize("recipe", [recipes.paper, recipes.small_paper, recipes.tiny_paper])
def test_the_papers_stages_are_a_base_and_its_controlnet(recipe: "type[recipes.Recipe]") -> None:
    base, control = recipe().stages
    torso = Denoiser.from_config(base.denoiser)
    assert torso.controlnet is None
    assert not base.denoiser.condition
    assert torso.with_controlnet(control.denoiser).controlnet is not None
    assert control.zero_conv_steps > 0


def test_the_recipe_that_ships_fits_in_sixteen_megabytes() -> None:
    denoiser = Denoiser.from_config(recipes.small().stages[-1].denoiser)
    assert 2 * sum(weight.numel() for weight in denoiser.state_dict().values()) < 16e6


def test_the_papers_recipe_has_the_papers_widths() -> None:
    config = recipes.paper().stages[-1].denoiser
    assert config.widths == (128, 128, 256, 256)
    assert config.condition == ("class", "depth")
    assert not config.copy_gate
    assert config.cell == (1, 1)
