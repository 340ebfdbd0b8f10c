"""Scenarios: the motions of the ego vehicle and of objects, as values and as JSON; and their tracks.

Objects without a motion in the scenario move by their kind (`simulation.motion`).
"""

from __future__ import annotations

import dataclasses
import itertools
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from typing import Any

import numpy as np

from lidardraft.errors import FormatError, LayoutError, did_you_mean
from lidardraft.files import JsonFile, named
from lidardraft.json_fields import are_numbers, check_fields, check_object, is_number, parse_document
from lidardraft.scene.pose import finite_array

SCHEMA = "lidardraft.scenario/1"
FASTEST = 150.0  # m/s
_LONGEST = 1e5  # s
_FURTHEST = 1e5  # m


@dataclass(frozen=True, slots=True)
class Straight:
    """Ahead along its heading at a constant `speed` [m/s]; backwards if it is negative, parked if it is 0."""

    speed: float

    def __post_init__(self) -> None:
        _check("speed", self.speed, -FASTEST, FASTEST, "m/s")


@dataclass(frozen=True, slots=True)
class AlongLane:
    """Along the lane under it, at `speed` [m/s] while the way is free; None is the speed of the road and the kind.

    `later` are changes of the speed, (time [s], speed) each. It keeps `gap` [m] plus the way of `headway` [s] to the
    vehicle ahead, by the Intelligent Driver Model (Treiber, Hennecke and Helbing, Physical Review E 62, 2000). With
    `gives_way` it stops before junctions as lights and signs demand. At the junction it may `turn` "left" or "right".
    If it `overtakes`, it drives beside its lane, and returns to it after it has passed another. It stops for some
    seconds beside the place `halt` x, y [m], as a bus at its stop. It stands until the time `start` [s].
    """

    speed: float | None = None
    later: tuple[tuple[float, float], ...] = ()
    gap: float = 2.0
    headway: float = 1.5
    turn: str | None = None
    overtakes: bool = False
    gives_way: bool = True
    halt: tuple[float, float] | None = None
    start: float = 0.0

    def __post_init__(self) -> None:
        if self.speed is not None:
            _check("speed", self.speed, 0.0, FASTEST, "m/s")
        object.__setattr__(self, "later", _rows("later", self.later, (2,)))
        for _, speed in self.later:
            _check("later: speed", speed, 0.0, FASTEST, "m/s")
        _check("gap", self.gap, 0.0, _FURTHEST, "m")
        _check("start", self.start, 0.0, _LONGEST, "s")
        _check("headway", self.headway, 0.0, 60.0, "s")
        if self.turn not in (None, "left", "right"):
            raise LayoutError(f"turn is {self.turn!r:.80}; it must be left or right")
        if self.halt is not None:
            object.__setattr__(self, "halt", _place("halt", self.halt))
        for name in ("overtakes", "gives_way"):
            if type(getattr(self, name)) is not bool:
                raise LayoutError(f"{name} is {getattr(self, name)!r:.80}; it must be true or false")


@dataclass(frozen=True, slots=True)
class Walk:
    """Straight to the place `to`, x and y [m] of the layout, at `speed` [m/s] from the time `start` [s] on. `crosses`
    are stretches of road, each from and to a distance [m] before that place; it waits before each until it can
    cross."""

    to: tuple[float, float]
    speed: float = 1.4
    start: float = 0.0
    crosses: tuple[tuple[float, float], ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "to", _place("to", self.to))
        _check("speed", self.speed, 0.01, FASTEST, "m/s")
        _check("start", self.start, 0.0, _LONGEST, "s")
        if not isinstance(self.crosses, list | tuple) or not all(are_numbers(span, 2) for span in self.crosses):
            raise LayoutError(f"crosses is {self.crosses!r:.80}; it must be rows of 2 numbers")
        object.__setattr__(self, "crosses", tuple((float(low), float(high)) for low, high in self.crosses))


@dataclass(frozen=True, slots=True)
class Waypoints:
    """Through `points`, rows of time [s], x, y [m] and, in all rows or in none, yaw [rad]; without yaw it faces its
    direction of travel. The path is smooth (PCHIP); it stands still before the first point and after the last."""

    points: tuple[tuple[float, ...], ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "points", _rows("waypoints", self.points, (3, 4)))
        if not self.points:
            raise LayoutError("waypoints is empty; it must have one point at least")


Motion = Straight | AlongLane | Walk | Waypoints
_KINDS: dict[str, type[Motion]] = {"straight": Straight, "lane": AlongLane, "walk": Walk, "waypoints": Waypoints}


@dataclass(frozen=True, slots=True)
class Scenario(JsonFile):
    """The motions of the ego vehicle and of objects, by names or by patterns of them (`around/*`). A name takes
    precedence over patterns, then the first match counts. Objects without a match move by their kind."""

    ego: Motion | None = None
    actors: Mapping[str, Motion] = field(default_factory=dict)

    def of(self, name: str) -> Motion | None:
        """The motion of an object; None if it has none of its own."""
        if name in self.actors:
            return self.actors[name]
        return next((motion for pattern, motion in self.actors.items() if fnmatchcase(name, pattern)), None)

    def check_names(self, names: Sequence[str]) -> None:
        """Raises `LayoutError` on a name or pattern that matches no object of the layout; "*" always passes."""
        for pattern in self.actors:
            if pattern not in names and not any(fnmatchcase(name, pattern) for name in [*names, "*"]):
                known = did_you_mean(names, pattern) or f"; it has {', '.join(names[:8]) or 'none'}"
                raise LayoutError(f"the layout has no object {pattern!r}{known}")

    def to_json(self) -> str:
        """The scenario as JSON text, an actor a line; `from_json` gives an equal scenario."""
        ego = "" if self.ego is None else f', "ego": {_written(self.ego)}'
        rows = (f"{json.dumps(name)}: {_written(motion)}" for name, motion in self.actors.items())
        return f'{{"schema": "{SCHEMA}"{ego}, "actors": {{\n  ' + ",\n  ".join(rows) + "\n}}\n"

    @classmethod
    def from_json(cls, text: str) -> Scenario:
        """Raises `FormatError` if the text is not the JSON of a scenario, `LayoutError` on an invalid value."""
        document = parse_document(text, SCHEMA, (), ("ego", "actors"))
        ego = document.get("ego")
        rows = check_object(document.get("actors", {}))
        motions = {name: _from_fields(name, row) for name, row in rows.items()}
        return cls(None if ego is None else _from_fields("ego", ego), motions)


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """Places over time: `places` f64 [K, 4], x, y, z [m] and yaw [rad, without jumps], at `times` f64 [K] [s].

    Places are interpolated linearly, and constant before the first and after the last time.
    """

    times: np.ndarray
    places: np.ndarray

    def __post_init__(self) -> None:
        object.__setattr__(self, "times", finite_array("times", self.times, "K"))
        object.__setattr__(self, "places", finite_array("places", self.places, len(self.times), 4))

    def at(self, times: np.ndarray) -> np.ndarray:
        """The places f64 [N, 4] at times [N]."""
        return np.stack([np.interp(times, self.times, column) for column in self.places.T], axis=-1)

    def rate(self, time: float, span: float) -> np.ndarray:
        """The mean velocities [m/s] and yaw rate [rad/s] over `span` [s] around one of the times, f64 [4]."""
        ends = np.clip([time - span / 2, time + span / 2], self.times[0], self.times[-1])
        before, after = self.at(ends)
        rate: np.ndarray = (after - before) / (ends[1] - ends[0])
        return rate

    def moves(self) -> bool:
        """Whether the place ever changes."""
        return bool((np.ptp(self.places, axis=0) > 1e-6).any())


def _check(name: str, value: Any, low: float, high: float, unit: str) -> None:
    if not is_number(value) or not low <= value <= high:
        raise LayoutError(f"{name} is {value!r:.80}; it must be {low:g} to {high:g} {unit}")


def _place(name: str, place: Any) -> tuple[float, float]:
    if not are_numbers(place, 2) or max(map(abs, place)) > _FURTHEST:
        raise LayoutError(f"{name} is {place!r:.80}; it must be x and y within {_FURTHEST:g} m")
    return float(place[0]), float(place[1])


def _rows(name: str, rows: Any, widths: tuple[int, ...]) -> tuple[tuple[float, ...], ...]:
    """Rows of numbers of one of the widths; the first numbers are increasing times."""
    form = " or ".join(map(str, widths))
    if not isinstance(rows, list | tuple | np.ndarray) or not all(
        any(are_numbers(row, width) for width in widths) and len(row) == len(rows[0]) for row in rows
    ):
        raise LayoutError(f"{name} is {rows!r:.80}; it must be rows of {form} numbers, all of one length")
    found = tuple(tuple(map(float, row)) for row in rows)
    for row in found:
        _check(f"{name}: time", row[0], 0.0, _LONGEST, "s")
        if max(map(abs, row[1:])) > _FURTHEST:
            raise LayoutError(f"{name}: {list(row)} has a number larger than {_FURTHEST:g}")
    for before, after in itertools.pairwise(found):
        if after[0] <= before[0]:
            raise LayoutError(f"{name}: time {after[0]:g} s follows {before[0]:g} s; times must run forwards")
    return found


def _written(motion: Motion) -> str:
    """The JSON of a motion; numpy numbers become floats."""
    (name,) = (name for name, kind in _KINDS.items() if type(motion) is kind)
    fields = ((field, getattr(motion, field.name)) for field in dataclasses.fields(motion))
    said = {field.name: value for field, value in fields if value != field.default}
    return json.dumps({name: said["points"] if isinstance(motion, Waypoints) else said}, default=float)


def _from_fields(name: str, row: Any) -> Motion:
    with named(name):
        fields = check_object(row)
        if len(fields) != 1 or not set(fields) <= set(_KINDS):
            raise FormatError(f"a motion is {', '.join(list(_KINDS)[:-1])} or waypoints; this is {row!r:.60}")
        ((kind, said),) = fields.items()
        if kind == "waypoints":
            return Waypoints(said)
        allowed = dataclasses.fields(_KINDS[kind])
        required = [row.name for row in allowed if row.default is dataclasses.MISSING]
        check_fields(check_object(said), required, [row.name for row in allowed])
        return _KINDS[kind](**said)
