"""Depth that agrees with the plane of the road: where road is seen, its pixels say how far away it is."""

from __future__ import annotations

import math

import numpy as np
from scipy import ndimage

from lidardraft.drafting.pinhole import Pinhole
from lidardraft.drafting.road_plane import RoadPlane
from lidardraft.semantics import BY_NAME

# A road that is off its plane by a share of the camera's height looks like depth that is off by that share. In KITTI's
# frames that is 1 % up to 20 m and 1 to 6 % up to 30 m, and networks are off by some percents at any distance.
_TRUSTED = 20.0  # m; out to there the plane counts for more than the network
_LARGEST_ERROR = 0.1  # of depth; what is further off is a slope or no road
_SMOOTH = math.radians(1.5)  # of the correction: errors of networks reach further than this


def corrected_depth(
    depth: np.ndarray, labels: np.ndarray, camera: Pinhole, plane: RoadPlane, camera_height: float
) -> np.ndarray:
    """Depth [H, W] along the axis of the camera, times what brings the road to its plane, the less the further it is.

    Depth and plane are in one unit, of which `camera_height` [m] over the road tells the length.
    What stands on the road takes the correction of the road at its foot: that next below it in the picture.
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
