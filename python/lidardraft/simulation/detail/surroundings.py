"""What the rules ask of the layout around an object: its roads as frames along and across, where their shapes tell it
(rectangles, and strips along a bend), and whether fronts and backs are known."""

from __future__ import annotations

import math
from dataclasses import dataclass

from lidardraft.scene.layout import Layout
from lidardraft.simulation.detail.coarse_object import CoarseObject, UprightBox
from lidardraft.simulation.roads import RoadStrip, road_strips

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
        return cls(tuple(road_strips(layout)), not layout.intent.headed)

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
            x, y = strip.line.nearest(box.x, box.y)
            away = math.hypot(x - box.x, y - box.y) - strip.half
            if away < least:
                nearest, least = (x - box.x, y - box.y), away
        return nearest
