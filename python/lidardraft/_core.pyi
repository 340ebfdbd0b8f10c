"""The compiled core: numpy arrays in, numpy arrays out, the GIL released while it works.

Metres and radians throughout. Arrays must be C-contiguous and of exactly the dtype given; anything else raises
`TypeError`, and so do output arrays that are read-only or share memory. Invalid values of a sensor or a scene raise
`lidardraft.SensorError` or `lidardraft.LayoutError`, other ones `lidardraft.LidarDraftError`. Everything is checked
before anything is written.

`threads` is the largest number of threads of a call, 0 to 1024; 0 is the number of cores (`RAYON_NUM_THREADS`). Results
are the same bit for bit for any number.

`seed`, 0 or more, decides how far rays travel in media. The free path of a ray in a primitive is a pure function of the
seed, the primitive's index (or its number in `media`), its place, and the row and column of the ray. Rays of a scan
that pass near each other have similar free paths.
"""

from math import inf
from os import PathLike
from typing import final

import numpy as np
from numpy.typing import NDArray

from lidardraft.scene import sensor_model
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.surfaces import Surfaces

DEBUG: bool  # whether this is a debug build: correct, and many times slower

def backends() -> list[str]:
    """The backends that this machine can cast scans with, the fastest first: some of "avx512", "avx2", "portable", and
    always "reference".
    """

@final
class SensorPattern:
    """The map from (row, column) to a ray: H beams by W columns, row 0 the highest beam.

    Column w of beam h has the azimuth `azimuth_start - (w + 1/2) * azimuth_span / W + azimuth_offsets[h]`, and
    starts at `origins[h]` turned about z by that azimuth: the lasers turn with the head.
    """

    def __new__(
        cls,
        *,
        elevations: NDArray[np.float64],  # [H], rad, strictly decreasing, within (-pi/2, pi/2)
        azimuth_offsets: NDArray[np.float64],  # [H], rad
        origins: NDArray[np.float64],  # [H, 3], m: forward, to the left and up, relative to the beam's own azimuth
        columns: int,
        azimuth_start: float,
        azimuth_span: float,  # rad, (0, 2 pi]
        min_range: float,  # m, >= 0; a nearer surface is not reported, but occludes others
        max_range: float,  # m, finite
    ) -> SensorPattern: ...
    @property
    def shape(self) -> tuple[int, int]:
        """(H, W)."""
    def directions(self) -> NDArray[np.float64]:
        """Unit ray directions in the sensor frame, [H, W, 3]."""
    def origins(self) -> NDArray[np.float64]:
        """The origin of each ray in the sensor frame, [H, W, 3]."""
    def points(self, depth: NDArray[np.float32]) -> NDArray[np.float64]:
        """Sensor-frame points for the distances [H, W] along the rays, [H, W, 3]; the beam origin for depth 0.

        Raises `SensorError` if the image has another shape, or a distance is negative or not finite.
        """
    def project(self, points: NDArray[np.float64]) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.float32]]:
        """Row, column and distance from the beam's origin of points [N, 3]; row = column = -1, distance 0 outside.

        A point belongs to the beam with the nearest elevation, each relative to its own origin, and to the column whose
        cell it is in. A point is outside if it is nearer to the axis than any beam can reach, out of the azimuth span,
        not in [min_range, max_range], or not finite. It is also outside if it is further from the highest or lowest
        beam than half its spacing (that of the columns for a single beam). Distances are compared as float32, so
        `points` of an image of this sensor project to their own pixels, unless two beams cross there.
        """

@final
class Scene:
    """Shapes with class and instance, compiled for casting.

    Every shape is a unit shape (the box [-1/2, 1/2]^3, the ball, cylinder or mesh in it, or its square z = 0) scaled by
    `sizes`, turned by `yaws` about z and moved to `centers`.
    """

    def __new__(
        cls,
        *,
        shapes: NDArray[np.uint8],  # [P]: 0 box, 1 ellipsoid, 2 cylinder (axis z), 3 plane, 4 mesh
        centers: NDArray[np.float64],  # [P, 3], m
        sizes: NDArray[np.float64],  # [P, 3], m, full extents; z is 0 for a plane
        yaws: NDArray[np.float64],  # [P], rad
        labels: NDArray[np.uint8],  # [P]
        instances: NDArray[np.uint32],  # [P]
        # Unit vertices [V, 3] and faces [F, 3] of the meshes, in their order.
        meshes: list[tuple[NDArray[np.float64], NDArray[np.uint32]]],
        # [P], 1/m, 0 for solids; None if all are. A ray interacts with a medium after an exponential free path of mean
        # 1 / extinction, or leaves it. Planes and open meshes cannot be media.
        extinctions: NDArray[np.float64] | None = None,
        # [P], replaces the primitive's index in the function of free paths
        media: NDArray[np.uint32] | None = None,
    ) -> Scene: ...
    @staticmethod
    def joined(
        scenes: list[Scene], primitives: list[NDArray[np.uint32]], origin: tuple[float, float, float] | None
    ) -> Scene:
        """One scene of some `primitives` of each of `scenes`, in that order, as if compiled from them.

        Meshes are shared, and so is everything else of scenes with this `origin`, by default the middle of the
        original places of all primitives. An index out of range raises `LayoutError`.
        """
    @property
    def origin(self) -> tuple[float, float, float]:
        """The point of the world around which the scene is most precise."""
    def moved(self, primitives: NDArray[np.uint32], world_from_primitive: NDArray[np.float64]) -> Scene:
        """The same scene with primitives [M] at other poses [M, 4, 4] of their own frames (middle, axes), rigid; they
        may be tilted.

        Nothing else is compiled again: meshes are shared with the old scene, which stays unchanged. An index out of
        range, a repeated one, or a pose that is not rigid raises `LayoutError`.
        """
    def scan(
        self,
        pattern: SensorPattern,
        world_from_sensor: NDArray[np.float64],  # [N, K, 4, 4], rigid; K is 1, or W: one for each column
        *,
        # Written in place; the last three may be left out.
        depth: NDArray[np.float32],  # [N, H, W], m along the ray
        label: NDArray[np.uint8],  # [N, H, W]
        instance: NDArray[np.uint32],  # [N, H, W]
        primitive: NDArray[np.int32] | None = None,  # [N, H, W], index in the scene
        incidence: NDArray[np.float32] | None = None,  # [N, H, W], cosine between ray and normal, 0 to 1
        normal: NDArray[np.float32] | None = None,  # [N, H, W, 3], unit, in the world, turned towards the sensor
        seed: int = 0,  # of the first scan; scan k has the seed `seed` + k
        threads: int = 0,
        backend: str | None = None,  # one of `backends()`; None is the fastest
    ) -> None:
        """Write the closest hit of every ray of N scans.

        No hit within [min_range, max_range] is depth 0, label 0, instance 0, primitive -1, incidence 0, normal 0. Both
        sides of every surface count. Of two hits at the same float32 distance the primitive with the lower index
        wins. A first interaction with a medium has incidence 1 and a normal back along the ray. A pose that is not
        rigid raises `LayoutError`, images of another shape `SensorError`.
        """
    def cast(
        self,
        origins: NDArray[np.float64],  # [R, 3], m
        directions: NDArray[np.float64],  # [R, 3], of any length but 0
        *,
        max_range: float = inf,  # m, greater than 0
        seed: int = 0,  # ray i is in row i // 16384 and column i % 16384
        threads: int = 0,
    ) -> tuple[NDArray[np.float32], NDArray[np.uint8], NDArray[np.uint32], NDArray[np.int32], NDArray[np.float32]]:
        """The closest hit of any rays: distance [m], label, instance, primitive, each [R], and the unit normal turned
        towards the origin, [R, 3].

        No hit is 0 in all of them and -1 in primitive. Values that are not finite and directions of length 0 raise
        `LayoutError`.
        """

@final
class Cloud:
    """The points of a scan, N of them, finite, and the rays to them from one place.

    They are in a frame with z up whose z axis passes through the sensor. Columns with more or fewer than N entries
    raise `LayoutError`. A box is a row of 7 numbers: its center, its size along its yaw, across and up [m], its yaw.
    """

    def __new__(
        cls,
        points: NDArray[np.float64],  # [N, 3], m
        *,
        origin: tuple[float, float, float],
        most_rays: int,  # evenly chosen, with which shapes should agree; `passed` uses all
    ) -> Cloud: ...
    def ground(self, labels: NDArray[np.uint8], classes: list[int]) -> HeightField:
        """The ground, from the points whose labels [N] are of some classes."""
    def passed(
        self, weights: NDArray[np.float64], cores: NDArray[np.float64], boxes: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """The number of rays, weighted by `weights` [N], that go through each of `cores` [B, 7] and end behind or below
        it. Rays that end over its box, of `boxes` [B, 7], above the core's bottom are not counted.
        """
    def refined(
        self,
        *,
        clusters: NDArray[np.uint32],  # [N], the number of each point's cluster, from 1; 0 is left out
        crowns: NDArray[np.bool_],  # [N], True for clusters that become ellipsoids, else boxes
        boxes: NDArray[np.float64],  # [P, 7], objects that stay whole
        posts: NDArray[np.bool_],  # [P], True for cylinders
        ground: HeightField,
        most_pieces: int,
        least_length: float,  # m; shorter pieces are not halved
        worth: float,  # returns; nor are pieces that are wrong for fewer
        grounded: bool,  # whether all pieces reach the ground: none is stacked, and none left out
    ) -> tuple[NDArray[np.uint32], NDArray[np.float64]]:
        """The pieces of clusters, halved until their cast agrees with the points: the cluster [Q] and box [Q, 7] of
        each, cluster by cluster.
        """

@final
class HeightField:
    """The ground under a cloud: one height field in several classes, on a grid of cells of 1 m."""

    def heights(self, places: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Heights [N] at places [N, 2], also unseen ones, and the distances to the nearest seen ground [m]; 0 and inf
        without ground."""
    def grid(self) -> tuple[tuple[int, int], NDArray[np.float64], NDArray[np.uint8]]:
        """The first cell, in cells from x = y = 0; the heights of the corners [X + 1, Y + 1], NaN without ground; the
        classes of the cells [X, Y], 0 without ground.
        """

def cluster(
    points: NDArray[np.float64], *, reach: float, per_range: float, min_points: int
) -> list[NDArray[np.uint32]]:
    """DBSCAN: the indices of the points [N, 3] of each cluster, in order, the largest cluster first.

    Two points are neighbours within the mean of their reaches: `reach` [m] and `per_range` (less than 0.1) of the
    distance from x = y = 0. A cluster grows from points with `min_points` neighbours, themselves among them. Points
    closer than a quarter of the reach are searched as one.
    """

def fit_box(points: NDArray[np.float64], outliers: float) -> list[float]:
    """The box [7] around points [N, 3] whose sides fit them most closely; yaw is 0 to pi / 2.

    `outliers` is the share of the points at either end of an extent that are strays.
    """

def read_obj(
    path: str | PathLike[str],
) -> list[tuple[str, str, NDArray[np.float64], NDArray[np.uint32], NDArray[np.uint32]]]:
    """For each object in a Wavefront OBJ file: object name, material name ("" if none), vertices [V, 3], the corners of
    all faces in order, and the number of corners of each face.

    An object with several materials comes as several entries; shared positions stay shared.
    """

def lay(
    mesh: tuple[NDArray[np.float64], NDArray[np.uint32]],
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    heights: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.uint32]]:
    """Vertices [U, 3] and triangles [G, 3] of a mesh, vertices [V, 3] and triangles [F, 3], that is cut where the lines
    x [X] and y [Y] and the diagonals between them lie, and raised by their `heights` [X, Y]."""

@final
class SensorModel:
    """The effects of one unit of a sensor, checked: `SensorError` names an invalid number, and its limit.

    `numbers` is read by its attributes; the sub-rays of a beam have `shares` [S], 1 to 32, of its power.
    """

    def __new__(cls, numbers: sensor_model.SensorModel, shares: list[float]) -> SensorModel: ...
    @property
    def pulse_length(self) -> float:
        """The distance [m] below which echoes merge."""

def observe(
    image: RangeImage,  # of the sub-rays, [H * S, W]: row h * S + s is sub-ray s of beam h; with primitive, incidence
    surfaces: Surfaces,
    *,
    rays: SensorPattern,  # of the sub-rays
    poses: NDArray[np.float64],  # world_from_sensor [1, K, 4, 4], K is 1 or W
    pattern: SensorPattern,
    range_sigma: float,  # m, noise of strong echoes
    model: SensorModel,
    extinction: float = 0.0,  # 1/m, of the air
    # Range and response of particles in the air in front of each surface, f32 [H, W]; 0 for none.
    backscatter: list[tuple[NDArray[np.float32], NDArray[np.float32]]] = ...,
    scan: RangeImage,  # [H, W], with primitive, incidence and intensity: written in place
    seed: int = 0,
    threads: int = 0,
) -> None:
    """Write the scan that a sensor reports from clean returns.

    All random values are pure functions of the seed, the row and the column; those of the sensor's unit are functions
    of `model.unit`. Images of another size, and a primitive that `surfaces` lacks, raise `SensorError`.
    """
