"""The plan of one street, drawn from the kind of quarter it lies in."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from lidardraft.scene.road import Road
from lidardraft.streets.arms import build_arms, furnish_arms
from lidardraft.streets.crowd import walk
from lidardraft.streets.gardens import beds, draw_drives, fronts, grow, thickets, yards
from lidardraft.streets.ground import Ground
from lidardraft.streets.lane import Lane, driven_lanes
from lidardraft.streets.lots import Lot, draw_lot, fill_lot
from lidardraft.streets.markings import draw_markings
from lidardraft.streets.plots import build
from lidardraft.streets.quarter import QUARTERS, SIDES, Quarter, draw_road
from lidardraft.streets.relief import Land
from lidardraft.streets.roadside import furnish, plant_island, row_trees, sow
from lidardraft.streets.site import Site
from lidardraft.streets.traffic import drive, park
from lidardraft.streets.works import guard, signal

_NAMES = tuple(QUARTERS)
_GREEN = 0.35  # of the streets between closed fronts, an estimate of ours
_SHARES = np.cumsum([quarter.share for quarter in QUARTERS.values()])


def draw_site(rng: np.random.Generator, reach: float) -> tuple[Site, tuple[Lane, ...], str]:
    """A site with all its things, the lanes that are driven in, and the name of its quarter."""
    name = _NAMES[int(np.searchsorted(_SHARES / _SHARES[-1], rng.random(), side="right"))]
    quarter = QUARTERS[name]
    if quarter.gap[1] == 0.0 and rng.random() < _GREEN:
        # closed fronts behind front gardens
        quarter = replace(quarter, setback=(2.5, 6.0), fronts=0.5, paved=0.0, thickets=1.5)
    parking = tuple(side for side in SIDES if rng.random() < quarter.parked)
    oneway, wants_lot = bool(rng.random() < quarter.oneway), bool(rng.random() < quarter.lot)
    road = draw_road(quarter, parking, reach, rng, oneway=oneway, lot=wants_lot)
    road, lot = _with_lot(road, rng) if wants_lot else (road, None)
    site = Site(road, _ground(road, quarter, rng))
    lights = road.junction is not None and road.circle is None and bool(rng.random() < quarter.lights)
    lanes = driven_lanes(road, quarter, parking, lot, oneway=oneway, lights=lights)
    site.ground.paint(draw_markings(road, lanes, lot, quarter.speed, rng))
    if lights:
        signal(site, rng)
    guard(site, name, rng)
    build(site, quarter, lot, rng)
    build_arms(site, quarter, rng)
    drives = draw_drives(site, quarter, rng)
    fronts(site, quarter, drives, lot, rng)
    furnish(site, quarter, lot, rng)
    row_trees(site, quarter, rng)
    furnish_arms(site, quarter, rng)
    plant_island(site, rng)
    if lot is not None:
        fill_lot(site, lot, rng)
    park(site, parking, lot, rng)
    drive(site, quarter, lanes, rng)
    walk(site, quarter, lights, rng)
    yards(site, quarter, rng)
    beds(site, quarter, rng)
    thickets(site, quarter, rng)
    grow(site, quarter, rng)
    sow(site, rng)
    return site, lanes, name


def _with_lot(road: Road, rng: np.random.Generator) -> tuple[Road, Lot]:
    lot = draw_lot(road, 1 + int(rng.random() < 0.35), rng)
    return replace(road, patches=(lot.patch, lot.access)), lot


def _ground(road: Road, quarter: Quarter, rng: np.random.Generator) -> Ground:
    land = Land(
        grade=quarter.grade,
        hillside=quarter.hillside,
        rolling=quarter.rolling,
        ditch=quarter.ditch,
        bank=quarter.bank,
    )
    strip = rng.uniform(0.35, 0.5) * road.sidewalk if rng.random() < quarter.strip else 0.0
    if road.circle is not None or road.sidewalk < 2.2:
        strip = 0.0
    ground = Ground(road, rng, land, strip=strip, paved=bool(rng.random() < quarter.paved))
    # about a quarter of German motorways are of concrete (BASt); the other shares are estimates of ours
    if road.sidewalk == 0 and road.median > 0 and rng.random() < 0.25:
        ground.materials["road"] = "concrete"
    if road.sidewalk == 0 and rng.random() < 0.2:
        ground.materials["terrain"] = "soil"
    if rng.random() < 0.2:
        ground.materials["sidewalk"] = "asphalt"
    return ground
