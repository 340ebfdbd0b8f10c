"""Car parks beside the road, and what stands on them."""

import math

import numpy as np
import pytest
from planned import occupancies

from lidardraft.scene.road import LEFT, RIGHT, Road
from lidardraft.streets.placement.car_parks import AISLE_WIDTH, BAY_LENGTH, BAY_WIDTH, sample_car_park


def test_cars_in_a_car_park_stand_in_bays():
    seen = 0
    for occupancy in occupancies():
        for area in occupancy.road.paved_areas[:1]:
            for placed in occupancy._placed:
                turned = abs(math.sin(placed.angle)) > 0.9
                if turned and area.along[0] < placed.along < area.along[1] and placed.kind in ("suv", "hatchback"):
                    if not area.across[0] < placed.across < area.across[1]:
                        continue
                    share = (placed.along - area.along[0]) / BAY_WIDTH - 0.5
                    assert abs(share - round(share)) < 0.3
                    into = (abs(placed.across) - min(map(abs, area.across))) % (2 * BAY_LENGTH + AISLE_WIDTH)
                    assert min(abs(into - BAY_LENGTH / 2), abs(into - 1.5 * BAY_LENGTH - AISLE_WIDTH)) < 0.5
                    seen += 1
    assert seen > 50


@pytest.mark.parametrize("modules", [1, 2])
def test_a_car_park_lies_behind_the_verge_and_its_way_in_leads_to_the_road(modules: int):
    road = Road()
    for seed in range(20):
        car_park = sample_car_park(road, modules, np.random.default_rng(seed))
        near, far = sorted(map(abs, car_park.paved_area.across))
        assert near > road.verge
        assert far - near == pytest.approx(modules * (2 * BAY_LENGTH + AISLE_WIDTH))
        assert np.sign(car_park.paved_area.across).tolist() == [car_park.side] * 2
        assert sorted(map(abs, car_park.access.across)) == pytest.approx([road.edge, near])
        assert car_park.paved_area.along[0] < car_park.access.along[0] < car_park.access.along[1]
        assert car_park.access.along[1] < car_park.paved_area.along[1]
        assert len(car_park.aisles) == modules
        for across, toward in car_park.rows:
            # an aisle is where each row says
            assert (
                min(abs(across + toward * (BAY_LENGTH + AISLE_WIDTH) / 2 - aisle) for aisle in car_park.aisles) < 1e-9
            )


def test_a_car_park_is_clear_of_side_roads():
    for seed in range(20):
        rng = np.random.default_rng(seed)
        assert sample_car_park(Road(junction=5.0, side_roads=(RIGHT,)), 1, rng).side == LEFT
        road = Road(junction=5.0)
        start, end = sample_car_park(road, 1, rng).paved_area.along
        assert start > 5.0 + road.verge or end < 5.0 - road.verge
