"""Scores between two sets of scans by published protocols: those of LiDM, LiDARGen and R2DM.

A score has its noise floor beside it: the same distance between random halves of the recorded scans.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from lidardraft.errors import LidarDraftError, check_seed
from lidardraft.files import named
from lidardraft.formats.recording import read_points, returns
from lidardraft.metrics.comparisons import (
    Distance,
    FrechetDistance,
    KernelDiscrepancy,
    MatchingDistance,
    PooledDivergence,
    bev_histogram,
    euclidean,
    spectral,
)
from lidardraft.metrics.spherical import SphericalImage, corner_points, spherical_image

_HALVINGS = 10  # of the recorded scans, for a noise floor
_EDGE = 50.0  # m from the sensor to the edges of LiDM's square
_LIDM_NEAR, _LIDM_FAR = 1.0, 56.0  # m, of LiDM's 64-beam sensors
_NEAR, _FAR = 0.5, 63.0  # m, of R2DM
_CLIP = 63.0  # m: the limit of LiDARGen's range images

File = str | os.PathLike[str]
Measure = Callable[[SphericalImage], np.ndarray]


@dataclass(frozen=True, kw_only=True)
class Metric:
    """A metric: its measure of one scan, its distance, and its definition in words. `network` names its weights."""

    name: str
    definition: str
    distance: Callable[[np.ndarray], Distance]
    measure: Measure | None = None
    network: str = ""


@dataclass(frozen=True, kw_only=True)
class Protocol:
    """`near` and `far` [m] bound the projected points. `scans` describes the compared scans; `drawn` gives the numbers
    of recorded and generated scans to draw."""

    name: str
    source: str
    scans: str
    near: float
    far: float
    metrics: tuple[Metric, ...]
    drawn: Callable[[int, int], tuple[int, int]]


@dataclass(frozen=True)
class Score:
    """The metric card: a value, its definition, and the floor, distances of `floor_scans` recorded scans from as many
    others. `network` names and hashes the weights; `left_out` is the reason for a missing value."""

    protocol: str
    source: str
    metric: str
    definition: str
    projection: str
    value: float = float("nan")
    recorded: int = 0
    generated: int = 0
    floor: tuple[float, ...] = ()
    floor_scans: int = 0
    network: str = ""
    left_out: str = ""


def _counted(histogram: np.ndarray) -> np.ndarray:
    cells = np.flatnonzero(histogram)
    return np.stack([cells, histogram.ravel()[cells].astype(np.int64)], axis=1)


def _lidm_cells(image: SphericalImage, edge: float) -> np.ndarray:
    """The indices of the cells of `edge` metres with a point in LiDM's square, each once."""
    points = corner_points(image.depth)[image.within(_LIDM_NEAR, _LIDM_FAR)]
    x, y = points[(np.abs(points[:, :2]) < _EDGE).all(axis=1), :2].T
    half = round(_EDGE / edge)
    return np.unique((np.floor(x / edge).astype(np.int64) + half) * 2 * half + np.floor(y / edge).astype(int) + half)


def _lidm_pooled(image: SphericalImage) -> np.ndarray:
    cells = _lidm_cells(image, 0.05)
    return np.stack([cells, np.ones_like(cells)], axis=1)


def _lidargen_histogram(image: SphericalImage) -> np.ndarray:
    points = corner_points(np.minimum(image.depth, np.float32(_CLIP)))
    return bev_histogram(points[image.depth > 0])


def _r2dm_histogram(image: SphericalImage) -> np.ndarray:
    return bev_histogram(image.points[image.within(_NEAR, _FAR)])


_FRD = Metric(
    name="FRD",
    definition="Frechet distance of 4,096 of the 2,097,152 features (drawn with seed 0) that the last decoder stage of "
    "RangeNet++ (DarkNet-53, SemanticKITTI) has of range, x, y, z and intensity, standardised, 0.5 to 63 m off",
    network="darknet53-1024",
    distance=FrechetDistance,
)
_BEV = "of counts in 100 x 100 cells of 1.6 m, of points 3 to 70 m off"


def _first(sides: np.ndarray, most: int) -> np.ndarray:
    """The comparisons of the first `most` scans of each side."""
    limited = sides.copy()
    for row in limited:
        for side in (0, 1):
            row[np.flatnonzero(row == side)[most:]] = -1
    return limited


def _top_view_metrics(
    histogram: Measure, squared_distances: Callable[[np.ndarray, np.ndarray], np.ndarray], norm: str
) -> tuple[Metric, Metric]:
    """JSD and MMD of LiDARGen and R2DM, which differ in the points and the norm."""
    return (
        Metric(
            name="JSD",
            definition=f"square root of the Jensen-Shannon divergence in nats of the sums {_BEV}",
            measure=lambda image: _counted(histogram(image)),
            distance=lambda sides: PooledDivergence(sides, 100**2),
        ),
        Metric(
            name="MMD",
            definition=f"squared maximum mean discrepancy {_BEV}, divided by their sum; Gaussian kernel of width 0.5 "
            f"in the {norm}norm, pairs of a scan with itself included",
            measure=histogram,
            distance=lambda sides: KernelDiscrepancy(sides, squared_distances),
        ),
    )


PROTOCOLS = {
    "lidm": Protocol(
        name="lidm",
        source="hancyran/LiDAR-Diffusion, lidm/eval (Ran et al., CVPR 2024)",
        scans="both sides 64 x 1024, +3 to -25 degrees, 1 to 56 m, points along the upper left corners of pixels",
        near=_LIDM_NEAR,
        far=_LIDM_FAR,
        drawn=lambda recorded, generated: (recorded, generated),
        metrics=(
            Metric(
                name="JSD",
                definition="square root of the Jensen-Shannon divergence in nats of the summed top views: cells of "
                "0.05 m within 50 m to each side, each counted once a scan",
                measure=_lidm_pooled,
                distance=lambda sides: PooledDivergence(sides, 2000**2),
            ),
            Metric(
                name="MMD",
                definition="minimum matching distance: mean over recorded scans of the least chamfer distance (squared "
                "distances, mean of both ways) to a generated one, of occupied cells of 0.5 m in a square of edge 1",
                measure=lambda image: _lidm_cells(image, 0.5),
                distance=MatchingDistance,
            ),
            Metric(
                name="FRID",
                definition="Frechet distance of 512 features: the last decoder stage of RangeNet++ (DarkNet-21, no "
                "intensity), averaged over 16 groups of 4 rows; range, x, y, z in metres, -1 where nothing returns",
                network="rangenet21_lidm",
                distance=FrechetDistance,
            ),
        ),
    ),
    "lidargen": Protocol(
        name="lidargen",
        source="vzyrianov/lidargen, metrics (Zyrianov et al., ECCV 2022)",
        scans="both sides 64 x 1024, +3 to -25 degrees, ranges clipped to 63 m, points along the upper left corners of "
        "pixels; as many recorded scans as generated ones, drawn at random",
        near=0.0,
        far=np.inf,
        drawn=lambda recorded, generated: (min(recorded, generated), generated),
        metrics=(
            *_top_view_metrics(_lidargen_histogram, spectral, "matrix 2-"),
            replace(
                _FRD,
                definition=f"{_FRD.definition}, of 1,100 scans a side at most",
                distance=lambda sides: FrechetDistance(_first(sides, 1100)),
            ),
        ),
    ),
    "r2dm": Protocol(
        name="r2dm",
        source="kazuto1011/r2dm, evaluate.py (Nakashima and Kurazume, ICRA 2024)",
        scans="both sides 64 x 1024, +3 to -25 degrees, the nearest point of each pixel as it is, 0.5 to 63 m; at most "
        "10,000 scans a side, drawn at random",
        near=0.0,
        far=np.inf,
        drawn=lambda recorded, generated: (min(recorded, 10_000), min(generated, 10_000)),
        metrics=(
            *_top_view_metrics(_r2dm_histogram, euclidean, "Euclidean "),
            _FRD,
            Metric(
                name="FPD",
                definition="Frechet distance of 1,808 features (all layers of the classifier) that PointNet (ShapeNet, "
                "16 classes) has of the points over 80 m, pixels without a return as (0, 0, 0)",
                network="cls_model_39",
                distance=FrechetDistance,
            ),
        ),
    ),
}


def compare(
    protocol: Protocol,
    recorded: Sequence[File],
    generated: Sequence[File],
    *,
    networks: File | None = None,
    device: str = "cpu",
    seed: int = 0,
    on_scan: Callable[[], object] | None = None,
    intensity_scale: float | None = None,
) -> list[Score]:
    """The scores of generated scans in files beside recorded ones, each file read once; `on_scan` is called after each.
    `intensity_scale` is that of recorded intensities, as in `read_recording`.

    `networks` is the folder of the public weights; without it, metrics that need some are left out. Raises
    `LidarDraftError` if a file holds no scan, or nothing to measure.
    """
    random = np.random.default_rng(check_seed(seed))
    files, counts = [], protocol.drawn(len(recorded), len(generated))
    for side, count in zip((recorded, generated), counts, strict=True):
        files += [side[number] for number in random.permutation(len(side))[:count]]
    sides, half = _sides(*counts, random)
    measured = list[tuple[Distance, Measure]]()
    scores = list[Score]()
    for metric in protocol.metrics:
        measure, network, left_out = _measure(metric, networks, device)
        if measure is not None:
            measured.append((metric.distance(sides), measure))
        about = protocol.name, protocol.source, metric.name, metric.definition, protocol.scans
        scores.append(Score(*about, math.nan, *counts, floor_scans=half, network=network, left_out=left_out))
    needed = any(score.network for score in scores) or None  # networks use intensities
    for number, file in enumerate(files):
        scale = intensity_scale if number < counts[0] else None
        points, fields = read_points(file, intensity_scale=scale, needs_intensity=needed)
        with named(file):
            points, fields = returns(points, fields)
            image = spherical_image(points, fields.get("intensity"), near=protocol.near, far=protocol.far)
            for distance, measure in measured:
                distance.add(measure(image))
        if on_scan is not None:
            on_scan()
    found = iter([distance.distances().tolist() for distance, _ in measured])
    valued = ((score, [] if score.left_out else next(found)) for score in scores)
    return [replace(score, value=values[0], floor=tuple(values[1:])) if values else score for score, values in valued]


def _sides(recorded: int, generated: int, random: np.random.Generator) -> tuple[np.ndarray, int]:
    """The two sets and halvings of recorded scans, as in `metrics.comparisons`, and the number of scans in a half.

    A half has as many scans as were generated, if there are enough recorded ones: distances depend on numbers.
    """
    if not (recorded and generated):
        raise LidarDraftError("a set of scans is empty; a score needs at least one scan on each side")
    half = min(recorded // 2, generated)
    sides = np.full((1 + (_HALVINGS if half > 1 else 0), recorded + generated), -1, dtype=np.int8)
    sides[0] = np.repeat([0, 1], [recorded, generated])
    for halving in sides[1:]:
        halving[: 2 * half] = random.permutation(np.repeat([0, 1], half))
    return sides, half


def _measure(metric: Metric, networks: File | None, device: str) -> tuple[Measure | None, str, str]:
    """The measure of a metric, the description of its network, and the reason if it is left out."""
    if metric.measure is not None:
        return metric.measure, "", ""
    from lidardraft.perception.feature_networks import NETWORKS

    network = NETWORKS[metric.network]
    if networks is None or not network.is_in(networks):
        return None, "", f"needs {network.files} in the folder of --networks, from {network.address}"
    loaded = network.load(networks, device)
    return loaded.measure, loaded.description, ""
