"""Arms of the generator: networks, trained alike and for the same processor time, scored on unseen streets.

    lidardraft streets -n 800 --poses 2 --seed 7 -o FOLDER
    python benches/generator_arms.py --pairs FOLDER [--seconds 100] [-n 10] [--only NAME]

All see the same pairs in the same order, four at a step, and are sampled by the same solver, without `postprocess`. The
seconds are those that the processor spends on gradient steps, in one thread; what a step costs decides how many there
are. A base that is frozen under a ControlNet takes the first half of them.
"""

from __future__ import annotations

import argparse
import dataclasses
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from typing import Protocol

import numpy as np
import torch
from torch import Tensor, nn
from torch.optim.swa_utils import AveragedModel
from torch.utils.flop_counter import FlopCounterMode

from generated_streets import scores_by_kind
from generator_losses import Loss, apart, in_metres, squared, without_air
from lidardraft import RangeImage, Sensor
from lidardraft.cli.arguments import positive, whole_number
from lidardraft.diffusion.codec import (
    CONDITION_CHANNELS,
    STATE_CHANNELS,
    decode_scan,
    encode_condition,
    encode_rays,
    encode_scan,
)
from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.diffusion.denoiser_config import DenoiserConfig
from lidardraft.diffusion.noise import add_noise, training_levels
from lidardraft.diffusion.sampler import sample
from lidardraft.evaluation import unseen_streets
from lidardraft.networks.precision import reduced_precision
from lidardraft.streets import StreetPair
from lidardraft.training.loop import prefetched
from lidardraft.training.pairs import Pair, PairFolder
from markdown_table import Row, table

BATCH, RATE, WARMUP, DECAY, EMA = 4, 2e-3, 40, 0.4, 0.99
STARTS = ((None, 20), (0.5, 4))  # noise level and calls
COLUMNS = ("agreeing", "objects", "dropped", "range", "BEV", "holes in 1,000", "lone %")
CPU = torch.device("cpu")
Clock = Callable[[], float]


class Network(Protocol):
    """What an arm trains: `Denoiser.denoise`, and a module's parameters."""

    cell: tuple[int, int]

    def denoise(
        self, x: Tensor, sigma: Tensor, rays: Tensor, condition: Tensor | None, *, wraps: bool, decide: bool
    ) -> Tensor: ...


def draw_levels(count: int, generator: torch.Generator) -> Tensor:
    """Noise levels [count] to train on, those of the pilots: log-normal."""
    return training_levels(count, generator, mean=-1.5, std=1.6)


@dataclass(frozen=True, kw_only=True)
class Arm:
    """One row: the network, what it learns by, and whether half of its time goes to a base that is then frozen."""

    make: Callable[[], nn.Module]
    loss: Loss = squared
    levels: Callable[[int, torch.Generator], Tensor] = draw_levels
    frozen: DenoiserConfig | None = None  # with the ControlNet on the base that `make` makes


SMALL = DenoiserConfig(cell=(2, 4), widths=(48, 64, 96), strides=(1, 2, 2), dilations=(1, 1, 1))


def denoiser_arm(loss: Loss = squared, **changes: object) -> Arm:
    """`SMALL` with some fields changed."""
    config = dataclasses.replace(SMALL, **changes)  # type: ignore[arg-type]
    return Arm(make=lambda: Denoiser.from_config(config), loss=loss)


def frozen_arm(*, copy_gate: bool) -> Arm:
    """A ControlNet on a base that has learned without a condition."""
    config = dataclasses.replace(SMALL, controlnet=True, copy_gate=copy_gate)
    base = dataclasses.replace(SMALL, condition=(), copy_gate=copy_gate)
    return Arm(make=lambda: Denoiser.from_config(base), frozen=config)


ARMS = {
    "concatenated": denoiser_arm(),
    "concatenated, no copy gate": denoiser_arm(copy_gate=False),
    "ControlNet, trained jointly": denoiser_arm(controlnet=True),
    "ControlNet, trained jointly, no copy gate": denoiser_arm(controlnet=True, copy_gate=False),
    "ControlNet on a frozen base": frozen_arm(copy_gate=True),
    "ControlNet on a frozen base, no copy gate": frozen_arm(copy_gate=False),
    "loss: validity apart": denoiser_arm(apart),
    "loss: depth of the ground in metres": denoiser_arm(in_metres),
    "loss: nothing in the air": denoiser_arm(without_air),
}


def learned(arm: Arm, pairs: PairFolder, seconds: float, clock: Clock = time.thread_time) -> tuple[Denoiser, int]:
    """The network of an arm after so many seconds of processor time, as the average of its weights; its steps."""
    torch.manual_seed(0)
    network = arm.make()
    if arm.frozen is None:
        return _learned(network, arm, pairs, seconds, clock, with_condition=True)
    base, first = _learned(network, arm, pairs, seconds / 2, clock, with_condition=False)
    network, steps = _learned(base.with_controlnet(arm.frozen), arm, pairs, seconds / 2, clock, with_condition=True)
    return network, first + steps


def _learned(
    network: nn.Module, arm: Arm, pairs: PairFolder, seconds: float, clock: Clock, *, with_condition: bool
) -> tuple[Denoiser, int]:
    weights = [weight for weight in network.parameters() if weight.requires_grad]
    optimiser = torch.optim.AdamW(weights, RATE, betas=(0.9, 0.99))
    average = AveragedModel(network, avg_fn=_young_average)
    rays, spent, step = torch.from_numpy(encode_rays(pairs.sensor)), 0.0, 0
    with closing(prefetched(partial(_batch, pairs), 0)) as batches:
        while spent < seconds:
            clean, condition = next(batches)
            generator = torch.Generator().manual_seed(step)
            sigma, noise = arm.levels(len(clean), generator), torch.randn(clean.shape, generator=generator)
            given, wraps = condition if with_condition else None, pairs.sensor.wraps
            began = clock()
            for group in optimiser.param_groups:
                group["lr"] = RATE * min(1.0, (step + 1) / WARMUP, (1 - spent / seconds) / DECAY)
            with reduced_precision(CPU):
                denoised = network.denoise(
                    add_noise(clean, sigma, noise), sigma, rays, given, wraps=wraps, decide=False
                )
            optimiser.zero_grad(set_to_none=True)
            arm.loss(denoised, clean, sigma, condition).mean().backward()
            nn.utils.clip_grad_norm_(weights, 1.0)
            optimiser.step()
            average.update_parameters(network)
            spent, step = spent + clock() - began, step + 1
    return average.module.eval(), step


def _young_average(average: Tensor, weight: Tensor, count: Tensor | int) -> Tensor:
    return average.lerp(weight, 1 - min(EMA, (1 + int(count)) / (10 + int(count))))


def _batch(pairs: PairFolder, step: int) -> tuple[Tensor, Tensor]:
    """Clean states and conditions of a step, mirrored half the time."""
    drawn: list[Pair] = pairs.pairs(step, BATCH)
    clean = torch.from_numpy(np.stack([encode_scan(pair.scan) for pair in drawn]))
    condition = torch.from_numpy(np.stack([encode_condition(pair.condition_image, pair.simulated) for pair in drawn]))
    if np.random.default_rng(step).random() < 0.5:
        return clean.flip(-1), condition.flip(-1)
    return clean, condition


@torch.inference_mode()
def sampled(network: Network, pair: StreetPair, start: float | None, calls: int) -> RangeImage:
    """A scan of a pair's layout, from its simulated scan under noise of the level `start`, or from noise alone."""
    assert pair.simulated is not None
    sensor = pair.scan.sensor
    condition = torch.from_numpy(encode_condition(pair.condition_image, pair.simulated))[None]
    # of a denoiser it asks for what a `Network` has
    states = sample(network, sensor, seeds=[pair.index], condition=condition, steps=calls, start=start)  # type: ignore[arg-type]
    *_, state = states
    return decode_scan(state[0].numpy(), sensor)


def gflop(network: Network, sensor: Sensor) -> float:
    """Billions of multiplications and additions of one call."""
    x, one = torch.zeros(1, STATE_CHANNELS, *sensor.shape), torch.ones(1)
    condition = torch.zeros(1, CONDITION_CHANNELS, *sensor.shape)
    with FlopCounterMode(display=False) as counter, torch.inference_mode():
        network.denoise(x, one, torch.from_numpy(encode_rays(sensor)), condition, wraps=True, decide=True)
    return counter.get_total_flops() / 1e9


def rows_of(arms: Mapping[str, Arm], pairs: PairFolder, seconds: float, num: int) -> Iterator[tuple[str, Row]]:
    """The rows of all arms, and before them that of the simulated scans."""
    unseen = unseen_streets(num, sensor=pairs.sensor)
    simulated = None
    for name, arm in arms.items():
        network, steps = learned(arm, pairs, seconds)
        size = sum(weight.numel() for weight in network.parameters())  # type: ignore[attr-defined]
        cost = {"million weights": size / 1e6, "GFLOP a call": gflop(network, pairs.sensor), "steps": float(steps)}
        for start, calls in STARTS:
            found = scores_by_kind(unseen, [sampled(network, pair, start, calls) for pair in unseen])
            if simulated is None:
                simulated = found["simulated"]
                yield "simulated scan", {column: simulated[column] for column in COLUMNS}
            label = f"{name}; {'noise' if start is None else f'{start:g}'}, {calls} calls"
            yield label, cost | {column: found["generated"][column] for column in COLUMNS}


def compare(arms: Mapping[str, Arm], description: str | None) -> None:
    """Parse, train, print a row as soon as it is there, and the table at the end."""
    parser = argparse.ArgumentParser(description=(description or "").split("\n")[0])
    parser.add_argument("--pairs", required=True, metavar="FOLDER", help="as `lidardraft streets -o FOLDER` makes them")
    parser.add_argument("--seconds", type=positive, default=100.0, help="processor time of each arm (default 100)")
    parser.add_argument("-n", "--num", type=whole_number(2), default=10, help="unseen streets (default 10)")
    parser.add_argument("--only", default="", metavar="NAME", help="arms whose names hold this")
    given = parser.parse_args()
    torch.set_num_threads(1)
    chosen = {name: arm for name, arm in arms.items() if given.only in name}
    rows: dict[str, Row] = {}
    for name, row in rows_of(chosen, PairFolder(given.pairs), given.seconds, given.num):
        rows[name] = row
        print(name, {column: round(float(value), 4) for column, value in row.items()}, flush=True)
    print(table(rows))


if __name__ == "__main__":
    compare(ARMS, __doc__)
