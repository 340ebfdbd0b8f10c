"""What the rules ask of the layout around an object: its roads, and whether fronts and backs are known."""

from __future__ import annotations

import math
from dataclasses import dataclass

from lidardraft.scene.layout import Layout
from lidardraft.simulation.coarse_object import CoarseObject, UprightBox
from lidardraft.simulation.road_strip import RoadStrip, road_strips

# What clusterings call themselves: their boxes are turned by -90 to 90 degrees, as front and back look alike.
_CLUSTERINGS = ("cloud", "point cloud")
LANE_SIDE = 1.75  # m, half a lane: what stands further to the left comes towards the ego vehicle
_ALONG = math.cos(math.radians(40.0))  # what is turned by less against the ego vehicle drives along its road
_WITH_LANE = 0.95  # share of vehicles along a road that stand in its direction: an estimate of ours


@dataclass(frozen=True, slots=True, eq=False)
class Surroundings:
    """`strips` are the roads whose frame can be told; `clustered` is whether boxes know no front from back."""

    strips: tuple[RoadStrip, ...]
    clustered: bool

    @classmethod
    def of(cls, layout: Layout) -> Surroundings:
        """Those of the objects of a layout."""
        provenance = layout.provenance
        clustered = provenance.get("source") in _CLUSTERINGS or "sensor_height" in provenance
        return cls(tuple(road_strips(layout)), clustered)

    def headed(self, coarse: CoarseObject, box: UprightBox) -> UprightBox:
        """The box with its likelier heading, where it knows no front from back: that of its lane, or any."""
        if not self.clustered:
            return box
        chance = float(coarse.rng.random())
        ahead = math.cos(box.yaw)
        if abs(ahead) < _ALONG:
            return box.turned(2) if chance < 0.5 else box
        with_ego = (box.y <= LANE_SIDE) == (chance < _WITH_LANE)
        return box if (ahead > 0.0) == with_ego else box.turned(2)

    def road_side(self, box: UprightBox) -> tuple[float, float]:
        """The direction (x, y) from an object to the nearest road, or to the ego vehicle where none is known."""
        nearest, least = (-box.x, -box.y), math.inf
        for strip in self.strips:
            x, y = strip.nearest(box.x, box.y)
            away = math.hypot(x - box.x, y - box.y) - strip.half
            if away < least:
                nearest, least = (x - box.x, y - box.y), away
        return nearest
