"""The arms of the paper's ablation differ from its form in what they say, and in nothing else."""

import dataclasses

from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.training import recipes
from lidardraft.training.ablation import ARMS

*_, BASE, CONTROL = recipes.small_paper().stages


def test_the_papers_own_row_is_its_recipe() -> None:
    assert ARMS["paper"].stage(CONTROL) == dataclasses.replace(CONTROL, watch_every=0)


def test_arms_stand_on_the_papers_base_and_learn_as_long() -> None:
    base = Denoiser.from_config(BASE.denoiser)
    for arm in ARMS.values():
        stage = arm.stage(CONTROL)
        assert stage.steps == CONTROL.steps
        begun = base.with_controlnet(stage.denoiser) if arm.controlnet else base.with_condition(stage.denoiser)
        assert (begun.controlnet is not None) == arm.controlnet


def test_each_arm_changes_one_part() -> None:
    paper = ARMS["paper"]
    for name, arm in ARMS.items():
        changed = [f.name for f in dataclasses.fields(arm) if getattr(arm, f.name) != getattr(paper, f.name)]
        assert len(changed) == (name != "paper"), name


def test_without_tuning_the_zero_convolutions_learn_alone_to_the_end() -> None:
    stage = ARMS["ControlNet not fine-tuned"].stage(CONTROL)
    assert stage.zero_conv_steps == stage.steps
    assert ARMS["semantic map alone"].stage(CONTROL).denoiser.condition == ("class",)
    assert ARMS["without classes"].stage(CONTROL).denoiser.condition == ("depth",)
