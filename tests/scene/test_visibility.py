"""How much of an object others hide."""

import dataclasses

import numpy as np
import pytest

from lidardraft import Box, Layout, Primitive, Sensor, raycast
from lidardraft.scene.pose import inverse
from lidardraft.scene.visibility import occluded_shares

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
