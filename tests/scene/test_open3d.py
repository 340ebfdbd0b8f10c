"""The scenes of the benchmarks, as Open3D's ray caster (Embree, one ray at a time) sees them."""

import warnings

import numpy as np
import pytest

from compare import agreement
from lidardraft import Raycaster
from peers import Open3d, layout_of, sensor_of
from scenes import SCENES, hdl64, pose

with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # its own dependencies' warnings are not ours
    pytest.importorskip("open3d", reason="Open3D is not installed: pip install -e '.[bench]'", exc_type=ImportError)


@pytest.mark.parametrize(("name", "triangles"), [*((name, True) for name in SCENES), ("small", False)])
def test_shapes_agree_on_every_ray(name: str, triangles: bool) -> None:
    scene, pattern = SCENES[name](), hdl64()
    rival = Open3d(1)
    rival.build(scene)
    rival.prepare(pattern)
    caster, sensor = Raycaster(layout_of(scene, triangles=triangles)), sensor_of(pattern)
    for step in range(4):
        expected = rival.scan(pose(step))
        image = caster.scan(sensor, pose(step), primitive=True)
        assert image.primitive is not None
        near, same = agreement(expected, (image.depth, image.label, image.primitive))
        assert near >= 0.9999
        assert same >= 0.9999
        if not triangles:  # whose edges are a little elsewhere
            continue
        np.testing.assert_array_equal(image.depth > 0, expected[0] > 0)
        hit = image.primitive == expected[2]
        np.testing.assert_array_equal(image.label[hit], expected[1][hit])
