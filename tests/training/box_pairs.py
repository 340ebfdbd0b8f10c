"""Pairs that need no street: boxes on a road."""

import numpy as np

from lidardraft.formats.pairs import NotedPair, Pair
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.raycast import raycast
from lidardraft.scene.sensor import Sensor

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
    return Pair(_observed(condition_image, rng), condition_image)


def _observed(clean: RangeImage, rng: np.random.Generator) -> RangeImage:
    kept = clean.valid & (rng.random(clean.sensor.shape) > 0.1)
    assert clean.incidence is not None
    return RangeImage(
        sensor=clean.sensor,
        depth=np.where(kept, clean.depth + rng.normal(0, 0.02, kept.shape), 0).astype(np.float32),
        label=np.where(kept, clean.label, 0).astype(np.uint8),
        instance=np.zeros(kept.shape, dtype=np.uint32),
        intensity=np.where(kept, clean.incidence, 0).astype(np.float32),
    )


def noted(seed: int, sensor: Sensor = SENSOR) -> NotedPair:
    """`make_pair` with the seed as its note."""
    return make_pair(seed, sensor), {"seed": seed}
