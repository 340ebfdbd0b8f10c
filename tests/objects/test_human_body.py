"""Limbs and torsos: closed, and joints that keep the lengths of their segments."""

import numpy as np
import pytest
from built_objects import is_closed

from lidardraft.objects.human_body import SEGMENTS, bent_joint, hanging, limb, torso
from lidardraft.scene.mesh import TriangleMesh


@pytest.mark.parametrize("coat", [False, True])
def test_torsos_and_limbs_are_closed(coat: bool):
    for vertices, faces in (
        torso(np.zeros(3), 0.04, coat=coat),
        limb(np.array([(0.0, 0.0, 0.5), (0.1, 0.0, 0.25), (0.0, 0.0, 0.0)]), SEGMENTS.leg_diameters),
    ):
        assert is_closed(TriangleMesh(vertices / 2, faces))


def test_legs_and_torso_add_up_to_the_shoulder():
    assert SEGMENTS.ankle + SEGMENTS.thigh + SEGMENTS.shank == pytest.approx(SEGMENTS.hip)
    assert SEGMENTS.hip + SEGMENTS.torso == pytest.approx(0.818)


@pytest.mark.parametrize("knee", [True, False])
def test_a_joint_keeps_the_lengths_of_its_segments(knee: bool):
    rng = np.random.default_rng(0)
    for _ in range(50):
        start = rng.uniform(-1, 1, 3)
        end = start + rng.uniform(0.2, 0.45) * hanging(rng.uniform(-1.0, 1.0))
        joint = bent_joint(start, end, 0.25, 0.24, knee=knee)
        assert np.linalg.norm(joint - start) == pytest.approx(0.25)
        assert np.linalg.norm(joint - end) == pytest.approx(0.24)
        off = joint - (start + end) / 2
        assert off[0] > 0 if knee else off[2] < 0
