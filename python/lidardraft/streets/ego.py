"""Where the ego vehicle is, how fast, and how its sensor stands over the road there."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from lidardraft.errors import LayoutError
from lidardraft.scene.sensor import Sensor
from lidardraft.streets.placement.lanes import Lane
from lidardraft.streets.placement.occupancy import Occupancy

EGO_SIZE = (4.5, 2.2, 1.6)  # m that stay free around the ego vehicle
_WHEELS = (2.7, 1.6)  # m, usual wheelbase and track of a car
_NEAR = 0.45  # share of the reach in which the ego vehicle stays
# How often a place in a lane is taken, against one of the road itself, and how often the ego vehicle stands there:
# estimates of ours.
_LIKELY = {"road": 1.0, "arm": 0.5, "ring": 1.0, "aisle": 0.7}
_STANDING = {"road": 0.12, "arm": 0.3, "ring": 0.1, "aisle": 0.25}
# How a car leans: 3 to 7 degrees of roll per g sideways (Gillespie, Fundamentals of Vehicle Dynamics); 2 degrees of
# pitch per g of braking is an estimate of ours. Comfortable braking and cornering stay within 0.3 g.
_FAST = 25.0  # m/s
_ROLL, _PITCH = math.radians(5.0) / 9.81, math.radians(2.0) / 9.81
_BRAKING, _CORNERING = 1.2, 3.0  # m/s2: standard deviation and limit


@dataclass(frozen=True, slots=True, eq=False)
class Ego:
    """The ego vehicle: x, y, z [m] of the road under it, yaw [rad], `speed` [m/s] and the lane it is in.

    `pose` is world_from_layout [4, 4]: the layout's frame is fixed to the road's surface under the wheels. `lean` holds
    the roll and pitch [rad] of the car's body against it.
    """

    x: float
    y: float
    z: float
    yaw: float
    speed: float
    lane: Lane
    pose: np.ndarray
    lean: tuple[float, float]


def sample_ego(occupancy: Occupancy, lanes: tuple[Lane, ...], rng: np.random.Generator) -> Ego:
    """A free place in one of the lanes, near the middle of the street; raises `LayoutError` if there is none."""
    near = _NEAR * occupancy.road.half_length
    middle = occupancy.road.lane(occupancy.road.ego_lane)
    for attempt in range(1000):
        lane = lanes[int(rng.integers(len(lanes)))]
        distance = rng.uniform(0.0, lane.length)
        along, across, angle = lane.at(distance, min(max(rng.normal(0.0, 0.15), -0.4), 0.4))
        spread = 14.0 + 0.1 * attempt  # the search widens when the middle is full
        off = math.hypot(along, 0.6 * (across - middle)) / spread
        if max(abs(along), abs(across)) > near or rng.random() > _LIKELY[lane.name] * math.exp(-0.5 * off * off) + 0.02:
            continue
        x, y, heading = occupancy.road.at(along, across)
        yaw = math.remainder(heading + angle + rng.normal(0.0, 0.02), 2 * math.pi)
        if occupancy.is_free(x, y, yaw, EGO_SIZE):
            return _ego(occupancy, lane, (along, across, angle), (x, y, yaw), rng)
    raise LayoutError(f"no free place of {EGO_SIZE[0]} x {EGO_SIZE[1]} m for the ego vehicle")


def _ego(
    occupancy: Occupancy,
    lane: Lane,
    place: tuple[float, float, float],
    planar: tuple[float, float, float],
    rng: np.random.Generator,
) -> Ego:
    along, across, angle = place
    x, y, yaw = planar
    base, track = _WHEELS
    ahead = np.array([base, base, -base, -base]) / 2
    left = np.array([track, -track, track, -track]) / 2
    cos, sin = math.cos(angle), math.sin(angle)
    wheels = occupancy.ground.heights(along + ahead * cos - left * sin, across + ahead * sin + left * cos)
    rise, bank = float(ahead @ wheels / (ahead @ ahead)), float(left @ wheels / (left @ left))
    z = float(wheels.mean())
    speed = _speed(lane, rng)
    braking = min(max(rng.normal(0.0, _BRAKING), -_CORNERING), _CORNERING) if speed > 0 else 0.0
    sideways = min(max(speed**2 * _bend(occupancy, lane), -_CORNERING), _CORNERING)
    # road noise on top; a left bend leans the body to the right, braking dips its nose
    roll = _ROLL * sideways + rng.normal(0.0, 0.003)
    pitch = _PITCH * braking + rng.normal(0.0, 0.003)
    return Ego(x, y, z, yaw, speed, lane, _on_slope((x, y, z), yaw, rise, bank), (roll, pitch))


def _speed(lane: Lane, rng: np.random.Generator) -> float:
    """Standing, slow or up to a little over the limit [m/s]."""
    # nobody stands or crawls on a fast road, but in a jam
    share = 0.15 if lane.speed > _FAST else 1.0
    if rng.random() < share * _STANDING[lane.name]:
        return 0.0
    if rng.random() < share * 0.2:
        return float(rng.uniform(0.1, 0.5) * lane.speed)
    return float(min(max(rng.normal(0.9, 0.12), 0.4), 1.1) * lane.speed)


def _bend(occupancy: Occupancy, lane: Lane) -> float:
    """Curvature [1/m] of the way the ego vehicle takes, positive to the left."""
    if lane.bend or lane.name != "road":
        return lane.bend
    return math.copysign(occupancy.road.curvature, occupancy.road.curvature * math.cos(lane.angle))


def _on_slope(place: tuple[float, float, float], yaw: float, rise: float, bank: float) -> np.ndarray:
    """The rigid pose at a place, turned by `yaw` and tilted so that the ground's slopes ahead and left are its x, y."""
    forward = np.array([math.cos(yaw), math.sin(yaw), rise])
    left = np.array([-math.sin(yaw), math.cos(yaw), bank])
    forward /= np.linalg.norm(forward)
    up = _cross(forward, left)
    up /= np.linalg.norm(up)
    pose = np.eye(4)
    pose[:3, :3] = np.stack([forward, _cross(up, forward), up], axis=1)
    pose[:3, 3] = place
    return pose


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The product of two vectors [3], for which numpy's takes twenty times as long."""
    (x, y, z), (u, v, w) = a.tolist(), b.tolist()
    return np.array([y * w - z * v, z * u - x * w, x * v - y * u])


def mount(sensor: Sensor, ego: Ego, rng: np.random.Generator) -> np.ndarray:
    """The sensor in the layout's frame [4, 4]: at its height over the road, leaning with the car's body."""
    roll, pitch = ego.lean
    # sensors are mounted a little askew, and loads and tyres change their height
    roll, pitch = roll + rng.normal(0.0, 0.003), pitch + rng.normal(0.0, 0.003)
    height = sensor.mount_height + rng.normal(0.0, 0.03)
    about_x = np.array([[1, 0, 0], [0, math.cos(roll), -math.sin(roll)], [0, math.sin(roll), math.cos(roll)]])
    about_y = np.array([[math.cos(pitch), 0, math.sin(pitch)], [0, 1, 0], [-math.sin(pitch), 0, math.cos(pitch)]])
    pose = np.eye(4)
    pose[:3, :3] = about_y @ about_x
    pose[2, 3] = height
    return pose
