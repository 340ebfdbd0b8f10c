"""Poses at a distance from the kerb or from the sidewalk."""

from __future__ import annotations

import math

import numpy as np

from lidardraft.drafting.solver.object_shapes import STANDING, ObjectPart
from lidardraft.drafting.solver.parking_bays import lot_edge
from lidardraft.drafting.solver.road_pose import BACKWARDS, PoseSampler, RoadPose, alternate
from lidardraft.drafting.solver.scene_spec import ObjectGroup
from lidardraft.drafting.solver.sentence_kinds import SentenceKind
from lidardraft.scene.road import Road


def set_back(group: ObjectGroup, kind: SentenceKind, road: Road, sides: tuple[int, ...]) -> PoseSampler:
    """Where the near side stands, at a distance from the kerb or the sidewalk."""
    inwards = _lies_inwards(group)
    near, far = group.from_road or group.from_sidewalk or (0.0, 0.0)

    def sample(rng: np.random.Generator, along: float, number: int, _effort: float) -> RoadPose:
        side, off = alternate(sides, number), float(rng.uniform(near, far))
        base = road.edge if inwards else lot_edge(road, side) + (road.sidewalk if group.from_road is None else 0.0)
        backwards = side > 0 and not (kind.drives and road.one_way)
        return RoadPose(along, side * (base - off if inwards else base + off), BACKWARDS if backwards else 0.0)

    return sample


def with_near_side_at(group: ObjectGroup, pose: RoadPose, parts: list[ObjectPart]) -> RoadPose:
    """The pose whose near side, of what stands on the ground, is where the middle was."""
    cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
    out = math.copysign(1.0, pose.across) * (-1.0 if _lies_inwards(group) else 1.0)
    near = [
        out * (sin * part.center[0] + cos * part.center[1]) - (abs(sin) * part.size[0] + abs(cos) * part.size[1]) / 2
        for part in parts
        if part.center[2] - part.size[2] / 2 < STANDING
    ]
    return pose._replace(across=pose.across - out * min(near, default=0.0))


def _lies_inwards(group: ObjectGroup) -> bool:
    """Whether a distance from the kerb is meant towards the middle of the road."""
    return group.record.drives or group.surface == "road"
