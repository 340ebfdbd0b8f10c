"""The coarse layouts of a street, as a sentence, a clustering, a picture or annotators would give them.

All shapes are solid, even if they are porous in the detailed scene: no input makes a medium. Their frame is that of the
ego vehicle, fixed to the road under it: `pose` is street_from_ego [4, 4].
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import ClassVar, TypeAlias

import numpy as np

from lidardraft.drafting.cloud.layout import layout_from_cloud
from lidardraft.objects.coarse_shapes import MOST_LOBES
from lidardraft.objects.kinds import FAMILIES
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.shape_table import ShapeTable
from lidardraft.streets.coarse.coarse_street import SEEN, CoarseStreet, place_of

_NOTICED = 5  # returns from which a picture shows an object: an estimate
_SHARES = (0.3, 0.35, 0.2, 0.15)  # the share of each style
_HAS_SIDEWALKS, _HAS_POLES, _IS_NUMBERED, _IS_FLAT = 0.85, 0.85, 0.5, 0.5  # probabilities
_MOST_OMITTED = 0.3  # share of small objects, in one of three pictures
_NAMED_WITHIN = (45.0, 80.0)  # m
# Cameras see 60 to 120 degrees; monocular depth is wrong by some percent. Shown objects must still be worth obeying.
_PICTURED_WITHIN, _VIEW_DEGREES = (30.0, 70.0), (60.0, 120.0)  # m, degrees
_MOST_ERROR, _MOST_TURN = 0.03, 0.05  # share, rad


@dataclass(frozen=True, eq=False)
class VisibleObjects:
    """The returns of one scan on objects, from a sensor at `pose` [4, 4] over the ego vehicle at `place` (x, y, yaw).

    `scan` has the primitive of each return; `owners` i32 [P + 1] is the object of each primitive, of `count`, as in
    `CoarseStreet`.
    """

    place: tuple[float, float, float]
    pose: np.ndarray
    scan: RangeImage
    owners: np.ndarray
    count: int

    def returns(self) -> np.ndarray:
        """The number of returns of each object, i64 [T]."""
        assert self.scan.primitive is not None
        owner = self.owners[self.scan.primitive[self.scan.valid]]
        return np.bincount(owner[owner >= 0], minlength=self.count)


@dataclass(frozen=True, kw_only=True, slots=True)
class TextStyle:
    """The objects that the sentence names: vehicles, and those of the `FAMILIES` in `named`, within `reach` [m] of the
    ego vehicle.

    `sidewalks` and `poles` are whether it has any.
    """

    source: ClassVar[str] = "text"
    coverage: ClassVar[tuple[float, float] | None] = None
    named: tuple[str, ...] = tuple(FAMILIES)
    sidewalks: bool = True
    poles: bool = True
    reach: float = 200.0


def as_text(street: CoarseStreet, style: TextStyle, pose: np.ndarray) -> ShapeTable:
    """The layout of a sentence: sizes of the solver, objects amid their lanes and along the road, flat ground."""
    x, y, _ = place_of(pose)
    near = np.hypot(*(street.places[:, :2] - (x, y)).T) <= style.reach
    chosen = np.isin(street.families, ("", *style.named)) & near & (style.poles | ~street.poles)
    ground = street.ground(pose, relief=False, sidewalks=style.sidewalks)
    return ShapeTable.join(ground, street.standing(street.solved, chosen, pose, relief=False))


@dataclass(frozen=True, kw_only=True, slots=True)
class ClusterStyle:
    """`numbered` is whether the points have instance numbers."""

    source: ClassVar[str] = "cloud"
    coverage: ClassVar[tuple[float, float] | None] = None
    numbered: bool = True


def as_clusters(style: ClusterStyle, visible: VisibleObjects) -> ShapeTable:
    """The layout that `layout_from_cloud` makes of the scan."""
    scan, (x, y, height) = visible.scan, visible.pose[:3, 3].tolist()
    layout = layout_from_cloud(
        scan.points() @ visible.pose[:3, :3].T,
        scan.label[scan.valid],
        instances=scan.instance[scan.valid] if style.numbered else None,
        sensor_height=height,
    )
    shapes = ShapeTable.from_primitives(layout)
    return replace(shapes, centers=shapes.centers + np.array([x, y, 0.0]))


@dataclass(frozen=True, kw_only=True, slots=True)
class PictureStyle:
    """The content of a picture, and the accuracy of its objects.

    It shows the objects within `reach` [m] and `view` [rad] around straight ahead. `omit` is the share of small objects
    left out. `sidewalks` and `poles` are whether it has any, `relief` whether its ground rises and falls. `lobes` is
    the number of ellipsoids in a crown. `error` is the standard deviation of sizes in shares of them and of places in
    shares of the distance, `turn` that of yaw [rad].
    """

    source: ClassVar[str] = "picture"
    relief: bool = False
    sidewalks: bool = True
    poles: bool = True
    omit: float = 0.0
    lobes: int = 1
    error: float = 0.0
    turn: float = 0.0
    reach: float = 200.0
    view: float = math.tau

    @property
    def coverage(self) -> tuple[float, float] | None:
        """The azimuths [rad] that the picture shows, as in `Layout.coverage`."""
        return None if self.view >= math.tau else (-self.view / 2, self.view / 2)


def as_picture(
    street: CoarseStreet, style: PictureStyle, rng: np.random.Generator, pose: np.ndarray, visible: VisibleObjects
) -> ShapeTable:
    """The layout of a picture."""
    chosen = _in_picture(street, style, rng, visible)
    errors = _errors(street, style, rng, pose)
    ground = street.ground(pose, relief=style.relief, sidewalks=style.sidewalks)
    shapes = street.standing(street.exact, chosen, pose, relief=style.relief, lobes=style.lobes, errors=errors)
    return ShapeTable.join(ground, shapes)


def _in_picture(
    street: CoarseStreet, style: PictureStyle, rng: np.random.Generator, visible: VisibleObjects
) -> np.ndarray:
    """The mask [T] of objects in the picture."""
    x, y, yaw = visible.place
    ahead = street.places[:, :2] - (x, y)
    bearing = np.arctan2(ahead[:, 1], ahead[:, 0]) - yaw
    inside = np.cos(bearing) >= math.cos(style.view / 2)
    near = np.hypot(ahead[:, 0], ahead[:, 1]) <= style.reach
    omitted = street.small & (rng.random(len(street.objects)) < style.omit)
    noticed = visible.returns() >= _NOTICED
    shown: np.ndarray = inside & near & noticed & (style.poles | ~street.poles) & ~omitted
    return shown


def _errors(
    street: CoarseStreet, style: PictureStyle, rng: np.random.Generator, pose: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Errors of the places [T, 3] (x, y, yaw), x and y along the line of sight, and scales of the sizes [T, 3]."""
    count = len(street.objects)
    sight = street.places[:, :2] - place_of(pose)[:2]
    off = np.column_stack([sight * rng.normal(0.0, style.error, (count, 1)), rng.normal(0.0, style.turn, count)])
    return off, np.exp(rng.normal(0.0, style.error, (count, 3)))


@dataclass(frozen=True, kw_only=True, slots=True)
class BoxStyle:
    """`relief` is whether the ground rises and falls or is flat."""

    source: ClassVar[str] = "boxes"
    coverage: ClassVar[tuple[float, float] | None] = None
    relief: bool = False


def as_boxes(street: CoarseStreet, style: BoxStyle, pose: np.ndarray, reach: float = SEEN) -> ShapeTable:
    """The layout of boxes: all objects at their places and sizes, and the ground within `reach` [m]."""
    everything = np.ones(len(street.objects), dtype=bool)
    ground = street.ground(pose, relief=style.relief, reach=reach)
    return ShapeTable.join(ground, street.standing(street.exact, everything, pose, relief=style.relief))


Style: TypeAlias = TextStyle | ClusterStyle | PictureStyle | BoxStyle

# Estimates of people's inputs.
_STYLES = (TextStyle, ClusterStyle, PictureStyle, BoxStyle)


def coarse_layout(
    street: CoarseStreet, style: Style, rng: np.random.Generator, pose: np.ndarray, visible: VisibleObjects
) -> ShapeTable:
    """The coarse layout of a street in a style; `visible` are the returns of a scan from `pose`."""
    match style:
        case TextStyle():
            return as_text(street, style, pose)
        case ClusterStyle():
            return as_clusters(style, visible)
        case PictureStyle():
            return as_picture(street, style, rng, pose, visible)
        case BoxStyle():
            return as_boxes(street, style, pose)


def sample_style(rng: np.random.Generator) -> Style:
    """A random style of people's inputs."""
    style = _STYLES[int(rng.choice(len(_STYLES), p=_SHARES))]
    sidewalks, poles = bool(rng.random() < _HAS_SIDEWALKS), bool(rng.random() < _HAS_POLES)
    omit, lobes = float(rng.choice((0.0, 0.0, rng.uniform(0.0, _MOST_OMITTED)))), int(rng.integers(1, MOST_LOBES + 1))
    if style is TextStyle:
        named = tuple(family for family, share in FAMILIES.items() if rng.random() < share)
        return TextStyle(named=named, sidewalks=sidewalks, poles=poles, reach=float(rng.uniform(*_NAMED_WITHIN)))
    if style is ClusterStyle:
        return ClusterStyle(numbered=bool(rng.random() < _IS_NUMBERED))
    relief = bool(rng.random() >= _IS_FLAT)
    if style is BoxStyle:
        return BoxStyle(relief=relief)
    return PictureStyle(
        relief=relief,
        sidewalks=sidewalks,
        poles=poles,
        omit=omit,
        lobes=lobes,
        error=float(rng.uniform(0.0, _MOST_ERROR)),
        turn=float(rng.uniform(0.0, _MOST_TURN)),
        reach=float(rng.uniform(*_PICTURED_WITHIN)),
        view=float(np.deg2rad(rng.uniform(*_VIEW_DEGREES))),
    )
