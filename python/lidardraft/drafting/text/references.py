"""Which object a position is relative to, as in "behind the bus", "between two trucks" or "next to it"."""

from __future__ import annotations

from lark import Token

from lidardraft.drafting.solver.sentence_kinds import SENTENCE_KINDS
from lidardraft.drafting.text.mention import Mention, add_qualities
from lidardraft.drafting.text.number_words import count_of, exact_count
from lidardraft.drafting.text.sentence_chunks import KIND_OF, Chunk

_RELATION_OF = {
    "BEHIND": "behind",
    "FRONT": "in-front-of",
    "BESIDE": "beside",
    "BETWEEN": "between",
    "NEAR": "near",
    "DISTANCE_FROM": "near",
    "ALONG": "beside",
    "LEFT_OF": "left-of",
    "RIGHT_OF": "right-of",
    "OPPOSITE": "opposite",
    "OVERTAKING": "left-of",
    "FOLLOWED": "behind",
}
_EXPLICIT = (
    "DISTANCE_FROM",
    "BESIDE",
    "BETWEEN",
    "OPPOSITE",
    "LEFT_OF",
    "RIGHT_OF",
    "OVERTAKING",
    "RELATED",
    "FOLLOWED",
)
_RELATED_OF = dict.fromkeys(("against", "under", "underneath", "beneath", "past", "beyond"), "near")
_RELATED_OF["outside"] = "in-front-of"


def relation_of(token: Token) -> str | None:
    """The relation of SceneSpec that a word for a place means if an object follows it, None if it has none."""
    if token.type == "RELATED":
        return _RELATED_OF.get(token)
    return _RELATION_OF.get(token.type)


def refers(position: Chunk, named: Chunk, *, linked: bool) -> bool:
    """Whether a position is relative to what is named after it, rather than one that introduces it.

    `linked` says that the position begins a clause, as "behind" does in "a car ahead and behind a truck".
    """
    last = position.tokens[-1]
    if last.type in _EXPLICIT or (last.type in ("FRONT", "BEHIND") and last.endswith((" of", "before"))):
        return True
    if last.type == "FRONT" or (last.type == "ALONG" and not last.startswith("along")):
        return False
    definite = "THE" in named.types or is_one_of_several(named)
    return last.type in ("BEHIND", "NEAR", "ALONG") and (definite or not linked)


def mention_of(chunk: Chunk) -> Mention:
    """What a phrase with a noun asks for."""
    vehicle = chunk.head == "TRAFFIC"
    mention = Mention(
        "vehicle" if vehicle else KIND_OF[chunk.head], _traffic(chunk) if vehicle else count_of(chunk.tokens)
    )
    if vehicle and len(chunk.tokens) > 1 and chunk.tokens[-2].type in KIND_OF:
        mention.kind = KIND_OF[chunk.tokens[-2].type]
    add_qualities(mention, chunk.tokens)
    mention.name = next((str(token) for token in chunk.tokens if token.type == "NAME"), "")
    mention.spans.append(chunk.span)
    return mention


def known_mention(chunk: Chunk, mentions: list[Mention], subjects: list[Mention]) -> Mention | None:
    """The last mention that a phrase such as "the bus" or "bus A" can mean; None where it must be another object."""
    kind, name = mention_of(chunk).kind, mention_of(chunk).name
    if name:
        return next((one for one in mentions if (one.kind, one.name) == (kind, name)), None)
    if not (chunk.types & {"THE", "EACH"} or is_one_of_several(chunk)) or exact_count(chunk.tokens) is not None:
        return None
    for mention in reversed(mentions):
        if mention.count == 0 or mention.kind is None or any(mention is subject for subject in subjects):
            continue
        if mention.kind == kind or (kind == "vehicle" and SENTENCE_KINDS[mention.kind].is_vehicle):
            return mention
    return None


def meant_by(pronoun: str, mentions: list[Mention]) -> list[Mention]:
    """The last mention that a pronoun can mean: "them" are several, "it" is no number of them."""
    if pronoun in ("they", "them") or pronoun.startswith(("each", "every")):
        fitting = [mention for mention in mentions if mention.count != 1]
    else:
        fitting = [mention for mention in mentions if mention.count == 1 or not isinstance(mention.count, int)]
    return (fitting or mentions)[-1:]


def is_one_of_several(chunk: Chunk) -> bool:
    """Whether it names one of several, as "the first" or "the others"."""
    return bool(chunk.types & {"FIRST", "ANOTHER"}) and chunk.tokens[0].startswith("the ")


def _traffic(chunk: Chunk) -> int | str:
    if "NO" in chunk.types:
        return 0
    if chunk.types & {"QUIET", "FEW"}:
        return "few"
    return "many" if chunk.types & {"BUSY", "MANY", "DOZENS"} or chunk.tokens[-1] != "traffic" else "some"
