"""Bays and aisles of a parking lot."""

import math

import numpy as np

from lidardraft.drafting.solver.parking_bays import (
    BAY_LENGTH,
    BAY_WIDTH,
    LOT_DEPTH,
    LOT_DEPTHS,
    in_aisle,
    in_bay,
    lot_edge,
    row_poses,
)
from lidardraft.drafting.solver.sentence_kinds import SENTENCE_KINDS
from lidardraft.scene.road import PavedArea, Road

EDGE = 3.0
LOT = Road(
    lane_width=EDGE,
    sidewalk=0.0,
    paved_areas=tuple(PavedArea((-30.0, 30.0), a) for a in ((-EDGE - LOT_DEPTH, -EDGE), (EDGE, EDGE + LOT_DEPTH))),
)


def test_cars_stand_in_bays_at_right_angles_to_the_aisle() -> None:
    rng = np.random.default_rng(0)
    for number in range(60):
        pose = in_bay(SENTENCE_KINDS["car"], LOT, (1, -1))(rng, -29.0 + number, number, number / 60)
        assert abs(math.sin(pose.yaw)) > 0.99
        assert min(abs(abs(pose.across) - EDGE - row) for row in (2.5, 7.5, 18.5)) < 1e-9
        assert abs((pose.along + 30.0) / BAY_WIDTH % 1.0 - 0.5) < 0.05


def test_what_is_longer_than_a_bay_stands_along_a_row() -> None:
    rng = np.random.default_rng(0)
    assert abs(math.sin(in_bay(SENTENCE_KINDS["bus"], LOT, (1,))(rng, 0.0, 0, 0.0).yaw)) < 0.1


def test_what_is_at_a_distance_stands_there_exactly() -> None:
    sample = in_bay(SENTENCE_KINDS["car"], LOT, (1, -1), exactly=True)
    assert sample(np.random.default_rng(0), 12.3, 0, 0.0).along == 12.3


def test_a_lot_of_one_row_has_no_others() -> None:
    road = Road(lane_width=EDGE, sidewalk=0.0, paved_areas=(PavedArea((-30.0, 30.0), (EDGE, EDGE + LOT_DEPTHS[-1])),))
    assert lot_edge(road, 1) == EDGE + BAY_LENGTH
    assert lot_edge(road, -1) == EDGE
    assert [across for across, _ in row_poses(road, 1)] == [EDGE + 2.5]
    assert len(row_poses(LOT, -1)) == 3


def test_people_walk_in_the_aisles() -> None:
    rng = np.random.default_rng(0)
    for number in range(60):
        across = abs(in_aisle(LOT, (1, -1))(rng, 0.0, number, 0.5).across)
        assert across < EDGE or EDGE + 10.0 < across < EDGE + 16.0
