"""`lidardraft generate`: labelled scans into a folder of their own."""

from __future__ import annotations

import argparse
from pathlib import Path

from lidardraft.cli.arguments import add_sensor, add_weights, whole_number
from lidardraft.cli.inputs import add_inputs, read_layout
from lidardraft.cli.output_folder import check_empty
from lidardraft.scene.sensor import Sensor


def generate(arguments: argparse.Namespace) -> None:
    """Make labelled LiDAR scans, with boxes and pictures, from a sentence, a layout, a 3D model or a labelled scan."""
    from tqdm import tqdm

    folder, num = Path(arguments.output), arguments.num
    check_empty(folder, ", or --overwrite to replace its scans", but=".*" if arguments.overwrite else "")
    sensor = Sensor.preset(arguments.sensor)
    layout = read_layout(arguments)

    from lidardraft.drafting.text import layout_from_text
    from lidardraft.pipeline import Pipeline

    pipeline = Pipeline.from_pretrained(arguments.weights, device=arguments.device, steps=arguments.steps)
    with tqdm(total=num * arguments.steps, unit="step", disable=None) as bar:
        for number in range(num):
            bar.set_description(f"scan {number + 1} of {num}")
            seed = arguments.seed + number
            if number > 0 and arguments.text is not None:
                layout = layout_from_text(arguments.text, seed=seed)
            scan = pipeline(layout, sensor=sensor, seed=seed, on_step=bar.update)
            if number == 0:
                _clear(folder)
            scan.save(folder / f"{number:06d}")
    last = f" to {num - 1:06d}.bin" if num > 1 else ""
    print(f"{folder}: {num} scan{'s' * (num > 1)}, 000000.bin{last}, each with .label, .boxes.json and .png")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of the command."""
    add_inputs(parser)
    add_weights(parser.add_argument_group("model"))
    output = parser.add_argument_group("output")
    add_sensor(output, of=" to make scans of")
    text = "scans to make, with seeds counting up (default 1)"
    output.add_argument("-n", "--num", type=whole_number(1), default=1, metavar="N", help=text)
    output.add_argument("-o", "--output", required=True, metavar="FOLDER", help="where scans go: new or empty")
    output.add_argument("--overwrite", action="store_true", help="replace the scans that are in FOLDER already")


def _clear(folder: Path) -> None:
    """Make the folder, without the scans of an earlier call: numbers with a layout beside them. The rest stays."""
    from lidardraft.pipeline import SCAN_ENDINGS

    folder.mkdir(parents=True, exist_ok=True)
    for layout in folder.glob("*.layout.json"):
        name = layout.name.removesuffix(".layout.json")
        if name.isdigit():
            for ending in SCAN_ENDINGS:
                (folder / f"{name}{ending}").unlink(missing_ok=True)
