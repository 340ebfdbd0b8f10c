"""How much of an object others hide, beside casts of each object alone."""

import dataclasses

import numpy as np

from lidardraft import Layout, Primitive, Sensor, raycast
from lidardraft.scene.visibility import occluded_shares

SENSOR = Sensor(
    name="few",
    elevations=tuple(np.deg2rad(np.linspace(4, -30, 64)).tolist()),
    columns=1024,
    origin_heights=(0.05,) * 64,
)


def test_shares_are_those_of_casts_of_each_object_alone() -> None:
    rng = np.random.default_rng(3)
    standing = []
    for number in range(1, 25):
        angle, away = rng.uniform(0, 2 * np.pi), rng.uniform(4, 30)
        size = tuple(rng.uniform((1, 1, 1), (6, 3, 4)).tolist())
        center = (away * np.cos(angle), away * np.sin(angle), size[2] / 2)
        standing.append(
            Primitive(
                shape="box",
                center=center,
                size=size,
                label="car",
                id=f"car_{number}",
                yaw=rng.uniform(-3, 3),
                instance=number,
            )
        )
    layout, pose = Layout(tuple(standing)), SENSOR.pose(yaw=0.4)
    poses = SENSOR.poses_in_motion(pose, 15.0 * pose[:3, 0])
    moved = (poses[:, :3, 3] - pose[:3, 3]) @ pose[:3, :3]
    image = raycast(layout, SENSOR, poses=poses)
    boxes = [box.seen_from(pose) for box in layout.boxes()]
    expected = []
    for one in standing:
        alone = raycast(dataclasses.replace(layout, primitives=(one,)), SENSOR, poses=poses)
        hidden = (image.depth[alone.valid] < alone.depth[alone.valid] - 0.1) & image.valid[alone.valid]
        expected.append(hidden.mean() if len(hidden) else 1.0)
    np.testing.assert_allclose(occluded_shares(image, boxes, moved), expected, atol=0.02)
    assert min(expected) < 0.01
    assert max(expected) > 0.5
