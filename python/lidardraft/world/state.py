"""The state of a world at one moment: a frozen value, and its file."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lidardraft.errors import FormatError, check_number, check_seed
from lidardraft.files import JsonFile
from lidardraft.json_fields import check_object, parse_document, read_as, write_as
from lidardraft.scene.layout import Layout
from lidardraft.scene.pose import Place
from lidardraft.scene.scenario import Motion, Scenario, Track
from lidardraft.simulation.sweeps import Spot

SCHEMA = "lidardraft.world/1"
EGO_NAME = "ego"
_FIELDS = ("seed", "origin", "time", "steps", "layouts", "things", "scenario", "collisions")


@dataclass(frozen=True, slots=True)
class Drive:
    """A driver on the way of number `way`: `along` it, `left` of its middle [m], `yaw` against it [rad] and place along
    it at its `start`, and `speed` [m/s]. `beside` is whether it has been beside the vehicle that it overtakes,
    `returns` whether it moves to the middle, `waited` how long it has stood [s], `drift` its way to the left for each
    metre along."""

    way: int
    along: float
    left: float
    yaw: float
    start: float
    speed: float
    beside: bool = False
    returns: bool = False
    waited: float = 0.0
    drift: float = 0.0


@dataclass(frozen=True, slots=True)
class Actor:
    """One thing at one moment: the number of the layout that it came with, the `spot` x, y, z [m] and yaw [rad] of its
    middle, and its next motion.

    `past` has rows of time, x, y, z, yaw up to now; it is empty if the thing has not moved in the last sweep. With the
    `motion` None it stands. `drive` is that of a driver in a lane, `goal` its x, y and yaw at the end of the next step.
    """

    batch: int
    spot: Spot
    past: tuple[tuple[float, ...], ...] = ()
    motion: Motion | None = None
    drive: Drive | None = None
    goal: Place | None = None

    def track(self) -> Track:
        """Its past; without one, it has always been in its spot."""
        rows = np.array(self.past or ((0.0, *self.spot),))
        return Track(rows[:, 0], rows[:, 1:])

    def rate(self) -> Spot:
        """Its current velocity [m/s] and yaw rate [rad/s]."""
        if not self.past:
            return 0.0, 0.0, 0.0, 0.0
        (begin, *before), (end, *now) = self.past[-2:]
        x, y, z, turn = ((b - a) / (end - begin) for a, b in zip(before, now, strict=True))
        return x, y, z, turn


@dataclass(frozen=True, slots=True)
class Collision:
    """The names of two things that began to overlap at a time [s]."""

    time: float
    one: str
    other: str


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class WorldState(JsonFile):
    """All that the scans of a `World` depend on, except its sensor and weather.

    `layouts` are the layout and all additions, as given; `actors` are the things left of them, with their places.
    `steps` counts the calls of `World.step`, for the noise of scans; `origin` [m] is that of the compiled scene.
    """

    seed: int
    origin: tuple[float, float, float]
    time: float
    steps: int
    layouts: Mapping[int, Layout]
    actors: Mapping[str, Actor]
    collisions: tuple[Collision, ...] = ()

    def but(self, actors: Mapping[str, Actor | None], **fields: Any) -> WorldState:
        """The state with some actors replaced, or removed if None. Layouts without any actor left are removed too."""
        now = {name: actor for name, actor in {**self.actors, **actors}.items() if actor is not None}
        layouts = fields.pop("layouts", self.layouts)
        if None in actors.values():
            used = {0, *(actor.batch for actor in now.values())}
            layouts = {number: layout for number, layout in layouts.items() if number in used}
        return replace(self, actors=now, layouts=layouts, **fields)

    def to_json(self) -> str:
        """The state as JSON text: layouts, a scenario of all motions, and the places of things."""
        motions = {name: actor.motion for name, actor in self.actors.items() if actor.motion is not None}
        things = {name: write_as(replace(actor, motion=None)) for name, actor in self.actors.items()}
        document = {
            "schema": SCHEMA,
            "seed": self.seed,
            "origin": self.origin,
            "time": self.time,
            "steps": self.steps,
            "layouts": {number: json.loads(layout.to_json()) for number, layout in self.layouts.items()},
            "things": things,
            "scenario": json.loads(Scenario(None, motions).to_json()),
            "collisions": write_as(self.collisions),
        }
        return json.dumps(document, allow_nan=False)

    @classmethod
    def from_json(cls, text: str) -> WorldState:
        """Raises `FormatError` if the text is not the JSON of a state, `LayoutError` on an invalid value."""
        document = parse_document(text, SCHEMA, _FIELDS, ())
        motions = Scenario.from_json(json.dumps(document["scenario"])).actors
        layouts = {
            check_number("layouts", int(number) if number.isdecimal() else number): Layout.from_json(json.dumps(rows))
            for number, rows in check_object(document["layouts"]).items()
        }
        actors = {
            name: replace(read_as(Actor, row, name), motion=motions.get(name))
            for name, row in check_object(document["things"]).items()
        }
        if EGO_NAME not in actors or 0 not in layouts:
            raise FormatError("things has no 'ego', or layouts no '0'; both are needed")
        return cls(
            seed=check_seed(document["seed"]),
            origin=read_as(tuple[float, float, float], document["origin"], "origin"),
            time=read_as(float, document["time"], "time"),
            steps=check_number("steps", document["steps"]),
            layouts=layouts,
            actors=actors,
            collisions=read_as(tuple[Collision, ...], document["collisions"], "collisions"),
        )
