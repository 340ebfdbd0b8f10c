"""The street around a layout: the layout stays as it is, and a street of its district fills in around it."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Iterator, Sequence

import numpy as np

from lidardraft.arranging.district import District, only_district, setting
from lidardraft.arranging.ground import Ground
from lidardraft.arranging.occupancy import Occupancy
from lidardraft.arranging.plan import Frame, fill, greened, sample_lights
from lidardraft.arranging.street_mix import StreetMix, applied
from lidardraft.arranging.traffic import EGO_ROOM
from lidardraft.errors import LayoutError, check_choice, check_seed, check_type
from lidardraft.objects.kinds import KINDS, SENTENCE_KINDS, kind_of
from lidardraft.objects.mesh import quads
from lidardraft.objects.placed_object import PlacedObject
from lidardraft.scene.check import EGO_SIZE, SIZE_RANGES, VEHICLE_LABELS, LayoutGround, objects
from lidardraft.scene.edit import placed
from lidardraft.scene.intent import Intent
from lidardraft.scene.layout import AROUND, MOST_PRIMITIVES, Layout, Primitive
from lidardraft.scene.pose import in_frame, place_around
from lidardraft.scene.relief import Relief
from lidardraft.scene.road import KERB_HEIGHT, SIDES, Road
from lidardraft.scene.road_network import RoadNetwork
from lidardraft.scene.road_surfaces import road_surfaces
from lidardraft.scene.solids import Solid, Solids
from lidardraft.scene.street import StreetFrame
from lidardraft.semantics import BY_NAME
from lidardraft.simulation.around.land import drawn_relief
from lidardraft.simulation.around.lines_of_sight import SENSOR, LinesOfSight
from lidardraft.simulation.roads import NoStreetError, with_roads

_STREAM = 5  # of random numbers, apart from those that made the layout
# Shares of districts of a street that the layout says nothing of, by its lanes each way: estimates.
_NARROW = {"residential": 0.55, "urban": 0.25, "avenue": 0.15, "retail": 0.05}
_WIDE = {"urban": 0.35, "avenue": 0.5, "retail": 0.15}
# Factors of the district's traffic and people, by the activity that was asked for: estimates.
_ACTIVITY = {"busy": StreetMix(traffic=2.5, people=2.5), "quiet": StreetMix(traffic=0.3, people=0.4)}
# Distances that added objects keep [m]: estimates.
_GAP = 0.3  # to all objects that were asked for
_OVER = 1.0  # of crowns over those beside the road: on a slope the foot of a tree lies lower
_RIM = 3.0  # twice that of the cores of crowns, whose rims stick out
_AT_HOUSES = {"bicycle", "bin", "letterbox"}
_AHEAD, _ASIDE = 5.0, 1.0  # of traffic along its lane and beside it
_VIEW_PIECE = 8.0  # m of a piece of a picture's field of view
_HUGGED = 0.4  # share of scenes in which traffic may stand right beside the ego vehicle: an estimate
_HIGH = 50.0  # m over and under all objects
_REACH = 112.0  # m, a little less than sensors reach: no objects are added beyond
_OVER_ROAD, _BEYOND = 4.0, 80.0  # m over roads that stay free; m beyond the end of a road
_LARGE = {*VEHICLE_LABELS, "building"}  # classes of objects too large for a slope


def surround(layout: Layout, *, seed: int = 0) -> Layout:
    """The layout with a street around it: buildings, plants, furniture, traffic and people as simple shapes.

    All primitives of the layout stay as they are. Those of the street have ids such as "around/tree_12", and
    `edit.remove(layout, "around/*")` removes them. Objects that a sentence counts or denies are not added. No object
    touches one that was asked for, and lines of sight to these stay open. `intent.around` is the district. Notes name
    objects hidden by others that were asked for, or say why there is no street. `provenance["surroundings"]` has the
    number of objects and the share of open lines of sight.

    Raises `LayoutError` if the seed is invalid or the layout has surroundings already.
    """
    check_type("layout", layout, Layout)
    seed = check_seed(seed)
    if any(primitive.id.startswith(AROUND) for primitive in layout):
        raise LayoutError(f'the layout has surroundings already, the objects "{AROUND}*"')
    rng = np.random.default_rng([seed, _STREAM])
    try:
        layout = with_roads(layout)
        roads, street = _to_fill(layout)
        scene = _Scene(layout, street)
        frame, name = scene.frame(rng)
        fill(frame, rng)
        standing = scene.standing(frame.occupancy.objects)
        around = list(placed([*scene.land(frame.occupancy.ground), *_shapes(standing)], scene.street.place))
        if len(layout) + len(around) > MOST_PRIMITIVES:
            raise NoStreetError(f"no street around it: it would have over {MOST_PRIMITIVES} shapes")
    except NoStreetError as error:
        return layout.noted(str(error))
    intent = dataclasses.replace(layout.intent, around=name)
    street = dataclasses.replace(street, speed=frame.district.speed, lights=frame.street.lights)
    roads = roads.but(street=street, relief=scene.relief(frame.occupancy.ground))
    whole = dataclasses.replace(layout, primitives=(*layout.primitives, *around), intent=intent, roads=roads)
    said = {
        "district": name,
        "seed": seed,
        "objects": len(standing),
        "in_sight": scene.lines_of_sight.share_open(whole),
    }
    hidden = {name: by for name, by in scene.lines_of_sight.hidden.items() if name not in scene.free}
    notes = [f"{name} cannot be seen: {by} stands before it" for name, by in hidden.items()]
    return dataclasses.replace(whole, provenance=layout.provenance | {"surroundings": said}).noted(*notes)


class _Scene:
    """The given part of a street, in the frame of its road; the ego vehicle is there at x, y, yaw `ego`."""

    def __init__(self, layout: Layout, street: StreetFrame) -> None:
        self.street, self.road = street, street.road
        self.ego = place_around(street.place)
        self.paved = [(in_frame(one.place, self.ego), one.size, one.label) for one in street.paved]
        self.intent = layout.intent
        self.given = list(placed(layout, self.ego))
        self.asked = objects(Layout(tuple(self.given)))
        self.coverage = layout.coverage
        is_drawn = self.intent.road is None and self.coverage is None
        self.counted = {p.label for p in layout} if is_drawn else set[str]()
        self.free = {name for name, asked in self.intent.objects.items() if not asked.counted}
        # more of "houses on both sides", or of the objects that "downtown" implies, may stand in front of them
        watched = {
            name for name, some in self.asked.items() if name not in self.free or BY_NAME[some[0].label].is_thing
        }
        self.lines_of_sight = LinesOfSight(layout, watched)

    def frame(self, rng: np.random.Generator) -> tuple[Frame, str]:
        """The frame to fill, with all that was asked for reserved, and the name of its district."""
        road = self.road
        name = self.intent.district or _sample_district(road, self.intent, rng)
        district = setting(name) if name == "alley" else greened(setting(name), rng)
        district = applied(_ACTIVITY.get(str(self.intent.activity), StreetMix()), district)
        district = _beside_lots(district, road)
        paved = bool(rng.random() < district.paved)
        # ditches and rising banks would hide the objects that were asked for
        crossed = self.paved or any(map(self._is_beside, itertools.chain.from_iterable(self.asked.values())))
        land = dataclasses.replace(district.land, ditch=0.0, falling=1.0) if crossed else district.land
        tops = [one.center[2] + one.size[2] / 2 for one in self.given if one.label == "sidewalk"]
        usual = all(math.isclose(top, KERB_HEIGHT) for top in tops)
        ground = Ground(road, rng, land, plain=self.street.plain, paved=paved, kerbs=usual)
        denied = _denied(self.intent, self.counted) | (set() if district.built_up else _AT_HOUSES)
        instances = max((primitive.instance for primitive in self.given), default=0)
        occupancy = Occupancy(road, ground, denied=denied, instances=instances)
        for space in (*self._footprints(rng), *self._view(), *self._beyond_ends()):
            occupancy.reserve(space)
        for place, size, bottom, top in self.lines_of_sight.spaces(_REACH):
            occupancy.reserve(Solid.box(*in_frame(place, self.ego), size, bottom, top))
        for area in road.paved_areas:
            x, y, yaw = road.at(sum(area.along) / 2, sum(area.across) / 2)
            occupancy.reserve(Solid.box(x, y, yaw, (np.ptp(area.along), np.ptp(area.across)), -_HIGH, _OVER_ROAD))
        for place, size, label in self.paved:
            space = Solid.box(*place, size, -_HIGH, _HIGH if label == "sidewalk" else _OVER_ROAD)
            occupancy.keep_public(space) if label == "sidewalk" else occupancy.reserve(space)
        # between buildings a road has parking strips if cars are parked on one side at least
        parked = 1.0 / (2.0 - district.parked) if district.built_up else district.parked
        parking = tuple(side for side in SIDES if road.parking > 0 and rng.random() < parked)
        lights = sample_lights(road, district, rng)
        street = StreetFrame(road=road, speed=district.speed, parked=parking, lights=lights)
        return Frame(district, street, occupancy), name

    def relief(self, ground: Ground) -> Relief | None:
        """The relief of the ground if the layout leaves it open; level under large objects that were asked for beside
        the road."""
        if self.coverage is not None or not any(one.open and one.label == "terrain" for one in self.given):
            return None
        large = (part for parts in self.asked.values() for part in parts if part.label in _LARGE)
        level = (((*part.center[:2], part.yaw), part.size[:2]) for part in filter(self._is_beside, large))
        return drawn_relief(ground, self.street.place, self.ego, level)

    def _is_beside(self, part: Primitive) -> bool:
        return bool(abs(self.road.along_across(*part.center[:2])[1]) > self.road.verge)

    def land(self, ground: Ground) -> Iterator[Primitive]:
        """The missing ground of the layout, and paved yards and driveways beside the road."""
        corners, kinds, across = ground.quads()
        outside = self._is_outside(corners)
        yards = (kinds == 1) & (np.abs(across) > self.road.verge)
        lacks = kinds == (2 if "terrain" in self.street.lacks else -1)
        pieces = {"land": ("terrain", corners[lacks & outside]), "yards": ("sidewalk", corners[yards])}
        if "road" in self.street.lacks:
            flat = corners * (1.0, 1.0, 0.0)
            pieces["road"] = ("road", flat[(kinds == 0) & outside])
            pieces["sidewalks"] = ("sidewalk", flat[(kinds == 1) & ~yards & outside] + np.array([0, 0, KERB_HEIGHT]))
        elif "sidewalk" in self.street.lacks:
            walks = [surface for surface in road_surfaces(self.road) if surface.label == "sidewalk"]
            yield from (dataclasses.replace(walk, id=AROUND + walk.id) for walk in walks)
        pieces["drives"] = ("road", ground.drives())
        for name, (label, quad) in pieces.items():
            if len(quad):
                yield Primitive.from_mesh(*quads(quad), label=label, id=AROUND + name)

    def _footprints(self, rng: np.random.Generator) -> Iterator[Solid]:
        """The space to keep free around the ego vehicle and given objects; for objects on the road, their lane too."""
        length, width, height = EGO_SIZE
        yield Solid.box(*self.ego, (length + 2 * _AHEAD, width + _ASIDE), 0.0, height)
        if rng.random() > _HUGGED:
            yield Solid.box(*self.ego, EGO_ROOM[:2], 0.0, height)
        for primitive in itertools.chain.from_iterable(self.asked.values()):
            x, y, z = primitive.center
            length, width, height = primitive.size
            low, high = z - height / 2, z + height / 2
            over = high + (_OVER if self._is_beside(primitive) else _GAP)
            yield Solid.box(x, y, primitive.yaw, (length + 2 * _GAP, width + 2 * _GAP), low - 1.0, over)
            if high > EGO_SIZE[2]:
                yield Solid.box(x, y, primitive.yaw, (length + _RIM, width + _RIM), max(low, EGO_SIZE[2]), high + _GAP)
            along, across = self.road.along_across(x, y)
            if abs(across) < self.road.edge and low < SENSOR[1]:
                size = (max(length, width) + 2 * _AHEAD, width + 2 * _ASIDE)
                yield Solid.box(x, y, self.road.at(along, across)[2], size, 0.0, SENSOR[1])

    def _view(self) -> Iterator[Solid]:
        """The field of view of a picture: only objects that it shows may stand in it."""
        if self.coverage is None:
            return
        start, end = self.coverage
        heading, half = (start + end) / 2, (end - start) / 2
        for near in np.arange(0.0, _REACH, _VIEW_PIECE).tolist():
            middle, far = near + _VIEW_PIECE / 2, near + _VIEW_PIECE
            place = (middle * math.cos(heading), middle * math.sin(heading), heading)
            yield Solid.box(*place, (_VIEW_PIECE, 2 * far * math.tan(half)), -_HIGH, _HIGH)

    def _beyond_ends(self) -> Iterator[Solid]:
        """The space beyond the ends of a drawn road: its continuation."""
        for end in self.street.ends or ():
            x, y, yaw = self.road.at(end + math.copysign(_BEYOND / 2, end), 0.0)
            yield Solid.box(x, y, yaw, (_BEYOND, 2 * self.road.verge), -_HIGH, _HIGH)

    def standing(self, objects: Sequence[PlacedObject]) -> list[PlacedObject]:
        """The objects within reach of sensors, without vans longer than the cars of `scene.check` and plants whose rims
        touch given objects; those of a drawn layout stand on its ground, which may differ between the sides of the
        road."""
        objects = [one for one in objects if math.dist((one.x, one.y), self.ego[:2]) < _REACH]
        longest = SIZE_RANGES["car"][1][0]
        objects = [one for one in objects if "car" not in kind_of(one.kind).labels or one.size[0] < longest]
        if self.street.ends is not None:
            ground = LayoutGround(self.given)
            objects = [dataclasses.replace(one, z=one.z - one.level + ground.height(one.x, one.y)) for one in objects]
        # plants reserve the cores of their crowns alone
        asked = Solids(map(_around, itertools.chain.from_iterable(self.asked.values())))
        return [one for one in objects if "vegetation" not in kind_of(one.kind).labels or not _meets(one, asked)]

    def _is_outside(self, corners: np.ndarray) -> np.ndarray:
        """The mask [...] of quadrilaterals [..., 4, 3] that the picture does not show."""
        if self.coverage is None:
            return np.ones(corners.shape[:-2], dtype=bool)
        start, end = self.coverage
        seen = (np.arctan2(corners[..., 1], corners[..., 0]) - start) % math.tau < end - start
        outside: np.ndarray = ~seen.any(axis=-1)
        return outside


def _to_fill(layout: Layout) -> tuple[RoadNetwork, StreetFrame]:
    """The roads of a layout, and the street to fill."""
    roads = layout.roads
    if roads is None or roads.street is None:
        raise NoStreetError("no street around it: its roads are those of a map, and only one road can be filled")
    if roads.street.parked is not None:
        raise NoStreetError("no street around it: it is a whole street already")
    return roads, roads.street


def _sample_district(road: Road, intent: Intent, rng: np.random.Generator) -> str:
    """The name of a district that fits such a road."""
    if only := only_district(road, intent.road):
        return only
    shares = _NARROW if road.lanes == 1 else _WIDE
    if any(asked.kind == "house" for asked in intent.objects.values()):
        return "residential"
    return str(rng.choice(list(shares), p=list(shares.values())))


def _beside_lots(district: District, road: Road) -> District:
    """The district, with its buildings behind the parking lots of the road."""
    depth = max((abs(edge) - road.verge for area in road.paved_areas for edge in area.across), default=0.0)
    low, high = district.setback
    return dataclasses.replace(district, setback=(low + depth, high + depth))


def _denied(intent: Intent, counted: set[str]) -> frozenset[str]:
    """The kinds of objects of which one more would contradict the request.

    Sketches and boxes show all their things: no more of the classes `counted` may be added.
    """
    words = set(intent.denied)
    for word in words:
        check_choice("intent: denied: kind", word, SENTENCE_KINDS)
    labels = {SENTENCE_KINDS[word].label for word in words} - {"vegetation", "trunk", "pole", "other"}
    labels |= {label for label in counted if BY_NAME[label].is_thing}
    if "vehicle" in words:
        labels |= set(VEHICLE_LABELS)
    if any(SENTENCE_KINDS[word].is_ridden for word in words):
        labels.add("rider")
    if intent.activity == "empty":
        labels |= {name for name, row in BY_NAME.items() if row.is_thing}
    denied = {name for name, kind in KINDS.items() if {name, kind.word} & words or labels.intersection(kind.labels)}
    return frozenset(denied | {"grass"})  # coarse layouts have no grass


def _meets(one: PlacedObject, solids: Solids) -> bool:
    """Whether the boxes around the coarse shapes of a placed object meet solids."""
    return any(True for shape in _shapes([one]) for _ in solids.touching(_around(shape)))


def _around(part: Primitive) -> Solid:
    """The box around a shape."""
    (x, y, z), (length, width, height) = part.center, part.size
    return Solid.box(x, y, part.yaw, (length, width), z - height / 2, z + height / 2)


def _shapes(standing: Sequence[PlacedObject]) -> Iterator[Primitive]:
    """The coarse shapes of placed objects."""
    for one in standing:
        shapes = [shape for shape in kind_of(one.kind).coarse(one) if shape.lobes in (0, 1)]
        for number, shape in enumerate(shapes):
            id = f"{AROUND}{one.id}.{number}" if number else f"{AROUND}{one.id}"
            yield shape.placed(one.place, one.z, id, one.instance + shape.instance_offset if one.instance else 0)
