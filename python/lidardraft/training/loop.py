"""The training loop: a network, a loss and a batch function become weights on disk, in one run or in slices."""

from __future__ import annotations

import dataclasses
import itertools
import json
import math
import os
import time
import warnings
import zlib
from collections.abc import Callable, Generator, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing, contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import torch
from torch import Tensor, nn

from lidardraft.errors import FormatError, TrainingError
from lidardraft.files import written_whole
from lidardraft.json_fields import is_number, parse_object
from lidardraft.networks.weight_file import Network
from lidardraft.training.learner import Learner, LearningConfig, RunIdentity
from lidardraft.training.processes import Processes
from lidardraft.training.sources import PairSource

Batch = TypeVar("Batch")
ConfigT = TypeVar("ConfigT", bound=LearningConfig)
Measures = dict[str, Tensor]


@dataclass(frozen=True, kw_only=True)
class Report:
    """Means since the last report: the loss, the norm of the gradient, and the other measures of the loss function,
    None if it has measured nothing."""

    step: int
    loss: float
    gradient: float
    measures: dict[str, float | None]
    samples_per_second: float
    minutes: float


def train(
    config: ConfigT,
    network: Network,
    batch: Callable[[ConfigT, int], Batch],
    loss: Callable[[int, Batch], tuple[Tensor, Measures]],
    data: PairSource,
    run: str | os.PathLike[str],
    *,
    device: torch.device,
    max_minutes: float = float("inf"),
) -> Iterator[Report]:
    """Train a `network` and yield reports.

    `batch(config, step)` makes the input of a step while the previous step runs. It must depend on both alone, so that
    a run in slices gives the weights of an uninterrupted run. `loss(step, batch)` gives the losses of the samples,
    whose mean is minimised, and named tensors of numbers, whose means without NaN are reported. With several processes
    (`Processes`) each has its share of the samples; the gradients are added, reports cover the samples of all, and the
    first process writes. Numbers stay on the device until a report or a state is due; then a loss or a gradient that
    was not finite ends the run, and the files on disk stay unchanged.

    The folder `run` receives `log.jsonl`, `state.safetensors` to continue from after an interruption or `max_minutes`,
    and `weights.safetensors`, the average of weights. A report is yielded after everything due at its step is on disk.
    Raises `TrainingError` if `run` cannot be a folder, the run in it is another, the training fails, or memory lacks.
    """
    run = Path(run)
    check_run_folder(run)
    identity, processes = _identity(config, network, data), Processes.from_environment(device)
    learner = Learner(network.to(device).train(), config)
    start = learner.resume(run / "state.safetensors", identity)
    run.mkdir(parents=True, exist_ok=True)
    if processes.rank == 0:
        _cut_log(run / "log.jsonl", start)
    began, window = time.monotonic(), _Window()
    upcoming = _prefetched(partial(batch, config), start)

    with closing(upcoming):
        for step in range(start, config.steps):
            with naming_lack_of_memory(config.batch, step):
                losses, measures = loss(step, next(upcoming))
                window.add(losses.detach(), learner.step(step, losses, processes), measures)
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
            if saves and processes.rank == 0:
                learner.save(run, step + 1, data.source, identity)
            if report:
                yield report
            if last:
                return


def _prefetched(batch: Callable[[int], Batch], start: int) -> Generator[Batch, None, None]:
    """`batch(step)` of each step from `start` on; the next one is made while the caller uses this one."""
    with ThreadPoolExecutor(1) as loader:
        upcoming = loader.submit(batch, start)
        for step in itertools.count(start + 1):
            tensors, upcoming = upcoming.result(), loader.submit(batch, step)
            yield tensors


def check_run_folder(run: str | os.PathLike[str]) -> None:
    """Raise `TrainingError` if a file is in the place of the folder of a run, or of one above it."""
    for folder in (Path(run), *Path(run).parents):
        if folder.exists() and not folder.is_dir():
            raise TrainingError(f"{folder} is a file; it must be a folder")


def device_for_training(name: str | None = None) -> torch.device:
    """The torch device of that name, by default the GPU if there is one; of several GPUs that of `LOCAL_RANK`, which
    `torchrun` sets. Raises `TrainingError` if there is no such device, or for a GPU that torch cannot use."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        there = torch.cuda.is_available()
    if name is None and told:  # by torch, on a driver or a GPU that does not fit: a CPU would silently take days
        said = str(told[0].message).split(". ")[0]
        raise TrainingError(f"the GPU cannot be used: {said}; --device cpu trains without it")
    name = name or ("cuda" if there else "cpu")
    try:
        device = torch.device(name)
        if name == "cuda":
            device = torch.device("cuda", int(os.environ.get("LOCAL_RANK", "0")))
            torch.cuda.set_device(device)
            torch.set_float32_matmul_precision("high")  # TF32, for computations that are not in bfloat16
        torch.empty(0, device=device)
    except (RuntimeError, AssertionError, NotImplementedError) as error:  # torch's, for a device it does not have
        raise TrainingError(f"device is {name!r}: {str(error).splitlines()[0]}") from None
    return device


@contextmanager
def naming_lack_of_memory(batch: int, step: int) -> Iterator[None]:
    """Raises `TrainingError` with an advice if memory lacks in the block, on any device."""
    try:
        yield
    except (MemoryError, RuntimeError) as error:  # torch raises RuntimeErrors, of one kind for a GPU alone
        text = (str(error) or "MemoryError").splitlines()[0]
        if not isinstance(error, MemoryError) and "out of memory" not in text and "t allocate memory" not in text:
            raise
        needs = f"step {step + 1} of batches of {batch} needs more memory than there is"
        raise TrainingError(f"{needs}; a smaller --batch needs less ({text})") from None


class _Window:
    """The measures since the last report."""

    def __init__(self) -> None:
        self.began = time.monotonic()
        self.steps: list[Tensor] = []  # mean loss and norm of the gradient of each
        self.sums: dict[str, tuple[Tensor, Tensor]] = {}  # sum and count of the values that are not NaN

    def add(self, losses: Tensor, gradient: Tensor, measures: Measures) -> None:
        self.steps.append(torch.stack([losses.mean(), gradient]))
        for name, values in ({"loss": losses} | measures).items():
            total, count = self.sums.get(name, (0, 0))
            self.sums[name] = total + values.nansum(), count + (~values.isnan()).sum()

    def check(self, step: int) -> None:
        """Raise `TrainingError` if a loss or a gradient of the steps up to `step` was not finite."""
        for number, (loss, gradient) in enumerate(torch.stack(self.steps).tolist(), step - len(self.steps) + 1):
            if not math.isfinite(loss + gradient):
                raise TrainingError(f"the loss is {loss} and its gradient {gradient} at step {number}")

    def report(self, step: int, minutes: float, processes: Processes, device: torch.device) -> Report:
        """Means over all processes; all of them must call this."""
        sums = {name: [processes.total(own.item(), device) for own in pair] for name, pair in self.sums.items()}
        means = {name: total / count if count else None for name, (total, count) in sums.items()}
        return Report(
            step=step,
            loss=means.pop("loss") or 0.0,
            gradient=torch.stack(self.steps)[:, 1].mean().item(),
            measures=means,
            samples_per_second=sums["loss"][1] / (time.monotonic() - self.began),
            minutes=minutes,
        )


def _identity(config: LearningConfig, network: nn.Module, data: PairSource) -> RunIdentity:
    weights = 0
    for p in network.parameters():
        weights = zlib.crc32(p.detach().cpu().numpy().tobytes(), weights)
    return RunIdentity(config.of_any_length(), weights, data.checksum, str(data.path))


def _log(path: Path, report: Report) -> None:
    with path.open("a") as log:
        log.write(json.dumps(dataclasses.asdict(report)) + "\n")


def _cut_log(path: Path, step: int) -> None:
    """Drop the reports after `step`: a killed run may have reported steps that its state does not hold.

    Lines that are not reports are dropped too.
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
