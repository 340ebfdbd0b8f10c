"""A vehicle on its wheels: it leans as the ground under them does."""

from __future__ import annotations

import math

import numpy as np

from lidardraft.scene.pose import Place, point_at, upright

_BASE, _TRACK = 2.7, 1.6  # m between axles and between wheels, as is usual for cars
_AHEAD, _LEFT = np.array([1, 1, -1, -1]) * _BASE / 2, np.array([1, -1, 1, -1]) * _TRACK / 2
_LEVEL = 1e-6  # m between the heights of wheels


def wheels_at(place: Place) -> tuple[np.ndarray, np.ndarray]:
    """x and y [m] of the four wheels of a vehicle at a place, each f64 [4]."""
    return point_at(place, _AHEAD, _LEFT)


def on_wheels(center: tuple[float, float, float], yaw: float, heights: np.ndarray) -> np.ndarray:
    """The pose [4, 4] of a vehicle at `center` with that heading [rad]: its x and y axes follow the slopes ahead and to
    the left of the `heights` [4] of the ground [m] under its wheels. On level ground it is upright."""
    if np.ptp(heights) < _LEVEL:
        return upright(center, yaw)
    rise, bank = float(_AHEAD @ heights / (_AHEAD @ _AHEAD)), float(_LEFT @ heights / (_LEFT @ _LEFT))
    forward = np.array([math.cos(yaw), math.sin(yaw), rise])
    left = np.array([-math.sin(yaw), math.cos(yaw), bank])
    forward /= np.linalg.norm(forward)
    up = np.cross(forward, left)
    up /= np.linalg.norm(up)
    pose = np.eye(4)
    pose[:3, :3] = np.stack([forward, np.cross(up, forward), up], axis=1)
    pose[:3, 3] = center
    return pose
