"""A labelled point cloud becomes a layout: ground, then clusters of each class, then shapes for each."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np

from lidardraft import _core
from lidardraft.drafting.cloud.fitting import completions, contain, fit_box, fit_post, is_length
from lidardraft.drafting.cloud.ground import GROUND_IDS, surfaces
from lidardraft.drafting.cloud.rules import (
    DETAILS,
    HANGING_CLASSES,
    HANGING_HEIGHT,
    MIN_EXTENT,
    MIN_POINTS,
    OTHER_REACH,
    POST_CLASSES,
    REACH,
    REACH_PER_RANGE,
    Detail,
)
from lidardraft.errors import LayoutError, check_type, one_of
from lidardraft.json_fields import is_number
from lidardraft.scene.intent import Intent
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.semantics import BY_NAME, CLASSES, GROUND, NUM_CLASSES, SemanticClass

_STRAY = 10  # rays; this few through a box do not rule it out
_STRAY_SHARE = 0.1  # of the points of an object, likewise
_MOST_RAYS_THROUGH = 2  # for each point of a cluster; with more the cluster is no object, and its class is wrong
_LEAST_RISE = 0.2  # of the usual height of a class; a cluster that rises less is part of the ground
_TOUCHING = 0.3  # of the usual width of a class; a cluster with its middle nearer to an object is part of it
# A car's outline is not a box: rays meet the road under it and pass over its hood [m], and a fitted box is turned by
# some degrees. So only rays through this share of its length and width have passed through the car.
_CLEARANCE, _ROUNDED, _CORE = 0.3, 0.1, 0.8
_NEIGHBOUR = 15.0  # m; objects no further apart are likely to have the same heading
_FURTHEST, _NEAREST = 1000.0, 1e-6  # m, the limits of ranges
_GROUND_POINTS = 200  # the nearest of the ground, which give the height of the sensor over it
_LOWEST = 8.0  # m from the road: the limit for the lowest point if no point has a class of the ground
_OFF_GROUND, _SLOPE = 0.5, 0.08  # m, the largest height of a road off the ground, and more for each metre to the side
_ROUNDING = 0.01  # m, more than rounding changes a distance
_KNOWN = 2.0  # m; the height is known this near to seen ground
_VEGETATION = BY_NAME["vegetation"].id
_HANGING = np.isin([row.name for row in CLASSES], HANGING_CLASSES)


def layout_from_cloud(
    points: np.ndarray,
    labels: np.ndarray | Callable[[np.ndarray], np.ndarray],
    *,
    instances: np.ndarray | None = None,
    weights: np.ndarray | None = None,
    sensor_height: float = 1.73,
    detail: str = "fine",
    source: str = "point cloud",
) -> Layout:
    """The layout of one labelled scan.

    `points` [N, 3] are in the sensor frame [m]. `labels` [N] are class ids of `semantics.CLASSES`; 0 is left out. They
    may be a function of the points, as `lambda points: segmenter.label_points(points, intensity, height)`. `instances`
    [N] are numbers of objects, counted for each class; points with 0, unknown, are clustered. `weights` [N] are numbers
    of rays, for a thinned cloud in which a point stands for several. `sensor_height` is that over the road [m]; a note
    reports labelled ground at another height.

    The ground becomes a mesh for each class. People, vehicles and signs become boxes, one each; poles and trunks become
    cylinders. Buildings, walls and fences become boxes, and vegetation ellipsoids: with `detail` "fine" as many as make
    the cast of the layout agree with the points, with "objects" few whole ones, for layouts that are edited by hand. An
    object seen from one side gets the usual size of its class, unless more rays than a tenth of its points went through
    it. The same cloud always gives the same layout.

    Raises `LayoutError` on arrays that do not fit together or hold invalid values.
    """
    _check_points(points)
    labels = labels(points) if callable(labels) else labels
    instances = np.zeros(len(points), dtype=np.uint32) if instances is None else instances
    _check_labels(labels, instances, len(points))
    if weights is not None and (np.shape(weights) != (len(points),) or not (np.asarray(weights) > 0).all()):
        raise LayoutError(f"weights have shape {np.shape(weights)}; {len(points)} points need as many numbers over 0")
    if not is_number(sensor_height):
        raise LayoutError(f"sensor_height is {sensor_height} m; it must be finite")
    if not isinstance(detail, str) or detail not in DETAILS:
        raise LayoutError(f"detail is {detail!r}; it must be {one_of(DETAILS, detail)}")
    _check_spread(points)
    points = points.astype(np.float64) + np.array([0.0, 0.0, sensor_height])
    weights = np.ones(len(points)) if weights is None else weights.astype(np.float64)
    scan = _Scan(points, weights, sensor_height, labels, DETAILS[detail].most_rays)
    found = _clustered(scan, instances, DETAILS[detail])
    layout = Layout(
        primitives=(*surfaces(scan.ground), *_numbered(_refined(scan, found, DETAILS[detail]))),
        provenance={"source": source, "sensor_height": float(sensor_height)},
        intent=Intent(headed=False),
    )
    return layout.noted(*_height_note(points, labels, sensor_height))


def _height_note(points: np.ndarray, labels: np.ndarray, sensor_height: float) -> Iterator[str]:
    """A note if the ground nearest to the sensor, or the road if it has a class, is not at z = 0, as `sensor_height`
    [m] puts it. If no ground has a class, a note if no point is low."""
    road = labels == BY_NAME["road"].id
    ground = points[road if road.sum() >= _GROUND_POINTS else np.isin(labels, GROUND_IDS)]
    if len(ground) >= MIN_POINTS:
        away, last = np.hypot(*ground[:, :2].T), min(len(ground), _GROUND_POINTS) - 1
        near = away <= np.partition(away, last)[last]
        what, found = "the ground lies", float(np.median(ground[near, 2]))
        most = _OFF_GROUND + _SLOPE * math.hypot(*ground[near, :2].mean(axis=0))
    else:
        what, found, most = "the lowest point lies", float(np.percentile(points[:, 2], 1)), _LOWEST
    if abs(found) > most:
        below = "; or does z point down in it?" if found > sensor_height else ""
        said = f"{what} at z = {found:.2f} m, as the sensor is taken to be {sensor_height:g} m over the road"
        yield f"{said}; by the cloud it is {sensor_height - found:.2f} m: give sensor_height (--sensor-height){below}"


class _Scan:
    """Points [N, 3] relative to the road with their classes, `labels` u8 [N], and numbers of rays, `weights` [N]; the
    free space along the rays, and the ground."""

    def __init__(
        self, points: np.ndarray, weights: np.ndarray, height: float, labels: np.ndarray, most_rays: int
    ) -> None:
        self.points, self.weights, self.labels = points, weights, labels.astype(np.uint8)
        self.cloud = _core.Cloud(points, origin=(0.0, 0.0, height), most_rays=most_rays)
        self.ground = self.cloud.ground(self.labels, list(GROUND_IDS))

    def heights(self, boxes: np.ndarray) -> np.ndarray:
        """Heights [B] of the ground under boxes [B, 7]."""
        return self.ground.heights(np.ascontiguousarray(boxes[:, :2]))[0]

    def grounded(self, boxes: np.ndarray, labels: np.ndarray) -> np.ndarray:
        """Boxes [B, 7] extended down to the ground if they begin less than 2.5 m over it: their foot was hidden."""
        bottom, top = boxes[:, 2] - boxes[:, 5] / 2, boxes[:, 2] + boxes[:, 5] / 2
        height = self.heights(boxes)
        down = (height < bottom) & (bottom < height + HANGING_HEIGHT) & ~_HANGING[labels]
        bottom = np.where(down, height, bottom)
        return np.column_stack([boxes[:, :2], (bottom + top) / 2, boxes[:, 3:5], top - bottom, boxes[:, 6]])


@dataclass(frozen=True, slots=True, eq=False)
class _Found:
    """The objects that stay whole, each a shape, a box [7] and a class; and the clusters that may be cut into pieces:
    the cluster number of each point, `clusters` u32 [N], from 1, and the class of each cluster."""

    clusters: np.ndarray
    whole: list[tuple[str, np.ndarray, int]] = field(default_factory=list)
    labels: list[int] = field(default_factory=lambda: [0])


def _clustered(scan: _Scan, instances: np.ndarray, detail: Detail) -> _Found:
    points, found = scan.points, _Found(np.zeros(len(scan.points), dtype=np.uint32))
    for row in CLASSES:
        mine = np.flatnonzero(scan.labels == row.id)
        if row.name == "none" or row.name in GROUND or not len(mine):
            continue
        groups = list(_groups(row, points, mine, instances, detail))
        if row.size is not None:
            found.whole.extend(("box", box, row.id) for box in _objects(row, groups, scan))
        elif row.name in POST_CLASSES:
            found.whole.extend(("cylinder", fit_post(points[members]), row.id) for members in groups)
        elif row.name == "traffic-sign":
            found.whole.extend(("box", fit_box(points[members]), row.id) for members in groups)
        else:
            for members in groups:
                found.clusters[members] = len(found.labels)
                found.labels.append(row.id)
    return found


def _refined(scan: _Scan, found: _Found, detail: Detail) -> Iterator[list[tuple[str, np.ndarray, int]]]:
    """The parts of each object, on the ground; whole objects have one."""
    whole = np.array([box for _, box, _ in found.whole]).reshape(-1, 7)
    whole = scan.grounded(whole, np.array([label for *_, label in found.whole], dtype=int))
    yield from ([(shape, box, label)] for (shape, _, label), box in zip(found.whole, whole, strict=True))
    grounds = len(np.unique(scan.labels[np.isin(scan.labels, GROUND_IDS)])) + 1
    clusters, pieces = scan.cloud.refined(
        clusters=found.clusters,
        crowns=scan.labels == _VEGETATION,
        boxes=whole,
        posts=np.array([shape == "cylinder" for shape, *_ in found.whole], dtype=bool),
        ground=scan.ground,
        most_pieces=max(detail.most_shapes - len(whole) - grounds, 0),
        least_length=detail.least_length,
        worth=detail.worth,
        grounded=detail.grounded,
    )
    labels = np.array(found.labels)[clusters]
    if detail.grounded:
        pieces = scan.grounded(pieces, labels)
    rows = zip(clusters.tolist(), pieces, labels.tolist(), strict=True)
    for _, parts in itertools.groupby(rows, key=lambda row: row[0]):
        yield [("ellipsoid" if label == _VEGETATION else "box", box, label) for _, box, label in parts]


def _objects(row: SemanticClass, groups: list[np.ndarray], scan: _Scan) -> Iterator[np.ndarray]:
    """A box [7] around each group, with its unseen sides completed; none for flat groups and those that rays went
    through."""
    assert row.size is not None
    if not groups:
        return
    seen = np.array([fit_box(scan.points[members]) for members in groups])
    choices = completions(seen, row.size, _headings(seen, row.size))
    passed = _passed(choices.reshape(-1, 7), scan).reshape(len(choices), -1)
    counts = np.array([scan.weights[members].sum() for members in groups])
    # rays through the seen part, as through windows, do not decide between the choices
    best = np.argmin(np.maximum(passed - passed[-1], np.maximum(_STRAY, _STRAY_SHARE * counts)), axis=0)
    unreal = passed.min(axis=0) > np.maximum(_STRAY, _MOST_RAYS_THROUGH * counts)
    height, away = scan.ground.heights(np.ascontiguousarray(seen[:, :2]))
    unreal |= (seen[:, 2] + seen[:, 5] / 2 - height < _LEAST_RISE * row.size[2]) & (away <= _KNOWN)
    is_long = row.size[0] > 2 * row.size[1]  # people stand close to each other
    margin = -_TOUCHING * row.size[1] if is_long else 0.0
    found, count = np.empty_like(seen), 0
    for number in np.flatnonzero(~unreal).tolist():
        # A cluster in or on a larger object, such as a seat behind a window or a far corner, is a part of it.
        if not contain(found[:count], seen[number, :2], margin).any():
            found[count], count = choices[best[number], number], count + 1
    yield from found[:count]


def _headings(seen: np.ndarray, size: tuple[float, float, float]) -> np.ndarray:
    """The heading [rad] of the nearest other box with a seen length, for each of boxes [B, 7]; NaN without one."""
    from scipy.spatial import cKDTree  # slow to import, so not for --help

    sure = np.flatnonzero(is_length(seen[:, 3:5].max(axis=1), size))
    if not len(sure):
        return np.full(len(seen), math.nan)
    away, nearest = cKDTree(seen[sure, :2]).query(seen[:, :2], k=[1, 2], distance_upper_bound=_NEIGHBOUR)
    nearest = np.append(sure, -1)[nearest]
    other = (nearest[:, 0] == np.arange(len(seen))).astype(int)
    away, nearest = (np.take_along_axis(values, other[:, None], axis=1)[:, 0] for values in (away, nearest))
    turn = np.where(seen[nearest, 4] > seen[nearest, 3], math.pi / 2, 0.0)
    return np.where(np.isfinite(away), seen[nearest, 6] + turn, math.nan)


def _passed(boxes: np.ndarray, scan: _Scan) -> np.ndarray:
    """The number of rays [B] that went through each of boxes [B, 7] and ended behind or below it.

    Only the core of a box on the ground counts: no ray goes through the core of a real object.
    """
    top = boxes[:, 2] + boxes[:, 5] / 2 - _ROUNDED
    bottom = np.minimum(scan.heights(boxes) + _CLEARANCE, top - MIN_EXTENT)
    cores = np.column_stack([boxes[:, :2], (bottom + top) / 2, _CORE * boxes[:, 3:5], top - bottom, boxes[:, 6]])
    return scan.cloud.passed(scan.weights, cores, boxes)


def _check_points(points: np.ndarray) -> None:
    check_type("points", points, np.ndarray)
    if points.ndim != 2 or points.shape[1] != 3 or not len(points):
        raise LayoutError(f"points have shape {points.shape}; they must be [N, 3] with N > 0")
    if points.dtype.kind not in "fiu":
        raise LayoutError(f"points hold {points.dtype}; they must hold numbers")
    reach = np.abs(points.T, order="C").max(axis=0)
    for wrong, what in (
        (~np.isfinite(reach), "every coordinate must be finite"),
        (reach > _FURTHEST, f"a scan reaches {_FURTHEST:.0f} m"),
        (reach < _NEAREST, "that is in the sensor itself; leave out points that are not returns"),
    ):
        if wrong.any():
            raise LayoutError(f"point {np.argmax(wrong)} is {points[np.argmax(wrong)].tolist()}; {what}")


def _check_spread(points: np.ndarray) -> None:
    """Raise `LayoutError` if several points are all in one spot or on one line, and so show no shape."""
    off = points.T.astype(np.float64, order="C")
    off -= off.mean(axis=1, keepdims=True)
    variances = np.linalg.eigvalsh(off @ off.T / len(points))
    if len(points) > 2 and variances[1] < _ROUNDING**2:
        where = "in one spot" if variances[2] < _ROUNDING**2 else "on one line"
        raise LayoutError(f"all {len(points)} points lie {where}; they show no shape")


def _check_labels(labels: np.ndarray, instances: np.ndarray, count: int) -> None:
    for name, values in (("labels", labels), ("instances", instances)):
        check_type(name, values, np.ndarray)
        if values.shape != (count,):
            raise LayoutError(f"{name} have shape {values.shape}; {count} points need ({count},)")
        if not np.issubdtype(values.dtype, np.integer):
            raise LayoutError(f"{name} are {values.dtype}; they must be whole numbers")
    unknown = np.flatnonzero((labels < 0) | (labels >= NUM_CLASSES))
    if len(unknown):
        raise LayoutError(f"point {unknown[0]} has label {labels[unknown[0]]}; it must be 0 to {NUM_CLASSES - 1}")
    if not labels.any():
        raise LayoutError(f"all {count} points have label 0, unlabelled; a layout needs points with a class")


def _groups(
    row: SemanticClass, points: np.ndarray, mine: np.ndarray, instances: np.ndarray, detail: Detail
) -> Iterator[np.ndarray]:
    """The indices of the points of each numbered object, then those of each cluster of points without a number.

    For classes without a typical size, small clusters of sparser points count too, if there is detail enough.
    """
    order = mine[np.argsort(instances[mine], kind="stable")]
    starts = np.flatnonzero(np.diff(instances[order], prepend=0))
    rest, *numbered = np.split(order, starts)
    yield from numbered
    reach, fewest = REACH.get(row.name, OTHER_REACH), max(MIN_POINTS, detail.least_points)
    whole = row.size is not None
    found = clusters_of(points[rest], reach, MIN_POINTS)
    yield from (rest[members] for members in found if whole or len(members) >= fewest)
    if not whole and detail.least_points < MIN_POINTS:
        strays = np.delete(rest, np.concatenate([*found, np.zeros(0, dtype=int)]))
        yield from (strays[members] for members in clusters_of(points[strays], 2 * reach, detail.least_points))


def clusters_of(points: np.ndarray, reach: float, min_points: int) -> list[np.ndarray]:
    """The indices of the points [N, 3] of each cluster, largest first; neighbours are within `reach` [m] plus 1 % of
    their range."""
    return _core.cluster(points, reach=reach, per_range=REACH_PER_RANGE, min_points=min_points)


def _numbered(objects: Iterator[list[tuple[str, np.ndarray, int]]]) -> Iterator[Primitive]:
    """The primitives, class by class, with an instance for each thing. Pieces are parts of one object."""
    number, index = 0, [0] * NUM_CLASSES
    for parts in sorted(objects, key=lambda parts: parts[0][2]):
        row = CLASSES[parts[0][2]]
        number += row.is_thing
        index[row.id] += 1
        for part, (shape, box, _) in enumerate(parts, start=1):
            name = f"{index[row.id]}.{part}" if len(parts) > 1 else str(index[row.id])
            yield Primitive(
                shape=shape,
                center=box[:3].round(3).tolist(),
                size=box[3:6].round(3).tolist(),
                yaw=float(box[6]),
                label=row.name,
                id=f"{row.name}_{name}",
                instance=number if row.is_thing else 0,
            )
