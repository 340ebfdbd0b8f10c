"""The plan of one street, sampled from what the district it lies in has."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from lidardraft.scene.road import Road
from lidardraft.streets.ground.ground import Ground
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
from lidardraft.streets.placement.street_mix import USUAL_MIX, StreetMix
from lidardraft.streets.placement.traffic import place_parked_vehicles, place_traffic
from lidardraft.streets.placement.walkers import place_people

# Closed fronts behind front gardens: their share among closed fronts, and what is different there. Numbers without a
# source are estimates of ours, here and below.
_GREEN = 0.35
_GREEN_SETBACK, _GREEN_FENCES, _GREEN_THICKETS = (2.5, 6.0), 0.5, 1.5  # m, a side, mean number a side
_TWO_AISLES = 0.35  # share of car parks with two aisles

_GRASS_STRIP = (0.35, 0.5)  # share of the width of a sidewalk
_STRIP_SIDEWALK = 2.2  # m, narrower sidewalks have none
_CONCRETE_ROADS = 0.25  # share of motorways: about a quarter of the German ones (BASt)
_BARE_SOIL, _ASPHALT_WALKS = 0.2, 0.2  # share of land outside towns, and of all sidewalks


def plan_street(
    rng: np.random.Generator, half_length: float, mix: StreetMix = USUAL_MIX
) -> tuple[Occupancy, tuple[Lane, ...], str]:
    """A street of some district with all its objects, the lanes that are driven in, and the name of the district."""
    name = mix.sample_district(rng)
    district = DISTRICTS[name]
    if district.closed_fronts and rng.random() < _GREEN:
        district = replace(
            district, setback=_GREEN_SETBACK, front_fences=_GREEN_FENCES, paved=0.0, thickets=_GREEN_THICKETS
        )
    district = mix.applied(district)
    parking = tuple(side for side in SIDES if rng.random() < district.parked)
    oneway, wants_car_park = bool(rng.random() < district.oneway), bool(rng.random() < district.car_park)
    road = sample_road(district, parking, half_length, rng, oneway=oneway, car_park=wants_car_park)
    road, car_park = _with_car_park(road, rng) if wants_car_park else (road, None)
    occupancy = Occupancy(road, _sample_ground(road, district, rng))
    lights = road.junction is not None and road.roundabout_radius is None and bool(rng.random() < district.lights)
    lanes = driven_lanes(road, district, parking, car_park, oneway=oneway, lights=lights)
    occupancy.ground.paint(road_markings(road, lanes, car_park, district.speed, rng))
    if lights:
        place_traffic_lights(occupancy, rng)
    place_road_equipment(occupancy, district, rng)
    place_buildings(occupancy, district, car_park, rng)
    place_side_road_buildings(occupancy, district, rng)
    driveways = place_driveways(occupancy, district, rng)
    place_front_fences(occupancy, district, driveways, car_park, rng)
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
    car_park = sample_car_park(road, 1 + int(rng.random() < _TWO_AISLES), rng)
    return replace(road, paved_areas=(car_park.paved_area, car_park.access)), car_park


def _sample_ground(road: Road, district: District, rng: np.random.Generator) -> Ground:
    strip = rng.uniform(*_GRASS_STRIP) * road.sidewalk if rng.random() < district.strip else 0.0
    if road.roundabout_radius is not None or road.sidewalk < _STRIP_SIDEWALK:
        strip = 0.0
    ground = Ground(road, rng, district.land, strip=strip, paved=bool(rng.random() < district.paved))
    if road.sidewalk == 0 and road.median > 0 and rng.random() < _CONCRETE_ROADS:
        ground.materials["road"] = "concrete"
    if road.sidewalk == 0 and rng.random() < _BARE_SOIL:
        ground.materials["terrain"] = "soil"
    if rng.random() < _ASPHALT_WALKS:
        ground.materials["sidewalk"] = "asphalt"
    return ground
