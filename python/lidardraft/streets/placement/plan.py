"""The plan of one street, drawn from the kind of quarter it lies in."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from lidardraft.scene.road import Road
from lidardraft.streets.ground.ground import Ground
from lidardraft.streets.ground.relief import Land
from lidardraft.streets.placement.building_rows import place_buildings
from lidardraft.streets.placement.car_parks import CarPark, place_in_car_park, sample_car_park
from lidardraft.streets.placement.district import DISTRICTS, SIDES, District, sample_road
from lidardraft.streets.placement.gardens import (
    place_driveways,
    place_front_fences,
    place_garden_plants,
    place_shrub_beds,
    place_thickets,
    place_yard_objects,
)
from lidardraft.streets.placement.lanes import Lane, driven_lanes
from lidardraft.streets.placement.markings import road_markings
from lidardraft.streets.placement.occupancy import Occupancy
from lidardraft.streets.placement.road_equipment import place_road_equipment, place_traffic_lights
from lidardraft.streets.placement.roadside import (
    place_high_grass,
    place_island_plants,
    place_street_furniture,
    place_street_trees,
)
from lidardraft.streets.placement.side_roads import place_beside_side_roads, place_side_road_buildings
from lidardraft.streets.placement.traffic import place_parked_vehicles, place_traffic
from lidardraft.streets.placement.walkers import place_people

_NAMES = tuple(DISTRICTS)
_GREEN = 0.35  # of the streets between closed fronts, an estimate of ours
_SHARES = np.cumsum([district.share for district in DISTRICTS.values()])


def plan_street(rng: np.random.Generator, half_length: float) -> tuple[Occupancy, tuple[Lane, ...], str]:
    """A site with all its things, the lanes that are driven in, and the name of its quarter."""
    name = _NAMES[int(np.searchsorted(_SHARES / _SHARES[-1], rng.random(), side="right"))]
    district = DISTRICTS[name]
    if district.gap[1] == 0.0 and rng.random() < _GREEN:
        # closed fronts behind front gardens
        district = replace(district, setback=(2.5, 6.0), fronts=0.5, paved=0.0, thickets=1.5)
    parking = tuple(side for side in SIDES if rng.random() < district.parked)
    oneway, wants_lot = bool(rng.random() < district.oneway), bool(rng.random() < district.car_park)
    road = sample_road(district, parking, half_length, rng, oneway=oneway, car_park=wants_lot)
    road, car_park = _with_car_park(road, rng) if wants_lot else (road, None)
    occupancy = Occupancy(road, _ground(road, district, rng))
    lights = road.junction is not None and road.roundabout_radius is None and bool(rng.random() < district.lights)
    lanes = driven_lanes(road, district, parking, car_park, oneway=oneway, lights=lights)
    occupancy.ground.paint(road_markings(road, lanes, car_park, district.speed, rng))
    if lights:
        place_traffic_lights(occupancy, rng)
    place_road_equipment(occupancy, name, rng)
    place_buildings(occupancy, district, car_park, rng)
    place_side_road_buildings(occupancy, district, rng)
    drives = place_driveways(occupancy, district, rng)
    place_front_fences(occupancy, district, drives, car_park, rng)
    place_street_furniture(occupancy, district, car_park, rng)
    place_street_trees(occupancy, district, rng)
    place_beside_side_roads(occupancy, district, rng)
    place_island_plants(occupancy, rng)
    if car_park is not None:
        place_in_car_park(occupancy, car_park, rng)
    place_parked_vehicles(occupancy, parking, car_park, rng)
    place_traffic(occupancy, district, lanes, rng)
    place_people(occupancy, district, lights, rng)
    place_yard_objects(occupancy, district, rng)
    place_shrub_beds(occupancy, district, rng)
    place_thickets(occupancy, district, rng)
    place_garden_plants(occupancy, district, rng)
    place_high_grass(occupancy, rng)
    return occupancy, lanes, name


def _with_car_park(road: Road, rng: np.random.Generator) -> tuple[Road, CarPark]:
    car_park = sample_car_park(road, 1 + int(rng.random() < 0.35), rng)
    return replace(road, paved_areas=(car_park.paved_area, car_park.access)), car_park


def _ground(road: Road, district: District, rng: np.random.Generator) -> Ground:
    land = Land(
        grade=district.grade,
        hillside=district.hillside,
        rolling=district.rolling,
        ditch=district.ditch,
        bank=district.bank,
    )
    strip = rng.uniform(0.35, 0.5) * road.sidewalk if rng.random() < district.strip else 0.0
    if road.roundabout_radius is not None or road.sidewalk < 2.2:
        strip = 0.0
    ground = Ground(road, rng, land, strip=strip, paved=bool(rng.random() < district.paved))
    # about a quarter of German motorways are of concrete (BASt); the other shares are estimates of ours
    if road.sidewalk == 0 and road.median > 0 and rng.random() < 0.25:
        ground.materials["road"] = "concrete"
    if road.sidewalk == 0 and rng.random() < 0.2:
        ground.materials["terrain"] = "soil"
    if rng.random() < 0.2:
        ground.materials["sidewalk"] = "asphalt"
    return ground
