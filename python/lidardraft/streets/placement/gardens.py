"""What private people have between the street and their houses, and what grows there."""

from __future__ import annotations

import math

import numpy as np

from lidardraft.objects.cars import sample_car
from lidardraft.scene.road import PavedArea
from lidardraft.streets.placement.car_parks import CarPark
from lidardraft.streets.placement.district import SIDES, District
from lidardraft.streets.placement.occupancy import Occupancy

_DRIVE = (2.8, 6.0)  # m: a bay and what opens a car's doors; RASt 06 wants 5 m before a garage
_STEEPEST_DRIVE = 0.5  # m of rise over its length
_STEEP = 0.12  # m that a straight piece may leave the ground at its ends
BIN = (0.58, 0.62, 1.07)  # m: EN 840, 240 litres

Driveway = tuple[int, float]  # side and along


def tree_size(rng: np.random.Generator) -> tuple[tuple[float, float, float], float]:
    """Extents and height of the bare clearance; crowns measure 2 to 9 m, an estimate of ours for street trees."""
    height = rng.uniform(4.5, 13.0)
    crown = height * rng.uniform(0.42, 0.68)
    return (crown * rng.uniform(0.9, 1.1), crown, height), height * rng.uniform(0.08, 0.32)


def piece_length(occupancy: Occupancy, along: float, longest: float) -> float:
    """How long a level piece of a fence or a rail may be there [m]: bends and slopes are followed by short ones."""
    limit = min(longest, 7.0) if abs(occupancy.road.curvature) > 0.002 else longest
    return max(3.0, min(limit, 2 * _STEEP / max(abs(occupancy.ground.grade(along)), 1e-3)))


def place_driveways(occupancy: Occupancy, district: District, rng: np.random.Generator) -> list[Driveway]:
    """Paved drives beside houses, most with a car on it."""
    road = occupancy.road
    drives: list[Driveway] = []
    if district.setback[1] <= 2.0:
        return drives
    mean = 9.0 if district.fronts > 0.5 else 2.5
    for side in SIDES:
        for along in np.sort(rng.uniform(-0.95, 0.95, rng.poisson(mean * district.built))) * road.half_length:
            width, depth = _DRIVE
            x, y, yaw = road.at(along, side * (road.verge + depth / 2 + 0.1))
            size = (width, depth, 1.8)
            if not occupancy.is_free(x, y, yaw, size) or not occupancy.is_private(x, y, yaw, size):
                continue
            if any(side == other and abs(along - place) < 1.5 * width for other, place in drives):
                continue
            rise = occupancy.ground.heights(np.full(4, along), side * (road.verge + np.array([0.1, 1.9, 2.4, depth])))
            if np.ptp(rise) > _STEEPEST_DRIVE:
                continue  # no drive leads through a ditch
            drives.append((side, float(along)))
            if rng.random() < 0.7:
                kind, car = sample_car(rng)
                across = side * (road.verge + 0.5 + car[0] / 2)
                angle = (math.pi / 2 if rng.random() < 0.5 else -math.pi / 2) + rng.normal(0.0, 0.03)
                occupancy.place(kind, along, across, car, angle=angle, private=True)
            near, far = road.verge, road.verge + depth
            half = width / 2
            occupancy.pave(PavedArea((along - half, along + half), (near, far) if side > 0 else (-far, -near)))
    return drives


def place_front_fences(
    occupancy: Occupancy, district: District, drives: list[Driveway], car_park: CarPark | None, rng: np.random.Generator
) -> None:
    """What closes the front gardens: fences, walls or hedges in runs, with gates between and open at drives."""
    road = occupancy.road
    kinds = ("fence", "garden_wall", "hedge", "hedge", "hedge", "hedge", "hedge", "mesh_fence")
    for side in SIDES:
        if rng.random() > district.fronts or district.setback[1] < 2.0:
            continue
        along, off = -road.half_length, road.verge + rng.uniform(0.3, 0.9)
        gates = [place for other, place in drives if other == side]
        if car_park is not None and car_park.side == side:
            gates.append(car_park.gate)
        while along < road.half_length:
            kind = kinds[int(rng.integers(len(kinds)))]
            height = rng.uniform(0.8, 1.6) if kind != "hedge" else rng.uniform(1.1, 2.9)
            thick = {"fence": 0.1, "garden_wall": 0.3, "mesh_fence": 0.06, "hedge": rng.uniform(0.6, 1.2)}[kind]
            stop = min(along + rng.uniform(8.0, 28.0), road.half_length)
            while along < stop:
                length = min(piece_length(occupancy, along, 12.0), stop - along)
                gate = next((g for g in gates if g - 4.5 < along + length and along < g + 1.7), None)
                if gate is not None:
                    length = gate - 1.7 - along
                if length > 1.2:
                    across = side * (off + thick / 2)
                    size = (length - 0.1, thick, height)
                    occupancy.place(kind, along + length / 2, across, size, margin=0.0, private=True)
                along = along + length if gate is None else gate + 1.7
            along += rng.uniform(1.2, 4.0)


def place_yard_objects(occupancy: Occupancy, district: District, rng: np.random.Generator) -> None:
    """Bins, letterboxes, and bicycles behind the fences."""
    road = occupancy.road
    homes = district.built > 0.5
    for _ in range(rng.poisson(4 if homes else 0.5)):
        side, along = SIDES[int(rng.integers(2))], rng.normal(0.0, 35.0)
        across = side * (road.verge + rng.uniform(0.5, 2.0))
        pick = rng.random()
        if pick < 0.5:
            occupancy.place("bin", along, across, BIN, angle=rng.uniform(0, 3), private=True)
        elif pick < 0.75:
            angle = math.pi / 2 if side < 0 else -math.pi / 2
            occupancy.place("letterbox", along, side * (road.verge + 0.35), (0.35, 0.4, 1.2), angle=angle, private=True)
        else:
            occupancy.place("bicycle", along, across, (1.78, 0.58, 1.06), angle=rng.normal(0.0, 0.1), private=True)


def place_shrub_beds(occupancy: Occupancy, district: District, rng: np.random.Generator) -> None:
    """Shrubs in front of the houses, in beds of one kind."""
    road = occupancy.road
    depth = district.setback[1]
    if depth < 2.0 or district.built < 0.5:
        return
    for side in SIDES:
        along = -road.half_length
        while along < road.half_length:
            width = rng.uniform(0.8, 2.8)
            off = rng.uniform(0.6, max(0.7, 0.7 * depth - width))
            for _ in range(int(rng.integers(1, 5))):
                size = (width * rng.uniform(0.9, 1.45), width, width * rng.uniform(0.7, 1.3))
                across = side * (road.verge + off + width / 2 + rng.normal(0.0, 0.1))
                angle = rng.normal(0.0, 0.15)
                occupancy.place("bush", along + size[0] / 2, across, size, angle=angle, margin=0.0, private=True)
                along += size[0] * rng.uniform(0.95, 1.3)
            along += rng.exponential(3.0)


def place_thickets(occupancy: Occupancy, district: District, rng: np.random.Generator) -> None:
    """Thickets and runs of them along the backs of gardens, the edges of fields and the verges of roads."""
    road = occupancy.road
    for side in SIDES:
        for _ in range(rng.poisson(district.thickets)):
            along, off = rng.uniform(-1.0, 0.7) * road.half_length, road.verge + rng.uniform(1.0, 14.0)
            stop = min(along + rng.uniform(10.0, 60.0), road.half_length)
            while along < stop:
                width = rng.uniform(1.6, 4.2)
                length = width * rng.uniform(0.9, 1.45)
                size = (length, width, width * rng.uniform(0.7, 1.3))
                across = side * (off + width / 2 + rng.normal(0.0, 0.5))
                angle = rng.normal(0.0, 0.12)
                occupancy.place("bush", along + length / 2, across, size, angle=angle, margin=0.0, private=True)
                along += length * rng.uniform(1.0, 1.1)


def place_garden_plants(occupancy: Occupancy, district: District, rng: np.random.Generator) -> None:
    """Trees and bushes of gardens, parks and fields."""
    road = occupancy.road
    spread = 14.0 if district.built > 0.5 else 28.0
    for _ in range(rng.poisson(district.wild_trees)):
        side, along = SIDES[int(rng.integers(2))], rng.uniform(-1.0, 1.0) * road.half_length
        size, clearance = tree_size(rng)
        across = road.verge + 1.5 + rng.exponential(spread)
        if across < 55.0:
            occupancy.place(
                "tree",
                along,
                side * across,
                size,
                angle=rng.uniform(0, 3),
                clearance=clearance,
                margin=0.05,
                private=True,
            )
    for _ in range(rng.poisson(1.5 * district.wild_trees)):
        side, along = SIDES[int(rng.integers(2))], rng.uniform(-0.8, 0.8) * road.half_length
        width = rng.uniform(0.8, 3.6)
        across = road.verge + 0.6 + width / 2 + rng.exponential(0.4 * spread)
        size = (width * rng.uniform(0.8, 1.45), width, width * rng.uniform(0.6, 1.0))
        if across < 45.0:
            occupancy.place("bush", along, side * across, size, angle=rng.uniform(0, 3), margin=0.05, private=True)
