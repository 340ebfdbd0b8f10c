"""What a gradient step changes and a run keeps: weights, their average and the optimiser, which is Muon."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, cast

import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import save as serialise
from torch import Tensor
from torch.optim.swa_utils import AveragedModel, get_ema_multi_avg_fn

from lidardraft.errors import TrainingError
from lidardraft.files import regular_size, written_whole
from lidardraft.networks.weight_file import Network
from lidardraft.training.processes import ALONE, Processes

_NEWTON_SCHULZ = (3.4445, -4.7750, 2.0315)  # the authors' coefficients: near 1 in five steps, not exact
_NEWTON_SCHULZ_STEPS = 5
_MOMENTUM = 0.95
_LEAST_SIDE = 16  # of a matrix; in smaller ones every direction is learned anyway
_ADAM_RATE = 0.1  # of the learning rate
_ADAM_BETAS, _ADAM_EPSILON = (0.9, 0.99), 1e-8


@dataclass(frozen=True, kw_only=True)
class LearningConfig:
    """How weights learn.

    The learning rate rises over `warmup` steps, stays, and falls to 0 over the last `decay` of the steps.
    """

    steps: int
    batch: int
    learning_rate: float
    warmup: int = 100
    decay: float = 0.3
    weight_decay: float = 0.1
    max_gradient: float = 0.1
    seed: int = 0
    save_every: int = 200
    report_every: int = 20

    def rate(self, step: int) -> float:
        """The learning rate of a step."""
        rise = (step + 1) / max(self.warmup, 1)
        fall = (self.steps - step) / max(self.decay * self.steps, 1)
        return self.learning_rate * min(1.0, rise, fall)

    def check_counts(self) -> None:
        """Raise `TrainingError` on a count that must be 1 or more and is not."""
        for name in ("steps", "batch", "save_every", "report_every"):
            if getattr(self, name) < 1:
                raise TrainingError(f"{name} is {getattr(self, name)}; it must be at least 1")

    def of_any_length(self) -> dict[str, Any]:
        """The fields as JSON types, but for those that may differ between the slices of a run."""
        free = ("steps", "save_every", "report_every", "watch_every")
        fields: dict[str, Any] = json.loads(json.dumps(dataclasses.asdict(self)))
        return {name: v for name, v in fields.items() if name not in free}


@dataclass(frozen=True)
class RunIdentity:
    """What must be the same in all slices of a run: the config, and checksums of the weights it begins with, be they
    random, given or the frozen base of a ControlNet, and of the pairs.

    `folder` says where the pairs lay; they may be moved.
    """

    config: dict[str, Any]
    weights: int
    pairs: int
    folder: str = field(compare=False)

    def check(self, path: Path, begun: RunIdentity) -> None:
        """Raise `TrainingError` where the run that wrote `path` had `begun` with something else."""
        if begun.pairs != self.pairs:
            difference = f"begun with the pairs of {begun.folder}, which are not those of {self.folder}"
        elif begun.config != self.config:
            names = sorted({*self.config, *begun.config})
            name = next(name for name in names if self.config.get(name) != begun.config.get(name))
            difference = f"with another config: its {name} is {begun.config.get(name)}, not {self.config.get(name)}"
        elif begun.weights != self.weights:
            difference = "begun with other weights (--init, or the base of a ControlNet)"
        else:
            return
        raise TrainingError(f"{path} is the state of a run {difference}; use another folder")


class Learner:
    """Those weights of a network that learn, their average and the optimiser."""

    def __init__(self, network: Network, config: LearningConfig) -> None:
        self.config, self.network = config, network
        self.weights = [p for p in network.parameters() if p.requires_grad]
        self.average = AveragedModel(network, multi_avg_fn=_update_average)
        self.optimiser = Muon(self.weights, lr=config.learning_rate, weight_decay=config.weight_decay)

    def step(self, step: int, loss: Tensor, processes: Processes = ALONE) -> float:
        """One gradient step on the sum of all processes' losses; the norm of the gradient. Raises `TrainingError`, and
        changes nothing, where loss or gradient is not finite."""
        for group in self.optimiser.param_groups:
            group["lr"] = self.config.rate(step)
        self.optimiser.zero_grad(set_to_none=True)
        loss.backward()  # type: ignore[no-untyped-call]
        processes.add_up(weight.grad for weight in self.weights if weight.grad is not None)
        gradient = torch.nn.utils.clip_grad_norm_(self.weights, self.config.max_gradient)
        if not (loss.isfinite() and gradient.isfinite()):
            raise TrainingError(f"the loss is {loss.item()} and its gradient {gradient.item()} at step {step + 1}")
        self.optimiser.step()
        self.average.update_parameters(self.network)
        return gradient.item()

    def save(self, path: Path, step: int, identity: RunIdentity) -> None:
        """Write what the next slice of the run goes on from."""
        tensors = {f"network.{name}": t for name, t in self.network.state_dict().items()}
        tensors |= {f"average.{name}": t for name, t in self.average.state_dict().items()}
        for number, state in self.optimiser.state_dict()["state"].items():
            tensors |= {f"optimiser.{number}.{name}": t for name, t in state.items()}
        metadata = {"step": str(step), "run": json.dumps(dataclasses.asdict(identity))}
        with written_whole(path) as temporary:
            whole = {name: t.detach().cpu().contiguous() for name, t in tensors.items()}
            temporary.write_bytes(serialise(whole, metadata))

    def resume(self, path: Path, identity: RunIdentity) -> int:
        """Take over the state of an earlier slice of the same run, if there is one; the step to go on from.

        Raises `TrainingError` where the file is no state, or that of another run.
        """
        if not path.exists():
            return 0
        try:
            regular_size(path)
            with safe_open(path, framework="pt") as file:
                metadata, tensors = file.metadata(), {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
            begun, step = RunIdentity(**json.loads(metadata["run"])), int(metadata["step"])
        except (SafetensorError, OSError, KeyError, TypeError, ValueError) as error:
            raise TrainingError(f"{path} is no state of a run: {error}") from None
        identity.check(path, begun)
        self.network.load_state_dict(_below("network.", tensors))
        self.average.load_state_dict(_below("average.", tensors))
        state: dict[int, dict[str, Tensor]] = {}
        for name, tensor in _below("optimiser.", tensors).items():
            number, key = name.split(".")
            state.setdefault(int(number), {})[key] = tensor
        groups = self.optimiser.state_dict()["param_groups"]
        self.optimiser.load_state_dict({"state": state, "param_groups": groups})
        return step

    @property
    def averaged(self) -> Network:
        """The network with the averaged weights."""
        return cast(Network, self.average.module)


def _update_average(
    average: tuple[Tensor, ...] | list[Tensor], weights: tuple[Tensor, ...] | list[Tensor], count: Tensor | int
) -> None:
    # A window that grows with the training, about a tenth of its length: the power profile of Karras et al. (Analyzing
    # and Improving the Training Dynamics of Diffusion Models, CVPR 2024) with gamma = 8. It forgets the random start.
    get_ema_multi_avg_fn((1 + int(count)) / (10 + int(count)))(average, weights, count)  # type: ignore[no-untyped-call]


def _below(prefix: str, tensors: dict[str, Tensor]) -> dict[str, Tensor]:
    return {name.removeprefix(prefix): t for name, t in tensors.items() if name.startswith(prefix)}


class Muon(torch.optim.Optimizer):
    """Muon (Jordan et al., 2024, kellerjordan.github.io): weights that are matrices (convolutions: outputs by all else)
    move along their orthogonalised momentum, by the learning rate `lr`; all other weights by Adam, with a tenth of it.
    """

    def __init__(self, weights: Iterable[Tensor], *, lr: float, weight_decay: float) -> None:
        super().__init__(weights, {"lr": lr, "weight_decay": weight_decay})

    @torch.no_grad()
    def step(self, closure: Any = None) -> Any:
        """One step along the gradients."""
        assert closure is None
        for group in self.param_groups:
            for weight in group["params"]:
                if weight.grad is None:
                    continue
                if weight.ndim > 1 and min(len(weight), weight[0].numel()) >= _LEAST_SIDE:
                    self._step_of_matrix(weight, weight.grad, group["lr"], group["weight_decay"])
                else:
                    self._step_of_others(weight, weight.grad, _ADAM_RATE * group["lr"])

    def _step_of_matrix(self, weight: Tensor, gradient: Tensor, rate: float, decay: float) -> None:
        state = self.state[weight]
        if not state:
            state["momentum"] = torch.zeros_like(weight)
        momentum = state["momentum"].lerp_(gradient, 1 - _MOMENTUM)
        towards = gradient.lerp(momentum, _MOMENTUM).flatten(1)  # Nesterov's
        rows, columns = towards.shape
        size = rate * max(1.0, rows / columns) ** 0.5
        weight.mul_(1 - rate * decay).add_(orthogonalised(towards).view_as(weight), alpha=-size)

    def _step_of_others(self, weight: Tensor, gradient: Tensor, rate: float) -> None:
        state, (first, second) = self.state[weight], _ADAM_BETAS
        if not state:
            state["step"] = torch.zeros(())
            state["mean"], state["square"] = torch.zeros_like(weight), torch.zeros_like(weight)
        state["step"] += 1
        mean = state["mean"].lerp_(gradient, 1 - first) / (1 - first ** state["step"])
        square = state["square"].lerp_(gradient**2, 1 - second) / (1 - second ** state["step"])
        weight.add_(mean / (square.sqrt() + _ADAM_EPSILON), alpha=-rate)


def orthogonalised(matrix: Tensor) -> Tensor:
    """The matrix [M, N] with singular values between about 0.7 and 1.2, by Newton-Schulz steps.

    The steps are taken on what stands before the matrix, which is square and small, and not on itself.
    """
    a, b, c = _NEWTON_SCHULZ
    tall = matrix.shape[0] > matrix.shape[1]
    x = (matrix.T if tall else matrix) / (matrix.norm() + 1e-7)
    gram, before = x @ x.T, torch.eye(len(x), device=x.device)
    for _ in range(_NEWTON_SCHULZ_STEPS):
        now = before @ gram @ before.T
        before = a * before + (b * now + c * now @ now) @ before
    x = before @ x
    return x.T if tall else x
