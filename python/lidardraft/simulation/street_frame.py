"""The road that a street around a layout stands along: what its source says, or what its shapes tell."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from lidardraft.arranging.district import District, setting
from lidardraft.errors import LayoutError
from lidardraft.scene.check import VEHICLE_LABELS, LayoutGround
from lidardraft.scene.layout import Layout
from lidardraft.scene.pose import Place, point_at
from lidardraft.scene.road import TERRAIN_HEIGHT, PavedArea, Road
from lidardraft.simulation.surroundings import RoadStrip, road_strips

_LANE = 3.5  # m, usual
_LANE_WIDTHS = (2.5, 6.0)  # m, of one that a drawn road can have
_SIDEWALK = 2.5  # m, of roads of which nobody says that they have none
_BEYOND_BOXES = 0.05  # m over the plane of boxes, of the land beside their road
_HALF_LENGTHS = (40.0, 110.0)  # m
_MOST_OFF = 0.75  # m that a drawn road may leave the arc that is taken for it, as far as `_CHECKED` [m] from the ego
_CHECKED = 60.0
_SLOW_TURN = 0.35  # rad against the ego vehicle; what is turned by more does not drive along its road
_VEHICLE_HALF = 1.0  # m
_WIDEST_PICTURE = math.radians(170.0)


class NoStreetError(LayoutError):
    """Why a layout gets no street."""


class Pavement(NamedTuple):
    """A paved rectangle of a layout, of a length and width [m], with the label "road" or "sidewalk"."""

    place: Place
    size: tuple[float, float]
    label: str


class StreetFrame(NamedTuple):
    """`road`, and its `place` in the layout; the height of the `plain` around it [m]; which of its surfaces the layout
    `lacks`: "sidewalk", "terrain", or all but in the picture with "road".

    Of a drawn road, what is `paved` besides it, and how far [m] along it is drawn: `ends`.
    """

    road: Road
    place: Place = (0.0, 0.0, 0.0)
    plain: float = TERRAIN_HEIGHT
    lacks: tuple[str, ...] = ()
    paved: tuple[Pavement, ...] = ()
    ends: tuple[float, float] | None = None


def street_frame(layout: Layout) -> StreetFrame:
    """The frame of the road that a layout shows under the ego vehicle; raises `NoStreetError` where there is none."""
    if "road" in layout.provenance:
        return StreetFrame(road_of(layout.provenance["road"]))
    if layout.coverage is not None:
        if layout.coverage[1] - layout.coverage[0] > _WIDEST_PICTURE:
            raise NoStreetError("no street around it: it shows everything around already")
        return StreetFrame(Road(lanes=1, lane_width=_LANE, sidewalk=_SIDEWALK), lacks=("road", "sidewalk", "terrain"))
    if any(primitive.open and primitive.label == "road" for primitive in layout):  # boxes say nothing of the ground
        return StreetFrame(_road_of_boxes(layout), plain=_BEYOND_BOXES, lacks=("sidewalk", "terrain"))
    strips = [strip for strip in road_strips(layout) if abs(strip.along_across(np.zeros((1, 2)))[1][0]) < strip.half]
    if not strips:
        raise NoStreetError("no street around it: it has no road under the ego vehicle that could be followed")
    return _drawn(max(strips, key=lambda strip: strip.length), layout)


def road_of(fields: dict[str, Any]) -> Road:
    """The road of the provenance of a layout from a spec."""
    areas = tuple(PavedArea(tuple(area["along"]), tuple(area["across"])) for area in fields["paved_areas"])
    return Road(**{**fields, "paved_areas": areas, "side_roads": tuple(fields["side_roads"])})


def district_of(layout: Layout, road: Road) -> District:
    """Where a road of a layout leads: as its surroundings or its sentence say, or as it looks."""
    intent = layout.intent
    return setting(intent.around or intent.district or only_district(road, intent.road) or "urban")


def only_district(road: Road, kind: str | None) -> str | None:
    """The name of the district that a road of a spec's `kind` leads through, if it can be no other."""
    if road.paved_areas:
        return "retail"
    if road.sidewalk == 0:
        return "motorway" if road.median > 0 or kind == "motorway" else "country"
    return None


def _road_of_boxes(layout: Layout) -> Road:
    """A straight road with a lane for each vehicle that drives along it."""
    aside = [
        primitive.center[1]
        for primitive in layout
        if primitive.label in VEHICLE_LABELS
        and abs(math.sin(primitive.yaw)) < _SLOW_TURN
        and math.hypot(*primitive.center[:2]) < _CHECKED
    ]
    right, left = min([0.0, *aside]), max([_LANE, *aside])
    ego_lane = min(max(math.ceil((-right + _VEHICLE_HALF) / _LANE - 0.5), 0), 2)
    others = min(max(math.ceil((left + _VEHICLE_HALF) / _LANE - 0.5), 1), 4)
    lanes = ego_lane + max(1, (others + 1 - ego_lane) // 2)
    return Road(
        lanes=lanes,
        oncoming_lanes=max(1, ego_lane + 1 + others - lanes),
        ego_lane=ego_lane,
        lane_width=_LANE,
        sidewalk=_SIDEWALK,
    )


def _drawn(strip: RoadStrip, layout: Layout) -> StreetFrame:
    """The frame of a drawn road: its lanes and its bend, as an arc through its middle line at the ego vehicle."""
    lanes = max(1, round(strip.half / _LANE))
    width = strip.half / lanes
    if not _LANE_WIDTHS[0] <= width <= _LANE_WIDTHS[1]:
        raise NoStreetError(f"no street around it: its road is {2 * strip.half:.1f} m wide")
    along = float(strip.along_across(np.zeros((1, 2)))[0][0])
    before, behind = strip.length - along, along
    x, y, yaw, curvature = _arc(strip, along)
    half_length = min(max(before, behind, _HALF_LENGTHS[0]), _HALF_LENGTHS[1])
    if curvature:
        half_length = min(half_length, 1.5 / abs(curvature))
    walk = _sidewalk(strip, layout, along)
    road = Road(lanes=lanes, lane_width=width, sidewalk=walk or _SIDEWALK, curvature=curvature, half_length=half_length)
    _check_arc(strip, road, (x, y, yaw), along)
    # the road's frame has its origin in the middle of the ego's lane
    place = (*point_at((x, y, yaw), 0.0, road.lane(road.ego_lane)), yaw)
    paved = tuple(_other_pavement(layout, strip))
    return StreetFrame(road, place, lacks=() if walk else ("sidewalk",), paved=paved, ends=(-behind, before))


def _other_pavement(layout: Layout, own: RoadStrip) -> Iterator[Pavement]:
    """What is paved beside the own road, in pieces that follow bends."""
    strips = {strip.id: strip for strip in road_strips(layout) if strip.id != own.id}
    for primitive in layout:
        if primitive.label not in ("road", "sidewalk") or primitive.id == own.id:
            continue
        if primitive.id in strips:
            for (x, y), (u, v) in itertools.pairwise(strips[primitive.id].middle.tolist()):
                size = (math.dist((x, y), (u, v)), 2 * strips[primitive.id].half)
                yield Pavement(((x + u) / 2, (y + v) / 2, math.atan2(v - y, u - x)), size, "road")
        elif primitive.mesh is None:
            place = (*primitive.center[:2], primitive.yaw)
            yield Pavement(place, (primitive.size[0], primitive.size[1]), primitive.label)


def _arc(strip: RoadStrip, along: float) -> tuple[float, float, float, float]:
    """x, y, heading and curvature of a strip's middle line there."""
    span = min(_CHECKED / 2, strip.length / 4)
    middle = min(max(along, 2 * span), strip.length - 2 * span) if strip.length > 4 * span else strip.length / 2
    steps = np.clip(middle + np.array([-2, -1, 1, 2]) * span, 0.0, strip.length)
    points = strip.at(steps, np.zeros(4))
    first, last = points[1] - points[0], points[3] - points[2]
    turn = math.remainder(math.atan2(last[1], last[0]) - math.atan2(first[1], first[0]), math.tau)
    between = float(steps[2:].mean() - steps[:2].mean())
    curvature = turn / between if abs(turn) > 0.02 else 0.0
    (x, y), (nx, ny) = strip.at(np.array([along]), np.zeros(1))[0], strip.at(np.array([along]), np.ones(1))[0]
    return float(x), float(y), math.atan2(-(nx - x), ny - y), curvature


def _check_arc(strip: RoadStrip, road: Road, place: Place, along: float) -> None:
    x, y, yaw = place
    steps = strip.along[np.abs(strip.along - along) < min(_CHECKED, road.half_length)]
    points = strip.at(steps, np.zeros(len(steps))) - (x, y)
    cos, sin = math.cos(yaw), math.sin(yaw)
    u, v = points[:, 0] * cos + points[:, 1] * sin, points[:, 1] * cos - points[:, 0] * sin
    _, across = road.along_across(u, v - road.lane(road.ego_lane))
    if np.abs(across).max(initial=0.0) > _MOST_OFF:
        raise NoStreetError("no street around it: its road bends more than one way")


def _sidewalk(strip: RoadStrip, layout: Layout, along: float) -> float:
    """The width of the sidewalks beside a strip near the ego vehicle [m], 0 where there are none."""
    ground = LayoutGround(layout)
    for off in (3.0, 2.0, 1.2):
        for side in (-1, 1):
            ((x, y),) = strip.at(np.array([along]), np.array([side * (strip.half + off)])).tolist()
            below = ground.at(x, y)
            if below is not None and below[1] == "sidewalk":
                return off + 0.3
    return 0.0
