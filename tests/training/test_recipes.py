"""Recipes have the stages that they say; the arms of the paper's ablation differ in what they say, and nothing else."""

import dataclasses
from collections.abc import Callable

import pytest

from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.training import recipes

*_, BASE, CONTROL = recipes.paper_small()


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


def test_the_papers_own_row_is_its_recipe() -> None:
    assert recipes.ARMS["paper"].stage(CONTROL) == dataclasses.replace(CONTROL, watch_every=0)


@pytest.mark.parametrize(
    ("recipe", "of"), [(recipes.paper_map, recipes.paper), (recipes.small_map, recipes.paper_small)]
)
def test_semantic_maps_have_a_controlnet_on_the_same_base(
    recipe: Callable[[], recipes.Stages], of: Callable[[], recipes.Stages]
) -> None:
    assert recipe()[:-1] == of()[:-1]
    assert recipe()[-1] == dataclasses.replace(recipes.ARMS["semantic map alone"].stage(of()[-1]), watch_every=250)


def test_arms_stand_on_the_papers_base_and_learn_as_long() -> None:
    base = Denoiser.from_config(BASE.denoiser)
    for arm in recipes.ARMS.values():
        stage = arm.stage(CONTROL)
        assert stage.steps == CONTROL.steps
        begun = base.with_controlnet(stage.denoiser) if arm.controlnet else base.with_condition(stage.denoiser)
        assert (begun.controlnet is not None) == arm.controlnet


def test_each_arm_changes_one_part() -> None:
    paper = recipes.ARMS["paper"]
    for name, arm in recipes.ARMS.items():
        changed = [f.name for f in dataclasses.fields(arm) if getattr(arm, f.name) != getattr(paper, f.name)]
        assert len(changed) == (name != "paper"), name


def test_without_tuning_the_zero_convolutions_learn_alone_to_the_end() -> None:
    stage = recipes.ARMS["ControlNet not fine-tuned"].stage(CONTROL)
    assert stage.zero_conv_steps == stage.steps
    assert recipes.ARMS["semantic map alone"].stage(CONTROL).denoiser.condition == ("class",)
    assert recipes.ARMS["without classes"].stage(CONTROL).denoiser.condition == ("depth",)
