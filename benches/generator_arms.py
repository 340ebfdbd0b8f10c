"""Arms of the generator: networks that learn for the same processor time, scored on unseen streets.

    lidardraft streets -n 800 --poses 2 --seed 7 -o FOLDER
    python benches/generator_arms.py --pairs FOLDER [--seconds 300] [-n 10] [--only NAME]

All learn from the same pairs in the same order, every second beam and column of them, and make whole scans from noise,
with the classes and depths of the layout's cast as the condition. The seconds are those that the processor spends on
gradient steps, in one thread; what a step costs decides how many there are. Objects: share of the returns on objects
that agree with the layout; other: with that of another street; heeded: `evaluation.loss_by_other_layouts`; range, BEV:
Jensen-Shannon distances to the streets' own scans.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing
from dataclasses import dataclass, replace
from functools import partial
from typing import Any
from unittest import mock

import torch
from torch import Tensor, nn
from torch.utils.flop_counter import FlopCounterMode

from lidardraft import RangeImage, Sensor
from lidardraft.cli.arguments import positive, whole_number
from lidardraft.diffusion import denoiser as denoiser_module
from lidardraft.diffusion.codec import CONDITION_CHANNELS, STATE_CHANNELS, decode_scan, encode_condition, encode_rays
from lidardraft.diffusion.denoiser import SIGMA_DATA, SIGMA_TURN, Denoiser
from lidardraft.diffusion.denoiser_config import STEPS
from lidardraft.diffusion.noise import karras_levels
from lidardraft.diffusion.sampler import sample_multistep
from lidardraft.evaluation import loss_by_other_layouts, score, unseen_streets, untrained_weights
from lidardraft.networks.layers import reduced_precision
from lidardraft.streets import StreetPair
from lidardraft.training import denoising, recipes
from lidardraft.training.learner import Learner
from lidardraft.training.loop import prefetched
from lidardraft.training.processes import ALONE
from lidardraft.training.sources import PairFolder
from markdown_table import Row, table

THINNING = 2  # of beams and columns
BASE, *_, CONTROL = recipes.small_paper()
OURS = replace(CONTROL.denoiser, controlnet=False)
CONFIG = replace(BASE, denoiser=OURS, thinnings=(THINNING,), warmup=30)
ADAM_RATE = 2e-3
CPU = torch.device("cpu")
Clock = Callable[[], float]
Stage = Callable[[Any], nn.Module]


@dataclass(frozen=True, kw_only=True)
class Arm:
    """One row: its networks, each made of the one before, with equal parts of the time; what takes the place of Muon
    and of its learning rate; of the noise level at which the network turns to tell the noise; and of the levels that it
    learns from."""

    stages: tuple[Stage, ...] = (lambda _: Denoiser.from_config(OURS),)
    optimiser: Callable[[list[Tensor]], torch.optim.Optimizer] | None = None
    learning_rate: float = CONFIG.learning_rate
    sigma_turn: float = SIGMA_TURN
    levels: Callable[[Tensor], Tensor] = torch.Tensor.clone


ARMS = {
    "ours": Arm(),
    "AdamW in place of Muon": Arm(
        optimiser=partial(torch.optim.AdamW, betas=(0.9, 0.99), weight_decay=CONFIG.weight_decay),
        learning_rate=ADAM_RATE,
    ),
    "sigma turn 0.5 (Karras)": Arm(sigma_turn=SIGMA_DATA),
    "ControlNet on a frozen base": Arm(
        stages=(
            lambda _: Denoiser.from_config(replace(OURS, condition=())),
            lambda base: base.with_controlnet(replace(OURS, controlnet=True)),
        )
    ),
}


def learned(arm: Arm, pairs: PairFolder, seconds: float, clock: Clock = time.thread_time) -> tuple[nn.Module, int]:
    """The network of an arm after so many seconds of processor time, as the average of its weights; its steps."""
    torch.manual_seed(0)
    network, steps = None, 0
    for stage in arm.stages:
        network, more = _learned(stage(network), arm, pairs, seconds / len(arm.stages), clock)
        steps += more
    assert network is not None
    return network, steps


def _learned(network: Any, arm: Arm, pairs: PairFolder, seconds: float, clock: Clock) -> tuple[nn.Module, int]:
    config = replace(CONFIG, learning_rate=arm.learning_rate)
    learner, spent, step = Learner(network, config), 0.0, 0
    if arm.optimiser is not None:
        learner.optimiser = arm.optimiser(learner.weights)  # type: ignore[assignment]
    unconditional = isinstance(network, Denoiser) and not network.config.condition
    with closing(prefetched(partial(denoising._batch, config, pairs, ALONE), 0)) as batches:
        while spent < seconds:
            clean, sigma, noise, rays, condition, wraps, _ = next(batches)
            began = clock()
            if spent:  # the learning rate falls to 0 where the time will be over
                learner.config = replace(config, steps=math.ceil(step * seconds / spent))
            with reduced_precision(CPU):
                given = None if unconditional else condition
                losses = network.loss(clean, arm.levels(sigma), noise, rays, given, wraps=bool(wraps))
            learner.step(step, losses.mean())
            spent, step = spent + clock() - began, step + 1
    return learner.averaged.eval(), step


@torch.inference_mode()
def sampled(network: Any, pair: StreetPair) -> RangeImage:
    """A scan of a pair's layout, from noise."""
    assert pair.simulated is not None
    sensor, sigmas = pair.scan.sensor, karras_levels(STEPS)
    condition = torch.from_numpy(encode_condition(pair.condition_image, pair.simulated))[None]
    rays = torch.from_numpy(encode_rays(sensor))
    noise = torch.randn(1, STATE_CHANNELS, *sensor.shape, generator=torch.Generator().manual_seed(pair.index))

    def denoise(x: Tensor, sigma: Tensor) -> Tensor:
        with reduced_precision(CPU):
            return network.denoise(x, sigma, rays, condition, wraps=sensor.wraps)

    *_, state = sample_multistep(denoise, sigmas[0] * noise, sigmas)
    return decode_scan(state[0].numpy(), sensor)


def gflop(network: Any, sensor: Sensor) -> float:
    """Billions of multiplications and additions of one call for a whole scan, with what a ControlNet reads."""
    x, one = torch.zeros(1, STATE_CHANNELS, *sensor.shape), torch.ones(1)
    condition = torch.zeros(1, CONDITION_CHANNELS, *sensor.shape)
    with FlopCounterMode(display=False) as counter, torch.inference_mode():
        network.denoise(x, one, torch.from_numpy(encode_rays(sensor)), condition, wraps=True)
    return counter.get_total_flops() / 1e9


def rows_of(arms: Mapping[str, Arm], pairs: PairFolder, seconds: float, num: int) -> Iterator[tuple[str, Row]]:
    """The rows of all arms, then those of our network untrained and of the condition images passed through."""
    unseen = [_thinned(pair) for pair in unseen_streets(num, sensor=pairs.sensor)]
    for name, arm in arms.items():
        with mock.patch.object(denoiser_module, "SIGMA_TURN", arm.sigma_turn):
            yield name, _row(*learned(arm, pairs, seconds), pairs.sensor, unseen)
    yield "ours, untrained", _row(untrained_weights(Denoiser.from_config(OURS)), 0, pairs.sensor, unseen)
    yield "condition image", _scores(unseen, [pair.condition_image for pair in unseen])


def _thinned(pair: StreetPair) -> StreetPair:
    """A pair with the beams and columns that are learned from."""
    assert pair.simulated is not None
    images = {"scan": pair.scan, "condition_image": pair.condition_image, "simulated": pair.simulated}
    return replace(pair, **{name: denoising.thinned(image, THINNING) for name, image in images.items()})


def _row(network: nn.Module, steps: int, sensor: Sensor, unseen: list[StreetPair]) -> Row:
    size = sum(weight.numel() for weight in network.parameters())
    row = {"million weights": size / 1e6, "GFLOP a call": gflop(network, sensor), "steps": float(steps)}
    row |= _scores(unseen, [sampled(network, pair) for pair in unseen])
    if isinstance(network, Denoiser):
        images = [pair.condition_image for pair in unseen]
        row["heeded"] = loss_by_other_layouts(network, [pair.scan for pair in unseen], images)
    return row


def _scores(unseen: list[StreetPair], scans: list[RangeImage]) -> Row:
    found = score("", unseen, scans)
    shares = {"objects": found.objects, "other": found.other, "heeded": math.nan}
    return shares | {"range": found.range, "BEV": found.bev, "lone %": 100 * found.lone}


def compare(arms: Mapping[str, Arm], description: str | None) -> None:
    """Parse, train, print a row as soon as it is there, and the table at the end."""
    parser = argparse.ArgumentParser(description=(description or "").split("\n")[0])
    parser.add_argument("--pairs", required=True, metavar="FOLDER", help="as `lidardraft streets -o FOLDER` makes them")
    parser.add_argument("--seconds", type=positive, default=300.0, help="processor time of each arm (default 300)")
    parser.add_argument("-n", "--num", type=whole_number(2), default=10, help="unseen streets (default 10)")
    parser.add_argument("--only", default="", metavar="NAME", help="arms whose names hold this")
    given = parser.parse_args()
    torch.set_num_threads(1)
    chosen = {name: arm for name, arm in arms.items() if given.only in name}
    rows: dict[str, Row] = {}
    for name, row in rows_of(chosen, PairFolder(given.pairs), given.seconds, given.num):
        rows[name] = row
        print(name, {column: round(value, 4) for column, value in row.items()}, flush=True)
    print(table(rows))


if __name__ == "__main__":
    compare(ARMS, __doc__)
