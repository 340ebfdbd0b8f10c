"""Where something is from the ego: the meaning of words for places, lanes, distances and spacings."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

from lark import Token

from lidardraft.drafting.text.number_words import metres

Place = tuple[str, str]  # before or behind, and the side; "" where nothing is said

_PLACES_OF: dict[str, tuple[Place, ...]] = {
    "FRONT": (("front", ""),),
    "BEHIND": (("behind", ""),),
    "BESIDE": (("beside", ""),),
    "LEFT": (("", "left"),),
    "RIGHT": (("", "right"),),
    "SIDES": (("", "left"), ("", "right")),
    "EACH_SIDE": (("", "left"), ("", "right")),
    "ONE_SIDE": (("", "right"),),
    "OPPOSITE": (("", "left"),),
    "OVERTAKING": (("beside", ""),),
}
_RANGE_OF = {"NEAR": (8.0, 18.0), "FAR": (35.0, 60.0)}  # m
_LANE_OF = {
    "OWN_LANE": "own",
    "LEFT_LANE": "left",
    "MIDDLE_LANE": "middle",
    "RIGHT_LANE": "right",
    "OPPOSITE_LANE": "opposite",
    "EACH_LANE": "each",
    "OVERTAKING": "left",
}
DISTANCES = ("DISTANCE", "NEAR", "FAR")
SET_BACK = ("FROM_ROAD", "FROM_SIDEWALK")  # which no relation goes with
LANE_WORDS = tuple(word for word in _LANE_OF if word.endswith("_LANE"))
_HEADING_OF = {"OPPOSITE_LANE": "against", "OVERTAKING": "with", "FROM_SIDE": "across", "CROSSWALK": "across"}


@dataclass(frozen=True, slots=True)
class Position:
    """Where something is; the default says nothing. `beside_road` is on any side of it.

    `heading` is the one that goes with such a place; a number at `shared` places is that at all of them together.
    """

    places: tuple[Place, ...] = (("", ""),)
    distance: tuple[float, float] | None = None
    from_road: tuple[float, float] | None = None
    from_sidewalk: tuple[float, float] | None = None
    spacing: float | None = None
    sidewalk: bool = False
    on_road: bool = False
    beside_road: bool = False
    both_sides: bool = False
    shared: bool = False
    at_junction: bool = False
    lane: str | None = None
    heading: str | None = None

    @property
    def only_places(self) -> bool:
        """Whether it says nothing but places."""
        return self == Position(
            self.places, beside_road=self.beside_road, both_sides=self.both_sides, shared=self.shared
        )

    def agrees(self, other: Position) -> bool:
        """Whether something can be at both at once: no two places, distances or lanes of them differ."""
        pairs = [(_both(a, c), _both(b, d)) for a, b in self.places for c, d in other.places]
        said = (
            (self.distance, other.distance),
            (self.lane, other.lane),
            (self.spacing, other.spacing),
            (self.from_road or self.from_sidewalk, other.from_road or other.from_sidewalk),
            (self.sidewalk, other.on_road),
            (self.on_road, other.sidewalk),
        )
        return any(None not in pair for pair in pairs) and not any(a and b for a, b in said)

    def narrowed(self, other: Position) -> Position:
        """Both at once: "ahead" and "on the left" are ahead on the left. Contradictions are alternatives."""
        pairs = [(_both(a, c), _both(b, d)) for a, b in self.places for c, d in other.places]
        places = tuple((fore, side) for fore, side in pairs if fore is not None and side is not None)
        return Position(
            places=places or self.places + other.places,
            distance=other.distance or self.distance,
            from_road=other.from_road or self.from_road,
            from_sidewalk=other.from_sidewalk or self.from_sidewalk,
            spacing=other.spacing or self.spacing,
            sidewalk=self.sidewalk or other.sidewalk,
            on_road=self.on_road or other.on_road,
            beside_road=self.beside_road or other.beside_road,
            both_sides=self.both_sides or other.both_sides,
            shared=self.shared or other.shared,
            at_junction=self.at_junction or other.at_junction,
            lane=other.lane or self.lane,
            heading=other.heading or self.heading,
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
        if token.type in ("BESIDE", "NEAR") and beside_road:
            word = Position(beside_road=True)
        elif token.type == "FROM_ROAD":
            word = Position(from_road=metres(token))
        elif token.type == "FROM_SIDEWALK":
            word = Position(from_sidewalk=metres(token))
        elif token.type in ("DISTANCE", "DISTANCE_FROM"):
            word = Position(distance=metres(token))
        elif token.type == "SPACING":
            word = Position(spacing=metres(token)[0])
        elif token.type == "FROM_SIDE":
            word = Position(places=(("", "left" if "left" in token else "right"),), heading="across")
        else:
            word = Position(
                places=_PLACES_OF.get(token.type, (("", ""),)),
                distance=_RANGE_OF.get(token.type),
                sidewalk=token.type == "SIDEWALK",
                on_road=token.type == "ON_ROAD",
                beside_road=token.type == "ALONG",
                both_sides=token.type in ("SIDES", "EACH_SIDE"),
                shared=token.type == "SIDES",
                at_junction=token.type == "CORNER",
                lane=_LANE_OF.get(token.type),
                heading=_HEADING_OF.get(token.type),
            )
            if token.endswith("shoulder"):
                sided = any(other.type in ("LEFT", "RIGHT") for other in tokens)
                word = Position(places=(("", "" if sided else "right"),), heading="parked")
            elif token.type == "OVERTAKING" and any(other.type == "RIGHT" for other in tokens):
                word = dataclasses.replace(word, lane=None)
            elif token.type == "OVERTAKING" and any(other.type in ("FRONT", "BEHIND") for other in tokens):
                word = dataclasses.replace(word, places=(("", ""),))  # "overtaking cars behind us"
            elif token.type == "FRONT" and token.startswith("far "):
                word = dataclasses.replace(word, distance=_RANGE_OF["FAR"])
            elif token.endswith(" end of the road") or token.endswith(" end of the street"):
                word = dataclasses.replace(word, places=(("front", ""),))
        position = position.narrowed(word)
    return position


def _both(a: str, b: str) -> str | None:
    """Both where they agree or one says nothing; None where they contradict each other."""
    return a or b if not (a and b) or a == b else None
