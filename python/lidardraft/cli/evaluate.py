"""`lidardraft evaluate`: scores of generated scans, of unseen streets or beside recordings by a published protocol."""

from __future__ import annotations

import argparse
import dataclasses
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from lidardraft.cli.arguments import (
    add_seed,
    add_sensor,
    add_weights,
    positive,
    read_pipeline,
    read_sensor,
    whole_number,
)
from lidardraft.cli.command import add_json, progress, report
from lidardraft.cli.inputs import scan_files
from lidardraft.errors import FormatError
from lidardraft.protocols import PROTOCOLS, Protocol, Score, compare
from lidardraft.scene.sensor import Sensor

if TYPE_CHECKING:
    from lidardraft.evaluation import Scores
    from lidardraft.pipeline import Pipeline
    from lidardraft.streets import StreetPair

_SEED = 1_000_000  # of streets that no training used
_COLUMNS = ("objects", "other", "overall", "drop", "range", "height", "bev", "classes", "holes", "lone")
_CALLED = {"overall": "all", "bev": "BEV"}  # columns with other names than the fields of `Scores`
_SMALL = 0.01  # lower scores are printed x 1e-4, as in published tables


def evaluate(arguments: argparse.Namespace) -> None:
    """Score generated scans: of weights on unseen streets, or folders of scans against recordings by a published
    protocol."""
    folders = (arguments.real, arguments.generated)
    if (arguments.protocol, *folders) == (None,) * 3:
        _evaluate_weights(arguments)
    elif None in (arguments.protocol, *folders):
        raise FormatError("a published protocol takes all three: --protocol, --real and --generated")
    else:
        _print_cards(arguments)


def _evaluate_weights(arguments: argparse.Namespace) -> None:
    """Print the scores of weights on unseen streets."""
    sensor, num = read_sensor(arguments.sensor), arguments.num
    pipeline = read_pipeline(arguments)
    pairs = unseen_streets(num, sensor, arguments.seed)
    head = f"{num} street{'s' * (num > 1)}, {sensor.name}, {pipeline.steps} steps"
    columns = f"{'':16}{''.join(f'{_CALLED.get(name, name):>9}' for name in _COLUMNS)}"
    report(arguments, f"{head}\n{columns}", streets=num, sensor=sensor.name, steps=pipeline.steps)
    for row in scores(pipeline, pairs):
        lines = [f"{row.name:16}{''.join(f'{getattr(row, field):9.3f}' for field in _COLUMNS)}"]
        lines += [f"    all, by class: {_by_class(row.by_class)}"]
        lines += [f"    intensity (JSD), by class: {_by_class(row.intensity)}"] if row.intensity else []
        report(arguments, "\n".join(lines), **dataclasses.asdict(row))


def _by_class(values: dict[str, float]) -> str:
    return ", ".join(f"{name} {value:.2f}" for name, value in values.items())


def unseen_streets(num: int, sensor: Sensor, seed: int = _SEED) -> list[StreetPair]:
    """Streets for scores, made behind a progress bar."""
    from lidardraft import evaluation

    with progress(num, "street", "making streets", leave=False) as bar:
        return evaluation.unseen_streets(num, sensor=sensor, seed=seed, on_street=bar.update)


def scores(pipeline: Pipeline, pairs: list[StreetPair]) -> Iterator[Scores]:
    """The rows of scores; the progress bar is cleared while a row is printed."""
    from lidardraft import evaluation

    with progress(2 * len(pairs), "scan", "generating", leave=False) as bar:
        for row in evaluation.evaluate(pipeline, pairs, on_scan=bar.update):
            bar.clear()
            yield row


def evaluate_options(parser: argparse.ArgumentParser) -> None:
    """The options of `evaluate`."""
    parser.epilog = (
        "objects, all: share of the returns on objects, or on anything, within 0.5 m or 5 % of the layout; other: of "
        "those on objects, with the layout of another street. drop: share of the rays that hit the layout and return "
        "nothing. range, height, BEV, classes: Jensen-Shannon distances of ranges, heights, top views and classes from "
        "those of the detailed scans; 0 is equal. holes: of the places between two returns of a surface within 20 m, "
        "the share that returns nothing. lone: share of the returns that have no neighbour within 0.5 m and 3 %. "
        "intensity (JSD): how far the intensities of a class are from those of the detailed scans. untrained: the same "
        "network with random weights: what these and the rows before them reach too, training has not earned."
    )
    folders = parser.add_argument_group("scans in folders, beside recordings")
    text = "as these define their metrics; each is printed with its definition and its noise floor"
    folders.add_argument("--protocol", choices=PROTOCOLS, help=text)
    text = "recorded scans: files, or folders, of .bin, .pcd.bin, .pcd, .ply, .npz, .las, .pkl.gz or .pcap"
    folders.add_argument("--real", nargs="+", metavar="SCANS", help=text)
    folders.add_argument("--generated", nargs="+", metavar="SCANS", help="generated scans, likewise")
    text = "number for an intensity of 1 in the scans of --real, if their format does not define it"
    folders.add_argument("--intensity-scale", type=positive, metavar="X", help=text)
    text = "folder of the public weights for FRD, FRID and FPD; without it, the command names their source"
    folders.add_argument("--networks", metavar="FOLDER", help=text)
    add_sensor(parser)
    add_weights(parser)
    text = "streets to score (default 50)"
    parser.add_argument("-n", "--num", type=whole_number(1), default=50, metavar="N", help=text)
    add_seed(parser, default=_SEED)
    add_json(parser)


def _print_cards(arguments: argparse.Namespace) -> None:
    """Print the metric cards of two sets of scans."""
    recorded, generated = scan_files(arguments.real), scan_files(arguments.generated)
    cards = _compared(arguments, PROTOCOLS[arguments.protocol], recorded, generated)
    first = cards[0]
    head = f"{first.protocol}: {first.generated} generated beside {first.recorded} recorded scans; {first.source}\n"
    head += f"scans: {first.projection}\n"
    if first.floor_scans > 1:
        head += (
            f"floor: {first.floor_scans} recorded scans beside as many others, the least and the most of 10 halvings\n"
        )
    for card in cards:
        network = f"\n     network: {card.network}" if card.network else ""
        text = f"{card.metric:5}{card.left_out or _shown(card)}\n     {card.definition}{network}"
        report(arguments, f"{head if card is first else ''}{text}", **dataclasses.asdict(card))


def _compared(
    arguments: argparse.Namespace, protocol: Protocol, recorded: list[Path], generated: list[Path]
) -> list[Score]:
    """The scores of a protocol, behind a progress bar."""
    total = sum(protocol.drawn(len(recorded), len(generated)))
    with progress(total, "scan", "measuring", leave=False) as bar:
        return compare(
            protocol,
            recorded,
            generated,
            networks=arguments.networks,
            device=arguments.device,
            seed=arguments.seed,
            on_scan=bar.update,
            intensity_scale=arguments.intensity_scale,
        )


def _shown(card: Score) -> str:
    """A score and its floor, x 1e-4 if it is small."""
    scale, unit = (1e4, " x 1e-4") if abs(card.value) < _SMALL else (1.0, "")
    floor = f"   floor {scale * min(card.floor):.4g} to {scale * max(card.floor):.4g}" if card.floor else ""
    return f"{scale * card.value:10.4g}{floor}{unit}"
