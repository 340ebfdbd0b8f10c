"""A folder of scans, a seed each: what `simulate` and `generate` write alike."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from lidardraft.cli.arguments import add_sensor, whole_number
from lidardraft.cli.inputs import layout_of_text
from lidardraft.cli.output_folder import check_empty
from lidardraft.scene.layout import Layout

if TYPE_CHECKING:
    from lidardraft.cli.arguments import Options
    from lidardraft.scan import Scan
    from lidardraft.scene.range_image import RangeImage

T = TypeVar("T")


def add_scan_output(parser: argparse.ArgumentParser) -> None:
    """--sensor, --num, --output and --overwrite, in a group of their own."""
    output = parser.add_argument_group("output")
    add_sensor(output, of=" to make scans of")
    text = "scans to make, with seeds counting up (default 1)"
    output.add_argument("-n", "--num", type=whole_number(1), default=1, metavar="N", help=text)
    add_folder(output)


def add_folder(parser: Options) -> None:
    """--output and --overwrite."""
    parser.add_argument("-o", "--output", required=True, metavar="FOLDER", help="where scans go: new or empty")
    parser.add_argument("--overwrite", action="store_true", help="replace the scans that are in FOLDER already")


def check_output(arguments: argparse.Namespace) -> None:
    """Raises `FormatError` where the folder holds anything and --overwrite is not given."""
    otherwise = ", or --overwrite to replace its scans"
    check_empty(Path(arguments.output), otherwise, but=".*" if arguments.overwrite else "")


def layouts(arguments: argparse.Namespace, first: Layout) -> Iterator[tuple[int, Layout]]:
    """Seed and layout of each scan: `first`, which a sentence replaces with another one for each further seed."""
    yield arguments.seed, first
    for seed in range(arguments.seed + 1, arguments.seed + arguments.num):
        if arguments.text is None:
            yield seed, first
        else:
            yield seed, layout_of_text(arguments, seed)


def write_scans(arguments: argparse.Namespace, scans: Iterable[Scan]) -> None:
    """Save the scans, numbered from 0; those of an earlier call go when the first one is there."""
    from lidardraft.scan import Scan

    _write(arguments, scans, Scan.save, ".label, .boxes.json and .png")


def write_observed(arguments: argparse.Namespace, images: Iterable[RangeImage]) -> None:
    """As `write_scans`, of images without a layout."""
    from lidardraft.scan import save_observed

    _write(arguments, images, save_observed, ".label and .png")


def _write(arguments: argparse.Namespace, scans: Iterable[T], save: Callable[[T, Path], None], beside: str) -> None:
    folder, count = Path(arguments.output), 0
    for count, scan in enumerate(scans, start=1):
        if count == 1:
            _clear(folder)
        save(scan, folder / f"{count - 1:06d}")
    last = f" to {count - 1:06d}.bin" if count > 1 else ""
    print(f"{folder}: {count} scan{'s' * (count > 1)}, 000000.bin{last}, each with {beside}")


def _clear(folder: Path) -> None:
    """Make the folder, without the scans of an earlier call: numbers with a sensor beside them. The rest stays."""
    from lidardraft.scan import SCAN_ENDINGS

    folder.mkdir(parents=True, exist_ok=True)
    for sensor in folder.glob("*.sensor.json"):
        name = sensor.name.removesuffix(".sensor.json")
        if name.isdigit():
            for ending in SCAN_ENDINGS:
                (folder / f"{name}{ending}").unlink(missing_ok=True)
