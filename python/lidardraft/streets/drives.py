"""Drives through procedural streets, in which everything moves: a seed and a number become a sequence."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from lidardraft.errors import LayoutError, check_number, check_seed
from lidardraft.scene.edit import placed
from lidardraft.scene.layout import Layout
from lidardraft.scene.pose import place_around, upright
from lidardraft.scene.street import MAIN_ROAD
from lidardraft.streets.coarse.coarse_layout import BoxStyle, as_boxes
from lidardraft.streets.ego import EGO_SPACE
from lidardraft.streets.street import Street, StreetConfig, make_street

if TYPE_CHECKING:
    from lidardraft.simulation.motion.sequence import SequenceSimulator

HALF_LENGTH = 200.0  # m, for streets of drives
_STREAM = 2  # random numbers of a drive, apart from those of its street
_FIRST, _LAST, _STEP = 15.0, 120.0, 2.5  # m from the start of its lane to that of the ego vehicle, and between tries


def street_drive(
    number: int,
    *,
    seed: int = 0,
    config: StreetConfig | None = None,
    frames: int = 100,
    hz: float = 10.0,
    carrier: bool | Layout = True,
    threads: int | None = None,
) -> SequenceSimulator:
    """Drive `number` of a seed: `frames` scans, `hz` a second, of the ego vehicle along its own street, among traffic
    and people.

    `config` is the composition of streets, by default streets of 400 m; `poses_per_street` has no effect. The layout of
    a scan holds simple shapes on the ground with its relief; the detailed street is scanned, from a `carrier` as in
    `simulate`. The same arguments give the same scans. Raises `LayoutError` for a number that is negative or no
    integer, and if the ego vehicle reaches the end of its street before the last frame.
    """
    from lidardraft.simulation.motion.sequence import SequenceSimulator  # pictures come with it

    seed, number = check_seed(seed), check_number("number", number)
    config = config or StreetConfig(half_length=HALF_LENGTH)
    street = make_street(seed=seed, config=config, number=number)
    rng = np.random.default_rng([seed, number, _STREAM])
    pose, left = _start(street, rng)
    provenance = {"source": "streets", "seed": seed, "number": number, "district": street.district}
    shapes = as_boxes(street.coarse, BoxStyle(relief=True), pose, reach=math.inf)
    layout = street.with_roads(shapes.layout(provenance, intent=street.scene.intent), pose, relief=True)
    simulator = SequenceSimulator(
        layout,
        config.sensor,
        scene=_seen_from(pose, street.scene),
        frames=frames,
        hz=hz,
        seed=int(rng.integers(2**31)),
        model=replace(config.sensor.assumed_model, unit=number),
        weather=config.weather,
        carrier=carrier,
        threads=threads,
    )
    driven = float(np.hypot(*np.diff(simulator.tracks.ego.places[:, :2], axis=0).T).sum())
    if driven > left - EGO_SPACE[0]:
        raise LayoutError(f"drive {number}: after {driven:.0f} m the street ends; ask for fewer frames or more hz")
    return simulator


def _start(street: Street, rng: np.random.Generator) -> tuple[np.ndarray, float]:
    """The start of the ego vehicle, street_from_ego [4, 4], and the rest of its lane [m]."""
    lanes = [lane for lane in street.lanes if lane.kind == MAIN_ROAD]
    road, ground = street.occupancy.road, street.occupancy.ground
    for number in rng.permutation(len(lanes)).tolist():
        lane = lanes[number]
        for distance in np.arange(rng.uniform(_FIRST, _LAST / 2), min(_LAST, lane.length / 2), _STEP).tolist():
            along, across, angle = lane.at(distance)
            x, y, heading = road.at(along, across)
            if street.occupancy.is_free(x, y, heading + angle, EGO_SPACE):
                height = float(ground.heights(np.array([along]), np.array([across]))[0])
                return upright((x, y, height), heading + angle), lane.length - distance
    raise LayoutError(f"street {street.number} has no free place on its road where a drive could begin")


def _seen_from(pose: np.ndarray, scene: Layout) -> Layout:
    """The scene in the upright frame at `pose`."""
    x, y, z = pose[:3, 3].tolist()
    there = placed(scene, place_around((x, y, float(np.arctan2(pose[1, 0], pose[0, 0])))))
    lowered = (replace(part, center=(*part.center[:2], part.center[2] - z)) for part in there)
    return replace(scene, primitives=tuple(lowered))
