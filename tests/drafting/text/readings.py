"""What sentences are read as, each of them once in a run: most tests of sentences go through the same 600."""

from functools import cache

from lidardraft.drafting.text.explanation import Explanation
from lidardraft.drafting.text.layout import explain
from lidardraft.errors import LayoutError, TextError


@cache
def reading(text: str) -> Explanation | None:
    """The explanation of a sentence, None where it is refused."""
    try:
        return explain(text)
    except (TextError, LayoutError):
        return None
