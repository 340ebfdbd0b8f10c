"""Objects of every kind, in their smallest and largest extents, built alone."""

import math
from collections import Counter

import numpy as np

from lidardraft import Layout, Primitive, Raycaster
from lidardraft.objects.buildings import STOREY
from lidardraft.objects.cars import BODIES
from lidardraft.objects.kinds import KINDS
from lidardraft.objects.placed_object import PlacedObject
from lidardraft.scene.layout import primitive_mesh
from lidardraft.scene.mesh import TriangleMesh

# Extents (length, width, height) and clearance of each kind [m], from small to large.
SIZES: dict[str, tuple[tuple[float, float, float, float], ...]] = {
    **{name: ((*body.size, 0.0),) for name, body in BODIES.items()},
    "truck": ((5.5, 2.1, 2.6, 0), (7.5, 2.3, 3.0, 0), (12.0, 2.55, 4.0, 0)),
    "trailer_truck": ((15.5, 2.5, 3.7, 0), (16.5, 2.55, 4.0, 0)),
    "bus": ((10.0, 2.5, 3.0, 0), (13.0, 2.55, 3.3, 0)),
    "tram": ((18.0, 2.3, 3.4, 0), (42.0, 2.65, 3.7, 0)),
    "bicycle": ((1.65, 0.5, 1.05, 0), (1.85, 0.65, 1.1, 0)),
    "cyclist": ((1.7, 0.55, 1.6, 0), (1.8, 0.62, 1.85, 0)),
    "motorcycle": ((1.9, 0.7, 1.15, 0), (2.25, 0.9, 1.3, 0)),
    "motorcyclist": ((2.0, 0.75, 1.45, 0), (2.2, 0.85, 1.65, 0)),
    "person": ((0.25, 0.29, 1.05, 0), (0.4, 0.35, 1.3, 0), (0.3, 0.5, 1.8, 0), (0.75, 0.48, 1.75, 0)),
    "house": ((8, 7.5, 5.2, 3.1), (16, 11, 14, 8.9), (8, 11, 8.5, 6.0)),
    "block": ((10, 9, 2 * STOREY + 0.4, 0), (30, 15, 7 * STOREY, 0), (3, 9, 3 * STOREY, 0)),
    "shed": ((2.9, 5.5, 2.4, 0), (25, 9, 5, 0)),
    "tree": ((2.0, 2.0, 4.5, 1.0), (6, 6.4, 9, 2.2), (9, 9, 14, 4), (2, 2, 10, 1.5)),
    "bush": ((0.8, 0.7, 0.5, 0), (4.5, 4, 4, 0)),
    "hedge": ((1.5, 0.6, 0.8, 0), (14, 1.6, 2.4, 0)),
    "grass": ((2, 1, 0.06, 0), (40, 3, 0.5, 0)),
    "lamp": ((0.12, 0.2, 4.0, 0), (0.22, 0.2, 9.0, 0)),
    "pole": ((0.08, 0.2, 0.9, 0), (0.3, 0.3, 8.0, 0)),
    "sign": ((0.12, 0.42, 2.4, 2.0), (0.12, 0.6, 3.4, 2.2), (0.2, 3.0, 4.0, 2.0)),
    "traffic_light": ((0.25, 0.32, 3.3, 2.4), (0.5, 6.0, 5.8, 4.7)),
    "fence": ((1.5, 0.1, 0.8, 0), (14, 0.12, 1.8, 0)),
    "mesh_fence": ((2.0, 0.08, 1.0, 0), (20, 0.1, 2.4, 0)),
    "garden_wall": ((1.5, 0.25, 0.5, 0), (14, 0.3, 1.6, 0)),
    "wall": ((4, 0.2, 1.8, 0), (30, 0.5, 6, 0)),
    "barrier": ((4, 0.3, 0.75, 0), (50, 0.7, 0.75, 0), (30, 0.6, 1.1, 0)),
    "gantry": ((0.6, 9, 7.0, 5.0), (1.0, 24, 8.5, 5.5)),
    "billboard": ((0.3, 3.8, 3.4, 0.8), (0.4, 3.8, 5.4, 2.6)),
    "shelter": ((3.0, 1.3, 2.4, 0), (6.0, 1.8, 2.7, 0)),
    "bin": ((0.58, 0.62, 1.07, 0), (0.4, 0.4, 0.9, 0), (1.1, 1.37, 1.4, 0)),
    "bench": ((1.5, 0.55, 0.8, 0), (2.0, 0.65, 0.9, 0)),
    "cone": ((0.28, 0.28, 0.5, 0), (0.4, 0.4, 0.75, 0)),
    "letterbox": ((0.35, 0.4, 1.2, 0), (0.5, 0.6, 1.6, 0)),
    "hydrant": ((0.35, 0.35, 0.8, 0), (0.45, 0.45, 1.1, 0)),
    "ground_cover": ((0.8, 0.6, 0.12, 0), (3.5, 2.0, 0.4, 0)),
    "overgrown_fence": ((1.5, 0.3, 0.6, 0), (12, 0.9, 2.0, 0)),
    "crate": ((0.3, 0.3, 0.35, 0), (1.2, 0.9, 1.3, 0)),
    "plant_tub": ((0.5, 0.5, 0.7, 0), (1.6, 0.8, 1.6, 0)),
    "cafe_table": ((1.4, 0.7, 0.9, 0), (1.8, 0.9, 0.9, 0)),
    "cabinet": ((0.3, 0.8, 1.0, 0), (0.45, 1.8, 1.6, 0)),
}


def placed(
    kind: str, variant: int = 0, yaw: float = 0.0, at: tuple[float, float, float] = (0.0, 0.0, 0.0)
) -> PlacedObject:
    """An object of a kind in one of its sizes; the first of its instances, if it is counted, is 5."""
    length, width, height, clearance = SIZES[kind][variant % len(SIZES[kind])]
    x, y, z = at
    return PlacedObject(
        kind=kind,
        id=f"{kind}_1",
        x=x,
        y=y,
        z=z,
        level=z,
        yaw=yaw,
        size=(float(length), float(width), float(height)),
        clearance=float(clearance),
        instance=5 if KINDS[kind].instances else 0,
    )


def build(made: PlacedObject, seed: int) -> list[Primitive]:
    return KINDS[made.kind].build(made, np.random.default_rng(seed))


def vertices(primitive: Primitive) -> np.ndarray:
    """Of a primitive at its place, [V, 3]."""
    return primitive_mesh(primitive).vertices


def all_vertices(primitives: list[Primitive]) -> np.ndarray:
    return np.concatenate([vertices(p) for p in primitives])


def is_closed(mesh: TriangleMesh) -> bool:
    """Whether every edge is that of as many triangles one way as the other, where vertices at one place are one."""
    _, welded = np.unique(np.round(mesh.vertices, 9), axis=0, return_inverse=True)
    faces = welded.reshape(-1)[mesh.faces]
    faces = faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]
    edges = Counter(map(tuple, np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]).tolist()))
    return all(edges[(b, a)] == count for (a, b), count in edges.items())


def cast(primitives: list[Primitive], origin: tuple[float, float, float], towards: np.ndarray) -> np.ndarray:
    """The index of the primitive that each ray from a point to points [R, 3] meets; -1 is nothing."""
    origins = np.broadcast_to(np.array(origin, dtype=np.float64), towards.shape)
    return Raycaster(Layout(primitives=tuple(primitives))).cast(origins, towards - origins).primitive


def extinction_along(primitive: Primitive) -> float:
    """The share of rays that end in a medium on their way across its width."""
    assert primitive.extinction is not None
    return 1.0 - math.exp(-primitive.extinction * primitive.size[1])
