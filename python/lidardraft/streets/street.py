"""The endless procedural world: a seed becomes a street."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from lidardraft.errors import LayoutError
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.sensor import PRESETS, Sensor
from lidardraft.streets import buildings, cycles, furniture, heavy, people, plants, posts, vehicles
from lidardraft.streets.drawing import DrawnStreet
from lidardraft.streets.lane import Lane
from lidardraft.streets.plan import draw_site
from lidardraft.streets.site import Site
from lidardraft.streets.thing import Thing

_BUILDERS: dict[str, Callable[[Thing, np.random.Generator], list[Primitive]]] = {
    **dict.fromkeys(vehicles.BODIES, vehicles.car),
    "truck": heavy.truck,
    "trailer_truck": heavy.trailer_truck,
    "bus": heavy.bus,
    "tram": heavy.tram,
    "bicycle": cycles.bicycle,
    "cyclist": cycles.cyclist,
    "motorcycle": cycles.motorcycle,
    "motorcyclist": cycles.motorcyclist,
    "person": people.person,
    "house": buildings.house,
    "block": buildings.block,
    "shed": buildings.shed,
    "tree": plants.tree,
    "bush": plants.bush,
    "hedge": plants.hedge,
    "grass": plants.grass,
    "lamp": posts.lamp,
    "pole": posts.pole,
    "sign": posts.sign,
    "traffic_light": posts.traffic_light,
    "fence": furniture.fence,
    "mesh_fence": furniture.mesh_fence,
    "garden_wall": furniture.garden_wall,
    "wall": furniture.wall,
    "barrier": furniture.barrier,
    "gantry": posts.gantry,
    "billboard": posts.billboard,
    "shelter": furniture.shelter,
    "bin": furniture.bin,
    "bench": furniture.bench,
    "cone": furniture.cone,
    "letterbox": furniture.letterbox,
    "hydrant": furniture.hydrant,
    "cabinet": furniture.cabinet,
}


@dataclass(frozen=True, kw_only=True, slots=True)
class StreetConfig:
    """`poses_per_street` scans are taken of each street; `reach` [m] is how far it goes either way."""

    sensor: Sensor = PRESETS["hdl64e"]
    poses_per_street: int = 32
    reach: float = 90.0

    def __post_init__(self) -> None:
        if self.poses_per_street < 1:
            raise LayoutError(f"poses_per_street is {self.poses_per_street}; a street is scanned at least once")
        if not 40.0 <= self.reach <= 200.0:
            raise LayoutError(f"reach is {self.reach} m; it must be 40 to 200 m")


@dataclass(frozen=True, slots=True, eq=False)
class Street:
    """Two scenes of one place: `scene`, detailed, and `layout`, its clean drawing; both in the frame of the road.

    `drawn` is what all drawings of it have in common.
    """

    seed: int
    number: int
    quarter: str
    site: Site
    lanes: tuple[Lane, ...]
    scene: Layout
    drawn: DrawnStreet

    @property
    def layout(self) -> Layout:
        """Everything as it is, as simple shapes on flat ground."""
        return self.drawn.whole()


def make_street(seed: int, config: StreetConfig | None = None, *, number: int = 0) -> Street:
    """Street `number` of a seed; the same on every machine."""
    check_number("seed", seed)
    check_number("number", number)
    config = config or StreetConfig()
    rng = np.random.default_rng([seed, number])
    site, lanes, quarter = draw_site(rng, config.reach)
    primitives = site.ground.surfaces()
    for thing in site.things:
        primitives += _BUILDERS[thing.kind](thing, rng)
    provenance = {"source": "streets", "seed": seed, "number": number, "quarter": quarter}
    scene = Layout(primitives=tuple(primitives), provenance=provenance)
    middles = [lane.across for lane in lanes if abs(math.sin(lane.turn)) < 0.01]
    return Street(seed, number, quarter, site, lanes, scene, DrawnStreet(site.road, site.things, scene, middles))


def check_number(name: str, value: int, *, least: int = 0) -> None:
    """Raises `LayoutError` for what is no integer or less than `least`."""
    if isinstance(value, bool) or not isinstance(value, int) or value < least:
        raise LayoutError(f"{name} is {value!r}; it must be an integer >= {least}")
