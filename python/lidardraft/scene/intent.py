"""The intent of a layout: the request, and the objects that answer it."""

from __future__ import annotations

from collections.abc import Mapping, Set
from dataclasses import dataclass, field, replace
from typing import Any

from lidardraft.errors import as_tuple, check_choices, check_that
from lidardraft.files import named
from lidardraft.json_fields import check_fields, check_object, is_number, write_as
from lidardraft.scene.weather import WEATHERS

HEADINGS = (
    *("with", "against", "parked"),
    *("across", "across-left", "across-right", "turning", "turning-left", "turning-right"),
)
MOTIONS = ("brakes", "accelerates", "overtakes")
MAX_SPEED = 70.0  # m/s
PAINTS = ("light", "mid", "dark")
ACTIVITIES = ("empty", "quiet", "busy")


def check_speed(name: str, speed: float | None) -> None:
    """Raises `LayoutError` if a speed [m/s] is invalid."""
    fits = speed is None or (is_number(speed) and 0.0 <= speed <= MAX_SPEED)
    check_that(fits, name, speed, f"0 to {MAX_SPEED:g} m/s")


def _check_text(name: str, value: object) -> None:
    check_that(value is None or type(value) is str, name, value, "text")


@dataclass(frozen=True, kw_only=True, slots=True)
class Asked:
    """The request for one object, or for the ego vehicle; a field is None if the request leaves it open.

    `group` is the number of its group in the request, `kind` the noun used, as in "pickup". `counted` is True if the
    request gave a number, and not some or many. `heading` is one of HEADINGS, relative to the ego's. `motion`, one of
    MOTIONS, and `speed` [m/s] are its motion in a sequence; it `overtakes` the groups of these numbers. `paint` is one
    of PAINTS. Raises `LayoutError` on an invalid value.
    """

    group: int | None = None
    kind: str | None = None
    counted: bool = True
    heading: str | None = None
    motion: str | None = None
    speed: float | None = None
    overtakes: tuple[int, ...] = ()
    paint: str | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "overtakes", as_tuple("overtakes", self.overtakes))
        for number in (*self.overtakes, self.group or 0):
            check_that(type(number) is int and number >= 0, "group", number, "the number of a group, 0 or more")
        _check_text("kind", self.kind)
        check_that(type(self.counted) is bool, "counted", self.counted, "true or false")
        check_choices(self, {"heading": HEADINGS, "motion": MOTIONS, "paint": PAINTS})
        check_speed("speed", self.speed)


NOTHING = Asked()


@dataclass(frozen=True, kw_only=True, slots=True)
class Intent:
    """The request that a layout answers; a field is None if the request leaves it open.

    `sentence` is the text of the request. `road` is the kind of the road. `district` is its surroundings, as a street
    or a sentence gives them. `activity`, one of ACTIVITIES, is how busy it is; `weather` is one of
    `scene.weather.WEATHERS`. One more object of a kind in `denied` would contradict the request. `objects` maps names
    of objects to the request for each; names that the layout lacks are ignored. `ego` is the ego vehicle. `around` is
    the district of the street that `surround` has added.

    `headed` is whether the yaw of an object gives its front; a clustering of points cannot tell front from back.
    Raises `LayoutError` on an invalid value.
    """

    sentence: str | None = None
    road: str | None = None
    district: str | None = None
    activity: str | None = None
    weather: str | None = None
    denied: tuple[str, ...] = ()
    ego: Asked = NOTHING
    objects: Mapping[str, Asked] = field(default_factory=dict)
    around: str | None = None
    headed: bool = True

    def __post_init__(self) -> None:
        object.__setattr__(self, "denied", as_tuple("denied", self.denied))
        for name in ("sentence", "road", "district", "around"):
            _check_text(name, getattr(self, name))
        for kind in self.denied:
            check_that(type(kind) is str, "denied: kind", kind, "text")
        check_choices(self, {"activity": ACTIVITIES, "weather": WEATHERS})
        check_that(type(self.headed) is bool, "headed", self.headed, "true or false")
        check_that(isinstance(self.ego, Asked), "ego", self.ego, "of type Asked")
        whole = isinstance(self.objects, Mapping) and all(isinstance(one, Asked) for one in self.objects.values())
        check_that(whole, "objects", self.objects, "an `Asked` for each name")

    def of(self, name: str) -> Asked:
        """The request for an object, or for "ego"."""
        return self.ego if name == "ego" else self.objects.get(name, NOTHING)

    def only(self, names: Set[str]) -> Intent:
        """The intent of the named objects alone."""
        if self.objects.keys() <= names:
            return self
        return replace(self, objects={name: asked for name, asked in self.objects.items() if name in names})

    def renamed(self, names: Mapping[str, str]) -> Intent:
        """The intent with other names of objects."""
        return replace(self, objects={names.get(name, name): asked for name, asked in self.objects.items()})

    @classmethod
    def of_spec(cls, spec: Mapping[str, Any], objects: Mapping[str, int]) -> Intent:
        """The intent of the JSON of a `SceneSpec`; `objects` maps each object to the number of its group."""
        road, settings = spec.get("road", {}), ("district", "activity", "weather")
        of_group = [_asked_of(number, group) for number, group in enumerate(spec.get("groups", ()))]
        counted = [one.kind for one in of_group if one.counted and one.kind]
        ahead = [number for number, one in enumerate(of_group) if one.heading in (None, "with")]
        ego = {"motion": road.get("ego_motion"), "speed": road.get("ego_speed"), "references": ahead}
        fields: dict[str, Any] = {name: spec.get(name) for name in settings}
        return cls(
            road=road.get("kind"),
            denied=tuple(dict.fromkeys((*spec.get("absent", ()), *spec.get("not_around", ()), *counted))),
            ego=_asked_of(None, ego),
            objects={name: of_group[number] for name, number in objects.items()},
            **fields,
        )

    def to_dict(self) -> dict[str, Any]:
        """The intent as JSON types; fields with nothing to say are left out."""
        said: dict[str, Any] = write_as(self)
        return said

    @classmethod
    def from_dict(cls, fields: Mapping[str, Any]) -> Intent:
        """The inverse of `to_dict`; raises `FormatError` for an unknown field, `LayoutError` for an invalid one."""
        check_fields(check_object(fields), (), cls.__dataclass_fields__)
        ego, rows = _asked("ego", fields.get("ego", {})), check_object(fields.get("objects", {}))
        return cls(**{**fields, "ego": ego, "objects": {name: _asked(name, row) for name, row in rows.items()}})


NOTHING_ASKED = Intent()


def _asked_of(number: int | None, group: Mapping[str, Any]) -> Asked:
    """The request of a spec's group, with its `number`, for each of its objects."""
    names = ("kind", "heading", "motion", "speed", "paint")
    fields: dict[str, Any] = {name: group.get(name) for name in names}
    overtakes = tuple(group.get("references", ())) if fields["motion"] == "overtakes" else ()
    return Asked(group=number, counted=group.get("count", 1) not in ("some", "many"), overtakes=overtakes, **fields)


def _asked(name: str, row: Any) -> Asked:
    with named(name):
        check_fields(check_object(row), (), Asked.__dataclass_fields__)
        return Asked(**row)
