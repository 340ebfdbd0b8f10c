"""What adjectives and verbs say of objects: how they stand or move, and how large they are."""

from __future__ import annotations

from lark import Token

from lidardraft.drafting.text.mention import Mention
from lidardraft.drafting.text.number_words import metres

_HEADING_OF = {"PARKED": "parked", "MOVING": "with", "CROSSING": "across", "ONCOMING": "against"}
# What usual lengths, widths and heights are multiplied by; estimates of ours.
_SCALE_OF = {
    "LARGE": (1.25, 1.15, 1.25),
    "SMALL": (0.8, 0.85, 0.8),
    "TALL": (1.0, 1.0, 1.6),
    "LOW": (1.0, 1.0, 0.6),
    "LONG": (1.5, 1.0, 1.0),
    "SHORT": (0.7, 1.0, 0.7),
    "WIDE": (1.0, 1.3, 1.0),
    "NARROW": (1.0, 0.75, 1.0),
}
_JAM = "stuck in"  # a queue in all lanes
_TOWERS, _TOWER = ("sky", "high", "tower"), (1.0, 1.0, 2.5)
_AXIS_OF = {"long": 0, "length": 0, "wide": 1, "deep": 1, "thick": 1, "width": 1, "tall": 2, "high": 2, "height": 2}
SCALES = tuple(_SCALE_OF)
SIZES = (*SCALES, "SIZE", "LENGTH", "HEIGHT")


def heading_of(tokens: list[Token]) -> str | None:
    """How objects stand or move relative to the ego, None where nothing is said of it."""
    for token in tokens:
        if token.type == "CROSSING" and {"left", "right"} <= set(token.split()):
            return "across-right" if token.rindex("right") > token.rindex("left") else "across-left"
    found = [_HEADING_OF[token.type] for token in tokens if token.type in _HEADING_OF]
    found += ["with" for token in tokens if token.type == "QUEUEING" and token.startswith(_JAM)]
    return next((heading for heading in found if heading != "with"), found[0] if found else None)


def add_qualities(mention: Mention, tokens: list[Token]) -> None:
    """Note what some words say of a mention."""
    mention.heading = heading_of(tokens) or mention.heading
    mention.in_queue = mention.in_queue or any(
        (token.type == "QUEUEING" and not token.startswith(_JAM))
        or (token.type == "MANY" and {"queue", "line"} & set(token.split()))
        for token in tokens
    )
    if mention.kind == "person" and any(token == "cycling" for token in tokens):
        mention.kind = "bicycle"
    mention.ridden = mention.ridden or tokens[-1].rstrip("s").endswith(("ist", "rider"))
    for token in tokens:
        tower = token.type == "BUILDING" and token.startswith(_TOWERS)
        scale = _TOWER if tower else _SCALE_OF.get(token.type)
        if scale is not None:
            mention.scale = [a * b for a, b in zip(mention.scale, scale, strict=True)]
        elif token.type in ("LENGTH", "HEIGHT"):
            mention.size[0 if token.type == "LENGTH" else 2] = metres(token)[1]
        elif token.type == "SIZE":
            mention.size[_AXIS_OF[token.split()[-1]]] = metres(token)[1]
