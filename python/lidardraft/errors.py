"""The errors that bad input gets. Each message names the thing, the value and the limit."""

from collections.abc import Iterable


def one_of(names: Iterable[str], value: object) -> str:
    """What a message says of a `value` that is none of `names`: all of them, and the one that was probably meant."""
    import difflib  # only what has gone wrong waits for it

    known = list(names)
    similar = difflib.get_close_matches(str(value).lower(), known, n=1)
    return f"one of {', '.join(known) or 'none'}" + "".join(f"; did you mean {name!r}?" for name in similar)


class LidarDraftError(ValueError):
    """Something given to lidardraft cannot be used; the base of the family."""


class LayoutError(LidarDraftError):
    """A primitive, a layout or a pose that cannot be."""


class SensorError(LidarDraftError):
    """A sensor description that cannot be, or an image of another sensor."""


class FormatError(LidarDraftError):
    """A file that is broken, truncated or not what its name says."""


class TextError(LidarDraftError):
    """A sentence of which nothing was understood."""


class CheckpointError(LidarDraftError):
    """A weight file that is not ours or does not fit."""


class TrainingError(LidarDraftError):
    """A training run that cannot start or go on."""
