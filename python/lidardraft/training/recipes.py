"""Recipes: complete configurations of trainings, a stage after the other."""

from __future__ import annotations

from dataclasses import dataclass, replace

from lidardraft.diffusion.denoiser_config import DenoiserConfig
from lidardraft.training.denoising import DenoisingConfig


@dataclass(frozen=True, kw_only=True)
class Recipe:
    """Stages of one training. One with a ControlNet stands on the stage before it, which stays frozen; any other goes
    on with its weights."""

    stages: tuple[DenoisingConfig, ...]


def small() -> Recipe:
    """What ships, for two CPU cores."""
    denoiser = DenoiserConfig(cell=(2, 4), widths=(64, 128, 192, 256), strides=(1, 2, 2, 2), dilations=(1, 1, 1, 1))
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
    return _two_stages(128, (1, 1), base_steps=100_000, steps=5_000, zero_conv_steps=500, batch=24, learning_rate=1e-4)


def small_paper() -> Recipe:
    """The paper's form for two CPU cores: a quarter of its width, on folded pixels."""
    return _two_stages(32, (2, 4), base_steps=8_000, steps=2_000, zero_conv_steps=200, batch=4, learning_rate=1e-3)


def tiny() -> Recipe:
    """`small`, an eighth as wide, for tests and a look at the loop: seconds."""
    (stage,) = small().stages
    denoiser = replace(stage.denoiser, widths=(8, 8, 16, 16))
    return Recipe(stages=(replace(stage, denoiser=denoiser, steps=20, learning_rate=3e-3, warmup=5, ema=0.9),))


def tiny_paper() -> Recipe:
    """`small_paper`, a quarter as wide, for tests."""
    base, control = _two_stages(
        8, (2, 4), base_steps=20, steps=20, zero_conv_steps=5, batch=4, learning_rate=3e-3
    ).stages
    return Recipe(stages=(replace(base, warmup=5, ema=0.9), replace(control, warmup=5, watch_every=0)))


def _two_stages(
    width: int,
    cell: tuple[int, int],
    *,
    base_steps: int,
    steps: int,
    zero_conv_steps: int,
    batch: int,
    learning_rate: float,
) -> Recipe:
    """The paper's network in so many channels on cells of pixels: a base, which learns scans without a condition, and
    then its ControlNet."""
    denoiser = DenoiserConfig(
        cell=cell,
        widths=(width, width, 2 * width, 2 * width),
        strides=(1, 2, 1, 1),
        dilations=(1, 1, 2, 4),
        blocks=2,
        refine_units=2,
        pools=2,
        groups=8,
        condition=("class", "depth"),
        controlnet=True,
        copy_gate=False,
    )
    control = DenoisingConfig(
        denoiser=denoiser,
        steps=steps,
        batch=batch,
        learning_rate=learning_rate,
        zero_conv_steps=zero_conv_steps,
        watch_every=250,
    )
    alone = replace(denoiser, condition=(), controlnet=False)
    base = replace(control, denoiser=alone, steps=base_steps, ema=0.999, zero_conv_steps=0, watch_every=0)
    return Recipe(stages=(base, control))
