"""Triangle meshes, and the shapes of a layout as meshes: for preview, export and reference. No rays here."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from os import PathLike

import numpy as np

from lidardraft import _core
from lidardraft.errors import LayoutError
from lidardraft.files import regular_size

_TURNED = 1e-9  # of a polygon's area: rounding may turn a smaller triangle around
_JITTER = 1e-11  # of its extent: the corners of a polygon are off their lines by this when it is cut
_LINE = 1e-12  # m2 of a triangle, per square metre of the mesh's extent; a smaller one is only a line


@dataclass(frozen=True, slots=True, eq=False)
class TriangleMesh:
    """Vertices float64 [V, 3] and triangles uint32 [F, 3]; both read-only, compared by value."""

    vertices: np.ndarray
    faces: np.ndarray

    def __post_init__(self) -> None:
        try:
            vertices = np.array(self.vertices, dtype=np.float64, order="C")
            faces = np.array(self.faces, order="C")
        except (TypeError, ValueError, OverflowError) as error:
            raise LayoutError(f"a mesh needs vertices [V, 3] and faces [F, 3] of numbers: {error}") from None
        if faces.size and faces.dtype.kind not in "iu":
            raise LayoutError(f"faces hold {faces.dtype}; they must be whole numbers, of vertices")
        faces = faces.astype(np.int64)
        if vertices.ndim != 2 or vertices.shape[1] != 3 or faces.ndim != 2 or faces.shape[1] != 3 or not len(faces):
            raise LayoutError(
                f"a mesh needs vertices [V, 3] and at least one face [F, 3]; got {vertices.shape} and {faces.shape}"
            )
        if not np.isfinite(vertices).all():
            bad = np.flatnonzero(~np.isfinite(vertices).all(axis=1))
            raise LayoutError(
                f"vertex {bad[0]} of a mesh is {vertices[bad[0]].tolist()}; every coordinate must be finite"
            )
        if faces.min() < 0 or faces.max() >= len(vertices):
            face = np.flatnonzero(((faces < 0) | (faces >= len(vertices))).any(axis=1))[0]
            raise LayoutError(f"face {face} is {faces[face].tolist()}; the mesh has {len(vertices)} vertices")
        faces = faces.astype(np.uint32)
        vertices.flags.writeable = faces.flags.writeable = False
        object.__setattr__(self, "vertices", vertices)
        object.__setattr__(self, "faces", faces)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, TriangleMesh):
            return NotImplemented
        return np.array_equal(self.vertices, other.vertices) and np.array_equal(self.faces, other.faces)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"TriangleMesh({len(self.vertices)} vertices, {len(self.faces)} faces)"

    @classmethod
    def unchecked(cls, vertices: np.ndarray, faces: np.ndarray) -> TriangleMesh:
        """A mesh of contiguous arrays of the right types, known to be valid, for meshes by the ten thousand."""
        mesh = object.__new__(cls)
        vertices.flags.writeable = faces.flags.writeable = False
        object.__setattr__(mesh, "vertices", vertices)
        object.__setattr__(mesh, "faces", faces)
        return mesh

    def is_closed(self) -> bool:
        """Whether every edge is shared by exactly two triangles, which run along it in opposite directions."""
        corners = self.faces.astype(np.int64)
        start, end = corners.ravel(), np.roll(corners, -1, axis=1).ravel()
        forth, back = start * len(self.vertices) + end, end * len(self.vertices) + start
        edges, count = np.unique(forth, return_counts=True)
        return bool((count == 1).all()) and np.array_equal(edges, np.unique(back))


def unit_vertices(vertices: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Middle [3] and extents [3] of vertices [V, 3], and the vertices scaled so that their box is the unit box."""
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    middle, extent = (low + high) / 2, high - low
    # Clipped for rounding alone: in a mesh that is flat along an axis the extent is as small as the rounding.
    return middle, extent, np.clip((vertices - middle) / np.where(extent > 0, extent, 1.0), -0.5, 0.5)


def has_surface(vertices: np.ndarray, faces: np.ndarray) -> bool:
    """Whether any of the triangles [F, 3] of vertices [V, 3] [m] is more than a point or a line."""
    least = _LINE * max(1.0, float(np.ptp(vertices, axis=0).max())) ** 2
    for some in (faces[:8], faces):  # the first triangles mostly tell
        a, b, c = vertices[some.T]
        (x, y, z), (u, v, w) = (b - a).T, (c - a).T
        if np.abs((y * w - z * v, z * u - x * w, x * v - y * u)).max() > least:
            return True
    return False


def read_obj(path: str | PathLike[str]) -> list[tuple[str, str, TriangleMesh]]:
    """Object name, material name and mesh of each object of a Wavefront OBJ file, in the file's own frame and unit.

    Raises `FormatError` if the file is missing, broken or empty.
    """
    regular_size(path)
    return [
        (name, material, TriangleMesh.unchecked(vertices, triangles_of(vertices, corners, counts).astype(np.uint32)))
        for name, material, vertices, corners, counts in _core.read_obj(path)
    ]


@np.errstate(all="ignore")  # of coordinates too large, which are refused elsewhere
def triangles_of(
    vertices: np.ndarray, corners: np.ndarray, counts: np.ndarray, *, tick: Callable[[], object] = lambda: None
) -> np.ndarray:
    """The triangles int64 [F, 3] of polygons among vertices float64 [V, 3]. `counts`, each 3 or more, are the numbers
    of `corners` of the polygons. N corners become N - 2 triangles; some are lines if corners are collinear.

    A fan around the first corner covers a polygon once if the whole fan turns as the polygon does, by areas along its
    normal (Newell's), and if the polygon does not cross itself. Other polygons, the concave ones, are cut into ears.
    `tick` is called for each of those, and may raise.
    """
    corners, counts = corners.astype(np.int64), counts.astype(np.int64)
    first = np.repeat(np.cumsum(counts) - counts, counts - 2)
    begins = np.cumsum(counts - 2) - (counts - 2)
    step = first + np.arange(len(first)) - np.repeat(begins, counts - 2) + 1
    fans = corners[np.stack([first, step, step + 1], axis=1)]
    if not (counts > 3).any():
        return fans
    a, b, c = vertices[fans.T]
    turns = np.cross(b - a, c - a)
    normals = np.add.reduceat(turns, begins)
    shares = np.einsum("fi,fi->f", turns, np.repeat(normals, counts - 2, axis=0))
    wrong = np.minimum.reduceat(shares, begins) < -_TURNED * (normals**2).sum(axis=1)
    for at, count, normal in zip(begins[wrong].tolist(), counts[wrong].tolist(), normals[wrong], strict=True):
        tick()
        polygon = np.append(fans[at, :2], fans[at : at + count - 2, 2])
        fans[at : at + count - 2] = polygon[_ears(vertices[polygon], normal)]
    return fans


def _ears(polygon: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """The triangles [N - 2, 3] of the corners [N, 3] of a polygon around a normal [3]."""
    from mapbox_earcut import triangulate_float64  # few models need it

    across = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    flat = (polygon - polygon[0]) @ np.stack([across, np.cross(normal, across)], axis=1)
    flat /= np.abs(flat).max()
    # earcut would leave out corners exactly on a line, and with them edges that other faces have.
    flat += _JITTER * np.sin(flat[:, ::-1] / _JITTER**0.5)
    found = triangulate_float64(flat, np.array([len(flat)], dtype=np.uint32)).reshape(-1, 3)
    triangles = np.zeros((len(flat) - 2, 3), dtype=np.int64)  # those without extent are passed over
    triangles[: len(found)] = found
    return triangles


def unit_mesh(shape: str) -> TriangleMesh:
    """The triangles of a box, plane, cylinder or ellipsoid in the unit box; vertices of round shapes are on the
    surface."""
    return _UNIT_MESHES[shape]


def _unit_box() -> TriangleMesh:
    vertices = [(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return TriangleMesh(np.array(vertices), np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]))


def _unit_plane() -> TriangleMesh:
    square = np.array([(-0.5, -0.5, 0.0), (0.5, -0.5, 0.0), (0.5, 0.5, 0.0), (-0.5, 0.5, 0.0)])
    return TriangleMesh(square, np.array([(0, 1, 2), (0, 2, 3)]))


def _unit_cylinder(sides: int = 32) -> TriangleMesh:
    angle = 2 * np.pi * np.arange(sides) / sides
    ring = np.stack([0.5 * np.cos(angle), 0.5 * np.sin(angle), np.full(sides, 0.5)], axis=1)
    vertices = np.concatenate([ring * [1, 1, -1], ring, [[0, 0, -0.5], [0, 0, 0.5]]])
    low, high, bottom, top = np.arange(sides), sides + np.arange(sides), 2 * sides, 2 * sides + 1
    after = np.roll(low, -1)
    faces = np.concatenate(
        [
            np.stack([low, after, after + sides], axis=1),
            np.stack([low, after + sides, high], axis=1),
            np.stack([after, low, np.full(sides, bottom)], axis=1),
            np.stack([high, after + sides, np.full(sides, top)], axis=1),
        ]
    )
    return TriangleMesh(vertices, faces)


def _unit_ellipsoid(rings: int = 16, sides: int = 32) -> TriangleMesh:
    polar = np.pi * np.arange(1, rings) / rings
    angle = 2 * np.pi * np.arange(sides) / sides
    body = 0.5 * np.stack(
        [
            np.outer(np.sin(polar), np.cos(angle)),
            np.outer(np.sin(polar), np.sin(angle)),
            np.outer(np.cos(polar), np.ones(sides)),
        ],
        axis=2,
    ).reshape(-1, 3)
    vertices = np.concatenate([body, [[0, 0, 0.5], [0, 0, -0.5]]])
    north, south = len(body), len(body) + 1
    faces = []
    for side in range(sides):
        after = (side + 1) % sides
        faces.append((north, side, after))
        for ring in range(rings - 2):
            a, b = ring * sides + side, ring * sides + after
            faces += [(a, a + sides, b + sides), (a, b + sides, b)]
        last = (rings - 2) * sides
        faces.append((south, last + after, last + side))
    return TriangleMesh(vertices, np.array(faces))


_UNIT_MESHES = {
    "box": _unit_box(),
    "plane": _unit_plane(),
    "cylinder": _unit_cylinder(),
    "ellipsoid": _unit_ellipsoid(),
}
