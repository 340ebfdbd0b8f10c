"""Pairs that need no street: boxes on a road."""

import numpy as np

from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.raycast import raycast
from lidardraft.scene.sensor import Sensor
from lidardraft.training.pairs import NotedPair, Pair

SENSOR = Sensor(name="small", elevations=tuple(np.linspace(0.05, -0.4, 16).tolist()), columns=128)


def make_pair(seed: int, sensor: Sensor = SENSOR) -> Pair:
    """Boxes on a road: a scan of them with range noise and drops, and the condition image."""
    rng = np.random.default_rng(seed)
    primitives = [Primitive(shape="plane", center=(0, 0, 0), size=(200, 200, 0), label="road", id="road")]
    for number in range(12):
        angle, distance = rng.uniform(0, 2 * np.pi), rng.uniform(6, 30)
        center = (distance * np.cos(angle), distance * np.sin(angle), 1.5)
        primitives.append(
            Primitive(
                shape="box", center=center, size=(4, 3, 3), label="building", id=f"b{number}", yaw=rng.uniform(0, 3)
            )
        )
    condition_image = raycast(Layout(primitives=tuple(primitives)), sensor, incidence=True)
    kept = condition_image.valid & (rng.random(sensor.shape) > 0.1)
    assert condition_image.incidence is not None
    scan = RangeImage(
        sensor=sensor,
        depth=np.where(kept, condition_image.depth + rng.normal(0, 0.02, sensor.shape), 0).astype(np.float32),
        label=np.where(kept, condition_image.label, 0).astype(np.uint8),
        instance=np.zeros(sensor.shape, dtype=np.uint32),
        intensity=np.where(kept, condition_image.incidence, 0).astype(np.float32),
    )
    return scan, condition_image


def noted(seed: int, sensor: Sensor = SENSOR) -> NotedPair:
    """`make_pair` with the seed as its note."""
    return *make_pair(seed, sensor), {"seed": seed}
