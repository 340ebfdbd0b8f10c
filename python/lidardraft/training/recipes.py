"""Recipes: complete configurations of trainings, a stage after the other."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from lidardraft.diffusion.denoiser_config import DenoiserConfig
from lidardraft.training.denoising import DenoisingConfig

# Noise levels at which a network learns what a condition says: at lower ones the noisy scan says it all.
_CONDITIONED: dict[str, Any] = {"sigma_mean": 0.5, "sigma_std": 1.4}


@dataclass(frozen=True, kw_only=True)
class Recipe:
    """Stages of one training. One with a ControlNet stands on the stage before it, which stays frozen; any other goes
    on with its weights."""

    stages: tuple[DenoisingConfig, ...]


def small_paper() -> Recipe:
    """The paper's form for two CPU cores, on folded pixels: a base on every second beam and column, then on all, and
    its ControlNet."""
    return _with_controlnet(_small_base(), steps=8_000, zero_conv_steps=200)


def small() -> Recipe:
    """What ships, for two CPU cores: the base of `small_paper`, and then a network that completes simulated scans."""
    *base, last = _small_base()
    denoiser = replace(last.denoiser, condition=("simulated", "open"))
    return Recipe(stages=(*base, last, replace(last, denoiser=denoiser, steps=8_000, **_CONDITIONED)))


def paper() -> Recipe:
    """The paper's form: widths 128, 128, 256, 256, two blocks, no folding; LiDARGen's strides; for a GPU.

    The ControlNet sees classes and depths of the layout's cast. 100,000 steps without and 5,000 with the condition are
    the paper's; batch and learning rate it does not state, nor how long the zero convolutions learn alone.
    """
    denoiser = DenoiserConfig(
        cell=(1, 1),
        widths=(128, 128, 256, 256),
        strides=(1, 2, 1, 1),
        dilations=(1, 1, 2, 4),
        blocks=2,
        refine_units=2,
        pools=2,
        groups=8,
    )
    base = DenoisingConfig(denoiser=denoiser, steps=100_000, batch=24, learning_rate=0.01)
    return _with_controlnet((base,), steps=5_000, zero_conv_steps=500)


def tiny() -> Recipe:
    """`small`, an eighth as wide, for tests and a look at the loop: seconds."""
    return Recipe(stages=tuple(_tiny(stage) for stage in small().stages[-1:]))


def tiny_paper() -> Recipe:
    """`small_paper`, an eighth as wide, for tests."""
    *_, base, control = small_paper().stages
    return Recipe(stages=(_tiny(base), replace(_tiny(control), zero_conv_steps=5)))


def _small_base() -> tuple[DenoisingConfig, ...]:
    denoiser = DenoiserConfig(cell=(2, 4), widths=(64, 96, 128, 128), strides=(1, 2, 2, 1), dilations=(1, 1, 1, 2))
    coarse = DenoisingConfig(denoiser=denoiser, steps=20_000, batch=2, learning_rate=0.01, thinnings=(2,))
    return coarse, replace(coarse, steps=10_000, thinnings=(1, 2))


def _with_controlnet(base: tuple[DenoisingConfig, ...], *, steps: int, zero_conv_steps: int) -> Recipe:
    """A base, which learns scans without a condition, and then its ControlNet."""
    last = base[-1]
    denoiser = replace(last.denoiser, condition=("depth", "class"), controlnet=True)
    control = replace(
        last, denoiser=denoiser, steps=steps, zero_conv_steps=zero_conv_steps, watch_every=250, **_CONDITIONED
    )
    return Recipe(stages=(*base, control))


def _tiny(stage: DenoisingConfig) -> DenoisingConfig:
    denoiser = replace(stage.denoiser, widths=(8, 8, 16, 16))
    return replace(stage, denoiser=denoiser, steps=20, batch=4, warmup=5, watch_every=0)
