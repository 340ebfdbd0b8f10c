"""The roads of a layout: its own, or guesses from its boxes, shapes or picture. **The** guesses of roads."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from lidardraft.arranging.district import District, only_district, setting
from lidardraft.errors import LayoutError
from lidardraft.scene.check import VEHICLE_LABELS, LayoutGround
from lidardraft.scene.edit import placed
from lidardraft.scene.lane import Pavement
from lidardraft.scene.layout import AROUND, Layout, Primitive, primitive_mesh
from lidardraft.scene.line import Line
from lidardraft.scene.pose import Place, in_frame, rotation
from lidardraft.scene.road import Road
from lidardraft.scene.road_network import RoadNetwork
from lidardraft.scene.road_surfaces import drawn, road_surfaces
from lidardraft.scene.street import StreetFrame

_LANE = 3.5  # m, usual
_LANE_WIDTHS = (2.5, 6.0)  # m, of a lane of a drawn road
_SIDEWALK = 2.5  # m, of roads not said to have none
_BEYOND_BOXES = 0.05  # m of the land beside their road over the plane of boxes
_HALF_LENGTHS = (40.0, 110.0)  # m
_MOST_OFF = 0.75  # m that a drawn road may leave the arc that is taken for it, as far as `_CHECKED` [m] from the ego
_CHECKED = 60.0
_SLOW_TURN = 0.35  # rad against the ego vehicle; vehicles turned by more do not drive along its road
_VEHICLE_HALF = 1.0  # m
_WIDEST_PICTURE = math.radians(170.0)
_SHORTEST, _LONGEST, _NARROWEST, _WIDEST = 10.0, 2e4, 2.5, 45.0  # m of shapes that count as roads
_SLENDER = 1.5  # times as long as wide, at least
_ADJOINING = 0.5  # m between roads that are one surface
_FLAT, _EVEN = 1e-3, 0.02  # m that the surface may rise; m that a strip's width may change
_LINED = (2.9, 4.0)  # m, widths of lanes to look for
_PARKING = (1.7, 3.5)  # m, widths of strips for parked cars, or hard shoulders
_AMID = 0.2  # m from the middle of a one-way road of the ego vehicle, at most
_CARS = 2.2  # m, the strip of parked cars on a one-way road
_EXACT = 0.05  # m by which lanes may differ from the width of a road
_WIDEST_LANE = 3.6  # m: greatest lane width of a road with unknown lanes
_SAME = 0.01  # m that a primitive of a road may be off its place


class NoStreetError(LayoutError):
    """The reason why a layout gets no street."""


def with_roads(layout: Layout) -> Layout:
    """The layout with its roads: its own or else, with a note, guesses from its shapes.

    If its own roads disagree with the primitives that show them, the primitives count, and a note says so. Raises
    `NoStreetError` without a road under the ego vehicle.
    """
    roads, changed = layout.roads, ""
    if roads is not None:
        if roads.street is not None and roads.street.speed is None:
            limit = district_of(layout, roads.street.road).speed
            roads = roads.but(street=dataclasses.replace(roads.street, speed=limit))
        if not (changed := _changed(layout, roads)):
            return dataclasses.replace(layout, roads=roads)
        changed = f"{changed} is not where its roads have it: "
    try:
        street, shown, source = _guess(layout)
    except NoStreetError as error:
        raise NoStreetError(f"{changed}{error}") from None
    street = dataclasses.replace(street, speed=district_of(layout, street.road).speed)
    guess = RoadNetwork(street=street, drawn=drawn(p for p in layout if p.id == shown))
    note = f"{changed}the lanes of its road are guessed from its {source}"
    return dataclasses.replace(layout, roads=guess).noted(note)


def with_known_roads(layout: Layout) -> Layout:
    """As `with_roads`, or the layout without roads if none can be guessed; a note explains the loss of roads that it
    had."""
    try:
        return with_roads(layout)
    except NoStreetError as error:
        bare = dataclasses.replace(layout, roads=None)
        return bare if layout.roads is None else bare.noted(str(error))


def _changed(layout: Layout, roads: RoadNetwork) -> str:
    """The id of a primitive of a road that is gone or changed; "" if there is none."""
    shown, street = roads.drawn, roads.street
    if shown is None and street is not None:
        shown = drawn(placed(road_surfaces(street.road), street.place))
    there = {one.id: one for one in drawn(layout)}
    for one in shown or ():
        found = there.get(one.id)
        if found is None or max(abs(np.subtract((*found.low, *found.high), (*one.low, *one.high)))) > _SAME:
            return one.id
    return ""


def _guess(layout: Layout) -> tuple[StreetFrame, str, str]:
    """The guess of the road under the ego vehicle, the id of the primitive that shows it, if any, and the source of
    the guess."""
    layout = dataclasses.replace(layout, primitives=tuple(p for p in layout if not p.id.startswith(AROUND)))
    if layout.coverage is not None:
        if layout.coverage[1] - layout.coverage[0] > _WIDEST_PICTURE:
            raise NoStreetError("no street around it: it shows everything around already")
        road = Road(lanes=1, lane_width=_LANE, sidewalk=_SIDEWALK)
        return StreetFrame(road=road, lacks=("road", "sidewalk", "terrain")), "", "picture"
    if any(primitive.open and primitive.label == "road" for primitive in layout):  # boxes say nothing of the ground
        street = StreetFrame(road=_road_of_boxes(layout), plain=_BEYOND_BOXES, lacks=("sidewalk", "terrain"))
        return street, "", "boxes"
    here = np.zeros((1, 2))
    strips = [strip for strip in road_strips(layout) if abs(strip.line.along_across(here)[1][0]) < strip.half]
    if not strips:
        raise NoStreetError("no street around it: it has no road under the ego vehicle that could be followed")
    own = max(strips, key=lambda strip: strip.line.length)
    return _drawn(own, layout), own.id, "shapes"


def district_of(layout: Layout, road: Road) -> District:
    """The district of a road: that of the layout's surroundings or sentence, or a guess from the road."""
    intent = layout.intent
    return setting(intent.around or intent.district or only_district(road, intent.road) or "urban")


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
    along = float(strip.line.along_across(np.zeros((1, 2)))[0][0])
    before, behind = strip.line.length - along, along
    middle, curvature = _arc(strip, along)
    half_length = min(max(before, behind, _HALF_LENGTHS[0]), _HALF_LENGTHS[1])
    if curvature:
        half_length = min(half_length, 1.5 / abs(curvature))
    walk = _sidewalk(strip, layout, along)
    road = Road(lanes=lanes, lane_width=width, sidewalk=walk or _SIDEWALK, curvature=curvature, half_length=half_length)
    _check_arc(strip, road, middle, along)
    # the road's frame has its origin in the middle of the ego's lane
    place = in_frame((0.0, road.lane(road.ego_lane), 0.0), middle)
    paved = tuple(_other_pavement(layout, strip))
    lacks = () if walk else ("sidewalk",)
    return StreetFrame(road=road, place=place, lacks=lacks, paved=paved, ends=(-behind, before))


def _other_pavement(layout: Layout, own: RoadStrip) -> Iterator[Pavement]:
    """The pavement beside the own road, in pieces that follow bends."""
    strips = {strip.id: strip for strip in road_strips(layout) if strip.id != own.id}
    for primitive in layout:
        if primitive.label not in ("road", "sidewalk") or primitive.id == own.id:
            continue
        if primitive.id in strips:
            for (x, y), (u, v) in itertools.pairwise(strips[primitive.id].line.middle.tolist()):
                size = (math.dist((x, y), (u, v)), 2 * strips[primitive.id].half)
                yield Pavement(place=((x + u) / 2, (y + v) / 2, math.atan2(v - y, u - x)), size=size, label="road")
        elif primitive.mesh is None:
            place = (*primitive.center[:2], primitive.yaw)
            yield Pavement(place=place, size=primitive.size[:2], label=primitive.label)


def _arc(strip: RoadStrip, along: float) -> tuple[Place, float]:
    """The place of a strip's middle line at `along` [m], and its curvature [1/m]."""
    span = min(_CHECKED / 2, strip.line.length / 4)
    middle = min(max(along, 2 * span), strip.line.length - 2 * span)
    steps = np.clip(middle + np.array([-2, -1, 1, 2]) * span, 0.0, strip.line.length)
    points = strip.line.at(steps)
    first, last = points[1] - points[0], points[3] - points[2]
    turn = math.remainder(math.atan2(last[1], last[0]) - math.atan2(first[1], first[0]), math.tau)
    between = float(steps[2:].mean() - steps[:2].mean())
    curvature = turn / between if abs(turn) > 0.02 else 0.0
    (x, y), (nx, ny) = strip.line.at(along).tolist(), strip.line.at(along, 1.0).tolist()
    return (x, y, math.atan2(-(nx - x), ny - y)), curvature


def _check_arc(strip: RoadStrip, road: Road, place: Place, along: float) -> None:
    steps = strip.line.along[np.abs(strip.line.along - along) < min(_CHECKED, road.half_length)]
    points = strip.line.at(steps)
    u, v = rotation(place[2]) @ (points - place[:2]).T
    _, across = road.along_across(u, v - road.lane(road.ego_lane))
    if np.abs(across).max(initial=0.0) > _MOST_OFF:
        raise NoStreetError("no street around it: its road bends more than one way")


def _sidewalk(strip: RoadStrip, layout: Layout, along: float) -> float:
    """The width of the sidewalks beside a strip near the ego vehicle [m], 0 without any."""
    ground = LayoutGround(layout)
    for off in (3.0, 2.0, 1.2):
        for side in (-1, 1):
            below = ground.at(*strip.line.at(along, side * (strip.half + off)).tolist())
            if below is not None and below[1] == "sidewalk":
                return off + 0.3
    return 0.0


class RoadStrip(NamedTuple):
    """A drawn road: the `id` of its primitive, its height `top` and `half` its width [m], and its middle line, which
    runs in the ego's direction, if it does so at all."""

    id: str
    top: float
    half: float
    line: Line


def road_strips(layout: Layout) -> Iterator[RoadStrip]:
    """The roads of a layout with a known frame, without those along a longer road, such as car parks."""
    found = []
    for primitive in layout:
        if primitive.label == "road" and primitive.material is None:
            edges = _mesh_edges(primitive) if primitive.mesh is not None else _edges(primitive)
            if edges is not None:
                strip = _strip(primitive, *edges)
                width, least = 2 * strip.half, max(_SHORTEST, 2 * _SLENDER * strip.half)
                if _NARROWEST <= width <= _WIDEST and least <= strip.line.length <= _LONGEST:
                    found.append(strip)
    for strip in found:
        if not any(_lies_along(strip, other) for other in found if other.line.length > strip.line.length):
            yield strip


def _lies_along(strip: RoadStrip, road: RoadStrip) -> bool:
    along, across = road.line.along_across(strip.line.middle[[0, -1]])
    beside = np.abs(np.abs(across) - road.half - strip.half) < _ADJOINING
    return bool(beside.all() and (along >= 0.0).all() and (along <= road.line.length).all())


def strip_rows(primitive: Primitive, width: int) -> np.ndarray | None:
    """The vertices [S, width, 3] of a mesh that is a strip with `width` points at each station, else None."""
    assert primitive.mesh is not None
    vertices, faces = primitive.mesh.vertices, primitive.mesh.faces
    rows = len(vertices) // width
    if len(vertices) != rows * width or rows < 2 or len(faces) != 2 * (rows - 1) * (width - 1):
        return None
    if (faces.max(axis=1).astype(np.int64) - faces.min(axis=1) > width + 1).any():
        return None
    return primitive_mesh(primitive).vertices.reshape(rows, width, 3)


def _strip(primitive: Primitive, right: np.ndarray, left: np.ndarray) -> RoadStrip:
    """From its edges [S, 2]."""
    middle, across = (left + right) / 2, left - right
    width = np.linalg.norm(across, axis=1, keepdims=True)
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(middle, axis=0), axis=1))])
    top = primitive.center[2] + primitive.size[2] / 2
    level = np.zeros(len(along))
    line = Line(middle, across / np.maximum(width, 1e-9), along, level + top, level)
    return RoadStrip(primitive.id, top, float(width.mean()) / 2, line)


def _edges(primitive: Primitive) -> tuple[np.ndarray, np.ndarray] | None:
    """The right and the left edge [2, 2] of a plane or a box."""
    if primitive.shape not in ("plane", "box"):
        return None
    length, width, _ = primitive.size
    yaw = primitive.yaw
    if width > length:
        length, width, yaw = width, length, yaw + math.pi / 2
    if math.cos(yaw) < -1e-9:
        yaw += math.pi
    x, y, _ = primitive.center
    ahead, aside = np.array([math.cos(yaw), math.sin(yaw)]), np.array([-math.sin(yaw), math.cos(yaw)])
    ends = np.array([x, y]) + np.array([[-length / 2], [length / 2]]) * ahead
    return ends - width / 2 * aside, ends + width / 2 * aside


def _mesh_edges(primitive: Primitive) -> tuple[np.ndarray, np.ndarray] | None:
    """The right and the left edge [S, 2] of a flat strip."""
    rows = strip_rows(primitive, 2) if primitive.size[2] <= _FLAT else None
    if rows is None:
        return None
    right, left = rows[:, 0, :2], rows[:, 1, :2]
    width = np.linalg.norm(left - right, axis=1)
    if np.ptp(width) > _EVEN or np.linalg.norm(np.diff(right + left, axis=0), axis=1).min() < 1e-3:
        return None
    ahead = right[-1] + left[-1] - right[0] - left[0]
    aside = left[0] - right[0]
    if ahead[0] < 0.0:
        right, left = right[::-1], left[::-1]
        ahead = -ahead
    step = right[1] - right[0]
    return (right, left) if step[0] * aside[1] - step[1] * aside[0] > 0.0 else (left, right)


class StripLanes(NamedTuple):
    """The lanes of a drawn road, guessed from the place of the ego vehicle: their number in one direction, their
    width, and that of the parking strips beside them [m]."""

    number: int
    width: float
    parking: float
    two_way: bool = True


def lanes_of(strip: RoadStrip) -> StripLanes:
    """The lanes of a road, guessed from the place of the ego vehicle in the middle of its lane."""
    along, across = strip.line.along_across(np.zeros((1, 2)))
    off = -float(across[0])
    if 0.0 < float(along[0]) < strip.line.length and abs(off) < strip.half:
        if abs(off) < _AMID:
            return _one_way(strip.half)
        # lanes, and the ego's distance from the middle in lane widths: on the right, or anywhere on a one-way road
        two_way = [(n, n - k - 0.5) for n in range(1, 7) for k in range(n)] if off > 0.0 else []
        one_way = [(n, (n - 1) / 2 - k) for n in range(2, 5) for k in range(n) if n - 1 != 2 * k]
        for ways, both in ((two_way, True), (one_way, False)):
            for least, most in ((-_EXACT, _EXACT), _PARKING):
                for lanes, share in ways:
                    parking = strip.half - lanes * off / share * (1.0 if both else 0.5)
                    if _LINED[0] <= off / share <= _LINED[1] and least <= parking <= most:
                        return StripLanes(lanes, off / share, parking if parking > _EXACT else 0.0, both)
    lanes = max(1, math.ceil(strip.half / _WIDEST_LANE - 0.25))
    return StripLanes(lanes, strip.half / lanes, 0.0)


def _one_way(half: float) -> StripLanes:
    """The lanes of a road with the ego vehicle in its middle: one, or three."""
    for count in (1, 3):
        for parking in (0.0, _CARS):
            width = 2 * (half - parking) / count
            if _LINED[0] <= width <= _LINED[1]:
                return StripLanes(count, width, parking, two_way=False)
    return StripLanes(1, 2 * half, 0.0, two_way=False)
