"""The `lidardraft-train` command: streets become pairs, pairs become weights."""

from __future__ import annotations

import argparse
import dataclasses
import itertools
import sys
from collections.abc import Sequence
from pathlib import Path

from lidardraft.errors import LidarDraftError
from lidardraft.scene.sensor import PRESETS, Sensor

RECIPES = ("small", "tiny", "paper")


def pairs(arguments: argparse.Namespace) -> None:
    """Scan procedural streets into a folder of training pairs; goes on where an interrupted run stopped."""
    from tqdm import tqdm

    from lidardraft.streets.street import StreetConfig, streets
    from lidardraft.training.pairs import pairs_on_disk, write_pairs

    start = pairs_on_disk(arguments.pairs)
    config = StreetConfig(sensor=Sensor.preset(arguments.sensor))
    source = itertools.islice(streets(arguments.seed, config, start=start), max(arguments.num - start, 0))
    with tqdm(total=arguments.num, initial=start, unit="pair", desc="streets") as bar:
        for count in write_pairs(arguments.pairs, ((pair.scan, pair.drawing) for pair in source)):
            bar.update(count - bar.n)


def unconditional(arguments: argparse.Namespace) -> None:
    """Stage one: the score network learns what scans look like."""
    _train(arguments, "base", None)


def controlnet(arguments: argparse.Namespace) -> None:
    """Stage two: a ControlNet learns to obey the drawing, on the frozen network of stage one."""
    _train(arguments, "control", Path(arguments.base))


def street(arguments: argparse.Namespace) -> None:
    """All of it: pairs, both stages, and the weight file with its card."""
    from lidardraft.diffusion import checkpoint

    work = Path(arguments.work)
    arguments.pairs = str(work / "pairs")
    pairs(arguments)
    arguments.run = str(work / "base")
    arguments.steps = arguments.base_steps
    unconditional(arguments)
    arguments.base, arguments.run = str(work / "base" / "weights.safetensors"), str(work / "control")
    arguments.steps = arguments.control_steps
    controlnet(arguments)
    weights = work / "control" / "weights.safetensors"
    card = {
        "data": f"{arguments.num} procedural street scans, seed {arguments.seed}, {arguments.sensor}",
        "base": checkpoint.read_card(arguments.base),
        "control": checkpoint.read_card(weights),
    }
    Path(arguments.output).parent.mkdir(parents=True, exist_ok=True)
    checkpoint.save(checkpoint.load(weights), arguments.output, card, half=True)
    print(arguments.output)


def _train(arguments: argparse.Namespace, stage: str, base: Path | None) -> None:
    from tqdm import tqdm

    from lidardraft.diffusion import checkpoint
    from lidardraft.training import recipes
    from lidardraft.training.pairs import PairFolder
    from lidardraft.training.trainer import train

    config = getattr({"small": recipes.small, "tiny": recipes.tiny, "paper": recipes.paper}[arguments.recipe](), stage)
    if arguments.steps is not None:
        config = dataclasses.replace(config, steps=arguments.steps)
    reports = train(
        config,
        PairFolder(arguments.pairs),
        arguments.run,
        base=checkpoint.load(base) if base else None,
        device=arguments.device,
        max_minutes=arguments.minutes,
    )
    with tqdm(total=config.steps, unit="step", desc=stage) as bar:
        for report in reports:
            bar.update(report.step - bar.n)
            bar.set_postfix_str(f"loss {report.loss:.3f}, {report.crops_per_second:.1f} crops/s")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="lidardraft-train", description="From procedural streets to weights.")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    def command(name: str, run: object) -> argparse.ArgumentParser:
        text = run.__doc__ or ""
        added = commands.add_parser(name, help=text, description=text)
        added.set_defaults(run_command=run)
        return added

    def data(added: argparse.ArgumentParser) -> None:
        added.add_argument("--num", type=int, default=2400, help="how many pairs (default 2400)")
        added.add_argument("--seed", type=int, default=0, help="seed of the streets (default 0)")
        added.add_argument("--sensor", default="hdl64e", help=f"{', '.join(PRESETS)} or a .json file (default hdl64e)")

    def stage(added: argparse.ArgumentParser) -> None:
        added.add_argument("--recipe", choices=RECIPES, default="small", help="size of the network (default small)")
        added.add_argument("--device", default="cpu", help="torch device (default cpu)")
        added.add_argument(
            "--minutes", type=float, default=float("inf"), help="stop after so long; the same call goes on"
        )

    added = command("pairs", pairs)
    data(added)
    added.add_argument("-o", "--output", dest="pairs", required=True, metavar="FOLDER")

    for name, run in (("unconditional", unconditional), ("controlnet", controlnet)):
        added = command(name, run)
        stage(added)
        added.add_argument("--steps", type=int, help="instead of the recipe's")
        added.add_argument("--pairs", required=True, metavar="FOLDER")
        if run is controlnet:
            added.add_argument("--base", required=True, metavar="WEIGHTS", help="weights.safetensors of stage one")
        added.add_argument("-o", "--output", dest="run", required=True, metavar="FOLDER")

    added = command("street", street)
    data(added)
    stage(added)
    added.add_argument("--base-steps", type=int, help="steps of stage one, instead of the recipe's")
    added.add_argument("--control-steps", type=int, help="steps of stage two, instead of the recipe's")
    added.add_argument("--work", default="out/street", metavar="FOLDER", help="pairs and runs (default out/street)")
    added.add_argument("-o", "--output", default="street.safetensors", metavar="WEIGHTS")
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; 0 on success, 2 where the input is wrong."""
    arguments = _parser().parse_args(argv)
    try:
        arguments.run_command(arguments)
    except (LidarDraftError, OSError) as error:
        print(f"lidardraft-train: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
