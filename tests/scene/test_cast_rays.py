"""Any rays, against scans and closed forms, and at the border of the compiled core."""

import dataclasses

import numpy as np
import pytest

from lidardraft.errors import LayoutError, LidarDraftError
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.pose import upright
from lidardraft.scene.raycast import Raycaster
from lidardraft.scene.sensor import Sensor

BALL = Primitive(shape="ellipsoid", center=(10, 0, 0), size=(4, 4, 4), label="car", id="ball", instance=7)
CASTER = Raycaster(Layout((BALL,)))


def rays_of(sensor, pose):
    """Origins and directions [R, 3] of a sensor's rays in the world, three times as long as they need be."""
    origins = sensor.pattern.origins() @ pose[:3, :3].T + pose[:3, 3]
    directions = 3.0 * sensor.pattern.directions() @ pose[:3, :3].T
    return origins.reshape(-1, 3), directions.reshape(-1, 3)


@pytest.mark.parametrize("seed", range(5))
def test_the_rays_of_a_sensor_hit_what_its_scan_shows(seed):
    random = np.random.default_rng(seed)
    bodies = [
        Primitive(
            shape=("box", "ellipsoid", "cylinder")[i % 3],
            center=tuple(random.uniform(-20, 20, 3)),
            size=tuple(random.uniform(1, 6, 3)),
            yaw=random.uniform(0, 6),
            label="car",
            id=f"car_{i}",
            instance=i + 1,
        )
        for i in range(60)
    ]
    sensor = dataclasses.replace(Sensor.preset("os1-128"), columns=64, min_range=0.0, origin_lefts=(0.03,) * 128)
    pose = upright(tuple(random.uniform(-5, 5, 3)), random.uniform(0, 6))
    caster = Raycaster(Layout(tuple(bodies)))
    image = caster.scan(sensor, pose, primitive=True, normal=True)
    hits = caster.cast(*rays_of(sensor, pose), max_range=sensor.max_range)
    assert 100 < hits.valid.sum() < len(hits)
    for name in ("label", "instance", "primitive"):
        np.testing.assert_array_equal(getattr(hits, name), getattr(image, name).ravel(), err_msg=name)
    np.testing.assert_allclose(hits.distance, image.depth.ravel(), rtol=1e-5, atol=2e-3)
    np.testing.assert_allclose(hits.normal, image.normal.reshape(-1, 3), atol=1e-3)
    np.testing.assert_allclose(hits.points(), image.points(np.tile(pose, (64, 1, 1))), atol=3e-3)


def test_rays_hit_where_geometry_says():
    hits = CASTER.cast([[0, 0, 0], [0, 0, 0], [10, 0, 0], [0, 1, 0]], [[5, 0, 0], [0, 1, 0], [0, 0, 0.1], [1, 0, 0]])
    np.testing.assert_allclose(hits.distance, [8, 0, 2, 10 - np.sqrt(3)], rtol=1e-6)
    np.testing.assert_array_equal(hits.valid, [True, False, True, True])
    np.testing.assert_array_equal(hits.label, [13, 0, 13, 13])
    np.testing.assert_array_equal(hits.instance, [7, 0, 7, 7])
    np.testing.assert_array_equal(hits.primitive, [0, -1, 0, 0])
    np.testing.assert_allclose(hits.points(), [[8, 0, 0], [10, 0, 2], [10 - np.sqrt(3), 1, 0]], atol=1e-6)
    outward = [[-1, 0, 0], [0, 0, 0], [0, 0, -1], [-np.sqrt(3) / 2, 0.5, 0]]
    np.testing.assert_allclose(hits.normal, outward, atol=1e-6)
    assert [a.dtype for a in (hits.distance, hits.label, hits.instance, hits.primitive, hits.normal)] == [
        np.float32,
        np.uint8,
        np.uint32,
        np.int32,
        np.float32,
    ]


def test_rays_end_at_the_range_asked_for():
    ray = [[0.0, 0, 0]], [[1.0, 0, 0]]
    assert not CASTER.cast(*ray, max_range=7.9).valid.any()
    assert CASTER.cast(*ray, max_range=8.1).valid.all()


def test_rays_are_the_same_for_any_number_of_threads():
    random = np.random.default_rng(0)
    rays = random.normal(size=(5000, 3)), random.normal((2, 0, 0), 1, size=(5000, 3))
    one = CASTER.cast(*rays, threads=1)
    assert 0 < one.valid.sum() < 5000
    for threads in (2, 3, 5):
        more = CASTER.cast(*rays, threads=threads)
        for name in ("distance", "label", "instance", "primitive", "normal"):
            np.testing.assert_array_equal(getattr(more, name), getattr(one, name), err_msg=name)


@pytest.mark.parametrize(
    ("origins", "directions", "options", "message"),
    [
        (np.zeros(4), np.ones((1, 3)), {}, r"origins has shape \(4,\); it must be \[3\]"),
        (np.zeros((1, 2)), np.ones((1, 3)), {}, r"origins has shape \(1, 2\); it must be \[R, 3\]"),
        ([[0, 0, 0], [0]], np.ones((2, 3)), {}, r"origins is \[\[0, 0, 0\], \[0\]\]; it must be numbers \[R, 3\]"),
        (np.full(3, 1e10), np.ones((2, 3)), {}, r"origins\[0\] is .* at most 1e9"),
        (np.zeros((1, 3)), np.ones((1, 2)), {}, r"directions has shape \(1, 2\); it must be \[R, 3\]"),
        (np.zeros((1, 3)), np.ones((2, 3)), {}, "1 origins and 2 directions; a ray has one of each"),
        (np.full((1, 3), np.nan), np.ones((1, 3)), {}, r"origins\[0\] is \[NaN"),
        (np.zeros((1, 3)), np.array([[1, np.inf, 0]]), {}, r"directions\[0\] is \[1.0, inf"),
        (np.zeros((2, 3)), np.array([[1, 0, 0], [0, 0, 0]]), {}, r"directions\[1\] is \[0.0, 0.0, 0.0\]"),
        (np.zeros((1, 3)), np.ones((1, 3)), {"max_range": 0.0}, "max_range is 0 m; it must be greater than 0"),
        (np.zeros((1, 3)), np.ones((1, 3)), {"max_range": np.nan}, "max_range is NaN"),
    ],
)
def test_rays_that_cannot_be(origins, directions, options, message):
    with pytest.raises(LidarDraftError, match=message) as caught:
        CASTER.cast(origins, directions, **options)
    assert isinstance(caught.value, LayoutError) or "threads" in options
