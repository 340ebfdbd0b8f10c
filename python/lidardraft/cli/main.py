"""The `lidardraft` command."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

import lidardraft
from lidardraft.cli import draft, evaluate, fit, generate, observe, pairs, raycast, simulate, streets, view
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
    simulate.add_arguments(command("simulate", simulate.simulate))
    generate.add_arguments(command("generate", generate.generate))
    view.add_arguments(command("view", view.view))
    draft.add_arguments(command("draft", draft.draft))
    raycast.add_arguments(command("raycast", raycast.raycast))
    observe.add_arguments(command("observe", observe.observe))
    streets.add_arguments(command("streets", streets.streets))
    fit.add_arguments(command("fit", fit.fit))
    pairs.add_arguments(command("pairs", pairs.pairs))
    evaluate.add_arguments(command("evaluate", evaluate.evaluate))
    return parser


if __name__ == "__main__":
    sys.exit(main())
