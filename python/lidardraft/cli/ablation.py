"""`lidardraft-train ablation`: the paper's Table 2 on streets."""

from __future__ import annotations

import argparse
import copy
import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING

from lidardraft.cli import evaluate
from lidardraft.cli.arguments import add_seed, add_sensor, add_training_device, read_sensor, whole_number
from lidardraft.cli.training_progress import show

if TYPE_CHECKING:
    from lidardraft.diffusion.denoiser import Denoiser
    from lidardraft.scene.range_image import RangeImage
    from lidardraft.streets import StreetPair
    from lidardraft.training.denoising import DenoisingConfig
    from lidardraft.training.street_source import StreetSource

_OTHER_STREETS = 3_000_000  # a seed; neither learned from nor scored on


def ablation(arguments: argparse.Namespace) -> None:
    """Train the paper's form and what it is compared with, each for as long, and score all; a second call goes on."""
    from lidardraft.diffusion.top_view import top_view
    from lidardraft.evaluation import loss_by_other_layouts
    from lidardraft.training import recipes
    from lidardraft.training.ablation import ARMS
    from lidardraft.training.loop import check_run_folder, device_for_training
    from lidardraft.training.street_source import StreetSource

    sensor, num = read_sensor(arguments.sensor), arguments.num
    *_, base, control = recipes.small_paper().stages
    base, control = (
        dataclasses.replace(stage, steps=steps, seed=arguments.seed)
        for stage, steps in ((base, arguments.base_steps), (control, arguments.steps))
    )
    # what is short has time to learn all of the ControlNet as well
    control = dataclasses.replace(control, zero_conv_steps=min(control.zero_conv_steps, control.steps // 10))
    recipe = recipes.Recipe(stages=(base, control))
    source = StreetSource(seed=arguments.seed, sensor=sensor)
    base.check([sensor])
    check_run_folder(arguments.work)
    device_for_training(arguments.device)
    pairs = evaluate.unseen_streets(num, sensor)
    others = [pair.scan for pair in evaluate.unseen_streets(num, sensor, _OTHER_STREETS)]
    print(f"{num} street{'s' * (num > 1)}, {sensor.name}; base {base.steps} steps, each arm {control.steps}")
    print(f"{'':28}{'objects':>9}{'drop':>9}{'BEV JSD':>9}{'MMD 1e-4':>10}{'heeded':>9}", flush=True)
    _row("other streets", pairs, others)
    cast = [pair.condition_image for pair in pairs]
    from_above = [top_view(pair.layout, sensor, pair.pose) for pair in pairs]
    unconditional = _trained(arguments, base, source, "base")
    _row("no condition", pairs, _sampled(unconditional, cast))
    for name, arm in ARMS.items():
        seen = dataclasses.replace(source, from_above=arm.from_above)
        begin = copy.deepcopy(unconditional) if arm.controlnet else None  # it is frozen under a ControlNet
        denoiser = _trained(arguments, arm.stage(recipe), seen, name, begin)
        images = from_above if arm.from_above else cast
        heeded = loss_by_other_layouts(denoiser, [pair.scan for pair in pairs], images)
        _row(name, pairs, _sampled(denoiser, images), heeded)


def _trained(
    arguments: argparse.Namespace,
    config: DenoisingConfig,
    source: StreetSource,
    name: str,
    begin: Denoiser | None = None,
) -> Denoiser:
    from lidardraft.diffusion.denoiser import Denoiser
    from lidardraft.networks import weight_file
    from lidardraft.training.denoising import train_denoiser

    run = Path(arguments.work) / name.replace(",", "").replace(" ", "-").lower()
    show(train_denoiser(config, source, run, begin=begin, device=arguments.device), config.steps, name)
    return weight_file.load(run / "weights.safetensors", Denoiser).to(arguments.device)


def _sampled(denoiser: Denoiser, images: list[RangeImage]) -> list[RangeImage]:
    from tqdm import tqdm

    from lidardraft.evaluation import sample_scans

    with tqdm(total=len(images), unit="scan", desc="generating", disable=None, leave=False) as bar:
        return sample_scans(denoiser, images, on_scan=bar.update)


def _row(name: str, pairs: list[StreetPair], scans: list[RangeImage], heeded: float = 1.0) -> None:
    from lidardraft.evaluation import score
    from lidardraft.metrics.bev import bev_mmd

    scores = score(name, pairs, scans)
    mmd = bev_mmd((pair.scan.points() for pair in pairs), (scan.points() for scan in scans))
    shown = f"{scores.objects:9.3f}{scores.drop:9.3f}{scores.bev:9.3f}{1e4 * mmd:10.3f}{heeded:9.3f}"
    print(f"{name:28}{shown}", flush=True)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of the command."""
    parser.epilog = (
        "The paper's FRD needs weights that are not free, so that top views (BEV JSD, MMD) and adherence stand for it. "
        "objects: share of the returns on objects within 0.5 m or 5 % of the layout. drop: share of the rays that hit "
        "the layout and return nothing. heeded: the loss of unseen scans by the layout of another street, over that by "
        "their own, 1 where a network ignores its condition. The row of other streets says what scans of another place "
        "would get."
    )
    add_sensor(parser)
    text = "steps that the base learns, which knows no condition (default 8000)"
    parser.add_argument("--base-steps", type=whole_number(1), default=8000, metavar="N", help=text)
    text = "steps that each arm learns (default 2000)"
    parser.add_argument("--steps", type=whole_number(1), default=2000, metavar="N", help=text)
    text = "unseen streets to score on (default 50)"
    parser.add_argument("-n", "--num", type=whole_number(1), default=50, metavar="N", help=text)
    add_seed(parser)
    text = "where runs are kept (default out/ablation)"
    parser.add_argument("--work", default="out/ablation", metavar="FOLDER", help=text)
    add_training_device(parser)
