"""What the benchmarks cast: three scenes, one scan pattern, and a car that drives through them.

Everything is made from fixed seeds, in metres and radians, z up, the ground around z = 0. Every body comes twice: as
the shape it is, and as the triangles that a mesh caster needs. Body k has instance k, so that the index of what was
hit is its instance.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np

MAX_RANGE = 120.0  # m
SENSOR_HEIGHT = 1.73  # m


@dataclass(frozen=True)
class Body:
    """A "plane", "cuboid", "ellipsoid" or "mesh", and its triangles: verts f32 [V, 3] in the world, faces [F, 3].

    `half` holds half extents or radii [m], along axes turned by `yaw` about z.
    """

    kind: str
    center: tuple[float, float, float]
    half: tuple[float, float, float]
    yaw: float
    semantic: int
    instance: int
    verts: np.ndarray
    faces: np.ndarray


@dataclass(frozen=True)
class Scene:
    """Bodies, and all their triangles in one mesh."""

    name: str
    primitives: tuple[Body, ...]

    @cached_property
    def verts(self) -> np.ndarray:
        """float32 [V, 3]"""
        return np.concatenate([body.verts for body in self.primitives])

    @cached_property
    def faces(self) -> np.ndarray:
        """uint32 [F, 3]"""
        first = np.cumsum([0] + [len(body.verts) for body in self.primitives])
        faces = [body.faces + start for body, start in zip(self.primitives, first[:-1], strict=True)]
        return np.concatenate(faces).astype(np.uint32)

    @cached_property
    def instance_of_face(self) -> np.ndarray:
        """int32 [F + 1]; the last entry is that of a miss, -1."""
        counts = [len(body.faces) for body in self.primitives]
        return np.append(np.repeat([body.instance for body in self.primitives], counts), -1).astype(np.int32)

    @cached_property
    def semantic_of_face(self) -> np.ndarray:
        """uint8 [F + 1]; the last entry is that of a miss, 0."""
        counts = [len(body.faces) for body in self.primitives]
        return np.append(np.repeat([body.semantic for body in self.primitives], counts), 0).astype(np.uint8)

    def images(self, distance: np.ndarray, face: np.ndarray, shape: tuple[int, int]) -> tuple[np.ndarray, ...]:
        """Range f32, semantic u8 and instance i32 [H, W] from distances and hit faces, H * W each; any face out of
        the mesh, or a distance beyond `MAX_RANGE`, is a miss: 0, 0 and -1."""
        hit = (face < len(self.faces)) & (face >= 0) & (distance <= MAX_RANGE)
        index = np.where(hit, face, len(self.faces))
        depth = np.where(hit, distance, np.float32(0))
        images = depth, self.semantic_of_face.take(index), self.instance_of_face.take(index)
        return tuple(image.reshape(shape) for image in images)


@dataclass(frozen=True)
class Pattern:
    """A scan grid: elevation [H] and azimuth [W] of the rays, row 0 the highest beam, azimuth decreasing."""

    elevation: np.ndarray
    azimuth: np.ndarray

    @property
    def shape(self) -> tuple[int, int]:
        """(H, W)"""
        return len(self.elevation), len(self.azimuth)

    @cached_property
    def directions(self) -> np.ndarray:
        """Unit vectors in the sensor frame, float32 [H * W, 3], row by row."""
        flat, up = np.cos(self.elevation)[:, None], np.sin(self.elevation)[:, None]
        rays = [flat * np.cos(self.azimuth), flat * np.sin(self.azimuth), up + 0 * self.azimuth]
        return np.stack(rays, axis=-1).reshape(-1, 3).astype(np.float32)

    def rays(self, world_from_sensor: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Origin float32 [3] and directions float32 [H * W, 3] in the world, as a careful user of numpy makes them."""
        rotation = world_from_sensor[:3, :3].astype(np.float32)
        return world_from_sensor[:3, 3].astype(np.float32), self.directions @ rotation.T


def hdl64(beams: int = 64, columns: int = 1024) -> Pattern:
    """Beams from +3 to -25 degrees in equal steps by columns around the car, the seam behind it."""
    azimuth = np.pi - (np.arange(columns) + 0.5) * (2 * np.pi / columns)
    return Pattern(np.radians(np.linspace(3.0, -25.0, beams)), azimuth)


def pose(step: float) -> np.ndarray:
    """world_from_sensor [4, 4] of a car that drives a slow circle of 2 m and turns faster than it drives."""
    return _poses(np.array([float(step)]))[0]


def poses(first: int, count: int) -> np.ndarray:
    """world_from_sensor [N, 4, 4] of `count` steps."""
    return _poses(first + np.arange(float(count)))


def column_poses(step: float, columns: int) -> np.ndarray:
    """world_from_sensor [W, 4, 4] while one scan is taken: the car gets a tenth of a step further."""
    return _poses(step + 0.1 * np.arange(columns) / columns)


def _poses(step: np.ndarray) -> np.ndarray:
    yaw, along = 0.41 * step, 0.17 * step
    cos, sin, zero, one = np.cos(yaw), np.sin(yaw), np.zeros_like(yaw), np.ones_like(yaw)
    place = [2 * np.cos(along), 2 * np.sin(along), SENSOR_HEIGHT * one]
    rows = [
        [cos, -sin, zero, place[0]],
        [sin, cos, zero, place[1]],
        [zero, zero, one, place[2]],
        [zero, zero, zero, one],
    ]
    return np.ascontiguousarray(np.moveaxis(np.array(rows), 2, 0))


def small() -> Scene:
    """A ground and 30 boxes."""
    draw = np.random.default_rng(11)
    return Scene("small", (_ground(), *_boxes(draw, 30, first=1, reach=(7.0, 60.0))))


def street() -> Scene:
    """A ground, 200 boxes, and 100 ellipsoids of 320 triangles."""
    draw = np.random.default_rng(12)
    boxes = _boxes(draw, 200, first=1, reach=(7.0, 90.0))
    return Scene("street", (_ground(), *boxes, *_ellipsoids(draw, 100, first=201, reach=(7.0, 90.0), splits=2)))


def heavy() -> Scene:
    """A terrain of 720,000 triangles, and 220 ellipsoids of 1,280 triangles."""
    draw = np.random.default_rng(13)
    return Scene("heavy", (_terrain(draw, 600), *_ellipsoids(draw, 220, first=1, reach=(8.0, 110.0), splits=3)))


SCENES: dict[str, Callable[[], Scene]] = {"small": small, "street": street, "heavy": heavy}


def _ground(half: float = 200.0) -> Body:
    corners = np.array([(-half, -half, 0), (half, -half, 0), (half, half, 0), (-half, half, 0)], dtype=np.float32)
    return Body("plane", (0.0, 0.0, 0.0), (half, half, 0.0), 0.0, 1, 0, corners, np.array([(0, 1, 2), (0, 2, 3)]))


def _boxes(draw: np.random.Generator, count: int, first: int, reach: tuple[float, float]) -> list[Body]:
    unit, faces = _unit_cube()
    half = draw.uniform((0.4, 0.4, 0.4), (3.5, 2.0, 3.0), (count, 3))
    return _bodies("cuboid", unit, faces, _places(draw, count, reach), half, half[:, 2], draw, first)


def _ellipsoids(
    draw: np.random.Generator, count: int, first: int, reach: tuple[float, float], splits: int
) -> list[Body]:
    unit, faces = _unit_ball(splits)
    half = draw.uniform((0.4, 0.4, 0.6), (2.2, 2.2, 3.5), (count, 3))
    height = half[:, 2] * draw.uniform(0.8, 1.3, count)
    return _bodies("ellipsoid", unit, faces, _places(draw, count, reach), half, height, draw, first)


def _places(draw: np.random.Generator, count: int, reach: tuple[float, float]) -> np.ndarray:
    """Points [N, 2] spread evenly over the ring between the two radii."""
    radius = np.sqrt(draw.uniform(reach[0] ** 2, reach[1] ** 2, count))
    angle = draw.uniform(0, 2 * np.pi, count)
    return radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def _bodies(
    kind: str,
    unit: np.ndarray,
    faces: np.ndarray,
    place: np.ndarray,
    half: np.ndarray,
    height: np.ndarray,
    draw: np.random.Generator,
    first: int,
) -> list[Body]:
    bodies = []
    for k, yaw in enumerate(draw.uniform(-np.pi, np.pi, len(half)).tolist()):
        turn = np.array([[np.cos(yaw), -np.sin(yaw), 0], [np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]])
        center = np.append(place[k], height[k])
        verts = (unit * half[k] @ turn.T + center).astype(np.float32)
        semantic = 2 + (first + k) % 8
        body = Body(kind, tuple(center.tolist()), tuple(half[k].tolist()), yaw, semantic, first + k, verts, faces)
        bodies.append(body)
    return bodies


def _unit_cube() -> tuple[np.ndarray, np.ndarray]:
    """The cube [-1, 1]^3 as 12 triangles; corner 4 i + 2 j + k stands at (±1, ±1, ±1)."""
    corners = np.stack(np.meshgrid(*[(-1.0, 1.0)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return corners, np.array([face for a, b, c, d in quads for face in ((a, b, c), (a, c, d))])


@cache
def _unit_ball(splits: int) -> tuple[np.ndarray, np.ndarray]:
    """An icosahedron whose faces are cut in four `splits` times, every vertex on the unit sphere."""
    golden = (1 + 5**0.5) / 2
    verts = np.array([np.roll((0.0, a, b * golden), axis) for axis in range(3) for a in (-1, 1) for b in (-1, 1)])
    # The faces are the twenty triples of vertices that are one edge, of length 2, apart.
    near = np.linalg.norm(verts[:, None] - verts, axis=2) < 2.1
    a, b, c = np.nonzero(near[:, :, None] & near[None] & near[:, None])
    faces = np.stack([a, b, c], axis=1)[(a < b) & (b < c)]
    verts /= np.linalg.norm(verts, axis=1, keepdims=True)
    for _ in range(splits):
        # Each edge is cut once, also where two faces share it.
        edges = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
        edges, which = np.unique(edges, axis=0, return_inverse=True)
        middle = verts[edges].sum(axis=1)
        ab, bc, ca = (len(verts) + which.reshape(-1, 3)).T
        a, b, c = faces.T
        verts = np.concatenate([verts, middle / np.linalg.norm(middle, axis=1, keepdims=True)])
        faces = np.stack([(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]).transpose(0, 2, 1).reshape(-1, 3)
    return verts, faces


def _terrain(draw: np.random.Generator, cells: int, half: float = 150.0) -> Body:
    """Rolling hills with a rough surface, flat where the car drives: cells x cells squares of two triangles."""
    side = np.linspace(-half, half, cells + 1)
    x, y = np.meshgrid(side, side)
    z = np.zeros_like(x)
    for _ in range(24):
        along, across = draw.uniform(-0.12, 0.12, 2)
        z += draw.uniform(0.02, 0.25) * np.sin(along * x + across * y + draw.uniform(0, 2 * np.pi))
    z = z * np.minimum(np.hypot(x, y) / 30.0, 1.0) + draw.normal(0.0, 0.01, z.shape)
    verts = np.stack([x, y, z], axis=-1).reshape(-1, 3).astype(np.float32)
    corner = np.arange((cells + 1) ** 2).reshape(cells + 1, -1)
    a, b, c, d = (part.ravel() for part in (corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1]))
    faces = np.stack([a, b, c, a, c, d], axis=1).reshape(-1, 3)
    return Body("mesh", (0.0, 0.0, 0.0), (half, half, float(np.abs(z).max())), 0.0, 1, 0, verts, faces)
