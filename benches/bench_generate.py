"""Milliseconds of a call of the generator's network and of a step of training, in bfloat16 and in float32.

    python benches/bench_generate.py [--threads 1] [--rounds 5] [--batch 4] [--sensor hdl64e] [--weights FILE]

Without `--weights` of `paper`. Both precisions take turns, and the least processor time of the rounds counts, so
that ratios hold on a busy machine; on one without the instructions bfloat16 is emulated. Steps of training are on whole
scans, without the optimiser. Shares of the operators of a call and a step are printed with `--profile`.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from pathlib import Path

import torch
from torch import Tensor
from torch.profiler import ProfilerActivity, profile
from torch.utils.flop_counter import FlopCounterMode

from lidardraft import Sensor
from lidardraft.diffusion.channels import STATE_CHANNELS
from lidardraft.diffusion.codec import encode_rays
from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.networks import weight_file
from lidardraft.networks.layers import has_bfloat16
from lidardraft.networks.weight_header import PACKAGED


class Bench:
    """A denoiser, and random scans of a sensor with conditions."""

    def __init__(self, denoiser: Denoiser, sensor: Sensor, batch: int) -> None:
        self.denoiser, self.batch, self.wraps = denoiser, batch, sensor.wraps
        self.rays = torch.from_numpy(encode_rays(sensor))
        self.clean, self.noise = torch.randn(2, batch, STATE_CHANNELS, *sensor.shape)
        self.condition = torch.randn(batch, STATE_CHANNELS, *sensor.shape)
        self.sigma = torch.logspace(-2, 1, batch)

    @torch.inference_mode()
    def call(self) -> Tensor:
        """One call of the network for one scan."""
        return self.denoiser.denoise(self.clean[:1], self.sigma[:1], self.rays, self.condition[:1], wraps=self.wraps)

    def step(self) -> None:
        """The gradient of a batch."""
        loss = self.denoiser.loss(self.clean, self.sigma, self.noise, self.rays, self.condition, wraps=self.wraps)
        loss.mean().backward()
        self.denoiser.zero_grad()

    def flop(self) -> float:
        """Floating-point operations of a call."""
        with FlopCounterMode(display=False) as counter:
            self.call()
        return float(counter.get_total_flops())


def least(function: Callable[[], object], rounds: int) -> dict[bool, float]:
    """Milliseconds of processor time with and without bfloat16, which take turns."""
    best = {True: float("inf"), False: float("inf")}
    for turn in range(rounds + 1):
        for bfloat16 in best:
            start = time.process_time()
            with torch.autocast("cpu", dtype=torch.bfloat16, enabled=bfloat16):
                function()
            if turn:  # the first one of each warms up
                best[bfloat16] = min(best[bfloat16], 1e3 * (time.process_time() - start))
    return best


def shares(function: Callable[[], object]) -> str:
    """The operators that take the most time."""
    with profile(activities=[ProfilerActivity.CPU]) as measured, torch.autocast("cpu", dtype=torch.bfloat16):
        function()
    return measured.key_averages().table(sort_by="self_cpu_time_total", row_limit=16, max_name_column_width=40)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--batch", type=int, default=4)
    parser.add_argument("--sensor", default="hdl64e")
    parser.add_argument("--weights", type=Path, default=PACKAGED / "paper.safetensors")
    parser.add_argument("--profile", action="store_true")
    arguments = parser.parse_args()
    torch.set_num_threads(arguments.threads)
    denoiser = weight_file.load(arguments.weights, Denoiser)
    bench = Bench(denoiser, Sensor.preset(arguments.sensor), arguments.batch)
    weights = sum(p.numel() for p in denoiser.parameters())
    print(f"{denoiser.config}\n{bench.flop() / 1e9:.1f} GFLOP a call, {weights / 1e6:.2f} million weights")
    print(f"this processor has {'' if has_bfloat16(torch.device('cpu')) else 'no '}bfloat16\n")
    print("| ms of processor time | bfloat16 | float32 | ratio |\n|---|---:|---:|---:|")
    denoiser.requires_grad_(True)
    for name, function, count in (("a call", bench.call, 1), ("training, a scan", bench.step, arguments.batch)):
        best = least(function, arguments.rounds)
        print(f"| {name} | {best[True] / count:.1f} | {best[False] / count:.1f} | {best[True] / best[False]:.2f} |")
        if arguments.profile:
            print(shares(function))


if __name__ == "__main__":
    main()
