"""What a layout leaves open, in pixels, and how much of an object others hide."""

import dataclasses

import numpy as np
import pytest

from lidardraft import Box, Layout, Primitive, RangeImage, Sensor, raycast
from lidardraft.errors import LayoutError
from lidardraft.scene.pose import inverse
from lidardraft.scene.visibility import occluded_shares, open_pixels

SENSOR = Sensor(name="small", elevations=tuple(np.deg2rad([10.0, -5.0, -20.0])), columns=72)
LAWN = Primitive(shape="plane", center=(0, 0, 0), size=(200, 200, 0), label="terrain", id="lawn", open=True)
ROAD = Primitive(shape="plane", center=(0, 0, 0.01), size=(200, 6, 0), label="road", id="road")
CAR = Primitive(shape="box", center=(0, 12, 1), size=(4, 2, 2), label="car", id="car", instance=1)
OPEN = Layout((ROAD, LAWN, CAR))
CLOSED = Layout((ROAD, dataclasses.replace(LAWN, open=False), CAR))
POSE = SENSOR.pose()


def cast(layout: Layout, sensor: Sensor = SENSOR) -> RangeImage:
    return raycast(layout, sensor, primitive=True)


def test_what_an_open_shape_or_none_returns_is_open() -> None:
    image = cast(OPEN)
    found = open_pixels(OPEN, image, POSE)
    assert found.dtype == bool
    np.testing.assert_array_equal(found, (image.primitive == 1) | ~image.valid)
    for part in (image.primitive == 1, image.primitive == 0, image.primitive == 2, ~image.valid):
        assert part.any()


@pytest.mark.parametrize("layout", [CLOSED, Layout()])
def test_a_layout_without_an_open_shape_leaves_nothing_open_not_even_the_sky(layout: Layout) -> None:
    image = cast(layout)
    assert not image.valid.all()
    assert not open_pixels(layout, image, POSE).any()


@pytest.mark.parametrize("layout", [OPEN, CLOSED])
@pytest.mark.parametrize(("yaw", "turn"), [(0.0, 0.0), (1.0, 0.0), (1.0, 3.0)])
def test_what_is_outside_the_coverage_is_open(layout: Layout, yaw: float, turn: float) -> None:
    seen = dataclasses.replace(layout, coverage=(-0.5, 1.5))
    sensor = dataclasses.replace(SENSOR, azimuth_offsets=(0.0, 0.2, -0.2))
    poses = sensor.poses_in_motion(sensor.pose(yaw=yaw), angular_velocity=(0.0, 0.0, turn))
    image = raycast(seen, sensor, poses=poses, primitive=True)
    # the azimuth in the world of each ray
    all_around = Layout((Primitive(shape="cylinder", center=(0, 0, 0), size=(40, 40, 40), label="wall", id="w"),))
    points = raycast(all_around, sensor, poses=poses).points(poses).reshape(3, 72, 3)
    azimuth = np.arctan2(points[..., 1], points[..., 0])
    inside = (azimuth > -0.5) & (azimuth < 1.5)
    assert 0.25 < inside.mean() < 0.4
    found = open_pixels(seen, image, poses)
    assert found[~inside].all()
    np.testing.assert_array_equal(found[inside], open_pixels(layout, image, poses)[inside])
    if not turn:
        np.testing.assert_array_equal(found, open_pixels(seen, image, poses[0]))


def test_a_coverage_may_lie_across_the_back() -> None:
    behind = Layout(CLOSED.primitives, coverage=(3.0, 3.5))
    columns = np.flatnonzero(~open_pixels(behind, cast(behind), POSE).any(axis=0))
    azimuth = (np.pi - (columns + 0.5) * 2 * np.pi / 72) % (2 * np.pi)
    assert 3.0 < azimuth.min() < azimuth.max() < 3.5
    assert len(columns) in (5, 6)


def test_what_the_vehicle_hides_is_not_open() -> None:
    hidden = dataclasses.replace(SENSOR, blocked=(((-0.5, 0.5),), (), ((1.0, 4.0),)))
    image = cast(OPEN)
    found = open_pixels(OPEN, dataclasses.replace(image, sensor=hidden), POSE)
    np.testing.assert_array_equal(found, open_pixels(OPEN, image, POSE) & ~hidden.blocked_pixels)
    assert not np.array_equal(found, open_pixels(OPEN, image, POSE))


def test_a_cast_without_primitives_is_refused() -> None:
    with pytest.raises(LayoutError, match="the condition image has no primitives; cast it with primitive=True"):
        open_pixels(OPEN, raycast(OPEN, SENSOR), POSE)


FEW = Sensor(
    name="few",
    elevations=tuple(np.deg2rad(np.linspace(4, -30, 64)).tolist()),
    columns=1024,
    origin_heights=(0.05,) * 64,
)


@pytest.mark.parametrize("turn", [0.0, 0.9, -0.9])
def test_hidden_shares_are_those_of_casts_of_each_object_alone(turn: float) -> None:
    rng = np.random.default_rng(3)
    standing = []
    for number in range(1, 25):
        angle, away = rng.uniform(0, 2 * np.pi), rng.uniform(4, 30)
        size = tuple(rng.uniform((1, 1, 1), (6, 3, 4)).tolist())
        center = (away * np.cos(angle), away * np.sin(angle), size[2] / 2)
        place = {"center": center, "size": size, "yaw": rng.uniform(-3, 3)}
        standing.append(Primitive(shape="box", label="car", id=f"car_{number}", instance=number, **place))
    layout, pose = Layout(tuple(standing)), FEW.pose(yaw=0.4)
    poses = FEW.poses_in_motion(pose, 15.0 * pose[:3, 0], (0.0, 0.0, turn))
    image = raycast(layout, FEW, poses=poses)
    boxes = [box.seen_from(pose) for box in layout.boxes()]
    expected = []
    for one in standing:
        alone = raycast(dataclasses.replace(layout, primitives=(one,)), FEW, poses=poses)
        hidden = (image.depth[alone.valid] < alone.depth[alone.valid] - 0.1) & image.valid[alone.valid]
        expected.append(hidden.mean() if len(hidden) else 1.0)
    np.testing.assert_allclose(occluded_shares(image, boxes, inverse(pose) @ poses), expected, atol=0.02)
    assert min(expected) < 0.01
    assert max(expected) > 0.5


def test_a_box_that_no_ray_looks_at_is_hidden() -> None:
    ahead, above, behind = (
        Box(id, "car", number, center, (4.0, 2.0, 1.5), 0.0)
        for number, (id, center) in enumerate((("ahead", (9, 0, -1)), ("above", (9, 0, 9)), ("behind", (-9, 0, -1))), 1)
    )
    sector = dataclasses.replace(FEW, azimuth_start=0.5, azimuth_span=1.0, columns=100)
    image = raycast(Layout(), sector)
    assert occluded_shares(image, [ahead, above, behind]) == [0.0, 1.0, 1.0]
