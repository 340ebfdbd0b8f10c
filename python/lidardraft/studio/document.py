"""What a visitor has made: states of a world to go back and forth in, and how it is looked at; values all."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from lidardraft.scene.sensor import Sensor
from lidardraft.scene.weather import Weather
from lidardraft.world.state import WorldState

MOST_STATES = 2000  # that are kept to go back to: a state shares all but a table of places with those before it
MOST_PLAYED = 1200  # states of the time line: two minutes


@dataclass(frozen=True, slots=True)
class Document:
    """The states that edits have led through, of which that at the `cursor` is now, the states that have been `played`,
    of which that at `position` is shown, and the sensors and the weather that scan them.

    None as `weather` is that of the layout.
    """

    states: tuple[WorldState, ...]
    sensors: tuple[Sensor, ...]
    weather: Weather | None = None
    cursor: int = 0
    played: tuple[WorldState, ...] = ()
    position: int = 0

    @property
    def state(self) -> WorldState:
        """That of now."""
        return self.states[self.cursor]

    def edited(self, state: WorldState) -> Document:
        """With another state after that of now, in place of those that were undone."""
        if state is self.state:
            return self
        states = (*self.states[: self.cursor + 1], state)[-MOST_STATES:]
        played = (*self.played[: self.position], state) if self.played else ()
        return replace(self, states=states, cursor=len(states) - 1, played=played)

    def moved(self, by: int) -> Document:
        """With the state of `by` edits later as that of now, or the first or the last one."""
        cursor = min(max(self.cursor + by, 0), len(self.states) - 1)
        return replace(self, cursor=cursor, played=(), position=0)

    def stepped(self, before: WorldState, after: WorldState) -> Document:
        """With one more state played, in place of those that came after `before`."""
        played = (*(self.played[: self.position] if self.played else ()), before, after)[-MOST_PLAYED:]
        return replace(self, played=played, position=len(played) - 1)

    def at(self, position: int) -> Document:
        """With the played state of that number shown, or the first or the last one."""
        return replace(self, position=min(max(position, 0), len(self.played) - 1))


COLOURS = ("objects and height", "height", "class", "intensity", "range", "object", "ring")


@dataclass(frozen=True, slots=True)
class Look:
    """What is shown, and in which colours; `hidden` are ids of classes."""

    colour: str = COLOURS[0]
    points: bool = True
    boxes: bool = True
    labels: bool = False
    layout: bool = False
    recorded: bool = True
    hidden: frozenset[int] = field(default_factory=frozenset)
