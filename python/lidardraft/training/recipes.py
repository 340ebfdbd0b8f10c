"""Recipes: complete configurations of trainings, one stage after the other.

A stage with a ControlNet uses the previous stage as its frozen base; any other continues with its weights.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from lidardraft.diffusion.denoiser_config import DenoiserConfig
from lidardraft.training.denoising import DenoisingConfig

Stages = tuple[DenoisingConfig, ...]
# Noise levels at which a network learns to use a condition: at lower ones the noisy scan is enough.
_CONDITIONED: dict[str, Any] = {"sigma_mean": 0.5, "sigma_std": 1.4}


def paper_small() -> Stages:
    """The paper's form for two CPU cores, on folded pixels: a base on every second beam and column, then on all, and
    its ControlNet."""
    denoiser = DenoiserConfig(cell=(2, 4), widths=(64, 96, 128, 128), strides=(1, 2, 2, 1), dilations=(1, 1, 1, 2))
    coarse = DenoisingConfig(denoiser=denoiser, steps=20_000, batch=2, learning_rate=0.01, thinnings=(2,))
    base = coarse, replace(coarse, steps=10_000, thinnings=(1, 2))
    return _with_controlnet(base, steps=8_000, zero_conv_steps=200)


def paper() -> Stages:
    """The paper's form for ten minutes of a GPU, and for samples on a CPU: pixels folded in pairs, 56 GFLOP a call.

    The packaged weights had 1,820 steps without and 795 with the condition (`weights/paper.md`); both still learned.
    """
    denoiser = DenoiserConfig(
        cell=(1, 2), widths=(64, 128, 160, 192), strides=(1, 2, 2, 2), dilations=(1, 1, 1, 1), blocks=2
    )
    base = DenoisingConfig(denoiser=denoiser, steps=20_000, batch=32, learning_rate=0.01)
    return _with_controlnet((base,), steps=8_000, zero_conv_steps=200)


def paper_large() -> Stages:
    """The paper's form: widths 128, 128, 256, 256, two blocks, no folding; LiDARGen's strides; 842 GFLOP a call.

    The ControlNet gets classes and depths of the layout's cast. 100,000 steps without and 5,000 with the condition are
    the paper's. It does not state batch and learning rate, nor how long the zero convolutions learn alone.
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


def paper_map() -> Stages:
    """`paper` for semantic maps: its ControlNet gets classes alone."""
    return _of_maps(paper())


def small_map() -> Stages:
    """`paper_small` for semantic maps."""
    return _of_maps(paper_small())


def tiny() -> Stages:
    """`paper_small`, an eighth as wide, for tests and a look at the loop: seconds."""
    *_, base, control = paper_small()
    return _tiny(base), replace(_tiny(control), zero_conv_steps=5)


def _of_maps(stages: Stages) -> Stages:
    *base, control = stages
    return *base, replace(control, denoiser=replace(control.denoiser, condition=("class",)))


def _with_controlnet(base: Stages, *, steps: int, zero_conv_steps: int) -> Stages:
    """A base, which learns scans without a condition, and then its ControlNet."""
    last = base[-1]
    denoiser = replace(last.denoiser, condition=("depth", "class"), controlnet=True)
    control = replace(
        last, denoiser=denoiser, steps=steps, zero_conv_steps=zero_conv_steps, watch_every=250, **_CONDITIONED
    )
    return *base, control


def _tiny(stage: DenoisingConfig) -> DenoisingConfig:
    denoiser = replace(stage.denoiser, widths=(8, 8, 16, 16))
    return replace(stage, denoiser=denoiser, steps=20, batch=4, warmup=5, watch_every=0)
