"""How commands are declared, run, and end: exit status 0; 2 and one line on stderr if the input is invalid.

Ctrl-C is one line and 130; SIGTERM ends a command as cleanly, with 143.
"""

from __future__ import annotations

import argparse
import itertools
import json
import math
import os
import shutil
import signal
import sys
import threading
import warnings
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from importlib import import_module
from types import FrameType
from typing import Any, NamedTuple, NoReturn

from lidardraft.errors import LidarDraftError, did_you_mean, extra, one_of, printable

_SHOWN_AFTER, _WIDEST = 1.0, 100  # s, columns
_EVERY = 60.0  # s between the lines of a log
_QUIET = ContextVar("quiet", default=False)


class Command(NamedTuple):
    """A command: its module, which has a function of the command's name to run it, and NAME_options to declare its
    options; the text of its help; and an example of a call."""

    module: str
    text: str
    example: str


class Parser(argparse.ArgumentParser):
    """A parser whose errors are one line, with the option or the choice that was probably meant."""

    example = ""

    def format_help(self) -> str:
        """As argparse's, followed by an example."""
        return super().format_help() + (f"\nexample:\n  {self.example}\n" if self.example else "")

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> tuple[Any, list[str]]:
        """As argparse's, but arguments left over are an error of this command, not of those before it."""
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


def add_commands(parser: Parser, commands: Mapping[str, Command], declared: Collection[str]) -> None:
    """Add all commands to a parser by name, and the options of those `declared`, whose modules are imported."""
    added = parser.add_subparsers(required=True, metavar="COMMAND", title="commands")
    for name, (module, text, example) in commands.items():
        one = added.add_parser(name, help=text, description=text)
        one.example = example
        if name in declared:
            found = import_module(module)
            getattr(found, f"{name}_options")(one)
            one.add_argument("-q", "--quiet", action="store_true", help="print nothing but warnings and errors")
            one.set_defaults(command=getattr(found, name), json=one.get_default("json") or False)


def run(parser: Parser, argv: Sequence[str] | None, *, needs: str = "") -> int:
    """Run the command of the arguments, and return its exit status.

    `needs` is the extra to name for a missing library that several extras install.
    """
    words = sys.argv[1:] if argv is None else argv
    if not words:
        parser.print_help(sys.stderr)
        return 2
    arguments = parser.parse_args(words)
    before = _QUIET.set(arguments.quiet)
    try:
        with _clean_end(), extra(needs), warnings.catch_warnings():
            warnings.simplefilter("default", UserWarning)
            warnings.showwarning = lambda message, *_, **__: say(message, parser.prog)
            arguments.command(arguments)
            sys.stdout.flush()
    except KeyboardInterrupt:
        say("interrupted", parser.prog)
        return 130
    except BrokenPipeError:  # the reader of the output has ended, as in `lidardraft evaluate | head -1`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 141
    except LidarDraftError as error:
        say(error, parser.prog)
        return 2
    except OSError as error:
        say(f"{error.filename}: {error.strerror}" if error.filename else error, parser.prog)
        return 2
    finally:
        _QUIET.reset(before)
    return 0


@contextmanager
def _clean_end() -> Iterator[None]:
    """Ctrl-C and SIGTERM leave the block as exceptions do: worker processes end, and no half-written file stays.

    Further ones are ignored until the process has ended.
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


class _Log:
    """Stderr if it is no terminal: each state of a bar is a line."""

    def write(self, text: str) -> None:
        if text.strip():
            print(text.strip(), file=sys.stderr, flush=True)


def progress(total: int, unit: str, text: str = "", *, initial: int = 0, leave: bool = True) -> Any:
    """A progress bar with rate and time left, shown after a second; in a log, a line a minute."""
    from tqdm import tqdm

    size = shutil.get_terminal_size()
    # tqdm shows nothing on a terminal that reports no columns or rows
    how: dict[str, Any] = {"delay": _SHOWN_AFTER, "ncols": min(size.columns, _WIDEST), "leave": leave}
    if not sys.stderr.isatty():  # numbers without a bar; each update looks at the clock
        how = {"delay": _EVERY, "ncols": 0, "leave": False, "mininterval": _EVERY, "miniters": 1, "file": _Log()}
    options = {"unit": unit, "desc": text or None, "initial": initial, "nrows": size.lines}
    return tqdm(total=total, disable=_QUIET.get(), **options, **how)


def report(arguments: argparse.Namespace, text: str, **facts: Any) -> None:
    """Print the result of a command: a text; with --json its facts, as an object a line; with --quiet nothing."""
    if arguments.json:
        print(json.dumps(_known(facts), allow_nan=False), flush=True)
    elif not arguments.quiet:
        print(text, flush=True)


def _known(facts: Any) -> Any:
    """Facts with None in place of numbers that are not known, for which JSON has no word."""
    if isinstance(facts, dict):
        return {name: _known(fact) for name, fact in facts.items()}
    if isinstance(facts, list | tuple):
        return [_known(fact) for fact in facts]
    return None if isinstance(facts, float) and not math.isfinite(facts) else facts


def add_json(parser: argparse.ArgumentParser) -> None:
    """Add --json to a command that reports."""
    parser.add_argument("--json", action="store_true", help="print results as JSON, an object a line")


def say(message: object, prog: str = "lidardraft") -> None:
    """Print one line on stderr; control characters, as from a name in a broken file, are spelled out."""
    from tqdm import tqdm  # it moves its bars out of the way

    tqdm.write(f"{prog}: {printable(str(message))}", file=sys.stderr)
