"""The `lidardraft` command."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

import lidardraft
from lidardraft.cli import dataset, edit, evaluate, fit, layouts, pairs, profile, scans, studio, view
from lidardraft.cli.command import Parser, commands_of, run

_FIRST = """\
start here:
  lidardraft simulate --text "a bus ahead, trees along both sides" -o scans
  lidardraft view scans/000000.bin

`lidardraft COMMAND --help` lists the options of a command; `lidardraft-train --help` trains weights of your own.
"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line."""
    return run(_parser(), argv)


def _parser() -> Parser:
    parser = Parser(
        prog="lidardraft",
        description="Labelled LiDAR scans of your sensor, from a sentence, a layout of simple shapes, a 3D model or a "
        "labelled scan.",
        epilog=_FIRST,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"lidardraft {lidardraft.__version__}")
    command = commands_of(parser)
    scans.simulate_options(command("simulate", scans.simulate))
    scans.generate_options(command("generate", scans.generate))
    studio.studio_options(command("studio", studio.studio))
    dataset.dataset_options(command("dataset", dataset.dataset))
    view.view_options(command("view", view.view))
    edit.edit_options(command("edit", edit.edit))
    dataset.export_options(command("export", dataset.export))
    layouts.draft_options(command("draft", layouts.draft))
    layouts.raycast_options(command("raycast", layouts.raycast))
    scans.observe_options(command("observe", scans.observe))
    pairs.streets_options(command("streets", pairs.streets))
    fit.fit_options(command("fit", fit.fit))
    pairs.pairs_options(command("pairs", pairs.pairs))
    evaluate.evaluate_options(command("evaluate", evaluate.evaluate))
    profile.profile_options(command("profile", profile.profile))
    return parser


if __name__ == "__main__":
    sys.exit(main())
