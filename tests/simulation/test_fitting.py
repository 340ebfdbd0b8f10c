"""Builders' objects in given boxes."""

import numpy as np
import pytest
from coarse_boxes import box

from lidardraft.objects.kinds import KINDS
from lidardraft.scene.mesh import TriangleMesh, primitive_mesh
from lidardraft.semantics import BY_NAME
from lidardraft.simulation import fitting
from lidardraft.simulation.coarse_object import CoarseObject, UprightBox
from lidardraft.simulation.fitting import _cut_mesh, fitted

TINY, LARGE = (0.01, 0.01, 0.01), (80.0, 60.0, 50.0)


def coarse(label: str, size: tuple[float, float, float]) -> CoarseObject:
    return CoarseObject.of([box(label, size, at=(0, 0, 0))], 0, "it_1")


@pytest.mark.parametrize("kind", [name for name, kind in KINDS.items() if kind.extents])
@pytest.mark.parametrize("which", [0, 1, 2, 3])
def test_every_kind_fits_any_box(kind: str, which: int) -> None:
    size = (*KINDS[kind].extents, TINY, LARGE)[which]
    one = coarse(KINDS[kind].labels[0], size)
    clearance = 0.6 * size[2] if kind in ("house", "tree", "sign", "traffic_light") else 0.0
    parts = fitted(one, kind, UprightBox(0, 0, 0, 0.0, size), clearance=clearance, proud=(0.1, 0.1, 0.0))
    vertices = np.concatenate([primitive_mesh(part).vertices for part in parts])
    assert (np.abs(vertices[:, :2]) <= np.array(size[:2]) / 2 + 0.1 + 1e-6).all()
    assert vertices[:, 2].min() >= -1e-6
    assert vertices[:, 2].max() <= size[2] + 1e-6
    assert all(part.material is not None and part.label in one.owners for part in parts)
    assert {BY_NAME[part.label].name for part in parts} == {one.label}


def test_a_mesh_is_cut_where_the_ground_is_and_cut_once() -> None:
    square = TriangleMesh(
        np.array([(-0.5, 0, -0.5), (0.5, 0, -0.5), (0.5, 0, 0.5), (-0.5, 0, 0.5)]), np.array([[0, 1, 2], [0, 2, 3]])
    )
    cut = _cut_mesh(square, -0.25)
    assert cut.vertices[:, 2].min() == -0.5
    assert cut.vertices[:, 2].max() == 0.5
    assert _cut_mesh(square, -0.25) is cut
    assert _cut_mesh(square, 0.25) is not cut


def test_a_cut_is_whole_where_another_thread_clears_those_that_are_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    class Cleared(dict):  # as soon as it is written
        def __setitem__(self, key, value):
            super().__setitem__(key, value)
            self.clear()

    monkeypatch.setattr(fitting, "_cuts", Cleared())
    square = TriangleMesh(np.array([(-0.5, 0, -0.5), (0.5, 0, -0.5), (0.5, 0, 0.5)]), np.array([[0, 1, 2]]))
    assert _cut_mesh(square, -0.25).vertices[:, 2].min() == -0.5
