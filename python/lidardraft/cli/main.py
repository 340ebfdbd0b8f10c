"""The `lidardraft` command."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from lidardraft.cli import streets
from lidardraft.errors import FormatError, LidarDraftError
from lidardraft.scene.layout import Layout
from lidardraft.scene.raycast import raycast
from lidardraft.scene.sensor import PRESETS, Sensor

if TYPE_CHECKING:
    from lidardraft.pipeline import Pipeline


def draft(arguments: argparse.Namespace) -> None:
    """A sentence or a labelled scan becomes a layout."""
    layout = _layout(arguments, arguments.seed)
    layout.save(arguments.output)
    print(f"{arguments.output}: {len(layout)} primitives")


def cast(arguments: argparse.Namespace) -> None:
    """A layout becomes a drawing: depth, label and instance images."""
    image = raycast(Layout.load(arguments.layout), Sensor.preset(arguments.sensor))
    image.save(arguments.output)
    print(f"{arguments.output}: {image.sensor.name}, {image.valid.mean():.0%} of the rays hit")


def generate(arguments: argparse.Namespace) -> None:
    """A sentence, a layout or a labelled scan becomes labelled scans."""
    from tqdm import tqdm

    sensor = Sensor.preset(arguments.sensor)
    first = _layout(arguments, arguments.seed)
    pipeline = _pipeline(arguments)
    folder = Path(arguments.output)
    for number in tqdm(range(arguments.num), unit="scan", disable=arguments.num == 1):
        seed = arguments.seed + number
        layout = first if number == 0 or arguments.text is None else _layout(arguments, seed)
        scan = pipeline(layout, sensor=sensor, seed=seed)
        folder.mkdir(parents=True, exist_ok=True)
        scan.save(folder / f"{number:06d}")
    print(f"{folder}: {arguments.num} scan{'s' * (arguments.num > 1)}")


def view(arguments: argparse.Namespace) -> None:
    """A .bin scan (with the .label beside it), an .npz range image or a .json layout becomes a picture."""
    from lidardraft import view

    path = Path(arguments.path)
    picture = view.render_file(path, Sensor.preset(arguments.sensor))
    output = Path(arguments.output) if arguments.output else path.with_suffix(".view.png")
    view.save_png(picture, output)
    print(output)


def evaluate(arguments: argparse.Namespace) -> None:
    """How well generated scans of unseen streets obey their layouts, beside random weights and the drawing itself."""
    from lidardraft.evaluation import evaluate, unseen_streets

    pairs = unseen_streets(arguments.num, sensor=Sensor.preset(arguments.sensor), seed=arguments.seed)
    print(f"{len(pairs)} streets, {arguments.sensor}, {arguments.steps} steps")
    print(f"{'':16}{'objects':>9}{'all':>9}{'drop':>9}{'BEV JSD':>9}")
    for row in evaluate(_pipeline(arguments), pairs):
        print(f"{row.name:16}{row.objects:9.3f}{row.overall:9.3f}{row.drop:9.3f}{row.jsd:9.3f}", flush=True)
        print(" " * 4 + ", ".join(f"{name} {share:.2f}" for name, share in row.by_class.items()))


def _layout(arguments: argparse.Namespace, seed: int) -> Layout:
    if arguments.labels is not None and arguments.points is None:
        raise FormatError("--labels goes with --points")
    if arguments.text is not None:
        from lidardraft.drafting.text import layout_from_text

        layout = layout_from_text(arguments.text, seed=seed)
        if layout.provenance["not_understood"]:
            print(f"not understood: {', '.join(layout.provenance['not_understood'])}", file=sys.stderr)
        return layout
    if arguments.points is not None:
        from lidardraft.drafting.cloud import layout_from_cloud
        from lidardraft.formats import kitti, semantickitti

        if not arguments.labels:
            raise FormatError("--points needs --labels: a layout is made of classes")
        points, _ = kitti.read_bin(arguments.points)
        labels, instances = semantickitti.read_label(arguments.labels, len(points))
        height = Sensor.preset(arguments.sensor).mount_height
        return layout_from_cloud(points, labels, instances=instances, sensor_height=height)
    return Layout.load(arguments.layout)


def _pipeline(arguments: argparse.Namespace) -> Pipeline:
    from lidardraft.pipeline import Pipeline

    return Pipeline.from_pretrained(arguments.weights, device=arguments.device, steps=arguments.steps)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="lidardraft", description="From a sentence, a scan or a layout to LiDAR scans."
    )
    command = commands_of(parser)

    def source(added: argparse.ArgumentParser) -> argparse._MutuallyExclusiveGroup:
        group = added.add_mutually_exclusive_group(required=True)
        group.add_argument("--text", metavar="SENTENCE", help="what is on the road")
        group.add_argument("--points", metavar="FILE.bin", help="a scan: KITTI float32 x y z intensity")
        added.add_argument("--labels", metavar="FILE.label", help="its SemanticKITTI labels")
        added.add_argument("--seed", type=_seed, default=0, help="the same seed gives the same result (default 0)")
        return group

    def sensor(added: argparse.ArgumentParser) -> None:
        text = f"{', '.join(PRESETS)} or a .json file (default hdl64e)"
        added.add_argument("--sensor", default="hdl64e", metavar="NAME", help=text)

    def weights(added: argparse.ArgumentParser) -> None:
        added.add_argument(
            "--weights", default="street", metavar="NAME", help="packaged weights or a file (default street)"
        )
        added.add_argument("--steps", type=_positive, default=20, help="sampling steps (default 20)")
        added.add_argument("--device", default="cpu", help="torch device (default cpu)")

    added = command("draft", draft)
    source(added)
    sensor(added)
    added.add_argument("-o", "--output", required=True, metavar="LAYOUT.json")

    added = command("raycast", cast)
    added.add_argument("layout", metavar="LAYOUT.json")
    sensor(added)
    added.add_argument("-o", "--output", required=True, metavar="DRAWING.npz")

    added = command("generate", generate)
    source(added).add_argument("--layout", metavar="LAYOUT.json", help="a layout")
    sensor(added)
    weights(added)
    added.add_argument("-n", "--num", type=_positive, default=1, help="how many scans, seeds counting up (default 1)")
    added.add_argument("-o", "--output", required=True, metavar="FOLDER")

    added = command("view", view)
    added.add_argument("path", metavar="FILE")
    sensor(added)
    added.add_argument("-o", "--output", metavar="PICTURE.png", help="default: FILE.view.png")

    added = command("streets", streets.write)
    streets.add_arguments(added, num=6)
    added.add_argument("-o", "--out", metavar="FOLDER", help="of pairs: `lidardraft-train` learns from it")
    added.add_argument("--look", metavar="PICTURE.png", nargs="?", const="streets.png", help="a picture instead")

    added = command("evaluate", evaluate)
    sensor(added)
    weights(added)
    added.add_argument("-n", "--num", type=_positive, default=50, help="how many streets (default 50)")
    added.add_argument("--seed", type=_seed, default=1_000_000, help="seed of the streets (default 1000000)")
    return parser


def _positive(text: str) -> int:
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"{value} is less than 1")
    return value


def _seed(text: str) -> int:
    value = int(text)
    if not 0 <= value < 2**32:
        raise argparse.ArgumentTypeError(f"{value} is not between 0 and 2^32 - 1")
    return value


def commands_of(parser: argparse.ArgumentParser) -> Callable[[str, object], argparse.ArgumentParser]:
    """How to add a command to a parser: its name and the function that runs it, whose docstring is its help."""
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    def command(name: str, function: object) -> argparse.ArgumentParser:
        text = function.__doc__ or ""
        added = commands.add_parser(name, help=text, description=text)
        added.set_defaults(command=function)
        return added

    return command


def run(parser: argparse.ArgumentParser, argv: Sequence[str] | None) -> int:
    """Run the command that the arguments name; 0 on success, 2 and one line on stderr where the input is wrong."""
    arguments = parser.parse_args(argv)
    try:
        arguments.command(arguments)
    except (LidarDraftError, OSError) as error:
        print(f"{parser.prog}: {error}", file=sys.stderr)
        return 2
    return 0


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line."""
    return run(_parser(), argv)


if __name__ == "__main__":
    sys.exit(main())
