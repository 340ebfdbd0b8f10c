"""The text of a script is parsed to a syntax tree, if it is small enough, and the tree is evaluated value by value.
Python never runs any of it."""

from __future__ import annotations

import ast
import gc
import re
import warnings

from lidardraft.drafting.blender.script.builtin_functions import builtin_functions
from lidardraft.drafting.blender.script.definitions import Frame
from lidardraft.drafting.blender.script.limits import RaisedError, RefusalError, Script, ScriptLimits
from lidardraft.drafting.blender.script.modules import SCRIPT_FILE
from lidardraft.drafting.blender.script.statements import result_of
from lidardraft.drafting.blender.script.values import lone_surrogate

# Code, a comment, or a string; an open string ends with its line or the text. In any case the end is found in one pass.
_PART = re.compile(
    r"""(?P<code>[^"'#]+)|(?P<comment>\#[^\n]*)"""
    r"""|"{3}(?:[^"\\]+|\\.|"(?!""))*(?:"{3}|\\?\Z)|'{3}(?:[^'\\]+|\\.|'(?!''))*(?:'{3}|\\?\Z)"""
    r"""|"(?:[^"\\\n]+|\\.)*(?:"|$|\\?\Z)|'(?:[^'\\\n]+|\\.)*(?:'|$|\\?\Z)""",
    re.DOTALL | re.MULTILINE,
)
# Blocks between the fences of Markdown, whether the last one is closed or not.
_FENCED = re.compile(r"^[ \t]*(```|~~~)[^\n]*\n(.*?)(?:^[ \t]*\1[`~]*[ \t\r]*$|\Z)", re.MULTILINE | re.DOTALL)
_IS_FORMATTED = re.compile(r"[fF][rR]?\Z")  # the prefix of an f-string


def fenced(text: str) -> str | None:
    """The longest block between Markdown fences, at its line numbers; None if there is none."""
    block = max(_FENCED.finditer(text), key=lambda block: len(block[2]), default=None)
    return block and "\n" * text.count("\n", 0, block.start(2)) + block[2]


def parse(text: str, limits: ScriptLimits) -> ast.Module:
    """The syntax tree of a script. Raises `RefusalError` naming the line if it is too long or no Python."""
    if len(text) > limits.file:
        line = text.count("\n", 0, limits.file) + 1
        raise RefusalError(f"the script has {len(text)} characters; {limits.file} are read", line)
    if "\0" in text:
        raise RefusalError("a null byte", text.count("\n", 0, text.index("\0")) + 1)
    if (wrong := lone_surrogate(text)) is not None:
        raise RefusalError(f"half a character, {text[wrong]!r}", text.count("\n", 0, wrong) + 1)
    _check_code(text, limits)
    try:
        with warnings.catch_warnings():  # about escapes that later Pythons reject
            warnings.simplefilter("ignore")
            return ast.parse(text)
    except SyntaxError as error:
        raise RefusalError(f"not Python: {error.msg}", error.lineno or 1) from None
    except (RecursionError, MemoryError, ValueError, OverflowError):
        lines = text.split("\n")
        longest = max(range(len(lines)), key=lambda k: len(lines[k]))
        raise RefusalError("nested too deeply to be read", longest + 1) from None


def _check_code(text: str, limits: ScriptLimits) -> None:
    """Raises `RefusalError` for too much code for a syntax tree of bounded size; a string or comment counts as 1."""
    size = 0
    for part in _PART.finditer(text):
        is_code = part["code"] is not None or (
            part["comment"] is None and _IS_FORMATTED.search(text, max(part.start() - 2, 0), part.start())
        )
        size += part.end() - part.start() if is_code else 1
        if size > limits.code:
            line = text.count("\n", 0, part.end() - (size - limits.code)) + 1
            raise RefusalError(f'more than {limits.code} characters of code; put data into texts, as "1 2 3"', line)


def read(text: str, script: Script) -> None:
    """Evaluate a whole script. Raises `RefusalError` naming an unsupported line, or one beyond the limits."""
    collecting = gc.isenabled()
    gc.disable()  # it would scan the tree again and again; memory is bounded anyway
    try:
        try:
            tree = parse(text, script.limits)
        except RefusalError:
            if (inside := fenced(text)) is None:
                raise
            tree = parse(inside, script.limits)
            script.note("text outside the longest block between Markdown fences is ignored")
        builtins = Frame(None, builtin_functions(script), script)
        result_of(tree.body, Frame(builtins, {"__name__": "__main__", "__file__": SCRIPT_FILE}, script))
    except RaisedError as error:
        if error.name != "SystemExit" or error.said not in ("", "0", "None"):
            raise error.at(script.line) from None
    except RefusalError as refusal:
        raise refusal.at(script.line) from None
    except RecursionError:
        raise RefusalError("nested too deeply to be read", script.line) from None
    except MemoryError:
        raise RefusalError("too large to be read", script.line) from None
    finally:
        if collecting:
            gc.enable()
