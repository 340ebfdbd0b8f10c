"""The compiled core: numpy arrays in, numpy arrays out, the GIL released while it works.

Metres and radians throughout. Arrays must be C-contiguous and of exactly the dtype given; anything else raises
`TypeError`. Values that cannot be a sensor or a scene raise `lidardraft.SensorError` or `lidardraft.LayoutError`.
"""

from os import PathLike
from typing import final

import numpy as np
from numpy.typing import NDArray

@final
class SensorPattern:
    """The map from (row, column) to a ray: H beams by W columns, row 0 the highest beam.

    Beam h starts at (0, 0, origin_heights[h]) of the sensor frame; column w looks to the azimuth
    `azimuth_start - (w + 1/2) * azimuth_span / W + azimuth_offsets[h]`.
    """

    def __new__(
        cls,
        *,
        elevations: NDArray[np.float64],  # [H], rad, strictly decreasing, within (-pi/2, pi/2)
        azimuth_offsets: NDArray[np.float64],  # [H], rad
        origin_heights: NDArray[np.float64],  # [H], m
        columns: int,
        azimuth_start: float,
        azimuth_span: float,  # rad, (0, 2 pi]
        min_range: float,  # m, >= 0; a surface nearer than this is not reported, and hides what is behind it
        max_range: float,  # m, finite
    ) -> SensorPattern: ...
    @property
    def shape(self) -> tuple[int, int]:
        """(H, W)."""
    def directions(self) -> NDArray[np.float64]:
        """Unit ray directions in the sensor frame, [H, W, 3]."""
    def points(self, depth: NDArray[np.float32]) -> NDArray[np.float64]:
        """Sensor-frame points for the distances [H, W] along the rays, [H, W, 3]; the beam origin where depth is 0.

        `SensorError` if the image has another shape, or a distance is negative or not finite.
        """
    def project(self, points: NDArray[np.float64]) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.float32]]:
        """Row, column and distance from the beam's origin of points [N, 3]; row = column = -1, distance 0 outside.

        A point belongs to the beam whose elevation is nearest and to the column whose cell it lies in. Outside means
        out of the azimuth span, further from the highest or lowest beam than half its spacing (that of the columns if
        there is one beam only), not in [min_range, max_range], or not finite. Distances are compared as float32, so
        `points` of an image of this sensor project to the pixels they came from, unless two beams cross there.
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
        # Unit vertices [V, 3] and faces [F, 3] of the shapes that are 4, in their order.
        meshes: list[tuple[NDArray[np.float64], NDArray[np.uint32]]],
    ) -> Scene: ...
    def scan(
        self,
        pattern: SensorPattern,
        world_from_sensor: NDArray[np.float64],  # [4, 4], rigid
    ) -> tuple[NDArray[np.float32], NDArray[np.uint8], NDArray[np.uint32], NDArray[np.int32], NDArray[np.float32]]:
        """The closest hit of every ray: depth, label, instance, primitive index, cosine of incidence, each [H, W].

        No hit within [min_range, max_range] is depth 0, label 0, instance 0, primitive -1, incidence 0. Both sides of
        every surface are seen. Of two hits at the same float32 distance the primitive with the lower index wins. A
        pose that is not rigid raises `LayoutError`. The images are the same for any number of threads.
        """

def read_obj(
    path: str | PathLike[str],
) -> list[tuple[str, str, NDArray[np.float64], NDArray[np.uint32]]]:
    """Object name, material name ("" if none), vertices [V, 3] and triangles [F, 3] of each object in a Wavefront OBJ
    file.

    An object with several materials comes as several entries. Polygons become fans of triangles; shared positions stay
    shared.
    """
