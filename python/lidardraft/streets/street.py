"""The endless procedural world: a seed becomes a street."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from lidardraft.arranging.occupancy import Occupancy
from lidardraft.arranging.plan import plan_street
from lidardraft.arranging.street_mix import USUAL_MIX, StreetMix
from lidardraft.errors import LayoutError, check_number, check_seed
from lidardraft.objects.kinds import kind_of
from lidardraft.scene.intent import Intent
from lidardraft.scene.layout import Layout
from lidardraft.scene.pose import place_around, point_at
from lidardraft.scene.road_network import RoadNetwork
from lidardraft.scene.road_surfaces import drawn
from lidardraft.scene.sensor import PRESETS, Sensor
from lidardraft.scene.street import Path, StreetFrame, paths_of
from lidardraft.scene.weather import Weather
from lidardraft.streets.coarse.coarse_layout import BoxStyle, as_boxes
from lidardraft.streets.coarse.coarse_street import CoarseStreet, place_of

_CLEAR = Weather()
_PARALLEL = 0.01  # rad against the road of lanes along it, at most


@dataclass(frozen=True, kw_only=True, slots=True)
class StreetConfig:
    """The settings of streets and their scans.

    `sensor` scans them in `weather`, from `poses_per_street` places each. A street reaches `half_length` [m] either way
    from its middle; `mix` is the composition of streets. Raises `LayoutError` for less than one place, or a
    half length that is not 40 to 200 m.
    """

    sensor: Sensor = PRESETS["hdl64e"]
    poses_per_street: int = 32
    half_length: float = 90.0
    mix: StreetMix = USUAL_MIX
    weather: Weather = _CLEAR

    def __post_init__(self) -> None:
        if self.poses_per_street < 1:
            raise LayoutError(f"poses_per_street is {self.poses_per_street}; a street is scanned at least once")
        if not 40.0 <= self.half_length <= 200.0:
            raise LayoutError(f"half_length is {self.half_length} m; it must be 40 to 200 m")


@dataclass(frozen=True, slots=True, eq=False)
class Street:
    """One street, in the frame of its road: all objects are in their places of `Road.at`.

    `scene` is the detailed layout, `coarse` the common part of its coarse layouts. `occupancy` holds the road, the
    ground and the objects in order. The lanes follow from `frame`; `lanes` are those for traffic. `district` is a name
    of `DISTRICTS`.
    """

    seed: int
    number: int
    district: str
    occupancy: Occupancy
    frame: StreetFrame
    lanes: tuple[Path, ...]
    scene: Layout
    coarse: CoarseStreet

    @property
    def layout(self) -> Layout:
        """All objects as simple shapes on flat ground."""
        style, pose = BoxStyle(), np.eye(4)
        return self.with_roads(as_boxes(self.coarse, style, pose).layout({"source": style.source}), pose, relief=False)

    def with_roads(self, layout: Layout, pose: np.ndarray, *, relief: bool) -> Layout:
        """A layout of the street, in the frame of the ego vehicle at street_from_ego `pose` [4, 4], with its roads;
        with `relief`, these rise and fall over the plane of the pose."""
        place, ground = place_of(pose), self.occupancy.ground
        street = replace(self.frame, place=place_around(place))

        def height(points: np.ndarray) -> np.ndarray:
            x, y = point_at(place, points[:, 0], points[:, 1])
            z = ground.heights(*ground.road.along_across(x, y))
            over: np.ndarray = (np.column_stack([x, y, z]) - pose[:3, 3]) @ pose[:3, 2]
            return over

        roads = RoadNetwork(street=street, drawn=drawn(layout), ground=height if relief else None)
        return replace(layout, roads=roads)


def make_street(*, seed: int = 0, config: StreetConfig | None = None, number: int = 0) -> Street:
    """Street `number` of a seed."""
    seed, number = check_seed(seed), check_number("number", number)
    config = config or StreetConfig()
    rng = np.random.default_rng([seed, number])
    frame, district = plan_street(rng, config.half_length, config.mix)
    occupancy, lanes = frame.occupancy, paths_of(frame.street)
    primitives = occupancy.ground.surfaces()
    for placed in occupancy.objects:
        primitives += kind_of(placed.kind).build(placed, rng)
    provenance = {"source": "streets", "seed": seed, "number": number, "district": district}
    scene = Layout(primitives=tuple(primitives), provenance=provenance, intent=Intent(district=district))
    middles = [lane.across for lane in lanes if abs(math.sin(lane.angle)) < _PARALLEL]
    return Street(
        seed,
        number,
        district,
        occupancy,
        frame.street,
        lanes,
        scene,
        CoarseStreet(occupancy.road, occupancy.objects, scene, middles),
    )
