"""The ground of a street: a road with a camber, kerbs, sidewalks, and land that rises and falls."""

from __future__ import annotations

import math

import numpy as np

from lidardraft.scene.layout import Primitive
from lidardraft.scene.road import KERB_HEIGHT, TERRAIN_HEIGHT, Road
from lidardraft.streets.solids import quads, stepped_grid

_LEVELS = {"road": 0.0, "sidewalk": KERB_HEIGHT, "terrain": TERRAIN_HEIGHT}
_SURFACES = tuple(_LEVELS)
_SPACING = 3.0  # m between the stations of the mesh
_MARGIN = 36.0  # m that the ground goes on behind the ends of the road, for what stands there
_BEYOND = (0.8, 2.0, 4.0, 7.0, 11.0, 16.0, 23.0, 32.0, 44.0, 60.0, 90.0)  # m from the verge, where the land is sampled
_CAMBER = 0.025  # usual cross fall of a paved road, 2 to 3 %


class Ground:
    """The surface of one street over the road's frame (along, across)."""

    def __init__(self, road: Road, rng: np.random.Generator) -> None:
        self.road = road
        self._camber = rng.uniform(0.0, _CAMBER)
        self._swell = rng.uniform(0.0, 0.05)
        self._rolling = rng.uniform(0.0, 0.4)
        self._slope = rng.normal(0.0, 0.006, 2)
        self._waves = rng.uniform((0.05, -0.12, 0.0), (0.35, 0.12, 2 * math.pi), (5, 3))

    def surface(self, along: float, across: float) -> str:
        """The class of the ground: "road", "sidewalk" or "terrain"."""
        return _SURFACES[int(self._surface(np.array([along]), np.array([across]))[0])]

    def level(self, along: float, across: float) -> float:
        """The height of the flat surface that a drawing has there [m]."""
        return _LEVELS[self.surface(along, across)]

    def height(self, along: float, across: float) -> float:
        """The height of the ground [m]."""
        return self.level(along, across) + float(self._relief(np.array([along]), np.array([across]))[0])

    def surfaces(self) -> list[Primitive]:
        """The ground as one mesh a class, and the land far away as a plane."""
        road = self.road
        along, across = self._lines()
        middle = np.meshgrid((along[1:] + along[:-1]) / 2, (across[1:] + across[:-1]) / 2, indexing="ij")
        surface = self._surface(*middle)
        corners, cell = stepped_grid(along, across, np.array(list(_LEVELS.values()))[surface])
        s, d, level = np.moveaxis(corners, -1, 0)
        xy = positions(road, s, d)
        vertices = np.concatenate([xy, (level + self._relief(s, d))[..., None]], axis=-1)
        far = Primitive(shape="plane", center=(0, 0, -0.6), size=(400, 400, 0), label="terrain", id="far")
        primitives = [far]
        for number, name in enumerate(_SURFACES):
            mine = vertices[surface.ravel()[cell] == number]
            if len(mine):
                primitives.append(Primitive.from_mesh(*quads(mine), label=name, id=name))
        return primitives

    def _lines(self) -> tuple[np.ndarray, np.ndarray]:
        road = self.road
        end = road.reach + _MARGIN
        along = np.linspace(-end, end, round(2 * end / _SPACING) + 1)
        if road.junction is not None:
            along = np.append(along, road.junction + np.array([-road.verge, -road.edge, road.edge, road.verge]))
        half = [0.0, road.edge / 2, road.edge, road.verge, *(road.verge + np.array(_BEYOND))]
        # the land inside a bend ends before the bend's centre
        limit = 0.8 / abs(road.curvature) if road.curvature else math.inf
        across = np.array([d for d in half if d < limit])
        return np.unique(along), np.unique(np.concatenate([-across, across]))

    def _surface(self, along: np.ndarray, across: np.ndarray) -> np.ndarray:
        """Index into `_SURFACES`."""
        road = self.road
        side = np.abs(across)
        surface = np.where(side <= road.edge, 0, np.where(side <= road.verge, 1, 2))
        if road.junction is not None:
            for arm in road.arms:
                here = (across > road.edge) if arm == "left" else (across < -road.edge)
                off = np.abs(along - road.junction)
                surface = np.where(here & (off <= road.verge), np.minimum(surface, 1), surface)
                surface = np.where(here & (off <= road.edge), 0, surface)
        return surface

    def _relief(self, along: np.ndarray, across: np.ndarray) -> np.ndarray:
        """What the ground has over its flat level: camber, swells along the road, land rolling more the further off."""
        road = self.road
        off = np.abs(across)
        if road.junction is not None:
            # beside an arm it is the distance from the arm that counts
            arm = np.isin(np.sign(across), [1.0 if name == "left" else -1.0 for name in road.arms]) & (off > road.edge)
            off = np.where(arm, np.minimum(off, np.maximum(np.abs(along - road.junction), road.edge)), off)
        camber = self._camber * (road.edge / 2 - np.minimum(off, road.edge))
        p, q, phase = self._waves.T
        swell = self._swell * np.sin(p[0] * along) * np.sin(q[0] * along / 3 + phase[1])
        rolling = self._rolling * np.sin(along[..., None] * p + across[..., None] * q + phase).mean(axis=-1)
        away = np.maximum(off - road.verge, 0.0)
        slope = np.where(across > 0, self._slope[0], self._slope[1])
        relief: np.ndarray = camber + swell + np.minimum(away / 15.0, 1.0) * (rolling + slope * away)
        return relief


def positions(road: Road, along: np.ndarray, across: np.ndarray) -> np.ndarray:
    """x, y [..., 2] of points of the road's frame: `Road.at` for arrays."""
    bend, ego = road.curvature, road.lane(0)
    if abs(bend) < 1e-9:
        return np.stack([along, across - ego], axis=-1)
    heading = bend * along
    x = np.sin(heading) / bend - np.sin(heading) * across
    y = (1.0 - np.cos(heading)) / bend + np.cos(heading) * across - ego
    return np.stack([x, y], axis=-1)
