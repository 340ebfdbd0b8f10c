"""A labelled point cloud becomes a layout: ground, then clusters of each class, then shapes for each."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from lidardraft.drafting.cloud_rules import (
    ELLIPSE_SCALE,
    FRONT_DEPTH,
    HANGING_CLASSES,
    HANGING_HEIGHT,
    MAX_CROWN,
    MIN_CROWN,
    MIN_EXTENT,
    MIN_POINTS,
    OTHER_REACH,
    POST_CLASSES,
    REACH,
    UNSPLIT_LENGTH,
)
from lidardraft.drafting.clustering import FittedBox, cluster, completions, fit_box, split
from lidardraft.drafting.height_field import HeightField
from lidardraft.errors import LayoutError
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.semantics import CLASSES, GROUND, NUM_CLASSES, SemanticClass

_STRAY = 10  # points; fewer of the ground within an object are noise
_SLICE = 0.3  # m of height
_FURTHEST = 1000.0  # m; no sensor sees further


def layout_from_cloud(
    points: np.ndarray,
    labels: np.ndarray,
    *,
    instances: np.ndarray | None = None,
    sensor_height: float = 1.73,
    source: str = "point cloud",
) -> Layout:
    """The layout of one labelled scan.

    `points` [N, 3] in the sensor frame [m]; `labels` [N] class ids of `semantics.CLASSES`, 0 is left out; `instances`
    [N] numbers of objects, counted for each class, 0 where unknown: those points are clustered. `sensor_height` is that
    over the road [m]. The ground becomes a mesh for each class; people, vehicles, buildings, walls, fences and signs
    become boxes, vegetation ellipsoids, poles and trunks cylinders. The same cloud always gives the same layout.

    Raises `LayoutError` on arrays that do not fit together or hold what cannot be.
    """
    instances = np.zeros(len(labels), dtype=np.uint32) if instances is None else instances
    _check(points, labels, instances)
    if not math.isfinite(sensor_height):
        raise LayoutError(f"sensor_height is {sensor_height} m; it must be finite")
    points = points.astype(np.float64) + np.array([0.0, 0.0, sensor_height])
    ground = HeightField(points, labels)
    primitives = ground.primitives()
    number = 0
    for row in CLASSES:
        mine = labels == row.id
        if row.name == "none" or row.name in GROUND or not mine.any():
            continue
        others = points[~mine & (labels != 0)]
        for index, (shape, box) in enumerate(_shapes(row, points[mine], instances[mine], others, ground), start=1):
            number += row.is_thing
            stands = row.name not in HANGING_CLASSES
            primitives.append(_primitive(shape, _grounded(box, ground) if stands else box, row, index, number))
    return Layout(primitives=tuple(primitives), provenance={"source": source, "sensor_height": sensor_height})


def _check(points: np.ndarray, labels: np.ndarray, instances: np.ndarray) -> None:
    if points.ndim != 2 or points.shape[1] != 3 or not len(points):
        raise LayoutError(f"points have shape {points.shape}; they must be [N, 3] with N > 0")
    for name, values in (("labels", labels), ("instances", instances)):
        if values.shape != points.shape[:1]:
            raise LayoutError(f"{name} have shape {values.shape}; {len(points)} points need ({len(points)},)")
    broken = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(broken):
        raise LayoutError(f"point {broken[0]} is {points[broken[0]].tolist()}; every coordinate must be finite")
    far = np.flatnonzero(np.abs(points).max(axis=1) > _FURTHEST)
    if len(far):
        raise LayoutError(f"point {far[0]} is {points[far[0]].tolist()}; a scan reaches {_FURTHEST:.0f} m")
    unknown = np.flatnonzero((labels < 0) | (labels >= NUM_CLASSES))
    if len(unknown):
        raise LayoutError(f"point {unknown[0]} has label {labels[unknown[0]]}; it must be 0 to {NUM_CLASSES - 1}")
    if not labels.any():
        raise LayoutError(f"all {len(points)} points have label 0, unlabelled; a layout needs points with a class")


def _primitive(shape: str, box: FittedBox, row: SemanticClass, index: int, number: int) -> Primitive:
    center, size = box.center.round(3).tolist(), box.size.round(3).tolist()
    instance = number if row.is_thing else 0
    return Primitive(
        shape=shape, center=center, size=size, yaw=box.yaw, label=row.name, id=f"{row.name}_{index}", instance=instance
    )


def _shapes(
    row: SemanticClass, points: np.ndarray, instances: np.ndarray, others: np.ndarray, ground: HeightField
) -> Iterator[tuple[str, FittedBox]]:
    found: list[FittedBox] = []
    for members in _groups(points, instances, REACH.get(row.name, OTHER_REACH)):
        if row.size is not None:
            seen = fit_box(members)
            # A cluster in the middle of a larger object, such as a seat behind a window, is a part of it.
            if not any(box.contains(seen.center[None])[0] for box in found):
                found.append(_completed(seen, row.size, ground.points))
                yield "box", found[-1]
        elif row.name in POST_CLASSES:
            yield "cylinder", _post(members)
        elif row.name == "vegetation":
            yield from (("ellipsoid", _crown(part)) for part, _ in split(members, _is_crown))
        elif row.name == "traffic-sign":
            yield "box", fit_box(members)
        else:
            yield from (("box", box) for _, box in split(members, lambda part, box: _is_facade(part, box, others)))


def _completed(seen: FittedBox, size: tuple[float, float, float], ground: np.ndarray) -> FittedBox:
    """The likeliest whole object that does not stand on ground that was seen, or stands on the least of it."""
    boxes = completions(seen, size)
    covered = [np.count_nonzero(box.contains(ground, FRONT_DEPTH)) for box in boxes]
    return boxes[int(np.argmin(np.maximum(covered, _STRAY)))]


def _groups(points: np.ndarray, instances: np.ndarray, reach: float) -> Iterator[np.ndarray]:
    """The points of each numbered object, then the clusters of those without a number."""
    for number in np.unique(instances[instances > 0]):
        yield points[instances == number]
    rest = points[instances == 0]
    yield from (rest[members] for members in cluster(rest, reach=reach, min_points=MIN_POINTS))


def _is_facade(part: np.ndarray, box: FittedBox, others: np.ndarray) -> bool:
    """Whether the part lies on the front of its box, which holds neither the sensor nor points of another class."""
    if box.size.max() <= UNSPLIT_LENGTH:
        return True
    if box.contains(np.zeros((1, 3)))[0] or np.mean(box.depth_behind_front(part) > FRONT_DEPTH) > 0.1:
        return False
    return bool(np.count_nonzero(box.contains(others, margin=FRONT_DEPTH)) <= 0.02 * len(part))


def _is_crown(_part: np.ndarray, box: FittedBox) -> bool:
    return bool(box.size.max() <= MAX_CROWN)


def _crown(points: np.ndarray) -> FittedBox:
    """The ellipsoid seen as large as the points, around the middle half of them along the line of sight.

    Rays pass through foliage: its points lie scattered behind the side that faces the sensor.
    """
    away, sideways = _line_of_sight(points)
    local = np.column_stack([points[:, :2] @ away, points[:, :2] @ sideways, points[:, 2]])
    low, high = (np.percentile(local, end, axis=0) for end in (2, 98))
    low[0], high[0] = np.percentile(local[:, 0], [25, 75])
    along, across, up = (low + high) / 2
    size = np.maximum((high - low) * [1.0, ELLIPSE_SCALE, ELLIPSE_SCALE], MIN_CROWN)
    return FittedBox(
        center=np.array([*(along * away + across * sideways), up]), size=size, yaw=math.atan2(away[1], away[0])
    )


def _post(points: np.ndarray) -> FittedBox:
    """The upright cylinder whose near side holds the points, as thick as they usually are across the line of sight."""
    away, sideways = _line_of_sight(points)
    low, high = points[:, 2].min(), points[:, 2].max()
    slices = np.floor((points[:, 2] - low) / _SLICE).astype(int)
    widths = [np.ptp(points[slices == index, :2] @ sideways) for index in np.unique(slices)]
    width = max(float(np.median(widths)), MIN_EXTENT)
    along, across = np.median(points[:, :2] @ away) + width / 2, np.median(points[:, :2] @ sideways)
    size = np.array([width, width, max(high - low, MIN_EXTENT)])
    return FittedBox(center=np.array([*(along * away + across * sideways), (low + high) / 2]), size=size, yaw=0.0)


def _line_of_sight(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Horizontal unit vectors from the sensor to the points, and to the left of that."""
    middle = points[:, :2].mean(axis=0)
    x, y = middle / max(float(np.linalg.norm(middle)), 1e-6)
    return np.array([x, y]), np.array([-y, x])


def _grounded(box: FittedBox, ground: HeightField) -> FittedBox:
    """The box let down to the ground where it begins less than 2.5 m over it: its foot was hidden."""
    bottom, top = box.center[2] - box.size[2] / 2, box.center[2] + box.size[2] / 2
    height = float(ground.height(box.center[None, :2])[0])
    if not height < bottom < height + HANGING_HEIGHT:
        return box
    center, size = box.center.copy(), box.size.copy()
    center[2], size[2] = (height + top) / 2, top - height
    return replace(box, center=center, size=size)
