"""The ground of a labelled scan: one height field in the classes road, sidewalk and terrain."""

from __future__ import annotations

import numpy as np
from sklearn.neighbors import KNeighborsRegressor, NearestNeighbors

from lidardraft.drafting.cloud_rules import GROUND_PLANE_DROP, GROUND_PLANE_SIZE
from lidardraft.scene.layout import Primitive
from lidardraft.semantics import BY_NAME, CLASSES, GROUND

CELL = 1.0  # m
GROUND_IDS = tuple(BY_NAME[name].id for name in GROUND)
_BRIDGED = 4.0  # m; as far as this from a cell that was seen, the ground goes on


class HeightField:
    """Median height and most frequent class of the ground points in each cell of a grid.

    `points` [N, 3] and `labels` [N] may hold other classes, which are ignored. Without a ground point it is z = 0.
    """

    def __init__(self, points: np.ndarray, labels: np.ndarray) -> None:
        is_ground = np.isin(labels, GROUND_IDS)
        self.points, labels = points[is_ground], labels[is_ground]
        if not len(self.points):
            self._places, self._heights, self._labels = np.zeros((1, 2)), np.zeros(1), np.full(1, BY_NAME["terrain"].id)
        else:
            self._places, self._heights, self._labels = _cells(self.points, labels)
        neighbours = min(4, len(self._places))
        self._field = KNeighborsRegressor(neighbours, weights="distance").fit(self._places, self._heights)
        self._nearest = NearestNeighbors(n_neighbors=1).fit(self._places)

    def height(self, places: np.ndarray) -> np.ndarray:
        """Height [N] of the ground at x, y [N, 2], also where it was not seen."""
        return np.asarray(self._field.predict(places))

    def primitives(self) -> list[Primitive]:
        """A mesh for each class, with the class's name as id, and the plane "ground" below all of them."""
        surfaces = self._surfaces() if len(self.points) else []
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
