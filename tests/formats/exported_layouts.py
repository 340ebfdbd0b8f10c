"""Layouts with all that a file of another program has to carry."""

import lidardraft
from lidardraft.scene.layout import Layout, Primitive
from lidardraft.scene.mesh import unit_mesh

CONE = Primitive(
    shape="mesh", center=(7, 3, 1), size=(2, 2, 2), yaw=0.4, label="other", id="cone", mesh=unit_mesh("cylinder")
)
EVERYTHING = Layout((
    Primitive(shape="plane", center=(0, 0, 0), size=(100, 8, 0), label="road", id="road"),
    Primitive(shape="plane", center=(0, 0, -0.1), size=(99, 99, 0), label="terrain", id="lawn", open=True),
    Primitive(shape="box", center=(12, 0.1, 0.75), size=(4.2, 1.8, 1.5), yaw=1 / 3, label="car", id="car_1.body",
              instance=4),
    Primitive(shape="box", center=(12, 0.1, 1.6), size=(2, 1.6, 0.2), yaw=1 / 3, label="car", id="car_1.roof",
              instance=4),
    Primitive(shape="cylinder", center=(5, 6, 1.5), size=(0.3, 0.3, 3), label="trunk", id="tree_1.trunk",
              material="bark"),
    Primitive(shape="ellipsoid", center=(5, 6, 4), size=(3, 2, 4), yaw=-2.5, label="vegetation", id="tree_1.crown",
              extinction=0.7),
    CONE,
    Primitive.from_mesh([(0, 0, 0), (4, 0, 0), (4, 3, 0), (0, 3, 1 / 3)], [(0, 1, 2), (0, 2, 3)], label="terrain",
                        id="a bank of 'grass'"),
    Primitive.from_mesh([(0, 9, 0), (4, 9, 0), (4, 9, 3)], [(0, 1, 2)], label="wall", id="fence_gate"),
), {"sentence": 'a "car" ahead\n', "seed": 3}, (-1.0, 1.5))  # fmt: skip


def drafted() -> list[Layout]:
    """Layouts of sentences, with hundreds of shapes."""
    sentences = ("two parked cars on the left, trees along both sides, houses", "a busy crossroads", "a bus ahead")
    return [lidardraft.layout_from_text(sentence, seed=seed) for seed, sentence in enumerate(sentences)]
