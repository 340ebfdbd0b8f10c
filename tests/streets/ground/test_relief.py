"""How the land lies."""

import math

import numpy as np
import pytest
from planned import occupancies

from lidardraft.scene.road import Road
from lidardraft.streets.ground.relief import SECTION, Land, Relief
from lidardraft.streets.placement.occupancy import Occupancy


def test_the_road_rises_and_falls():
    rise = [
        float(np.ptp(occupancy.ground.heights(np.linspace(-80, 80, 81), np.zeros(81)))) for occupancy in occupancies()
    ]
    assert np.median(rise) > 0.5
    assert max(rise) < 8.0
    for occupancy in occupancies():
        grades = [occupancy.ground.grade(float(along)) for along in np.linspace(-90, 90, 31)]
        assert max(map(abs, grades)) < 0.061


def horizon(occupancy: Occupancy) -> np.ndarray:
    """Elevation [rad] of the land's edge around a sensor over the middle of the street."""
    along, across = np.meshgrid(np.linspace(-80, 80, 41), np.linspace(-60, 60, 31), indexing="ij")
    heights = occupancy.ground.heights(along.ravel(), across.ravel())
    distance = np.hypot(along.ravel(), across.ravel())
    far = distance > 15.0
    elevation = np.arctan2(heights[far] - occupancy.ground.height(0.0, 0.0) - 1.73, distance[far])
    sector = ((np.arctan2(across.ravel(), along.ravel())[far] + math.pi) / (2 * math.pi) * 24).astype(int) % 24
    return np.array([elevation[sector == number].max() for number in range(24)])


def test_the_horizon_is_no_flat_line():
    spread = [float(np.ptp(horizon(occupancy))) for occupancy in occupancies()]
    # a flat plane of this extent has a horizon between -0.029 and -0.015 rad
    assert np.median(spread) > 0.02
    assert max(spread) > 0.1


def test_heights_are_the_same_from_all_sides():
    for occupancy in occupancies()[::6]:
        rng = np.random.default_rng(1)
        along, across = rng.uniform(-80, 80, 300), rng.uniform(-50, 50, 300)
        step = 1e-4
        jump = np.abs(
            occupancy.ground.relief.heights(along + step, across + step)
            - occupancy.ground.relief.heights(along, across)
        )
        assert jump.max() < 1e-2


def test_ditches_and_banks_are_beside_the_road_only_where_the_land_has_them():
    road = Road(sidewalk=0.0)
    flat, cut = Land(grade=0.0, hillside=0.0, rolling=0.0), Land(grade=0.0, hillside=0.0, rolling=0.0, ditch=1.0)
    across = road.verge + np.array([0.0, *SECTION])
    along = np.zeros(len(across))
    plain = Relief(road, flat, np.random.default_rng(3)).heights(along, across)
    ditched = Relief(road, cut, np.random.default_rng(3)).heights(along, across)
    assert np.ptp(plain) < 0.05
    assert -0.7 < ditched.min() < -0.25
    assert across[int(ditched.argmin())] - road.verge == pytest.approx(SECTION[1])


def test_the_island_of_a_roundabout_rises_to_its_middle():
    road = Road(junction=10.0, roundabout_radius=18.0)
    relief = Relief(road, Land(grade=0.0, rolling=0.0), np.random.default_rng(0))
    heights = relief.heights(10.0 + np.array([0.0, 5.0, road.island]), np.zeros(3))
    assert heights[0] > heights[1] > heights[2]
