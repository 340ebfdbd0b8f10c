"""The primitives that show a road: its surfaces, and strips of the ground of any height."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from lidardraft.scene.layout import Primitive, corners_around
from lidardraft.scene.road import KERB_HEIGHT, LEFT, TERRAIN_HEIGHT, Road
from lidardraft.scene.road_network import Drawn

_SEGMENT = 2.0  # m; the chord of a 50 m bend leaves the arc by 1 cm
_EXTENT = 200.0
_SEEN_MEDIAN = 1.0  # m; a wider median has its own surface


def road_surfaces(road: Road) -> list[Primitive]:
    """Terrain, road, sidewalks and crossing road as primitives with the ids "terrain", "road", "sidewalk_1" ..."""
    surfaces = [terrain(_EXTENT), *_carriageways(road)]
    if road.sidewalk > 0:
        surfaces += [
            _strip(road, f"sidewalk_{number}", "sidewalk", span, across, KERB_HEIGHT)
            for number, (span, across) in enumerate(road.sidewalks(), start=1)
        ]
    if road.junction is not None:
        surfaces += [_side_road(road, road.junction, side) for side in road.side_roads]
    if road.roundabout_radius is not None and road.junction is not None:
        surfaces += _roundabout(road, road.junction, road.roundabout_radius)
    for number, area in enumerate(road.paved_areas, start=1):
        surfaces.append(_strip(road, f"patch_{number}", "road", area.along, area.across, 0.0))
    return surfaces


def drawn(primitives: Iterable[Primitive]) -> tuple[Drawn, ...]:
    """The primitives that show roads, as a network refers to them."""
    found = []
    for primitive in primitives:
        if primitive.label == "road" and primitive.material is None:
            (a, b, c), (x, y, z) = corners_around([primitive], 0.0)
            found.append(Drawn(primitive.id, (a, b, c), (x, y, z)))
    return tuple(found)


def _carriageways(road: Road) -> list[Primitive]:
    whole = (-road.half_length, road.half_length)
    if road.median < _SEEN_MEDIAN:
        return [_strip(road, "road", "road", whole, (-road.edge, road.edge), 0.0)]
    return [
        _strip(road, "road", "road", whole, (-road.edge, -road.median / 2), 0.0),
        _strip(road, "road_back", "road", whole, (road.median / 2, road.edge), 0.0),
    ]


def _roundabout(road: Road, junction: float, radius: float) -> list[Primitive]:
    turns = np.linspace(0.0, 2 * math.pi, 33)[:-1]
    rim = [(*road.at(junction + radius * math.cos(t), radius * math.sin(t))[:2], 0.0) for t in turns.tolist()]
    x, y, _ = road.at(junction, 0.0)
    here = np.arange(len(rim))
    faces = np.stack([here, (here + 1) % len(rim), np.full(len(rim), len(rim))], axis=1)
    disc = Primitive.from_mesh(np.array([*rim, (x, y, 0.0)]), faces, label="road", id="roundabout")
    height = KERB_HEIGHT - TERRAIN_HEIGHT
    center = (x, y, KERB_HEIGHT - height / 2)
    size = (2 * road.island, 2 * road.island, height)
    return [disc, Primitive(shape="cylinder", center=center, size=size, label="terrain", id="island")]


def _side_road(road: Road, junction: float, side: int) -> Primitive:
    x, y, heading = road.at(junction, side * (road.edge + road.half_length) / 2)
    length, turn, name = road.half_length - road.edge, heading + math.pi / 2, "left" if side == LEFT else "right"
    return slab(x, y, length, 2 * road.edge, turn, 0.0, "road", f"road_{name}")


def _strip(
    road: Road, id: str, label: str, span: tuple[float, float], across: tuple[float, float], top: float
) -> Primitive:
    """The surface between two distances along and across: a plane or box if the road is straight, else a mesh."""
    if road.curvature == 0.0:
        x, y, _ = road.at((span[0] + span[1]) / 2, (across[0] + across[1]) / 2)
        return slab(x, y, span[1] - span[0], across[1] - across[0], 0.0, top, label, id)
    stations = np.linspace(*span, max(2, math.ceil((span[1] - span[0]) / _SEGMENT) + 1))
    profile = profile_of(*across, top)
    return ribbon(np.array([[(*road.at(s, side)[:2], z) for side, z in profile] for s in stations]), label, id)


def terrain(reach: float) -> Primitive:
    """The ground under everything, `reach` [m] to each side of the ego vehicle."""
    center, size = (0.0, 0.0, TERRAIN_HEIGHT), (2 * reach, 2 * reach, 0.0)
    return Primitive(shape="plane", center=center, size=size, label="terrain", id="terrain", open=True)


def slab(x: float, y: float, length: float, width: float, yaw: float, top: float, label: str, id: str) -> Primitive:
    """A straight strip around x, y: a plane on the ground, or a box from the terrain up to `top` [m]."""
    height = top - TERRAIN_HEIGHT if top > 0.0 else 0.0
    shape, center, size = "box" if height else "plane", (x, y, top - height / 2), (length, width, height)
    return Primitive(shape=shape, center=center, size=size, yaw=yaw, label=label, id=id)


def profile_of(low: float, high: float, top: float) -> list[tuple[float, float]]:
    """The cross section of a strip, from side to side: places across and heights [m], with kerbs if it is raised."""
    flat = [(low, top), (high, top)]
    return [(low, TERRAIN_HEIGHT), *flat, (high, TERRAIN_HEIGHT)] if top > 0.0 else flat


def ribbon(rows: np.ndarray, label: str, id: str) -> Primitive:
    """The mesh between consecutive cross sections float64 [N, P, 3]."""
    count, width, _ = rows.shape
    a = (np.arange(count - 1)[:, None] * width + np.arange(width - 1)).ravel()
    faces = np.stack([a, a + 1, a + 1 + width, a, a + 1 + width, a + width], axis=1)
    return Primitive.from_mesh(rows.reshape(-1, 3), faces.reshape(-1, 3), label=label, id=id)
