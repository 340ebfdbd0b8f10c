"""What a scene is to hold: the road, groups of objects with a count and a place, and what was not understood."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from lidardraft.drafting.sentence_kinds import COUNTS, SENTENCE_KINDS, SentenceKind
from lidardraft.errors import LayoutError, LidarDraftError, one_of
from lidardraft.files import named
from lidardraft.json_fields import check_fields, check_object, parse_object

ROADS = ("straight", "bend", "left-bend", "right-bend", "crossroads", "t-junction", "motorway")
PLACES = tuple(
    "-".join(filter(None, (fore, side)))
    for fore in ("", "front", "behind", "beside")
    for side in ("", "left", "right")
    if fore or side
)
SURFACES = ("road", "sidewalk")
HEADINGS = ("with", "against", "across", "parked")
MAX_COUNT = 200


def split_place(place: str) -> tuple[str, str]:
    """What one of PLACES says of before and behind, and of the side; "" where it says nothing."""
    fore, _, side = place.partition("-")
    return ("", fore) if fore in ("left", "right") else (fore, side)


@dataclass(frozen=True, kw_only=True, slots=True)
class RoadSpec:
    """The road under the ego vehicle; `lanes` (in one direction) and `sidewalk` are None where its kind decides."""

    kind: str = "straight"
    lanes: int | None = None
    sidewalk: bool | None = None

    def __post_init__(self) -> None:
        _one_of("road: kind", self.kind, ROADS)
        if self.lanes is not None and (type(self.lanes) is not int or not 1 <= self.lanes <= 6):
            raise LayoutError(f"road: lanes is {self.lanes!r}; a road has 1 to 6 in each direction")
        if self.sidewalk not in (None, True, False):
            raise LayoutError(f"road: sidewalk is {self.sidewalk!r}; it must be true, false or null")


@dataclass(frozen=True, kw_only=True, slots=True)
class ObjectGroup:
    """Objects of one kind.

    `count` is a number or one of COUNTS, meant for each of `places`; no places is anywhere on or beside the road.
    `surface` asks for one other than the usual of the kind; `heading` is relative to the ego's. `distance` is a range
    from the ego [m]: across the road for what stands beside it at a place that is neither in front nor behind, else
    along the road. `spacing` is the distance between neighbours [m].
    """

    kind: str
    count: int | str = 1
    places: tuple[str, ...] = ()
    surface: str | None = None
    heading: str | None = None
    distance: tuple[float, float] | None = None
    spacing: float | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "places", tuple(self.places))
        _one_of("group: kind", self.kind, tuple(SENTENCE_KINDS))
        if isinstance(self.count, str):
            _one_of(f"{self.kind}: count", self.count, COUNTS)
        elif type(self.count) is not int or not 1 <= self.count <= MAX_COUNT:
            limit = f"1 to {MAX_COUNT}, or one of {', '.join(COUNTS)}"
            raise LayoutError(f"{self.kind}: count is {self.count!r}; it must be {limit}")
        for place in self.places:
            _one_of(f"{self.kind}: place", place, PLACES)
        if self.surface is not None:
            _one_of(f"{self.kind}: surface", self.surface, SENTENCE_KINDS[self.kind].surfaces)
        if self.heading is not None:
            _one_of(f"{self.kind}: heading", self.heading, HEADINGS)
        if self.distance is not None:
            near, far = self.distance
            if not 0.0 <= near <= far < math.inf:
                raise LayoutError(f"{self.kind}: distance is {near} to {far} m; it must be 0 <= from <= to")
            object.__setattr__(self, "distance", (float(near), float(far)))
        if self.spacing is not None:
            if not 0.0 < self.spacing < math.inf:
                raise LayoutError(f"{self.kind}: spacing is {self.spacing!r} m; it must be > 0")
            object.__setattr__(self, "spacing", float(self.spacing))

    @property
    def record(self) -> SentenceKind:
        """What is known of its kind."""
        return SENTENCE_KINDS[self.kind]

    @property
    def crosses(self) -> bool:
        """Whether it drives on a road that crosses the ego's."""
        return self.heading == "across" and self.record.drives


@dataclass(frozen=True, kw_only=True, slots=True)
class SceneSpec:
    """What a scene holds, in relations and counts; `layout_from_spec` turns it into metres.

    `absent` are kinds that nothing in the scene may be; `not_understood` the parts of the source that say nothing here.
    """

    road: RoadSpec = field(default_factory=RoadSpec)
    groups: tuple[ObjectGroup, ...] = ()
    absent: tuple[str, ...] = ()
    not_understood: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for name in ("groups", "absent", "not_understood"):
            object.__setattr__(self, name, tuple(getattr(self, name)))
        for kind in self.absent:
            _one_of("absent: kind", kind, tuple(SENTENCE_KINDS))

    def to_dict(self) -> dict[str, Any]:
        """The spec as JSON types; fields that say nothing are left out."""
        fields: dict[str, Any] = _plain(dataclasses.asdict(self))
        return fields

    @classmethod
    def from_dict(cls, fields: Mapping[str, Any]) -> SceneSpec:
        """The inverse of `to_dict`; raises `FormatError` for an unknown field, `LayoutError` for a wrong one."""
        check_fields(fields, (), cls.__dataclass_fields__)
        road, groups = check_object(fields.get("road", {})), fields.get("groups", ())
        check_fields(road, (), RoadSpec.__dataclass_fields__)
        try:
            for group in groups:
                check_fields(check_object(group), ("kind",), ObjectGroup.__dataclass_fields__)
            return cls(
                **{**fields, "road": RoadSpec(**road), "groups": tuple(ObjectGroup(**group) for group in groups)}
            )
        except LidarDraftError:
            raise
        except (TypeError, ValueError, OverflowError) as error:
            raise LayoutError(f"a value is of the wrong type: {error}") from None

    def to_json(self) -> str:
        """The spec as JSON text; `from_json` gives an equal spec."""
        return json.dumps(self.to_dict(), allow_nan=False)

    @classmethod
    def from_json(cls, text: str) -> SceneSpec:
        """Raises `FormatError` where the text is no spec, `LayoutError` where what it says cannot be."""
        with named("spec"):
            return cls.from_dict(parse_object(text))


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items() if item not in (None, ())}
    return [_plain(item) for item in value] if isinstance(value, tuple | list) else value


def _one_of(name: str, value: object, choices: tuple[str, ...]) -> None:
    if value not in choices:
        raise LayoutError(f"{name} is {value!r}; it must be {one_of(choices, value)}")
