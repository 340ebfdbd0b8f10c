"""Every way the core can cast a scan, forced, against the plain one; and any number of threads against one."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from strategies import layouts, poses, sensors

from lidardraft import _core
from lidardraft.scene.layout import Layout
from lidardraft.scene.range_image import blank_images
from lidardraft.scene.raycast import Raycaster
from lidardraft.scene.sensor import Sensor

FAST = [name for name in _core.backends() if name != "reference"]
SENSOR = Sensor(name="around", elevations=tuple(np.linspace(1.5, -1.5, 48)), columns=96, min_range=0.0)


def scanned(layout: Layout, sensor: Sensor, world_from_sensor: np.ndarray, **how: Any) -> dict[str, np.ndarray]:
    """All images [N, H, W] of one call of the core, written over what is none."""
    shape = (len(world_from_sensor), *sensor.shape)
    images = blank_images(shape, primitive=True, incidence=True, normal=True)
    for image in images.values():
        image.fill(77)
    Raycaster(layout)._scene.scan(sensor.pattern, world_from_sensor, **images, **how)
    return images


def assert_agree(found: dict[str, np.ndarray], expected: dict[str, np.ndarray]) -> None:
    """The same on every ray, distances within 2 mm and 1e-5 of the range."""
    for name in ("label", "instance", "primitive"):
        np.testing.assert_array_equal(found[name], expected[name], err_msg=name)
    np.testing.assert_array_equal(found["depth"] > 0, expected["depth"] > 0)
    np.testing.assert_allclose(found["depth"], expected["depth"], rtol=1e-5, atol=2e-3)


def test_the_reference_is_always_there_and_the_slowest():
    assert _core.backends()[-1] == "reference"
    assert set(_core.backends()) <= {"avx512", "avx2", "portable", "reference"}
    with pytest.raises((TypeError, ValueError), match="abacus"):
        scanned(Layout(), SENSOR, np.eye(4)[None, None], backend="abacus")


@pytest.mark.parametrize("backend", FAST)
@settings(max_examples=60, deadline=None)
@given(layouts(), sensors(), poses())
def test_backends_see_what_the_reference_sees(backend, layout, sensor, pose):
    expected = scanned(layout, sensor, pose[None, None], backend="reference")
    assert_agree(scanned(layout, sensor, pose[None, None], backend=backend), expected)


@pytest.mark.parametrize("backend", _core.backends())
@settings(max_examples=8, deadline=None)
@given(layouts(), sensors(), poses(), poses())
def test_threads_change_no_bit(backend, layout, sensor, first, last):
    rolling = np.stack([np.tile(pose, (sensor.columns, 1, 1)) for pose in (first, last, first)])
    for several in (first[None, None], np.stack([first, last, first])[:, None], rolling):
        one = scanned(layout, sensor, several, threads=1, backend=backend)
        for threads in (2, 3, 5):
            more = scanned(layout, sensor, several, threads=threads, backend=backend)
            for name, image in one.items():
                np.testing.assert_array_equal(more[name].view(np.uint8), image.view(np.uint8), err_msg=name)
