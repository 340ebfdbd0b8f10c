"""Checks of a layout. Each finding names the fault, its objects and its size; the layout can still be cast."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from lidardraft.scene.box import Box
from lidardraft.scene.layout import Layout, Primitive, object_of, primitive_mesh
from lidardraft.scene.solids import Solid, Solids, penetration
from lidardraft.semantics import BY_NAME, CLASSES, GROUND

VEHICLE_LABELS = ("car", "truck", "bus", "train", "motorcycle")
EGO_SIZE = (4.5, 2.0, 2.0)  # m around the origin, standing on the road
MAX_RANGE = 210.0  # m, the longest range of the presets, with the far ends of objects at that range
OVERLAP_TOLERANCE = 0.02  # m
GROUND_TOLERANCE = 0.15  # m, a kerb
_LEVEL = 0.01  # m over the bottom of an object: parts as low as that touch the ground, as all legs of an animal do

# Smallest and largest (length, width, height) [m] of each thing class.
SIZE_RANGES = {row.name: row.limits for row in CLASSES if row.limits}


@dataclass(frozen=True, slots=True)
class Finding:
    """One fault: the name of the check, the ids of the primitives, and a sentence with the numbers."""

    check: str
    ids: tuple[str, ...]
    message: str


def check(layout: Layout) -> list[Finding]:
    """The findings of all checks, in the order of CHECKS."""
    return [finding for test in CHECKS for finding in test(layout)]


def overlap(layout: Layout) -> list[Finding]:
    """Parts of different objects that overlap. A mesh counts as its box; ground is left out."""
    standing = {primitive.id: primitive for primitive in layout if primitive.label not in GROUND}
    findings, before = list[Finding](), Solids()
    for solid in map(Solid.from_primitive, standing.values()):
        for other in dict.fromkeys(before.touching(solid)):
            a, b, depth = standing[other.id], standing[solid.id], penetration(other, solid)
            same = object_of(a) == object_of(b) or (a.instance and a.instance == b.instance)
            if depth > OVERLAP_TOLERANCE and not same:
                findings.append(Finding("overlap", (a.id, b.id), f"{a.id} and {b.id} overlap by {depth:.2f} m"))
        before.add(solid)
    return findings


def grounded(layout: Layout) -> list[Finding]:
    """Objects that float over the ground or are sunk into it, measured under the lowest part that fits best."""
    ground = LayoutGround(layout)
    findings = []
    for name, parts in objects(layout).items():
        bottom = min(map(_bottom, parts))
        feet = [part.center[:2] for part in parts if _bottom(part) < bottom + _LEVEL]
        gap = min((bottom - ground.height(x, y) for x, y in feet), key=abs)
        if abs(gap) > GROUND_TOLERANCE:
            state = "floats {:.2f} m over the ground" if gap > 0 else "is sunk {:.2f} m into the ground"
            findings.append(Finding("grounded", tuple(p.id for p in parts), f"{name} {state.format(abs(gap))}"))
    return findings


def on_road(layout: Layout) -> list[Finding]:
    """Vehicles whose middle is not over a primitive labelled road; no findings if the layout has no road.

    Motorcycles may be on sidewalks, and trams have their own tracks.
    """
    road, paved = (LayoutGround(layout, labels=labels) for labels in (("road",), ("road", "sidewalk")))
    if not road.primitives:
        return []
    findings = []
    for box in layout.boxes():
        x, y, _ = box.center
        ground = paved if box.label == "motorcycle" else road
        if box.label in VEHICLE_LABELS and box.label != "train" and ground.at(x, y) is None:
            message = f"{box.id} stands off the road at x = {x:.1f}, y = {y:.1f} m"
            findings.append(Finding("on_road", (box.id,), message))
    return findings


def size(layout: Layout) -> list[Finding]:
    """Things smaller or larger than the limits of their class."""
    return [finding for box in layout.boxes() for finding in _size_of(box)]


def ego_clear(layout: Layout) -> list[Finding]:
    """Primitives inside the ego vehicle, which carries the sensor."""
    ego = Solid.from_primitive(EGO)
    solids = [Solid.from_primitive(primitive) for primitive in layout if primitive.label not in GROUND]
    return [
        Finding("ego_clear", (solid.id,), f"{solid.id} reaches {depth:.2f} m into the ego vehicle")
        for solid in solids
        if (depth := penetration(solid, ego)) > OVERLAP_TOLERANCE
    ]


def in_range(layout: Layout) -> list[Finding]:
    """Objects whose middle is farther away than any sensor reaches."""
    findings = []
    for primitive in layout:
        distance = math.hypot(*primitive.center[:2])
        if primitive.label not in GROUND and distance > MAX_RANGE:
            message = f"{primitive.id} is {distance:.0f} m away; sensors reach {MAX_RANGE:.0f} m"
            findings.append(Finding("in_range", (primitive.id,), message))
    return findings


def numbered(layout: Layout) -> list[Finding]:
    """Things without an instance, which get no box, and instances shared by two classes, which get one box for both."""
    findings = []
    owners: dict[int, Primitive] = {}
    for primitive in layout:
        if BY_NAME[primitive.label].is_thing and primitive.instance == 0:
            message = f"{primitive.id} is a {primitive.label} with instance 0; things have 1 or more"
            findings.append(Finding("numbered", (primitive.id,), message))
        owner = owners.setdefault(primitive.instance, primitive)
        if primitive.instance and owner.label != primitive.label:
            message = f"{owner.id}, a {owner.label}, and {primitive.id}, a {primitive.label}, are both {owner.instance}"
            findings.append(Finding("numbered", (owner.id, primitive.id), message))
    return findings


CHECKS = (overlap, grounded, on_road, size, ego_clear, in_range, numbered)


def objects(layout: Layout) -> dict[str, list[Primitive]]:
    """The parts of each object, ground left out, in the layout's order."""
    parts: dict[str, list[Primitive]] = {}
    for primitive in layout:
        if primitive.label not in GROUND:
            parts.setdefault(object_of(primitive), []).append(primitive)
    return parts


class LayoutGround:
    """The ground surfaces of a layout; the highest counts if several are over a point."""

    def __init__(self, primitives: Iterable[Primitive], labels: Sequence[str] = GROUND) -> None:
        self.primitives = [primitive for primitive in primitives if primitive.label in labels]
        self._meshes = {p.id: primitive_mesh(p) for p in self.primitives if p.shape == "mesh"}

    def at(self, x: float, y: float) -> tuple[float, str] | None:
        """Height [m] and label of the ground at a point, or None if there is none."""
        surfaces = [(height, p.label) for p in self.primitives if (height := self._height_of(p, x, y)) is not None]
        return max(surfaces, default=None)

    def height(self, x: float, y: float) -> float:
        """Height of the ground [m]; 0, the road under the ego, if there is none."""
        surface = self.at(x, y)
        return 0.0 if surface is None else surface[0]

    def _height_of(self, primitive: Primitive, x: float, y: float) -> float | None:
        dx, dy = x - primitive.center[0], y - primitive.center[1]
        if primitive.shape == "mesh":
            mesh = self._meshes[primitive.id]
            return _highest_over(mesh.vertices[mesh.faces], x, y)
        cos, sin = math.cos(primitive.yaw), math.sin(primitive.yaw)
        length, width, height = primitive.size
        inside = abs(cos * dx + sin * dy) <= length / 2 and abs(cos * dy - sin * dx) <= width / 2
        return primitive.center[2] + height / 2 if inside else None


def _highest_over(triangles: np.ndarray, x: float, y: float) -> float | None:
    """The highest z over (x, y) of triangles [F, 3, 3], by barycentric coordinates; None if there is none."""
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    u, v, w = (b - a)[:, :2], (c - a)[:, :2], np.array([x, y]) - a[:, :2]
    area = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    flat = np.abs(area) > 1e-12  # not upright
    area = np.where(flat, area, 1.0)
    s = (w[:, 0] * v[:, 1] - w[:, 1] * v[:, 0]) / area
    t = (u[:, 0] * w[:, 1] - u[:, 1] * w[:, 0]) / area
    over = flat & (s >= -1e-9) & (t >= -1e-9) & (s + t <= 1 + 1e-9)
    if not over.any():
        return None
    return float((a[:, 2] + s * (b - a)[:, 2] + t * (c - a)[:, 2])[over].max())


def _size_of(box: Box) -> Iterator[Finding]:
    smallest, largest = SIZE_RANGES[box.label]
    for name, value, low, high in zip(("length", "width", "height"), box.size, smallest, largest, strict=True):
        if not low - 1e-6 <= value <= high + 1e-6:
            message = f"{box.id} has {name} {value:.2f} m; a {box.label} has {low:g} to {high:g} m"
            yield Finding("size", (box.id,), message)


def _bottom(primitive: Primitive) -> float:
    return primitive.center[2] - primitive.size[2] / 2


EGO = Primitive(shape="box", center=(0.0, 0.0, EGO_SIZE[2] / 2), size=EGO_SIZE, label="car", id="ego")
