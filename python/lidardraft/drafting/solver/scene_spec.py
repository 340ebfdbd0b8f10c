"""The contents of a scene: the road, groups of objects with a count and a place, and the text not understood."""

from __future__ import annotations

import dataclasses
import graphlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, cast

from lidardraft.arranging.district import SETTINGS
from lidardraft.errors import LayoutError, as_tuple, check_choice, check_choices, check_that
from lidardraft.json_fields import are_numbers, check_fields, check_object, is_number
from lidardraft.objects.kinds import SENTENCE_KINDS
from lidardraft.objects.sentence_kind import COUNTS, SentenceKind
from lidardraft.scene.intent import ACTIVITIES, HEADINGS, MOTIONS, PAINTS, check_speed
from lidardraft.scene.weather import WEATHERS

ROADS = (
    *("straight", "bend", "left-bend", "right-bend", "crossroads", "t-junction", "roundabout"),
    *("motorway", "parking-lot"),
)
PLACES = tuple(
    "-".join(filter(None, (fore, side)))
    for fore in ("", "front", "behind", "beside")
    for side in ("", "left", "right")
    if fore or side
)
SURFACES = ("road", "sidewalk", "median")
LANES = ("own", "left", "middle", "right", "opposite", "each")
EGO_LANES = ("left", "middle", "right")
RELATIONS = ("behind", "in-front-of", "beside", "left-of", "right-of", "between", "opposite", "near")
DISTRICTS = tuple(SETTINGS)
MAX_COUNT = 5000
MAX_LANES = 6  # in one direction
NEAREST_JUNCTION = 6.0  # m, before the ego
MIN_SPACING = CLOSED = 0.1  # m, for a row without gaps
EXTENTS = (0.05, 100.0)  # m, the limits of a requested extent

_FORE = {"front": "in front", "behind": "behind", "beside": "beside the ego vehicle"}
_HEADINGS = {
    "with": "in the ego's direction",
    "against": "oncoming",
    "parked": "parked",
    "across": "crossing",
    "across-left": "crossing to the left",
    "across-right": "crossing to the right",
    "turning": "turning",
    "turning-left": "turning left",
    "turning-right": "turning right",
}
_MOTIONS = {"brakes": "braking", "accelerates": "accelerating", "overtakes": "overtaking"}
_RELATIONS = {"left-of": "on the left of", "right-of": "on the right of", "in-front-of": "in front of"}


def split_place(place: str) -> tuple[str, str]:
    """The two parts of one of PLACES: before or behind, and the side; "" for an open part."""
    fore, _, side = place.partition("-")
    return ("", fore) if fore in ("left", "right") else (fore, side)


@dataclass(frozen=True, kw_only=True, slots=True)
class RoadSpec:
    """The road under the ego vehicle; `lanes` (in one direction) and `sidewalk` are None if its kind decides.

    `median` requests a strip between the directions, which motorways have anyway. `oncoming_lanes` are those of the
    other direction, if their number differs. With `one_way` all lanes lead in the ego's direction. `ego_lane` is one of
    EGO_LANES, or None if open; `ego_motion` and `ego_speed` are as those of a group. `junction` is the range from the
    ego to the start of the crossing road [m], None if open.
    """

    kind: str = "straight"
    lanes: int | None = None
    oncoming_lanes: int | None = None
    sidewalk: bool | None = None
    median: bool = False
    one_way: bool = False
    ego_lane: str | None = None
    ego_motion: str | None = None
    ego_speed: float | None = None
    junction: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        check_choice("road: kind", self.kind, ROADS)
        check_choices(self, {"ego_lane": EGO_LANES, "ego_motion": MOTIONS}, "road: ")
        check_speed("road: ego_speed", self.ego_speed)
        for name in ("lanes", "oncoming_lanes"):
            number = getattr(self, name)
            fits = number is None or (type(number) is int and 1 <= number <= MAX_LANES)
            check_that(fits, f"road: {name}", number, f"1 to {MAX_LANES} in each direction")
        two_way = self.lanes is not None and not self.one_way and self.kind != "motorway"
        limit = "null, unless the road is two-way and has a number of lanes"
        check_that(self.oncoming_lanes is None or two_way, "road: oncoming_lanes", self.oncoming_lanes, limit)
        said = self.sidewalk is None or type(self.sidewalk) is bool
        check_that(said, "road: sidewalk", self.sidewalk, "true, false or null")
        for name in ("median", "one_way"):
            check_that(type(getattr(self, name)) is bool, f"road: {name}", getattr(self, name), "true or false")
        if self.junction is not None:
            fits = are_numbers(self.junction, 2) and NEAREST_JUNCTION <= self.junction[0] <= self.junction[1]
            check_that(fits, "road: junction", self.junction, f"a range in metres, {NEAREST_JUNCTION:g} <= from <= to")
            object.__setattr__(self, "junction", (float(self.junction[0]), float(self.junction[1])))


@dataclass(frozen=True, kw_only=True, slots=True)
class ObjectGroup:
    """Objects of one kind.

    `count` is a number, a range of numbers (from, to) or one of COUNTS, and applies to each of `places`. Without places
    the objects are anywhere on or beside the road, but at none of `not_places`. `surface` requests one other than the
    usual of the kind. `lane` requests one of LANES: "left" is the leftmost in the ego's direction; with "each" the
    count applies to every lane that `heading` allows. `at_junction` puts them at the junction with another road;
    `heading` is relative to the ego's. `motion`, one of MOTIONS, and `speed` [m/s] are their motion in a sequence; 0 is
    still.

    `distance` is a range from the ego [m]. It is across the road at places beside the ego, and for roadside objects at
    places that are neither in front nor behind; else along the road. `spacing` is the distance between the middles of
    neighbours [m], or between their ends if it is shorter than the objects; CLOSED is no gap. `from_road` is a range
    from the kerb to the near side [m], beyond the kerb, but before it for vehicles and on the surface "road".
    `from_sidewalk` is one from the far edge of the sidewalk. `size` is length, width and height [m], None if open;
    `scale` multiplies the usual size. `paint`, one of PAINTS, is for vehicles.

    `relation` places the objects relative to those of other groups, `references`, by their numbers in the spec; then
    `distance` is measured from there. `words` are those of the sentence that requested the group.
    """

    kind: str
    count: int | str | tuple[int, int] = 1
    places: tuple[str, ...] = ()
    not_places: tuple[str, ...] = ()
    surface: str | None = None
    lane: str | None = None
    at_junction: bool = False
    heading: str | None = None
    motion: str | None = None
    speed: float | None = None
    distance: tuple[float, float] | None = None
    spacing: float | None = None
    from_road: tuple[float, float] | None = None
    from_sidewalk: tuple[float, float] | None = None
    size: tuple[float | None, float | None, float | None] | None = None
    scale: tuple[float, float, float] | None = None
    paint: str | None = None
    relation: str | None = None
    references: tuple[int, ...] = ()
    words: str = field(default="", compare=False)

    def __post_init__(self) -> None:
        check_choice("group: kind", self.kind, tuple(SENTENCE_KINDS))
        for name in ("places", "not_places", "references"):
            object.__setattr__(self, name, as_tuple(f"{self.kind}: {name}", getattr(self, name)))
        for place in (*self.places, *self.not_places):
            check_choice(f"{self.kind}: place", place, PLACES)
        choices = {"surface": self.record.surfaces, "lane": LANES, "heading": HEADINGS, "relation": RELATIONS}
        check_choices(self, {**choices, "motion": MOTIONS, "paint": PAINTS}, f"{self.kind}: ")
        check_that(type(self.at_junction) is bool, f"{self.kind}: at_junction", self.at_junction, "true or false")
        check_speed(f"{self.kind}: speed", self.speed)
        check_that(type(self.words) is str, f"{self.kind}: words", self.words, "text")
        if (self.relation is None) != (not self.references):
            raise LayoutError(f"{self.kind}: relation is {self.relation!r} to {self.references}; one needs the other")
        if self.set_back and (self.relation is not None or None not in (self.from_road, self.from_sidewalk)):
            raise LayoutError(f"{self.kind}: from_road, from_sidewalk and relation exclude each other")
        self._check_count()
        self._check_lengths()

    def _check_count(self) -> None:
        if isinstance(self.count, str):
            return check_choice(f"{self.kind}: count", self.count, COUNTS)
        low, *rest = self.count if isinstance(self.count, tuple | list) and self.count else (self.count,)
        high = rest[0] if rest else low
        whole = len(rest) < 2 and type(low) is int and type(high) is int
        limit = f"1 to {MAX_COUNT}, or one of {', '.join(COUNTS)}"
        check_that(whole and 1 <= low <= high <= MAX_COUNT, f"{self.kind}: count", self.count, limit)
        object.__setattr__(self, "count", low if low == high else (low, high))

    def _check_lengths(self) -> None:
        for name in ("distance", "from_road", "from_sidewalk"):
            value = getattr(self, name)
            if value is not None:
                fits = are_numbers(value, 2) and 0.0 <= value[0] <= value[1]
                check_that(fits, f"{self.kind}: {name}", value, "a range in metres, 0 <= from <= to")
                object.__setattr__(self, name, (float(value[0]), float(value[1])))
        if self.spacing is not None:
            fits = is_number(self.spacing) and self.spacing >= MIN_SPACING
            check_that(fits, f"{self.kind}: spacing", self.spacing, f"{MIN_SPACING} m or more")
            object.__setattr__(self, "spacing", float(self.spacing))
        for name, (low, high) in (("size", EXTENTS), ("scale", (0.1, 10.0))):
            value = getattr(self, name)
            if value is not None:
                numbers = [low if one is None else one for one in value] if isinstance(value, tuple | list) else ()
                fits = are_numbers(numbers, 3) and low <= min(numbers) and max(numbers) <= high
                check_that(fits, f"{self.kind}: {name}", value, f"three numbers of {low:g} to {high:g}, or null")
                object.__setattr__(self, name, tuple(None if one is None else float(one) for one in value))

    @property
    def record(self) -> SentenceKind:
        """The record of its kind."""
        return SENTENCE_KINDS[self.kind]

    @property
    def on_road(self) -> bool:
        """Whether it may be on the road."""
        return self.record.on_road or self.surface in ("road", "median") or self.lane is not None

    @property
    def set_back(self) -> bool:
        """Whether it is requested at a distance from the road or the sidewalk."""
        return self.from_road is not None or self.from_sidewalk is not None

    @property
    def set_aside(self) -> bool:
        """Whether it is a roadside object requested at a distance to the left or the right of the ego."""
        sides = all(place in ("left", "right") for place in self.places)
        return self.distance is not None and self.relation is None and not self.on_road and sides

    @property
    def is_closed(self) -> bool:
        """Whether it is a row without gaps: walls along a side with a word as number, or a group that is CLOSED."""
        free = self.relation is None and self.distance is None and not self.on_road
        along = all(place in ("left", "right") for place in self.places)
        lines = self.record.follows_road and isinstance(self.count, str) and self.spacing is None and bool(self.places)
        return free and along and (lines or self.spacing == CLOSED)

    @property
    def crosses(self) -> bool:
        """Whether it drives on a road that crosses the ego's."""
        return str(self.heading).startswith("across") and self.record.drives and not self.goes_across

    @property
    def goes_across(self) -> bool:
        """Whether it goes straight across the ego's road: on foot, or on two wheels at a given place."""
        on_wheels = self.record.cycles and (self.distance or self.relation or self.surface == "road")
        return str(self.heading).startswith("across") and (self.record.walks or bool(on_wheels))

    @property
    def way_across(self) -> int:
        """1 if it crosses the ego's road to the left, -1 to the right, 0 if that is open."""
        comes_from = {split_place(place)[1] for place in self.places}
        from_side = {frozenset({"right"}): 1, frozenset({"left"}): -1}.get(frozenset(comes_from), 0)
        return {"across-left": 1, "across-right": -1}.get(str(self.heading), from_side)

    @property
    def turns(self) -> bool:
        """Whether it drives from one road into another."""
        return str(self.heading).startswith("turning") and self.record.drives

    @property
    def fewest(self) -> int | None:
        """The fewest objects that meet a numeric count; None for a word."""
        return None if isinstance(self.count, str) else self.count if isinstance(self.count, int) else self.count[0]


@dataclass(frozen=True, kw_only=True, slots=True)
class SceneSpec:
    """The contents of a scene, in relations and counts; `layout_from_spec` turns it into metres.

    `absent` are kinds that the scene must not have; `not_understood` the parts of the source without meaning here.
    `district`, one of DISTRICTS, is the area of the road, and `activity`, one of ACTIVITIES, how busy it is. They
    decide the surroundings (`surround`), not the scene. Kinds in `not_around` are not added there either: they are
    denied at a place, or in a state, such as parked cars. `weather` is one of WEATHERS.
    """

    road: RoadSpec = field(default_factory=RoadSpec)
    groups: tuple[ObjectGroup, ...] = ()
    absent: tuple[str, ...] = ()
    not_understood: tuple[str, ...] = ()
    district: str | None = None
    activity: str | None = None
    not_around: tuple[str, ...] = ()
    weather: str | None = None

    def __post_init__(self) -> None:
        for name in ("groups", "absent", "not_understood", "not_around"):
            object.__setattr__(self, name, as_tuple(name, getattr(self, name)))
        check_choices(self, {"district": DISTRICTS, "activity": ACTIVITIES, "weather": WEATHERS})
        for name in ("absent", "not_around"):
            for kind in getattr(self, name):
                check_choice(f"{name}: kind", kind, tuple(SENTENCE_KINDS))
        for part in self.not_understood:
            check_that(type(part) is str, "not_understood: part", part, "text")
        for number, group in enumerate(self.groups):
            for reference in group.references:
                other = type(reference) is int and 0 <= reference < len(self.groups) and reference != number
                check_that(other, f"{group.kind}: reference", reference, "the number of another group")
        self._check_circles()

    def _check_circles(self) -> None:
        """Raises `LayoutError` if groups are placed from each other in a circle."""
        sorter = graphlib.TopologicalSorter({n: group.references for n, group in enumerate(self.groups)})
        try:
            sorter.prepare()
        except graphlib.CycleError as error:
            kinds = ", ".join(self.groups[number].kind for number in error.args[1][1:])
            raise LayoutError(f"references go in a circle: {kinds}") from None

    def to_dict(self) -> dict[str, Any]:
        """The spec as JSON types; fields that say nothing are left out."""
        return cast(dict[str, Any], _plain(dataclasses.asdict(self)))

    @classmethod
    def from_dict(cls, fields: Mapping[str, Any]) -> SceneSpec:
        """The inverse of `to_dict`; raises `FormatError` for an unknown field, `LayoutError` for an invalid one."""
        check_fields(fields, (), cls.__dataclass_fields__)
        road, groups = check_object(fields.get("road", {})), as_tuple("groups", fields.get("groups", ()))
        check_fields(road, (), RoadSpec.__dataclass_fields__)
        for group in groups:
            check_fields(check_object(group), ("kind",), ObjectGroup.__dataclass_fields__)
        return cls(**{**fields, "road": RoadSpec(**road), "groups": [ObjectGroup(**group) for group in groups]})


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items() if not _says_nothing(key, item)}
    return [_plain(item) for item in value] if isinstance(value, tuple | list) else value


def _says_nothing(key: str, item: Any) -> bool:
    return item is None or item == () or (key in ("median", "one_way", "at_junction", "words") and not item)


def relations(spec: SceneSpec) -> list[str]:
    """All relations of a spec, the road's first, a line each."""
    found = [f"road: {text}" for text in road_relations(spec.road)]
    for group in spec.groups:
        found += [
            f"{group.kind}: {', '.join([count_text(group), *group_relations(group, spec, place)])}"
            for place in group.places or ("",)
        ]
    found += [f"{kind}: none" for kind in spec.absent]
    return found + ([f"weather: {spec.weather}"] if spec.weather else [])


def road_relations(road: RoadSpec) -> list[str]:
    """The properties of the road, as texts."""
    found = [road.kind]
    if road.lanes is not None:
        other = road.oncoming_lanes or road.lanes
        ways = " each way" if other == road.lanes else f" this way, {other} oncoming"
        ways = "" if road.one_way else ways
        found.append(f"{road.lanes} lane{'s' * (road.lanes > 1)}{ways}")
    if road.one_way:
        found.append("one-way")
    if road.sidewalk is not None:
        found.append("sidewalks" if road.sidewalk else "no sidewalks")
    if road.median:
        found.append("a median")
    if road.ego_lane is not None:
        found.append(f"the ego in the {road.ego_lane} lane")
    found += [f"the ego {text}" for text in _motion_text(road.ego_motion, road.ego_speed)]
    if road.junction is not None:
        near, far = road.junction
        found.append(f"the junction {near:g} m ahead" if near == far else f"the junction {near:g} to {far:g} m ahead")
    return found


def _motion_text(motion: str | None, speed: float | None) -> list[str]:
    pace = [] if speed is None else [f"at {speed * 3.6:.3g} km/h" if speed else "standing"]
    return [*pace, *([] if motion is None else [_MOTIONS[motion]])]


def count_text(group: ObjectGroup) -> str:
    """The number of objects of a group at each place, as a text."""
    return f"{group.count[0]} to {group.count[1]}" if isinstance(group.count, tuple) else str(group.count)


def group_relations(group: ObjectGroup, spec: SceneSpec, place: str) -> list[str]:
    """The places, relations and states of the objects of a group at one of its places, as texts."""
    fore, side = split_place(place)
    found = ([_FORE[fore]] if fore else []) + ([f"on the {side}"] if side else [])
    found += [f"not {' '.join(split_place(place)).strip()}" for place in group.not_places]
    lane = {"own": "the ego", "each": "each"}.get(str(group.lane), f"the {group.lane}")
    found += [f"in {lane} lane"] * (group.lane is not None)
    found += ["at the junction"] * group.at_junction
    found += [f"{'in' if group.surface == 'median' else 'on'} the {group.surface}"] * (group.surface is not None)
    if group.relation is not None:
        kinds = " and ".join(spec.groups[reference].kind for reference in group.references)
        found.append(f"{_RELATIONS.get(group.relation, group.relation)} {kinds}")
    off = "from the kerb" if group.record.drives or group.surface == "road" else "from the road"
    lengths = ((group.distance, "away"), (group.from_road, off), (group.from_sidewalk, "from the sidewalk"))
    for length, said in lengths:
        if length is not None:
            near, far = length
            found.append(f"{near:g} m {said}" if near == far else f"{near:g} to {far:g} m {said}")
    if group.spacing is not None:
        found.append("without gaps" if group.spacing == CLOSED else f"every {group.spacing:g} m")
    found += [_HEADINGS[group.heading]] if group.heading is not None else []
    found += _motion_text(group.motion, group.speed)
    found += [f"{group.paint} paint"] if group.paint is not None else []
    sizes = zip(("long", "wide", "high"), group.size or (None,) * 3, group.scale or (None,) * 3, strict=True)
    for name, metres, scale in sizes:
        if metres is not None:
            found.append(f"{metres:g} m {name}")
        if scale not in (None, 1.0):
            found.append(f"{scale:g} times as {name}")
    return found
