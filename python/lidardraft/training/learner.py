"""What a gradient step changes and a run keeps: weights, their average and the optimiser."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import save as serialise
from torch import Tensor, nn

from lidardraft.errors import TrainingError
from lidardraft.files import written_whole


@dataclass(frozen=True, kw_only=True)
class LearningConfig:
    """How weights learn.

    The learning rate rises over `warmup` steps, stays, and falls to 0 over the last `decay` of the steps. `ema` is the
    decay of the average of weights that is saved.
    """

    steps: int
    batch: int
    learning_rate: float
    warmup: int = 100
    decay: float = 0.3
    weight_decay: float = 0.01
    max_gradient: float = 1.0
    ema: float = 0.998
    seed: int = 0
    save_every: int = 200
    report_every: int = 20

    def rate(self, step: int) -> float:
        """The learning rate of a step."""
        rise = (step + 1) / max(self.warmup, 1)
        fall = (self.steps - step) / max(self.decay * self.steps, 1)
        return self.learning_rate * min(1.0, rise, fall)

    def of_any_length(self) -> dict[str, Any]:
        """The fields but for those that may differ between the slices of one run: its length, and how it reports."""
        return {**dataclasses.asdict(self), **dict.fromkeys(("steps", "save_every", "report_every"))}


class Learner:
    """Those weights of a module that learn, their average and the optimiser; `identity` says of which run."""

    def __init__(self, module: nn.Module, config: LearningConfig, identity: Any) -> None:
        self.config, self.identity = config, json.dumps(identity)
        self.weights = {name: p for name, p in module.named_parameters() if p.requires_grad}
        self.average = {name: p.detach().clone() for name, p in self.weights.items()}
        self.optimiser = torch.optim.AdamW(
            self.weights.values(), lr=config.learning_rate, betas=(0.9, 0.99), weight_decay=config.weight_decay
        )

    def step(self, step: int, loss: Tensor) -> float:
        """One gradient step; the norm of the gradient."""
        for group in self.optimiser.param_groups:
            group["lr"] = self.config.rate(step)
        self.optimiser.zero_grad(set_to_none=True)
        loss.backward()  # type: ignore[no-untyped-call]
        gradient = torch.nn.utils.clip_grad_norm_(self.weights.values(), self.config.max_gradient)
        self.optimiser.step()
        # A young average is short, so that it forgets its random start.
        decay = min(self.config.ema, (1 + step) / (10 + step))
        torch._foreach_lerp_(list(self.average.values()), [p.detach() for p in self.weights.values()], 1 - decay)
        return gradient.item()

    @contextmanager
    def averaged(self) -> Iterator[None]:
        """Let the module have the averaged weights meanwhile."""
        trained = {name: p.detach().clone() for name, p in self.weights.items()}
        self._put(self.average)
        try:
            yield
        finally:
            self._put(trained)

    def save(self, path: Path, step: int) -> None:
        """Write what the next slice of the run goes on from."""
        tensors = {f"weight.{name}": p.detach() for name, p in self.weights.items()}
        tensors |= {f"average.{name}": p for name, p in self.average.items()}
        for name, p in self.weights.items():
            tensors |= {f"{key}.{name}": value for key, value in self.optimiser.state.get(p, {}).items()}
        metadata = {"step": str(step), "run": self.identity}
        with written_whole(path) as temporary:
            temporary.write_bytes(serialise({name: t.cpu().contiguous() for name, t in tensors.items()}, metadata))

    def resume(self, path: Path) -> int:
        """Take over the state of an earlier slice of the same run, if there is one; the step to go on from.

        Raises `TrainingError` where the file is no state, or that of another run.
        """
        if not path.exists():
            return 0
        try:
            with safe_open(path, framework="pt") as file:
                metadata, tensors = file.metadata(), {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
            identity, step = metadata["run"], int(metadata["step"])
        except (SafetensorError, OSError, KeyError, TypeError, ValueError) as error:
            raise TrainingError(f"{path} is no state of a run: {error}") from None
        if identity != self.identity:
            raise TrainingError(f"{path} is the state of a run with another config or base; use another folder")
        self._put({name: tensors[f"weight.{name}"] for name in self.weights})
        for name, p in self.weights.items():
            self.average[name].copy_(tensors[f"average.{name}"])
            self.optimiser.state[p] = {
                key: tensors[f"{key}.{name}"].to(p.device if key != "step" else "cpu")
                for key in ("step", "exp_avg", "exp_avg_sq")
                if f"{key}.{name}" in tensors
            }
        return step

    @torch.no_grad()
    def _put(self, values: dict[str, Tensor]) -> None:
        for name, p in self.weights.items():
            p.copy_(values[name])
