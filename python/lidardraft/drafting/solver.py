"""The solver: a spec and a seed become a layout in which nothing overlaps and everything stands on its ground."""

from __future__ import annotations

import dataclasses
import math
from collections import Counter
from collections.abc import Iterator

import numpy as np

from lidardraft.drafting.object_shapes import ObjectPart
from lidardraft.drafting.road_from_spec import road_from_spec
from lidardraft.drafting.road_zones import RoadPose, Zone, zone_of
from lidardraft.drafting.scene_spec import ObjectGroup, SceneSpec
from lidardraft.drafting.sentence_kinds import SENTENCE_KINDS, SentenceKind
from lidardraft.errors import LayoutError
from lidardraft.scene.check import EGO, LayoutGround, Solid, penetration
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.road import Road
from lidardraft.semantics import BY_NAME

TRIES = 60  # of places for one object
# Estimates of ours.
GAP = 0.25  # m between any two objects
FOLLOWING_GAP = 2.0  # m before and behind whatever drives


def layout_from_spec(spec: SceneSpec, seed: int = 0) -> Layout:
    """A layout that satisfies the spec and passes every check; the same for the same spec and seed.

    Raises `LayoutError` on a seed that is no integer >= 0, and where an object that is asked for finds no room, naming
    how many of how many did.
    """
    if type(seed) is not int or seed < 0:
        raise LayoutError(f"seed is {seed!r}; it must be an integer >= 0")
    rng = np.random.default_rng(seed)
    road = road_from_spec(spec, rng)
    scene = _Scene(road, rng)
    for group in sorted(spec.groups, key=_rank):
        for place in group.places or ("",):
            _fill(scene, spec, group, place)
    return Layout(
        primitives=tuple(scene.primitives), provenance={"source": "spec", "seed": seed, "spec": spec.to_dict()}
    )


def _rank(group: ObjectGroup) -> tuple[bool, bool, int]:
    return group.distance is None, group.spacing is None, -group.record.precedence


def _fill(scene: _Scene, spec: SceneSpec, group: ObjectGroup, place: str) -> None:
    """Place what a group wants at one place; a number is met exactly, a word by at least one."""
    wanted = _count(group, place, scene.rng)
    placed = 0
    for number in range(wanted):
        kind = _kind(group, spec, scene.rng)
        zone = zone_of(group, kind, place, scene.road)
        if any(scene.place(kind, group, pose) for pose in _poses(scene, zone, group, number, wanted)):
            placed += 1
        elif isinstance(group.count, int):
            break
    if placed == 0 or (isinstance(group.count, int) and placed < wanted):
        where = f" at place {place!r}" if place else ""
        asked = wanted if isinstance(group.count, int) else f"{group.count!r}"
        raise LayoutError(f"{group.kind}{where}: {placed} of {asked} found room; ask for fewer or for another place")


def _count(group: ObjectGroup, place: str, rng: np.random.Generator) -> int:
    if isinstance(group.count, int):
        return group.count
    low, high = getattr(group.record.counts, group.count)
    if group.spacing is not None:
        return max(low, min(40, int(100.0 / group.spacing)))
    return int(rng.integers(low, high + 1)) * (1 if place else 2)


def _kind(group: ObjectGroup, spec: SceneSpec, rng: np.random.Generator) -> SentenceKind:
    """The kind of one object of a group: its own, or one of the mix that traffic is."""
    kind = group.record
    if kind.sizes is not None:
        return kind
    mix = [one for one in SENTENCE_KINDS.values() if one.traffic_share and one.name not in spec.absent]
    if group.heading == "parked":  # what a usual parking strip takes
        mix = [one for one in mix if one.parking_width < kind.parking_width]
    if not mix:
        raise LayoutError(f"{kind.name}: every kind of it is absent: {', '.join(spec.absent)}")
    shares = np.array([one.traffic_share for one in mix])
    return SENTENCE_KINDS[str(rng.choice([one.name for one in mix], p=shares / shares.sum()))]


def _poses(scene: _Scene, zone: Zone, group: ObjectGroup, number: int, wanted: int) -> Iterator[RoadPose]:
    """The poses to try in order: in the object's own slot first, then, unless it is bound to it, anywhere."""
    rng = scene.rng
    near, far = zone.span
    step = (far - near) / wanted
    for attempt in range(TRIES):
        if group.spacing is not None:
            along = near + math.copysign(group.spacing, far - near) * (number // zone.sides)
            if abs(along) > scene.road.half_length:
                return
        elif near == far:
            along = near
        elif attempt < TRIES // 4:
            along = near + step * (number + float(rng.uniform(0.25, 0.75)))
        else:
            along = near + (far - near) * float(rng.random())
        yield zone.sample_pose(rng, along, number, attempt / TRIES)


class _Scene:
    """What stands so far, and where there is still room."""

    def __init__(self, road: Road, rng: np.random.Generator) -> None:
        self.road, self.rng = road, rng
        self.primitives = road.surfaces()
        self.ground = LayoutGround(self.primitives)
        self.solids: list[Solid] = [Solid.from_primitive(EGO)]
        self.side_roads = [
            Solid.from_primitive(_raised(p)) for p in self.primitives if p.id in ("road_left", "road_right")
        ]
        self.numbers: Counter[str] = Counter()
        self.instances = 0

    def place(self, kind: SentenceKind, group: ObjectGroup, pose: RoadPose) -> bool:
        """Place one object there if there is room for it."""
        parked = group.heading == "parked"
        parts = kind.sample_parts(self.rng, parked=parked, bent=self.road.curvature != 0.0)
        if "road" not in kind.surfaces and any(_reaches(part, pose.across, self.road) for part in parts):
            return False
        primitives = [self._primitive(kind, part, pose) for part in parts]
        moving = kind.drives and not parked
        wide = [Solid.from_primitive(_widened(p, FOLLOWING_GAP if moving else GAP, GAP)) for p in primitives]
        obstacles = self.solids if moving or kind.walks else self.solids + self.side_roads
        if any(penetration(solid, other) > 0 for solid in wide for other in obstacles):
            return False
        self.numbers[kind.name] += 1
        name = f"{kind.name}_{self.numbers[kind.name]}"
        numbers: dict[str, int] = {}  # a rider and what is ridden are two instances of one name
        for part, primitive in zip(parts, primitives, strict=True):
            if BY_NAME[part.label].is_thing and part.label not in numbers:
                self.instances += 1
                numbers[part.label] = self.instances
            id = f"{name}.{part.name}" if part.name else name
            self.primitives.append(dataclasses.replace(primitive, id=id, instance=numbers.get(part.label, 0)))
        self.solids += map(Solid.from_primitive, primitives)
        return True

    def _primitive(self, kind: SentenceKind, part: ObjectPart, pose: RoadPose) -> Primitive:
        along, across, yaw = pose
        length, width, height = part.size
        dx, dy, dz = part.center
        if kind.follows_road:  # each segment follows the bend, as long as the arc is there
            along, dx, length = along + dx, 0.0, length * (1.0 - self.road.curvature * across)
        x, y, heading = self.road.at(along, across)
        z = self.ground.height(x, y)
        yaw += heading
        cos, sin = math.cos(yaw), math.sin(yaw)
        center = (x + cos * dx - sin * dy, y + sin * dx + cos * dy, z + dz)
        size = (length, width, height)
        return Primitive(shape=part.shape, center=center, size=size, yaw=yaw, label=part.label, id=kind.name)


def _reaches(part: ObjectPart, across: float, road: Road) -> bool:
    """Whether a part that stands beside the road would stand on it; what hangs over it, as a crown does, may."""
    low = part.center[2] - part.size[2] / 2 < 0.5
    return low and abs(across) - part.size[1] / 2 < road.edge


def _widened(primitive: Primitive, ahead: float, aside: float) -> Primitive:
    length, width, height = primitive.size
    return dataclasses.replace(primitive, size=(length + 2 * ahead, width + 2 * aside, height))


def _raised(surface: Primitive) -> Primitive:
    """An obstacle over a surface that has to stay free."""
    return dataclasses.replace(surface, shape="box", size=(*surface.size[:2], 20.0), label="other")
