"""Edits of a recorded scan, as values: objects are inserted, removed, moved and replaced, with their shadows.

An inserted object is cast in detail along the scan's own rays. The layout of the rest of the scan fills the shadow of a
removed one. To undo the last edit, leave it out of the list.
"""

from __future__ import annotations

import itertools
import math
import warnings
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from lidardraft.errors import LayoutError, check_seed, check_type
from lidardraft.json_fields import are_numbers, is_number
from lidardraft.objects.placed_object import Vector
from lidardraft.scene.box import Box
from lidardraft.scene.check import EGO
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.raycast import Hits, Raycaster
from lidardraft.scene.solids import Solid, penetration
from lidardraft.scene.surfaces import Surfaces
from lidardraft.semantics import BY_NAME, CLASSES
from lidardraft.simulation.detail.coarse_object import generator_of
from lidardraft.simulation.recorded.ray_receiver import RayReceiver
from lidardraft.simulation.recorded.recorded_scan import FILLED, INSERTED, RAY_FIELDS, RECORDED, RecordedScan
from lidardraft.simulation.recorded.solid_object import SolidObject

_MARGIN = 0.15  # m around a box: mirrors, and boxes that annotators drew tight
_MOST_OVERLAP = 0.3  # m of boxes, which annotators draw wide
_CLEARANCE = 0.1  # m over the ground, from which an object begins
_ALIKE = 8  # nearest returns of its class from which a filled return draws its intensity
_MOST_INSIDE = 5  # returns of other things in the box of an inserted object
_ROAD, _OTHER = BY_NAME["road"].id, BY_NAME["other"].id
_IS_THING = np.array([row.is_thing for row in CLASSES])


@dataclass(frozen=True)
class Insert:
    """Put an object of a kind (`solid_object.WORDS`) on the ground at `at` (x, y) [m] with a `yaw` [rad] and, if given,
    a `size` (length, width, height) [m]; its id is the kind with the first free number if none is given."""

    kind: str
    at: tuple[float, float]
    yaw: float = 0.0
    size: Vector | None = None
    id: str = ""

    def _apply(self, scan: RecordedScan, *, seed: int) -> RecordedScan:
        id = self.id or _free_id(scan, self.kind)
        solid = SolidObject.of_kind(self.kind, size=self.size, name=id, seed=seed)
        return _with_object(scan, solid, id, self.at, self.yaw, seed)


@dataclass(frozen=True)
class Remove:
    """Take an object away."""

    id: str

    def _apply(self, scan: RecordedScan, *, seed: int) -> RecordedScan:
        return _without_object(scan, scan.box(self.id), seed)


@dataclass(frozen=True)
class Move:
    """Let an object stand on the ground at `to` (x, y) [m], turned to `yaw` [rad] if given. Its returns are made anew:
    the sensor sees another side of it there."""

    id: str
    to: tuple[float, float]
    yaw: float | None = None

    def _apply(self, scan: RecordedScan, *, seed: int) -> RecordedScan:
        box = scan.box(self.id)
        solid = SolidObject.of_class(box.label, box.size, name=box.id, seed=seed)
        yaw = box.yaw if self.yaw is None else self.yaw
        return _with_object(_without_object(scan, box, seed), solid, box.id, self.to, yaw, seed)


@dataclass(frozen=True)
class Replace:
    """Replace an object with one of another kind, with a size of that kind."""

    id: str
    kind: str

    def _apply(self, scan: RecordedScan, *, seed: int) -> RecordedScan:
        box = scan.box(self.id)
        rest = _without_object(scan, box, seed)
        return Insert(self.kind, box.center[:2], box.yaw)._apply(rest, seed=seed)


Edit = Insert | Remove | Move | Replace


def edit_scan(scan: RecordedScan, edits: Iterable[Edit], *, seed: int = 0) -> RecordedScan:
    """The scan with each edit in turn; rays that no edit touches keep their returns.

    The same seed gives the same scan, and an object's random numbers depend on its id alone. Raises `LayoutError` for
    an unknown object or kind, and for a place out of the sensor's range or taken by another object or the vehicle.
    """
    check_type("scan", scan, RecordedScan)
    seed = check_seed(seed)
    for edit in edits:
        check_type("an edit", edit, Insert, Remove, Move, Replace)
        scan = edit._apply(scan, seed=seed)
    return scan


def _free_id(scan: RecordedScan, kind: str) -> str:
    taken = {box.id for box in scan.boxes}
    return next(id for n in itertools.count(1) if (id := f"{kind}_{n}") not in taken)


def _with_object(
    scan: RecordedScan, solid: SolidObject, id: str, at: tuple[float, float], yaw: float, seed: int
) -> RecordedScan:
    if not are_numbers(at, 2) or not is_number(yaw):
        raise LayoutError(f"{id}: place {at!r} and yaw {yaw!r} must be x, y [m] and an angle [rad], all finite")
    instance = int(scan.instance.max(initial=max((box.instance for box in scan.boxes), default=0))) + 1
    number = instance if BY_NAME[solid.label].is_thing else 0
    center = (float(at[0]), float(at[1]), scan.ground_height(*at) + solid.size[2] / 2)
    box = Box(id, solid.label, number, center, solid.size, float(yaw))
    check_room(scan, box)
    standing = scan.points[scan.returned & ~scan.is_ground]
    if (count := int(box.contains(standing, -_MARGIN).sum())) > _MOST_INSIDE:
        warnings.warn(f"{id} stands among {count} returns of something without a box", stacklevel=5)
    return inserted(scan, [(solid, box)], seed)


def check_room(scan: RecordedScan, box: Box) -> None:
    """Raises `LayoutError` if a box is out of the sensor's range, overlaps another one or the recording vehicle, or
    has the id of another."""
    x, y, _ = box.center
    if math.hypot(x, y) > scan.sensor.max_range:
        raise LayoutError(f"{box.id} at {x:g}, {y:g} is {math.hypot(x, y):.0f} m away; {scan.sensor.name} reaches "
                          f"{scan.sensor.max_range:g} m")  # fmt: skip
    if any(other.id == box.id for other in scan.boxes):
        raise LayoutError(f"{box.id}: an object of the scan has this id already")
    ego = replace(EGO, center=(0.0, 0.0, box.center[2]), id="the recording vehicle")
    reach = math.hypot(*box.size[:2]) / 2
    near = [o for o in scan.boxes if math.dist(o.center, box.center) < reach + math.hypot(*o.size) and min(o.size) > 0]
    for other in (ego, *map(_solid, near)):
        depth = penetration(Solid.from_primitive(_solid(box)), Solid.from_primitive(other))
        if depth > _MOST_OVERLAP:
            raise LayoutError(f"{box.id} at {x:g}, {y:g} would overlap {other.id} by {depth:.2f} m")


def _solid(box: Box) -> Primitive:
    return Primitive(shape="box", center=box.center, size=box.size, yaw=box.yaw, label=box.label, id=box.id)


def inserted(scan: RecordedScan, objects: Sequence[tuple[SolidObject, Box]], seed: int) -> RecordedScan:
    """The scan with objects in boxes: rays that hit them return from them, or not at all if the echo is too weak.

    A ray that returned from something before them stays as it is."""
    reach = np.where(scan.returned, scan.distance, np.inf)
    owner, casts = np.full(len(reach), -1), list[tuple[np.ndarray, Hits]]()
    for number, (solid, box) in enumerate(objects):
        near, (x, y, z) = _towards(scan, box), box.center
        place = (x, y, z - box.size[2] / 2)
        hits = solid.cast(place, box.yaw, scan.directions[near], scan.sensor.max_range, seed)
        before = hits.valid & (hits.distance < reach[near])
        near, hits = near[before], hits.keep(before)
        reach[near], owner[near] = hits.distance, number
        casts.append((near, hits))
    kept, found, receiver = np.ones(len(reach), bool), _editable(scan), RayReceiver.of_scan(scan)
    for number, ((solid, box), (near, hits)) in enumerate(zip(objects, casts, strict=True)):
        mine = owner[near] == number
        near, hits = near[mine], hits.keep(mine)
        noise = int(generator_of(seed, box.id).integers(2**31))
        depth, intensity = receiver.report(hits, solid.surfaces, noise)
        _write_returns(found, near, depth, intensity, hits.label, INSERTED)
        found.instance[near] = np.where((depth > 0) & _IS_THING[hits.label], box.instance, 0)
        kept[near[depth == 0]] = False  # stopped without an echo: nothing returns from behind either
    rays = {name: getattr(found, name)[kept] for name in RAY_FIELDS}
    return replace(found, boxes=(*scan.boxes, *(box for _, box in objects)), **rays)


def _without_object(scan: RecordedScan, box: Box, seed: int) -> RecordedScan:
    """The scan without the returns of an object; its rays go on to the layout of the rest behind it."""
    near = _towards(scan, box)
    ground = scan.is_ground[near]
    if not scan.has_classes:  # by height alone, low returns of the object are ground
        ground &= scan.points[near, 2] < scan.ground_height(*box.center[:2]) + _CLEARANCE
    own = (scan.made_up[near] == INSERTED) & (scan.instance[near] == box.instance) & (box.instance > 0)
    own |= box.contains(scan.points[near], _MARGIN)  # the noise of weak echoes goes further
    mine = near[scan.returned[near] & ~ground & own]
    lost = near[~scan.returned[near]]
    length, width, height = (extent + 2 * _MARGIN for extent in box.size)
    wide = replace(_solid(box), size=(length, width, height))
    through = Raycaster(Layout((wide,))).cast(np.zeros(3), scan.directions[lost])
    freed = np.concatenate([mine, lost[through.valid]])
    start = np.concatenate([scan.distance[mine], through.distance[through.valid]])
    rest = np.ones(len(scan.distance), bool)
    rest[mine] = False
    layout, directions = scan.layout(rest), scan.directions[freed]
    hits = Raycaster(layout).cast(directions * start[:, None], directions, seed=seed)
    hits = replace(hits, distance=hits.distance + start)
    behind = hits.valid & (hits.distance < scan.sensor.max_range)
    hits, freed = hits.keep(behind), np.concatenate([freed[behind], freed[~behind]])
    noise = generator_of(seed, f"without {box.id}")
    depth, intensity = RayReceiver.of_scan(scan).report(hits, Surfaces.from_layout(layout), int(noise.integers(2**31)))
    none = np.zeros(len(freed) - len(depth), np.float32)
    label = np.concatenate([hits.label, none.astype(np.uint8)])
    edited = _editable(scan)
    _write_returns(edited, freed, np.concatenate([depth, none]), np.concatenate([intensity, none]), label, FILLED)
    _like_around(edited, np.flatnonzero(rest & scan.returned), freed[: len(depth)][depth > 0], noise)
    return replace(edited, boxes=tuple(other for other in scan.boxes if other.id != box.id))


def _like_around(scan: RecordedScan, known: np.ndarray, filled: np.ndarray, rng: np.random.Generator) -> None:
    """Give each filled return the intensity of one of the nearest returns of its class, and the nearest one's instance.

    Without classes, all ground returns are of one class, and all others of another."""
    from scipy.spatial import cKDTree  # slow to import

    labels = scan.label if scan.has_classes else np.where(scan.is_ground, _ROAD, _OTHER)
    for label in np.unique(scan.label[filled]).tolist():
        alike, here = known[labels[known] == label], filled[scan.label[filled] == label]
        if len(alike) < _ALIKE:
            continue
        _, nearest = cKDTree(scan.points[alike]).query(scan.points[here], k=_ALIKE)
        chosen = nearest[np.arange(len(here)), rng.integers(_ALIKE, size=len(here))]
        scan.intensity[here] = scan.intensity[alike[chosen]]
        scan.instance[here] = scan.instance[alike[nearest[:, 0]]]


def _editable(scan: RecordedScan) -> RecordedScan:
    return replace(scan, **{name: getattr(scan, name).copy() for name in RAY_FIELDS})


def _write_returns(
    scan: RecordedScan, which: np.ndarray, depth: np.ndarray, intensity: np.ndarray, label: np.ndarray, mark: int
) -> None:
    """Let the rays `which` return from `depth` [m], or not return if that is 0."""
    there = depth > 0
    directions = scan.points[which] / np.where(scan.returned[which], scan.distance[which], 1.0)[:, None]
    scan.points[which] = directions * np.where(there, depth, 1.0)[:, None]
    scan.distance[which] = depth
    scan.intensity[which] = np.where(there, intensity, 0.0)
    scan.label[which] = np.where(there, label, 0)
    scan.instance[which] = 0
    scan.made_up[which] = np.where(there, mark, RECORDED)


def _towards(scan: RecordedScan, box: Box) -> np.ndarray:
    """The indices of rays that pass near a box: those in the cone around a sphere around it."""
    center = np.array(box.center)
    away, radius = float(np.linalg.norm(center)), float(np.linalg.norm(box.size)) / 2 + 2 * _MARGIN
    if away <= radius:
        return np.arange(len(scan.distance))
    return np.flatnonzero(scan.directions @ (center / away) > math.sqrt(1.0 - (radius / away) ** 2))
