"""The text of a script becomes a syntax tree, if it is small enough to be parsed."""

from __future__ import annotations

import ast
import re
import warnings

from lidardraft.drafting.script.limits import Limits, RefusalError

# A comment, or a string with its prefix; one that does not end goes on to the end of its line or of the text.
_COMMENT_OR_STRING = re.compile(
    r"""\#[^\n]*|(?:\b[A-Za-z]{1,2})?(?:"{3}(?:[^\\]|\\.)*?(?:"{3}|\Z)|'{3}(?:[^\\]|\\.)*?(?:'{3}|\Z)"""
    r"""|"(?:[^"\\\n]|\\.)*(?:"|$|\Z)|'(?:[^'\\\n]|\\.)*(?:'|$|\Z))""",
    re.DOTALL | re.MULTILINE,
)


# A number, a name, or one character of another kind.
_SURROGATE = re.compile("[\ud800-\udfff]")
_TOKEN = re.compile(r"\w+(?:\.\w+)?|[^\s\w]")


def parse(text: str, limits: Limits) -> tuple[ast.Module, int]:
    """The syntax tree of a script and its number of tokens: names, numbers and signs outside strings.

    Raises `RefusalError` naming the line where it is too long or no Python.
    """
    if len(text) > limits.file:
        line = text.count("\n", 0, limits.file) + 1
        raise RefusalError(f"the script has {len(text)} characters; {limits.file} are read", line)
    if "\0" in text:
        raise RefusalError("a null byte", text.count("\n", 0, text.index("\0")) + 1)
    if (wrong := lone_surrogate(text)) is not None:
        raise RefusalError(f"half a character, {text[wrong]!r}", text.count("\n", 0, wrong) + 1)
    count = _count_tokens(text, limits)
    try:
        with warnings.catch_warnings():  # of escapes that will be wrong in a later Python
            warnings.simplefilter("ignore")
            return ast.parse(text), count
    except SyntaxError as error:
        raise RefusalError(f"not Python: {error.msg}", error.lineno or 1) from None
    except (RecursionError, MemoryError, ValueError, OverflowError):
        lines = text.split("\n")
        longest = max(range(len(lines)), key=lambda k: len(lines[k]))
        raise RefusalError("nested too deeply to be read", longest + 1) from None


def lone_surrogate(text: str) -> int | None:
    """The place of the first half of a character that stands alone, which no file in UTF-8 can hold."""
    match = None if text.isascii() else _SURROGATE.search(text)
    return match.start() if match else None


def _count_tokens(text: str, limits: Limits) -> int:
    code = _COMMENT_OR_STRING.sub(_code_of, text)
    count, most = 0, limits.tokens
    for match in _TOKEN.finditer(code):
        count += 1
        if count > most:
            line = code.count("\n", 0, match.start()) + 1
            raise RefusalError(f'more than {most} names, numbers and signs; put data into texts, as "1 2 3"', line)
    return count


def _code_of(match: re.Match[str]) -> str:
    """What counts as code of a comment or a string: its line ends, and all of an f-string, which holds expressions."""
    found = match.group()
    prefix = found[: min(found.find(quote) % (len(found) + 1) for quote in "\"'#")].lower()
    return found if "f" in prefix else '"' + "\n" * found.count("\n")
