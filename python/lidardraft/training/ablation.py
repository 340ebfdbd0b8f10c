"""The paper's ablation (its Table 2): what each part of its form is worth, at one budget of training."""

from __future__ import annotations

from dataclasses import dataclass, replace

from lidardraft.training.denoising import DenoisingConfig


@dataclass(frozen=True, kw_only=True)
class Arm:
    """What one row of the table changes of the paper's form.

    The parts of the condition; whether it enters through a ControlNet, or beside the state of a base that learns on;
    whether the ControlNet's copy of the encoder learns, or its zero convolutions alone; whether the layout is seen from
    above (`top_view`) in place of its cast.
    """

    condition: tuple[str, ...] = ("depth", "class")
    controlnet: bool = True
    tuned: bool = True
    from_above: bool = False

    def stage(self, control: DenoisingConfig) -> DenoisingConfig:
        """What this arm learns on the base in place of the paper's `control`, in as many steps."""
        denoiser = replace(control.denoiser, condition=self.condition, controlnet=self.controlnet)
        alone = control.zero_conv_steps if self.tuned else control.steps
        return replace(control, denoiser=denoiser, zero_conv_steps=alone, watch_every=0)


# The rows of the table, the paper's own form last. "Semantic map alone" is the paper's "without depth estimation".
ARMS = {
    "ControlNet not fine-tuned": Arm(tuned=False),
    "top view, not cast": Arm(from_above=True),
    "without classes": Arm(condition=("depth",)),
    "semantic map alone": Arm(condition=("class",)),
    "condition concatenated": Arm(controlnet=False),
    "paper": Arm(),
}
