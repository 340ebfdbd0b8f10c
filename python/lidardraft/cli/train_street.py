"""`lidardraft-train street`: weights of the generator."""

from __future__ import annotations

import argparse
import dataclasses
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

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
from lidardraft.cli.training_progress import show
from lidardraft.errors import TrainingError
from lidardraft.scene.sensor import Sensor

if TYPE_CHECKING:
    from lidardraft.diffusion.denoiser import Denoiser
    from lidardraft.scene.sensor_limits import SensorLimits
    from lidardraft.training.denoising import DenoisingConfig, PairSource

_RECIPES = ("small", "paper", "small-paper", "tiny", "tiny-paper")
_FURTHER_RATE = 0.3  # of the recipe's learning rate: weights that are good already would be lost with more


def street(arguments: argparse.Namespace) -> None:
    """Train the generator: all stages of a recipe, scores, and the weight file with its card; a second call goes on."""
    from lidardraft.diffusion.denoiser import Denoiser
    from lidardraft.networks import weight_file
    from lidardraft.pipeline import Pipeline
    from lidardraft.training.loop import check_run_folder, device_for_training
    from lidardraft.training.processes import Processes

    begin = _initial(arguments.init)
    stages = _stages(arguments, begin)
    source = _source(arguments)
    # what cannot be is refused before hours of work
    if Path(arguments.output).is_dir():
        raise TrainingError(f"{arguments.output} is a folder; the weights are a file")
    runs = [Path(arguments.work) / f"stage-{number}" for number in range(1, len(stages) + 1)]
    for config, run_folder in zip(stages, runs, strict=True):
        config.check(source.sensors)
        check_run_folder(run_folder)
    processes = Processes.from_environment(device_for_training(arguments.device))
    Path(arguments.output).parent.mkdir(parents=True, exist_ok=True)
    ends = time.monotonic() + 60 * arguments.minutes
    for config, run_folder in zip(stages, runs, strict=True):
        if not _trained(config, source, run_folder, begin, arguments.device, (ends - time.monotonic()) / 60):
            print(f"{run_folder}: stopped after {arguments.minutes:g} minutes; the same call goes on")
            return
        processes.wait()  # until the first one has saved what all have learned
        begin = weight_file.load(run_folder / "weights.safetensors", Denoiser)
    if processes.rank > 0:
        return
    # What is scored is what ships: float16.
    assert begin is not None
    half = Path(arguments.work) / "half.safetensors"
    weight_file.save(begin, half, {}, half=True)
    pipeline = Pipeline.from_pretrained(half, device=arguments.device)
    sensor = source.sensor or Sensor.preset(DEFAULT_SENSOR)
    unseen = evaluate.unseen_streets(arguments.evaluate, sensor)
    card = {
        "command": " ".join(["lidardraft-train", *sys.argv[1:]]),
        "data": source.source,
        "sensors": _limits(source.sensor).to_dict(),
        "stages": [weight_file.read_card(run_folder / "weights.safetensors") for run_folder in runs],
        "scores": [dataclasses.asdict(scores) for scores in evaluate.scores(pipeline, unseen)],
    }
    weight_file.save(pipeline.denoiser, arguments.output, card, half=True)
    print(arguments.output)


def _stages(arguments: argparse.Namespace, begin: Denoiser | None) -> list[DenoisingConfig]:
    """Those of the recipe; its last one alone where weights to begin with are given."""
    from lidardraft.training import recipes

    recipe = getattr(recipes, arguments.recipe.replace("-", "_"))()
    stages = [dataclasses.replace(config, seed=arguments.seed) for config in recipe.stages]
    if begin is not None:
        rate = _FURTHER_RATE * stages[-1].learning_rate
        stages = [dataclasses.replace(stages[-1], learning_rate=rate, warmup=20)]
    given = {name: getattr(arguments, name) for name in ("steps", "batch", "learning_rate")}
    given = {name: value for name, value in given.items() if value is not None}
    return [dataclasses.replace(config, **given) for config in stages]


def _initial(name: str | None) -> Denoiser | None:
    from lidardraft.pipeline import Pipeline

    return None if name is None else Pipeline.from_pretrained(name).denoiser


def _source(arguments: argparse.Namespace) -> PairSource:
    """What --data names: streets, folders of pairs, or a mixture."""
    from lidardraft.training.mixed_source import MixedSource
    from lidardraft.training.pairs import PairFolder
    from lidardraft.training.street_source import StreetSource

    sensor = None if arguments.sensor is None else read_sensor(arguments.sensor)
    sources: list[PairSource] = []
    weights: list[float] = []
    for given in arguments.data or ["streets"]:
        name, _, weight = given.partition("=")
        sources.append(StreetSource(seed=arguments.seed, sensor=sensor) if name == "streets" else PairFolder(name))
        try:
            weights.append(float(weight or 1))
        except ValueError:
            raise TrainingError(f"--data is {given!r}; behind = there must be a number") from None
    return sources[0] if len(sources) == 1 else MixedSource(tuple(sources), tuple(weights))


def _limits(sensor: Sensor | None) -> SensorLimits:
    from lidardraft.scene.sensor_limits import SensorLimits
    from lidardraft.training import sampled_sensor

    return sampled_sensor.LIMITS if sensor is None else SensorLimits.from_sensor(sensor)


def _trained(
    config: DenoisingConfig,
    source: PairSource,
    run: Path,
    begin: Denoiser | None,
    device: str,
    minutes: float,
) -> bool:
    """Whether a stage is done, after so many minutes at most."""
    from lidardraft.training.denoising import train_denoiser

    reports = train_denoiser(config, source, run, begin=begin, device=device, max_minutes=minutes)
    return show(reports, config.steps, run.name) in (None, config.steps)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of the command."""
    text = "size of the network and length of the training (default small)"
    parser.add_argument("--recipe", choices=_RECIPES, default="small", help=text)
    text = (
        "pairs to learn from: `streets`, made as they are needed (default), or a folder of `lidardraft streets -o`; "
        "repeatable, each with its share as =WEIGHT"
    )
    parser.add_argument("--data", action="append", metavar="NAME", help=text)
    add_sensor(parser, default=None, of=" of streets (default: another one at each step, drawn at random)")
    text = "go on from these weights: packaged ones by name, or a .safetensors file"
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
    text = "unseen streets to score the weights on (default 50)"
    parser.add_argument("--evaluate", type=whole_number(1), default=50, metavar="N", help=text)
    text = "where runs are kept (default out/street)"
    parser.add_argument("--work", default="out/street", metavar="FOLDER", help=text)
    text = "where the weight file goes (default street.safetensors)"
    parser.add_argument("-o", "--output", default="street.safetensors", metavar="WEIGHTS", help=text)
