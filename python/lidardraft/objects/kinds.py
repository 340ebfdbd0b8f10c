"""The table of kinds: how each kind of object is built and what that needs, in one row.

Other tables name kinds for what is theirs alone: `drafting/solver/sentence_kinds.py` what sentences can ask for,
`arranging/sizes.py` the sizes that streets have, `semantics.py` what extents a class can have at all.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass

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
from lidardraft.objects.object_builder import Add, built
from lidardraft.objects.placed_object import PlacedObject, Vector
from lidardraft.scene.layout import Primitive
from lidardraft.scene.pose import Place, point_at
from lidardraft.scene.solids import Solid
from lidardraft.semantics import BY_NAME


@dataclass(frozen=True, slots=True)
class Kind:
    """One kind of object.

    `add` adds the detailed primitives of an object to its builder, with random numbers of its generator; `labels` are
    the classes that these have, in the order of their instances where they are counted. `word` is what a sentence calls
    it, a name in `SENTENCE_KINDS`; None where no sentence speaks of it.

    `shapes` makes the few solid shapes that a coarse layout has for it, None where that is a box of the first class;
    `boxes` the upright boxes that placement keeps free for extents (length, width, height) and a `clearance` [m].
    `extents` are the smallest and the largest (length, width, height) [m] that `add` is right for, about those that
    `tests/objects` builds: a box beyond them gets a stretched object. None: any are right.

    `most_fall` is how far the ground may fall from under its base to its lowest corner [m]: an object on steeper ground
    is let down; `math.inf` if only the ground under its middle matters. `is_small` objects are easily left out of a
    picture, and those `on_pole` are left out of coarse layouts without poles.
    """

    add: Add
    labels: tuple[str, ...]
    _: KW_ONLY
    word: str | None = None
    shapes: Callable[[PlacedObject], list[CoarseShape]] | None = None
    boxes: Callable[[Vector, float], list[Solid]] = boxes.whole
    extents: tuple[Vector, Vector] | None = None
    most_fall: float = math.inf
    is_small: bool = False
    on_pole: bool = False

    def build(self, placed: PlacedObject, rng: np.random.Generator) -> list[Primitive]:
        """The detailed primitives of an object."""
        return built(self.add, placed, rng)

    def solids(self, place: Place, size: Vector, clearance: float) -> list[Solid]:
        """The upright boxes that an object fills at its place."""
        solids = []
        for own in self.boxes(size, clearance):
            extents = (2 * own.half_length, 2 * own.half_width)
            solids.append(Solid.box(*point_at(place, own.x, own.y), place[2], extents, own.bottom, own.top))
        return solids

    def coarse(self, placed: PlacedObject) -> list[CoarseShape]:
        """The shapes of an object in a coarse layout."""
        return self.shapes(placed) if self.shapes else [coarse.standing("box", placed.size, self.labels[0])]

    @property
    def instances(self) -> int:
        """How many instances an object has: 0 if it is not counted, 2 for a rider and what is ridden."""
        return sum(BY_NAME[label].is_thing for label in self.labels)


def _times(size: Vector, by: float) -> Vector:
    return size[0] * by, size[1] * by, size[2] * by


_PLINTH = buildings.MOST_PLINTH
KINDS: dict[str, Kind] = {
    **{
        name: Kind(
            cars.car, ("car",), word="van" if name == "van" else "car",
            extents=(_times(body.size, 0.5), _times(body.size, 2.0)),
        )
        for name, body in cars.BODIES.items()
    },
    "truck": Kind(trucks.truck, ("truck",), word="truck", extents=((5.5, 2.1, 2.6), (12.0, 2.6, 4.0))),
    "trailer_truck": Kind(
        trucks.trailer_truck, ("truck",), word="truck", shapes=coarse.trailer_truck,
        extents=((12.5, 2.3, 3.2), (18.8, 2.6, 4.2))
    ),
    "bus": Kind(buses.bus, ("bus",), word="bus", extents=((8.0, 2.3, 2.8), (18.8, 2.6, 3.5))),
    "tram": Kind(buses.tram, ("train",), word="tram", extents=((14.0, 2.2, 3.2), (60.0, 2.7, 3.9))),
    "bicycle": Kind(
        bicycles.bicycle, ("bicycle",), word="bicycle", is_small=True, extents=((1.5, 0.45, 1.0), (2.0, 0.7, 1.15))
    ),
    "cyclist": Kind(
        bicycles.cyclist, ("rider", "bicycle"), word="bicycle", shapes=coarse.cyclist,
        extents=((1.6, 0.5, 1.5), (1.95, 0.66, 1.95))
    ),
    "motorcycle": Kind(
        motorcycles.motorcycle, ("motorcycle",), word="motorcycle", extents=((1.8, 0.6, 1.05), (2.4, 0.9, 1.3))
    ),
    "motorcyclist": Kind(
        motorcycles.motorcyclist, ("rider", "motorcycle"), word="motorcycle", shapes=coarse.motorcyclist,
        extents=((1.9, 0.65, 1.4), (2.4, 0.9, 1.75))
    ),
    "person": Kind(pedestrians.person, ("person",), word="person", extents=((0.2, 0.28, 1.0), (1.0, 0.6, 2.0))),
    "house": Kind(
        buildings.house, ("building",), word="house", shapes=coarse.house, boxes=boxes.house,
        most_fall=_PLINTH, extents=((5.0, 5.0, 4.0), (40.0, 20.0, 14.0))
    ),
    "block": Kind(
        buildings.block, ("building",), word="building", boxes=boxes.block, most_fall=_PLINTH,
        extents=((5.0, 5.0, 3.5), (60.0, 40.0, 60.0))
    ),
    "shed": Kind(
        buildings.shed, ("building",), most_fall=_PLINTH, extents=((2.4, 2.4, 2.2), (30.0, 20.0, 6.0))
    ),
    "tree": Kind(
        plants.tree, ("trunk", "vegetation"), word="tree", shapes=coarse.tree, boxes=boxes.tree,
        extents=((0.8, 0.8, 1.5), (20.0, 20.0, 30.0))
    ),
    "bush": Kind(plants.bush, ("vegetation",), word="bush", shapes=coarse.bush, is_small=True),
    "hedge": Kind(plants.hedge, ("vegetation",), word="hedge", extents=((0.6, 0.3, 0.4), (60.0, 4.0, 5.0))),
    "grass": Kind(plants.grass, ("terrain",), shapes=lambda _: [], most_fall=0.0),
    "lamp": Kind(
        poles.lamp, ("pole",), word="street-light", shapes=coarse.mast, boxes=boxes.lamp, is_small=True, on_pole=True
    ),
    "pole": Kind(
        poles.pole, ("pole",), word="pole", shapes=coarse.mast, is_small=True, on_pole=True,
        extents=((0.03, 0.03, 0.3), (1.0, 1.0, 15.0))
    ),
    "sign": Kind(
        signs.sign, ("pole", "traffic-sign"), word="traffic-sign", shapes=coarse.sign, boxes=boxes.sign, is_small=True,
        on_pole=True, extents=((0.05, 0.3, 0.5), (0.4, 4.0, 6.0))
    ),
    "traffic_light": Kind(
        poles.traffic_light, ("pole", "traffic-light"), word="traffic-light", shapes=coarse.traffic_light,
        is_small=True, on_pole=True, extents=((0.2, 0.25, 1.0), (0.6, 0.6, 6.0))
    ),
    "gantry": Kind(signs.gantry, ("pole", "traffic-sign"), shapes=coarse.gantry, boxes=boxes.gantry, on_pole=True),
    "billboard": Kind(signs.billboard, ("other",), shapes=coarse.billboard, boxes=boxes.billboard, on_pole=True),
    "fence": Kind(fences.fence, ("fence",), word="fence", extents=((0.6, 0.05, 0.4), (60.0, 0.4, 3.0))),
    "mesh_fence": Kind(
        fences.mesh_fence, ("fence",), word="fence", is_small=True, extents=((1.0, 0.05, 0.6), (60.0, 0.4, 3.0))
    ),
    "barrier": Kind(fences.barrier, ("fence",), word="fence", is_small=True),
    "garden_wall": Kind(
        fences.garden_wall, ("wall", "fence"), word="wall", extents=((0.5, 0.1, 0.35), (60.0, 0.8, 1.6))
    ),
    "wall": Kind(fences.wall, ("wall",), word="wall", extents=((1.0, 0.1, 0.7), (60.0, 1.0, 8.0))),
    "shelter": Kind(furniture.shelter, ("other",), extents=((2.4, 1.1, 2.2), (7.0, 2.2, 3.0))),
    "bin": Kind(furniture.bin, ("other",), word="bin", is_small=True, extents=((0.35, 0.35, 0.6), (1.3, 1.4, 1.5))),
    "bench": Kind(
        furniture.bench, ("other",), word="bench", is_small=True, extents=((1.0, 0.4, 0.65), (3.0, 0.9, 1.1))
    ),
    "cone": Kind(furniture.cone, ("other",), is_small=True),
    "letterbox": Kind(furniture.letterbox, ("other",), is_small=True),
    "hydrant": Kind(furniture.hydrant, ("other",), is_small=True),
    "cabinet": Kind(furniture.cabinet, ("other",), is_small=True, extents=((0.25, 0.5, 0.7), (0.6, 2.5, 1.8))),
}  # fmt: skip


def kind_of(name: str) -> Kind:
    """The kind of that name; raises `LayoutError` if there is none."""
    try:
        return KINDS[name]
    except KeyError:
        raise LayoutError(f"kind is {name!r}; it must be {one_of(KINDS, name)}") from None
