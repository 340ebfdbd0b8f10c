"""The arms of the paper's ablation differ from its form in what they say, and in nothing else."""

import dataclasses

from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.training import recipes
from lidardraft.training.ablation import ARMS

RECIPE = recipes.small_paper()
*_, BASE, CONTROL = RECIPE.stages


def test_the_papers_own_row_is_its_recipe() -> None:
    assert ARMS["paper"].stage(RECIPE) == dataclasses.replace(CONTROL, watch_every=0)


def test_arms_with_a_controlnet_stand_on_the_papers_base() -> None:
    base = Denoiser.from_config(BASE.denoiser)
    for arm in ARMS.values():
        stage = arm.stage(RECIPE)
        if arm.controlnet:
            assert base.with_controlnet(stage.denoiser).controlnet is not None
            assert stage.steps == CONTROL.steps


def test_each_arm_changes_one_part() -> None:
    paper = ARMS["paper"]
    for name, arm in ARMS.items():
        changed = [f.name for f in dataclasses.fields(arm) if getattr(arm, f.name) != getattr(paper, f.name)]
        assert len(changed) == (name != "paper"), name


def test_budgets_are_equal() -> None:
    stage = ARMS["condition concatenated"].stage(RECIPE)
    assert stage.steps == BASE.steps + CONTROL.steps
    assert not stage.denoiser.controlnet
    assert stage.denoiser.condition == ("depth", "class")


def test_without_tuning_the_zero_convolutions_learn_alone_to_the_end() -> None:
    stage = ARMS["ControlNet not fine-tuned"].stage(RECIPE)
    assert stage.zero_conv_steps == stage.steps
    assert ARMS["semantic map alone"].stage(RECIPE).denoiser.condition == ("class",)
    assert ARMS["without classes"].stage(RECIPE).denoiser.condition == ("depth",)
