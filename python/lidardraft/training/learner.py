"""The state of a run that gradient steps change: weights, their average and the optimiser, which is Muon."""

from __future__ import annotations

import copy
import dataclasses
import json
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import save as serialise
from torch import Tensor

from lidardraft.errors import TrainingError
from lidardraft.files import regular_size, written_whole
from lidardraft.networks import weight_file
from lidardraft.networks.weight_file import Network
from lidardraft.training.processes import ALONE, Processes

_NEWTON_SCHULZ = (3.4445, -4.7750, 2.0315)  # the authors' coefficients: near 1 in five steps, not exact
_NEWTON_SCHULZ_STEPS = 5
_MOMENTUM = 0.95
_LEAST_SIDE = 16  # of a matrix; in smaller ones every direction is learned in any case
_ADAM_RATE = 0.1  # of the learning rate
_ADAM_BETAS, _ADAM_EPSILON = (0.9, 0.99), 1e-8


@dataclass(frozen=True, kw_only=True)
class LearningConfig:
    """Parameters of learning.

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
        """The fields as JSON types, without those that may differ between the slices of a run."""
        free = ("steps", "save_every", "report_every", "watch_every")
        fields: dict[str, Any] = json.loads(json.dumps(dataclasses.asdict(self)))
        return {name: v for name, v in fields.items() if name not in free}


@dataclass(frozen=True)
class RunIdentity:
    """The properties that must be the same in all slices of a run: the config, and checksums of the pairs and of the
    initial weights, be they random, given or the frozen base of a ControlNet.

    `folder` is the place of the pairs; they may be moved.
    """

    config: dict[str, Any]
    weights: int
    pairs: int
    folder: str = field(compare=False)

    def check(self, path: Path, begun: RunIdentity) -> None:
        """Raise `TrainingError` if the run that wrote `path` had `begun` with another identity."""
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
    """The trainable weights of a network, their moving average and the optimiser. Nothing here waits for the device."""

    def __init__(self, network: Network, config: LearningConfig) -> None:
        self.config, self.network = config, network
        self.weights = [p for p in network.parameters() if p.requires_grad]
        self.averaged = copy.deepcopy(network)
        self.optimiser = Muon(self.weights, lr=config.learning_rate, weight_decay=config.weight_decay)

    def step(self, step: int, losses: Tensor, processes: Processes = ALONE) -> Tensor:
        """One gradient step on the mean of the losses of all processes' samples; returns the norm of the gradient,
        which is clipped to `max_gradient`. A step whose norm is not finite spoils the weights: the caller checks the
        norm and ends the run.
        """
        for group in self.optimiser.param_groups:
            group["lr"] = self.config.rate(step)
        self.optimiser.zero_grad(set_to_none=True)
        mean = losses.sum() / processes.total(losses.numel(), losses.device)
        mean.backward()  # type: ignore[no-untyped-call]
        learned = [weight for weight in self.weights if weight.grad is not None]
        gradient = torch.cat([weight.grad.flatten() for weight in learned if weight.grad is not None])
        processes.add_up(gradient)
        norm = gradient.norm()
        gradient *= (self.config.max_gradient / (norm + 1e-6)).clamp(max=1)
        for weight, part in zip(learned, torch.split(gradient, [w.numel() for w in learned]), strict=True):
            weight.grad = part.view_as(weight)
        self.optimiser.step()
        self._average(step)
        return norm

    @torch.no_grad()
    def _average(self, step: int) -> None:
        # A window that grows with the training, about a tenth of its length: the power profile of Karras et al.
        # (Analyzing and Improving the Training Dynamics of Diffusion Models, CVPR 2024) with gamma = 8. It forgets the
        # random start.
        averages, weights = (list[Tensor](each.parameters()) for each in (self.averaged, self.network))
        torch._foreach_lerp_(averages, weights, 9 / (10 + step) if step else 1.0)

    def save(self, run: Path, step: int, source: str, identity: RunIdentity) -> None:
        """Write the average of weights, with a card, and the state from which the next slice of the run continues.

        The state is written last: an interruption before it makes the run repeat these steps.
        """
        card = {"training": dataclasses.asdict(self.config), "step": step, "data": source}
        weight_file.save(self.averaged, run / "weights.safetensors", card)
        tensors = {f"network.{name}": t for name, t in self.network.state_dict().items()}
        tensors |= {f"average.{name}": t for name, t in self.averaged.state_dict().items()}
        for number, state in self.optimiser.state_dict()["state"].items():
            tensors |= {f"optimiser.{number}.{name}": t for name, t in state.items()}
        metadata = {"step": str(step), "run": json.dumps(dataclasses.asdict(identity))}
        with written_whole(run / "state.safetensors") as temporary:
            whole = {name: t.detach().cpu().contiguous() for name, t in tensors.items()}
            temporary.write_bytes(serialise(whole, metadata))

    def resume(self, path: Path, identity: RunIdentity) -> int:
        """Restore the state of an earlier slice of the same run, if there is one; returns the step to continue from.

        Raises `TrainingError` if the file is not a state, or that of another run.
        """
        if not path.exists():
            return 0
        try:
            regular_size(path)
            with safe_open(path, framework="pt") as file:
                metadata, tensors = file.metadata(), {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
            begun, step = RunIdentity(**json.loads(metadata["run"])), int(metadata["step"])
        except (SafetensorError, OSError, KeyError, TypeError, ValueError) as error:
            raise TrainingError(f"{path} is not the state of a run: {error}") from None
        identity.check(path, begun)
        self.network.load_state_dict(_below("network.", tensors))
        self.averaged.load_state_dict(_below("average.", tensors))
        state: dict[int, dict[str, Tensor]] = {}
        for name, tensor in _below("optimiser.", tensors).items():
            number, key = name.split(".")
            state.setdefault(int(number), {})[key] = tensor
        groups = self.optimiser.state_dict()["param_groups"]
        self.optimiser.load_state_dict({"state": state, "param_groups": groups})
        return step


def _below(prefix: str, tensors: dict[str, Tensor]) -> dict[str, Tensor]:
    return {name.removeprefix(prefix): t for name, t in tensors.items() if name.startswith(prefix)}


class Muon(torch.optim.Optimizer):
    """Muon (Jordan et al., 2024, kellerjordan.github.io). Weights that are matrices (convolutions: outputs by all else)
    move along their orthogonalised momentum, by the learning rate `lr`; all other weights by Adam, with a tenth of it.

    Matrices of one shape are processed as one stack, so that a step takes hundreds of kernels and not thousands.
    """

    def __init__(self, weights: Iterable[Tensor], *, lr: float, weight_decay: float) -> None:
        super().__init__(weights, {"lr": lr, "weight_decay": weight_decay})

    @torch.no_grad()
    def step(self, closure: Any = None) -> Any:
        """One step along the gradients."""
        assert closure is None
        for group in self.param_groups:
            weights = [weight for weight in group["params"] if weight.grad is not None]
            matrices = [w for w in weights if w.ndim > 1 and min(_shape(w)) >= _LEAST_SIDE]
            if matrices:
                self._step_of_matrices(matrices, group["lr"], group["weight_decay"])
            if others := [w for w in weights if w.ndim < 2 or min(_shape(w)) < _LEAST_SIDE]:
                self._step_of_others(others, _ADAM_RATE * group["lr"])

    def _states(self, name: str, weights: list[Tensor]) -> list[Tensor]:
        for weight in weights:
            if name not in self.state[weight]:
                self.state[weight][name] = torch.zeros_like(weight)
        return [self.state[weight][name] for weight in weights]

    def _step_of_matrices(self, weights: list[Tensor], rate: float, decay: float) -> None:
        gradients, momenta = _gradients(weights), self._states("momentum", weights)
        torch._foreach_lerp_(momenta, gradients, 1 - _MOMENTUM)
        towards = torch._foreach_lerp(gradients, momenta, _MOMENTUM)  # Nesterov's
        torch._foreach_mul_(weights, 1 - rate * decay)
        numbers: dict[tuple[int, int], list[int]] = {}
        for number, weight in enumerate(weights):
            numbers.setdefault(_shape(weight), []).append(number)
        for (rows, columns), some in numbers.items():
            turned = orthogonalised(torch.stack([towards[number].flatten(1) for number in some]))
            moved = [matrix.view_as(weights[number]) for number, matrix in zip(some, turned, strict=True)]
            size = rate * max(1.0, rows / columns) ** 0.5
            torch._foreach_add_([weights[number] for number in some], moved, alpha=-size)

    def _step_of_others(self, weights: list[Tensor], rate: float) -> None:
        gradients, (first, second) = _gradients(weights), _ADAM_BETAS
        means, squares = self._states("mean", weights), self._states("square", weights)
        for weight in weights:  # these may begin to learn later than others
            self.state[weight]["step"] = self.state[weight].get("step", torch.zeros(())) + 1
        steps: list[float] = torch.stack([self.state[weight]["step"] for weight in weights]).tolist()  # on the CPU
        torch._foreach_lerp_(means, gradients, 1 - first)
        torch._foreach_lerp_(squares, torch._foreach_mul(gradients, gradients), 1 - second)
        moved = torch._foreach_div(means, [1 - first**step for step in steps])
        roots = torch._foreach_sqrt(torch._foreach_div(squares, [1 - second**step for step in steps]))
        torch._foreach_add_(roots, _ADAM_EPSILON)
        torch._foreach_addcdiv_(weights, moved, roots, value=-rate)


def _shape(weight: Tensor) -> tuple[int, int]:
    return len(weight), weight.numel() // len(weight)


def _gradients(weights: list[Tensor]) -> list[Tensor]:
    return [weight.grad for weight in weights if weight.grad is not None]


def orthogonalised(matrices: Tensor) -> Tensor:
    """Each matrix [..., M, N] with singular values between about 0.7 and 1.2, by Newton-Schulz steps.

    The steps work on the factor in front of the matrix, which is square and small, not on the matrix itself.
    """
    a, b, c = _NEWTON_SCHULZ
    tall = matrices.shape[-2] > matrices.shape[-1]
    x = (matrices.mT if tall else matrices) / (matrices.norm(dim=(-2, -1), keepdim=True) + 1e-7)
    gram, before = x @ x.mT, torch.eye(x.shape[-2], device=x.device).expand(*x.shape[:-1], -1)
    for _ in range(_NEWTON_SCHULZ_STEPS):
        now = before @ gram @ before.mT
        before = a * before + (b * now + c * now @ now) @ before
    x = before @ x
    return x.mT if tall else x
