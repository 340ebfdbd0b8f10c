"""The `lidardraft-train` command: pairs become weights."""

from __future__ import annotations

import sys
from collections.abc import Sequence

import lidardraft
from lidardraft.cli import ablation, train_segmenter, train_street
from lidardraft.cli.command import Parser, commands_of, run


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line."""
    return run(_parser(), argv, needs="train")


def _parser() -> Parser:
    parser = Parser(
        prog="lidardraft-train",
        description="Weights of your own, from procedural streets.",
        epilog="start here: `lidardraft-train street` makes streets, learns from them, and writes one weight file for "
        "`lidardraft generate --weights FILE`.",
    )
    parser.add_argument("--version", action="version", version=f"lidardraft {lidardraft.__version__}")
    command = commands_of(parser)
    train_segmenter.add_arguments(command("segmenter", train_segmenter.segmenter))
    train_street.add_arguments(command("street", train_street.street))
    ablation.add_arguments(command("ablation", ablation.ablation))
    return parser


if __name__ == "__main__":
    sys.exit(main())
