"""The table of kinds: all that is known of each kind of object, in one row.

Whatever needs to know something of an object's kind asks this table; nothing else lists kinds.
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
    trams,
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

    `word` is what the plan of a sentence calls it, a name in `lidardraft.drafting.sentence_kinds`, None where no
    sentence speaks of it; `alignment` is how the solver of sentences places it.
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

    @property
    def instances(self) -> int:
        """How many instances an object has: 0 if it is not counted, 2 for a rider and what is ridden."""
        return sum(BY_NAME[label].is_thing for label in self.labels)


_INF = math.inf
_PLINTH = buildings.MOST_PLINTH
_LANE, _ROAD, _SQUARE, _FREE = Alignment.LANE, Alignment.ROAD, Alignment.SQUARE, Alignment.FREE

KINDS: dict[str, Kind] = {
    **{
        body: Kind(
            build=cars.car, labels=("car",), coarse=coarse.box_of("car"), boxes=boxes.whole, most_fall=_INF,
            is_small=False, on_pole=False, word="van" if body == "van" else "car", alignment=_LANE,
        )
        for body in cars.BODIES
    },
    "truck": Kind(
        build=trucks.truck, labels=("truck",), coarse=coarse.box_of("truck"), boxes=boxes.whole, most_fall=_INF,
        is_small=False, on_pole=False, word="truck", alignment=_LANE,
    ),
    "trailer_truck": Kind(
        build=trucks.trailer_truck, labels=("truck",), coarse=coarse.trailer_truck, boxes=boxes.whole, most_fall=_INF,
        is_small=False, on_pole=False, word="truck", alignment=_LANE,
    ),
    "bus": Kind(
        build=buses.bus, labels=("bus",), coarse=coarse.box_of("bus"), boxes=boxes.whole, most_fall=_INF,
        is_small=False, on_pole=False, word="bus", alignment=_LANE,
    ),
    "tram": Kind(
        build=trams.tram, labels=("train",), coarse=coarse.box_of("train"), boxes=boxes.whole, most_fall=_INF,
        is_small=False, on_pole=False, word="tram", alignment=_LANE,
    ),
    "bicycle": Kind(
        build=bicycles.bicycle, labels=("bicycle",), coarse=coarse.box_of("bicycle"), boxes=boxes.whole,
        most_fall=_INF, is_small=True, on_pole=False, word="bicycle", alignment=_FREE,
    ),
    "cyclist": Kind(
        build=bicycles.cyclist, labels=("rider", "bicycle"), coarse=coarse.cyclist, boxes=boxes.whole,
        most_fall=_INF, is_small=False, on_pole=False, word="bicycle", alignment=_FREE,
    ),
    "motorcycle": Kind(
        build=motorcycles.motorcycle, labels=("motorcycle",), coarse=coarse.box_of("motorcycle"), boxes=boxes.whole,
        most_fall=_INF, is_small=False, on_pole=False, word="motorcycle", alignment=_LANE,
    ),
    "motorcyclist": Kind(
        build=motorcycles.motorcyclist, labels=("rider", "motorcycle"), coarse=coarse.motorcyclist, boxes=boxes.whole,
        most_fall=_INF, is_small=False, on_pole=False, word="motorcycle", alignment=_LANE,
    ),
    "person": Kind(
        build=pedestrians.person, labels=("person",), coarse=coarse.box_of("person"), boxes=boxes.whole,
        most_fall=_INF, is_small=False, on_pole=False, word="person", alignment=_FREE,
    ),
    "house": Kind(
        build=buildings.house, labels=("building",), coarse=coarse.house, boxes=boxes.house, most_fall=_PLINTH,
        is_small=False, on_pole=False, word="house", alignment=_ROAD,
    ),
    "block": Kind(
        build=buildings.block, labels=("building",), coarse=coarse.box_of("building"), boxes=boxes.block,
        most_fall=_PLINTH, is_small=False, on_pole=False, word="building", alignment=_ROAD,
    ),
    "shed": Kind(
        build=buildings.shed, labels=("building",), coarse=coarse.box_of("building"), boxes=boxes.whole,
        most_fall=_PLINTH, is_small=False, on_pole=False, word=None, alignment=_ROAD,
    ),
    "tree": Kind(
        build=plants.tree, labels=("trunk", "vegetation"), coarse=coarse.tree, boxes=boxes.tree, most_fall=_INF,
        is_small=False, on_pole=False, word="tree", alignment=_FREE,
    ),
    "bush": Kind(
        build=plants.bush, labels=("vegetation",), coarse=coarse.bush, boxes=boxes.whole, most_fall=_INF,
        is_small=True, on_pole=False, word="bush", alignment=_FREE,
    ),
    "hedge": Kind(
        build=plants.hedge, labels=("vegetation",), coarse=coarse.box_of("vegetation"), boxes=boxes.whole,
        most_fall=_INF, is_small=False, on_pole=False, word="hedge", alignment=_FREE,
    ),
    "grass": Kind(
        build=plants.grass, labels=("terrain",), coarse=coarse.nothing, boxes=boxes.whole, most_fall=0.0,
        is_small=False, on_pole=False, word=None, alignment=_FREE,
    ),
    "lamp": Kind(
        build=poles.lamp, labels=("pole",), coarse=coarse.mast, boxes=boxes.lamp, most_fall=_INF,
        is_small=True, on_pole=True, word="street-light", alignment=_FREE,
    ),
    "pole": Kind(
        build=poles.pole, labels=("pole",), coarse=coarse.mast, boxes=boxes.whole, most_fall=_INF,
        is_small=True, on_pole=True, word="pole", alignment=_FREE,
    ),
    "sign": Kind(
        build=signs.sign, labels=("pole", "traffic-sign"), coarse=coarse.sign, boxes=boxes.sign, most_fall=_INF,
        is_small=True, on_pole=True, word="traffic-sign", alignment=_SQUARE,
    ),
    "traffic_light": Kind(
        build=poles.traffic_light, labels=("pole", "traffic-light"), coarse=coarse.traffic_light, boxes=boxes.whole,
        most_fall=_INF, is_small=True, on_pole=True, word="traffic-light", alignment=_SQUARE,
    ),
    "gantry": Kind(
        build=signs.gantry, labels=("pole", "traffic-sign"), coarse=coarse.gantry, boxes=boxes.gantry, most_fall=_INF,
        is_small=False, on_pole=True, word=None, alignment=_FREE,
    ),
    "billboard": Kind(
        build=signs.billboard, labels=("other",), coarse=coarse.billboard, boxes=boxes.billboard, most_fall=_INF,
        is_small=False, on_pole=True, word=None, alignment=_FREE,
    ),
    "fence": Kind(
        build=fences.fence, labels=("fence",), coarse=coarse.box_of("fence"), boxes=boxes.whole, most_fall=_INF,
        is_small=False, on_pole=False, word="fence", alignment=_FREE,
    ),
    "mesh_fence": Kind(
        build=fences.mesh_fence, labels=("fence",), coarse=coarse.box_of("fence"), boxes=boxes.whole,
        most_fall=_INF, is_small=True, on_pole=False, word="fence", alignment=_FREE,
    ),
    "barrier": Kind(
        build=fences.barrier, labels=("fence",), coarse=coarse.box_of("fence"), boxes=boxes.whole, most_fall=_INF,
        is_small=True, on_pole=False, word="fence", alignment=_FREE,
    ),
    "garden_wall": Kind(
        build=fences.garden_wall, labels=("wall", "fence"), coarse=coarse.box_of("wall"), boxes=boxes.whole,
        most_fall=_INF, is_small=False, on_pole=False, word="wall", alignment=_FREE,
    ),
    "wall": Kind(
        build=fences.wall, labels=("wall",), coarse=coarse.box_of("wall"), boxes=boxes.whole, most_fall=_INF,
        is_small=False, on_pole=False, word="wall", alignment=_FREE,
    ),
    "shelter": Kind(
        build=furniture.shelter, labels=("other",), coarse=coarse.box_of("other"), boxes=boxes.whole, most_fall=_INF,
        is_small=False, on_pole=False, word=None, alignment=_FREE,
    ),
    "bin": Kind(
        build=furniture.bin, labels=("other",), coarse=coarse.box_of("other"), boxes=boxes.whole, most_fall=_INF,
        is_small=True, on_pole=False, word="bin", alignment=_SQUARE,
    ),
    "bench": Kind(
        build=furniture.bench, labels=("other",), coarse=coarse.box_of("other"), boxes=boxes.whole, most_fall=_INF,
        is_small=True, on_pole=False, word="bench", alignment=_SQUARE,
    ),
    "cone": Kind(
        build=furniture.cone, labels=("other",), coarse=coarse.box_of("other"), boxes=boxes.whole, most_fall=_INF,
        is_small=True, on_pole=False, word=None, alignment=_FREE,
    ),
    "letterbox": Kind(
        build=furniture.letterbox, labels=("other",), coarse=coarse.box_of("other"), boxes=boxes.whole,
        most_fall=_INF, is_small=True, on_pole=False, word=None, alignment=_FREE,
    ),
    "hydrant": Kind(
        build=furniture.hydrant, labels=("other",), coarse=coarse.box_of("other"), boxes=boxes.whole, most_fall=_INF,
        is_small=True, on_pole=False, word=None, alignment=_FREE,
    ),
    "cabinet": Kind(
        build=furniture.cabinet, labels=("other",), coarse=coarse.box_of("other"), boxes=boxes.whole, most_fall=_INF,
        is_small=True, on_pole=False, word=None, alignment=_FREE,
    ),
}  # fmt: skip


def kind_of(name: str) -> Kind:
    """The kind of that name; raises `LayoutError` if there is none."""
    try:
        return KINDS[name]
    except KeyError:
        raise LayoutError(f"kind is {name!r}; it must be {one_of(KINDS, name)}") from None
