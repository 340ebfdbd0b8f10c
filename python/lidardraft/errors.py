"""The errors for bad input. Each message names the thing, the value and the limit."""

import operator
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any


def one_of(names: Iterable[str], value: object) -> str:
    """The part of a message on a `value` that is none of `names`: all of them, and the one that was probably meant."""
    known = list(names)
    return f"one of {', '.join(known) or 'none'}{did_you_mean(known, value)}"


def did_you_mean(names: Iterable[str], value: object) -> str:
    """The end of a message on a `value` that is none of `names`: the one that was probably meant, or ""."""
    nearest = nearest_name(names, value)
    return "" if nearest is None else f"; did you mean {nearest!r}?"


def nearest_name(names: Iterable[str], value: object) -> str | None:
    """The one of `names` that a misspelled `value` most probably means, with the same first letter; None if none is
    similar."""
    import difflib  # slow to import; only errors need it

    typed = str(value)[:100].lower()
    known = {name.lower(): name for name in names if name[:1].lower() == typed[:1]}
    similar = difflib.get_close_matches(typed, known, n=1, cutoff=0.7)
    return known[similar[0]] if similar else None


def check_type(name: str, value: object, *types: type) -> None:
    """Raise `TypeError` unless an argument is of one of the types."""
    if not isinstance(value, types):
        wanted = " or ".join(each.__name__ for each in types)
        raise TypeError(f"{name} is a {type(value).__name__}; it must be a {wanted}")


def as_int(value: Any) -> int | None:
    """An integer, also one of numpy, as an int; None for anything else, and for True and False."""
    try:
        return None if isinstance(value, bool) else operator.index(value)
    except TypeError:
        return None


def check_number(name: str, value: Any, *, least: int = 0) -> int:
    """The value as an int; raises `LayoutError` if it is not an integer or less than `least`."""
    number = as_int(value)
    if number is None or number < least:
        raise LayoutError(f"{name} is {value!r}; it must be an integer >= {least}")
    return number


def check_that(fits: bool, name: str, value: object, limit: str) -> None:
    """Raise `LayoutError` with the `limit` of a value, unless it `fits`."""
    if not fits:
        raise LayoutError(f"{name} is {value!r}; it must be {limit}")


def check_choice(name: str, value: object, choices: Iterable[str]) -> None:
    """Raise `LayoutError` unless a value is one of the choices."""
    known = tuple(choices)
    if value not in known:
        raise LayoutError(f"{name} is {value!r}; it must be {one_of(known, value)}")


def check_choices(one: object, choices: Mapping[str, Iterable[str]], prefix: str = "") -> None:
    """Raise `LayoutError` if a field of those names is neither None nor one of its choices."""
    for name, known in choices.items():
        if getattr(one, name) is not None:
            check_choice(prefix + name, getattr(one, name), known)


def as_tuple(name: str, value: Any) -> tuple[Any, ...]:
    """A list or tuple as a tuple; raises `LayoutError` if it is neither."""
    check_that(isinstance(value, tuple | list), name, value, "a list")
    return tuple(value)


def check_seed(seed: Any) -> int:
    """The seed as an int; raises `LayoutError` unless it is an integer of 0 to 2^63 - 1, the limit of the core."""
    number = as_int(seed)
    if number is None or not 0 <= number < 2**63:
        raise LayoutError(f"seed is {seed!r:.80}; it must be an integer of 0 to 2^63 - 1")
    return number


_LONGEST = 2000  # characters of a message


def printable(text: str) -> str:
    """The text without codes that control a terminal: control characters are escaped, and a long text is cut in its
    middle."""
    shown = text if len(text) <= _LONGEST else f"{text[: _LONGEST // 2]} ... {text[-_LONGEST // 2 :]}"
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in shown)


class LidarDraftError(ValueError):
    """An input that lidardraft cannot use; the base of all its errors.

    Names and values in a message come from foreign files, so every message is `printable`.
    """

    def __init__(self, message: str) -> None:
        super().__init__(printable(message))


class LayoutError(LidarDraftError):
    """An invalid primitive, layout or pose."""


class UnknownNameError(LayoutError, KeyError):
    """A name or pattern without a match in a layout or scan; the message names the one that was probably meant."""

    __str__ = Exception.__str__  # a KeyError shows its message in quotes


class SensorError(LidarDraftError):
    """An invalid sensor description, or an image of another sensor."""


class FormatError(LidarDraftError):
    """A file that is broken, truncated or of another format than its name says."""


class TextError(LidarDraftError):
    """A sentence that was not understood at all."""


class LanguageModelError(LidarDraftError):
    """A language model that is unreachable, or that writes no scene."""


class ScriptError(LidarDraftError):
    """A script that is not a scene; the message names the line."""


class CheckpointError(LidarDraftError):
    """A weight file that is not from lidardraft, or does not fit."""


class TrainingError(LidarDraftError):
    """A training run that cannot start or go on."""


class MissingExtraError(LidarDraftError, ImportError):
    """A library of an extra is not installed; the message names the extra."""


# The libraries of the extras, each with the extras that install it; the first one is the smallest.
EXTRAS = {
    "torch": ("generate", "train", "image"), "transformers": ("image",), "huggingface_hub": ("image",),
    "laspy": ("export",), "av": ("video",), "ouster": ("ouster",),
    "rosbags": ("ros",), "viser": ("studio",), "shtab": ("completion",),
}  # fmt: skip


@contextmanager
def extra(preferred: str = "") -> Iterator[None]:
    """Raise `MissingExtraError` if the block imports a missing library of `EXTRAS`. It names an extra that installs the
    library: `preferred`, if that is one of them."""
    try:
        yield
    except ModuleNotFoundError as error:
        names = EXTRAS.get(str(error.name))
        if names is None:
            raise
        name = preferred if preferred in names else names[0]
        raise MissingExtraError(f"{error.name} is not installed; run: pip install 'lidardraft[{name}]'") from None
