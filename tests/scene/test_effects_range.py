"""Noise and offsets of ranges against closed forms."""

import math
from dataclasses import replace

import numpy as np
import pytest
from observed_walls import IDEAL, SENSOR, seen, wall

from lidardraft import Layout, Primitive, raycast
from lidardraft.errors import SensorError


def test_range_noise_grows_as_power_falls():
    model = replace(IDEAL, jitter=0.1, detection_threshold=1e-5)
    noisy = replace(SENSOR, range_sigma=0.02)
    for distance, material in ((5.0, "plaster"), (50.0, "plaster"), (50.0, "rubber")):
        scan = seen(wall(distance, material), model, sensor=noisy)
        share = {"plaster": 0.45, "rubber": 0.03}[material]
        power = share / distance**2 / 1e-5
        clean = raycast(wall(distance, material), noisy).depth
        spread = (scan.depth - clean)[scan.valid].std()
        assert spread == pytest.approx(math.hypot(0.02, 0.1 / math.sqrt(power)), rel=0.05)


def test_a_rough_surface_scatters_ranges_by_its_heights():
    model = replace(IDEAL, material_noise=True)
    flat = Layout((Primitive(shape="plane", center=(0, 0, -2), size=(200, 200, 0), label="terrain", id="lawn"),))
    steep = replace(SENSOR, elevations=(-0.8, -0.9, -1.0, -1.1))
    for layout, sensor, cosine in (
        (wall(9.0, "grass"), SENSOR, np.ones(4)),
        (flat, steep, np.sin([0.8, 0.9, 1.0, 1.1])),
    ):
        moved = seen(layout, model, sensor=sensor).depth - raycast(layout, sensor).depth
        np.testing.assert_allclose(moved.std(axis=1), 0.008 / cosine, rtol=0.12)
    smooth = seen(wall(9.0, "plaster"), model).depth
    np.testing.assert_array_equal(smooth, raycast(wall(9.0), SENSOR).depth)


def test_ranges_are_rounded_and_never_leave_the_limits():
    coarse = seen(wall(12.0), replace(IDEAL, range_step=0.25)).depth
    np.testing.assert_allclose(np.unique(coarse), [12.0])
    near = replace(SENSOR, range_sigma=0.3, min_range=0.5)
    assert seen(wall(0.52), IDEAL, sensor=near).depth.min() >= np.float32(0.5)


def test_each_beam_of_a_unit_has_an_offset_and_a_gain_of_its_own():
    model = replace(IDEAL, offset_spread=0.05, gain_spread=0.3)
    clean = raycast(wall(10.0), SENSOR).depth
    one, again, other = (seen(wall(10.0), replace(model, unit=u), seed=s) for u, s in ((3, 0), (3, 1), (4, 0)))
    np.testing.assert_array_equal(one.depth, again.depth)
    np.testing.assert_allclose((one.depth - clean).std(axis=1), 0.0, atol=1e-5)
    assert len(np.unique((one.depth - clean)[:, 0])) == 4
    assert len(np.unique(one.intensity)) == 4
    assert (one.depth != other.depth).all()


def test_a_known_offset_is_in_every_range_of_its_beam():
    layout, offsets = wall(12.0), (0.05, 0.0, -0.02, 0.0)
    off = seen(layout, replace(IDEAL, range_offsets=offsets)).depth - seen(layout, IDEAL).depth
    np.testing.assert_allclose(off, np.broadcast_to(np.array(offsets)[:, None], off.shape), atol=1e-5)
    # a model alone does not know how many beams there are
    with pytest.raises(SensorError, match="range_offsets has 3 values; it needs one for each of 4 beams"):
        seen(layout, replace(IDEAL, range_offsets=offsets[:3]))
