"""How commands are declared, run, and end: exit status 0; 2 and one line on stderr where the input is wrong.

Ctrl-C is one line and 130; SIGTERM ends a command as cleanly, with 143.
"""

from __future__ import annotations

import argparse
import itertools
import os
import shutil
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from types import FrameType
from typing import Any, NoReturn

from lidardraft.errors import LidarDraftError, did_you_mean, extra, one_of, printable

Command = Callable[[argparse.Namespace], None]
_SHOWN_AFTER, _WIDEST = 1.0, 100  # s, columns


class Parser(argparse.ArgumentParser):
    """A parser whose errors are one line, with the option or the choice that was probably meant."""

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> tuple[Any, list[str]]:
        """As argparse's, but what is left over is an error here: of the command, not of what is before it."""
        # first, as an option that is missing may be the one that is misspelt
        self._check_options(args if self._subparsers is None else itertools.takewhile(_is_option, args))
        found, left = super().parse_known_args(args, namespace)
        if left:
            self.error(f"not understood: {' '.join(left)}")
        return found, left

    def _check_options(self, words: Iterable[str]) -> None:
        known = [option for option in self._option_string_actions if option.startswith("--")]
        for word in words:
            name = word.partition("=")[0]
            if name == "--":
                break
            if name.startswith("--") and " " not in word and not any(option.startswith(name) for option in known):
                self.error(f"there is no option {name}{did_you_mean(known, name)}")

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        if action.choices is not None and value not in action.choices:
            raise argparse.ArgumentError(action, f"{value!r} is not {one_of(action.choices, value)}")

    def error(self, message: str) -> NoReturn:
        """End with one line on stderr, without the whole usage, and status 2."""
        self.exit(2, f"{self.prog}: error: {printable(message)} (see `{self.prog} --help`)\n")


def _is_option(word: str) -> bool:
    return word.startswith("-")


def commands_of(parser: Parser) -> Callable[[str, Command], Parser]:
    """How to add a command to a parser: its name and the function that runs it, whose docstring is its help."""
    commands = parser.add_subparsers(required=True, metavar="COMMAND", title="commands")

    def command(name: str, function: Command) -> Parser:
        text = " ".join((function.__doc__ or "").split())
        added = commands.add_parser(name, help=text, description=text)
        added.set_defaults(command=function)
        return added

    return command


def run(parser: Parser, argv: Sequence[str] | None, *, needs: str = "") -> int:
    """Run the command that the arguments name, and give its exit status.

    `needs` is the extra to name for a missing library that several extras bring.
    """
    words = sys.argv[1:] if argv is None else argv
    if not words:
        parser.print_help(sys.stderr)
        return 2
    arguments = parser.parse_args(words)
    try:
        with _clean_end(), extra(needs), warnings.catch_warnings():
            warnings.simplefilter("default", UserWarning)
            warnings.showwarning = lambda message, *_, **__: say(message, parser.prog)
            arguments.command(arguments)
            sys.stdout.flush()
    except KeyboardInterrupt:
        say("interrupted", parser.prog)
        return 130
    except BrokenPipeError:  # who read our output has gone, as in `lidardraft evaluate | head -1`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 141
    except LidarDraftError as error:
        say(error, parser.prog)
        return 2
    except OSError as error:
        say(f"{error.filename}: {error.strerror}" if error.filename else error, parser.prog)
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


def progress(total: int, unit: str, text: str = "", *, initial: int = 0, leave: bool = True) -> Any:
    """A progress bar with rate and time left: only on a terminal, and only of what takes longer than a second."""
    from tqdm import tqdm

    size = shutil.get_terminal_size()
    return tqdm(
        total=total,
        unit=unit,
        desc=text or None,
        initial=initial,
        leave=leave,
        disable=None,
        delay=_SHOWN_AFTER,
        ncols=min(size.columns, _WIDEST),  # tqdm shows nothing on a terminal that says it has no columns or rows
        nrows=size.lines,
    )


def say(message: object, prog: str = "lidardraft") -> None:
    """One line on stderr; what a terminal would obey, such as in a name out of a broken file, is spelled out."""
    from tqdm import tqdm  # which moves its bars out of the way

    tqdm.write(f"{prog}: {printable(str(message))}", file=sys.stderr)
