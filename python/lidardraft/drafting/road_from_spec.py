"""The road that a spec asks for, with room for everything that the spec puts on it."""

from __future__ import annotations

import numpy as np

from lidardraft.drafting.road_zones import queue_length
from lidardraft.drafting.scene_spec import ObjectGroup, SceneSpec, split_place
from lidardraft.errors import LayoutError
from lidardraft.scene.check import MAX_RANGE
from lidardraft.scene.road import LEFT, RIGHT, Road

HARD_SHOULDER = 3.0  # m, estimate of ours
MAX_DISTANCE = MAX_RANGE - 10.0  # m, that an object can be asked for at


def road_from_spec(spec: SceneSpec, rng: np.random.Generator) -> Road:
    """A road in the ego's frame, with what the spec leaves open sampled.

    Raises `LayoutError` on a distance that is further than a sensor sees.
    """
    kind = spec.road.kind
    motorway = kind == "motorway"
    lanes = spec.road.lanes or (int(rng.choice([2, 3])) if motorway else int(rng.choice([1, 2], p=[0.75, 0.25])))
    farthest = max((group.distance[1] for group in spec.groups if group.distance), default=0.0)
    if farthest > MAX_DISTANCE:
        raise LayoutError(f"distance is {farthest:g} m; objects can be asked for up to {MAX_DISTANCE:g} m away")
    queue = max((queue_length(group) for group in spec.groups if group.record.is_vehicle), default=0.0)
    half_length = max(80.0, farthest + 15.0, min(MAX_DISTANCE, queue + 10.0))
    wanted = spec.road.sidewalk
    sidewalk = float(rng.uniform(1.8, 3.0)) if wanted or (wanted is None and not motorway) else 0.0
    bend = {"left-bend": 1.0, "right-bend": -1.0, "bend": float(rng.choice([-1, 1]))}.get(kind, 0.0)
    crossing = kind in ("crossroads", "t-junction") or any(group.crosses for group in spec.groups)
    lane_width = 3.75 if motorway else float(rng.uniform(3.3, 3.7))
    parking = HARD_SHOULDER if motorway else _parking_width(spec, lanes)
    near = lanes * lane_width + parking + sidewalk + 6.0
    return Road(
        lanes=lanes,
        ego_lane=1 if lanes > 1 and any(_on_the_right(group) for group in spec.groups) else 0,
        lane_width=lane_width,
        parking=parking,
        sidewalk=sidewalk,
        curvature=bend / float(rng.uniform(90.0, 160.0)),
        junction=float(rng.uniform(near, near + 12.0)) if crossing else None,
        side_roads=(int(rng.choice([LEFT, RIGHT])),) if kind == "t-junction" else (LEFT, RIGHT),
        half_length=half_length,
    )


def _on_the_right(group: ObjectGroup) -> bool:
    right = any(split_place(place)[1] == "right" for place in group.places)
    return right and group.record.drives and group.heading in (None, "with")


def _parking_width(spec: SceneSpec, lanes: int) -> float:
    parked = [
        group.record for group in spec.groups if group.heading == "parked" or (lanes == 1 and _on_the_right(group))
    ]
    return max((kind.parking_width for kind in parked if kind.is_vehicle), default=0.0)
