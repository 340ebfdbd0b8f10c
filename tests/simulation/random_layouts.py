"""Layouts of shapes of every class in any size, as no sentence would give them."""

import math

import numpy as np

from lidardraft import CLASSES, Intent, Layout, Primitive
from lidardraft.semantics import GROUND

SOLIDS = ("box", "ellipsoid", "cylinder")


def random_layout(seed: int, count: int = 30, *, headed: bool = True) -> Layout:
    """A road with a sidewalk and `count` objects, half of them in shapes that their class usually has."""
    rng = np.random.default_rng(seed)
    primitives = [
        Primitive(shape="plane", center=(0, 0, -0.05), size=(200, 200, 0), label="terrain", id="terrain"),
        Primitive(shape="plane", center=(0, 1.75, 0), size=(120, 7, 0), label="road", id="road"),
        Primitive(shape="box", center=(0, -2.75, 0.06), size=(120, 2, 0.12), label="sidewalk", id="sidewalk_1"),
    ]
    for number in range(1, count + 1):
        row = CLASSES[int(rng.integers(1, len(CLASSES)))]
        if row.name in GROUND:
            continue
        size = np.exp(rng.uniform(math.log(0.02), math.log(40.0), 3))
        if row.size is not None and rng.random() < 0.5:
            size = np.array(row.size) * np.exp(rng.normal(0.0, 0.2, 3))
        shape = "box" if rng.random() < 0.5 else SOLIDS[int(rng.integers(3))]
        x, y = rng.uniform(-60, 60, 2)
        primitives.append(
            Primitive(
                shape=shape,
                center=(float(x), float(y), float(size[2] / 2 + rng.choice([0.0, 0.0, 3.0]))),
                size=tuple(size.tolist()),
                label=row.name,
                id=f"{row.name}_{number}" + (".part" if rng.random() < 0.2 else ""),
                yaw=float(rng.uniform(-4, 4)),
                instance=number if row.is_thing else 0,
            )
        )
    return Layout(primitives=tuple(primitives), intent=Intent(headed=headed))
