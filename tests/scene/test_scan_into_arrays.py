"""Scans into arrays that are there already, one or many: the same images, or an error and nothing written."""

import dataclasses

import numpy as np
import pytest

from lidardraft.errors import LayoutError, LidarDraftError, SensorError
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.range_image import RangeImage, RangeImageBatch, images_of
from lidardraft.scene.raycast import Raycaster, raycast
from lidardraft.scene.sensor import Sensor

SENSOR = Sensor(name="small", elevations=tuple(np.linspace(0.2, -0.4, 16)), columns=64, max_range=100.0)
OTHER = dataclasses.replace(SENSOR, columns=32)
ALL = {"primitive": True, "incidence": True, "normal": True}
CASTER = Raycaster(
    Layout(
        (
            Primitive(shape="plane", center=(0, 0, 0), size=(400, 400, 0), label="road", id="road"),
            Primitive(shape="box", center=(10, 0, 0.75), size=(4, 2, 1.5), label="car", id="car", instance=7),
        )
    )
)
POSES = np.stack([SENSOR.pose(0.1 * i, 0.2, 0.3 * i) for i in range(3)])


def assert_same(a: RangeImage | RangeImageBatch, b: RangeImage | RangeImageBatch) -> None:
    assert images_of(a).keys() == images_of(b).keys()
    for name, array in images_of(a).items():
        np.testing.assert_array_equal(array, getattr(b, name), err_msg=name)


@pytest.mark.parametrize("options", [{}, {"incidence": True}, ALL], ids=["three", "four", "all"])
def test_a_scan_into_an_older_image_is_the_scan_in_its_memory(options):
    out = CASTER.scan(SENSOR, POSES[0], **options)
    before = images_of(out)
    again = CASTER.scan(SENSOR, POSES[1], out=out)
    assert again is out
    for name, array in images_of(out).items():
        assert array is before[name]
    assert_same(out, CASTER.scan(SENSOR, POSES[1], **options))
    assert (out.depth != CASTER.scan(SENSOR, POSES[0]).depth).any()


def test_a_scan_has_what_is_asked_for_and_nothing_else():
    assert images_of(CASTER.scan(SENSOR)).keys() == {"depth", "label", "instance"}
    for name in ALL:
        assert images_of(CASTER.scan(SENSOR, **{name: True})).keys() == {"depth", "label", "instance", name}
    assert_same(raycast(CASTER.layout, SENSOR, POSES[1], **ALL), CASTER.scan(SENSOR, POSES[1], **ALL))


def test_an_empty_image_is_one_without_returns_and_takes_a_scan():
    out = RangeImage.empty(SENSOR, **ALL)
    assert not out.valid.any()
    assert (out.primitive == -1).all()
    assert not any(array.any() for name, array in images_of(out).items() if name != "primitive")
    for image in (out, CASTER.scan(SENSOR, POSES[1], out=out), CASTER.scan_batch(SENSOR, POSES, **ALL)):
        assert_same(dataclasses.replace(image), image)  # it passes the checks of an image
    assert_same(out, CASTER.scan(SENSOR, POSES[1], **ALL))


def test_a_batch_writes_into_a_batch():
    out = RangeImageBatch.empty(SENSOR, 3, normal=True)
    before = images_of(out)
    assert CASTER.scan_batch(SENSOR, POSES, out=out) is out
    assert all(array is before[name] for name, array in images_of(out).items())
    assert_same(out, CASTER.scan_batch(SENSOR, POSES, normal=True))


def test_an_image_of_a_batch_can_be_scanned_anew():
    batch = CASTER.scan_batch(SENSOR, POSES)
    CASTER.scan(SENSOR, POSES[0], out=batch[2])
    np.testing.assert_array_equal(batch.depth[2], batch.depth[0])
    assert (batch.depth[1] != batch.depth[0]).any()


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        ({"pose": np.eye(3)}, LayoutError, r"pose has shape \(3, 3\); it must be \[4, 4\]"),
        ({"pose": 2 * np.eye(4)}, LayoutError, "world_from_sensor"),
        ({"pose": "here"}, LayoutError, r"pose is 'here'; it must be numbers \[4, 4\]"),
        ({"poses": POSES}, LayoutError, r"poses has shape \(3, 4, 4\); it must be \[64, 4, 4\]"),
        ({"poses": np.tile(2 * np.eye(4), (64, 1, 1))}, LayoutError, "world_from_sensor"),
        ({"pose": POSES[0], "poses": np.tile(POSES[0], (64, 1, 1))}, LayoutError, "pose and poses are both given"),
        ({"threads": -2}, LidarDraftError, r"threads is -2; it must be 0 \(all cores\) to 1024"),
        ({"threads": 1.5}, TypeError, "integer"),
        ({"sensor": OTHER}, SensorError, "out is of another sensor of that name; the scan is of small"),
        ({"sensor": Sensor.preset("vlp16")}, SensorError, "out is of small; the scan is of vlp16"),
        ({"incidence": True}, SensorError, "out has no incidence, and incidence=True asks for it"),
        ({"normal": True}, SensorError, "out has no normal, and normal=True asks for it"),
    ],
)
def test_calls_that_cannot_be_leave_out_as_it_is(change, error, message):
    out = CASTER.scan(SENSOR, POSES[1], primitive=True)
    before = {name: array.copy() for name, array in images_of(out).items()}
    with pytest.raises(error, match=message):
        CASTER.scan(**{"sensor": SENSOR, "out": out, **change})
    for name, array in before.items():
        np.testing.assert_array_equal(getattr(out, name), array)


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        ({"poses": POSES[:2]}, SensorError, "out holds 3 images; there are 2 poses"),
        ({"poses": POSES[0]}, LayoutError, r"poses has shape \(4, 4\); it must be \[N, 4, 4\]"),
        ({"poses": np.ones((3, 5, 4, 4))}, LayoutError, r"poses has shape \(3, 5, 4, 4\); it must be \[N, 64, 4, 4\]"),
        ({"poses": POSES * [[[1], [1], [2], [1]]]}, LayoutError, "world_from_sensor"),
        ({"sensor": OTHER}, SensorError, "out is of another sensor"),
    ],
)
def test_batches_that_cannot_be_leave_out_as_it_is(change, error, message):
    out = CASTER.scan_batch(SENSOR, POSES[::-1])
    before = {name: array.copy() for name, array in images_of(out).items()}
    with pytest.raises(error, match=message):
        CASTER.scan_batch(**{"sensor": SENSOR, "poses": POSES, "out": out, **change})
    for name, array in before.items():
        np.testing.assert_array_equal(getattr(out, name), array)


def test_out_of_another_kind():
    with pytest.raises(TypeError, match="out is a RangeImageBatch; it must be a RangeImage"):
        CASTER.scan(SENSOR, out=RangeImageBatch.empty(SENSOR, 1))
    with pytest.raises(TypeError, match="out is a RangeImage; it must be a RangeImageBatch"):
        CASTER.scan_batch(SENSOR, POSES, out=RangeImage.empty(SENSOR))
    with pytest.raises(TypeError, match="out is a ndarray; it must be a RangeImage"):
        CASTER.scan(SENSOR, out=np.zeros(SENSOR.shape, np.float32))


def test_an_intensity_would_be_that_of_another_scan():
    out = dataclasses.replace(CASTER.scan(SENSOR), intensity=np.zeros(SENSOR.shape, np.float32))
    with pytest.raises(SensorError, match="out has an intensity"):
        CASTER.scan(SENSOR, out=out)


SMALL = Sensor(name="small", elevations=(0.2, 0.1, 0.0, -0.1), columns=16)


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
        ({"depth": np.zeros((3, 4, 16))}, r"depth is float64 .* needs float32 \(3, 4, 16\)"),
        ({"depth": np.full((3, 4, 16), np.nan, np.float32)}, "depth holds "),
        ({"depth": np.full((3, 4, 16), -1, np.float32)}, "depth holds "),
        ({"label": np.full((3, 4, 16), 99, np.uint8)}, "label holds 99; class ids are 0 to 20"),
    ],
)
def test_arrays_that_are_no_batch(change, message):
    with pytest.raises(SensorError, match=message):
        dataclasses.replace(RangeImageBatch.empty(SMALL, 3, normal=True), **change)


@pytest.mark.parametrize("rolling", [False, True])
def test_a_batch_of_fewer_scans_than_threads_is_its_scans(rolling):
    tree = Primitive(shape="ellipsoid", center=(9, 3, 3), size=(5, 5, 5), label="vegetation", id="tree", extinction=0.7)
    road = Primitive(shape="plane", center=(0, 0, 0), size=(99, 99, 0), label="road", id="road")
    caster, sensor = Raycaster(Layout((road, tree))), Sensor.preset("hdl64e")
    several = np.stack([sensor.pose(x=float(x)) for x in range(3)])
    if rolling:
        several = np.stack([sensor.poses_in_motion(pose, velocity=(9, 0, 0)) for pose in several])
    batch = caster.scan_batch(sensor, several, threads=8, seed=5, **ALL)
    for number, pose in enumerate(several):
        one = {"poses" if rolling else "pose": pose}
        assert_same(batch[number], caster.scan(sensor, threads=1, seed=5 + number, **one, **ALL))
