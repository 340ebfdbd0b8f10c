"""A labelled point cloud becomes a layout: ground, then clusters of each class, then shapes for each."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from operator import attrgetter

import numpy as np

from lidardraft.drafting.cloud.clustering import FittedBox, cluster, completions, fit_box, fit_post, is_length
from lidardraft.drafting.cloud.ground import HeightField
from lidardraft.drafting.cloud.rays import Rays
from lidardraft.drafting.cloud.refinement import Piece, refined
from lidardraft.drafting.cloud.rules import (
    DETAILS,
    HANGING_CLASSES,
    HANGING_HEIGHT,
    MIN_EXTENT,
    MIN_POINTS,
    OTHER_REACH,
    POST_CLASSES,
    REACH,
    Detail,
)
from lidardraft.errors import LayoutError, check_type, one_of
from lidardraft.json_fields import is_number
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.semantics import CLASSES, GROUND, NUM_CLASSES, SemanticClass

_STRAY = 10  # rays; as few that went through a box do not speak against it
_MOST_RAYS_THROUGH = 2  # for each point of a cluster; with more it is no object, and its points have a wrong class
_LEAST_RISE = 0.2  # of the usual height of a class: what does not rise so far from the ground is the ground's
_TOUCHING = 0.3  # of the usual width of a class: a cluster whose middle is so near to an object has no room of its own
# The outline of a car is no box's: rays see the road under it and pass over its hood [m], and a fitted box is turned by
# some degrees; only what passes through this share of its length and width passed through it.
_CLEARANCE, _ROUNDED, _CORE = 0.3, 0.1, 0.8
_NEIGHBOUR = 15.0  # m; objects no further apart are likely to be headed the same way
_FURTHEST, _NEAREST = 1000.0, 1e-6  # m; no sensor sees further, or nearer
_ROUNDING = 0.01  # m, more than rounding makes of a distance


def layout_from_cloud(
    points: np.ndarray,
    labels: np.ndarray | Callable[[np.ndarray], np.ndarray],
    *,
    instances: np.ndarray | None = None,
    weights: np.ndarray | None = None,
    sensor_height: float = 1.73,
    detail: str = "fine",
    source: str = "point cloud",
    stray_share: float = 0.1,
) -> Layout:
    """The layout of one labelled scan.

    `points` [N, 3] in the sensor frame [m]; `labels` [N] class ids of `semantics.CLASSES`, 0 is left out, or a function
    of the points that tells them, as `lambda points: segmenter.label_points(points, intensity, height)` does;
    `instances` [N] numbers of objects, counted for each class, 0 where unknown: those points are clustered.
    `weights` [N] numbers of rays, where the cloud was thinned and a point stands for several.
    `sensor_height` is that over the road [m].

    The ground becomes a mesh for each class; people, vehicles and signs become boxes, one each, poles and trunks
    cylinders. Buildings, walls and fences become boxes and vegetation ellipsoids: with `detail` "fine" as many as make
    the cast of the layout agree with the points, with "objects" few whole ones, for layouts that are edited by hand.
    An object seen from one side gets the usual size of its class, unless more rays than this share of its points went
    through there: `stray_share`, more where depth is guessed. The same cloud always gives the same layout.

    Raises `LayoutError` on arrays that do not fit together or hold what cannot be.
    """
    _check_points(points)
    labels = labels(points) if callable(labels) else labels
    instances = np.zeros(len(points), dtype=np.uint32) if instances is None else instances
    _check_labels(labels, instances, len(points))
    if weights is not None and (np.shape(weights) != (len(points),) or not (np.asarray(weights) > 0).all()):
        raise LayoutError(f"weights have shape {np.shape(weights)}; {len(points)} points need as many numbers over 0")
    if not is_number(sensor_height):
        raise LayoutError(f"sensor_height is {sensor_height} m; it must be finite")
    if not (is_number(stray_share) and 0 <= stray_share <= 1):
        raise LayoutError(f"stray_share is {stray_share}; it must be 0 to 1")
    if not isinstance(detail, str) or detail not in DETAILS:
        raise LayoutError(f"detail is {detail!r}; it must be {one_of(DETAILS, detail)}")
    _check_spread(points)
    points = points.astype(np.float64) + np.array([0.0, 0.0, sensor_height])
    rays = Rays(points, np.array([0.0, 0.0, sensor_height]), weights)
    ground = HeightField(rays, labels)
    shapes, pieces = _clustered(rays, labels, instances, ground, DETAILS[detail], stray_share)
    others = [_primitive(*shape, str(index), index) for index, shape in enumerate(shapes)]
    pieces = refined(pieces, rays, [*others, *ground.primitives()], DETAILS[detail])
    objects = [[shape] for shape in shapes]
    cluster_of = attrgetter("label", "cluster")
    for _, parts in itertools.groupby(sorted(pieces, key=cluster_of), key=cluster_of):
        boxes = [(piece, _grounded(piece.box, piece.label, ground)) for piece in parts]
        objects.append(
            [(piece.shape, box if DETAILS[detail].grounded else piece.box, piece.label) for piece, box in boxes]
        )
    primitives = [*ground.primitives(), *_numbered(objects)]
    return Layout(primitives=tuple(primitives), provenance={"source": source, "sensor_height": sensor_height})


Shape = tuple[str, FittedBox, int]  # the name of the shape, where it is, and the id of its class


def _clustered(
    rays: Rays,
    labels: np.ndarray,
    instances: np.ndarray,
    ground: HeightField,
    detail: Detail,
    stray_share: float,
) -> tuple[list[Shape], list[Piece]]:
    """The objects that stay whole, and the clusters of what may be cut in pieces."""
    points = rays.points
    shapes: list[Shape] = []
    pieces: list[Piece] = []
    for row in CLASSES:
        mine = np.flatnonzero(labels == row.id)
        if row.name == "none" or row.name in GROUND or not len(mine):
            continue
        groups = _groups(row, points, mine, instances, detail)
        if row.size is not None:
            found = [("box", box) for box in _objects(row, list(groups), ground, rays, stray_share)]
        elif row.name in POST_CLASSES:
            found = [("cylinder", fit_post(points[members])) for members in groups]
        elif row.name == "traffic-sign":
            found = [("box", fit_box(points[members])) for members in groups]
        else:
            shape = "ellipsoid" if row.name == "vegetation" else "box"
            for number, members in enumerate(groups):
                pieces += Piece.from_points(points, members, row.id, shape, number).tiles(points)
            continue
        shapes += [(shape, _grounded(box, row.id, ground), row.id) for shape, box in found]
    return shapes, pieces


def _objects(
    row: SemanticClass, groups: list[np.ndarray], ground: HeightField, rays: Rays, stray_share: float
) -> list[FittedBox]:
    """A box around each group, with the sides that were not seen; none of what is flat or what rays went through."""
    if row.size is None or not groups:
        return []
    seen = [fit_box(rays.points[members]) for members in groups]
    headings = _headings(seen, row.size)
    choices = [completions(box, row.size, heading) for box, heading in zip(seen, headings, strict=True)]
    passed = np.array([_passed(boxes, row, ground, rays) for boxes in zip(*choices, strict=True)])
    counts = np.array([rays.weights[members].sum() for members in groups])
    strays = np.maximum(_STRAY, stray_share * counts)
    # rays that pass through what was seen, as through windows, do not tell one choice from the other
    best = np.argmin(np.maximum(passed - passed[-1], strays), axis=0)
    unreal = _is_flat(seen, row.size[2], ground) | (
        passed.min(axis=0) > np.maximum(_STRAY, _MOST_RAYS_THROUGH * counts)
    )
    found: list[FittedBox] = []
    places, reaches = np.empty((len(seen), 2)), np.empty(len(seen))  # of those found, so that only near ones are asked
    is_long = row.size[0] > 2 * row.size[1]  # people stand close to each other
    margin = -_TOUCHING * row.size[1] if is_long else 0.0
    for box, boxes, choice, gone in zip(seen, choices, best.tolist(), unreal.tolist(), strict=True):
        # A cluster in or on a larger object, such as a seat behind a window or a far corner, is a part of it.
        number = len(found)
        near = np.linalg.norm(places[:number] - box.center[:2], axis=1) <= reaches[:number]
        if not gone and not any(found[other].contains(box.center[None], margin)[0] for other in np.flatnonzero(near)):
            found.append(whole := boxes[choice])
            places[number], reaches[number] = whole.center[:2], np.linalg.norm(whole.size[:2] / 2 - margin) + _ROUNDING
    return found


def _headings(seen: list[FittedBox], size: tuple[float, float, float]) -> list[float | None]:
    """For each box the heading [rad] of the nearest other one whose length was seen; None where there is none."""
    sure = np.flatnonzero([is_length(max(box.size[:2]), size) for box in seen])
    places = np.array([box.center[:2] for box in seen])
    found: list[float | None] = []
    for number, box in enumerate(seen):
        others = sure[sure != number]
        away = np.linalg.norm(places[others] - box.center[:2], axis=1)
        nearest = seen[others[np.argmin(away)]] if away.min(initial=math.inf) < _NEIGHBOUR else None
        turn = math.pi / 2 if nearest and nearest.size[1] > nearest.size[0] else 0.0
        found.append(nearest.yaw + turn if nearest else None)
    return found


def _is_flat(boxes: Sequence[FittedBox], height: float, ground: HeightField) -> np.ndarray:
    """Which boxes [N] of a class of that height hardly rise from ground that was seen."""
    places = np.array([box.center[:2] for box in boxes])
    tops = np.array([box.center[2] + box.size[2] / 2 for box in boxes])
    flat: np.ndarray = tops - ground.height(places) < _LEAST_RISE * height
    return flat & ground.is_known(places)


def _passed(boxes: Sequence[FittedBox], row: SemanticClass, ground: HeightField, rays: Rays) -> np.ndarray:
    """How many rays went through each box [N] of a class and ended behind or below it."""
    heights = ground.height(np.array([box.center[:2] for box in boxes]))
    cores = [_core(box, height) for box, height in zip(boxes, heights.tolist(), strict=True)]
    hits = rays.cast([_primitive("box", core, row.id, str(index), 1) for index, core in enumerate(cores)])
    passed = np.zeros(len(boxes))
    for index in np.unique(hits.primitive[hits.too_near]):
        ends = hits.chosen[hits.too_near & (hits.primitive == index)]
        # What lies in the box, such as a windscreen behind its hood, is a part of the object.
        bottom = cores[index].center[2] - cores[index].size[2] / 2
        inside = boxes[index].contains(rays.points[ends]) & (rays.points[ends, 2] > bottom)
        passed[index] = rays.weights[ends[~inside]].sum()
    return passed


def _core(box: FittedBox, height: float) -> FittedBox:
    """What of a box, on ground of a height, no ray goes through if it is that of an object."""
    top = box.center[2] + box.size[2] / 2 - _ROUNDED
    bottom = min(height + _CLEARANCE, top - MIN_EXTENT)
    center, size = [*box.center[:2], (bottom + top) / 2], [*(_CORE * box.size[:2]), top - bottom]
    return replace(box, center=np.array(center), size=np.array(size))


def _check_points(points: np.ndarray) -> None:
    check_type("points", points, np.ndarray)
    if points.ndim != 2 or points.shape[1] != 3 or not len(points):
        raise LayoutError(f"points have shape {points.shape}; they must be [N, 3] with N > 0")
    if points.dtype.kind not in "fiu":
        raise LayoutError(f"points hold {points.dtype}; they must hold numbers")
    broken = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(broken):
        raise LayoutError(f"point {broken[0]} is {points[broken[0]].tolist()}; every coordinate must be finite")
    far = np.flatnonzero(np.abs(points).max(axis=1) > _FURTHEST)
    if len(far):
        raise LayoutError(f"point {far[0]} is {points[far[0]].tolist()}; a scan reaches {_FURTHEST:.0f} m")
    near = np.flatnonzero((np.abs(points) < _NEAREST).all(axis=1))
    if len(near):
        raise LayoutError(
            f"point {near[0]} is {points[near[0]].tolist()}, in the sensor itself; leave out what is no return"
        )


def _check_spread(points: np.ndarray) -> None:
    """Raise `LayoutError` where several points lie in one spot or on one line, and so show the shape of nothing."""
    variances = np.linalg.eigvalsh(np.cov(points.T.astype(np.float64), bias=True))
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
    """The indices of each numbered object's points, then those of the clusters of points without a number.

    Of what has no typical size, small clusters of points further apart count too, if there is detail enough.
    """
    for number in np.unique(instances[mine][instances[mine] > 0]):
        yield mine[instances[mine] == number]
    rest = mine[instances[mine] == 0]
    reach, fewest = REACH.get(row.name, OTHER_REACH), max(MIN_POINTS, detail.least_points)
    whole = row.size is not None
    found = cluster(points[rest], reach=reach, min_points=MIN_POINTS)
    yield from (rest[members] for members in found if whole or len(members) >= fewest)
    if not whole and detail.least_points < MIN_POINTS:
        strays = np.delete(rest, np.concatenate([*found, np.zeros(0, dtype=int)]))
        found = cluster(points[strays], reach=2 * reach, min_points=detail.least_points)
        yield from (strays[members] for members in found)


def _numbered(objects: list[list[Shape]]) -> Iterator[Primitive]:
    """The primitives, class by class, with a number for each object that is counted. Pieces are parts of one object."""
    number, index = 0, [0] * NUM_CLASSES
    for parts in sorted(objects, key=lambda parts: parts[0][2]):
        label = parts[0][2]
        number += CLASSES[label].is_thing
        index[label] += 1
        for part, (shape, box, _) in enumerate(parts, start=1):
            name = f"{index[label]}.{part}" if len(parts) > 1 else str(index[label])
            yield _primitive(shape, box, label, name, number)


def _primitive(shape: str, box: FittedBox, label: int, name: str, number: int) -> Primitive:
    row = CLASSES[label]
    center, size = box.center.round(3).tolist(), box.size.round(3).tolist()
    instance = number if row.is_thing else 0
    return Primitive(
        shape=shape, center=center, size=size, yaw=box.yaw, label=row.name, id=f"{row.name}_{name}", instance=instance
    )


def _grounded(box: FittedBox, label: int, ground: HeightField) -> FittedBox:
    """The box let down to the ground where it begins less than 2.5 m over it: its foot was hidden."""
    if CLASSES[label].name in HANGING_CLASSES:
        return box
    bottom, top = box.center[2] - box.size[2] / 2, box.center[2] + box.size[2] / 2
    height = float(ground.height(box.center[None, :2])[0])
    if not height < bottom < height + HANGING_HEIGHT:
        return box
    center, size = box.center.copy(), box.size.copy()
    center[2], size[2] = (height + top) / 2, top - height
    return replace(box, center=center, size=size)
