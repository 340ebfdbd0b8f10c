"""A street in two steps: a frame, sampled or given, and a fill that places all other objects in it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from lidardraft.arranging.building_rows import place_buildings
from lidardraft.arranging.car_parks import CarPark, place_in_car_park, sample_car_park
from lidardraft.arranging.clusters import place_clusters
from lidardraft.arranging.district import CALM, STREET_DISTRICTS, District, sample_road
from lidardraft.arranging.gardens import (
    place_car_park_fences,
    place_driveways,
    place_front_fences,
    place_garden_plants,
    place_ground_cover,
    place_plot_lines,
    place_shrub_beds,
    place_thickets,
    place_yard_objects,
)
from lidardraft.arranging.ground import Ground
from lidardraft.arranging.markings import road_markings, sample_zebras, zebras
from lidardraft.arranging.occupancy import Occupancy
from lidardraft.arranging.road_equipment import place_road_equipment, place_traffic_lights
from lidardraft.arranging.roadside import (
    place_high_grass,
    place_island_plants,
    place_street_furniture,
    place_street_trees,
)
from lidardraft.arranging.side_roads import place_beside_side_roads, place_side_road_buildings
from lidardraft.arranging.street_mix import USUAL_MIX, StreetMix, applied
from lidardraft.arranging.traffic import place_parked_vehicles, place_traffic
from lidardraft.arranging.walkers import place_people
from lidardraft.scene.road import SIDES, Road
from lidardraft.scene.street import StreetFrame, paths_of

# Closed fronts behind front gardens: their share among closed fronts, and their properties. Numbers without a source
# are estimates, here and below.
_GREEN = 0.35
# Streets along parks and open land, country roads with sidewalks, and calm streets without any: estimates.
_OPEN, _COUNTRY_WALKS, _NO_WALKS = 0.15, 0.3, 0.08
_OPEN_BUILT, _OPEN_FENCES, _OPEN_THICKETS = 0.45, 0.6, 2.0  # share of the plots behind; a side
_OPEN_SETBACK, _OPEN_GAP, _WALKS = (18.0, 45.0), (4.0, 20.0), (1.5, 2.5)  # m
_GREEN_SETBACK, _GREEN_FENCES, _GREEN_THICKETS = (2.5, 6.0), 0.5, 1.5  # m, a side, mean number a side
_TWO_AISLES = 0.35  # share of car parks with two aisles

_GRASS_STRIP = (0.35, 0.5)  # share of the width of a sidewalk
_STRIP_SIDEWALK = 2.2  # m, narrower sidewalks have none
_CONCRETE_ROADS = 0.25  # share of motorways: about a quarter of German ones (BASt)
_BARE_SOIL, _ASPHALT_WALKS = 0.2, 0.2  # share of land outside towns, and of all sidewalks


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """The frame of a street to fill: the road with its lanes, and its ground with the objects so far."""

    district: District
    street: StreetFrame
    occupancy: Occupancy
    car_park: CarPark | None = None


def plan_street(rng: np.random.Generator, half_length: float, mix: StreetMix = USUAL_MIX) -> tuple[Frame, str]:
    """A street of some district with all its objects, and the name of the district."""
    frame, name = sample_frame(rng, half_length, mix)
    fill(frame, rng)
    return frame, name


def sample_frame(rng: np.random.Generator, half_length: float, mix: StreetMix) -> tuple[Frame, str]:
    """A random frame of a street in a `mix`, and the name of its district."""
    name = mix.sample_district(rng)
    district = applied(mix, walked(greened(STREET_DISTRICTS[name], rng), rng))
    parking = tuple(side for side in SIDES if rng.random() < district.parked)
    oneway, wants_car_park = bool(rng.random() < district.oneway), bool(rng.random() < district.car_park)
    road = sample_road(district, parking, half_length, rng, oneway=oneway, car_park=wants_car_park)
    road, car_park = _with_car_park(road, rng) if wants_car_park else (road, None)
    occupancy = Occupancy(road, _sample_ground(road, district, rng))
    lights = sample_lights(road, district, rng)
    street = StreetFrame(
        road=road,
        speed=district.speed,
        parked=parking,
        one_way=oneway,
        aisles=() if car_park is None else tuple((across, *car_park.paved_area.along) for across in car_park.aisles),
        lights=lights,
    )
    spans = road_markings(road, paths_of(street), car_park, district.speed, rng)
    street = replace(street, zebras=sample_zebras(road, district.speed, rng))
    occupancy.ground.paint(np.concatenate([spans, zebras(road, street.zebras)]))
    return Frame(district, street, occupancy, car_park), name


def greened(district: District, rng: np.random.Generator) -> District:
    """The district, in which some closed fronts stand behind front gardens."""
    if district.closed_fronts and rng.random() < _GREEN:
        return replace(
            district, setback=_GREEN_SETBACK, front_fences=_GREEN_FENCES, paved=0.0, thickets=_GREEN_THICKETS
        )
    return district


def walked(district: District, rng: np.random.Generator) -> District:
    """The district with variants: sometimes parks, squares and yards before its buildings, country roads with
    sidewalks; more seldom buildings without sidewalks."""
    draw = rng.random()
    if not district.junction:  # a motorway
        return district
    if not district.built_up:
        return replace(district, sidewalk=_WALKS) if draw < _COUNTRY_WALKS else district
    if draw < _OPEN:
        district = replace(district, built=_OPEN_BUILT, paved=0.0, setback=_OPEN_SETBACK, gap=_OPEN_GAP)
        return replace(district, front_fences=_OPEN_FENCES, thickets=_OPEN_THICKETS)
    if draw > 1.0 - _NO_WALKS and district.speed < CALM:
        return replace(district, sidewalk=(0.0, 0.0))
    return district


def sample_lights(road: Road, district: District, rng: np.random.Generator) -> bool:
    """Whether the road has a junction with traffic lights."""
    return road.junction is not None and road.roundabout_radius is None and bool(rng.random() < district.lights)


def fill(frame: Frame, rng: np.random.Generator) -> None:
    """Place all objects of a street of its district in a frame, around its present ones."""
    occupancy, district, car_park = frame.occupancy, frame.district, frame.car_park
    if frame.street.lights:
        place_traffic_lights(occupancy, rng)
    place_road_equipment(occupancy, district, rng)
    place_buildings(occupancy, district, car_park, rng)
    place_side_road_buildings(occupancy, district, rng)
    driveways = place_driveways(occupancy, district, rng)
    place_front_fences(occupancy, district, driveways, car_park, rng)
    if car_park is not None:
        place_car_park_fences(occupancy, district, car_park, rng)
    place_street_furniture(occupancy, district, car_park, rng)
    place_street_trees(occupancy, district, rng)
    place_beside_side_roads(occupancy, district, rng)
    place_island_plants(occupancy, rng)
    if car_park is not None:
        place_in_car_park(occupancy, car_park, rng)
    place_parked_vehicles(occupancy, frame.street.parked or (), car_park, rng)
    place_traffic(occupancy, district, paths_of(frame.street), rng)
    place_people(occupancy, district, frame.street.lights, rng)
    place_clusters(occupancy, district, car_park, rng)
    place_yard_objects(occupancy, district, rng)
    place_shrub_beds(occupancy, district, rng)
    place_thickets(occupancy, district, rng)
    place_plot_lines(occupancy, district, rng)
    place_garden_plants(occupancy, district, rng)
    place_ground_cover(occupancy, district, rng)
    place_high_grass(occupancy, rng)


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
