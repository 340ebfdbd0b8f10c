"""The `lidardraft-train` command: streets become pairs, pairs become weights."""

from __future__ import annotations

import argparse
import dataclasses
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import lidardraft
from lidardraft.cli import evaluate, streets
from lidardraft.cli.arguments import add_seed, minutes, whole_number
from lidardraft.cli.command import commands_of, run
from lidardraft.errors import TrainingError
from lidardraft.scene.sensor import Sensor

if TYPE_CHECKING:
    from lidardraft.training.denoising import DenoisingConfig
    from lidardraft.training.loop import Report


def unconditional(arguments: argparse.Namespace) -> None:
    """Train stage one: a score network that learns what scans look like."""
    config = _config(arguments.recipe, "base", arguments.steps)
    _train(config, arguments.pairs, arguments.run, device=arguments.device, minutes=arguments.minutes)


def controlnet(arguments: argparse.Namespace) -> None:
    """Train stage two: a ControlNet that learns to keep to the condition image, on the frozen network of stage one."""
    config = _config(arguments.recipe, "control", arguments.steps)
    base = Path(arguments.base)
    _train(config, arguments.pairs, arguments.run, base=base, device=arguments.device, minutes=arguments.minutes)


def segmenter(arguments: argparse.Namespace) -> None:
    """Train a segmenter, which tells the class of each return, on the scans of pairs; a second call goes on."""
    from lidardraft.training.loop import check_run_folder
    from lidardraft.training.pairs import PairFolder
    from lidardraft.training.segmentation import SegmentationConfig, train_segmenter

    config = SegmentationConfig(steps=arguments.steps, batch=arguments.batch, seed=arguments.seed)
    check_run_folder(arguments.run)
    folder = PairFolder(arguments.pairs)
    reports = train_segmenter(config, folder, arguments.run, device=arguments.device, max_minutes=arguments.minutes)
    _show(reports, config.steps, "segmenter")


def street(arguments: argparse.Namespace) -> None:
    """Do it all: pairs, both stages, scores, and the weight file with its card; a second call goes on."""
    from lidardraft.diffusion.denoiser import Denoiser
    from lidardraft.networks import weight_file
    from lidardraft.pipeline import Pipeline
    from lidardraft.training.loop import check_run_folder, device_for_training
    from lidardraft.training.pairs import PairFolder

    base = _config(arguments.recipe, "base", arguments.base_steps)
    control = _config(arguments.recipe, "control", arguments.control_steps)
    sensor = Sensor.preset(arguments.sensor)
    # what cannot be is refused before hours of work
    if Path(arguments.output).is_dir():
        raise TrainingError(f"{arguments.output} is a folder; the weights are a file")
    for config in (base, control):
        config.check(sensor)
    device_for_training(arguments.device)
    for stage in ("base", "control"):
        check_run_folder(Path(arguments.work) / stage)
    Path(arguments.output).parent.mkdir(parents=True, exist_ok=True)
    work, arguments.pairs = Path(arguments.work), str(Path(arguments.work) / "pairs")
    streets.write_pairs_of_streets(arguments.pairs, arguments)
    _train(base, arguments.pairs, work / "base", device=arguments.device)
    trained = work / "base" / "weights.safetensors"
    _train(control, arguments.pairs, work / "control", base=trained, device=arguments.device)
    weights = work / "control" / "weights.safetensors"
    # What is scored is what ships: float16.
    half = work / "half.safetensors"
    weight_file.save(weight_file.load(weights, Denoiser), half, {}, half=True)
    pipeline = Pipeline.from_pretrained(half, device=arguments.device)
    folder = PairFolder(arguments.pairs)
    unseen = evaluate.unseen_streets(arguments.evaluate, folder.sensor)
    card = {
        "command": " ".join(["lidardraft-train", *sys.argv[1:]]),
        "data": f"{len(folder)} scans: {folder.source}",
        "sensors": [folder.sensor.name],
        "base": weight_file.read_card(trained),
        "control": weight_file.read_card(weights),
        "scores": [dataclasses.asdict(scores) for scores in evaluate.scores(pipeline, unseen)],
    }
    weight_file.save(pipeline.denoiser, arguments.output, card, half=True)
    print(arguments.output)


def _config(recipe: str, stage: str, steps: int | None) -> DenoisingConfig:
    from lidardraft.training import recipes

    configs = {"small": recipes.small, "tiny": recipes.tiny, "paper": recipes.paper}[recipe]()
    config: DenoisingConfig = getattr(configs, stage)
    return config if steps is None else dataclasses.replace(config, steps=steps)


def _train(
    config: DenoisingConfig,
    pairs: str | Path,
    run: str | Path,
    *,
    base: Path | None = None,
    device: str,
    minutes: float = float("inf"),
) -> None:
    from lidardraft.diffusion.denoiser import Denoiser
    from lidardraft.networks import weight_file
    from lidardraft.training.denoising import train_denoiser
    from lidardraft.training.loop import check_run_folder
    from lidardraft.training.pairs import PairFolder

    check_run_folder(run)
    reports = train_denoiser(
        config,
        PairFolder(pairs),
        run,
        base=weight_file.load(base, Denoiser) if base else None,
        device=device,
        max_minutes=minutes,
    )
    _show(reports, config.steps, "control" if base else "base")


def _show(reports: Iterator[Report], steps: int, name: str) -> None:
    """A progress bar of a training."""
    from tqdm import tqdm

    with tqdm(total=steps, unit="step", desc=name) as bar:
        for report in reports:
            bar.update(report.step - bar.n)
            bar.set_postfix_str(f"loss {report.loss:.3f}, {report.samples_per_second:.1f} samples/s")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="lidardraft-train",
        description="Weights of your own, from procedural streets.",
        epilog="start here: `lidardraft-train street` makes streets, trains both stages on them, and writes one weight "
        "file for `lidardraft generate --weights FILE`. The default recipe takes about an hour on two CPU cores.",
    )
    parser.add_argument("--version", action="version", version=f"lidardraft {lidardraft.__version__}")
    command = commands_of(parser)

    def pairs(added: argparse.ArgumentParser) -> None:
        text = "training pairs, as `lidardraft streets -o FOLDER` makes them"
        added.add_argument("--pairs", required=True, metavar="FOLDER", help=text)
        text = "stop after so many minutes; the same call goes on (default: no limit)"
        added.add_argument("--minutes", type=minutes, default=float("inf"), metavar="M", help=text)
        text = "where the weights and the state of the run go; a second call goes on"
        added.add_argument("-o", "--output", dest="run", required=True, metavar="FOLDER", help=text)

    def recipe(added: argparse.ArgumentParser) -> None:
        text = "size of the network and length of the training (default small)"
        added.add_argument("--recipe", choices=("small", "tiny", "paper"), default="small", help=text)

    def device(added: argparse.ArgumentParser) -> None:
        added.add_argument("--device", default="cpu", help="where torch trains: cpu, cuda, ... (default cpu)")

    for name, function in (("unconditional", unconditional), ("controlnet", controlnet)):
        added = command(name, function)
        pairs(added)
        if function is controlnet:
            added.add_argument("--base", required=True, metavar="WEIGHTS", help="weights.safetensors of stage one")
        recipe(added)
        added.add_argument(
            "--steps", type=whole_number(1), metavar="N", help="steps of training (default: the recipe's)"
        )
        device(added)

    added = command("segmenter", segmenter)
    pairs(added)
    text = "steps of training (default 2000)"
    added.add_argument("--steps", type=whole_number(1), default=2000, metavar="N", help=text)
    added.add_argument("--batch", type=whole_number(1), default=2, metavar="N", help="whole scans a step (default 2)")
    add_seed(added)
    device(added)

    added = command("street", street)
    streets.add_pair_arguments(added, num=2400)
    recipe(added)
    text = "steps of stage one (default: the recipe's)"
    added.add_argument("--base-steps", type=whole_number(1), metavar="N", help=text)
    text = "steps of stage two (default: the recipe's)"
    added.add_argument("--control-steps", type=whole_number(1), metavar="N", help=text)
    device(added)
    text = "unseen streets to score the weights on (default 50)"
    added.add_argument("--evaluate", type=whole_number(1), default=50, metavar="N", help=text)
    text = "where pairs and runs are kept (default out/street)"
    added.add_argument("--work", default="out/street", metavar="FOLDER", help=text)
    text = "where the weight file goes (default street.safetensors)"
    added.add_argument("-o", "--output", default="street.safetensors", metavar="WEIGHTS", help=text)
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line."""
    return run(_parser(), argv)


if __name__ == "__main__":
    sys.exit(main())
