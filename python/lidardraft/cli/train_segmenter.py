"""`lidardraft-train segmenter`: a network that tells the class of each return."""

from __future__ import annotations

import argparse

from lidardraft.cli.arguments import add_minutes, add_seed, add_training_device, whole_number
from lidardraft.cli.training_progress import show


def segmenter(arguments: argparse.Namespace) -> None:
    """Train a segmenter, which tells the class of each return, on the scans of pairs; a second call goes on."""
    from lidardraft.training.loop import check_run_folder
    from lidardraft.training.pairs import PairFolder
    from lidardraft.training.segmentation import SegmentationConfig, train_segmenter

    config = SegmentationConfig(steps=arguments.steps, batch=arguments.batch, seed=arguments.seed)
    check_run_folder(arguments.run)
    folder = PairFolder(arguments.pairs)
    reports = train_segmenter(config, folder, arguments.run, device=arguments.device, max_minutes=arguments.minutes)
    show(reports, config.steps, "segmenter")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of the command."""
    text = "training pairs, as `lidardraft streets -o FOLDER` makes them"
    parser.add_argument("--pairs", required=True, metavar="FOLDER", help=text)
    add_minutes(parser)
    text = "where the weights and the state of the run go; a second call goes on"
    parser.add_argument("-o", "--output", dest="run", required=True, metavar="FOLDER", help=text)
    text = "steps of training (default 2000)"
    parser.add_argument("--steps", type=whole_number(1), default=2000, metavar="N", help=text)
    parser.add_argument("--batch", type=whole_number(1), default=2, metavar="N", help="whole scans a step (default 2)")
    add_seed(parser)
    add_training_device(parser)
