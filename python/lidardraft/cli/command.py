"""How commands are declared, run, and end: exit status 0; 2 and one line on stderr where the input is wrong.

Ctrl-C is one line and 130; SIGTERM ends a command as cleanly, with 143.
"""

from __future__ import annotations

import argparse
import os
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from types import FrameType

from lidardraft.errors import LidarDraftError, printable

Command = Callable[[argparse.Namespace], None]


def commands_of(parser: argparse.ArgumentParser) -> Callable[[str, Command], argparse.ArgumentParser]:
    """How to add a command to a parser: its name and the function that runs it, whose docstring is its help."""
    commands = parser.add_subparsers(required=True, metavar="COMMAND", title="commands")

    def command(name: str, function: Command) -> argparse.ArgumentParser:
        text = " ".join((function.__doc__ or "").split())
        added = commands.add_parser(name, help=text, description=text)
        added.set_defaults(command=function)
        return added

    return command


def run(parser: argparse.ArgumentParser, argv: Sequence[str] | None) -> int:
    """Run the command that the arguments name, and give its exit status."""
    words = sys.argv[1:] if argv is None else argv
    if not words:
        parser.print_help(sys.stderr)
        return 2
    arguments = parser.parse_args(words)
    try:
        with _clean_end(), warnings.catch_warnings():
            warnings.simplefilter("default", UserWarning)
            warnings.showwarning = lambda message, *_, **__: say(parser.prog, message)
            arguments.command(arguments)
            sys.stdout.flush()
    except KeyboardInterrupt:
        say(parser.prog, "interrupted")
        return 130
    except BrokenPipeError:  # who read our output has gone, as in `lidardraft evaluate | head -1`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 141
    except LidarDraftError as error:
        say(parser.prog, error)
        return 2
    except OSError as error:
        say(parser.prog, f"{error.filename}: {error.strerror}" if error.filename else error)
        return 2
    return 0


@contextmanager
def _clean_end() -> Iterator[None]:
    """Ctrl-C and SIGTERM leave the block as exceptions do: worker processes end, and no half-written file stays.

    After the first one further ones are ignored until the process has ended.
    """
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    # only the main thread may handle signals, and `nohup` and the like start a process with some ignored
    heard = [number for number, handler in before.items() if handler not in (signal.SIG_IGN, None)]
    if threading.current_thread() is not threading.main_thread():
        heard = []
    left = False

    def leave(number: int, _frame: FrameType | None) -> None:
        nonlocal left
        left = True
        for each in heard:
            signal.signal(each, signal.SIG_IGN)
        raise KeyboardInterrupt if number == signal.SIGINT else SystemExit(128 + number)

    for number in heard:
        signal.signal(number, leave)
    try:
        yield
    finally:
        if not left:
            for number in heard:
                signal.signal(number, before[number])


def say(prog: str, message: object) -> None:
    """One line on stderr; what a terminal would obey, such as in a name out of a broken file, is spelled out."""
    from tqdm import tqdm  # which moves its bars out of the way

    tqdm.write(f"{prog}: {printable(str(message))}", file=sys.stderr)
