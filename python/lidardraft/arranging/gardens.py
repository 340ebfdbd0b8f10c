"""Private land between the street and the houses: driveways, fences, bins and plants."""

from __future__ import annotations

import math

import numpy as np

from lidardraft.arranging.car_parks import CarPark
from lidardraft.arranging.district import District
from lidardraft.arranging.occupancy import Occupancy
from lidardraft.arranging.sizes import (
    BICYCLE,
    GARDEN_LETTERBOX,
    WHEELED_BIN,
    Size,
    sample_enclosure,
    sample_tree,
)
from lidardraft.objects.cars import sample_car
from lidardraft.scene.road import SIDES, PavedArea

Driveway = tuple[int, float]  # side, and along [m] of its middle

# Driveways. Numbers without a source are estimates, here and below.
_DRIVEWAY = (2.8, 6.0)  # m: a bay with room for a car's doors; RASt 06 wants 5 m before a garage
_DRIVEWAYS, _FEW_DRIVEWAYS = 9.0, 2.5  # mean number a side if all plots are built: with front fences, and without
_DRIVEWAY_ENDS = 0.95  # of the half length of the street, at most
_DRIVEWAY_HEIGHT, _DRIVEWAY_OFF = 1.8, 0.1  # m of free height over one, and m from the verge
_DRIVEWAY_SPACING = 1.5  # widths between the middles of two
_CROSS_SECTION = (0.1, 1.9, 2.4, 6.0)  # m from the verge, at which to look for a ditch or bank
_STEEPEST_DRIVEWAY = 0.5  # m of rise over its length
_WITH_CAR, _CAR_OFF, _CAR_ASKEW = 0.7, 0.5, 0.03  # share with a car, m from the verge to it, rad (deviation)

# Front fences, walls and hedges, in runs of one kind.
_FENCE_OFF = (0.3, 0.9)  # m from the verge
_FENCE_RUN, _RUN_GAP = (8.0, 28.0), (1.2, 4.0)  # m of a run, and between two
_GAP_OFF, _GAP_LENGTH = (0.05, 0.3), 3.0  # m from the verge, and m of a piece, in gaps of a closed front
_FENCE_LENGTH, _LEAST_FENCE, _FENCE_SEAM = 12.0, 1.2, 0.1  # m of a piece: longest, shortest, between two
_GATE, _BEFORE_GATE = 1.7, 4.5  # m from the middle of a gate that stay open, and within which a piece ends at it

# Between plots.
_PLOT, _PLOT_DEPTH, _PLOT_FRONT = (9.0, 24.0), (14.0, 34.0), (0.6, 5.0)  # m along, across, and open at its front
_PLOT_PIECES, _PLOT_RISE = (2.5, 6.0), 0.25  # m of a piece, limits, and m of rise of the ground under it at most

_PARK_FENCED, _PARK_OFF = 0.6, 0.8  # share of the edges of a car park with a fence, and m to it

# Behind the fences.
_YARD_OBJECTS, _FEW_YARD_OBJECTS = 4, 0.5  # mean number if most plots are built, and else
_YARD_SPREAD, _YARD_OFF = 35.0, (0.5, 2.0)  # m along (deviation), m from the verge
_BINS, _LETTERBOXES = 0.5, 0.25  # share; the others are bicycles
_LETTERBOX_OFF, _BICYCLE_ANGLE, _BIN_ANGLE = 0.35, 0.1, (0.0, 3.0)  # m from the verge; rad, deviation; rad

# Shrubs.
_BED_WIDTH, _BED_OFF, _BED_ROOM = (0.8, 2.8), 0.6, 0.7  # m, m from the verge, least m for it
_BED_DEPTH = 0.7  # of the depth of a garden, for beds
_BED, _BED_STEP, _BED_GAP = (
    (1, 5),
    (0.95, 1.3),
    3.0,
)  # shrubs; lengths between; mean m to the next bed
_SHRUB_OVAL, _SHRUB_HEIGHT = (0.9, 1.45), (0.7, 1.3)  # length and height over width
_BED_LINE, _BED_ANGLE = 0.1, 0.15  # m and rad off the line, deviations

# Low plants in beds along the verge, before and behind fences, and before houses: estimates. In SemanticKITTI's
# sequence 00, 9 % of all returns are from plants within 8 m, as many from those under 0.4 m.
_COVER_ENDS, _COVER_BED = 0.5, (4.0, 22.0)  # of the half length; m of a bed
_COVER_GAP = (1.0, 10.0)  # mean m to the next bed, on land and in paved streets
_COVER_OFF, _COVER_DEPTH = (0.05, 0.3), (0.8, 4.0)  # m from the verge, m across a bed
_COVER_LENGTH, _COVER_WIDTH = (2.0, 6.0), (0.6, 2.2)  # m
_COVER_HEIGHT, _TALL_COVER, _TALL = (0.15, 0.45), (0.45, 1.2), 0.5  # m of low beds, m of others, share of these
_COVER_UNEVEN, _COVER_SEAM = (0.6, 1.4), 0.02  # height against the bed's; m between two plants

# Thickets: runs of high shrubs.
_THICKET_BEGINS = (-1.0, 0.7)  # of the half length of the street
_THICKET_OFF, _THICKET_RUN = (1.0, 14.0), (10.0, 60.0)  # m from the verge, m of a run
_THICKET_WIDTH, _THICKET_STEP = (1.6, 4.2), (1.0, 1.1)  # m, lengths between shrubs
_THICKET_LINE, _THICKET_ANGLE = 0.5, 0.12  # m and rad off the line, deviations

# Trees and bushes of gardens, parks and fields.
_GARDEN_SPREAD, _FIELD_SPREAD = 14.0, 28.0  # m from the verge, mean
_TREE_OFF, _FURTHEST_TREE, _TREE_MARGIN = 1.5, 55.0, 0.05  # m from the verge, m across, m
_BUSHES = 1.5  # a tree
_BUSH_ENDS = 0.8  # of the half length of the street, at most
_BUSH_WIDTH, _BUSH_OVAL, _BUSH_HEIGHT = (0.8, 3.6), (0.8, 1.45), (0.6, 1.0)  # m; length and height over width
_BUSH_OFF, _BUSH_NEARER, _FURTHEST_BUSH = 0.6, 0.4, 45.0  # m from the verge; of the spread of trees; m across
_PLANT_ANGLE = (0.0, 3.0)  # rad


def place_driveways(occupancy: Occupancy, district: District, rng: np.random.Generator) -> list[Driveway]:
    """Paved driveways beside houses, most with a car on it."""
    road = occupancy.road
    driveways: list[Driveway] = []
    if not district.front_gardens:
        return driveways
    mean = _DRIVEWAYS if district.front_fences > 0.5 else _FEW_DRIVEWAYS
    for side in SIDES:
        places = rng.uniform(-_DRIVEWAY_ENDS, _DRIVEWAY_ENDS, rng.poisson(mean * district.built))
        for along in np.sort(places) * road.half_length:
            if _has_room(occupancy, side, along, driveways):
                driveways.append((side, float(along)))
                _place_driveway(occupancy, side, along, rng)
    return driveways


def _has_room(occupancy: Occupancy, side: int, along: float, driveways: list[Driveway]) -> bool:
    """Whether a driveway at `along` is free, private, apart from the others and crosses no ditch."""
    road = occupancy.road
    width, depth = _DRIVEWAY
    x, y, yaw = road.at(along, side * (road.verge + depth / 2 + _DRIVEWAY_OFF))
    size = (width, depth, _DRIVEWAY_HEIGHT)
    if not occupancy.is_free(x, y, yaw, size) or not occupancy.is_private(x, y, yaw, size):
        return False
    if any(side == other and abs(along - place) < _DRIVEWAY_SPACING * width for other, place in driveways):
        return False
    across = side * (road.verge + np.array(_CROSS_SECTION))
    rise = occupancy.ground.heights(np.full(len(across), along), across)
    return bool(np.ptp(rise) <= _STEEPEST_DRIVEWAY)


def _place_driveway(occupancy: Occupancy, side: int, along: float, rng: np.random.Generator) -> None:
    road = occupancy.road
    if rng.random() < _WITH_CAR:
        kind, size = sample_car(rng)
        across = side * (road.verge + _CAR_OFF + size[0] / 2)
        angle = (math.pi / 2 if rng.random() < 0.5 else -math.pi / 2) + rng.normal(0.0, _CAR_ASKEW)
        occupancy.place(kind, along, across, size, angle=angle, private=True)
    half, depth = _DRIVEWAY[0] / 2, _DRIVEWAY[1]
    near, far = road.verge, road.verge + depth
    occupancy.add_driveway(PavedArea((along - half, along + half), (near, far) if side > 0 else (-far, -near)))


def place_front_fences(
    occupancy: Occupancy,
    district: District,
    driveways: list[Driveway],
    car_park: CarPark | None,
    rng: np.random.Generator,
) -> None:
    """Fences, walls or hedges before front gardens or in the gaps of a closed front, in runs with gates between, open
    at driveways."""
    road, gardens = occupancy.road, district.front_gardens
    longest = _FENCE_LENGTH if gardens else _GAP_LENGTH
    for side in SIDES:
        if rng.random() > district.front_fences:
            continue
        along, off = -road.half_length, road.verge + rng.uniform(*(_FENCE_OFF if gardens else _GAP_OFF))
        gates = [place for other, place in driveways if other == side]
        if car_park is not None and car_park.side == side:
            gates.append(car_park.gate)
        while along < road.half_length:
            kind, width, height = sample_enclosure(district.green, rng)
            stop = min(along + rng.uniform(*_FENCE_RUN), road.half_length)
            along = _place_fence_run(occupancy, kind, (along, stop), side, off, (width, height), gates, longest)
            along += rng.uniform(*_RUN_GAP)


def _place_fence_run(
    occupancy: Occupancy,
    kind: str,
    span: tuple[float, float],
    side: int,
    off: float,
    section: tuple[float, float],
    gates: list[float],
    longest: float,
) -> float:
    """Pieces of one kind over a span [m along], `off` [m] from the middle of the road, with gaps at the gates.

    `section` is their width and height [m]. Returns their end [m along].
    """
    along, stop = span
    width, height = section
    while along < stop:
        length = min(occupancy.ground.level_length(along, longest), stop - along)
        gate = next((g for g in gates if g - _BEFORE_GATE < along + length and along < g + _GATE), None)
        if gate is not None:
            length = gate - _GATE - along
        if length > _LEAST_FENCE:
            across = side * (off + width / 2)
            size = (length - _FENCE_SEAM, width, height)
            occupancy.place(kind, along + length / 2, across, size, margin=0.0, private=True)
        along = along + length if gate is None else gate + _GATE
    return along


def place_plot_lines(occupancy: Occupancy, district: District, rng: np.random.Generator) -> None:
    """Fences, walls and hedges between plots, from the front to the back, as far as there is room."""
    road = occupancy.road
    if not district.built_up:
        return
    for side in SIDES:
        along = -road.half_length + rng.uniform(*_PLOT)
        while along < road.half_length:
            section = sample_enclosure(district.green, rng)
            span = road.verge + rng.uniform(*_PLOT_FRONT), road.verge + rng.uniform(*_PLOT_DEPTH)
            _place_across(occupancy, section, along, side, span)
            along += rng.uniform(*_PLOT)


def _place_across(
    occupancy: Occupancy, section: tuple[str, float, float], along: float, side: int, span: tuple[float, float]
) -> None:
    """Pieces of a kind, width and height [m] in a line across a side of the road, over a span [m from its middle]."""
    kind, width, height = section
    longest = piece_across(occupancy, side, *_PLOT_PIECES, _PLOT_RISE)
    ends = np.arange(*span, longest)
    heights = occupancy.ground.heights(np.full(len(ends), along), side * ends)
    for middle in ((ends[1:] + ends[:-1]) / 2)[np.abs(np.diff(heights)) < 2 * _PLOT_RISE].tolist():
        size = (longest - _FENCE_SEAM, width, height)
        occupancy.place(kind, along, side * middle, size, angle=math.pi / 2, margin=0.0, private=True)


def place_car_park_fences(
    occupancy: Occupancy, district: District, car_park: CarPark, rng: np.random.Generator
) -> None:
    """Fences, walls and hedges along the back and the ends of a car park."""
    kind, width, height = section = sample_enclosure(district.green, rng)
    ends = car_park.paved_area.along
    near, far = sorted(abs(edge) for edge in car_park.paved_area.across)
    if rng.random() < _PARK_FENCED:
        _place_fence_run(occupancy, kind, ends, car_park.side, far + _PARK_OFF, (width, height), [], _FENCE_LENGTH)
    for along in (ends[0] - _PARK_OFF - width, ends[1] + _PARK_OFF + width):
        if rng.random() < _PARK_FENCED:
            _place_across(occupancy, section, along, car_park.side, (near, far))


def piece_across(occupancy: Occupancy, side: int, least: float, most: float, rise: float) -> float:
    """The length [m] of a piece of fence that rises by `rise` [m] on a side's hillside, from `least` to `most`."""
    slope = abs(float(occupancy.ground.relief.hillside[0 if side > 0 else 1]))
    return max(least, min(most, rise / max(slope, 1e-3)))


def place_yard_objects(occupancy: Occupancy, district: District, rng: np.random.Generator) -> None:
    """Bins, letterboxes, and bicycles behind the fences."""
    road = occupancy.road
    for _ in range(rng.poisson(_YARD_OBJECTS if district.built_up else _FEW_YARD_OBJECTS)):
        side, along = SIDES[int(rng.integers(2))], rng.normal(0.0, _YARD_SPREAD)
        across = side * (road.verge + rng.uniform(*_YARD_OFF))
        pick = rng.random()
        if pick < _BINS:
            size, angle = WHEELED_BIN.sample(rng), rng.uniform(*_BIN_ANGLE)
            occupancy.place("bin", along, across, size, angle=angle, private=True)
        elif pick < _BINS + _LETTERBOXES:
            size, angle = GARDEN_LETTERBOX.sample(rng), -side * math.pi / 2
            across = side * (road.verge + _LETTERBOX_OFF)
            occupancy.place("letterbox", along, across, size, angle=angle, private=True)
        else:
            size, angle = BICYCLE.sample(rng), rng.normal(0.0, _BICYCLE_ANGLE)
            occupancy.place("bicycle", along, across, size, angle=angle, private=True)


def _shrub(width: float, rng: np.random.Generator) -> Size:
    return width * rng.uniform(*_SHRUB_OVAL), width, width * rng.uniform(*_SHRUB_HEIGHT)


def place_shrub_beds(occupancy: Occupancy, district: District, rng: np.random.Generator) -> None:
    """Shrubs in front of the houses, in beds of one kind."""
    road = occupancy.road
    if not district.front_gardens or not district.built_up:
        return
    depth = district.setback[1]
    for side in SIDES:
        along = -road.half_length
        while along < road.half_length:
            width = rng.uniform(*_BED_WIDTH)
            off = rng.uniform(_BED_OFF, max(_BED_ROOM, _BED_DEPTH * depth - width))
            for _ in range(int(rng.integers(*_BED))):
                size = _shrub(width, rng)
                across = side * (road.verge + off + width / 2 + rng.normal(0.0, _BED_LINE))
                angle = rng.normal(0.0, _BED_ANGLE)
                occupancy.place("bush", along + size[0] / 2, across, size, angle=angle, margin=0.0, private=True)
                along += size[0] * rng.uniform(*_BED_STEP)
            along += rng.exponential(_BED_GAP)


def place_ground_cover(occupancy: Occupancy, district: District, rng: np.random.Generator) -> None:
    """Low plants that spread beside sidewalks, in beds of one height."""
    road = occupancy.road
    if road.sidewalk == 0 or not district.built_up:
        return
    for side in SIDES:
        along = -_COVER_ENDS * road.half_length
        while along < _COVER_ENDS * road.half_length:
            stop = along + rng.uniform(*_COVER_BED)
            height = rng.uniform(*(_TALL_COVER if rng.random() < _TALL else _COVER_HEIGHT))
            off, depth = rng.uniform(*_COVER_OFF), rng.uniform(*_COVER_DEPTH)
            while off < depth:
                width = rng.uniform(*_COVER_WIDTH)
                _place_cover_row(occupancy, (along, stop), side * (road.verge + off + width / 2), (width, height), rng)
                off += width
            along = stop + rng.exponential(_COVER_GAP[occupancy.ground.paved])


def _place_cover_row(
    occupancy: Occupancy,
    span: tuple[float, float],
    across: float,
    section: tuple[float, float],
    rng: np.random.Generator,
) -> None:
    """A row of a bed, a span [m along] at `across` [m]; `section` is its width and height [m]."""
    along, stop = span
    while along < stop:
        length = rng.uniform(*_COVER_LENGTH)
        size = (length - _COVER_SEAM, section[0] - _COVER_SEAM, section[1] * rng.uniform(*_COVER_UNEVEN))
        occupancy.place("ground_cover", along + length / 2, across, size, margin=0.0, private=True)
        along += length


def place_thickets(occupancy: Occupancy, district: District, rng: np.random.Generator) -> None:
    """Thickets and runs of them along the backs of gardens, the edges of fields and the verges of roads."""
    road = occupancy.road
    for side in SIDES:
        for _ in range(rng.poisson(district.thickets)):
            along, off = rng.uniform(*_THICKET_BEGINS) * road.half_length, road.verge + rng.uniform(*_THICKET_OFF)
            stop = min(along + rng.uniform(*_THICKET_RUN), road.half_length)
            while along < stop:
                width = rng.uniform(*_THICKET_WIDTH)
                size = _shrub(width, rng)
                across = side * (off + width / 2 + rng.normal(0.0, _THICKET_LINE))
                angle = rng.normal(0.0, _THICKET_ANGLE)
                occupancy.place("bush", along + size[0] / 2, across, size, angle=angle, margin=0.0, private=True)
                along += size[0] * rng.uniform(*_THICKET_STEP)


def place_garden_plants(occupancy: Occupancy, district: District, rng: np.random.Generator) -> None:
    """Trees and bushes of gardens, parks and fields."""
    road = occupancy.road
    spread = _GARDEN_SPREAD if district.built_up else _FIELD_SPREAD
    for _ in range(rng.poisson(district.wild_trees)):
        side, along = SIDES[int(rng.integers(2))], rng.uniform(-1.0, 1.0) * road.half_length
        size, stem = sample_tree(rng)
        across = road.verge + _TREE_OFF + rng.exponential(spread)
        if across < _FURTHEST_TREE:
            angle = rng.uniform(*_PLANT_ANGLE)
            occupancy.place(
                "tree", along, side * across, size, angle=angle, clearance=stem, margin=_TREE_MARGIN, private=True
            )
    for _ in range(rng.poisson(_BUSHES * district.wild_trees)):
        side, along = SIDES[int(rng.integers(2))], rng.uniform(-_BUSH_ENDS, _BUSH_ENDS) * road.half_length
        width = rng.uniform(*_BUSH_WIDTH)
        across = road.verge + _BUSH_OFF + width / 2 + rng.exponential(_BUSH_NEARER * spread)
        size = (width * rng.uniform(*_BUSH_OVAL), width, width * rng.uniform(*_BUSH_HEIGHT))
        if across < _FURTHEST_BUSH:
            angle = rng.uniform(*_PLANT_ANGLE)
            occupancy.place("bush", along, side * across, size, angle=angle, margin=_TREE_MARGIN, private=True)
