"""The kinds of object that a sentence can ask for: one record each, from which everything else about a kind follows.

The words for a kind stand in `english.lark` under its name in capitals; without them the grammar is in error.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from lidardraft.drafting.solver.object_shapes import (
    ObjectPart,
    SizeAround,
    SizeBetween,
    Sizes,
    sample_box,
    sample_bush,
    sample_cone,
    sample_garden,
    sample_pole,
    sample_street_light,
    sample_traffic_light,
    sample_traffic_sign,
    sample_tree,
    with_rider,
)
from lidardraft.semantics import BY_NAME


@dataclass(frozen=True, slots=True)
class CountRanges:
    """How many objects at one place the words "few", "some" and "many" mean: fewest and most."""

    few: tuple[int, int]
    some: tuple[int, int]
    many: tuple[int, int]


COUNTS = tuple(field.name for field in dataclasses.fields(CountRanges))
_TRAFFIC = CountRanges(few=(2, 3), some=(2, 4), many=(5, 7))
_BUILDINGS = CountRanges(few=(2, 3), some=(3, 5), many=(5, 7))
_STRIPS = CountRanges(few=(1, 2), some=(2, 3), many=(3, 4))
_PEOPLE = CountRanges(few=(2, 3), some=(2, 4), many=(6, 9))
_TRAFFIC_LIGHTS = CountRanges(few=(1, 2), some=(2, 2), many=(3, 4))
_OTHERS = CountRanges(few=(2, 3), some=(4, 6), many=(8, 11))


@dataclass(frozen=True, slots=True)
class Setback:
    """How far behind the sidewalk the middle of an object stands [m]: usually `nearest` to `usual`, for want of room up
    to `farthest`."""

    nearest: float
    usual: float
    farthest: float


@dataclass(frozen=True, kw_only=True, slots=True)
class SentenceKind:
    """One kind of object.

    `label` is the class of its largest part. `sizes` are those of the whole object, without a rider; None for the kind
    "vehicle", which stands for any kind with a `traffic_share`, the share it has of such traffic. `shapes` samples the
    parts. `counts` says what words for numbers mean. `surfaces` are those that it can be asked for on; with none it
    always stands behind the sidewalk. What is `set_down` stands on the road where nothing else is said. `precedence` is
    higher for what is placed earlier, as it needs most room or has least choice.

    `is_vehicle`, `cycles` and `walks` say how it moves, if it does. `is_ridden` adds a rider unless it is parked.
    `lane_length` is what it takes of a lane while it drives, with the gaps that people leave [m], and `parking_width`
    the width of the strip that it is parked on [m].

    What stands beside the road does so at `setback`, or at the kerb where that is None, and is out of line by
    `yaw_deviation` [rad]. `follows_road` is for long strips that bend with the road, `at_junction` for what stands
    where traffic waits before a junction, if there is one.
    """

    name: str
    label: str
    sizes: Sizes | None
    shapes: Callable[[Sizes, str, np.random.Generator], list[ObjectPart]] = sample_box
    counts: CountRanges = _OTHERS
    surfaces: tuple[str, ...] = ()
    precedence: int = 0
    set_down: bool = False
    is_vehicle: bool = False
    cycles: bool = False
    walks: bool = False
    is_ridden: bool = False
    traffic_share: float = 0.0
    lane_length: float = 12.0
    parking_width: float = 2.2
    setback: Setback | None = None
    yaw_deviation: float = 0.0
    follows_road: bool = False
    at_junction: bool = False

    @property
    def drives(self) -> bool:
        """Whether it moves in a lane."""
        return self.is_vehicle or self.cycles

    @property
    def on_road(self) -> bool:
        """Whether it may be on the road without being asked for there."""
        return self.drives or self.walks or self.set_down

    def sample_parts(self, rng: np.random.Generator, *, parked: bool = False) -> list[ObjectPart]:
        """The parts of one object, in a size of its own; a single part has an empty name.

        What `is_ridden` has a rider unless `parked`.
        """
        assert self.sizes is not None, f"{self.name} stands for other kinds"
        parts = self.shapes(self.sizes, self.label, rng)
        return with_rider(parts[0], rng) if self.is_ridden and not parked else parts


_MACHINE = (0.10, 0.04, 0.08)  # how much sizes vary, as shares of length, width and height
_TWO_WHEELER = (0.08, 0.10, 0.06)
_ROADS_AND_WALKS = ("road", "sidewalk")


def _class_sizes(label: str, spread: tuple[float, float, float]) -> SizeAround:
    """Around the typical size in the class table."""
    typical = BY_NAME[label].size
    assert typical is not None, f"{label} has no typical size"
    return SizeAround(typical, spread)


_vehicle = partial(SentenceKind, counts=_TRAFFIC, surfaces=("road",), is_vehicle=True)

# Numbers are estimates of ours. Vans are cars in Cityscapes; their size is that of common European ones.
_VEHICLES = (
    _vehicle(name="vehicle", label="car", sizes=None, precedence=7, parking_width=3.0),
    _vehicle(name="car", label="car", sizes=_class_sizes("car", _MACHINE), precedence=6, traffic_share=0.76),
    _vehicle(name="van", label="car", sizes=SizeAround((5.3, 2.0, 2.2), _MACHINE), precedence=8, traffic_share=0.12),
    _vehicle(
        name="truck",
        label="truck",
        sizes=_class_sizes("truck", _MACHINE),
        precedence=9,
        traffic_share=0.08,
        lane_length=18.0,
        parking_width=3.0,
    ),
    _vehicle(
        name="bus",
        label="bus",
        sizes=_class_sizes("bus", _MACHINE),
        precedence=10,
        traffic_share=0.04,
        lane_length=21.0,
        parking_width=3.0,
    ),
    _vehicle(
        name="tram",
        label="train",
        sizes=_class_sizes("train", _MACHINE),
        precedence=11,
        lane_length=38.0,
        parking_width=3.0,
    ),
    _vehicle(name="motorcycle", label="motorcycle", sizes=_class_sizes("motorcycle", _TWO_WHEELER), is_ridden=True),
    SentenceKind(
        name="bicycle",
        label="bicycle",
        sizes=_class_sizes("bicycle", _TWO_WHEELER),
        counts=_TRAFFIC,
        surfaces=_ROADS_AND_WALKS,
        cycles=True,
        is_ridden=True,
    ),
)
_PERSON = SentenceKind(
    name="person",
    label="person",
    sizes=SizeBetween((0.4, 0.45, 1.5), (0.8, 0.65, 1.9)),
    counts=_PEOPLE,
    surfaces=_ROADS_AND_WALKS,
    walks=True,
)
_strip = partial(SentenceKind, counts=_STRIPS, surfaces=("road",), follows_road=True)
# Length is along the road.
_BEHIND_THE_SIDEWALK = (
    SentenceKind(
        name="house",
        label="building",
        sizes=SizeBetween((8.0, 7.0, 5.0), (13.0, 10.0, 8.5)),
        counts=_BUILDINGS,
        precedence=12,
        setback=Setback(9.0, 12.0, 22.0),
        yaw_deviation=0.02,
    ),
    SentenceKind(
        name="building",
        label="building",
        sizes=SizeBetween((12.0, 10.0, 9.0), (22.0, 14.0, 20.0)),
        counts=_BUILDINGS,
        precedence=13,
        setback=Setback(8.0, 11.0, 24.0),
        yaw_deviation=0.02,
    ),
    SentenceKind(
        name="tree",
        label="vegetation",
        sizes=SizeBetween((2.8, 2.8, 5.0), (5.0, 5.0, 10.0)),
        shapes=sample_tree,
        surfaces=_ROADS_AND_WALKS,
        precedence=1,
        setback=Setback(1.3, 3.0, 14.0),
    ),
    SentenceKind(
        name="bush",
        label="vegetation",
        sizes=SizeBetween((0.8, 0.8, 0.7), (2.2, 2.2, 1.8)),
        shapes=sample_bush,
        surfaces=_ROADS_AND_WALKS,
        setback=Setback(1.4, 3.0, 10.0),
    ),
    SentenceKind(
        name="garden",
        label="vegetation",
        sizes=SizeBetween((5.0, 1.95, 0.7), (9.0, 2.2, 1.2)),
        shapes=sample_garden,
        precedence=2,
        setback=Setback(0.6, 1.0, 4.0),
    ),
    _strip(
        name="hedge",
        label="vegetation",
        sizes=SizeBetween((6.0, 0.6, 0.9), (16.0, 1.2, 2.0)),
        precedence=3,
        setback=Setback(0.9, 1.2, 5.0),
    ),
    _strip(
        name="fence",
        label="fence",
        sizes=SizeBetween((10.0, 0.06, 0.9), (30.0, 0.15, 1.8)),
        precedence=4,
        setback=Setback(0.4, 0.8, 5.0),
    ),
    # of steel or, from 0.8 m on, of concrete
    _strip(
        name="barrier",
        label="fence",
        sizes=SizeBetween((10.0, 0.3, 0.7), (30.0, 0.6, 0.9)),
        precedence=4,
        setback=Setback(0.4, 0.8, 5.0),
    ),
    _strip(
        name="wall",
        label="wall",
        sizes=SizeBetween((10.0, 0.2, 1.5), (30.0, 0.4, 3.0)),
        precedence=5,
        setback=Setback(0.5, 0.9, 5.0),
    ),
)
_STREET_FURNITURE = (
    SentenceKind(
        name="pole",
        label="pole",
        sizes=SizeBetween((0.1, 0.1, 2.5), (0.2, 0.2, 5.0)),
        shapes=sample_pole,
        surfaces=_ROADS_AND_WALKS,
    ),
    SentenceKind(
        name="street-light",
        label="pole",
        sizes=SizeBetween((0.3, 1.2, 6.0), (0.3, 1.2, 8.5)),
        shapes=sample_street_light,
        surfaces=_ROADS_AND_WALKS,
    ),
    SentenceKind(
        name="traffic-light",
        label="traffic-light",
        sizes=SizeBetween((0.35, 0.35, 3.1), (0.35, 0.35, 3.9)),
        shapes=sample_traffic_light,
        counts=_TRAFFIC_LIGHTS,
        surfaces=_ROADS_AND_WALKS,
        at_junction=True,
    ),
    SentenceKind(
        name="traffic-sign",
        label="traffic-sign",
        sizes=SizeBetween((0.145, 0.6, 2.0), (0.145, 0.9, 2.6)),
        shapes=sample_traffic_sign,
        surfaces=_ROADS_AND_WALKS,
    ),
    SentenceKind(
        name="bin", label="other", sizes=SizeBetween((0.5, 0.5, 0.9), (0.8, 0.7, 1.2)), surfaces=_ROADS_AND_WALKS
    ),
    SentenceKind(
        name="bench",
        label="other",
        sizes=SizeBetween((1.4, 0.5, 0.75), (1.9, 0.6, 0.9)),
        surfaces=_ROADS_AND_WALKS,
        setback=Setback(0.7, 1.0, 3.0),
    ),
)
_SET_DOWN = (
    # 0.75 m for motorways and 0.5 m for other roads in the German rules for road works (RSA 21)
    SentenceKind(
        name="cone",
        label="other",
        sizes=SizeBetween((0.28, 0.28, 0.5), (0.4, 0.4, 0.75)),
        shapes=sample_cone,
        surfaces=_ROADS_AND_WALKS,
        set_down=True,
    ),
)
SENTENCE_KINDS: dict[str, SentenceKind] = {
    kind.name: kind for kind in (*_VEHICLES, _PERSON, *_BEHIND_THE_SIDEWALK, *_STREET_FURNITURE, *_SET_DOWN)
}
