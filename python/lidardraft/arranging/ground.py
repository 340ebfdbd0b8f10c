"""The ground of a street: a road with camber and grade, kerbs, sidewalks, ditches, and land that rises and falls."""

from __future__ import annotations

import math

import numpy as np

from lidardraft.arranging.relief import SECTION, Land, Relief
from lidardraft.objects.mesh import quads, stepped_grid
from lidardraft.scene.layout import Primitive
from lidardraft.scene.road import KERB_HEIGHT, TERRAIN_HEIGHT, PavedArea, Road

_RIM = 4.0  # m of land in the square beyond the sidewalk
_RING_SHARES = (0.12, 0.3, 0.6)  # rings between the outermost circle and the square, in shares of the way


class RoundaboutMesh:
    """A mesh of rings [K] by spokes [J + 1] in the frame of a road with a roundabout, in place of a square.

    The square reaches `half` [m] each way from the junction; `offsets` are its lines both ways, from its middle.
    """

    def __init__(self, road: Road) -> None:
        assert road.junction is not None
        assert road.roundabout_radius is not None
        self.road, self._middle, self._radius = road, road.junction, road.roundabout_radius
        outer = road.roundabout_radius + road.sidewalk
        self.half = outer + _RIM
        between = road.verge + 0.5 * (self.half - road.verge)
        half_lines = [0.0, road.edge, road.verge, between, self.half]
        lines = sorted({*half_lines, *(-d for d in half_lines)})
        self.offsets = [d for i, d in enumerate(lines) if i == 0 or d - lines[i - 1] > 1e-3]
        square = self._square()
        heading = np.arctan2(square[:, 1], square[:, 0])
        rings = [np.zeros_like(square)]
        radii = (0.5 * road.island, road.island, road.roundabout_radius, *([outer] if road.sidewalk > 0 else []))
        rings += [self._ring(square, heading, radius) for radius in radii]
        # the land rises or falls most next to the pavement
        rings += [rings[-1] + share * (square - rings[-1]) for share in _RING_SHARES]
        rings.append(square)
        points = np.stack(rings)
        self.along, self.across = points[..., 0] + road.junction, points[..., 1]

    def lines_along(self) -> list[float]:
        """The positions of the square's lines along the road [m]."""
        return [self._middle + d for d in self.offsets]

    def covers(self, along: np.ndarray, across: np.ndarray) -> np.ndarray:
        """Whether points lie in the square."""
        inside: np.ndarray = (np.abs(along - self._middle) < self.half) & (np.abs(across) < self.half)
        return inside

    def middles(self) -> tuple[np.ndarray, np.ndarray]:
        """Points along and across [K - 1, J] within the cells between rings and spokes."""

        def mean(a: np.ndarray) -> np.ndarray:
            inner: np.ndarray = (a[:-1, :-1] + a[1:, :-1] + a[1:, 1:] + a[:-1, 1:]) / 4
            return inner

        return mean(self.along), mean(self.across)

    def kinds(self, along: np.ndarray, across: np.ndarray, kinds: np.ndarray) -> np.ndarray:
        """The kinds of `Ground.kinds` with the island, the lane and the sidewalk around it."""
        road = self.road
        radius = np.hypot(along - self._middle, across)
        # the chord of a ring between two spokes lies a little inside the circle
        kinds = np.where((radius <= self._radius + road.sidewalk) & (kinds != 0), 1 if road.sidewalk > 0 else 2, kinds)
        kinds = np.where(radius <= self._radius, 0, kinds)
        return np.where(radius <= road.island, 3, kinds)

    def _square(self) -> np.ndarray:
        """The lines' ends on the square [J + 1, 2], once around from a corner."""
        lines, half = np.array(self.offsets), np.full(len(self.offsets) - 1, self.half)
        up, down = lines[:-1], lines[:0:-1]
        sides = [(half, up), (down, half), (-half, down), (up, -half)]
        around = np.concatenate([np.stack(side, axis=-1) for side in sides])
        return np.concatenate([around, around[:1]])

    def _ring(self, square: np.ndarray, heading: np.ndarray, radius: float) -> np.ndarray:
        """Points of a circle: on the lines of the roads, else in the directions of the square's points."""
        ring = radius * np.stack([np.cos(heading), np.sin(heading)], axis=-1)
        verge = self.road.verge + 1e-6
        if radius > verge:
            for axis in (0, 1):
                low = np.abs(square[:, axis]) <= verge
                rest = np.sqrt(np.maximum(radius**2 - square[:, axis] ** 2, 0.0)) * np.sign(square[:, 1 - axis])
                ring[low, axis] = square[low, axis]
                ring[low, 1 - axis] = rest[low]
            self._spread(ring, square, radius)
        return ring

    def _spread(self, ring: np.ndarray, square: np.ndarray, radius: float) -> None:
        """Put the points between a side road and a corner half way between them on the circle."""
        turn = np.arctan2(ring[:, 1], ring[:, 0])
        verge = math.asin(self.road.verge / radius)
        low = np.abs(square).min(axis=1)
        between = (low > self.road.verge + 1e-3) & (low < self.half - 1e-3)
        district = np.round(turn[between] / (math.pi / 2)) * (math.pi / 2)
        away = np.sign(turn[between] - district) * (verge + math.pi / 4) / 2
        ring[between] = radius * np.stack([np.cos(district + away), np.sin(district + away)], axis=-1)


# The surfaces of the ground, and their classes.
_SURFACES = ("road", "sidewalk", "terrain", "grass")
_LABELS = ("road", "sidewalk", "terrain", "terrain")
_KERBED = (1, 3)  # of these, the surfaces behind kerbs
_SPACING = 4.5  # m between the stations of a level mesh; the chord of a 110 m bend leaves the arc by 2 cm
_FINE = 3.0  # m between the lines on a road with waves
_COARSER = 0.12  # of their distance from 0, between the lines of a relief
_MARGIN = 36.0  # m of ground behind the ends of the road, for objects there
_BEYOND = (11.0, 16.0, 23.0, 33.0, 48.0, 70.0, 100.0)  # m from the verge, at which the land is sampled
_AROUND = (2.5, 6.0)  # m beyond the square of a roundabout, at which the land is sampled
_INSIDE = 0.8  # of the way to the centre of a bend, at which the land inside ends
_GRASS_DROP = 0.02  # m from a sidewalk down to the grass beside it
_GUTTER = 0.02  # m before a kerb, over which a relief goes down to a lower one
_GARDEN_BEGINS = 0.15  # m from the sidewalk, at which gardens beside a level road have their height
# m, in streets: a kerb over the road, a dropped kerb, and gardens over the sidewalk: estimates
_KERBS, _DROPPED, _GARDENS = (0.0, KERB_HEIGHT), 0.03, (-0.04, 0.08)
_CROSSED = 2.5  # m beside a side road, with kerbs dropped for people who cross
_FAR, _FAR_DROP = 500.0, 0.5  # m, the extents of the land far away, and its depth under the lowest ground
_MEDIAN_GAP = 1.0  # m from the crossing road to the median
_PIECES, _PAVED = 3, 0.04  # pieces of a driveway, and its height [m] over the land
PAINT, COAT = "road-paint", 0.005  # height of markings over the road [m]
_BENT = 4  # pieces of paint along and across a cell of the mesh, which is not flat
# Level pieces, estimates: m off the ground at their ends at most, m of the shortest, m of the longest in bends over
# a curvature, and that curvature [1/m].
_OFF_GROUND, _LEAST_PIECE, _BEND_PIECE, _BEND = 0.12, 3.0, 7.0, 0.002
_FLAT = 1e-3  # slopes under this count as none
_CLOSE = 1.0  # m, a station this near to a fixed line is left out
_NEAR = 1e-6  # m


class Ground:
    """The surface of one street over the road's frame (along, across): its class and height.

    `strip` [m] is the width of the grass between kerb and sidewalk; with `paved` the land beside the street is a
    square or a yard. With the height of a `plain` [m] the ground is level, as in `road_surfaces`, and the relief
    is still to be applied; with `kerbs` it lowers those of a straight road to their own height.
    """

    def __init__(
        self,
        road: Road,
        rng: np.random.Generator,
        land: Land | None = None,
        *,
        strip: float = 0.0,
        paved: bool = False,
        plain: float | None = None,
        kerbs: bool = True,
    ) -> None:
        self.road, self.strip, self.paved, self.plain = road, strip, paved, plain
        self.relief = Relief(road, land or Land(), rng)
        (own,) = rng.spawn(1)
        # lines of a relief follow no kerb in a bend or around a circle
        kerbs = kerbs and (plain is None or (road.curvature == 0 and road.roundabout_radius is None))
        kerb = own.uniform(*_KERBS) if kerbs and road.sidewalk > 0 else KERB_HEIGHT
        garden = own.uniform(*_GARDENS)
        # gardens are about as high as a sidewalk; beside a bare road the land is a little lower
        land_level = kerb + garden if road.sidewalk > 0 else TERRAIN_HEIGHT
        self._levels = np.array([0.0, kerb, land_level, kerb - _GRASS_DROP])
        self._roundabout = None if road.roundabout_radius is None else RoundaboutMesh(road)
        end = road.half_length + _MARGIN
        stations = np.linspace(-end, end, round(2 * end / (_FINE if plain is None else _SPACING)) + 1)
        self._along, self._across = self._lines(stations, plain is None, self._roundabout)
        if plain is None:
            self._lattice = self.relief.heights(self._along[:, None], self._across[None, :])
        else:
            self._lattice = np.zeros((len(self._along), len(self._across)))
        self._drop = self._dropped_at_crossings()
        self.low = float(self._lattice.min())
        self._driveways: list[PavedArea] = []
        self._painted = np.zeros((0, 4))
        self.materials: dict[str, str] = {}

    def reaches(self, along: float, across: float) -> bool:
        """Whether the ground reaches a point."""
        lines, columns = self._along, self._across
        return bool(lines[0] <= along <= lines[-1] and columns[0] <= across <= columns[-1])

    def levels(self, along: np.ndarray, across: np.ndarray) -> np.ndarray:
        """The heights [n] of a coarse layout's flat surfaces at points [n] [m]."""
        kinds = self.kinds(along, across)
        side = np.abs(across)
        walk = np.isin(kinds, (1, 3)) & (side > self.road.edge) & (side <= self.road.verge)
        if self.road.roundabout_radius is not None and self.road.junction is not None:
            # a coarse layout has an island, and no sidewalk around the circle
            off = np.hypot(along - self.road.junction, across)
            walk = (walk & (np.abs(along - self.road.junction) > self.road.roundabout_radius)) | (
                off <= self.road.island
            )
        plain = TERRAIN_HEIGHT if self.plain is None else self.plain
        return np.where(kinds == 0, 0.0, np.where(walk, KERB_HEIGHT, plain))

    def heights(self, along: np.ndarray, across: np.ndarray) -> np.ndarray:
        """The heights [n] of the ground's mesh at points [n] [m]."""
        kinds = self.kinds(along, across)
        level = self._levels[kinds] if self.plain is None else self.levels(along, across)
        row = np.clip(np.searchsorted(self._along, along) - 1, 0, len(self._along) - 2)
        column = np.clip(np.searchsorted(self._across, across) - 1, 0, len(self._across) - 2)
        p = (along - self._along[row]) / (self._along[row + 1] - self._along[row])
        q = (across - self._across[column]) / (self._across[column + 1] - self._across[column])
        p, q = np.clip(p, 0.0, 1.0), np.clip(q, 0.0, 1.0)
        height = _within(self._lattice, row, column, p, q)
        if self.plain is None:
            kerbed = np.isin(kinds, _KERBED)
            height = height - np.where(kerbed, _within(self._drop, row, column, p, q), 0.0)
        if self._roundabout is not None and self.plain is None:
            height = np.where(self._roundabout.covers(along, across), self.relief.heights(along, across), height)
        heights: np.ndarray = level + height
        return heights

    def grade(self, along: float) -> float:
        """The slope of the road along itself."""
        return self.relief.grade(along)

    def level_length(self, along: float, longest: float) -> float:
        """The longest level piece of a fence or rail at `along` [m]: short ones follow bends and slopes."""
        limit = min(longest, _BEND_PIECE) if abs(self.road.curvature) > _BEND else longest
        return max(_LEAST_PIECE, min(limit, 2 * _OFF_GROUND / max(abs(self.grade(along)), _FLAT)))

    def add_driveway(self, area: PavedArea) -> None:
        """Pave a driveway, a little over the land, and drop the kerb before it."""
        self._driveways.append(area)
        (low, high), side = area.along, np.sign(sum(area.across))
        rows = (self._along >= low - _FINE / 2) & (self._along <= high + _FINE / 2)
        self._drop[np.ix_(rows, np.isclose(self._across, side * self.road.edge))] = self._most_dropped

    def paint(self, spans: np.ndarray) -> None:
        """Add painted rectangles [n, 4] to the surfaces: from and to along, from and to across [m]."""
        self._painted = np.concatenate([self._painted, spans])

    def quads(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The cells around a level road: corners f64 [n, m, 4, 3] on the land, `kinds` and middles across [n, m]."""
        assert self.plain is not None
        along, across = self._along, self._across
        middle = np.meshgrid((along[1:] + along[:-1]) / 2, (across[1:] + across[:-1]) / 2, indexing="ij")
        xy = self.road.points(along[:, None], across[None, :])
        corner = np.concatenate([xy, (self._lattice + self.plain)[..., None]], axis=-1)
        corners = np.stack([corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]], axis=2)
        kinds = self.kinds(*middle)
        corners[kinds == 1, :, 2] += _PAVED / 2  # pavement lies a little over the land
        return corners, kinds, middle[1]

    def surfaces(self) -> list[Primitive]:
        """The ground as one mesh a class, and the land far away as a plane."""
        along, across = self._along, self._across
        middle = np.meshgrid((along[1:] + along[:-1]) / 2, (across[1:] + across[:-1]) / 2, indexing="ij")
        kinds = self.kinds(*middle)
        hidden = None if self._roundabout is None else self._roundabout.covers(*middle)
        xy = self.road.points(along[:, None], across[None, :])
        pieces = [_cells(kinds, self._levels, xy, self._lattice, hidden, self._drop)]
        if self._roundabout is not None:
            s, d = self._roundabout.along, self._roundabout.across
            inner = self.kinds(*self._roundabout.middles())
            heights = self.relief.heights(s, d)
            pieces.append(_cells(inner, self._levels, self.road.points(s, d), heights, None, 0.0 * heights))
        size = (_FAR, _FAR, 0.0)
        far = Primitive(shape="plane", center=(0.0, 0.0, self.low - _FAR_DROP), size=size, label="terrain", id="far")
        primitives = [far]
        corners = np.concatenate([corners for corners, _ in pieces])
        owners = np.concatenate([owner for _, owner in pieces])
        for number, name in enumerate(_SURFACES):
            mine = corners[owners == number]
            if len(mine):
                label, material = _LABELS[number], self.materials.get(_LABELS[number])
                primitives.append(Primitive.from_mesh(*quads(mine), label=label, id=name, material=material))
        if len(self._painted):
            corners = self._coat(self._painted)
            primitives.append(Primitive.from_mesh(*quads(corners), label="road", id="markings", material=PAINT))
        if self._driveways:
            primitives.append(Primitive.from_mesh(*quads(self.drives()), label="sidewalk", id="drives"))
        return primitives

    def _coat(self, spans: np.ndarray) -> np.ndarray:
        """Corners [Q, 4, 3] of painted rectangles, cut at the lines of the mesh so that they lie on it."""
        for axis, lines in enumerate((self._along, self._across)):
            number = np.arange(len(lines))
            finer = np.interp(np.linspace(0, number[-1], _BENT * number[-1] + 1), number, lines)
            spans = cut(spans, finer, axis)
        along, across = spans[:, [0, 1, 1, 0]], spans[:, [2, 2, 3, 3]]
        height = self.heights(along.ravel(), across.ravel()).reshape(along.shape)
        return np.concatenate([self.road.points(along, across), (height + COAT)[..., None]], axis=-1)

    def drives(self) -> np.ndarray:
        """Corners [Q, 4, 3] of the driveways, each in pieces that follow the land."""
        ends = np.array([(area.along, area.across) for area in self._driveways]).reshape(-1, 2, 2)
        lines = np.linspace(ends[:, 1, 0], ends[:, 1, 1], _PIECES + 1, axis=-1)
        if self.plain is not None:  # beside a level road the land has its height from here on
            begins = np.copysign(self.road.verge + _GARDEN_BEGINS, lines[:, :1])
            lines = np.sort(np.concatenate([lines, begins], axis=1))
        across = np.stack([lines[:, :-1], lines[:, 1:], lines[:, 1:], lines[:, :-1]], axis=-1)
        along = np.broadcast_to(ends[:, 0, [0, 0, 1, 1]][:, None], across.shape)
        height = self.heights(along.ravel(), across.ravel()).reshape(across.shape)
        # the rim lies at the verge, at which the land begins
        corners = np.concatenate([self.road.points(along, across), (height + _PAVED)[..., None]], axis=-1)
        return corners.reshape(-1, 4, 3)

    def kinds(self, along: np.ndarray, across: np.ndarray) -> np.ndarray:
        """Indices into road, sidewalk, terrain and grass (between kerb and sidewalk, or in the median)."""
        road = self.road
        side = np.abs(across)
        kinds = np.where(side <= road.edge, 0, np.where(side <= road.verge, 1, 2))
        if self.strip > 0:
            kinds = np.where((side > road.edge) & (side <= road.edge + self.strip), 3, kinds)
        if self.paved:
            kinds = np.where((side > road.verge) & (side <= road.verge + _BEYOND[0]), 1, kinds)
        off = np.inf if road.junction is None else np.abs(along - road.junction)
        if road.median > 0:
            kinds = np.where((side < road.median / 2) & (off > road.edge + _MEDIAN_GAP), 3, kinds)
        if road.junction is not None:
            for side in road.side_roads:
                here = (across > road.edge) if side > 0 else (across < -road.edge)
                if self.paved:
                    kinds = np.where(here & (off <= road.verge + SECTION[-1]) & (kinds > 1), 1, kinds)
                kinds = np.where(here & (off <= road.verge) & (kinds > 1), 1, kinds)
                kinds = np.where(here & (off <= road.edge), 0, kinds)
        for area in road.paved_areas:
            within = (along >= area.along[0]) & (along <= area.along[1])
            kinds = np.where(within & (across >= area.across[0]) & (across <= area.across[1]), 0, kinds)
        if self._roundabout is not None:
            kinds = self._roundabout.kinds(along, across, kinds)
            if self.paved:
                kinds = np.where(self._roundabout.covers(along, across) & (kinds == 2), 1, kinds)
        if self.plain is not None:
            kinds = np.where(np.abs(along) > road.half_length, 2, kinds)
        return kinds

    @property
    def _most_dropped(self) -> float:
        """The height of a kerb over a dropped kerb [m]."""
        return max(0.0, float(self._levels[1]) - _DROPPED)

    def _dropped_at_crossings(self) -> np.ndarray:
        """The drop [m] of the sidewalks at each point of the mesh: at the corners of side roads."""
        road, drop = self.road, np.zeros_like(self._lattice)
        if road.junction is None or road.roundabout_radius is not None or road.sidewalk == 0 or self.plain is not None:
            return drop
        off = np.abs(self._along - road.junction)
        for side in road.side_roads:
            out, far = side * self._across, road.verge + _CROSSED
            corner = (off >= road.edge - _NEAR) & (off <= far)
            drop[np.ix_(corner, np.isclose(out, road.edge))] = self._most_dropped
            drop[np.ix_(np.isclose(off, road.edge), (out >= road.edge - _NEAR) & (out <= far))] = self._most_dropped
        return drop

    def relief_lines(self) -> tuple[np.ndarray, np.ndarray]:
        """Lines along and across [m] between which the relief is nearly even."""
        road = self.road
        along, across = self._lines(graded(road.half_length + _MARGIN), True, None)
        rims = np.array([road.edge - _GUTTER, road.verge + _GARDEN_BEGINS])
        if road.junction is not None:
            along = np.concatenate([along, road.junction - rims[:1], road.junction + rims[:1]])
        return _distinct(along), _distinct(np.concatenate([across, -rims, rims]))

    def rises(self, along: np.ndarray, across: np.ndarray) -> np.ndarray:
        """The rise [m] of a relief over level ground at points that broadcast; kerbs get their own height, and gardens
        become as high as sidewalks."""
        step = self._levels[2] - (TERRAIN_HEIGHT if self.plain is None else self.plain)
        begins = np.minimum(self.relief.away(along, across) / _GARDEN_BEGINS, 1.0)
        middle = 0.0 if self.road.junction is None else self.road.junction
        beside = along + np.copysign(_NEAR, along - middle), across + np.copysign(_NEAR, across)
        behind = (self.kinds(*beside) != 0) & (np.abs(beside[1]) > self.road.edge)
        kerb = np.where(behind, self._levels[1] - KERB_HEIGHT, 0.0)
        heights: np.ndarray = self.relief.heights(along, across) + kerb + (step - kerb) * begins
        return heights

    def _lines(
        self, stations: np.ndarray, fine: bool, roundabout: RoundaboutMesh | None
    ) -> tuple[np.ndarray, np.ndarray]:
        road = self.road
        ways = np.array([road.edge, *([road.edge + self.strip] if self.strip else []), road.verge])
        section = road.verge + np.array(SECTION)
        lines = [d for area in road.paved_areas for d in area.along]
        if roundabout is not None:
            lines += roundabout.lines_along()
            half = roundabout.half
            assert road.junction is not None
            stations = stations[np.abs(stations - road.junction) > half]
        elif road.junction is not None:
            beside = np.concatenate([ways, section])
            lines += [*(road.junction - beside), *(road.junction + beside)]
            if road.median > 0:
                lines += [road.junction - road.edge - _MEDIAN_GAP, road.junction + road.edge + _MEDIAN_GAP]
        fixed = np.array(lines)
        if len(fixed):
            stations = stations[np.abs(stations[:, None] - fixed).min(axis=1) > _CLOSE]
        along = np.concatenate([stations, fixed])
        middle = [road.median / 2] if road.median > 0 else [0.0]
        if fine:
            middle += np.arange(middle[0] + _FINE, road.edge - _CLOSE, _FINE).tolist()
        half_lines = np.concatenate([middle, ways, section, road.verge + np.array(_BEYOND)])
        if roundabout is not None:
            beyond = half_lines[half_lines > roundabout.half + _CLOSE]
            around = roundabout.half + np.array(_AROUND)
            half_lines = np.concatenate([[d for d in roundabout.offsets if d >= 0.0], around, beyond])
        # the land inside a bend ends before the bend's centre
        if road.curvature:
            half_lines = half_lines[half_lines < _INSIDE / abs(road.curvature)]
        across = np.concatenate([-half_lines, half_lines, [d for area in road.paved_areas for d in area.across]])
        return _distinct(along), _distinct(across)


def graded(reach: float) -> np.ndarray:
    """Lines [m] on either side of 0, up to `reach` or a little more, sparser further away."""
    lines = [0.0]
    while lines[-1] < reach:
        lines.append(lines[-1] + max(_FINE, _COARSER * lines[-1]))
    return np.array([*(-line for line in lines[:0:-1]), *lines])


def _distinct(lines: np.ndarray) -> np.ndarray:
    lines = np.sort(lines)
    return lines[np.concatenate([[True], np.diff(lines) > 1e-3])]


def _within(lattice: np.ndarray, row: np.ndarray, column: np.ndarray, p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Heights [n] at the shares p, q of cells of a lattice, on the two triangles of each cell in `quads`."""
    here, after = lattice[row, column], lattice[row + 1, column + 1]
    ahead, beside = lattice[row + 1, column], lattice[row, column + 1]
    return here + np.where(p >= q, p * (ahead - here) + q * (after - ahead), q * (beside - here) + p * (after - beside))


def _cells(
    kinds: np.ndarray,
    levels: np.ndarray,
    xy: np.ndarray,
    relief: np.ndarray,
    hidden: np.ndarray | None,
    drop: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Corners [Q, 4, 3] and kind [Q] of the cells [n, m] over a lattice [n + 1, m + 1], and of the steps between.

    Surfaces behind kerbs are lower by `drop` at the points of the lattice.
    """
    rows, columns = (np.arange(n + 1.0) for n in kinds.shape)
    corners, cell = stepped_grid(rows, columns, levels[kinds])
    if hidden is not None:
        corners, cell = corners[~hidden.ravel()[cell]], cell[~hidden.ravel()[cell]]
    row, column = corners[..., 0].astype(np.intp), corners[..., 1].astype(np.intp)
    owners = kinds.ravel()[cell]
    on_top = np.isin(owners, _KERBED)[:, None] & (corners[..., 2] == levels[owners][:, None])
    height = relief[row, column] + corners[..., 2] - np.where(on_top, drop[row, column], 0.0)
    return np.concatenate([xy[row, column], height[..., None]], axis=-1), owners


def cut(spans: np.ndarray, lines: np.ndarray, axis: int) -> np.ndarray:
    """Spans [n, 4] cut at sorted lines [m]: along (axis 0) or across (1)."""
    low, high = spans[:, 2 * axis], spans[:, 2 * axis + 1]
    first, last = np.searchsorted(lines, low, side="right"), np.searchsorted(lines, high, side="left")
    pieces = last - first + 1
    owner = np.repeat(np.arange(len(spans)), pieces)
    number = np.arange(len(owner)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    after = first[owner] + number
    parts = spans[owner].copy()
    inner, outer = number > 0, number < pieces[owner] - 1
    parts[inner, 2 * axis] = lines[after[inner] - 1]
    parts[outer, 2 * axis + 1] = lines[after[outer]]
    return parts
