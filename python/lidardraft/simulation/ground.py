"""What the ground gets on top: lines on roads whose frame is known, and kerbstones where sidewalks meet them.

Widths and patterns are those of the German guide to road markings (RMS-1): lines of 0.12 m, 3 m of line and 6 m of gap
in towns, 4 and 8 m outside. Shapes of the ground keep their places; their materials are those of their classes.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from lidardraft.arranging.markings import bay_lines
from lidardraft.drafting.solver.poses import row_poses
from lidardraft.objects.mesh import quads
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.road import Road
from lidardraft.simulation.street_frame import road_of
from lidardraft.simulation.surroundings import RoadStrip, strip_rows

_COAT = 0.005  # m that paint lies over the road
_LINE = 0.12  # m wide
_TOWN, _COUNTRY = (3.0, 6.0), (4.0, 8.0)  # m of line and gap
_EDGE_OFF = 0.25  # m from an edge line to the edge of the road
_LANE = (2.9, 4.0)  # m, widths of lanes that are looked for
_PARKING = (1.7, 3.5)  # m, widths of strips for parked cars, or hard shoulders
_AMID = 0.2  # m from the middle of a one-way road that the ego vehicle is at most
_CARS = 2.2  # m, the strip of parked cars on a one-way road
_WIDEST_ROUND = 100.0  # m
_EXACT = 0.05  # m that lanes may leave of the width of a road, or exceed it by
_TWO_LANES = 5.0  # m: a narrower road has no lines
_LINED_LANES = 3.6  # m: width of the lanes of a road that nothing tells the lanes of, at most
_CLEAR = 3.0  # m from lines to a crossing road
_BESIDE = 1.0  # m from a road within which a sidewalk has a kerb
_KERB, _KERB_PROUD = 0.15, 0.003  # m wide; m that kerbstones stand out
_STRAIGHT = 20.0  # m: solid lines are painted in pieces


class _Line(NamedTuple):
    across: float
    dash: float  # m of line, and of gap; solid with a gap of 0
    gap: float


class _Lanes(NamedTuple):
    number: int  # of one direction
    width: float  # m
    parking: float  # m beside the outermost lanes
    two_way: bool = True


def ground_parts(layout: Layout, strips: tuple[RoadStrip, ...]) -> list[Primitive]:
    """The lines and kerbstones of a layout."""
    walks = [p for p in layout if p.label == "sidewalk" and p.material is None]
    taken = {p.id for p in layout}
    rounds = _rounds(layout, strips) if strips else []
    made = [p for strip in strips if (p := _markings(strip, strips, rounds, bool(walks))) is not None]
    made += [p for walk in walks if (p := _kerb(walk, strips)) is not None]
    if {"patch_1", "patch_2"} & taken and "road" in layout.provenance:
        made += _bays(road_of(layout.provenance["road"]))
    return [p for p in made if p.id not in taken]


def _markings(
    strip: RoadStrip, strips: tuple[RoadStrip, ...], rounds: list[tuple[float, float, float]], town: bool
) -> Primitive | None:
    spans = [span for line in _lines(strip, town) for span in _pieces(strip, line)]
    if not spans:
        return None
    low, high, across = np.array(spans).T
    middle = strip.at((low + high) / 2, across)
    kept = np.ones(len(spans), dtype=bool)
    for other in strips:
        if other is not strip:
            along, aside = other.along_across(middle)
            # a side road begins at the edge of the road that it meets
            reach = 2 * strip.half
            kept &= ~((np.abs(aside) < other.half + _CLEAR) & (along > -reach) & (along < other.length + reach))
    for x, y, radius in rounds:
        kept &= np.hypot(middle[:, 0] - x, middle[:, 1] - y) > radius + _CLEAR
    low, high, across = low[kept], high[kept], across[kept]
    if not len(low):
        return None
    along = np.stack([low, high, high, low], axis=1)
    side = across[:, None] + _LINE / 2 * np.array([-1, -1, 1, 1])
    corners = np.concatenate([strip.at(along, side), np.full((*along.shape, 1), strip.top + _COAT)], axis=-1)
    return Primitive.from_mesh(*quads(corners), label="road", id=f"{strip.id}.markings", material="road-paint")


def _bays(road: Road) -> Iterator[Primitive]:
    """The lines between the bays of a parking lot as the solver of sentences makes them."""
    spans = np.array(
        [
            span
            for area in road.paved_areas
            for span in bay_lines(
                area.along, [across for across, _ in row_poses(road, 1 if area.across[1] > 0 else -1)]
            )
        ]
    )
    if len(spans):
        plane = road.points(spans[:, [0, 1, 1, 0]], spans[:, [2, 2, 3, 3]])
        corners = np.concatenate([plane, np.full((*plane.shape[:2], 1), _COAT)], axis=-1)
        yield Primitive.from_mesh(*quads(corners), label="road", id="bays.markings", material="road-paint")


def _rounds(layout: Layout, strips: tuple[RoadStrip, ...]) -> list[tuple[float, float, float]]:
    """Middle and radius of each circle around a road that is no strip, as a roundabout is."""
    known = {strip.id for strip in strips}
    others = (p for p in layout if p.label == "road" and p.id not in known and p.material is None)
    return [(p.center[0], p.center[1], max(p.size[:2]) / 2) for p in others if max(p.size[:2]) < _WIDEST_ROUND]


def _lines(strip: RoadStrip, town: bool) -> list[_Line]:
    """Between lanes, along parked cars, and, outside towns, along the edges."""
    lanes = _lanes(strip)
    if 2 * strip.half < _TWO_LANES:
        return []
    dash, gap = _TOWN if town else _COUNTRY
    if lanes.two_way:
        lines = [_Line(0.0, dash, 0.0 if lanes.number > 1 else gap)]
        lines += [_Line(side * k * lanes.width, dash, gap) for k in range(1, lanes.number) for side in (-1, 1)]
    else:
        lines = [_Line((k - lanes.number / 2) * lanes.width, dash, gap) for k in range(1, lanes.number)]
    if not town or lanes.parking > 0.0:
        edge = strip.half - (lanes.parking or _EDGE_OFF)
        lines += [_Line(side * edge, dash, 0.0) for side in (-1, 1)]
    return lines


def _lanes(strip: RoadStrip) -> _Lanes:
    """What the place of the ego vehicle, amid a lane, tells of the lanes of its road."""
    along, across = strip.along_across(np.zeros((1, 2)))
    off = -float(across[0])
    if 0.0 < float(along[0]) < strip.length and abs(off) < strip.half:
        if abs(off) < _AMID:
            return _one_way(strip.half)
        # lanes and how many widths of them the ego is off the middle: on the right, or anywhere on a one-way road
        two_way = [(n, n - k - 0.5) for n in range(1, 7) for k in range(n)] if off > 0.0 else []
        one_way = [(n, (n - 1) / 2 - k) for n in range(2, 5) for k in range(n) if n - 1 != 2 * k]
        for ways, both in ((two_way, True), (one_way, False)):
            for least, most in ((-_EXACT, _EXACT), _PARKING):
                for lanes, share in ways:
                    parking = strip.half - lanes * off / share * (1.0 if both else 0.5)
                    if _LANE[0] <= off / share <= _LANE[1] and least <= parking <= most:
                        return _Lanes(lanes, off / share, parking if parking > _EXACT else 0.0, both)
    lanes = max(1, math.ceil(strip.half / _LINED_LANES - 0.25))
    return _Lanes(lanes, strip.half / lanes, 0.0)


def _one_way(half: float) -> _Lanes:
    """The lanes of a road whose middle the ego vehicle drives along: one, or three."""
    for count in (1, 3):
        for parking in (0.0, _CARS):
            width = 2 * (half - parking) / count
            if _LANE[0] <= width <= _LANE[1]:
                return _Lanes(count, width, parking, two_way=False)
    return _Lanes(1, 2 * half, 0.0, two_way=False)


def _pieces(strip: RoadStrip, line: _Line) -> list[tuple[float, float, float]]:
    """From, to and across [m]; what is solid is cut into pieces that follow a bend."""
    if line.gap > 0.0:
        starts = np.arange(line.gap / 2, strip.length - line.dash, line.dash + line.gap)
        return [(start, start + line.dash, line.across) for start in starts.tolist()]
    step = line.dash if len(strip.middle) > 2 else _STRAIGHT
    ends = np.linspace(0.0, strip.length, max(1, math.ceil(strip.length / step)) + 1).tolist()
    return [(low, high, line.across) for low, high in itertools.pairwise(ends)]


def _kerb(walk: Primitive, strips: tuple[RoadStrip, ...]) -> Primitive | None:
    """A row of kerbstones along the side of a sidewalk that meets a road."""
    edges = _sides(walk)
    best, side, nearest = None, 0, _BESIDE
    for strip in strips:
        for k, edge in enumerate(edges):
            along, across = strip.along_across(edge[len(edge) // 2][None] if len(edge) > 2 else edge.mean(axis=0)[None])
            away = abs(abs(float(across[0])) - strip.half)
            if 0.0 <= float(along[0]) <= strip.length and away < nearest:
                best, side, nearest = edge, k, away
    if best is None:
        return None
    far = edges[1 - side]
    inward = (far - best) / np.maximum(np.linalg.norm(far - best, axis=1, keepdims=True), 1e-9)
    top = walk.center[2] + walk.size[2] / 2 + _KERB_PROUD
    bottom = walk.center[2] - walk.size[2] / 2
    outer, inner = best - _KERB_PROUD * inward, best + _KERB * inward
    rails = [(outer, bottom), (outer, top), (inner, top)]
    rings = np.stack([np.column_stack([line, np.full(len(line), z)]) for line, z in rails], axis=1)
    if walk.size[2] == 0.0:
        rings = rings[:, 1:]
    corners = np.stack([rings[:-1, :-1], rings[1:, :-1], rings[1:, 1:], rings[:-1, 1:]], axis=2).reshape(-1, 4, 3)
    return Primitive.from_mesh(*quads(corners), label="sidewalk", id=f"{walk.id}.kerb", material="concrete")


def _sides(walk: Primitive) -> list[np.ndarray]:
    """Both long sides [S, 2] of a sidewalk, none if its shape does not tell them."""
    if walk.mesh is not None:
        rows = strip_rows(walk, 4)
        return [] if rows is None else [rows[:, 1, :2], rows[:, 2, :2]]
    if walk.shape not in ("box", "plane"):
        return []
    length, width, _ = walk.size
    yaw = walk.yaw if length >= width else walk.yaw + math.pi / 2
    half, out = max(length, width) / 2, min(length, width) / 2
    ahead, aside = np.array([math.cos(yaw), math.sin(yaw)]), np.array([-math.sin(yaw), math.cos(yaw)])
    ends = np.array(walk.center[:2]) + np.array([[-half], [half]]) * ahead
    return [ends - out * aside, ends + out * aside]
