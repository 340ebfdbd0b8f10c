"""A vehicle on its wheels: it leans as the ground under them does, and its body sways on the springs."""

from __future__ import annotations

import math

import numpy as np

from lidardraft.scene.pose import Place, point_at, upright

_BASE, _TRACK = 2.7, 1.6  # m between axles and between wheels, as is usual for cars
_AHEAD, _LEFT = np.array([1, 1, -1, -1]) * _BASE / 2, np.array([1, -1, 1, -1]) * _TRACK / 2
_LEVEL = 1e-6  # m between the heights of wheels
# Roll and pitch of a body by the roughness of roads: an estimate. Cars bounce 0.7 to 2 times a second on their springs.
ROAD_NOISE = 0.003  # rad, deviation
_BOUNCES, _WAVES, _FULL_SPEED = (0.7, 2.0), 4, 10.0  # Hz; waves of each angle; m/s at which it has that deviation


def wheels_at(place: Place) -> tuple[np.ndarray, np.ndarray]:
    """x and y [m] of the four wheels of a vehicle at a place, each f64 [4]."""
    return point_at(place, _AHEAD, _LEFT)


def on_wheels(center: tuple[float, float, float], yaw: float, heights: np.ndarray) -> np.ndarray:
    """The pose [4, 4] of a vehicle at `center` with that heading [rad]: its x and y axes follow the slopes ahead and to
    the left of the `heights` [4] of the ground [m] under its wheels. On level ground it is upright."""
    if is_level(heights):
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


def is_level(heights: np.ndarray) -> bool:
    """Whether ground of these heights [m] is one horizontal plane."""
    return bool(np.ptp(heights) < _LEVEL)


def leaning(roll: float, pitch: float) -> np.ndarray:
    """The pose [4, 4] of a body that leans by these angles [rad] against its wheels."""
    about_x = np.array([[1, 0, 0], [0, math.cos(roll), -math.sin(roll)], [0, math.sin(roll), math.cos(roll)]])
    about_y = np.array([[math.cos(pitch), 0, math.sin(pitch)], [0, 1, 0], [-math.sin(pitch), 0, math.cos(pitch)]])
    pose = np.eye(4)
    pose[:3, :3] = about_y @ about_x
    return pose


def sway(time: float, speed: float, seed: int) -> np.ndarray:
    """The pose [4, 4] of a body that sways on its springs, at a `time` [s], by the roughness of the road at a `speed`
    [m/s]."""
    rng = np.random.default_rng([seed, _WAVES])
    turns = rng.uniform(0.0, 1.0, (2, _WAVES)) + rng.uniform(*_BOUNCES, (2, _WAVES)) * time
    deviation = ROAD_NOISE * min(abs(speed) / _FULL_SPEED, 1.0)
    roll, pitch = (deviation * math.sqrt(2 / _WAVES) * np.sin(math.tau * turns).sum(axis=1)).tolist()
    return leaning(roll, pitch)
