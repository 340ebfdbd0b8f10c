"""Bays of a parking lot: rows at right angles to the aisle that the ego drives in, and to one further aisle a side."""

from __future__ import annotations

import math

import numpy as np

from lidardraft.drafting.road_pose import PoseSampler, RoadPose, alternate, turned
from lidardraft.drafting.sentence_kinds import SentenceKind
from lidardraft.scene.road import Road

# EAR 05 and RASt 06: bays of 2.5 x 5.0 m at right angles to an aisle of 6.0 m.
BAY_WIDTH, BAY_LENGTH, AISLE_WIDTH = 2.5, 5.0, 6.0
LOT_DEPTH = 3 * BAY_LENGTH + AISLE_WIDTH  # m from the ego's aisle: two rows back to back, an aisle, a row
_ROWS = ((0.5 * BAY_LENGTH, -1), (1.5 * BAY_LENGTH, 1), (LOT_DEPTH - 0.5 * BAY_LENGTH, -1))  # m; where the aisle lies
# Estimates of ours.
_NOSE_IN = 0.75  # share of the vehicles
_OFF_MIDDLE = 0.1  # m along, at most
_WALKER_OFF = 2.0  # m from the middle of an aisle, at most


def in_bay(kind: SentenceKind, road: Road, sides: tuple[int, ...]) -> PoseSampler:
    """In the bay nearest to a distance along, row by row as they fill; what is too long for one stands along a row."""
    assert kind.sizes is not None

    long = kind.sizes.largest[0] > BAY_LENGTH + 0.5

    def sample(rng: np.random.Generator, along: float, number: int, effort: float) -> RoadPose:
        side = alternate(sides, number)
        row = min(len(_ROWS) - 1, int(rng.random() * (1.0 + len(_ROWS) * effort)))
        across, aisle = _ROWS[row]
        if long:
            return RoadPose(along, side * (road.edge + across), turned(rng, 0.0))
        start, end = road.paved_areas[0].along
        bay = min(int((end - start) / BAY_WIDTH) - 1, max(0, int((along - start) / BAY_WIDTH)))
        middle = start + (bay + 0.5) * BAY_WIDTH + float(rng.uniform(-_OFF_MIDDLE, _OFF_MIDDLE))
        toward = aisle if rng.random() > _NOSE_IN else -aisle
        return RoadPose(middle, side * (road.edge + across), turned(rng, side * toward * math.pi / 2))

    return sample


def in_aisle(road: Road, sides: tuple[int, ...]) -> PoseSampler:
    """On foot in an aisle of the lot."""
    further = road.edge + 2 * BAY_LENGTH + AISLE_WIDTH / 2

    def sample(rng: np.random.Generator, along: float, number: int, effort: float) -> RoadPose:
        side = alternate(sides, number)
        far = rng.random() < 0.3 + 0.4 * effort
        beside = min(max(0.5, side * road.lane(road.ego_lane) + 0.1), road.edge - 0.1)  # of the ego
        across = (
            further + float(rng.uniform(-_WALKER_OFF, _WALKER_OFF)) if far else float(rng.uniform(beside, road.edge))
        )
        return RoadPose(along, side * across, float(rng.uniform(-math.pi, math.pi)))

    return sample
