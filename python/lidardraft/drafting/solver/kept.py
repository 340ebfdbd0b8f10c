"""The parts of a spec that a solved layout does not keep, by its objects: those that can fail without a refusal."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from lidardraft.drafting.solver.scene_spec import ObjectGroup, SceneSpec
from lidardraft.scene.check import objects
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.road import Road

_NO_GAP = 0.5  # m, the largest distance between neighbours without gaps
_OFF = 1.0  # m, the tolerance of a distance from another object


class Stands(NamedTuple):
    """An object from its parts, in the frame of the road [m]: from and to along and across it, and its middle."""

    name: str
    along: tuple[float, float]
    across: tuple[float, float]
    middle: tuple[float, float]
    labels: frozenset[str]

    @classmethod
    def of(cls, name: str, parts: Sequence[Primitive], road: Road) -> Stands:
        """The object of those parts."""
        reach = []
        for part in parts:
            along, across = road.along_across(*part.center[:2])
            yaw = part.yaw - road.at(along, across)[2]
            cos, sin = abs(math.cos(yaw)), abs(math.sin(yaw))
            half = (cos * part.size[0] + sin * part.size[1]) / 2, (sin * part.size[0] + cos * part.size[1]) / 2
            reach.append((along - half[0], along + half[0], across - half[1], across + half[1]))
        low, high = [min(one) for one in zip(*reach, strict=True)], [max(one) for one in zip(*reach, strict=True)]
        middle = (low[0] + high[1]) / 2, (low[2] + high[3]) / 2
        return cls(name, (low[0], high[1]), (low[2], high[3]), middle, frozenset(part.label for part in parts))

    def apart(self, other: Stands) -> tuple[float, float]:
        """Metres between the near sides of the two, and between their middles."""
        gaps = [max(a[0] - b[1], b[0] - a[1], 0.0) for a, b in ((self.along, other.along), (self.across, other.across))]
        return math.hypot(*gaps), math.dist(self.middle, other.middle)


def unkept(spec: SceneSpec, layout: Layout, road: Road, groups: Mapping[str, int]) -> list[str]:
    """A line for each property of a spec's group that its objects in the layout do not have.

    `groups` maps the names of objects to the numbers of their groups.
    """
    placed: dict[int, list[Stands]] = {number: [] for number in range(len(spec.groups))}
    parts = objects(layout)
    for name, number in groups.items():
        placed[number].append(Stands.of(name, parts[name], road))
    return [
        f"{spec.groups[number].words or spec.groups[number].kind!r}: {line}"
        for number, found in placed.items()
        for line in dict.fromkeys(_unkept_of(spec.groups[number], found, placed, road))
    ]


def _unkept_of(
    group: ObjectGroup, found: Sequence[Stands], placed: Mapping[int, list[Stands]], road: Road
) -> Iterator[str]:
    kind = group.record
    if isinstance(group.count, str) and len(found) < (least := getattr(kind.counts, group.count)[0]):
        yield f"there is room for {len(found)} of them, but {group.count} means {least} or more"
    for one in found:
        if group.goes_across and group.surface != "sidewalk" and min(map(abs, one.across)) > road.edge:
            yield f"{one.name} is to cross the road, and is beside it"
        if kind.is_ridden and group.heading != "parked" and "rider" not in one.labels:
            yield f"{one.name} has no rider"
        in_lane = abs(one.middle[1]) < road.edge - road.parking - 0.5 and not (group.lane or road.paved_areas)
        if kind.is_vehicle and group.heading == "parked" and in_lane:
            yield f"{one.name} should be parked, but is in a lane"
        others = [other for number in group.references for other in placed[number]]
        if group.distance is not None and others and not any(_is_at(one, other, group.distance) for other in others):
            yield f"{one.name} is not {group.distance[0]:g} m from its reference"
    gap = max(_gaps(group, found, road), default=0.0)
    if gap > _NO_GAP:
        yield f"there are gaps of up to {gap:.1f} m between them"


def _is_at(one: Stands, other: Stands, distance: tuple[float, float]) -> bool:
    """Whether two objects are at a distance [m], from side to side or from middle to middle."""
    return any(distance[0] - _OFF <= apart <= distance[1] + _OFF for apart in one.apart(other))


def _gaps(group: ObjectGroup, found: Sequence[Stands], road: Road) -> Iterator[float]:
    """The gaps [m] on each side of a row that should have none; those for crossing roads do not count."""
    if not group.is_closed:
        return
    for side in (True, False):
        row = sorted((one for one in found if (one.middle[1] > 0) is side), key=lambda one: one.along)
        for one, after in itertools.pairwise(row):
            middle, gap = (one.along[1] + after.along[0]) / 2, after.along[0] - one.along[1]
            if not road.in_junction(middle, gap / 2):
                yield gap
