"""The layout around an object, for the rules of detail: its roads as frames along and across, if their shapes give
these (rectangles, and strips along a bend), and whether headings are known."""

from __future__ import annotations

import math
from dataclasses import dataclass

from lidardraft.scene.layout import Layout
from lidardraft.simulation.detail.coarse_object import CoarseObject, UprightBox
from lidardraft.simulation.roads import RoadStrip, road_strips

LANE_SIDE = 1.75  # m, half a lane: objects further to the left are oncoming
_ALONG = math.cos(math.radians(40.0))  # objects turned by less against the ego vehicle drive along its road
_WITH_LANE = 0.95  # share of vehicles along a road that head in its direction: an estimate


@dataclass(frozen=True, slots=True, eq=False)
class Surroundings:
    """`strips` are the roads with a known frame; `clustered` is whether the headings of boxes are unknown."""

    strips: tuple[RoadStrip, ...]
    clustered: bool

    @classmethod
    def of(cls, layout: Layout) -> Surroundings:
        """The surroundings of the objects of a layout."""
        return cls(tuple(road_strips(layout)), not layout.intent.headed)

    def headed(self, coarse: CoarseObject, box: UprightBox) -> UprightBox:
        """The box as it is or, if its heading is unknown, with a likely one: that of its lane, or either."""
        if not self.clustered:
            return box
        chance = float(coarse.rng.random())
        ahead = math.cos(box.yaw)
        if abs(ahead) < _ALONG:
            return box.turned(2) if chance < 0.5 else box
        with_ego = (box.y <= LANE_SIDE) == (chance < _WITH_LANE)
        return box if (ahead > 0.0) == with_ego else box.turned(2)

    def road_side(self, box: UprightBox) -> tuple[float, float]:
        """The direction (x, y) from an object to the nearest road, or to the ego vehicle if no road is known."""
        nearest, least = (-box.x, -box.y), math.inf
        for strip in self.strips:
            x, y = strip.line.nearest(box.x, box.y)
            away = math.hypot(x - box.x, y - box.y) - strip.half
            if away < least:
                nearest, least = (x - box.x, y - box.y), away
        return nearest
