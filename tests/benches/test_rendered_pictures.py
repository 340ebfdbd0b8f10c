import math

import numpy as np
import pytest

from lidardraft import Layout, Primitive
from lidardraft.drafting.picture.camera import Pinhole
from lidardraft.semantics import BY_NAME
from rendered_pictures import SKY, as_networks_give_it, render

CAMERA = Pinhole(fx=100, fy=100, cx=50, cy=30, width=101, height=61)
WALL = Primitive(shape="box", center=(11, 0, 5), size=(2, 40, 20), label="wall", id="wall")
ROAD = Primitive(shape="plane", center=(0, 0, 0), size=(100, 100, 0), label="road", id="road")


def test_depth_is_that_along_the_axis():
    picture = render(Layout((WALL,)), CAMERA, height=2.0)
    np.testing.assert_allclose(picture.depth, 10, atol=1e-4)
    assert (picture.labels == BY_NAME["wall"].id).all()


@pytest.mark.parametrize("pitch", [0.0, 0.2])
def test_the_horizon_is_where_the_camera_looks_level(pitch):
    picture = render(Layout((ROAD,)), CAMERA, height=2.0, pitch=pitch)
    rows = np.flatnonzero(picture.labels[:, 50] > 0)
    assert rows[0] == pytest.approx(30 - 100 * math.tan(pitch) + 100 * 2 / 50, abs=2)
    assert picture.pixels[0, 50].tolist() == list(SKY)
    down = pitch + math.atan((60 - 30) / 100)
    assert picture.depth[60, 50] == pytest.approx(2 / math.sin(down) * math.cos(down - pitch), rel=1e-5)


def test_a_rolled_camera_sees_the_right_lower():
    """Rolled clockwise, as seen from behind, the ground on the right rises in the picture."""
    picture = render(Layout((ROAD,)), CAMERA, height=2.0, roll=0.2)
    left, right = (np.flatnonzero(picture.labels[:, column])[0] for column in (5, 95))
    assert right != left


def test_errors_of_networks_are_of_the_size_that_is_said():
    picture = render(Layout((ROAD, WALL)))
    wrong = as_networks_give_it(picture, 0)
    ratio = wrong.depth / picture.depth
    assert np.mean(ratio) == pytest.approx(1.12, rel=0.02)
    assert np.std(ratio) == pytest.approx(0.03 * 1.12, rel=0.2)
    assert not np.array_equal(wrong.depth, as_networks_give_it(picture, 1).depth)
