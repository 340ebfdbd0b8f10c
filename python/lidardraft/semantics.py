"""The class table: the classes of pixels and primitives.

Ids 1-10 are the Cityscapes / KITTI-360 train ids plus one, 11-18 are the train ids themselves (sky, train id 10, never
returns a ray), so that image labels, KITTI-360 boxes and layouts share one table. Id 0 is "no return".
"""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class SemanticClass:
    """One row of the table.

    `is_thing` marks classes whose objects are counted and get boxes. `size` is its typical (length, width, height) [m];
    `limits` are the smallest and the largest plausible sizes, from children and microcars up to articulated buses and
    coupled trams.
    """

    id: int
    name: str
    colour: tuple[int, int, int]
    is_thing: bool = False
    size: tuple[float, float, float] | None = None
    limits: tuple[tuple[float, float, float], tuple[float, float, float]] | None = None


# Colours: Cityscapes palette. Sizes: common European dimensions, estimates.
CLASSES: tuple[SemanticClass, ...] = (
    SemanticClass(0, "none", (0, 0, 0)),
    SemanticClass(1, "road", (128, 64, 128)),
    SemanticClass(2, "sidewalk", (244, 35, 232)),
    SemanticClass(3, "building", (70, 70, 70)),
    SemanticClass(4, "wall", (102, 102, 156)),
    SemanticClass(5, "fence", (190, 153, 153)),
    SemanticClass(6, "pole", (153, 153, 153)),
    SemanticClass(7, "traffic-light", (250, 170, 30)),
    SemanticClass(8, "traffic-sign", (220, 220, 0)),
    SemanticClass(9, "vegetation", (107, 142, 35)),
    SemanticClass(10, "terrain", (152, 251, 152)),
    SemanticClass(11, "person", (220, 20, 60), True, (0.8, 0.6, 1.7), ((0.2, 0.2, 0.8), (1.6, 1.6, 2.2))),
    SemanticClass(12, "rider", (255, 0, 0), True, (1.8, 0.6, 1.7), ((0.3, 0.3, 0.5), (2.8, 1.2, 2.3))),
    SemanticClass(13, "car", (0, 0, 142), True, (4.2, 1.8, 1.5), ((2.4, 1.3, 1.1), (6.5, 2.4, 3.0))),
    SemanticClass(14, "truck", (0, 0, 70), True, (9.0, 2.5, 3.3), ((4.5, 1.7, 1.8), (20.0, 2.8, 4.5))),
    SemanticClass(15, "bus", (0, 60, 100), True, (12.0, 2.55, 3.1), ((5.5, 1.9, 2.3), (25.0, 2.8, 4.6))),
    SemanticClass(16, "train", (0, 80, 100), True, (28.0, 2.65, 3.6), ((8.0, 2.0, 2.8), (80.0, 3.5, 5.5))),
    SemanticClass(17, "motorcycle", (0, 0, 230), True, (2.1, 0.8, 1.3), ((1.4, 0.4, 0.8), (2.8, 1.3, 2.2))),
    SemanticClass(18, "bicycle", (119, 11, 32), True, (1.8, 0.6, 1.1), ((1.0, 0.2, 0.7), (2.6, 1.0, 2.2))),
    SemanticClass(19, "trunk", (121, 85, 61)),
    SemanticClass(20, "other", (200, 200, 200)),
)

NUM_CLASSES = len(CLASSES)
BY_NAME: dict[str, SemanticClass] = {row.name: row for row in CLASSES}
GROUND = ("road", "sidewalk", "terrain")  # the ground of all other classes
