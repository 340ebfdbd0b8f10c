"""Positions relative to the ego: places, lanes, distances and spacings, and their combinations."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

Place = tuple[str, str]  # before or behind, and the side; "" if open

NOWHERE, FRONT, BEHIND, BESIDE = ("", ""), ("front", ""), ("behind", ""), ("beside", "")
LEFT, RIGHT = ("", "left"), ("", "right")


@dataclass(frozen=True, slots=True)
class Position:
    """A position; the default is open. `beside_road` is on any side of it.

    `heading` is the one implied by such a place; a number at `shared` places counts all of them together.
    """

    places: tuple[Place, ...] = (NOWHERE,)
    distance: tuple[float, float] | None = None
    from_road: tuple[float, float] | None = None
    from_sidewalk: tuple[float, float] | None = None
    spacing: float | None = None
    sidewalk: bool = False
    on_road: bool = False
    beside_road: bool = False
    median: bool = False
    both_sides: bool = False
    shared: bool = False
    at_junction: bool = False
    lane: str | None = None
    heading: str | None = None

    @property
    def only_places(self) -> bool:
        """Whether it has only places."""
        return self == Position(
            self.places, beside_road=self.beside_road, both_sides=self.both_sides, shared=self.shared
        )

    @property
    def sides(self) -> list[str]:
        """The sides that it names."""
        return [side for _, side in self.places if side]

    def agrees(self, other: Position) -> bool:
        """Whether an object can be at both at once: no places, distances or lanes of them differ."""
        said = (
            (self.distance, other.distance),
            (self.lane, other.lane),
            (self.spacing, other.spacing),
            (self.from_road or self.from_sidewalk, other.from_road or other.from_sidewalk),
            (self.sidewalk, other.on_road),
            (self.on_road, other.sidewalk),
        )
        return bool(self._common(other)) and not any(a and b for a, b in said)

    def narrowed(self, other: Position) -> Position:
        """Both at once: "ahead" and "on the left" are ahead on the left. Contradictions are alternatives."""
        said = {name: getattr(other, name) or getattr(self, name) for name in _FIELDS}
        places = self._common(other) or tuple(dict.fromkeys(self.places + other.places))
        return Position(**said | {"places": places})

    def _common(self, other: Position) -> tuple[Place, ...]:
        """The places of both: "ahead" and "on the left" have "ahead on the left". Traffic from a place has left it."""
        pairs = [(a or c, b or d) for a, b in self.places for c, d in other.places if _agree(a, c) and _agree(b, d)]
        left, other_left = (str(at.heading).startswith(("across-", "with")) for at in (self, other))
        if not pairs and left != other_left:
            return other.places if left else self.places
        return tuple(dict.fromkeys(pairs))

    def or_at(self, other: Position) -> Position:
        """Either position: "in front" and "behind"."""
        return dataclasses.replace(self, places=self.places + other.places)

    def without(self, other: Position) -> Position:
        """This position without the places of the other."""
        places = tuple(place for place in self.places if place not in other.places)
        return dataclasses.replace(self, places=places or self.places)


ANYWHERE = Position()
_FIELDS = tuple(one.name for one in dataclasses.fields(Position))


def place_named(name: str) -> Place:
    """The place of a name such as "front", "left" or "front-left"."""
    fore, _, side = name.partition("-")
    return ("", fore) if fore in ("left", "right") else (fore, side)


def _agree(one: str, other: str) -> bool:
    return one == other or not (one and other)
