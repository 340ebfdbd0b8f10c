"""A visitor's work: the states of a world for undo and redo, and the settings of the view; all of them values."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from lidardraft.scene.sensor import Sensor
from lidardraft.scene.weather import Weather
from lidardraft.world.state import WorldState

MOST_STATES = 2000  # kept for undo: a state shares all but a table of places with earlier ones
MOST_PLAYED = 1200  # states of the time line: two minutes


@dataclass(frozen=True, slots=True)
class Document:
    """The states after each edit, with the current one at the `cursor`; the states that were `played`, with the shown
    one at `position`; and the sensors and the weather of scans.

    `weather` None is that of the layout.
    """

    states: tuple[WorldState, ...]
    sensors: tuple[Sensor, ...]
    weather: Weather | None = None
    cursor: int = 0
    played: tuple[WorldState, ...] = ()
    position: int = 0

    @property
    def state(self) -> WorldState:
        """The current state."""
        return self.states[self.cursor]

    def edited(self, state: WorldState) -> Document:
        """The document with another state after the current one, in place of those that were undone."""
        if state is self.state:
            return self
        states = (*self.states[: self.cursor + 1], state)[-MOST_STATES:]
        played = (*self.played[: self.position], state) if self.played else ()
        return replace(self, states=states, cursor=len(states) - 1, played=played)

    def moved(self, by: int) -> Document:
        """The document with the state `by` edits later as the current one, or the first or the last one."""
        cursor = min(max(self.cursor + by, 0), len(self.states) - 1)
        return replace(self, cursor=cursor, played=(), position=0)

    def stepped(self, before: WorldState, after: WorldState) -> Document:
        """The document with one more played state, in place of those after `before`."""
        played = (*(self.played[: self.position] if self.played else ()), before, after)[-MOST_PLAYED:]
        return replace(self, played=played, position=len(played) - 1)

    def at(self, position: int) -> Document:
        """The document with the played state of that number shown, or the first or the last one."""
        return replace(self, position=min(max(position, 0), len(self.played) - 1))


COLOURS = ("objects and height", "height", "class", "intensity", "range", "object", "ring")


@dataclass(frozen=True, slots=True)
class Look:
    """What the view shows, and in which colours; `hidden` are ids of classes."""

    colour: str = COLOURS[0]
    points: bool = True
    boxes: bool = True
    labels: bool = False
    layout: bool = False
    recorded: bool = True
    hidden: frozenset[int] = field(default_factory=frozenset)
