"""Details of the ground: the markings of roads, and kerbstones where sidewalks meet them.

A road that the layout describes is marked as in streets (`arranging/markings.py`). For others, the shapes give the
lanes and the lines between them. Shapes of the ground keep their places and the materials of their classes.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np

from lidardraft.arranging.ground import COAT, PAINT, cut
from lidardraft.arranging.markings import COUNTRY, EDGE_OFF, TOWN, Line, bay_lines, road_markings, sample_zebras, zebras
from lidardraft.drafting.solver.poses import half_of, row_poses
from lidardraft.objects.mesh import quads
from lidardraft.scene.layout import Layout, Primitive, object_of
from lidardraft.scene.road import Road
from lidardraft.scene.road_surfaces import road_surfaces
from lidardraft.scene.street import StreetFrame, paths_of
from lidardraft.simulation.detail.coarse_object import generator_of
from lidardraft.simulation.roads import RoadStrip, district_of, lanes_of, strip_rows

_WIDEST_ROUND = 100.0  # m
_TWO_LANES = 5.0  # m: a narrower road has no lines
_CLEAR = 3.0  # m from lines to a crossing road
_BESIDE = 1.0  # m from a road: sidewalks this near have a kerb
_KERB, _KERB_PROUD = 0.15, 0.003  # m wide; m that kerbstones stand out
_STRAIGHT = 20.0  # m: solid lines are painted in pieces
_BEND_PIECE = 4.0  # m, the length of a piece of paint on a bend
_LIGHTS = 12.0  # m from a crossing road within which traffic lights belong to it
_ZEBRA_BEFORE, _ZEBRAS_APART = 2.3, 8.0  # m from a crossing road to the middle of a zebra, and between two


def ground_parts(layout: Layout, strips: tuple[RoadStrip, ...], seed: int) -> list[Primitive]:
    """The markings and kerbstones of a layout."""
    walks = [p for p in layout if p.label == "sidewalk" and p.material is None]
    taken = {p.id: p for p in layout}
    made, marked = [], set[str]()
    roads = layout.roads
    road = None if roads is None or roads.street is None or roads.drawn is not None else roads.street.road
    if road is not None and all(taken.get(p.id) == p for p in road_surfaces(road) if p.label == "road"):
        made, marked = _known_markings(road, layout, seed), {"road", "road_back"}
    rounds = _rounds(layout, strips) if strips else []
    for strip in strips:
        if strip.id not in marked and (lines := _markings(strip, strips, rounds, bool(walks))) is not None:
            made.append(lines)
    made += [p for walk in walks if (p := _kerb(walk, strips)) is not None]
    return [p for p in made if p.id not in taken]


def _known_markings(road: Road, layout: Layout, seed: int) -> list[Primitive]:
    """The markings of a road of a sentence."""
    if road.paved_areas:
        sides = [(area.along, row_poses(road, 1 if area.across[1] > 0 else -1)) for area in road.paved_areas]
        spans = np.array([line for along, rows in sides for line in bay_lines(along, [across for across, _ in rows])])
    else:
        middle = (math.inf, math.inf) if road.junction is None else road.at(road.junction, 0.0)[:2]
        near = road.edge + _LIGHTS
        lights = any(p.label == "traffic-light" and math.dist(p.center[:2], middle) < near for p in layout)
        district = district_of(layout, road)
        street = StreetFrame(road=road, speed=district.speed, parked=(), lights=lights)
        rng = generator_of(seed, "markings")
        spans = road_markings(road, paths_of(street), None, district.speed, rng)
        crossings = _crossings(road, layout) or sample_zebras(road, district.speed, rng)
        spans = np.concatenate([spans, zebras(road, crossings)])
    if road.curvature and len(spans):
        spans = cut(spans, np.arange(-road.half_length, road.half_length, _BEND_PIECE), 0)
    plane = road.points(spans[:, [0, 1, 1, 0]], spans[:, [2, 2, 3, 3]]) if len(spans) else np.zeros((0, 4, 2))
    return [_painted(plane, 0.0, "road.markings")] if len(spans) else []


def _crossings(road: Road, layout: Layout) -> Sequence[float]:
    """Where people of a sentence cross the road [m along], before or behind a crossing road."""
    cross = {name for name, asked in layout.intent.objects.items() if str(asked.heading).startswith("across")}
    found: list[float] = []
    for person in layout:
        if person.label == "person" and object_of(person) in cross and road.sidewalk > 0:
            along, _ = road.along_across(*person.center[:2])
            if road.junction is not None and road.in_junction(along, _ZEBRA_BEFORE):
                off = along - road.junction
                along = road.junction + math.copysign(half_of(road) + _ZEBRA_BEFORE, off)
            if all(abs(along - other) > _ZEBRAS_APART for other in found):
                found.append(along)
    return found


def _painted(plane: np.ndarray, top: float, id: str) -> Primitive:
    """Paint on rectangles with corners x, y [Q, 4, 2] at a height [m]."""
    corners = np.concatenate([plane, np.full((*plane.shape[:2], 1), top + COAT)], axis=-1)
    return Primitive.from_mesh(*quads(corners), label="road", id=id, material=PAINT)


def _markings(
    strip: RoadStrip, strips: tuple[RoadStrip, ...], rounds: list[tuple[float, float, float]], town: bool
) -> Primitive | None:
    spans = [span for line in _lines(strip, town) for span in _pieces(strip, line)]
    if not spans:
        return None
    low, high, across = np.array(spans).T
    middle = strip.line.at((low + high) / 2, across)
    kept = np.ones(len(spans), dtype=bool)
    for other in strips:
        if other is not strip:
            along, aside = other.line.along_across(middle)
            # a side road begins at the edge of the road that it meets
            reach = 2 * strip.half
            kept &= ~((np.abs(aside) < other.half + _CLEAR) & (along > -reach) & (along < other.line.length + reach))
    for x, y, radius in rounds:
        kept &= np.hypot(middle[:, 0] - x, middle[:, 1] - y) > radius + _CLEAR
    low, high, across = low[kept], high[kept], across[kept]
    if not len(low):
        return None
    along = np.stack([low, high, high, low], axis=1)
    side = across[:, None] + TOWN.lane_line / 2 * np.array([-1, -1, 1, 1])
    return _painted(strip.line.at(along, side), strip.top, f"{strip.id}.markings")


def _rounds(layout: Layout, strips: tuple[RoadStrip, ...]) -> list[tuple[float, float, float]]:
    """Middle and radius of each circle around a road that is no strip, such as a roundabout."""
    known = {strip.id for strip in strips}
    others = (p for p in layout if p.label == "road" and p.id not in known and p.material is None)
    return [(p.center[0], p.center[1], max(p.size[:2]) / 2) for p in others if max(p.size[:2]) < _WIDEST_ROUND]


def _lines(strip: RoadStrip, town: bool) -> list[Line]:
    """The lines between lanes, along parked cars and, outside towns, along the edges."""
    lanes = lanes_of(strip)
    if 2 * strip.half < _TWO_LANES:
        return []
    pattern = TOWN if town else COUNTRY
    thin, dash, gap = pattern.lane_line, pattern.dash, pattern.gap
    if lanes.two_way:
        lines = [Line(0.0, thin, dash, 0.0 if lanes.number > 1 else gap)]
        lines += [Line(side * k * lanes.width, thin, dash, gap) for k in range(1, lanes.number) for side in (-1, 1)]
    else:
        lines = [Line((k - lanes.number / 2) * lanes.width, thin, dash, gap) for k in range(1, lanes.number)]
    if not town or lanes.parking > 0.0:
        edge = strip.half - (lanes.parking or EDGE_OFF)
        lines += [Line(side * edge, thin, dash) for side in (-1, 1)]
    return lines


def _pieces(strip: RoadStrip, line: Line) -> list[tuple[float, float, float]]:
    """From, to and across [m]; solid lines are cut into pieces that follow a bend."""
    if line.gap > 0.0:
        starts = np.arange(line.gap / 2, strip.line.length - line.dash, line.dash + line.gap)
        return [(start, start + line.dash, line.across) for start in starts.tolist()]
    step = line.dash if len(strip.line.middle) > 2 else _STRAIGHT
    ends = np.linspace(0.0, strip.line.length, max(1, math.ceil(strip.line.length / step)) + 1).tolist()
    return [(low, high, line.across) for low, high in itertools.pairwise(ends)]


def _kerb(walk: Primitive, strips: tuple[RoadStrip, ...]) -> Primitive | None:
    """A row of kerbstones along the side of a sidewalk that meets a road."""
    edges = _sides(walk)
    best, side, nearest = None, 0, _BESIDE
    for strip in strips:
        for k, edge in enumerate(edges):
            along, across = strip.line.along_across(
                edge[len(edge) // 2][None] if len(edge) > 2 else edge.mean(axis=0)[None]
            )
            away = abs(abs(float(across[0])) - strip.half)
            if 0.0 <= float(along[0]) <= strip.line.length and away < nearest:
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
    """Both long sides [S, 2] of a sidewalk; empty if its shape does not give them."""
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
