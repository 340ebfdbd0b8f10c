"""Templates: triangles in shares of an object, kept in the unit box."""

import numpy as np
import pytest

from lidardraft.objects.mesh import box, quads
from lidardraft.objects.mesh_template import MeshTemplate


def test_a_template_gives_its_triangles_back():
    vertices, faces = box((0.2, -0.1, 0.7), (0.4, 0.6, 0.2))
    template = MeshTemplate.from_triangles(vertices, faces)
    assert template.center == pytest.approx((0.2, -0.1, 0.7))
    assert template.size == pytest.approx((0.4, 0.6, 0.2))
    assert np.abs(template.mesh.vertices).max() == pytest.approx(0.5)
    assert template.mesh.vertices * template.size + template.center == pytest.approx(vertices)


def test_a_flat_template_has_no_extent_across_itself():
    plate = np.array([[(0.0, -0.5, 0.0), (0.0, 0.5, 0.0), (0.0, 0.5, 1.0), (0.0, -0.5, 1.0)]])
    template = MeshTemplate.from_triangles(*quads(plate))
    assert template.size == (0.0, 1.0, 1.0)
    assert (template.mesh.vertices[:, 0] == 0.0).all()
