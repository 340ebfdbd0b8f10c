"""The ground of a labelled scan: one height field in the classes road, sidewalk and terrain."""

from __future__ import annotations

import numpy as np
from sklearn.neighbors import KNeighborsRegressor, NearestNeighbors

from lidardraft.drafting.cloud.rays import Rays
from lidardraft.drafting.cloud.rules import GROUND_PLANE_DROP, GROUND_PLANE_SIZE
from lidardraft.scene.layout import Primitive
from lidardraft.semantics import BY_NAME, CLASSES, GROUND

CELL = 1.0  # m
GROUND_IDS = tuple(BY_NAME[name].id for name in GROUND)
_BRIDGED = 4.0  # m; as far as this from a cell that was seen, the ground goes on
_SEEN = 2.0  # m; so near to a cell that was seen, its height is known
_ROUNDS = 2  # of leaving out cells: the next ones may be seen where the first are gone


class HeightField:
    """Median height and most frequent class of the ground points in each cell of a grid.

    The points of `rays` [N] and their `labels` [N] may hold other classes; without a ground point it is z = 0. A cell
    that hides more points than it shows is left out, and the ground goes on there at the height of the cells around:
    what stands on it was called ground.
    """

    def __init__(self, rays: Rays, labels: np.ndarray) -> None:
        is_ground = np.isin(labels, GROUND_IDS)
        self._seen = bool(is_ground.any())
        if not self._seen:
            self._fit(np.zeros((1, 2)), np.zeros(1), np.full(1, BY_NAME["terrain"].id))
            return
        self._fit(*_cells(rays.points[is_ground], labels[is_ground]))
        for _ in range(_ROUNDS):
            kept = self._shows(rays)
            if kept.all() or not kept.any():
                break
            self._fit(self._places[kept], self._heights[kept], self._labels[kept])

    def _fit(self, places: np.ndarray, heights: np.ndarray, labels: np.ndarray) -> None:
        self._places, self._heights, self._labels = places, heights, labels
        self._field = KNeighborsRegressor(min(4, len(places)), weights="distance").fit(places, heights)
        self._nearest = NearestNeighbors(n_neighbors=1).fit(places)

    def _shows(self, rays: Rays) -> np.ndarray:
        """bool [C]: which cells show as many points as they hide, or more."""
        hits = rays.cast(self.primitives(), rays.sample)
        on = hits.primitive > 0  # the plane is the first
        cell = np.full(len(on), len(self._places))
        if on.any():
            cell[on] = self._nearest.kneighbors(rays.ends(hits)[on, :2], return_distance=False)[:, 0]
        hidden, shown = (
            np.bincount(cell[which], minlength=len(self._places) + 1)[:-1]
            for which in (hits.too_near, ~hits.too_near & ~hits.too_far)
        )
        shows: np.ndarray = hidden <= shown
        return shows

    def height(self, places: np.ndarray) -> np.ndarray:
        """Height [N] of the ground at x, y [N, 2], also where it was not seen."""
        return np.asarray(self._field.predict(places))

    def is_known(self, places: np.ndarray) -> np.ndarray:
        """bool [N]: whether ground was seen within 2 m of x, y [N, 2]."""
        known: np.ndarray = self._nearest.kneighbors(places)[0][:, 0] <= _SEEN
        return known & self._seen

    def primitives(self) -> list[Primitive]:
        """A mesh for each class, with the class's name as id, and the plane "ground" below all of them."""
        surfaces = self._surfaces() if self._seen else []
        lowest = min([0.0, *(s.center[2] - s.size[2] / 2 for s in surfaces)])
        center = (0.0, 0.0, lowest - (GROUND_PLANE_DROP if surfaces else 0.0))
        plane = Primitive(
            shape="plane", center=center, size=(GROUND_PLANE_SIZE, GROUND_PLANE_SIZE, 0.0), label="terrain", id="ground"
        )
        return [plane, *surfaces]

    def _surfaces(self) -> list[Primitive]:
        low = np.floor((self._places.min(axis=0) - _BRIDGED) / CELL).astype(int)
        high = np.ceil((self._places.max(axis=0) + _BRIDGED) / CELL).astype(int)
        x, y = np.meshgrid(np.arange(low[0], high[0]), np.arange(low[1], high[1]), indexing="ij")
        cells = np.column_stack([x.ravel(), y.ravel()])
        distance, nearest = self._nearest.kneighbors((cells + 0.5) * CELL)
        near = distance[:, 0] <= _BRIDGED
        cells, labels = cells[near], self._labels[nearest[near, 0]]
        return [self._surface(cells[labels == label], CLASSES[label].name) for label in np.unique(labels)]

    def _surface(self, cells: np.ndarray, name: str) -> Primitive:
        """Two triangles a cell; a corner's height depends on its place only, so that neighbours meet without a gap."""
        corners = cells[:, None, :] + np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
        places, index = np.unique(corners.reshape(-1, 2), axis=0, return_inverse=True)
        quads = index.reshape(-1, 4)
        vertices = np.column_stack([places * CELL, self.height(places * CELL)])
        faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
        return Primitive.from_mesh(vertices, faces, label=name, id=name)


def _cells(points: np.ndarray, labels: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mean place [C, 2], median height [C] and most frequent label [C] of the cells with a point."""
    cells, cell = np.unique(np.floor(points[:, :2] / CELL).astype(int), axis=0, return_inverse=True)
    cell = cell.reshape(-1)
    count = np.bincount(cell)
    places = np.column_stack([np.bincount(cell, weights=points[:, axis]) / count for axis in (0, 1)])
    order = np.lexsort((points[:, 2], cell))
    first = np.concatenate([[0], np.cumsum(count)[:-1]])
    heights = points[order[first + count // 2], 2]
    votes = np.stack([np.bincount(cell[labels == label], minlength=len(cells)) for label in GROUND_IDS])
    return places, heights, np.array(GROUND_IDS)[votes.argmax(axis=0)]
