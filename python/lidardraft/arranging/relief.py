"""The relief of the ground over its flat level: grade and crests of the road, camber, short waves, hillsides, ditches,
rolling land.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from lidardraft.scene.road import Road

# m from the verge, at the bends of the land beside a road: shoulder, ditch or foot of a bank, top of the bank.
SECTION = (1.0, 1.9, 2.4, 3.6, 6.5)
_CAMBER = (0.02, 0.03)  # usual cross fall of a paved road
_BANKED = 0.05  # RAL: cross fall in bends up to 7 %
_STEEPEST = 0.06  # RASt 06 and RAL allow 4.5 to 8 %
_DITCH = (0.3, 0.6)  # m deep: the German guide to road drainage (RAS-Ew) has 0.5 m
_BANK = (0.4, 2.2)  # m; slopes of 1 : 1.5 and less (RAL)
_BANKED_EACH = 12.0  # m: cross fall times radius of the bend, up to `_BANKED`: an estimate
# Two waves of crests and sags along the road: the shortest and longest of each [m], since vertical curves of some 100 m
# are usual (RAL), and the steepness of the second against the first, an estimate.
_WAVELENGTHS = ((120.0, 55.0), (320.0, 140.0))
_WAVES = (1.0, 0.45)
# Short waves: their number, the least and longest [m], and the deviation of their slope on one street. ISO 8608 has
# .003 for good roads (class B) and .009 for poor ones (D) at these lengths.
_RIPPLES, _RIPPLE_LENGTHS, _ROUGHNESS = 6, (6.0, 25.0), (0.003, 0.009)
# The land beside the road: estimates.
_STEEPEST_HILL = 0.12
_STREET_HILLS = 1.6  # times `Land.hillside`
_HILL_BEGINS = 20.0  # m from the verge, at which a hillside has half of its slope
_ROLLING = (0.3, 1.0)  # height of its waves, in shares of the district's
_ROLLING_BEGINS = 15.0  # m from the pavement, at which they have their full height
_ROLLING_WAVES = ((0.03, -0.06, 0.0), (0.22, 0.06, 2 * math.pi))  # rad/m along and across, phase: least and most
_MOUND = (0.1, 1.4)  # m, the rise of a roundabout's island to its middle
_CAMBER_BEGINS = 6.0  # m from the circle of a roundabout, at which a road has its full camber and waves
_TOWN_BANK = 0.4  # height of a bank behind a sidewalk against one without
_SHOULDER_DROP = 0.03  # m from the road to its bare shoulder
_FOOT_OF_BANK = 0.35  # of its height at the last but one of `SECTION`


@dataclass(frozen=True, kw_only=True, slots=True)
class Land:
    """The shape of land: `grade` and `hillside` are standard deviations of slopes along and beside the road, `rolling`
    the height [m] of its waves, `ditch` and `bank` probabilities a side; `falling` is the share of banks that fall.
    """

    grade: float = 0.027
    hillside: float = 0.02
    rolling: float = 0.25
    ditch: float = 0.0
    bank: float = 0.0
    falling: float = 0.5


class Relief:
    """Heights over the frame (along, across) of one road, continuous everywhere.

    `hillside` [2] holds the final slopes of the land on the left and on the right, away from the road.
    """

    def __init__(self, road: Road, land: Land, rng: np.random.Generator) -> None:
        self.road = road
        self._camber = rng.uniform(*_CAMBER)
        outside = road.sidewalk == 0.0
        self._bank = (
            math.copysign(min(_BANKED, _BANKED_EACH * abs(road.curvature)), -road.curvature) if outside else 0.0
        )
        self._wavenumbers = 2 * math.pi / rng.uniform(*_WAVELENGTHS)
        self._rise = np.clip(rng.normal(0.0, land.grade, 2) * _WAVES, -0.5 * _STEEPEST, 0.5 * _STEEPEST)
        self._phase = rng.uniform(0.0, 2 * math.pi, 2)
        slopes = rng.normal(0.0, land.hillside, 2) * _STREET_HILLS
        self.hillside = np.clip(slopes, -_STEEPEST_HILL, _STEEPEST_HILL)
        self._sections = np.stack([_section(road, land, rng) for _ in range(2)])
        self._rolling = rng.uniform(*_ROLLING) * land.rolling
        self._waves = rng.uniform(*_ROLLING_WAVES, (3, 3))
        self._mound = rng.uniform(*_MOUND)
        (own,) = rng.spawn(1)
        lengths = np.geomspace(*_RIPPLE_LENGTHS, _RIPPLES)
        heading, self._ripple_phases = own.uniform(0.0, 2 * math.pi, (2, _RIPPLES))
        self._ripples = 2 * math.pi / lengths * np.stack([np.cos(heading), np.sin(heading)])
        self._ripple_heights = own.uniform(*_ROUGHNESS) / math.sqrt(_RIPPLES / 2) * lengths / (2 * math.pi)
        if not outside:  # behind a sidewalk land also falls as often as it rises
            self._sections[:, -2:] *= np.where(own.random(2) < land.falling, -1.0, 1.0)[:, None]

    def grade(self, along: float) -> float:
        """The slope of the road along itself."""
        return float((self._rise * np.cos(self._wavenumbers * along + self._phase)).sum())

    def heights(self, along: np.ndarray, across: np.ndarray) -> np.ndarray:
        """Heights [m] of points whose coordinates broadcast; near 0 at (0, 0)."""
        road = self.road
        side = np.abs(across)
        left = across > 0
        relief = self._profile(along) + self._crossfall(along, across) + self._short_waves(along, across)
        out = np.maximum(side - road.verge, 0.0)
        relief = relief + np.where(left, self.hillside[0], self.hillside[1]) * out * out / (out + _HILL_BEGINS)
        away = self.away(along, across)
        section = np.where(left, self._cut(away, 0), self._cut(away, 1))
        p, q, phase = self._waves.T
        waves = np.sin(along[..., None] * p + across[..., None] * q + phase).mean(axis=-1)
        relief = relief + section + self._rolling * np.minimum(away / _ROLLING_BEGINS, 1.0) * waves
        if road.roundabout_radius is not None and road.junction is not None:
            inward = np.clip(1.0 - np.hypot(along - road.junction, across) / road.island, 0.0, 1.0)
            relief = relief + self._mound * inward * (2.0 - inward)
        return np.asarray(relief)

    def _profile(self, along: np.ndarray) -> np.ndarray:
        height = 0.0
        for rise, wavenumber, phase in zip(self._rise, self._wavenumbers, self._phase, strict=True):
            height = height + rise / wavenumber * (np.sin(wavenumber * along + phase) - math.sin(phase))
        return np.asarray(height)

    def _crossfall(self, along: np.ndarray, across: np.ndarray) -> np.ndarray:
        verge, edge = self.road.verge, self.road.edge
        if self._bank:
            banked: np.ndarray = self._bank * np.clip(across, -verge, verge)
            return banked
        camber = self._camber * (edge / 2 - np.minimum(np.abs(across), edge))
        return np.asarray(camber * self._off_roundabout(along, across))

    def _short_waves(self, along: np.ndarray, across: np.ndarray) -> np.ndarray:
        """Patches, ruts and settlements."""
        p, q = self._ripples
        waves = np.sin(along[..., None] * p + across[..., None] * q + self._ripple_phases) @ self._ripple_heights
        return np.asarray(waves * self._off_roundabout(along, across))

    def _off_roundabout(self, along: np.ndarray, across: np.ndarray) -> np.ndarray | float:
        """0 in a roundabout, which has neither camber nor waves, rising to 1 away from it."""
        if self.road.roundabout_radius is None or self.road.junction is None:
            return 1.0
        off = np.hypot(along - self.road.junction, across) - self.road.roundabout_radius
        return np.asarray(np.clip(off / _CAMBER_BEGINS, 0.0, 1.0))

    def away(self, along: np.ndarray, across: np.ndarray) -> np.ndarray:
        """Distance [m] from the nearest pavement, of points that broadcast."""
        road = self.road
        away = np.abs(across) - road.verge
        if road.junction is not None:
            arm = np.abs(along - road.junction) - road.verge
            for side in road.side_roads:
                here = across > 0 if side > 0 else across < 0
                away = np.where(here, np.minimum(away, arm), away)
            if road.roundabout_radius is not None:
                away = np.minimum(
                    away, np.hypot(along - road.junction, across) - road.roundabout_radius - road.sidewalk
                )
        for area in road.paved_areas:
            ahead = np.maximum(area.along[0] - along, along - area.along[1])
            beside = np.maximum(area.across[0] - across, across - area.across[1])
            away = np.minimum(away, np.maximum(ahead, beside))
        return np.asarray(np.maximum(away, 0.0))

    def _cut(self, away: np.ndarray, side: int) -> np.ndarray:
        return np.interp(away, (0.0, *SECTION), self._sections[side])


def _section(road: Road, land: Land, rng: np.random.Generator) -> np.ndarray:
    """Heights [m] of the land at the verge and at each of `SECTION`: flat, with a ditch, with a bank, or both."""
    ditch = rng.uniform(*_DITCH) if rng.random() < land.ditch else 0.0
    bank = rng.uniform(*_BANK) * (1.0 if road.sidewalk == 0 else _TOWN_BANK) if rng.random() < land.bank else 0.0
    if road.sidewalk == 0 and rng.random() < land.falling:
        bank = -bank
    shoulder = -_SHOULDER_DROP if road.sidewalk == 0 else 0.0
    return np.array([0.0, shoulder, shoulder - ditch, shoulder - ditch, shoulder + _FOOT_OF_BANK * bank, bank])
