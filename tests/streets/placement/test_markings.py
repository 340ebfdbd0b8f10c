"""What is painted on the road."""

import numpy as np
from planned import occupancies

from lidardraft import Layout, Raycaster
from lidardraft.scene.layout import primitive_mesh
from lidardraft.scene.road import Road
from lidardraft.streets.placement.district import DISTRICTS
from lidardraft.streets.placement.lanes import driven_lanes
from lidardraft.streets.placement.markings import road_markings


def test_markings_lie_on_the_road():
    painted = 0
    for occupancy in occupancies()[::3]:
        surfaces = {p.id: p for p in occupancy.ground.surfaces()}
        if "markings" not in surfaces:
            continue
        painted += 1
        assert surfaces["markings"].label == "road"
        bare = Raycaster(Layout(primitives=tuple(p for name, p in surfaces.items() if name != "markings")))
        corners = primitive_mesh(surfaces["markings"]).vertices
        inner = corners.reshape(-1, 4, 3).mean(axis=1)
        hits = bare.cast(inner + np.array([0.0, 0.0, 5.0]), np.tile([0.0, 0.0, -1.0], (len(inner), 1)))
        assert (hits.label == 1).all(), occupancy.road
        over = hits.distance - 5.0
        assert over.min() > 0.002
        assert over.max() < 0.012
    assert painted > 20


def painted(road: Road, speed: float, *, lights: bool = False) -> np.ndarray:
    lanes = driven_lanes(road, DISTRICTS["urban"], (), None, oneway=False, lights=lights)
    return road_markings(road, lanes, None, speed, np.random.default_rng(4))


def test_dashes_and_gaps_are_those_of_the_guide():
    for road, speed, dash, gap, width in (
        (Road(sidewalk=0.0), 14.0, 3.0, 6.0, 0.12),
        (Road(sidewalk=0.0), 28.0, 4.0, 8.0, 0.12),
        (Road(lanes=2, sidewalk=0.0, median=4.0), 36.0, 6.0, 12.0, 0.15),
    ):
        spans = painted(road, speed)
        dashes = spans[np.isclose(spans[:, 1] - spans[:, 0], dash)]
        one = dashes[dashes[:, 2] == dashes[0, 2]]
        assert np.allclose(np.diff(one[:, 0]), dash + gap)
        assert np.allclose(one[:, 3] - one[:, 2], width)


def test_fast_roads_alone_have_edge_lines():
    whole = 2 * Road().half_length
    for speed, count in ((14.0, 0), (28.0, 2)):
        spans = painted(Road(sidewalk=0.0), speed)
        assert (np.isclose(spans[:, 1] - spans[:, 0], whole)).sum() == count


def test_stop_lines_are_before_lights_only():
    road = Road(junction=10.0, sidewalk=0.0)
    without, spans = painted(road, 14.0), painted(road, 14.0, lights=True)
    assert len(spans) == len(without) + 4
    extents = np.stack([spans[:, 1] - spans[:, 0], spans[:, 3] - spans[:, 2]], axis=1)
    assert np.isclose(extents.min(axis=1), 0.5).sum() == 4
