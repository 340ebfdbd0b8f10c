"""The ground of a labelled scan as primitives: one height field in the classes road, sidewalk and terrain."""

from __future__ import annotations

import numpy as np

from lidardraft import _core
from lidardraft.drafting.cloud.rules import GROUND_PLANE_DROP, GROUND_PLANE_SIZE
from lidardraft.scene.layout import Primitive
from lidardraft.semantics import BY_NAME, CLASSES, GROUND

GROUND_IDS = tuple(BY_NAME[name].id for name in GROUND)


def surfaces(ground: _core.HeightField) -> list[Primitive]:
    """A mesh for each class, with the class's name as id, and the plane "ground" below all of them.

    Two triangles a cell of 1 m; a corner's height depends on its place only, so that neighbours meet without a gap.
    """
    low, corners, labels = ground.grid()
    found = []
    for label in np.unique(labels[labels > 0]).tolist():
        x, y = np.nonzero(labels == label)
        quads = np.stack([x, x + 1, x + 1, x]) * corners.shape[1] + np.stack([y, y, y + 1, y + 1])
        used = np.zeros(corners.size, dtype=bool)
        used[quads] = True
        places = np.column_stack(np.unravel_index(np.flatnonzero(used), corners.shape)) + np.array(low)
        quads = (np.cumsum(used) - 1)[quads.T]
        faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
        vertices = np.column_stack([places, corners.ravel()[used]])
        name = CLASSES[label].name
        found.append(Primitive.from_mesh(vertices, faces, label=name, id=name))
    lowest = min([0.0, *(surface.center[2] - surface.size[2] / 2 for surface in found)])
    center = (0.0, 0.0, lowest - (GROUND_PLANE_DROP if found else 0.0))
    size = (GROUND_PLANE_SIZE, GROUND_PLANE_SIZE, 0.0)
    return [Primitive(shape="plane", center=center, size=size, label="terrain", id="ground"), *found]
