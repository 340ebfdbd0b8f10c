"""The drawings of a street: the layouts that a sentence, a clustering, a picture or an annotator would have made of it.

All shapes are solid; what is porous in the detailed scene is drawn as the solid that a sentence or a clustering makes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lidardraft.errors import LayoutError
from lidardraft.objects.coarse_shapes import CoarseShape
from lidardraft.objects.kinds import kind_of
from lidardraft.objects.placed_object import PlacedObject
from lidardraft.scene.layout import SHAPES, Layout, object_of
from lidardraft.scene.road import Road
from lidardraft.scene.shape_table import ShapeTable
from lidardraft.semantics import BY_NAME, CLASSES, GROUND, NUM_CLASSES
from lidardraft.streets.coarse.as_clusters import clusters
from lidardraft.streets.coarse.as_text import as_text
from lidardraft.streets.coarse.ground_mesh import GroundMesh
from lidardraft.streets.coarse.style import ALWAYS_NAMED, FAMILIES, Style
from lidardraft.streets.coarse.visible import VisibleObjects, owners_of

_SEEN = 5  # returns that a thing needs to be noticed in a picture
_RIDER = BY_NAME["rider"].id
_FAMILIES = tuple(FAMILIES)
# The number of a word's family; the last one, -1, is what is always named, and what no sentence speaks of.
_FAMILY_OF: dict[str | None, int] = {
    **{word: number for number, (_, words) in enumerate(FAMILIES.values()) for word in words},
    **dict.fromkeys((*ALWAYS_NAMED, None), -1),
}


@dataclass(frozen=True, slots=True, eq=False)
class _ShapeColumns:
    """Outlines as columns: the thing [M] each shape belongs to, its place there, and the yaw and place of the thing."""

    owners: np.ndarray
    shapes: np.ndarray
    centers: np.ndarray
    sizes: np.ndarray
    labels: np.ndarray
    instances: np.ndarray
    lobes: np.ndarray
    places: np.ndarray
    ids: np.ndarray

    @classmethod
    def from_rows(
        cls, objects: Sequence[PlacedObject], rows: list[tuple[int, CoarseShape, tuple[float, float, float]]]
    ) -> _ShapeColumns:
        number: dict[tuple[int, int], int] = {}
        ids = []
        for index, mark, _ in rows:
            # the crowns of one thing have the same ids whatever the number of their lobes
            key = (index, mark.lobes)
            number[key] = number.get(key, number.get((index, 0), 0) if mark.lobes else 0) + 1
            ids.append(f"{objects[index].id}.{number[key] - 1}" if number[key] > 1 else objects[index].id)
        marks = [mark for _, mark, _ in rows]
        instances = [objects[i].instance + mark.instance_offset if objects[i].instance else 0 for i, mark, _ in rows]
        return cls(
            owners=np.array([index for index, _, _ in rows], dtype=np.int64),
            shapes=np.array([SHAPES.index(mark.shape) for mark in marks], dtype=np.uint8),
            centers=np.array([mark.center for mark in marks], dtype=float).reshape(-1, 3),
            sizes=np.array([mark.size for mark in marks], dtype=float).reshape(-1, 3),
            labels=np.array([BY_NAME[mark.label].id for mark in marks], dtype=np.uint8),
            instances=np.array(instances, dtype=np.uint32),
            lobes=np.array([mark.lobes for mark in marks], dtype=np.int64),
            places=np.array([place for _, _, place in rows], dtype=float).reshape(-1, 3),
            ids=np.array(ids, dtype=object),
        )


class CoarseStreet:
    """What all drawings of one street have in common: its ground and the outlines of its things, as columns.

    `scene` is the detailed scene of the `things` along `road`, `middles` are those of the lanes across the road [m].
    Everything is in the frame of the road.
    """

    def __init__(self, road: Road, objects: Sequence[PlacedObject], scene: Layout, middles: Sequence[float]) -> None:
        self.objects = tuple(objects)
        self.owners = owners_of(scene, self.objects)
        names = {placed.id for placed in self.objects}
        self._flat = ShapeTable.from_primitives(road.surfaces())
        self._patches = GroundMesh(road, [p for p in scene if p.label in GROUND and object_of(p) not in names])
        kinds = [kind_of(t.kind) for t in self.objects]
        exact = [
            (i, shape, (t.x, t.y, t.yaw))
            for i, (t, kind) in enumerate(zip(self.objects, kinds, strict=True))
            for shape in kind.coarse(t)
        ]
        self._exact = _ShapeColumns.from_rows(self.objects, exact)
        self._spoken = _ShapeColumns.from_rows(self.objects, as_text(self.objects, road, middles))
        self._places = np.array([(t.x, t.y, t.yaw) for t in self.objects], dtype=float).reshape(-1, 3)
        self._levels = np.array([t.level for t in self.objects], dtype=float)
        self._grounds = np.array([t.z for t in self.objects], dtype=float)
        self._instances = np.array([t.instance for t in self.objects], dtype=np.uint32)
        self._ridden = np.array([kind.instances > 1 for kind in kinds], dtype=bool)
        self._small = np.array([kind.is_small for kind in kinds], dtype=bool)
        self._posts = np.array([kind.on_post for kind in kinds], dtype=bool)
        self._families = np.array([_FAMILY_OF[kind.word] for kind in kinds], dtype=np.int64)
        post = self._exact.shapes == SHAPES.index("cylinder")
        self._girths = np.full(len(self.objects), 0.1)
        self._girths[self._exact.owners[post]] = self._exact.sizes[post, 0]

    def whole(self) -> Layout:
        """Everything as it is, on flat ground, in the frame of the road."""
        style = Style(source="boxes")
        return self.draw(style, np.random.default_rng(0), np.eye(4)).layout({"source": style.source})

    def draw(
        self, style: Style, rng: np.random.Generator, pose: np.ndarray, visible: VisibleObjects | None = None
    ) -> ShapeTable:
        """The drawing in that style, in the frame of the ego vehicle, which is fixed to the road under it.

        `pose` is street_from_ego [4, 4]. A flat drawing has the plane of the road there as its ground everywhere. A
        "cloud" and a "picture" draw what was seen, and raise `LayoutError` without a `sighting`.
        """
        place = place_of(pose)
        flat = style.ground == "flat"
        heights = self._levels if flat else self._over(pose)
        ground = (self._flat if flat else self._patches.around(pose)).seen_from(*place)
        if not style.sidewalks:
            ground = ground.select(ground.labels != BY_NAME["sidewalk"].id)
        if style.source == "text":
            return ShapeTable.join(
                ground, self._placed_shapes(self._spoken, self._said(style, place), style, place, heights)
            )
        if style.source == "boxes":
            everything = np.ones(len(self.objects), dtype=bool)
            return ShapeTable.join(ground, self._placed_shapes(self._exact, everything, style, place, heights))
        if visible is None:
            raise LayoutError(f"a drawing of source {style.source!r} needs a sighting; it draws what was seen")
        if style.source == "cloud":
            return ShapeTable.join(ground, self._clustered(style, rng, visible, self._over(pose)))
        shown, wrong = self._pictured(style, rng, visible), self._misjudged(style, rng, place)
        return ShapeTable.join(ground, self._placed_shapes(self._exact, shown, style, place, heights, wrong))

    def _over(self, pose: np.ndarray) -> np.ndarray:
        """Heights [T] of the ground under the things over the plane of the road under the ego vehicle [m]."""
        heights: np.ndarray = (np.column_stack([self._places[:, :2], self._grounds]) - pose[:3, 3]) @ pose[:3, 2]
        return heights

    def _said(self, style: Style, place: tuple[float, float, float]) -> np.ndarray:
        """Which things [T] a sentence names: vehicles and its families, as far as it reaches."""
        named = np.array([family in style.named for family in _FAMILIES] + [True])
        near = np.hypot(*(self._places[:, :2] - place[:2]).T) <= style.reach
        return named[self._families] & near & (style.posts | ~self._posts)

    def _pictured(self, style: Style, rng: np.random.Generator, visible: VisibleObjects) -> np.ndarray:
        """Which things [T] are in a picture."""
        x, y, yaw = visible.place
        ahead = self._places[:, :2] - (x, y)
        bearing = np.arctan2(ahead[:, 1], ahead[:, 0]) - yaw
        inside = np.cos(bearing) >= math.cos(style.view / 2)
        near = np.hypot(ahead[:, 0], ahead[:, 1]) <= style.reach
        omitted = self._small & (rng.random(len(self.objects)) < style.omit)
        return inside & near & (visible.returns.sum(axis=1) >= _SEEN) & (style.posts | ~self._posts) & ~omitted

    def _misjudged(
        self, style: Style, rng: np.random.Generator, place: tuple[float, float, float]
    ) -> tuple[np.ndarray, np.ndarray]:
        """How far off the places [T, 3] (x, y, yaw) are, further along the line of sight, and the scales [T, 3]."""
        count = len(self.objects)
        sight = self._places[:, :2] - place[:2]
        off = np.column_stack([sight * rng.normal(0.0, style.error, (count, 1)), rng.normal(0.0, style.turn, count)])
        return off, np.exp(rng.normal(0.0, style.error, (count, 3)))

    def _placed_shapes(
        self,
        marks: _ShapeColumns,
        objects: np.ndarray,
        style: Style,
        place: tuple[float, float, float],
        heights: np.ndarray,
        wrong: tuple[np.ndarray, np.ndarray] | None = None,
    ) -> ShapeTable:
        """The marks of the chosen things [T] on ground of these heights [T], in the frame of the ego vehicle."""
        kept = np.flatnonzero(objects[marks.owners] & ((marks.lobes == 0) | (marks.lobes == style.lobes)))
        owners = marks.owners[kept]
        centers, sizes, places = marks.centers[kept], marks.sizes[kept], marks.places[kept]
        if wrong is not None:
            off, scale = wrong
            places = places + off[owners]
            centers, sizes = centers * scale[owners], sizes * scale[owners]
        cos, sin = np.cos(places[:, 2]), np.sin(places[:, 2])
        x = places[:, 0] + cos * centers[:, 0] - sin * centers[:, 1]
        y = places[:, 1] + sin * centers[:, 0] + cos * centers[:, 1]
        return ShapeTable(
            shapes=marks.shapes[kept],
            centers=np.column_stack([x, y, heights[owners] + centers[:, 2]]),
            sizes=sizes,
            yaws=places[:, 2],
            labels=marks.labels[kept],
            instances=marks.instances[kept],
            ids=tuple(marks.ids[kept].tolist()),
        ).seen_from(*place)

    def _clustered(
        self, style: Style, rng: np.random.Generator, visible: VisibleObjects, heights: np.ndarray
    ) -> ShapeTable:
        yaws = self._places[:, 2] - visible.place[2]
        found = clusters(visible, yaws, heights, self._girths, rng, numbered=style.numbered)
        order = np.argsort(found.keys % NUM_CLASSES, kind="stable")
        labels, owners = found.keys[order] % NUM_CLASSES, found.keys[order] // NUM_CLASSES
        rank = self._ridden[owners] & (labels != _RIDER)
        placed = np.array([row.is_thing for row in CLASSES])[labels]
        number = np.arange(len(labels)) - np.searchsorted(labels, labels)
        return ShapeTable(
            shapes=found.shapes[order],
            centers=found.centers[:, order].T,
            sizes=found.sizes[:, order].T,
            yaws=found.yaws[order],
            labels=labels,
            instances=np.where(placed, self._instances[owners] + rank, 0),
            ids=tuple(f"{CLASSES[k].name}_{n + 1}" for k, n in zip(labels.tolist(), number.tolist(), strict=True)),
        )


def place_of(pose: np.ndarray) -> tuple[float, float, float]:
    """x, y [m] and yaw [rad] of a pose [4, 4]."""
    return float(pose[0, 3]), float(pose[1, 3]), math.atan2(pose[1, 0], pose[0, 0])
