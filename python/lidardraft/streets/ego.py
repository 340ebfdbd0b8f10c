"""The ego vehicle: its place and speed, and the pose of its sensor over the road."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from lidardraft.arranging.district import FAST
from lidardraft.arranging.occupancy import Occupancy
from lidardraft.arranging.traffic import EGO_ROOM, HUGGED, USES
from lidardraft.errors import LayoutError
from lidardraft.scene.sensor import Sensor
from lidardraft.scene.street import MAIN_ROAD, Path
from lidardraft.simulation.wheels import ROAD_NOISE, leaning, on_wheels, wheels_at

EGO_SPACE = (4.5, 2.2, 1.6)  # m of free space for the ego vehicle

# Its place: estimates.
_NEAR = 0.45  # of the half length of the street, from the middle at most
_SPREAD, _WIDENED = 14.0, 0.1  # m from the middle (deviation), and its increase after each try
_ACROSS = 0.6  # weight of m across, against m along
_ANYWHERE = 0.02  # probability of a place at any distance
_OFF_MIDDLE, _MOST_OFF = 0.15, 0.4  # m off the middle of the lane: deviation and limit
_OFF_LANE = 0.02  # rad against the lane, deviation
_ATTEMPTS = 1000

# Its speed, in shares of the limit: estimates.
_SELDOM = 0.15  # frequency of standing or crawling on a fast road (jams only), against others
_CRAWLS, _CRAWLING = 0.2, (0.1, 0.5)  # probability, and speed
_FLOWING, _SLOWEST, _FASTEST = (0.9, 0.12), 0.4, 1.1  # mean and deviation, limits

# The lean of a car: 3 to 7 degrees of roll per g sideways (Gillespie, Fundamentals of Vehicle Dynamics); 2 degrees of
# pitch per g of braking is an estimate. Comfortable braking and cornering stay within 0.3 g.
_ROLL, _PITCH = math.radians(5.0) / 9.81, math.radians(2.0) / 9.81
_BRAKING, _CORNERING = 1.2, 3.0  # m/s2: deviation and limit

# The mount of its sensor: a little askew, at a height that loads and tyres change. Deviations, estimates.
_MOUNT_ANGLE, _MOUNT_HEIGHT = 0.003, 0.03  # rad, m


@dataclass(frozen=True, slots=True, eq=False)
class Ego:
    """The ego vehicle: x, y, z [m] of the road under it, yaw [rad], `speed` [m/s] and its lane.

    `pose` is world_from_layout [4, 4]: the layout's frame is fixed to the road's surface under the wheels. `lean` is
    the roll and pitch [rad] of the car's body against it.
    """

    x: float
    y: float
    z: float
    yaw: float
    speed: float
    lane: Path
    pose: np.ndarray
    lean: tuple[float, float]


def sample_ego(occupancy: Occupancy, lanes: tuple[Path, ...], rng: np.random.Generator) -> Ego:
    """A free place in one of the lanes, near the middle of the street; raises `LayoutError` if there is none."""
    road = occupancy.road
    near, middle = _NEAR * road.half_length, road.lane(road.ego_lane)
    for attempt in range(_ATTEMPTS):
        lane = lanes[int(rng.integers(len(lanes)))]
        distance = rng.uniform(0.0, lane.length)
        along, across, angle = lane.at(distance, min(max(rng.normal(0.0, _OFF_MIDDLE), -_MOST_OFF), _MOST_OFF))
        off = math.hypot(along, _ACROSS * (across - middle)) / (_SPREAD + _WIDENED * attempt)
        likely = USES[lane.kind].ego_share * math.exp(-0.5 * off * off) + _ANYWHERE
        if max(abs(along), abs(across)) > near or rng.random() > likely:
            continue
        x, y, heading = road.at(along, across)
        yaw = math.remainder(heading + angle + rng.normal(0.0, _OFF_LANE), 2 * math.pi)
        if occupancy.is_free(x, y, yaw, EGO_ROOM if rng.random() > HUGGED else EGO_SPACE):
            return _ego(occupancy, lane, (along, across, angle), (x, y, yaw), rng)
    raise LayoutError(f"no free place of {EGO_SPACE[0]} x {EGO_SPACE[1]} m for the ego vehicle")


def _ego(
    occupancy: Occupancy,
    lane: Path,
    place: tuple[float, float, float],
    planar: tuple[float, float, float],
    rng: np.random.Generator,
) -> Ego:
    x, y, yaw = planar
    wheels = occupancy.ground.heights(*wheels_at(place))
    z = float(wheels.mean())
    speed = _speed(lane, rng)
    braking = min(max(rng.normal(0.0, _BRAKING), -_CORNERING), _CORNERING) if speed > 0 else 0.0
    sideways = min(max(speed**2 * _bend(occupancy, lane), -_CORNERING), _CORNERING)
    # road noise on top; a left bend leans the body to the right, braking dips its nose
    roll = _ROLL * sideways + rng.normal(0.0, ROAD_NOISE)
    pitch = _PITCH * braking + rng.normal(0.0, ROAD_NOISE)
    return Ego(x, y, z, yaw, speed, lane, on_wheels((x, y, z), yaw, wheels), (roll, pitch))


def _speed(lane: Path, rng: np.random.Generator) -> float:
    """The speed: 0, slow, or up to a little over the limit [m/s]."""
    often = _SELDOM if lane.speed > FAST else 1.0
    if rng.random() < often * USES[lane.kind].ego_stands:
        return 0.0
    if rng.random() < often * _CRAWLS:
        return float(rng.uniform(*_CRAWLING) * lane.speed)
    return float(min(max(rng.normal(*_FLOWING), _SLOWEST), _FASTEST) * lane.speed)


def _bend(occupancy: Occupancy, lane: Path) -> float:
    """Curvature [1/m] of the ego vehicle's way, positive to the left."""
    if lane.bend or lane.kind != MAIN_ROAD:
        return lane.bend
    return math.copysign(occupancy.road.curvature, occupancy.road.curvature * math.cos(lane.angle))


def mount(sensor: Sensor, ego: Ego, rng: np.random.Generator) -> np.ndarray:
    """The sensor in the layout's frame [4, 4]: at its height over the road, leaning with the car's body."""
    roll, pitch = ego.lean
    roll, pitch = roll + rng.normal(0.0, _MOUNT_ANGLE), pitch + rng.normal(0.0, _MOUNT_ANGLE)
    height = sensor.mount_height + rng.normal(0.0, _MOUNT_HEIGHT)
    pose = leaning(roll, pitch)
    pose[2, 3] = height
    return pose
