"""What private people have, and what grows there."""

from dataclasses import replace

import numpy as np

from lidardraft.scene.road import Road
from lidardraft.streets.ground.ground import Ground
from lidardraft.streets.ground.relief import Land
from lidardraft.streets.placement.district import DISTRICTS
from lidardraft.streets.placement.gardens import (
    place_driveways,
    place_front_fences,
    place_garden_plants,
    place_shrub_beds,
    place_thickets,
    place_yard_objects,
)
from lidardraft.streets.placement.occupancy import Occupancy

FLAT = Land(grade=0.0, hillside=0.0, rolling=0.0)


def empty(road: Road) -> Occupancy:
    return Occupancy(road, Ground(road, np.random.default_rng(0), FLAT))


def test_driveways_lead_to_the_verge_and_stay_open():
    seen = 0
    for seed in range(10):
        occupancy = empty(Road())
        rng = np.random.default_rng(seed)
        driveways = place_driveways(occupancy, DISTRICTS["residential"], rng)
        place_front_fences(occupancy, replace(DISTRICTS["residential"], front_fences=1.0), driveways, None, rng)
        fences = [p for p in occupancy._placed if p.kind in ("fence", "garden_wall", "hedge", "mesh_fence")]
        assert fences
        for side, along in driveways:
            seen += 1
            for fence in fences:
                if fence.across * side > 0:
                    assert abs(fence.along - along) > fence.size[0] / 2 + 1.4, (fence, along)
    assert seen > 50


def test_no_driveway_leads_through_a_ditch():
    road = Road(sidewalk=0.0)
    counts = []
    for ditch in (0.0, 1.0):
        ground = Ground(road, np.random.default_rng(0), replace(FLAT, ditch=ditch))
        counts.append(len(place_driveways(Occupancy(road, ground), DISTRICTS["residential"], np.random.default_rng(1))))
    assert counts[0] > 3
    assert counts[1] < counts[0]


def test_closed_fronts_have_no_front_gardens():
    occupancy = empty(Road())
    assert place_driveways(occupancy, DISTRICTS["urban"], np.random.default_rng(0)) == []
    place_front_fences(occupancy, replace(DISTRICTS["urban"], front_fences=1.0), [], None, np.random.default_rng(0))
    place_shrub_beds(occupancy, DISTRICTS["urban"], np.random.default_rng(0))
    assert occupancy._placed == []


def test_gardens_begin_behind_the_verge():
    occupancy = empty(Road())
    district, rng = DISTRICTS["residential"], np.random.default_rng(0)
    for _ in range(4):
        place_yard_objects(occupancy, district, rng)
    for place in (place_shrub_beds, place_thickets, place_garden_plants):
        before = len(occupancy._placed)
        place(occupancy, district, rng)
        assert len(occupancy._placed) > before, place.__name__
    for placed in occupancy._placed:
        assert abs(placed.across) > occupancy.road.verge, placed
    assert {"bush", "tree", "bin", "bicycle"} <= {placed.kind for placed in occupancy._placed}
