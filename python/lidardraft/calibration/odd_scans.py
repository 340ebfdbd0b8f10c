"""Scans by another sensor than most, found before anything is fitted to them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from lidardraft.calibration.beam_table import FEWEST_POINTS, cones, off_cones, returns_of_lasers
from lidardraft.formats.recording import Recording

_MORE_LASERS = 4 / 3  # than another scan of the same unit: the highest ones may see nothing but sky
_LOOKED_AT = 500  # points of each laser to check
_OFF_CONES = math.radians(3.0)  # root mean square; with the right lasers, points lie a tenth as far off


def odd_scans(recordings: Sequence[Recording]) -> dict[int, str]:
    """The reasons of odd scans by number: the sensor of most scans is the usual one, or else that of the first."""
    lasers = [_lasers(one) for one in recordings]
    odd = {}
    for number, (_, off) in enumerate(lasers):
        if not off < _OFF_CONES:
            count = len(lasers[number][0])
            odd[number] = f"its points lie {math.degrees(off):.0f} degrees off the cones of {count} lasers"
    sound = [number for number in range(len(recordings)) if number not in odd]
    reasons = [
        {other: _difference(recordings, lasers, number, other) for other in sound if other != number}
        for number in sound
    ]
    if sound:
        usual = min(range(len(sound)), key=lambda k: sum(reason is not None for reason in reasons[k].values()))
        odd |= {number: reason for number, reason in reasons[usual].items() if reason is not None}
    return odd


def without_rare_lasers(recordings: Sequence[Recording]) -> tuple[list[Recording], list[int]]:
    """The scans without lasers that have too few returns in all scans for a fit, and the rings of these."""
    counts = np.bincount(np.concatenate([one.ring for one in recordings]))
    rare = (counts > 0) & (counts < FEWEST_POINTS)
    if not rare.any() or rare[counts > 0].all():
        return list(recordings), []
    return [_part(one, ~rare[one.ring]) for one in recordings], np.flatnonzero(rare).tolist()


def _part(recording: Recording, kept: np.ndarray) -> Recording:
    def part(values: np.ndarray | None) -> np.ndarray | None:
        return None if values is None else values[kept]

    return replace(
        recording,
        points=recording.points[kept],
        ring=recording.ring[kept],
        intensity=part(recording.intensity),
        label=part(recording.label),
        column=part(recording.column),
    )


def _lasers(recording: Recording) -> tuple[dict[int, float], float]:
    """The elevation of each ring [rad], and the root mean square distance of points from their cones [rad]."""
    rings, laser, out, z = returns_of_lasers([recording], _LOOKED_AT)
    elevations, heights, _ = cones(laser, out, z)
    off = off_cones(laser, out, z, elevations, heights) / np.maximum(np.hypot(out, z), 1.0)
    return dict(zip(rings.tolist(), elevations.tolist(), strict=True)), float(np.sqrt(np.mean(off**2)))


def _difference(
    recordings: Sequence[Recording], lasers: Sequence[tuple[dict[int, float], float]], number: int, other: int
) -> str | None:
    """The difference of scan `other` from scan `number`, in words; None without one."""
    one, found, name = lasers[number][0], lasers[other][0], recordings[number].name
    if len(one) > _MORE_LASERS * len(found) or len(found) > _MORE_LASERS * len(one):
        return f"it has {len(found)} lasers, {name} has {len(one)}"
    both = sorted(one.keys() & found.keys())
    spacing = float(np.median(np.diff(sorted(one.values())))) if len(one) > 1 else math.inf
    aside = float(np.median([abs(found[ring] - one[ring]) for ring in both])) if both else math.inf
    if aside > spacing / 2:
        return f"its lasers look {math.degrees(aside):.2g} degrees past those of {name}" if both else (
            f"none of its rings is one of {name}"
        )  # fmt: skip
    for field in ("intensity", "column"):
        mine, its = (getattr(recordings[each], field) is not None for each in (number, other))
        if mine != its:
            return f"it has {'an' if its else 'no'} {field} of each point, {name} has {'one' if mine else 'none'}"
    return None
