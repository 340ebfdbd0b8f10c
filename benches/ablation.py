"""The paper's Table 2: its form and its alternatives, each trained for as long and scored; a second call continues.

    python benches/ablation.py [--base NAME] [--data FOLDER ...] [--steps 2000] [-n 50] [--work out/ablation]

The paper's FRD needs weights that are not free, so that top views (BEV JSD, MMD) and adherence stand for it. objects:
share of the returns on objects within 0.5 m or 5 % of the layout. drop: share of the rays that hit the layout and
return nothing. heeded: the loss of unseen scans by the layout of another street, over that by their own, 1 where a
network ignores its condition. The row of other streets says what scans of another place would get, those of the cast
and of untrained weights what no training has earned. The scans of each row are in WORK/scans, for
`published_tables.py`.
"""

from __future__ import annotations

import argparse
import copy
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import torch

from lidardraft import Layout, Pipeline, RangeImage, Raycaster, Sensor
from lidardraft.cli.arguments import add_seed, add_sensor, add_training_device, read_sensor, whole_number
from lidardraft.cli.command import progress
from lidardraft.cli.train import add_data, show, source_of
from lidardraft.diffusion.codec import encode_rays, encode_scan
from lidardraft.diffusion.denoiser import Denoiser
from lidardraft.evaluation import OTHER_STREETS, score, unseen_streets, untrained_weights
from lidardraft.formats.kitti import write_bin
from lidardraft.metrics.comparisons import bev_histogram, histogram_mmd
from lidardraft.networks import weight_file
from lidardraft.networks.layers import reduced_precision
from lidardraft.streets import StreetPair
from lidardraft.training import recipes
from lidardraft.training.denoising import DenoisingConfig, train_denoiser
from lidardraft.training.loop import device_for_training
from lidardraft.training.sources import PairSource, StreetSource

HEEDED_LEVELS = (0.1, 0.3, 1.0, 3.0)  # of noise: at lower ones the scan itself suffices
NEAR, FAR = 2.0, 80.0  # m from the sensor along the ground: the lowest row and the highest of a top view
CEILING = 12.0  # m over the sensor's origin: the limit of heights
HIGH = 200.0  # m over the sensor's origin: the start of the rays


@dataclass(frozen=True, kw_only=True)
class Arm:
    """The change of the paper's form in one row of the table.

    The parts of the condition; whether it enters through a ControlNet, or beside the state of a base that learns on;
    whether the ControlNet's copy of the encoder learns, or its zero convolutions alone; whether the layout's top view
    (`top_view`) replaces its cast.
    """

    condition: tuple[str, ...] = ("depth", "class")
    controlnet: bool = True
    tuned: bool = True
    from_above: bool = False

    def stage(self, control: DenoisingConfig) -> DenoisingConfig:
        """The stage of this arm on the base in place of the paper's `control`, with as many steps."""
        denoiser = replace(control.denoiser, condition=self.condition, controlnet=self.controlnet)
        alone = control.zero_conv_steps if self.tuned else control.steps
        return replace(control, denoiser=denoiser, zero_conv_steps=alone, watch_every=0)


# The value of each part of the paper's form, at one budget of training; the paper's own form last. "Semantic map alone"
# is the paper's "without depth estimation".
ARMS = {
    "ControlNet not fine-tuned": Arm(tuned=False),
    "top view, not cast": Arm(from_above=True),
    "without classes": Arm(condition=("depth",)),
    "semantic map alone": Arm(condition=("class",)),
    "condition concatenated": Arm(controlnet=False),
    "paper": Arm(),
}


class TopViews(StreetSource):
    """The streets of a seed, with the top view of each layout in place of its cast."""

    def __init__(self, seed: int, sensor: Sensor) -> None:
        super().__init__(seed=seed, sensor=sensor)
        self.source, self.checksum = f"{self.source}, layouts from above", self.checksum + 1

    def condition_image(self, pair: StreetPair) -> RangeImage:
        """The top view of a pair."""
        return top_view(pair.layout, pair.scan.sensor, pair.pose)


def top_view(layout: Layout, sensor: Sensor, pose: np.ndarray) -> RangeImage:
    """The top view of a layout around a sensor at world_from_sensor `pose` [4, 4], in images of its shape.

    A pixel is a vertical ray at its own place: its column's azimuth is the sensor's, and higher rows are farther, in
    equal ratios from 2 to 80 m. `depth` is the distance of the surface below a ceiling of 12 m, `label` its class. The
    paper does not state its projection; azimuths that agree with those of the scan are the best case for it.
    """
    rows, columns = sensor.shape
    azimuth = sensor.azimuth_start - (np.arange(columns) + 0.5) * sensor.azimuth_span / columns
    azimuth = azimuth + np.arctan2(pose[1, 0], pose[0, 0])
    distance = np.geomspace(FAR, NEAR, rows)[:, None]
    origins = np.empty((rows, columns, 3))
    origins[..., 0] = pose[0, 3] + distance * np.cos(azimuth)
    origins[..., 1] = pose[1, 3] + distance * np.sin(azimuth)
    origins[..., 2] = pose[2, 3] + HIGH
    down = np.broadcast_to((0.0, 0.0, -1.0), (rows * columns, 3))
    hits = Raycaster(layout).cast(origins.reshape(-1, 3), down)
    depth = np.where(hits.valid, np.maximum(hits.distance - (HIGH - CEILING), 0.1), 0)
    return RangeImage(
        sensor=sensor,
        depth=depth.reshape(sensor.shape).astype(np.float32),
        label=hits.label.reshape(sensor.shape),
        instance=hits.instance.reshape(sensor.shape),
    )


@torch.inference_mode()
def loss_by_other_layouts(denoiser: Denoiser, scans: list[RangeImage], condition_images: list[RangeImage]) -> float:
    """The loss of scans by the next one's condition image over that by their own: 1 if a denoiser ignores its
    condition. It rises long before scans show it."""
    device = next(denoiser.parameters()).device
    losses = dict.fromkeys((0, 1), 0.0)
    for seed, scan in enumerate(scans):
        sigma = torch.tensor(HEEDED_LEVELS, device=device)
        clean = torch.from_numpy(encode_scan(scan)).to(device).expand(len(sigma), -1, -1, -1)
        noise = torch.randn(clean.shape, generator=torch.Generator().manual_seed(seed)).to(device)
        rays = torch.from_numpy(encode_rays(scan.sensor)).to(device)
        for shift in losses:
            encoded = encode_scan(condition_images[(seed + shift) % len(scans)])
            condition = torch.from_numpy(encoded).to(device).expand(len(sigma), -1, -1, -1)
            with reduced_precision(device):
                loss = denoiser.loss(clean, sigma, noise, rays, condition, wraps=scan.sensor.wraps)
            losses[shift] += loss.mean().item()
    return losses[1] / losses[0]


def main(argv: Sequence[str] | None = None) -> None:
    """Train and score all arms, or continue them; print a row each."""
    given = parser().parse_args(argv)
    sensor, num, work = read_sensor(given.sensor), given.num, Path(given.work)
    *_, base, control = recipes.paper_small()
    base, control = (
        replace(s, steps=n, seed=given.seed) for s, n in ((base, given.base_steps), (control, given.steps))
    )
    # short trainings have time for the whole ControlNet as well
    control = replace(control, zero_conv_steps=min(control.zero_conv_steps, control.steps // 10))
    base.check([sensor])
    begin = None if given.base is None else Pipeline.from_pretrained(given.base).denoiser
    source, from_above = source_of(given), TopViews(given.seed, sensor)
    device = str(device_for_training(given.device))
    pairs = unseen_streets(num, sensor=sensor)
    others = [pair.scan for pair in unseen_streets(num, sensor=sensor, seed=OTHER_STREETS)]
    learned = given.base or f"{base.steps} steps"
    print(f"{num} street{'s' * (num > 1)}, {sensor.name}; base {learned}, each arm {control.steps} steps")
    print(f"{'':28}{'objects':>9}{'drop':>9}{'BEV JSD':>9}{'MMD 1e-4':>10}{'heeded':>9}", flush=True)
    print_row(work, "other streets", pairs, others)
    cast = [pair.condition_image for pair in pairs]
    print_row(work, "cast passed through", pairs, cast)
    seen_from_above = [top_view(pair.layout, sensor, pair.pose) for pair in pairs]
    unconditional = begin.base() if begin else trained(work, base, source, "base", device)
    print_row(work, "untrained", pairs, sampled(untrained_weights(unconditional), cast))
    print_row(work, "no condition", pairs, sampled(unconditional, cast))
    for name, arm in ARMS.items():
        learned_from, images = (from_above, seen_from_above) if arm.from_above else (source, cast)
        begin = copy.deepcopy(unconditional)  # it is frozen under a ControlNet
        denoiser = trained(work, arm.stage(control), learned_from, name, device, begin)
        heeded = loss_by_other_layouts(denoiser, [pair.scan for pair in pairs], images)
        print_row(work, name, pairs, sampled(denoiser, images), heeded)


def trained(
    work: Path, config: DenoisingConfig, source: PairSource, name: str, device: str, begin: Denoiser | None = None
) -> Denoiser:
    """The weights of an arm, trained or as they are there already."""
    run = work / slug(name)
    show(train_denoiser(config, source, run, begin=begin, device=device), config.steps, name)
    return weight_file.load(run / "weights.safetensors", Denoiser).to(device)


def slug(name: str) -> str:
    """The folder of a row."""
    return name.replace(",", "").replace(" ", "-").lower()


def sampled(denoiser: Denoiser, images: list[RangeImage]) -> list[RangeImage]:
    """The scans that a denoiser generates from each condition image."""
    pipeline, scans = Pipeline(denoiser), []
    with progress(len(images), "scan", "generating", leave=False) as bar:
        for seed, image in enumerate(images):
            scans.append(pipeline.generate(image, seed=seed))
            bar.update()
    return scans


def print_row(work: Path, name: str, pairs: list[StreetPair], scans: list[RangeImage], heeded: float = 1.0) -> None:
    """Print a row, and write its scans."""
    scores, sides = score(name, pairs, scans), ([pair.scan for pair in pairs], scans)
    mmd = histogram_mmd(*(np.stack([bev_histogram(scan.points()) for scan in side]) for side in sides))
    folder = work / "scans" / slug(name)
    folder.mkdir(parents=True, exist_ok=True)
    for earlier in folder.glob("*.bin"):  # from a call with more streets
        earlier.unlink()
    for number, scan in enumerate(scans):
        intensity = np.zeros(scan.sensor.shape, np.float32) if scan.intensity is None else scan.intensity
        write_bin(folder / f"{number:06d}.bin", scan.points(), intensity[scan.valid])
    shown = f"{scores.objects:9.3f}{scores.drop:9.3f}{scores.bev:9.3f}{1e4 * mmd:10.3f}{heeded:9.3f}"
    print(f"{name:28}{shown}", flush=True)


def parser() -> argparse.ArgumentParser:
    """The options."""
    made = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    add_sensor(made)
    add_data(made)
    text = "the base of these weights, packaged ones by name, or a .safetensors file (default: one is trained first)"
    made.add_argument("--base", metavar="NAME", help=text)
    for option, default, what in (("--base-steps", 8000, "the base learns"), ("--steps", 2000, "each arm learns")):
        made.add_argument(option, type=whole_number(1), default=default, metavar="N", help=f"steps that {what}")
    made.add_argument("-n", "--num", type=whole_number(1), default=50, metavar="N", help="unseen streets to score on")
    add_seed(made)
    made.add_argument("--work", default="out/ablation", metavar="FOLDER", help="folder for runs and scans")
    add_training_device(made)
    return made


if __name__ == "__main__":
    sys.exit(main())
