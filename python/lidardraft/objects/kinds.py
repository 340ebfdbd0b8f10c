"""The table of kinds: how each kind of object is built and what that needs, in one row.

Other tables name kinds for what is theirs alone: `drafting/solver/sentence_kinds.py` what sentences can ask for,
`arranging/sizes.py` the sizes that streets have, `scene/check.py` what extents a class can have at all.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

import numpy as np

from lidardraft.errors import LayoutError, one_of
from lidardraft.objects import (
    bicycles,
    buildings,
    buses,
    cars,
    fences,
    furniture,
    motorcycles,
    pedestrians,
    plants,
    poles,
    signs,
    trucks,
)
from lidardraft.objects import coarse_shapes as coarse
from lidardraft.objects import collision_boxes as boxes
from lidardraft.objects.coarse_shapes import CoarseShape
from lidardraft.objects.collision_boxes import CollisionBox
from lidardraft.objects.placed_object import PlacedObject, Vector
from lidardraft.scene.layout import Primitive
from lidardraft.semantics import BY_NAME


class Alignment(Enum):
    """How the solver of sentences turns an object and puts it in line."""

    LANE = "along the road, in the middle of a lane or a row of parked cars"
    ROAD = "along the road or across it, wherever it stands"
    SQUARE = "exactly along the road or across it, wherever it stands"
    FREE = "turned as it is"


@dataclass(frozen=True, kw_only=True, slots=True)
class Kind:
    """One kind of object. No field has a default: whoever adds a kind decides on all of them.

    `build` makes the detailed primitives of an object, with random numbers of its generator; `labels` are the classes
    that these have, in the order of their instances where they are counted. `coarse` makes the few solid shapes that a
    coarse layout has for it, `boxes` the upright boxes that placement keeps free for extents (length, width, height)
    and a `clearance` [m].

    `most_fall` is how far the ground may fall from under its base to its lowest corner [m]: an object on steeper ground
    is let down; `math.inf` if only the ground under its middle matters. `is_small` objects are easily left out of a
    picture, and those `on_pole` are left out of coarse layouts without poles.

    `word` is what the plan of a sentence calls it, a name in `lidardraft.drafting.solver.sentence_kinds`, None where no
    sentence speaks of it; `alignment` is how the solver of sentences places it.

    `extents` are the smallest and the largest (length, width, height) [m] that `build` is right for, about those that
    `tests/objects` builds: a box beyond them gets a stretched object. None: any are right.
    """

    build: Callable[[PlacedObject, np.random.Generator], list[Primitive]]
    labels: tuple[str, ...]
    coarse: Callable[[PlacedObject], list[CoarseShape]]
    boxes: Callable[[Vector, float], list[CollisionBox]]
    most_fall: float
    is_small: bool
    on_pole: bool
    word: str | None
    alignment: Alignment
    extents: tuple[Vector, Vector] | None

    @property
    def instances(self) -> int:
        """How many instances an object has: 0 if it is not counted, 2 for a rider and what is ridden."""
        return sum(BY_NAME[label].is_thing for label in self.labels)


def _times(size: Vector, by: float) -> Vector:
    return size[0] * by, size[1] * by, size[2] * by


_INF = math.inf
_PLINTH = buildings.MOST_PLINTH
_LANE, _ROAD, _SQUARE, _FREE = Alignment.LANE, Alignment.ROAD, Alignment.SQUARE, Alignment.FREE

KINDS: dict[str, Kind] = {
    **{
        name: Kind(
            build=cars.car, labels=("car",), coarse=coarse.box_of("car"), boxes=boxes.whole, most_fall=_INF,
            is_small=False, on_pole=False, word="van" if name == "van" else "car", alignment=_LANE,
            extents=(_times(body.size, 0.5), _times(body.size, 2.0)),
        )
        for name, body in cars.BODIES.items()
    },
    "truck": Kind(
        build=trucks.truck, labels=("truck",), coarse=coarse.box_of("truck"), boxes=boxes.whole, most_fall=_INF,
        is_small=False, on_pole=False, word="truck", alignment=_LANE,
        extents=((5.5, 2.1, 2.6), (12.0, 2.6, 4.0)),
    ),
    "trailer_truck": Kind(
        build=trucks.trailer_truck, labels=("truck",), coarse=coarse.trailer_truck, boxes=boxes.whole, most_fall=_INF,
        is_small=False, on_pole=False, word="truck", alignment=_LANE,
        extents=((12.5, 2.3, 3.2), (18.8, 2.6, 4.2)),
    ),
    "bus": Kind(
        build=buses.bus, labels=("bus",), coarse=coarse.box_of("bus"), boxes=boxes.whole, most_fall=_INF,
        is_small=False, on_pole=False, word="bus", alignment=_LANE,
        extents=((8.0, 2.3, 2.8), (18.8, 2.6, 3.5)),
    ),
    "tram": Kind(
        build=buses.tram, labels=("train",), coarse=coarse.box_of("train"), boxes=boxes.whole, most_fall=_INF,
        is_small=False, on_pole=False, word="tram", alignment=_LANE,
        extents=((14.0, 2.2, 3.2), (60.0, 2.7, 3.9)),
    ),
    "bicycle": Kind(
        build=bicycles.bicycle, labels=("bicycle",), coarse=coarse.box_of("bicycle"), boxes=boxes.whole,
        most_fall=_INF, is_small=True, on_pole=False, word="bicycle", alignment=_FREE,
        extents=((1.5, 0.45, 1.0), (2.0, 0.7, 1.15)),
    ),
    "cyclist": Kind(
        build=bicycles.cyclist, labels=("rider", "bicycle"), coarse=coarse.cyclist, boxes=boxes.whole,
        most_fall=_INF, is_small=False, on_pole=False, word="bicycle", alignment=_FREE,
        extents=((1.6, 0.5, 1.5), (1.95, 0.66, 1.95)),
    ),
    "motorcycle": Kind(
        build=motorcycles.motorcycle, labels=("motorcycle",), coarse=coarse.box_of("motorcycle"), boxes=boxes.whole,
        most_fall=_INF, is_small=False, on_pole=False, word="motorcycle", alignment=_LANE,
        extents=((1.8, 0.6, 1.05), (2.4, 0.9, 1.3)),
    ),
    "motorcyclist": Kind(
        build=motorcycles.motorcyclist, labels=("rider", "motorcycle"), coarse=coarse.motorcyclist, boxes=boxes.whole,
        most_fall=_INF, is_small=False, on_pole=False, word="motorcycle", alignment=_LANE,
        extents=((1.9, 0.65, 1.4), (2.4, 0.9, 1.75)),
    ),
    "person": Kind(
        build=pedestrians.person, labels=("person",), coarse=coarse.box_of("person"), boxes=boxes.whole,
        most_fall=_INF, is_small=False, on_pole=False, word="person", alignment=_FREE,
        extents=((0.2, 0.28, 1.0), (1.0, 0.6, 2.0)),
    ),
    "house": Kind(
        build=buildings.house, labels=("building",), coarse=coarse.house, boxes=boxes.house, most_fall=_PLINTH,
        is_small=False, on_pole=False, word="house", alignment=_ROAD,
        extents=((5.0, 5.0, 4.0), (40.0, 20.0, 14.0)),
    ),
    "block": Kind(
        build=buildings.block, labels=("building",), coarse=coarse.box_of("building"), boxes=boxes.block,
        most_fall=_PLINTH, is_small=False, on_pole=False, word="building", alignment=_ROAD,
        extents=((5.0, 5.0, 3.5), (60.0, 40.0, 60.0)),
    ),
    "shed": Kind(
        build=buildings.shed, labels=("building",), coarse=coarse.box_of("building"), boxes=boxes.whole,
        most_fall=_PLINTH, is_small=False, on_pole=False, word=None, alignment=_ROAD,
        extents=((2.4, 2.4, 2.2), (30.0, 20.0, 6.0)),
    ),
    "tree": Kind(
        build=plants.tree, labels=("trunk", "vegetation"), coarse=coarse.tree, boxes=boxes.tree, most_fall=_INF,
        is_small=False, on_pole=False, word="tree", alignment=_FREE,
        extents=((0.8, 0.8, 1.5), (20.0, 20.0, 30.0)),
    ),
    "bush": Kind(
        build=plants.bush, labels=("vegetation",), coarse=coarse.bush, boxes=boxes.whole, most_fall=_INF,
        is_small=True, on_pole=False, word="bush", alignment=_FREE,
        extents=None,
    ),
    "hedge": Kind(
        build=plants.hedge, labels=("vegetation",), coarse=coarse.box_of("vegetation"), boxes=boxes.whole,
        most_fall=_INF, is_small=False, on_pole=False, word="hedge", alignment=_FREE,
        extents=((0.6, 0.3, 0.4), (60.0, 4.0, 5.0)),
    ),
    "grass": Kind(
        build=plants.grass, labels=("terrain",), coarse=coarse.nothing, boxes=boxes.whole, most_fall=0.0,
        is_small=False, on_pole=False, word=None, alignment=_FREE,
        extents=None,
    ),
    "lamp": Kind(
        build=poles.lamp, labels=("pole",), coarse=coarse.mast, boxes=boxes.lamp, most_fall=_INF,
        is_small=True, on_pole=True, word="street-light", alignment=_FREE,
        extents=None,
    ),
    "pole": Kind(
        build=poles.pole, labels=("pole",), coarse=coarse.mast, boxes=boxes.whole, most_fall=_INF,
        is_small=True, on_pole=True, word="pole", alignment=_FREE,
        extents=((0.03, 0.03, 0.3), (1.0, 1.0, 15.0)),
    ),
    "sign": Kind(
        build=signs.sign, labels=("pole", "traffic-sign"), coarse=coarse.sign, boxes=boxes.sign, most_fall=_INF,
        is_small=True, on_pole=True, word="traffic-sign", alignment=_SQUARE,
        extents=((0.05, 0.3, 0.5), (0.4, 4.0, 6.0)),
    ),
    "traffic_light": Kind(
        build=poles.traffic_light, labels=("pole", "traffic-light"), coarse=coarse.traffic_light, boxes=boxes.whole,
        most_fall=_INF, is_small=True, on_pole=True, word="traffic-light", alignment=_SQUARE,
        extents=((0.2, 0.25, 1.0), (0.6, 0.6, 6.0)),
    ),
    "gantry": Kind(
        build=signs.gantry, labels=("pole", "traffic-sign"), coarse=coarse.gantry, boxes=boxes.gantry, most_fall=_INF,
        is_small=False, on_pole=True, word=None, alignment=_FREE,
        extents=None,
    ),
    "billboard": Kind(
        build=signs.billboard, labels=("other",), coarse=coarse.billboard, boxes=boxes.billboard, most_fall=_INF,
        is_small=False, on_pole=True, word=None, alignment=_FREE,
        extents=None,
    ),
    "fence": Kind(
        build=fences.fence, labels=("fence",), coarse=coarse.box_of("fence"), boxes=boxes.whole, most_fall=_INF,
        is_small=False, on_pole=False, word="fence", alignment=_FREE,
        extents=((0.6, 0.05, 0.4), (60.0, 0.4, 3.0)),
    ),
    "mesh_fence": Kind(
        build=fences.mesh_fence, labels=("fence",), coarse=coarse.box_of("fence"), boxes=boxes.whole,
        most_fall=_INF, is_small=True, on_pole=False, word="fence", alignment=_FREE,
        extents=((1.0, 0.05, 0.6), (60.0, 0.4, 3.0)),
    ),
    "barrier": Kind(
        build=fences.barrier, labels=("fence",), coarse=coarse.box_of("fence"), boxes=boxes.whole, most_fall=_INF,
        is_small=True, on_pole=False, word="fence", alignment=_FREE,
        extents=None,
    ),
    "garden_wall": Kind(
        build=fences.garden_wall, labels=("wall", "fence"), coarse=coarse.box_of("wall"), boxes=boxes.whole,
        most_fall=_INF, is_small=False, on_pole=False, word="wall", alignment=_FREE,
        extents=((0.5, 0.1, 0.35), (60.0, 0.8, 1.6)),
    ),
    "wall": Kind(
        build=fences.wall, labels=("wall",), coarse=coarse.box_of("wall"), boxes=boxes.whole, most_fall=_INF,
        is_small=False, on_pole=False, word="wall", alignment=_FREE,
        extents=((1.0, 0.1, 0.7), (60.0, 1.0, 8.0)),
    ),
    "shelter": Kind(
        build=furniture.shelter, labels=("other",), coarse=coarse.box_of("other"), boxes=boxes.whole, most_fall=_INF,
        is_small=False, on_pole=False, word=None, alignment=_FREE,
        extents=((2.4, 1.1, 2.2), (7.0, 2.2, 3.0)),
    ),
    "bin": Kind(
        build=furniture.bin, labels=("other",), coarse=coarse.box_of("other"), boxes=boxes.whole, most_fall=_INF,
        is_small=True, on_pole=False, word="bin", alignment=_SQUARE,
        extents=((0.35, 0.35, 0.6), (1.3, 1.4, 1.5)),
    ),
    "bench": Kind(
        build=furniture.bench, labels=("other",), coarse=coarse.box_of("other"), boxes=boxes.whole, most_fall=_INF,
        is_small=True, on_pole=False, word="bench", alignment=_SQUARE,
        extents=((1.0, 0.4, 0.65), (3.0, 0.9, 1.1)),
    ),
    "cone": Kind(
        build=furniture.cone, labels=("other",), coarse=coarse.box_of("other"), boxes=boxes.whole, most_fall=_INF,
        is_small=True, on_pole=False, word=None, alignment=_FREE,
        extents=None,
    ),
    "letterbox": Kind(
        build=furniture.letterbox, labels=("other",), coarse=coarse.box_of("other"), boxes=boxes.whole,
        most_fall=_INF, is_small=True, on_pole=False, word=None, alignment=_FREE,
        extents=None,
    ),
    "hydrant": Kind(
        build=furniture.hydrant, labels=("other",), coarse=coarse.box_of("other"), boxes=boxes.whole, most_fall=_INF,
        is_small=True, on_pole=False, word=None, alignment=_FREE,
        extents=None,
    ),
    "cabinet": Kind(
        build=furniture.cabinet, labels=("other",), coarse=coarse.box_of("other"), boxes=boxes.whole, most_fall=_INF,
        is_small=True, on_pole=False, word=None, alignment=_FREE,
        extents=((0.25, 0.5, 0.7), (0.6, 2.5, 1.8)),
    ),
}  # fmt: skip


def kind_of(name: str) -> Kind:
    """The kind of that name; raises `LayoutError` if there is none."""
    try:
        return KINDS[name]
    except KeyError:
        raise LayoutError(f"kind is {name!r}; it must be {one_of(KINDS, name)}") from None
