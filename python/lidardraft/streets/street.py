"""The endless procedural world: a seed becomes a street, and a street becomes pairs of a scan and its drawing."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from lidardraft.errors import LayoutError
from lidardraft.scene.effects import observe
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.raycast import Raycaster, raycast
from lidardraft.scene.sensor import PRESETS, Sensor
from lidardraft.streets import buildings, furniture, people, plants, vehicles
from lidardraft.streets.drawing import Style, draw, draw_style
from lidardraft.streets.plan import draw_site
from lidardraft.streets.quarter import Lane
from lidardraft.streets.site import Site
from lidardraft.streets.thing import Thing

EGO_SIZE = (4.5, 2.2, 1.6)  # m that stay free around the ego vehicle
_SEEN = 5  # returns that a thing needs to be clustered

_BUILDERS: dict[str, Callable[[Thing, np.random.Generator], list[Primitive]]] = {
    **dict.fromkeys(vehicles.BODIES, vehicles.car),
    "truck": vehicles.truck,
    "bus": vehicles.bus,
    "tram": vehicles.tram,
    "bicycle": vehicles.bicycle,
    "cyclist": vehicles.cyclist,
    "motorcycle": vehicles.motorcycle,
    "motorcyclist": vehicles.motorcyclist,
    "person": people.person,
    "house": buildings.house,
    "block": buildings.block,
    "shed": buildings.shed,
    "tree": plants.tree,
    "bush": plants.bush,
    "hedge": plants.hedge,
    "lamp": furniture.lamp,
    "pole": furniture.pole,
    "sign": furniture.sign,
    "traffic_light": furniture.traffic_light,
    "fence": furniture.fence,
    "garden_wall": furniture.garden_wall,
    "bin": furniture.bin,
    "bench": furniture.bench,
}


@dataclass(frozen=True, kw_only=True, slots=True)
class StreetConfig:
    """`poses_per_street` scans are taken of each street; `reach` [m] is how far it goes either way."""

    sensor: Sensor = PRESETS["hdl64e"]
    poses_per_street: int = 6
    reach: float = 90.0

    def __post_init__(self) -> None:
        if self.poses_per_street < 1:
            raise LayoutError(f"poses_per_street is {self.poses_per_street}; a street is scanned at least once")
        if not 40.0 <= self.reach <= 200.0:
            raise LayoutError(f"reach is {self.reach} m; it must be 40 to 200 m")


@dataclass(frozen=True, slots=True, eq=False)
class Street:
    """Two scenes of one place: `scene`, detailed, and `layout`, its clean drawing; both in the frame of the road."""

    seed: int
    quarter: str
    site: Site
    lanes: tuple[Lane, ...]
    scene: Layout
    layout: Layout


@dataclass(frozen=True, slots=True, eq=False)
class StreetPair:
    """A lifelike scan and the drawing of the same place, both from `pose`.

    `layout` is in the frame of the ego vehicle; `raycast(layout, sensor, pose)` gives `drawing`. `index` counts the
    pairs of one seed, `style` says how the layout was drawn.
    """

    scan: RangeImage
    drawing: RangeImage
    layout: Layout
    pose: np.ndarray
    style: Style
    quarter: str
    index: int


def make_street(seed: int, config: StreetConfig | None = None) -> Street:
    """The street of a seed; the same on every machine."""
    _check_number("seed", seed)
    config = config or StreetConfig()
    return _street(np.random.default_rng([seed]), seed, config)


def streets(seed: int, config: StreetConfig | None = None, *, start: int = 0) -> Iterator[StreetPair]:
    """Pairs without end, from number `start`; pair k depends on the seed, the config and k alone."""
    _check_number("seed", seed)
    _check_number("start", start)
    config = config or StreetConfig()
    number = start // config.poses_per_street
    first = start % config.poses_per_street
    while True:
        street = _street(np.random.default_rng([seed, number]), seed, config)
        caster = Raycaster(street.scene)
        for index in range(number * config.poses_per_street + first, (number + 1) * config.poses_per_street):
            yield _pair(street, caster, config.sensor, seed, index)
        number, first = number + 1, 0


def _check_number(name: str, value: int) -> None:
    if isinstance(value, bool) or not isinstance(value, int) or value < 0:
        raise LayoutError(f"{name} is {value!r}; it must be an integer >= 0")


def _street(rng: np.random.Generator, seed: int, config: StreetConfig) -> Street:
    site, lanes, quarter = draw_site(rng, config.reach)
    primitives = site.ground.surfaces()
    for thing in site.things:
        primitives += _BUILDERS[thing.kind](thing, rng)
    provenance = {"source": "streets", "seed": seed, "quarter": quarter}
    layout = draw(site.road, site.things, Style(), rng)
    return Street(seed, quarter, site, lanes, Layout(primitives=tuple(primitives), provenance=provenance), layout)


def _pair(street: Street, caster: Raycaster, sensor: Sensor, seed: int, index: int) -> StreetPair:
    rng = np.random.default_rng([seed, index, 1])
    x, y, yaw = _ego(street, rng)
    pose = _mount(sensor, rng)
    raw = caster.scan(sensor, _from_ego(x, y, yaw) @ pose, primitive=True, incidence=True)
    scan = observe(raw, street.scene, rng)
    style = draw_style(rng)
    drawn = draw(street.site.road, street.site.things, style, rng, _seen(raw, scan, street.scene))
    layout = _in_ego_frame(drawn, x, y, yaw)
    drawing = raycast(layout, sensor, pose)
    return StreetPair(scan, drawing, layout, pose, style, street.quarter, index)


def _ego(street: Street, rng: np.random.Generator) -> tuple[float, float, float]:
    """x, y [m] and yaw [rad] of a free place in one of the lanes, near the middle of the street."""
    for attempt in range(1000):
        lane = street.lanes[int(rng.integers(len(street.lanes)))]
        # the search widens when the middle is full
        along = rng.normal(0.0, 14.0 + 0.1 * attempt)
        if abs(along) > 0.4 * street.site.road.reach:
            continue
        x, y, heading = street.site.road.at(along, lane.across + rng.normal(0.0, 0.15))
        yaw = heading + (0.0 if lane.direction > 0 else math.pi) + rng.normal(0.0, 0.02)
        if street.site.is_free(x, y, yaw, EGO_SIZE):
            return x, y, yaw
    raise LayoutError(
        f"street of seed {street.seed}: no free place of {EGO_SIZE[0]} x {EGO_SIZE[1]} m for the ego vehicle"
    )


def _mount(sensor: Sensor, rng: np.random.Generator) -> np.ndarray:
    """`world_from_sensor` of a sensor on a car that brakes and leans a little, over the origin."""
    roll, pitch = rng.normal(0.0, 0.006, 2)
    height = sensor.mount_height + rng.normal(0.0, 0.03)
    about_x = np.array([[1, 0, 0], [0, math.cos(roll), -math.sin(roll)], [0, math.sin(roll), math.cos(roll)]])
    about_y = np.array([[math.cos(pitch), 0, math.sin(pitch)], [0, 1, 0], [-math.sin(pitch), 0, math.cos(pitch)]])
    pose = np.eye(4)
    pose[:3, :3] = about_y @ about_x
    pose[2, 3] = height
    return pose


def _from_ego(x: float, y: float, yaw: float) -> np.ndarray:
    pose = np.eye(4)
    pose[:2, :2] = [[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]]
    pose[:2, 3] = x, y
    return pose


def _in_ego_frame(layout: Layout, x: float, y: float, yaw: float) -> Layout:
    cos, sin = math.cos(yaw), math.sin(yaw)

    def moved(p: Primitive) -> Primitive:
        dx, dy = p.center[0] - x, p.center[1] - y
        return replace(p, center=(cos * dx + sin * dy, cos * dy - sin * dx, p.center[2]), yaw=p.yaw - yaw)

    return replace(layout, primitives=tuple(moved(p) for p in layout.primitives))


def _seen(raw: RangeImage, scan: RangeImage, scene: Layout) -> set[str]:
    """Ids of the things with enough returns in the scan."""
    assert raw.primitive is not None
    counts = np.bincount(raw.primitive[scan.valid], minlength=len(scene.primitives))
    returns: dict[str, int] = {}
    for index in np.flatnonzero(counts):
        name = scene.primitives[index].id.partition(".")[0]
        returns[name] = returns.get(name, 0) + int(counts[index])
    return {name for name, count in returns.items() if count >= _SEEN}
