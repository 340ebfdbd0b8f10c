"""What is meant by the text that a language model writes: without its thoughts, and out of its code fences."""

from __future__ import annotations

import json

_FENCES = ("```", "~~~")


def json_of(reply: str) -> str:
    """The JSON object at the first brace; where there is none, the text from there to the last brace, or all of it."""
    text = _answer_of(reply)
    start, end = text.find("{"), text.rfind("}")
    if not 0 <= start < end:
        return text
    try:
        return text[start : json.JSONDecoder().raw_decode(text, start)[1]]
    except (ValueError, RecursionError):  # whose reader says what is wrong with it
        return text[start : end + 1]


def code_of(reply: str) -> str:
    """The longest fenced block, whether its fence is closed or not, or all of the text where there is none.

    It ends in a line break, so it is never taken for the path of a file.
    """
    text = _answer_of(reply)
    return max(_fenced(text), key=len, default=text).strip("\n") + "\n"


def _answer_of(reply: str) -> str:
    """What comes after the thoughts that models write down where a server does not take them out."""
    return reply.rpartition("</think>")[2].strip()


def _fenced(text: str) -> list[str]:
    blocks: list[list[str]] = []
    fence = ""
    for line in text.split("\n"):
        bare = line.strip()
        if fence and bare.startswith(fence) and not bare.strip(fence[0]):
            fence = ""
        elif fence:
            blocks[-1].append(line)
        elif bare.startswith(_FENCES):
            fence = bare[:3]
            blocks.append([])
    return ["\n".join(block) for block in blocks]
