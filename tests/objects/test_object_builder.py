"""The builder: parts in the object's frame become primitives at its place."""

import math
from dataclasses import replace

import numpy as np
import pytest
from built_objects import placed, vertices

from lidardraft.objects.mesh import box
from lidardraft.objects.mesh_template import MeshTemplate
from lidardraft.objects.object_builder import ObjectBuilder

MADE = placed("bin", yaw=math.pi / 2, at=(10.0, 20.0, 0.5))
# a box from (0.1, 0, 0) to (0.5, 0.2, 0.4), in shares
TEMPLATE = MeshTemplate.from_triangles(*box((0.3, 0.1, 0.2), (0.4, 0.2, 0.4)))


def test_places_are_turned_and_moved():
    builder = ObjectBuilder(MADE)
    builder.add("box", (1.0, 2.0, 3.0), (0.1, 0.2, 0.3), "other", "metal", yaw=0.25)
    (made,) = builder.primitives
    assert made.center == pytest.approx((8.0, 21.0, 3.5))
    assert made.yaw == pytest.approx(math.pi / 2 + 0.25)
    assert (made.label, made.material, made.instance) == ("other", "metal", 0)


def test_ids_begin_with_that_of_the_object_and_differ():
    builder = ObjectBuilder(MADE)
    for _ in range(3):
        builder.add("box", (0.0, 0.0, 0.5), (1.0, 1.0, 1.0), "other")
    assert [p.id for p in builder.primitives] == ["bin_1", "bin_1.1", "bin_1.2"]


def test_a_template_is_stretched_and_turned_round():
    builder = ObjectBuilder(placed("bin"))
    builder.add_mesh(TEMPLATE, (10.0, 5.0, 2.0), "other", at=(1.0, 0.0, 0.5))
    builder.add_mesh(TEMPLATE, (10.0, 5.0, 2.0), "other", at=(1.0, 0.0, 0.5), backward=True)
    ahead, back = (vertices(p) for p in builder.primitives)
    assert (ahead.min(axis=0), ahead.max(axis=0)) == (
        pytest.approx(np.array([2.0, 0.0, 0.5])),
        pytest.approx(np.array([6.0, 1.0, 1.3])),
    )
    assert (back.min(axis=0), back.max(axis=0)) == (
        pytest.approx(np.array([-4.0, -1.0, 0.5])),
        pytest.approx(np.array([0.0, 0.0, 1.3])),
    )


@pytest.mark.parametrize(("instance", "expected"), [(7, [7, 8]), (0, [0, 0])])
def test_what_is_ridden_is_the_next_instance(instance: int, expected: list[int]):
    builder = ObjectBuilder(replace(MADE, instance=instance))
    builder.add("box", (0.0, 0.0, 0.5), (1.0, 1.0, 1.0), "rider")
    builder.next_instance()
    builder.add("box", (0.0, 0.0, 0.5), (1.0, 1.0, 1.0), "bicycle")
    assert [p.instance for p in builder.primitives] == expected
