"""The road in a picture: its plane gives the tilt and height of the camera, and the distance of the road."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from lidardraft.drafting.picture.camera import Pinhole
from lidardraft.errors import LayoutError
from lidardraft.semantics import BY_NAME

# Estimates, except for the method: Fischler and Bolles, "Random Sample Consensus", CACM 1981.
FEWEST = 50  # points of ground
_ENOUGH = 0.3  # the least share of the points on the plane
_NEAR = 0.06  # of the camera's height, the tolerance of points on the plane; the scale is not known
_STEEPEST = math.radians(35)  # of the camera against the road
_TRIALS, _TRIED = 300, 4000  # planes, and points that each is tried on
_LEAST_SEEN_OF_ROAD = 200  # points; with fewer of road, sidewalk and terrain count too

# A road off its plane by a share of the camera's height looks like depth that is off by that share. In KITTI's frames
# that is 1 % up to 20 m and 1 to 6 % up to 30 m; networks are off by some percents at any distance.
_TRUSTED = 20.0  # m; up to here the plane counts more than the network
_LARGEST_ERROR = 0.1  # of depth; a larger error is a slope or no road
_SMOOTH = math.radians(1.5)  # of the correction: errors of networks are wider


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class RoadPlane:
    """`level` [3, 3] turns points of the camera's frame so that the road is level and the camera faces +x.

    `height` is that of the camera over the road, in the unit of the points.
    """

    level: np.ndarray
    height: float


def find_road_plane(points: np.ndarray, labels: np.ndarray) -> RoadPlane:
    """The plane with most ground points [N, 3]; x forward, y left, z up. The same points give the same plane.

    Raises `LayoutError` if no ground is seen, or none that is a plane below the camera.
    """
    road = points[labels == BY_NAME["road"].id]
    if len(road) < _LEAST_SEEN_OF_ROAD:
        road = points[np.isin(labels, [BY_NAME[name].id for name in ("road", "sidewalk", "terrain")])]
    if len(road) < FEWEST:
        raise LayoutError(
            f"no ground is visible: {len(road)} points of the picture are road, sidewalk or terrain with a depth, and "
            f"{FEWEST} are needed to find scale and tilt"
        )
    normal, height = _best_of_random_planes(road)
    for _ in range(3):
        on_it = np.abs(road @ normal + height) < _NEAR * height
        if np.count_nonzero(on_it) < _ENOUGH * len(road):
            share = f"{np.count_nonzero(on_it)} of {len(road)} points of the ground"
            raise LayoutError(f"no plane of the ground is found: {share} lie on one; is the depth metric and linear?")
        normal, height = _least_squares(road[on_it])
    forward = np.array([1.0, 0.0, 0.0]) - normal[0] * normal
    forward /= np.linalg.norm(forward)
    return RoadPlane(level=np.stack([forward, np.cross(normal, forward), normal]), height=height)


def _best_of_random_planes(road: np.ndarray) -> tuple[np.ndarray, float]:
    """Unit normal and height of the camera for the plane through three points that is near to most others."""
    rng = np.random.default_rng(0)
    tried = road[rng.choice(len(road), min(_TRIED, len(road)), replace=False)]
    corners = tried[rng.integers(0, len(tried), (_TRIALS, 3))]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = normals / np.maximum(lengths, 1e-12) * np.where(normals[:, 2:] < 0, -1.0, 1.0)
    heights = -(normals * corners[:, 0]).sum(axis=1)
    possible = (lengths[:, 0] > 0) & (normals[:, 2] > math.cos(_STEEPEST)) & (heights > 0)
    if not possible.any():
        raise LayoutError(
            "no plane of the ground is found below the camera; is the depth metric, and the picture upright?"
        )
    normals, heights = normals[possible], heights[possible]
    near = np.abs(tried @ normals.T + heights) < _NEAR * heights
    best = int(np.argmax(near.sum(axis=0)))
    return normals[best], float(heights[best])


def _least_squares(points: np.ndarray) -> tuple[np.ndarray, float]:
    """Unit normal, upwards, and the height over the best fit of a plane z = a x + b y + c."""
    (a, b, c), *_ = np.linalg.lstsq(np.column_stack([points[:, :2], np.ones(len(points))]), points[:, 2], rcond=None)
    length = math.sqrt(a * a + b * b + 1)
    return np.array([-a, -b, 1.0]) / length, float(-c / length)


def corrected_depth(
    depth: np.ndarray, labels: np.ndarray, camera: Pinhole, plane: RoadPlane, camera_height: float
) -> np.ndarray:
    """Depth [H, W] along the axis of the camera, corrected so that the road is on its plane; the correction fades with
    distance.

    Depth and plane are in one unit, whose length follows from `camera_height` [m] over the road. Objects on the road
    get the correction of the road at their foot: the next road pixel below them in the picture.
    """
    up = camera.rays(*np.indices(depth.shape)) @ plane.level[2]
    road = (labels == BY_NAME["road"].id) & (depth > 0) & (up < 0)
    times = np.divide(-plane.height, up * depth, out=np.ones(depth.shape), where=road)
    road &= np.abs(times - 1) < _LARGEST_ERROR
    trusted = _TRUSTED * plane.height / camera_height
    times = 1 + (times - 1) / (1 + (depth / trusted) ** 2)
    width = _SMOOTH * camera.fx
    weight, smooth = (ndimage.gaussian_filter(image, width, truncate=2) for image in (road.astype(float), times * road))
    times = np.divide(smooth, weight, out=np.ones(depth.shape), where=road)
    bottom = len(depth)
    foot = np.minimum.accumulate(np.where(road, np.arange(bottom)[:, None], bottom)[::-1])[::-1]
    at_foot = np.take_along_axis(times, np.minimum(foot, bottom - 1), axis=0)
    corrected: np.ndarray = depth * ndimage.gaussian_filter1d(np.where(foot < bottom, at_foot, 1.0), width, axis=1)
    return corrected
