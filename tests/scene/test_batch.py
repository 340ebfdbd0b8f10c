import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import layouts, poses, sensors

from lidardraft.errors import LayoutError, SensorError
from lidardraft.scene.batch import RangeImageBatch
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.range_image import IMAGES
from lidardraft.scene.raycast import Raycaster
from lidardraft.scene.sensor import Sensor

SMALL = Sensor(name="small", elevations=(0.2, 0.1, 0.0, -0.1), columns=16)
OPTIONS = {"primitive": True, "incidence": True, "normal": True}


@settings(max_examples=25, deadline=None)
@given(layouts(), sensors(), st.lists(poses(), max_size=4))
def test_a_batch_is_its_scans_bit_for_bit(layout, sensor, several):
    caster = Raycaster(layout)
    batch = caster.scan_batch(sensor, np.array(several).reshape(-1, 4, 4), **OPTIONS)
    assert len(batch) == len(several)
    for image, pose in zip(batch, several, strict=True):
        alone = caster.scan(sensor, pose, **OPTIONS)
        for name in set(IMAGES) - {"intensity"}:
            np.testing.assert_array_equal(getattr(image, name), getattr(alone, name), err_msg=name)


def test_a_batch_of_rolling_scans_is_its_scans():
    caster = Raycaster(Layout((Primitive(shape="plane", center=(0, 0, 0), size=(99, 99, 0), label="road", id="road"),)))
    several = np.stack([SMALL.poses_in_motion(velocity=(0, 0, v)) for v in (1.0, 2.0)])
    assert several.shape == (2, SMALL.columns, 4, 4)
    batch = caster.scan_batch(SMALL, several)
    assert batch[0].depth[-1, 0] != batch[1].depth[-1, 0] > 0
    np.testing.assert_array_equal(batch[1].depth, caster.scan(SMALL, poses=several[1]).depth)
    np.testing.assert_array_equal(caster.scan_batch(SMALL, several.tolist()).depth, batch.depth)
    with pytest.raises(LayoutError, match=r"poses is \[\[1\], \[1, 2\]\]; it must be numbers \[N, 4, 4\]"):
        caster.scan_batch(SMALL, [[1], [1, 2]])


def test_images_of_a_batch_are_views():
    batch = RangeImageBatch.empty(SMALL, 3, normal=True)
    image = batch[-1]
    assert image.sensor is SMALL
    for name in ("depth", "label", "instance", "normal"):
        assert np.shares_memory(getattr(image, name), getattr(batch, name)[2])
    assert image.intensity is None
    assert image.primitive is None
    assert dataclasses.replace(image).depth is image.depth


def test_no_poses_make_an_empty_batch():
    batch = Raycaster(Layout()).scan_batch(SMALL, np.zeros((0, 4, 4)), **OPTIONS)
    assert len(batch) == 0
    assert batch.depth.shape == (0, 4, 16)
    assert list(batch) == []


def test_images_that_are_not_in_the_batch():
    batch = RangeImageBatch.empty(SMALL, 3)
    with pytest.raises(IndexError, match="3"):
        batch[3]
    with pytest.raises(TypeError, match="integer"):
        batch["first"]  # type: ignore[index]
    with pytest.raises(SensorError, match="count is -1; it must be 0 or more"):
        RangeImageBatch.empty(SMALL, -1)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"depth": np.zeros((4, 16), np.float32)}, r"depth has shape \(4, 16\); a batch of small needs \[N, H, W\]"),
        ({"label": np.zeros((2, 4, 16), np.uint8)}, r"label is uint8 \(2, 4, 16\); small needs uint8 \(3, 4, 16\)"),
        ({"instance": np.zeros((3, 4, 16), np.int32)}, r"instance is int32 .* needs uint32"),
        ({"normal": np.zeros((3, 4, 16), np.float32)}, r"normal is float32 .* needs float32 \(3, 4, 16, 3\)"),
        ({"depth": np.full((3, 4, 16), np.nan, np.float32)}, "depth holds what is no distance"),
        ({"label": np.full((3, 4, 16), 99, np.uint8)}, "label holds 99; class ids are 0 to 20"),
    ],
)
def test_arrays_that_are_no_batch(change, message):
    with pytest.raises(SensorError, match=message):
        dataclasses.replace(RangeImageBatch.empty(SMALL, 3), **change)


@pytest.mark.parametrize("rolling", [False, True])
def test_a_batch_of_fewer_scans_than_threads_is_its_scans(rolling):
    tree = Primitive(shape="ellipsoid", center=(9, 3, 3), size=(5, 5, 5), label="vegetation", id="tree", extinction=0.7)
    road = Primitive(shape="plane", center=(0, 0, 0), size=(99, 99, 0), label="road", id="road")
    caster, sensor = Raycaster(Layout((road, tree))), Sensor.preset("hdl64e")
    several = np.stack([sensor.pose(x=float(x)) for x in range(3)])
    if rolling:
        several = np.stack([sensor.poses_in_motion(pose, velocity=(9, 0, 0)) for pose in several])
    batch = caster.scan_batch(sensor, several, threads=8, seed=5, **OPTIONS)
    for number, pose in enumerate(several):
        alone = caster.scan(sensor, threads=1, seed=5 + number, **{"poses" if rolling else "pose": pose}, **OPTIONS)
        for name in set(IMAGES) - {"intensity"}:
            np.testing.assert_array_equal(getattr(batch[number], name), getattr(alone, name), err_msg=name)
