"""The training loop: a network, a loss and a batch function become weights on disk, in one run or in slices."""

from __future__ import annotations

import dataclasses
import itertools
import json
import os
import time
import zlib
from collections.abc import Callable, Generator, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol, TypeVar

import torch
from torch import Tensor, nn

from lidardraft.errors import FormatError, TrainingError
from lidardraft.files import written_whole
from lidardraft.json_fields import is_number, parse_object
from lidardraft.networks import weight_file
from lidardraft.networks.weight_file import Network
from lidardraft.training.learner import Learner, LearningConfig, RunIdentity
from lidardraft.training.processes import Processes

Batch = TypeVar("Batch")
Measures = dict[str, Tensor]


class Data(Protocol):
    """What a run learns from: where it came from in words, where it lies, and a checksum."""

    @property
    def source(self) -> str: ...
    @property
    def path(self) -> Path: ...
    @property
    def checksum(self) -> int: ...


@dataclass(frozen=True, kw_only=True)
class Report:
    """Means since the last report: the loss, the norm of the gradient, and what else the loss function has measured,
    None where it has measured nothing."""

    step: int
    loss: float
    gradient: float
    measures: dict[str, float | None]
    samples_per_second: float
    minutes: float


def train(
    config: LearningConfig,
    network: Network,
    batches: Callable[[int], Generator[Batch, None, None]],
    loss: Callable[[int, Batch], tuple[Tensor, Measures]],
    data: Data,
    run: str | os.PathLike[str],
    *,
    device: torch.device,
    max_minutes: float = float("inf"),
) -> Iterator[Report]:
    """Train a `network` and yield reports.

    `batches(start)` gives the batch of each step from `start` on. It follows from the step alone, so that a run in
    slices gives the weights of a run in one. `loss(step, batch)` gives the losses of the samples, whose mean is stepped
    on, and tensors of numbers by name, whose means are reported without those that are NaN. Of several processes
    (`Processes`) each has its share of the samples; the gradients are added, reports are of the samples of all, and the
    first one writes. Numbers stay on the device until a report or a state is due: then a loss or a gradient that was
    not finite ends the run, and what is on disk stays as it is.

    The folder `run` receives `log.jsonl`, `state.safetensors` to go on from after an interruption or `max_minutes`, and
    `weights.safetensors`, the average of weights. A report is yielded after what is due at its step is on disk. Raises
    `TrainingError` where `run` cannot be a folder, the run in it is another, or the training has gone wrong.
    """
    run = Path(run)
    check_run_folder(run)
    identity, processes = _identity(config, network, data), Processes.from_environment(device)
    learner = Learner(network.to(device).train(), config)
    start = learner.resume(run / "state.safetensors", identity)
    if start >= config.steps:
        return
    run.mkdir(parents=True, exist_ok=True)
    if processes.rank == 0:
        _cut_log(run / "log.jsonl", start)
    began, window = time.monotonic(), _Window()
    with closing(batches(start)) as upcoming:
        for step in range(start, config.steps):
            with memory_of(f"step {step + 1} of batches of {config.batch}"):
                losses, measures = loss(step, next(upcoming))
                mean = losses.sum() / processes.total(losses.numel(), device)
                window.add(losses.detach(), learner.step(step, mean, processes), measures)
            minutes = (time.monotonic() - began) / 60
            # all processes stop at the same step
            last = step + 1 == config.steps or processes.total(minutes > max_minutes, device) > 0
            saves, reports = (last or (step + 1) % every == 0 for every in (config.save_every, config.report_every))
            if saves or reports:
                window.check(step + 1)
            report = window.report(step + 1, minutes, processes, device) if reports else None
            window = _Window() if reports else window
            if report and processes.rank == 0:
                _log(run / "log.jsonl", report)
            if processes.rank == 0 and saves:
                card = {"training": dataclasses.asdict(config), "step": step + 1, "data": data.source}
                weight_file.save(learner.averaged, run / "weights.safetensors", card)
                # The state last: what is killed before it is done again.
                learner.save(run / "state.safetensors", step + 1, identity)
            if report:
                yield report
            if last:
                return


def prefetched(batch: Callable[[int], Batch], start: int) -> Generator[Batch, None, None]:
    """`batch(step)` of each step from `start` on, the next one made while one is learned from."""
    with ThreadPoolExecutor(1) as loader:
        upcoming = loader.submit(batch, start)
        for step in itertools.count(start + 1):
            tensors, upcoming = upcoming.result(), loader.submit(batch, step)
            yield tensors


def check_run_folder(run: str | os.PathLike[str]) -> None:
    """Raise `TrainingError` where a file is in the place of the folder of a run, or of one above it."""
    for folder in (Path(run), *Path(run).parents):
        if folder.exists() and not folder.is_dir():
            raise TrainingError(f"{folder} is a file; it must be a folder")


def device_for_training(name: str | None = None) -> torch.device:
    """The torch device of that name, by default the GPU if there is one; of several GPUs that of `LOCAL_RANK`, which
    `torchrun` sets. Raises `TrainingError` if there is none of that name."""
    name = name or ("cuda" if torch.cuda.is_available() else "cpu")
    try:
        device = torch.device(name)
        if name == "cuda":
            device = torch.device("cuda", int(os.environ.get("LOCAL_RANK", "0")))
            torch.cuda.set_device(device)
            torch.set_float32_matmul_precision("high")  # TF32, of what is not in bfloat16
        torch.empty(0, device=device)
    except (RuntimeError, AssertionError, NotImplementedError) as error:  # torch's, for a device it does not have
        raise TrainingError(f"device is {name!r}: {str(error).splitlines()[0]}") from None
    return device


@contextmanager
def memory_of(what: str) -> Iterator[None]:
    """Raise `TrainingError` where the block asks for more memory than there is, on whatever device."""
    try:
        yield
    except (MemoryError, RuntimeError) as error:  # torch raises RuntimeErrors, of one kind for a GPU alone
        text = str(error).splitlines()[0] if str(error) else ""
        if isinstance(error, MemoryError) or "out of memory" in text or "t allocate memory" in text:
            raise TrainingError(f"{what} needs more memory than there is; use a smaller --batch ({text})") from None
        raise


class _Window:
    """What has been measured since the last report."""

    def __init__(self) -> None:
        self.began = time.monotonic()
        self.losses: list[Tensor] = []
        self.gradients: list[Tensor] = []
        self.sums: dict[str, tuple[Tensor, Tensor]] = {}  # sum and count of what is not NaN

    def add(self, losses: Tensor, gradient: Tensor, measures: Measures) -> None:
        self.losses.append(losses.mean())
        self.gradients.append(gradient)
        for name, values in ({"loss": losses} | measures).items():
            total, count = self.sums.get(name, (0, 0))
            self.sums[name] = total + values.nansum(), count + (~values.isnan()).sum()

    def check(self, step: int) -> None:
        """Raise `TrainingError` if a loss or a gradient of the steps up to `step` was not finite."""
        found = torch.stack([torch.stack(self.losses), torch.stack(self.gradients)]).cpu()
        (bad,) = (~found.isfinite().all(0)).nonzero(as_tuple=True)
        if len(bad):
            loss, gradient = found[:, bad[0]].tolist()
            first = step - len(self.losses) + int(bad[0]) + 1
            raise TrainingError(f"the loss is {loss} and its gradient {gradient} at step {first}")

    def report(self, step: int, minutes: float, processes: Processes, device: torch.device) -> Report:
        """Means over all processes, which must all ask for them."""
        means: dict[str, float | None] = {}
        samples = 0.0
        for name, (own_total, own_count) in self.sums.items():
            total, count = (processes.total(own.item(), device) for own in (own_total, own_count))
            means[name] = total / count if count else None
            samples = count if name == "loss" else samples
        loss = means.pop("loss")
        assert loss is not None
        return Report(
            step=step,
            loss=loss,
            gradient=torch.stack(self.gradients).mean().item(),
            measures=means,
            samples_per_second=samples / (time.monotonic() - self.began),
            minutes=minutes,
        )


def _identity(config: LearningConfig, network: nn.Module, data: Data) -> RunIdentity:
    weights = 0
    for p in network.parameters():
        weights = zlib.crc32(p.detach().cpu().numpy().tobytes(), weights)
    return RunIdentity(config.of_any_length(), weights, data.checksum, str(data.path))


def _log(path: Path, report: Report) -> None:
    with path.open("a") as log:
        log.write(json.dumps(dataclasses.asdict(report)) + "\n")


def _cut_log(path: Path, step: int) -> None:
    """Drop the reports after `step`: a run that was killed has reported steps that its state does not hold.

    Lines that are no reports are dropped too.
    """
    if not path.exists():
        return
    kept = []
    for line in path.read_bytes().splitlines():
        try:
            reported: Any = parse_object(line).get("step")
        except FormatError:  # killed while it wrote the line
            continue
        if is_number(reported) and reported <= step:
            kept.append(line + b"\n")
    with written_whole(path) as temporary:
        temporary.write_bytes(b"".join(kept))
