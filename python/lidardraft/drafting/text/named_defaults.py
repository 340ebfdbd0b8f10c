"""Properties implied by the name of an object: terraced houses have no gaps between them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from lidardraft.drafting.solver.scene_spec import CLOSED
from lidardraft.drafting.text.mentions import Mention
from lidardraft.drafting.text.tree import NO_SCALE

_TERRACES = ("terrace", "row h")  # terraced houses, terrace houses and cottages, row houses and homes
_AGAINST_NOISE = ("noise", "sound", "acoustic")
_PUMPS = ("pump", "dispenser")
# Estimates [m].
_NOISE_HEIGHT, _NOISE_LENGTH = 4.0, 60.0  # most are 3 to 5 m high
_PUMP_SIZE = (0.5, 0.9, 1.7)


def as_named(mention: Mention, mentions: Sequence[Mention]) -> Mention:
    """A mention with the size and the place that its noun implies and the sentence leaves open."""
    at, noun = mention.at, mention.noun
    free = mention.relation is None and at.distance is None and at.spacing is None
    if noun.startswith(_TERRACES) and free and mention.count != 1:
        return replace(mention, at=replace(at, spacing=CLOSED))
    if noun.startswith(_AGAINST_NOISE) and mention.record.follows_road:
        (length, width, height), (longer, _, higher) = mention.size, mention.scale
        length = _NOISE_LENGTH if length is None and free and mention.count == 1 and longer >= 1.0 else length
        height = _NOISE_HEIGHT if height is None and higher == 1.0 else height
        return replace(mention, size=(length, width, height))
    if noun.endswith(_PUMPS) and mention.kind == "pole":  # not of concrete
        of_building = mention.relation == "near" and all(
            mentions[one].kind is not None and mentions[one].record.family == "buildings" for one in mention.references
        )
        relation = "in-front-of" if of_building else mention.relation
        return replace(mention, size=_PUMP_SIZE, scale=NO_SCALE, relation=relation)
    return mention
