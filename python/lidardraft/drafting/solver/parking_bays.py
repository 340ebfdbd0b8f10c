"""Bays of a parking lot: rows at right angles to the aisle that the ego drives in, and to one further aisle a side."""

from __future__ import annotations

import math

import numpy as np

from lidardraft.drafting.solver.road_pose import PoseSampler, RoadPose, alternate, turned
from lidardraft.drafting.solver.sentence_kinds import SentenceKind
from lidardraft.scene.road import Road

# EAR 05 and RASt 06: bays of 2.5 x 5.0 m at right angles to an aisle of 6.0 m.
BAY_WIDTH, BAY_LENGTH, AISLE_WIDTH = 2.5, 5.0, 6.0
LOT_DEPTH = 3 * BAY_LENGTH + AISLE_WIDTH  # m from the ego's aisle: two rows back to back, an aisle, a row
LOT_DEPTHS = (LOT_DEPTH, 2 * BAY_LENGTH, BAY_LENGTH)  # m, of three rows, two, and one
_ROWS = ((0.5 * BAY_LENGTH, -1), (1.5 * BAY_LENGTH, 1), (LOT_DEPTH - 0.5 * BAY_LENGTH, -1))  # m; where the aisle lies
# Estimates of ours.
_NOSE_IN = 0.75  # share of the vehicles
_FULL = (0.5, 0.8)  # share of the bays of the first rows that many vehicles take
_OFF_MIDDLE = 0.1  # m along, at most
_WALKER_OFF = 2.0  # m from the middle of an aisle, at most


def lot_edge(road: Road, side: int) -> float:
    """How far across the road a parking lot reaches on a side (1, -1) from the centreline [m]; the kerb without one."""
    return max([road.edge, *(side * across for area in road.paved_areas for across in area.across)])


def row_poses(road: Road, side: int) -> list[tuple[float, float]]:
    """`across` [m] and yaw [rad] of who stands nose in, in each row of bays on a side of a parking lot."""
    depth = lot_edge(road, side) - road.edge
    rows = [(off, aisle) for off, aisle in _ROWS if off < depth]
    return [(side * (road.edge + off), side * aisle * math.pi / 2) for off, aisle in rows]


def sample_full(road: Road, rng: np.random.Generator) -> int:
    """How many vehicles fill the first rows of a parking lot."""
    start, end = road.paved_areas[0].along
    return int(2 * (end - start) / BAY_WIDTH * float(rng.uniform(*_FULL)))


def in_bay(kind: SentenceKind, road: Road, sides: tuple[int, ...], *, exactly: bool = False) -> PoseSampler:
    """In the bay nearest to a distance along, row by row as they fill; what is too long for one stands along a row.

    Bays begin anywhere for what stands `exactly` at a distance.
    """
    assert kind.sizes is not None

    long = kind.sizes.largest[0] > BAY_LENGTH + 0.5

    def sample(rng: np.random.Generator, along: float, number: int, effort: float) -> RoadPose:
        side = alternate(sides, number)
        rows = row_poses(road, side)
        across, nose_in = rows[min(len(rows) - 1, int(rng.random() * (1.0 + len(_ROWS) * effort)))]
        if long:
            return RoadPose(along, across, turned(rng, 0.0))
        start, end = road.paved_areas[0].along
        bay = min(int((end - start) / BAY_WIDTH) - 1, max(0, int((along - start) / BAY_WIDTH)))
        middle = start + (bay + 0.5) * BAY_WIDTH + float(rng.uniform(-_OFF_MIDDLE, _OFF_MIDDLE))
        yaw = nose_in if rng.random() > _NOSE_IN else -nose_in
        return RoadPose(along if exactly else middle, across, turned(rng, yaw))

    return sample


def in_aisle(road: Road, sides: tuple[int, ...]) -> PoseSampler:
    """On foot in an aisle of the lot."""
    further = road.edge + 2 * BAY_LENGTH + AISLE_WIDTH / 2

    def sample(rng: np.random.Generator, along: float, number: int, effort: float) -> RoadPose:
        side = alternate(sides, number)
        far = rng.random() < 0.3 + 0.4 * effort and lot_edge(road, side) > further
        beside = min(max(0.5, side * road.lane(road.ego_lane) + 0.1), road.edge - 0.1)  # of the ego
        across = (
            further + float(rng.uniform(-_WALKER_OFF, _WALKER_OFF)) if far else float(rng.uniform(beside, road.edge))
        )
        return RoadPose(along, side * across, float(rng.uniform(-math.pi, math.pi)))

    return sample
