"""Where something is: the meaning of words for places, distances and spacings."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

from lark import Token

from lidardraft.drafting.number_words import metres

Place = tuple[str, str]  # before or behind, and the side; "" where nothing is said

_PLACES_OF: dict[str, tuple[Place, ...]] = {
    "FRONT": (("front", ""),),
    "BEHIND": (("behind", ""),),
    "BESIDE": (("beside", ""),),
    "LEFT": (("", "left"),),
    "RIGHT": (("", "right"),),
    "SIDES": (("", "left"), ("", "right")),
}
_RANGE_OF = {"NEAR": (8.0, 18.0), "FAR": (35.0, 60.0)}  # m


@dataclass(frozen=True, slots=True)
class Position:
    """Where something is; the default says nothing. `beside_road` is on any side of it."""

    places: tuple[Place, ...] = (("", ""),)
    distance: tuple[float, float] | None = None
    spacing: float | None = None
    sidewalk: bool = False
    beside_road: bool = False
    both_sides: bool = False

    def narrowed(self, other: Position) -> Position:
        """Both at once: "ahead" and "on the left" are ahead on the left. Contradictions are alternatives."""
        pairs = [(_both(a, c), _both(b, d)) for a, b in self.places for c, d in other.places]
        places = tuple((fore, side) for fore, side in pairs if fore is not None and side is not None)
        return Position(
            places=places or self.places + other.places,
            distance=other.distance or self.distance,
            spacing=other.spacing or self.spacing,
            sidewalk=self.sidewalk or other.sidewalk,
            beside_road=self.beside_road or other.beside_road,
            both_sides=self.both_sides or other.both_sides,
        )

    def or_at(self, other: Position) -> Position:
        """One and the other: "in front" and "behind"."""
        return dataclasses.replace(self, places=self.places + other.places)

    def without(self, other: Position) -> Position:
        """Only where the other is not."""
        places = tuple(place for place in self.places if place not in other.places)
        return dataclasses.replace(self, places=places or self.places)


def read_position(tokens: list[Token], *, beside_road: bool = False) -> Position:
    """The position that a run of words describes; `beside_road` if a road follows them, as in "next to the road"."""
    position = Position()
    for token in tokens:
        if token.type == "BESIDE" and beside_road:
            word = Position(beside_road=True)
        elif token.type == "DISTANCE":
            word = Position(distance=metres(token))
        elif token.type == "SPACING":
            word = Position(spacing=metres(token)[0])
        else:
            word = Position(
                places=_PLACES_OF.get(token.type, (("", ""),)),
                distance=_RANGE_OF.get(token.type),
                sidewalk=token.type == "SIDEWALK",
                beside_road=token.type == "ALONG",
                both_sides=token.type == "SIDES",
            )
        position = position.narrowed(word)
    return position


def _both(a: str, b: str) -> str | None:
    """Both where they agree or one says nothing; None where they contradict each other."""
    return a or b if not (a and b) or a == b else None
