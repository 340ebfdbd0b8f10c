"""`lidardraft completion`: a script that completes commands and options in a shell."""

from __future__ import annotations

import argparse

from lidardraft.errors import extra

_SHELLS = ("bash", "zsh", "tcsh")


def completion(arguments: argparse.Namespace) -> None:
    """Print the script of a shell."""
    from lidardraft.cli.main import parser

    with extra():
        import shtab
    print(shtab.complete(parser(), shell=arguments.shell))


def completion_options(parser: argparse.ArgumentParser) -> None:
    """The options of `completion`."""
    parser.add_argument("shell", choices=_SHELLS, help="shell that reads the script")
