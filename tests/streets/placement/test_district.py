"""The records of districts, and the roads through them."""

from dataclasses import replace

import numpy as np
import pytest

from lidardraft.scene.road import LEFT, RIGHT, Road
from lidardraft.streets.placement.district import DISTRICTS, PARKING_STRIP, sample_road


def roads(name: str, count: int = 200, **options: bool) -> list[Road]:
    rng = np.random.default_rng(1)
    return [sample_road(DISTRICTS[name], (), 90.0, rng, **options) for _ in range(count)]


@pytest.mark.parametrize("name", DISTRICTS)
def test_roads_keep_to_what_their_district_says(name: str):
    district = DISTRICTS[name]
    found = roads(name)
    assert {road.lanes for road in found} == set(district.lanes)
    for road in found:
        assert district.lane_width[0] <= road.lane_width <= district.lane_width[1]
        assert district.sidewalk[0] <= road.sidewalk <= district.sidewalk[1]
        assert road.curvature == 0.0 or road.junction is None
        assert road.roundabout_radius is None or 13.0 <= road.roundabout_radius <= 25.0
    junctions = np.mean([road.junction is not None for road in found])
    # four standard deviations of a binomial draw
    assert junctions == pytest.approx(district.junction, abs=4 * (0.25 / len(found)) ** 0.5)


def test_a_road_is_straight_beside_a_car_park():
    assert any(road.curvature or road.roundabout_radius for road in roads("retail"))
    assert not any(road.curvature or road.roundabout_radius for road in roads("retail", car_park=True))


def test_parked_cars_widen_the_only_lane():
    district = replace(DISTRICTS["residential"], lane_width=(3.0, 3.0))
    widths = [
        sample_road(district, parking, 90.0, np.random.default_rng(0)).lane_width
        for parking in ((), (RIGHT,), (RIGHT, LEFT))
    ]
    assert widths == pytest.approx([3.0, 3.0 + PARKING_STRIP / 2, 3.0 + PARKING_STRIP])


def test_shares_of_districts_add_up():
    assert sum(district.share for district in DISTRICTS.values()) == pytest.approx(1.0)
    assert [name for name, district in DISTRICTS.items() if district.closed_fronts] == ["urban"]


def test_a_median_barrier_has_a_median_to_stand_in():
    for name, district in DISTRICTS.items():
        if district.equipment.median_barrier:
            assert all(road.median > 2.0 for road in roads(name))
