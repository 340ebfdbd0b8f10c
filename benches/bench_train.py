"""Scans a second that the generator learns from, and what a step asks of the device.

    python benches/bench_train.py [--recipe paper-small] [--device cpu] [--batch N] [--steps 8] [--peak TFLOPS]

Each stage of a recipe learns from eight streets, whole scans of 64 x 1024, held in memory. Printed are the median of
the steps' scans a second, the operators of a step that are no views (each a kernel or more), how often a step reads a
number back from its device, which makes the host wait, and the bytes of a batch that cross to it. With `--peak`, the
share of so many TFLOP/s that the convolutions reach; a gradient counts twice its call.
"""

from __future__ import annotations

import argparse
import dataclasses
import itertools
import statistics
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import torch
from torch.utils._python_dispatch import TorchDispatchMode
from torch.utils.flop_counter import FlopCounterMode

from lidardraft import Sensor
from lidardraft.evaluation import unseen_streets
from lidardraft.formats.pairs import IMAGES, Pair, write_pairs
from lidardraft.training import denoising, recipes
from lidardraft.training.denoising import DenoisingConfig
from lidardraft.training.learner import Learner
from lidardraft.training.loop import device_for_training
from lidardraft.training.processes import ALONE
from lidardraft.training.sources import PairFolder

_STREETS = 8
_VIEWS = ("view", "select", "aten.t.", "transpose", "expand", "detach", "unsqueeze", "slice", "permute", "split")
_READS = ("_local_scalar_dense", "nonzero", "masked_select")


class _Counted(TorchDispatchMode):
    """Counts operators on tensors with dimensions; numbers on the CPU that steer the optimiser are none."""

    def __init__(self) -> None:
        super().__init__()
        self.counts: Counter[str] = Counter()

    def __torch_dispatch__(self, function: Any, types: Any, args: Any = (), kwargs: Any = None) -> Any:
        name = str(function)
        if any(read in name for read in _READS):
            self.counts["reads"] += 1
        elif not any(view in name for view in _VIEWS):
            self.counts["operators"] += 1
        return function(*args, **(kwargs or {}))


@contextmanager
def _pairs(sensor: Sensor) -> Iterator[PairFolder]:
    with tempfile.TemporaryDirectory() as folder:
        found = unseen_streets(_STREETS, sensor=sensor, seed=5)
        list(write_pairs(folder, ((Pair(p.scan, p.condition_image, p.simulated), {}) for p in found)))
        yield PairFolder(folder)


def measured(config: DenoisingConfig, pairs: PairFolder, device: torch.device, steps: int) -> str:
    """A line on one stage."""
    begin = denoising.beginning(dataclasses.replace(config, denoiser=_base(config)), None)
    denoiser = denoising.beginning(config, begin).to(device).train()
    learner, took = Learner(denoiser, config), []

    def step(number: int) -> int:
        batch = denoising._batch(config, number, source=pairs, processes=ALONE, device=device)
        with denoising.reduced_precision(device):
            losses = denoiser.loss(*batch[:-1], wraps=batch.wraps)
        learner.step(number, losses)
        return len(batch.clean)

    step(0)
    with _Counted() as counted:
        step(1)
    with FlopCounterMode(display=False) as flop:
        step(2)
    for number in itertools.islice(itertools.count(3), steps):
        began = time.perf_counter()
        scans = step(number)
        if device.type == "cuda":
            torch.cuda.synchronize()
        took.append(scans / (time.perf_counter() - began))
    speed = statistics.median(took)
    crossing = 0.0 if device.type == "cuda" and pairs._placed == device else _bytes(pairs) * config.batch / 1e6
    told = f"{speed:8.1f} scans/s {counted.counts['operators']:6} operators {counted.counts['reads']:4} reads"
    return f"{told} {crossing:6.1f} MB a batch {flop.get_total_flops() / scans * speed / 1e12:8.2f} TFLOP/s"


def _base(config: DenoisingConfig) -> Any:
    return dataclasses.replace(config.denoiser, condition=(), controlnet=False)


def _bytes(pairs: PairFolder) -> int:
    return sum(dtype().itemsize for dtype in IMAGES.values()) * pairs.sensor.shape[0] * pairs.sensor.shape[1]


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--recipe", default="paper-small")
    parser.add_argument("--device", default=None)
    parser.add_argument("--batch", type=int)
    parser.add_argument("--steps", type=int, default=8)
    parser.add_argument("--sensor", default="hdl64e")
    parser.add_argument("--peak", type=float)
    given = parser.parse_args()
    device = device_for_training(given.device)
    stages = getattr(recipes, given.recipe.replace("-", "_"))()
    with _pairs(Sensor.preset(given.sensor)) as pairs:
        for name, stage in {"base": stages[-2], "last stage": stages[-1]}.items():
            config = dataclasses.replace(stage, batch=given.batch or stage.batch, thinnings=(1,))
            line = measured(config, pairs, device, given.steps)
            if given.peak:
                line += f" {float(line.split()[-2]) / given.peak:6.1%} of the peak"
            print(f"{name:12}{line}", flush=True)


if __name__ == "__main__":
    main()
