"""The `lidardraft-train` command: pairs become weights of the generator or of a segmenter."""

from __future__ import annotations

import argparse
import dataclasses
import sys
import time
from collections.abc import Collection, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import lidardraft
from lidardraft.cli import evaluate
from lidardraft.cli.arguments import (
    DEFAULT_SENSOR,
    add_minutes,
    add_seed,
    add_sensor,
    add_training_device,
    positive,
    read_sensor,
    whole_number,
)
from lidardraft.cli.command import Command, Parser, add_commands, progress, run
from lidardraft.errors import TrainingError
from lidardraft.scene.sensor import Sensor

if TYPE_CHECKING:
    from lidardraft.diffusion.denoiser import Denoiser
    from lidardraft.training.denoising import DenoisingConfig
    from lidardraft.training.loop import Report
    from lidardraft.training.sources import PairSource

_RECIPES = ("paper-small", "paper", "paper-large", "small-map", "paper-map", "tiny")
COMMANDS = {
    "segmenter": Command(
        __name__,
        "Train a segmenter, which predicts the class of each return, on the scans of pairs; a second call continues.",
        "lidardraft-train segmenter --pairs pairs/ -o run/",
    ),
    "street": Command(
        __name__,
        "Train the generator: all stages of a recipe, scores, and the weight file with its card; a second call goes "
        "on.",
        "lidardraft-train street --recipe paper-small --work run/ -o mine.safetensors",
    ),
}
_FURTHER_RATE = 0.3  # of the recipe's learning rate, which would spoil weights that are good already


def street(arguments: argparse.Namespace) -> None:
    """Train all stages of a recipe, or continue them."""
    from lidardraft.diffusion.denoiser import Denoiser
    from lidardraft.networks import weight_file
    from lidardraft.training.denoising import beginning, train_denoiser
    from lidardraft.training.loop import check_run_folder, device_for_training
    from lidardraft.training.processes import Processes

    # invalid input is refused before hours of work
    given = begin = _initial(arguments.init)
    stages = _stages(arguments, given)
    beginning(stages[0], given)
    if Path(arguments.output).is_dir():
        raise TrainingError(f"{arguments.output} is a folder; the weights are a file")
    runs = [Path(arguments.work) / f"stage-{number}" for number in range(1, len(stages) + 1)]
    for run_folder in runs:
        check_run_folder(run_folder)
    device = device_for_training(arguments.device)
    source = source_of(arguments, arguments.workers)
    for config in stages:
        config.check(source.sensors)
    processes = Processes.from_environment(device)
    Path(arguments.output).parent.mkdir(parents=True, exist_ok=True)
    ends = time.monotonic() + 60 * arguments.minutes
    with source.running(processes, device):
        for config, run_folder in zip(stages, runs, strict=True):
            options = {"device": str(device), "max_minutes": (ends - time.monotonic()) / 60}
            reports = train_denoiser(config, source, run_folder, begin=begin, **options)
            if show(reports, config.steps, run_folder.name) not in (None, config.steps):
                print(f"{run_folder}: stopped after {arguments.minutes:g} minutes; the same call goes on")
                return
            processes.wait()  # until the first one has saved the weights
            begin = weight_file.load(run_folder / "weights.safetensors", Denoiser)
    if processes.rank == 0 and begin is not None:
        kept = given is not None and given.config == begin.config  # these sample as the initial weights do
        _save_scored(arguments, begin, source, runs, str(device), arguments.init if kept else None)


def _save_scored(
    arguments: argparse.Namespace,
    denoiser: Denoiser,
    source: PairSource,
    runs: list[Path],
    device: str,
    sampled_as: str | None,
) -> None:
    """Score the weights in their final form, in float16, and write them with their card."""
    from lidardraft.diffusion.sensor_limits import SensorLimits
    from lidardraft.networks import weight_file
    from lidardraft.networks.weight_header import find
    from lidardraft.pipeline import Pipeline
    from lidardraft.training.sampled_sensor import LIMITS

    begun = {} if sampled_as is None else weight_file.read_card(find(sampled_as))
    card = {name: begun[name] for name in ("sampling",) if name in begun}
    half = Path(arguments.work) / "half.safetensors"
    weight_file.save(denoiser, half, card, half=True)
    pipeline = Pipeline.from_pretrained(half, device=device)
    unseen = evaluate.unseen_streets(arguments.evaluate, source.sensor or Sensor.preset(DEFAULT_SENSOR))
    card |= {
        "command": " ".join(["lidardraft-train", *sys.argv[1:]]),
        "data": source.source,
        "sensors": (SensorLimits.from_sensor(source.sensor) if source.sensor else LIMITS).to_dict(),
        "stages": [weight_file.read_card(run_folder / "weights.safetensors") for run_folder in runs],
        "scores": [dataclasses.asdict(scores) for scores in evaluate.scores(pipeline, unseen)],
    }
    weight_file.save(pipeline.denoiser, arguments.output, card, half=True)
    print(arguments.output)


def _stages(arguments: argparse.Namespace, begin: Denoiser | None) -> list[DenoisingConfig]:
    """The stages of the recipe; with initial weights its last one alone."""
    from lidardraft.training import recipes

    stages = list(getattr(recipes, arguments.recipe.replace("-", "_"))())
    given = {name: getattr(arguments, name) for name in ("steps", "batch", "learning_rate", "seed")}
    if begin is not None:
        given["learning_rate"] = given["learning_rate"] or _FURTHER_RATE * stages[-1].learning_rate
        stages = [dataclasses.replace(stages[-1], warmup=20)]
    given = {name: value for name, value in given.items() if value is not None}
    return [dataclasses.replace(stage, **given) for stage in stages]


def _initial(name: str | None) -> Denoiser | None:
    from lidardraft.pipeline import Pipeline

    return None if name is None else Pipeline.from_pretrained(name).denoiser


def source_of(arguments: argparse.Namespace, workers: int = 0) -> PairSource:
    """The source of --data: streets, folders of pairs, or a mixture; or the streets that --workers make meanwhile."""
    from lidardraft.training.sources import MixedSource, PairFolder, StreetBank, StreetSource

    sensor = None if arguments.sensor is None else read_sensor(arguments.sensor)
    names, weights = _weighted("--data", arguments.data or ["streets"])
    if workers:
        if sensor is None or names != ["streets"]:
            raise TrainingError("--workers make `--data streets` alone, of the --sensor that is named")
        return StreetBank(arguments.seed, sensor, workers)
    sources: list[PairSource] = [
        StreetSource(seed=arguments.seed, sensor=sensor) if name == "streets" else PairFolder(name) for name in names
    ]
    return sources[0] if len(sources) == 1 else MixedSource(tuple(sources), weights)


def _weighted(option: str, given: Sequence[str]) -> tuple[list[str], tuple[float, ...]]:
    """The names and the weights of NAME=WEIGHT, by default 1."""
    parts = [each.partition("=") for each in given]
    try:
        return [name for name, _, _ in parts], tuple(float(weight or 1) for _, _, weight in parts)
    except ValueError:
        raise TrainingError(f"{option} is {' '.join(given)!r}; behind = there must be a number") from None


def street_options(parser: argparse.ArgumentParser) -> None:
    """The options of `street`."""
    text = "size of the network and length of the training (default paper-small)"
    parser.add_argument("--recipe", choices=_RECIPES, default="paper-small", help=text)
    add_data(parser)
    add_sensor(parser, default=None, of=" of streets (default: another one at each step, drawn at random)")
    text = "go on from these weights: packaged ones by name, or a .safetensors file; the last stage alone"
    parser.add_argument("--init", metavar="NAME", help=text)
    text = "steps of each stage (default: the recipe's)"
    parser.add_argument("--steps", type=whole_number(1), metavar="N", help=text)
    text = "scans of 64 x 1024 a step, fewer of larger ones (default: the recipe's)"
    parser.add_argument("--batch", type=whole_number(1), metavar="N", help=text)
    text = "highest learning rate (default: the recipe's, 0.3 of it with --init)"
    parser.add_argument("--learning-rate", type=positive, metavar="R", help=text)
    add_minutes(parser)
    add_seed(parser)
    add_training_device(parser)
    text = "processes that make the streets of --sensor meanwhile; each step learns from the pairs made so far, for a "
    text += "GPU needs it (default: each step makes its own)"
    parser.add_argument("--workers", type=whole_number(0), default=0, metavar="N", help=text)
    text = "unseen streets to score the weights on (default 50)"
    parser.add_argument("--evaluate", type=whole_number(1), default=50, metavar="N", help=text)
    text = "folder for runs (default out/street)"
    parser.add_argument("--work", default="out/street", metavar="FOLDER", help=text)
    text = "weight file (default street.safetensors)"
    parser.add_argument("-o", "--output", default="street.safetensors", metavar="WEIGHTS", help=text)


def add_data(parser: argparse.ArgumentParser) -> None:
    """Add --data."""
    text = (
        "pairs to learn from: `streets`, made as they are needed (default), or a folder of `lidardraft streets -o`; "
        "repeatable, each with its share as =WEIGHT"
    )
    parser.add_argument("--data", action="append", metavar="NAME", help=text)


def segmenter(arguments: argparse.Namespace) -> None:
    """Train a segmenter, or continue its training."""
    from lidardraft.perception.segmenter import Segmenter
    from lidardraft.training.loop import check_run_folder
    from lidardraft.training.segmentation import SegmentationConfig, train_segmenter
    from lidardraft.training.sources import MixedSource, PairFolder

    check_run_folder(arguments.run)
    begin = None if arguments.init is None else Segmenter.from_pretrained(arguments.init)
    config = SegmentationConfig(steps=arguments.steps, batch=arguments.batch, seed=arguments.seed)
    if begin is not None:
        rate = _FURTHER_RATE * config.learning_rate
        config = dataclasses.replace(config, segmenter=begin.config, learning_rate=rate)
    names, weights = _weighted("--pairs", arguments.pairs)
    pairs = MixedSource(tuple(PairFolder(name) for name in names), weights)
    reports = train_segmenter(
        config, pairs, arguments.run, begin=begin, device=arguments.device, max_minutes=arguments.minutes
    )
    show(reports, config.steps, "segmenter")


def segmenter_options(parser: argparse.ArgumentParser) -> None:
    """The options of `segmenter`."""
    text = "pairs, as `lidardraft streets -o` and `lidardraft pairs` make them; several folders, each with its share as"
    parser.add_argument("--pairs", required=True, nargs="+", metavar="FOLDER", help=f"{text} =WEIGHT")
    text = "weights to begin with: `segmenter`, which is packaged, or a file"
    parser.add_argument("--init", metavar="NAME", help=text)
    add_minutes(parser)
    text = "folder for the weights and the state of the run; a second call continues"
    parser.add_argument("-o", "--output", dest="run", required=True, metavar="FOLDER", help=text)
    text = "steps of training (default 2000)"
    parser.add_argument("--steps", type=whole_number(1), default=2000, metavar="N", help=text)
    parser.add_argument("--batch", type=whole_number(1), default=2, metavar="N", help="whole scans a step (default 2)")
    add_seed(parser)
    add_training_device(parser)


def show(reports: Iterator[Report], steps: int, name: str) -> int | None:
    """Show a progress bar of a training; returns its last step, or None if there was nothing to do."""
    step = None
    with progress(steps, "step", name) as bar:
        for report in reports:
            bar.set_postfix_str(f"loss {report.loss:.3f}, {report.samples_per_second:.1f} samples/s", refresh=False)
            bar.update(report.step - bar.n)
            step = report.step
    return step


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line."""
    words = sys.argv[1:] if argv is None else argv
    return run(parser(words[:1]), words, needs="train")


def parser(declared: Collection[str] = tuple(COMMANDS)) -> Parser:
    """The parser of the command line, with the options of the commands `declared`."""
    made = Parser(
        prog="lidardraft-train",
        description="Weights of your own, from procedural streets.",
        epilog="start here: `lidardraft-train street` makes streets, learns from them, and writes one weight file for "
        "`lidardraft generate --weights FILE`.",
    )
    made.add_argument("--version", action="version", version=f"lidardraft {lidardraft.__version__}")
    add_commands(made, COMMANDS, declared)
    return made


if __name__ == "__main__":
    sys.exit(main())
