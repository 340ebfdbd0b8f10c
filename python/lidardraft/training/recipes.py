"""Recipes: complete configurations of trainings, a stage after the other."""

from __future__ import annotations

from dataclasses import dataclass, replace

from lidardraft.diffusion.denoiser import DenoiserConfig
from lidardraft.training.denoising import DenoisingConfig


@dataclass(frozen=True, kw_only=True)
class Recipe:
    """Stages of one training. One with a ControlNet stands on the stage before it, which stays frozen; any other goes
    on with its weights."""

    stages: tuple[DenoisingConfig, ...]


def small() -> Recipe:
    """What ships, for two CPU cores."""
    denoiser = DenoiserConfig(
        cell=(2, 4),
        widths=(64, 128, 192, 256),
        strides=(1, 2, 2, 2),
        dilations=(1, 1, 1, 1),
        blocks=1,
        refine_units=0,
        pools=0,
        groups=4,
    )
    stage = DenoisingConfig(
        denoiser=denoiser,
        steps=20_000,
        batch=4,
        learning_rate=1.5e-3,
        ema=0.999,
        sigma_mean=-1.2,
        sigma_std=1.6,
        decay=0.4,
    )
    return Recipe(stages=(stage,))


def paper() -> Recipe:
    """The paper's form: widths 128, 128, 256, 256, two blocks, no folding, no copy gate; LiDARGen's strides; for a GPU.

    The ControlNet sees classes and depths of the layout's cast. 100,000 steps without and 5,000 with the condition are
    the paper's; batch and learning rate it does not state, nor how long the zero convolutions learn alone.
    """
    return _two_stages(
        DenoisingConfig(
            denoiser=_of_the_paper(128, cell=(1, 1)),
            steps=5_000,
            batch=24,
            learning_rate=1e-4,
            zero_conv_steps=500,
            watch_every=250,
        ),
        base_steps=100_000,
        ema=0.999,
    )


def small_paper() -> Recipe:
    """The paper's form for two CPU cores: a quarter of its width, on folded pixels."""
    return _two_stages(
        DenoisingConfig(
            denoiser=_of_the_paper(32, cell=(2, 4)),
            steps=2_000,
            batch=4,
            learning_rate=1e-3,
            zero_conv_steps=200,
            watch_every=250,
        ),
        base_steps=8_000,
        ema=0.999,
    )


def _of_the_paper(width: int, *, cell: tuple[int, int]) -> DenoiserConfig:
    """The paper's network with its ControlNet, of another width and with folded pixels where asked for."""
    return DenoiserConfig(
        cell=cell,
        widths=(width, width, 2 * width, 2 * width),
        strides=(1, 2, 1, 1),
        dilations=(1, 1, 2, 4),
        blocks=2,
        refine_units=2,
        pools=2,
        condition=("class", "depth"),
        controlnet=True,
        copy_gate=False,
    )


def tiny() -> Recipe:
    """`small`, an eighth as wide, for tests and a look at the loop: seconds."""
    (stage,) = small().stages
    denoiser = replace(stage.denoiser, widths=(8, 8, 16, 16))
    return Recipe(stages=(replace(stage, denoiser=denoiser, steps=20, learning_rate=3e-3, warmup=5, ema=0.9),))


def tiny_paper() -> Recipe:
    """`small_paper`, a quarter as wide, for tests."""
    *_, stage = small_paper().stages
    stage = replace(stage, denoiser=_of_the_paper(8, cell=(2, 4)), steps=20, learning_rate=3e-3, warmup=5)
    return _two_stages(replace(stage, zero_conv_steps=5, watch_every=0), base_steps=20, ema=0.9)


def _two_stages(control: DenoisingConfig, *, base_steps: int, ema: float) -> Recipe:
    """The stage of a ControlNet, after that of its base, which learns scans without a condition."""
    denoiser = replace(control.denoiser, condition=(), controlnet=False)
    base = replace(control, denoiser=denoiser, steps=base_steps, ema=ema, zero_conv_steps=0, watch_every=0)
    return Recipe(stages=(base, control))
