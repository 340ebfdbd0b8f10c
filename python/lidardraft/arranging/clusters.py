"""Clusters of small objects in streets: bins put out, bicycles, bollards, planters, tables, works."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from lidardraft.arranging import sizes
from lidardraft.arranging.car_parks import CarPark
from lidardraft.arranging.district import District
from lidardraft.arranging.occupancy import Occupancy
from lidardraft.arranging.sizes import Extents, Range
from lidardraft.scene.road import SIDES


@dataclass(frozen=True, slots=True)
class Cluster:
    """A cluster: pieces drawn from `kinds` with their extents, in a line along the street.

    `count` pieces (from, to) stand `apart` [m] from middle to middle. They stand `off` [m] from a line: behind the kerb
    if `behind` is 0, before the verge if 1, behind the verge on private land if 2. They are turned by `angle` [rad],
    with the deviations `askew` [rad], and `scattered` [m] across. `shares` are its weights in districts without and
    with closed fronts. If `alike`, all pieces of a kind have one size.
    """

    kinds: tuple[tuple[str, Extents], ...]
    count: tuple[int, int]
    apart: Range
    off: Range
    behind: int
    shares: tuple[float, float]
    angle: float = 0.0
    askew: float = 0.15
    scattered: float = 0.05
    alike: bool = False


_BINS = ("bin", sizes.WHEELED_BIN)
_CRATE = ("crate", sizes.CRATE)
_ACROSS = math.pi / 2
# All numbers are estimates; parked bicycles stand 0.8 m apart (FGSV: 0.8 m and more) or less.
_CLUSTERS = (
    Cluster((_BINS,), (1, 5), (0.7, 1.1), (0.4, 0.7), 0, (0.16, 0.06), askew=0.4),
    Cluster((_BINS, _BINS, _CRATE), (2, 6), (0.7, 1.3), (0.4, 2.5), 2, (0.22, 0.08), askew=0.3, scattered=0.2),
    Cluster((("bin", sizes.LITTER_BIN), ("cabinet", sizes.CABINET)), (1, 2), (1.2, 2.5), (0.4, 0.5), 1, (0.08, 0.08)),
    Cluster((("cabinet", sizes.CABINET),), (1, 3), (1.0, 1.8), (0.35, 0.45), 1, (0.09, 0.07), askew=0.03),
    Cluster((("pole", sizes.BOLLARD),), (3, 10), (1.2, 2.2), (0.35, 0.55), 0, (0.07, 0.14), scattered=0.02, alike=True),
    Cluster((("bicycle", sizes.BICYCLE),), (2, 9), (0.5, 0.8), (1.0, 1.1), 1, (0.02, 0.1), _ACROSS, 0.08),
    Cluster((("bicycle", sizes.BICYCLE),), (1, 4), (1.9, 2.4), (0.35, 0.45), 1, (0.08, 0.08), askew=0.06),
    Cluster((("bicycle", sizes.BICYCLE),), (1, 3), (0.6, 2.0), (0.5, 2.5), 2, (0.06, 0.0), askew=0.5),
    Cluster((("plant_tub", sizes.PLANT_TUB),), (1, 5), (1.2, 2.6), (0.4, 0.6), 1, (0.05, 0.1)),
    Cluster((("bench", sizes.BENCH), ("bin", sizes.LITTER_BIN)), (1, 3), (1.6, 2.6), (0.45, 0.6), 1, (0.05, 0.06)),
    Cluster((("cafe_table", sizes.CAFE_TABLE),), (2, 6), (1.7, 2.3), (0.9, 1.0), 1, (0.01, 0.08), askew=0.6),
    Cluster((_CRATE,), (1, 5), (0.6, 1.2), (0.3, 0.6), 1, (0.04, 0.06), askew=0.5, scattered=0.1),
    Cluster((("fence", sizes.RAILING),), (3, 10), (2.0, 2.02), (0.3, 0.4), 0, (0.02, 0.09), 0.0, 0.0, 0.0, alike=True),
    Cluster(
        (("mesh_fence", sizes.SITE_FENCE), ("wall", sizes.HOARDING)),
        (2, 7), (3.55, 3.6), (0.2, 0.3), 1, (0.03, 0.09), 0.0, 0.0, 0.0, alike=True,
    ),
    Cluster(
        (("ground_cover", sizes.GROUND_COVER),),
        (2, 8), (0.8, 2.2), (0.5, 4.0), 2, (0.4, 0.08), askew=0.5, scattered=0.4,
    ),
    Cluster((("cone", sizes.CONE), ("crate", sizes.CRATE)), (2, 6), (1.0, 2.5), (0.3, 0.6), 0, (0.02, 0.0)),
)  # fmt: skip
_CLUSTERS_EACH = 36.0  # mean number a street of 180 m with sidewalks
_JUNCTION, _GATE, _MARGIN = 0.5, 4.5, 0.03  # m to a junction, from the middle of a car park's gate, between two pieces


def place_clusters(
    occupancy: Occupancy, district: District, car_park: CarPark | None, rng: np.random.Generator
) -> None:
    """Clusters of small things on the sidewalks and behind them."""
    road = occupancy.road
    shares = np.array([one.shares[int(district.closed_fronts)] for one in _CLUSTERS])
    if road.sidewalk == 0:
        return
    for _ in range(rng.poisson(_CLUSTERS_EACH * road.half_length / 90.0)):
        cluster = _CLUSTERS[int(rng.choice(len(_CLUSTERS), p=shares / shares.sum()))]
        side, along = SIDES[int(rng.integers(2))], rng.uniform(-road.half_length, road.half_length)
        gate = car_park is not None and side == car_park.side and abs(along - car_park.gate) < _GATE
        if not gate:
            _place_cluster(occupancy, cluster, along, side, rng)


def _place_cluster(occupancy: Occupancy, cluster: Cluster, along: float, side: int, rng: np.random.Generator) -> None:
    road = occupancy.road
    off = rng.uniform(*cluster.off)
    across = (road.edge + off, road.verge - off, road.verge + off)[cluster.behind]
    facing = (0.0 if side < 0 else math.pi) + cluster.angle
    same = rng.random() < 0.5  # all of one kind, or of any
    number = int(rng.integers(len(cluster.kinds)))
    drawn = [extents.sample(rng) for _, extents in cluster.kinds]
    for _ in range(int(rng.integers(cluster.count[0], cluster.count[1] + 1))):
        number = number if same else int(rng.integers(len(cluster.kinds)))
        kind, extents = cluster.kinds[number]
        size = drawn[number] if cluster.alike else extents.sample(rng)
        if not road.in_junction(along, _JUNCTION):
            place = side * (across + rng.normal(0.0, cluster.scattered))
            angle, private = facing + rng.normal(0.0, cluster.askew), cluster.behind == 2
            occupancy.place(kind, along, place, size, angle=angle, margin=_MARGIN, private=private)
        along += rng.uniform(*cluster.apart)
