"""Lanes and what regulates them: the parts of a road network, and their JSON."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, fields
from typing import Any, TypeVar

from lidardraft.errors import FormatError, LayoutError, one_of
from lidardraft.files import named
from lidardraft.json_fields import are_numbers, check_fields, check_object, is_number
from lidardraft.scene.line import Line
from lidardraft.scene.pose import Place

LANE_KINDS = ("driving", "aisle", "parking", "shoulder", "cycling", "sidewalk")
TURNS = ("left", "right", None)
_TURNING, _EASING = 5.0, 1.5  # m/s in a turn, m/s2 on the way to it
_T = TypeVar("_T")


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Lane:
    """A lane of a road, or a way through several (`RoadNetwork.ways`): its middle `line` in the direction of travel.

    `kind` is one of `LANE_KINDS`, `width` [m] is that of all of it, `speed` [m/s] the limit. `left` and `right` are the
    ids of lanes of the same direction beside it, `successors` those that begin where it ends, `junction` is the id of
    the one that it leads through. Those who give way wait `stop` [m] along it. One that turns, "left" or "right", does
    so from and to along it: `bend` [m]. Raises `LayoutError` naming the lane and an invalid value.
    """

    id: str
    line: Line
    width: float
    speed: float
    road: str = "road"
    kind: str = "driving"
    left: str | None = None
    right: str | None = None
    successors: tuple[str, ...] = ()
    junction: str | None = None
    stop: float | None = None
    turn: str | None = None
    bend: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        for name in ("width", "speed"):
            value = getattr(self, name)
            if not (is_number(value) and value > 0.0):
                raise LayoutError(f"lane {self.id}: {name} is {value!r}; it must be a number over 0")
        if self.kind not in LANE_KINDS:
            raise LayoutError(f"lane {self.id}: kind is {self.kind!r}; it must be {one_of(LANE_KINDS, self.kind)}")
        if self.turn not in TURNS:
            raise LayoutError(f"lane {self.id}: turn is {self.turn!r}; it must be 'left', 'right' or null")
        if self.stop is not None and not (is_number(self.stop) and 0.0 <= self.stop <= self.line.length):
            raise LayoutError(f"lane {self.id}: stop is {self.stop!r}; it must be 0 to {self.line.length:.1f} m")

    def limit(self, along: float) -> float:
        """The speed [m/s] at a place along it from which a turn can be taken."""
        before = max(0.0, self.bend[0] - along)
        return math.sqrt(_TURNING**2 + 2 * _EASING * before) if along < self.bend[1] else math.inf

    def to_dict(self) -> dict[str, Any]:
        """The lane as JSON types; what has a default only where it differs."""
        line = {"points": self.line.points.tolist()}
        if self.line.camber.any():
            line["camber"] = self.line.camber.tolist()
        return {**dict_of(self), "line": line}

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> Lane:
        """The inverse of `to_dict`; raises `FormatError` on a missing or unknown field, `LayoutError` on a value."""
        with named(f"lane {values.get('id', '?')}"):
            line = check_object(values.get("line"))
            check_fields(line, ("points",), ("camber",))
            through = Line.through(line["points"], line.get("camber"))
        return part_of(cls, {**values, "line": through}, "lane")


@dataclass(frozen=True, kw_only=True, slots=True)
class Junction:
    """Where lanes meet: `lanes` are the ids of those that lead through it."""

    id: str
    lanes: tuple[str, ...]


@dataclass(frozen=True, kw_only=True, slots=True)
class Crossing:
    """Where people cross a road: a rectangle around `place`, with its extents [m] in that frame."""

    id: str
    place: Place
    size: tuple[float, float]


@dataclass(frozen=True, kw_only=True, slots=True)
class Signal:
    """A light or a sign at `place` (x, y [m], yaw) that `lanes` obey; who has to waits before it."""

    id: str
    place: Place
    lanes: tuple[str, ...]
    kind: str = "traffic-light"


def dict_of(part: Any) -> dict[str, Any]:
    """A dataclass as JSON types would have it: its fields, but those that have their default."""
    rows = [(row.name, getattr(part, row.name), row.default) for row in fields(part)]
    return {name: value for name, value, default in rows if default is MISSING or value != default}


def part_of(cls: type[_T], values: Mapping[str, Any], what: str) -> _T:
    """The dataclass of the fields of a JSON object; raises as `Lane.from_dict`, naming the part by its id."""
    rows = fields(cls)  # type: ignore[arg-type]
    required = [row.name for row in rows if row.default is MISSING]
    with named(f"{what} {values.get('id', '?')}" if "id" in required else what):
        check_fields(check_object(values), required, [row.name for row in rows])
        given = {name: as_tuples(value) for name, value in values.items()}
        for name, value in given.items():
            length = _LENGTHS.get(name)
            if length and not are_numbers(value, length):
                raise FormatError(f"{name} is {value!r:.50}; it must be {length} numbers")
            if name in ("id", "road", "kind") and what != "street" and not isinstance(value, str):
                raise FormatError(f"{name} is {value!r:.50}; it must be a text")
            if name in ("lanes", "successors") and not (what == "street" or isinstance(value, tuple)):
                raise FormatError(f"{name} is {value!r:.50}; it must be a list of ids")
        try:
            return cls(**given)
        except (TypeError, ValueError, AttributeError) as error:
            raise FormatError(str(error)) from None


_LENGTHS = {"place": 3, "size": 2, "bend": 2}  # of values that are so many numbers


def as_tuples(value: Any) -> Any:
    """A JSON value with tuples in place of its lists; raises `FormatError` on a number that is not finite."""
    if isinstance(value, float) and not math.isfinite(value):
        raise FormatError(f"a number is {value}; it must be finite")
    return tuple(map(as_tuples, value)) if isinstance(value, list | tuple) else value
