"""The table of kinds, a row each: for sentences, and for the kinds of object that are built.

Everything else is a view of it, except words (`drafting/text/kinds.txt`, `scene/class_names.py`), the sizes in streets
(`arranging/sizes.py`), and the possible extents of a class (`semantics.py`).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass, replace
from functools import partial

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
from lidardraft.objects.sentence_kind import (
    CountRanges,
    SentenceKind,
    SizeAround,
    SizeBetween,
    sample_animal,
    sample_cone,
    sample_garden,
    sample_round,
    sample_street_light,
    sample_traffic_light,
    sample_traffic_sign,
    sample_tree,
)
from lidardraft.scene.layout import Primitive
from lidardraft.scene.pose import Place, point_at
from lidardraft.scene.solids import Solid
from lidardraft.semantics import BY_NAME


@dataclass(frozen=True, slots=True)
class Kind:
    """One kind of object.

    `add` adds the detailed primitives of an object to its builder, with random numbers of its generator; `labels` are
    their classes, in the order of instances for things. `word` is its name in sentences, one of `SENTENCE_KINDS`. It is
    None if sentences do not name it, or if it is `unsaid`: coarse layouts of streets in the form of sentences leave it
    out, as in the training of the packaged weights.

    `shapes` makes the few solid shapes of it in a coarse layout, None for a box of the first class; `boxes` makes the
    upright boxes that placement keeps free, from extents (length, width, height) and a `clearance` [m]. `extents` are
    the smallest and the largest (length, width, height) [m] that `add` is valid for, about those that `tests/objects`
    builds: a box beyond them gets a stretched object. None: all are valid.

    `most_fall` is the largest drop of the ground from under its base to its lowest corner [m]: an object on steeper
    ground is lowered; `math.inf` if only the ground under its middle matters. `is_small` objects are easily missed in a
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
    unsaid: bool = False

    def build(self, placed: PlacedObject, rng: np.random.Generator) -> list[Primitive]:
        """The detailed primitives of an object."""
        return built(self.add, placed, rng)

    def solids(self, place: Place, size: Vector, clearance: float) -> list[Solid]:
        """The upright boxes that an object occupies at its place."""
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
        """The number of instances of an object: 0 for stuff, 2 for a rider and its vehicle."""
        return sum(BY_NAME[label].is_thing for label in self.labels)


def _car(body: str) -> Kind:
    length, width, height = cars.BODIES[body].size
    extents = ((0.5 * length, 0.5 * width, 0.5 * height), (2.0 * length, 2.0 * width, 2.0 * height))
    return Kind(cars.car, ("car",), extents=extents)


# Sizes in sentences: their spread, as shares of length, width and height.
_MACHINE = (0.10, 0.04, 0.08)
_TWO_WHEELER = (0.08, 0.10, 0.06)


def _class_sizes(label: str, spread: tuple[float, float, float]) -> SizeAround:
    """Sizes around the typical one in the class table."""
    typical = BY_NAME[label].size
    assert typical is not None, f"{label} has no typical size"
    return SizeAround(typical, spread)


# Numbers are estimates. Vans are cars in Cityscapes; their size is that of common European ones. Lengths of roadside
# objects are along the road.
_vehicle = partial(SentenceKind, counts=CountRanges(), surfaces=("road",), is_vehicle=True)
_large = partial(_vehicle, parking_width=3.0)
_ANYWHERE = ("road", "sidewalk", "median")
_thing = partial(SentenceKind, surfaces=_ANYWHERE)
_plant = partial(SentenceKind, label="vegetation")
_building = partial(
    SentenceKind, label="building", family="buildings", counts=CountRanges(some=(3, 5)), yaw_deviation=0.02
)
_strip = partial(
    SentenceKind, counts=CountRanges((1, 2), (2, 3), (3, 4)), surfaces=("road", "median"), follows_road=True
)
_enclosure = partial(_strip, family="enclosures")
_pole = partial(_thing, family="poles")
_furniture = partial(_thing, label="other", family="furniture", is_square=True)
_PLINTH = buildings.MOST_PLINTH
_TABLE: tuple[tuple[SentenceKind | None, dict[str, Kind]], ...] = (
    (_large("vehicle", None, "car", precedence=7), {}),
    (_vehicle("car", _class_sizes("car", _MACHINE), "car", precedence=6, traffic_share=0.76), {
        name: _car(name) for name in cars.BODIES if name != "van"
    }),
    (_vehicle("van", SizeAround((5.3, 2.0, 2.2), _MACHINE), "car", precedence=8, traffic_share=0.12), {
        "van": _car("van"),
    }),
    (_large("truck", _class_sizes("truck", _MACHINE), "truck", precedence=9, traffic_share=0.08, lane_length=18.0), {
        "truck": Kind(trucks.truck, ("truck",), extents=((5.5, 2.1, 2.6), (12.0, 2.6, 4.0))),
        "trailer_truck": Kind(
            trucks.trailer_truck, ("truck",), shapes=coarse.trailer_truck,
            extents=((12.5, 2.3, 3.2), (18.8, 2.6, 4.2))
        ),
    }),
    (_large("bus", _class_sizes("bus", _MACHINE), "bus", precedence=10, traffic_share=0.04, lane_length=21.0), {
        "bus": Kind(buses.bus, ("bus",), extents=((8.0, 2.3, 2.8), (18.8, 2.6, 3.5))),
    }),
    (_large(
        "tram", _class_sizes("train", _MACHINE), "train", precedence=11, lane_length=38.0, surfaces=("road", "median"),
    ), {
        "tram": Kind(buses.tram, ("train",), extents=((14.0, 2.2, 3.2), (60.0, 2.7, 3.9))),
    }),
    (_vehicle(
        "motorcycle", _class_sizes("motorcycle", _TWO_WHEELER), "motorcycle", family="people",
        surfaces=("road", "sidewalk"), is_ridden=True,
    ), {
        "motorcycle": Kind(motorcycles.motorcycle, ("motorcycle",), extents=((1.8, 0.6, 1.05), (2.4, 0.9, 1.3))),
        "motorcyclist": Kind(
            motorcycles.motorcyclist, ("rider", "motorcycle"), shapes=coarse.motorcyclist,
            extents=((1.9, 0.65, 1.4), (2.4, 0.9, 1.75))
        ),
    }),
    (_thing(
        "bicycle", _class_sizes("bicycle", _TWO_WHEELER), "bicycle", family="people", counts=CountRanges(),
        cycles=True, is_ridden=True,
    ), {
        "bicycle": Kind(bicycles.bicycle, ("bicycle",), is_small=True, extents=((1.5, 0.45, 1.0), (2.0, 0.7, 1.15))),
        "cyclist": Kind(
            bicycles.cyclist, ("rider", "bicycle"), shapes=coarse.cyclist,
            extents=((1.6, 0.5, 1.5), (1.95, 0.66, 1.95))
        ),
    }),
    (_thing(
        "person", SizeBetween((0.4, 0.45, 1.5), (0.8, 0.65, 1.9)), "person", family="people",
        counts=CountRanges(many=(6, 9)), walks=True,
    ), {"person": Kind(pedestrians.person, ("person",), extents=((0.2, 0.28, 1.0), (1.0, 0.6, 2.0)))}),
    (_building("house", SizeBetween((8.0, 7.0, 5.0), (13.0, 10.0, 8.5)), precedence=12, setback=(9.0, 12.0, 22.0)), {
        "house": Kind(
            buildings.house, ("building",), shapes=coarse.house, boxes=boxes.house, most_fall=_PLINTH,
            extents=((5.0, 5.0, 4.0), (40.0, 20.0, 14.0))
        ),
    }),
    (_building(
        "building", SizeBetween((12.0, 10.0, 9.0), (22.0, 14.0, 20.0)), precedence=13, setback=(8.0, 11.0, 24.0)
    ), {
        "block": Kind(
            buildings.block, ("building",), boxes=boxes.block, most_fall=_PLINTH,
            extents=((5.0, 5.0, 3.5), (60.0, 40.0, 60.0))
        ),
    }),
    (_plant(
        "tree", SizeBetween((2.8, 2.8, 5.0), (5.0, 5.0, 10.0)), family="trees", surfaces=_ANYWHERE,
        shapes=sample_tree, precedence=1, setback=(1.3, 3.0, 14.0),
    ), {
        "tree": Kind(
            plants.tree, ("trunk", "vegetation"), shapes=coarse.tree, boxes=boxes.tree,
            extents=((0.8, 0.8, 1.5), (20.0, 20.0, 30.0))
        ),
    }),
    (_plant(
        "bush", SizeBetween((0.8, 0.8, 0.7), (2.2, 2.2, 1.8)), family="greenery", surfaces=_ANYWHERE,
        shapes=partial(sample_round, "ellipsoid"), setback=(1.4, 3.0, 10.0),
    ), {"bush": Kind(plants.bush, ("vegetation",), shapes=coarse.bush, is_small=True)}),
    (_plant(
        "garden", SizeBetween((5.0, 1.95, 0.7), (9.0, 2.2, 1.2)), shapes=sample_garden, precedence=2,
        setback=(0.6, 1.0, 4.0),
    ), {}),
    (_strip(
        "hedge", SizeBetween((6.0, 0.6, 0.9), (16.0, 1.2, 2.0)), "vegetation", family="greenery", precedence=3,
        setback=(0.9, 1.2, 5.0),
    ), {"hedge": Kind(plants.hedge, ("vegetation",), extents=((0.6, 0.3, 0.4), (60.0, 4.0, 5.0)))}),
    (_enclosure(
        "fence", SizeBetween((10.0, 0.06, 0.9), (30.0, 0.15, 1.8)), "fence", precedence=4, setback=(0.4, 0.8, 5.0)
    ), {
        "fence": Kind(fences.fence, ("fence",), extents=((0.6, 0.05, 0.4), (60.0, 0.4, 3.0))),
        "mesh_fence": Kind(fences.mesh_fence, ("fence",), is_small=True, extents=((1.0, 0.05, 0.6), (60.0, 0.4, 3.0))),
        "overgrown_fence": Kind(fences.overgrown_fence, ("fence", "vegetation"), is_small=True),
        "barrier": Kind(fences.barrier, ("fence",), is_small=True),  # the packaged weights know it as a fence
    }),
    (_enclosure(  # of steel or, from 0.8 m on, of concrete
        "barrier", SizeBetween((10.0, 0.3, 0.7), (30.0, 0.6, 0.9)), "fence", precedence=4, setback=(0.4, 0.8, 5.0)
    ), {}),
    (_enclosure(
        "wall", SizeBetween((10.0, 0.2, 1.5), (30.0, 0.4, 3.0)), "wall", precedence=5, setback=(0.5, 0.9, 5.0)
    ), {
        "wall": Kind(fences.wall, ("wall",), extents=((1.0, 0.1, 0.7), (60.0, 1.0, 8.0))),
        "garden_wall": Kind(fences.garden_wall, ("wall", "fence"), extents=((0.5, 0.1, 0.35), (60.0, 0.8, 1.6))),
    }),
    (_pole("pole", SizeBetween((0.1, 0.1, 2.5), (0.2, 0.2, 5.0)), "pole", shapes=partial(sample_round, "cylinder")), {
        "pole": Kind(
            poles.pole, ("pole",), shapes=coarse.mast, is_small=True, on_pole=True,
            extents=((0.03, 0.03, 0.3), (1.0, 1.0, 15.0))
        ),
    }),
    (_pole("street-light", SizeBetween((0.3, 1.2, 6.0), (0.3, 1.2, 8.5)), "pole", shapes=sample_street_light), {
        "lamp": Kind(poles.lamp, ("pole",), shapes=coarse.mast, boxes=boxes.lamp, is_small=True, on_pole=True),
    }),
    (_pole(
        "traffic-light", SizeBetween((0.35, 0.35, 3.1), (0.35, 0.35, 3.9)), "traffic-light",
        shapes=sample_traffic_light, counts=CountRanges((1, 2), (2, 2), (3, 4)), is_square=True, at_junction=True,
    ), {
        "traffic_light": Kind(
            poles.traffic_light, ("pole", "traffic-light"), shapes=coarse.traffic_light, is_small=True,
            on_pole=True, extents=((0.2, 0.25, 1.0), (0.6, 0.6, 6.0))
        ),
    }),
    (_pole(
        "traffic-sign", SizeBetween((0.145, 0.6, 2.0), (0.145, 0.9, 2.6)), "traffic-sign", is_square=True,
        shapes=sample_traffic_sign,
    ), {
        "sign": Kind(
            signs.sign, ("pole", "traffic-sign"), shapes=coarse.sign, boxes=boxes.sign, is_small=True,
            on_pole=True, extents=((0.05, 0.3, 0.5), (0.4, 4.0, 6.0))
        ),
    }),
    (_furniture("bin", SizeBetween((0.5, 0.5, 0.9), (0.8, 0.7, 1.2))), {
        "bin": Kind(furniture.bin, ("other",), is_small=True, extents=((0.35, 0.35, 0.6), (1.3, 1.4, 1.5))),
    }),
    (_furniture("bench", SizeBetween((1.4, 0.5, 0.75), (1.9, 0.6, 0.9)), setback=(0.7, 1.0, 3.0)), {
        "bench": Kind(furniture.bench, ("other",), is_small=True, extents=((1.0, 0.4, 0.65), (3.0, 0.9, 1.1))),
    }),
    (_furniture("shelter", SizeBetween((2.6, 1.2, 2.3), (5.0, 1.8, 2.8)), precedence=3, setback=(0.8, 1.1, 3.0)), {
        "shelter": Kind(furniture.shelter, ("other",), extents=((2.4, 1.1, 2.2), (7.0, 2.2, 3.0)), unsaid=True),
    }),
    (_thing("box", SizeBetween((0.5, 0.4, 0.4), (0.7, 0.6, 0.6)), "other", set_down=True), {}),
    (_thing("animal", SizeBetween((1.8, 0.5, 1.3), (2.3, 0.7, 1.6)), "other", shapes=sample_animal, walks=True), {}),
    (_vehicle("trailer", SizeBetween((3.0, 1.8, 1.6), (6.0, 2.3, 2.6)), "other", precedence=5), {}),
    # 0.75 m for motorways and 0.5 m for other roads in the German rules for road works (RSA 21)
    (_thing("cone", SizeBetween((0.28, 0.28, 0.5), (0.4, 0.4, 0.75)), "other", shapes=sample_cone, set_down=True), {
        "cone": Kind(furniture.cone, ("other",), is_small=True, unsaid=True),
    }),
    (None, {
        "shed": Kind(buildings.shed, ("building",), most_fall=_PLINTH, extents=((2.4, 2.4, 2.2), (30.0, 20.0, 6.0))),
        "ground_cover": Kind(plants.bush, ("vegetation",), shapes=coarse.bush, is_small=True),
        "grass": Kind(plants.grass, ("terrain",), shapes=lambda _: [], most_fall=0.0),
        "gantry": Kind(signs.gantry, ("pole", "traffic-sign"), shapes=coarse.gantry, boxes=boxes.gantry, on_pole=True),
        "billboard": Kind(signs.billboard, ("other",), shapes=coarse.billboard, boxes=boxes.billboard, on_pole=True),
        "letterbox": Kind(furniture.letterbox, ("other",), is_small=True),
        "hydrant": Kind(furniture.hydrant, ("other",), is_small=True),
        "crate": Kind(furniture.crate, ("other",), is_small=True),
        "plant_tub": Kind(furniture.plant_tub, ("other", "vegetation"), is_small=True),
        "cafe_table": Kind(furniture.cafe_table, ("other",), is_small=True),
        "cabinet": Kind(furniture.cabinet, ("other",), is_small=True, extents=((0.25, 0.5, 0.7), (0.6, 2.5, 1.8))),
    }),
)  # fmt: skip
SENTENCE_KINDS: dict[str, SentenceKind] = {said.name: said for said, _ in _TABLE if said}
KINDS: dict[str, Kind] = {
    name: replace(kind, word=None if said is None or kind.unsaid else said.name)
    for said, kinds in _TABLE
    for name, kind in kinds.items()
}
# How often a sentence about a street names each family of kinds.
FAMILIES = {
    "people": 0.85, "buildings": 0.9, "trees": 0.9, "greenery": 0.6, "enclosures": 0.6, "poles": 0.5, "furniture": 0.4
}  # fmt: skip


def kind_of(name: str) -> Kind:
    """The kind of that name; raises `LayoutError` if there is none."""
    try:
        return KINDS[name]
    except KeyError:
        raise LayoutError(f"kind is {name!r}; it must be {one_of(KINDS, name)}") from None
