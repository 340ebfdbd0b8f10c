"""Who stands where: the plan of one street, drawn from the kind of quarter it lies in."""

from __future__ import annotations

import math

import numpy as np

from lidardraft.streets.buildings import STOREY
from lidardraft.streets.ground import Ground
from lidardraft.streets.quarter import QUARTERS, SIDES, Lane, Quarter, draw_road, driven_lanes
from lidardraft.streets.site import Site
from lidardraft.streets.traffic import drive, fill_junction, park, walk
from lidardraft.streets.vehicles import car_body


def draw_site(rng: np.random.Generator, reach: float) -> tuple[Site, tuple[Lane, ...], str]:
    """A site with all its things, the lanes that are driven in, and the name of its quarter."""
    name = str(rng.choice(list(QUARTERS), p=[quarter.share for quarter in QUARTERS.values()]))
    quarter = QUARTERS[name]
    parking = tuple(side for side in SIDES if rng.random() < quarter.parked)
    road = draw_road(quarter, parking, reach, rng)
    site = Site(road, Ground(road, rng))
    lanes = driven_lanes(road, parking)
    fill_junction(site, rng)
    _buildings(site, quarter, rng)
    _fronts(site, quarter, rng)
    _posts(site, quarter, rng)
    _row_trees(site, quarter, rng)
    park(site, parking, rng)
    drive(site, quarter, lanes, rng)
    walk(site, quarter, rng)
    _yards(site, quarter, rng)
    _thickets(site, quarter, rng)
    _wild(site, quarter, rng)
    return site, lanes, name


def _buildings(site: Site, quarter: Quarter, rng: np.random.Generator) -> None:
    road = site.road
    for side in SIDES:
        for row in range(2):
            setback = rng.uniform(*quarter.setback) + row * rng.uniform(16.0, 30.0)
            along = -road.reach - rng.uniform(0.0, 8.0)
            while along < road.reach:
                kind, size, eaves = _building(quarter, rng)
                across = side * (road.verge + setback + rng.uniform(0.0, 1.0) + size[1] / 2)
                if rng.random() < quarter.built:
                    turn = (0.0 if side > 0 else math.pi) + rng.normal(0.0, 0.01)
                    site.place(
                        kind, along + size[0] / 2, across, size, turn=turn, stem=eaves, margin=0.02, private=True
                    )
                along += size[0] + rng.uniform(*quarter.gap) * (1 if row == 0 else 2)


def _building(quarter: Quarter, rng: np.random.Generator) -> tuple[str, tuple[float, float, float], float]:
    """Kind, extents and eaves of a building."""
    if rng.random() < quarter.blocks:
        storeys = int(rng.integers(3, 7))
        return "block", (rng.uniform(12.0, 30.0), rng.uniform(10.0, 15.0), storeys * STOREY + 0.4), 0.0
    if rng.random() < 0.12:
        return "shed", (rng.uniform(3.0, 12.0), rng.uniform(5.5, 9.0), rng.uniform(2.4, 4.0)), 0.0
    eaves = int(rng.integers(1, 4)) * STOREY + 0.2
    width = rng.uniform(7.5, 11.0)
    return "house", (rng.uniform(8.0, 16.0), width, eaves + width * rng.uniform(0.25, 0.5)), eaves


def _fronts(site: Site, quarter: Quarter, rng: np.random.Generator) -> None:
    """What closes the front gardens: fences, walls or hedges in runs, with gates between."""
    road = site.road
    for side in SIDES:
        if rng.random() > quarter.fronts or quarter.setback[1] < 2.0:
            continue
        along = -road.reach
        off = road.verge + rng.uniform(0.5, 0.9)
        while along < road.reach:
            kind = str(rng.choice(("fence", "garden_wall", "hedge"), p=(0.3, 0.2, 0.5)))
            height = rng.uniform(0.8, 1.6) if kind != "hedge" else rng.uniform(1.0, 2.4)
            thick = {"fence": 0.1, "garden_wall": 0.3, "hedge": rng.uniform(0.7, 1.4)}[kind]
            stop = min(along + rng.uniform(8.0, 28.0), road.reach)
            while along < stop:
                # a bend is followed by short straight pieces
                length = min(7.0 if road.curvature else 14.0, stop - along)
                if length > 1.5:
                    across = side * (off + thick / 2)
                    size = (length - 0.1, thick, height)
                    site.place(kind, along + length / 2, across, size, margin=0.0, private=True)
                along += length
            along += rng.uniform(1.2, 5.0)


def _posts(site: Site, quarter: Quarter, rng: np.random.Generator) -> None:
    """Lamps at even spacing on one or both sides; poles, signs, bins and benches between them."""
    road = site.road
    off = road.edge + 0.45 if road.sidewalk > 0 else road.edge + 1.5
    lit = [side for side in SIDES if rng.random() < (0.3 if road.sidewalk == 0 else 0.75)]
    spacing, height = rng.uniform(22.0, 36.0), rng.uniform(4.5, 9.0)
    for side in lit:
        for along in np.arange(-road.reach + rng.uniform(0, spacing), road.reach, spacing):
            if not road.in_junction(float(along), 1.0):
                turn = 0.0 if side < 0 else math.pi
                site.place("lamp", float(along), side * off, (rng.uniform(0.12, 0.22), 0.2, height), turn=turn)
    for _ in range(rng.poisson(7 if road.sidewalk > 0 else 4)):
        side, along = int(rng.choice(SIDES)), rng.uniform(-road.reach, road.reach)
        if road.in_junction(along, 0.5):
            continue
        turn = (math.pi if side < 0 else 0.0) + rng.normal(0.0, 0.08)
        stem = rng.uniform(1.9, 2.5)
        plate = rng.uniform(0.5, 0.9)
        kind = str(rng.choice(("sign", "sign", "pole", "bin", "bench"), p=(0.3, 0.2, 0.2, 0.2, 0.1)))
        size = {
            "sign": (0.12, plate, stem + plate),
            "pole": (rng.uniform(0.08, 0.3), 0.2, rng.uniform(0.9, 7.0)),
            "bin": (0.58, 0.62, 1.07),  # EN 840, 240 litres
            "bench": (1.8, 0.6, 0.85),
        }[kind]
        if kind == "bench":
            turn += math.pi  # it looks to the road
        edge = off if kind in ("sign", "pole") else road.verge - 0.5 if road.sidewalk > 0 else off
        site.place(kind, along, side * edge, size, turn=turn, stem=stem if kind == "sign" else 0.0)


def _tree_size(rng: np.random.Generator) -> tuple[tuple[float, float, float], float]:
    """Extents and height of the bare stem; crowns measure 2 to 9 m, an estimate of ours for street trees."""
    height = rng.uniform(4.5, 13.0)
    crown = height * rng.uniform(0.42, 0.68)
    return (crown * rng.uniform(0.9, 1.1), crown, height), height * rng.uniform(0.12, 0.34)


def _row_trees(site: Site, quarter: Quarter, rng: np.random.Generator) -> None:
    road = site.road
    for side in SIDES:
        if rng.random() > quarter.row_trees:
            continue
        off = road.edge + 0.8 if road.sidewalk > 2.0 else road.verge + rng.uniform(1.2, 3.0)
        (length, width, height), stem = _tree_size(rng)
        stem = max(stem, 2.4)
        for along in np.arange(-road.reach + rng.uniform(0, 10), road.reach, rng.uniform(8.0, 15.0)):
            grown = rng.uniform(0.8, 1.15)
            place = float(along) + rng.normal(0.0, 0.3)
            if not road.in_junction(place, 2.0) and rng.random() < 0.92:
                size = (length * grown, width * grown, max(height * grown, stem + 1.5))
                site.place("tree", place, side * off, size, turn=rng.uniform(0, 3.0), stem=stem, margin=0.05)


def _yards(site: Site, quarter: Quarter, rng: np.random.Generator) -> None:
    """Cars in drives, bicycles against front walls, bins behind fences."""
    road = site.road
    for _ in range(rng.poisson(3.5 if quarter.setback[1] > 2.0 else 0.7)):
        side, along = int(rng.choice(SIDES)), rng.uniform(-0.9, 0.9) * road.reach
        kind, size = car_body(rng)
        across = side * (road.verge + 0.6 + size[0] / 2)
        turn = float(rng.choice((-1, 1))) * math.pi / 2 + rng.normal(0.0, 0.05)
        site.place(kind, along, across, size, turn=turn, private=True)
    for _ in range(rng.poisson(1.5)):
        side, along = int(rng.choice(SIDES)), rng.normal(0.0, 30.0)
        kind = "bicycle" if rng.random() < 0.75 else "motorcycle"
        size = (1.78, 0.58, 1.06) if kind == "bicycle" else (2.1, 0.8, 1.2)
        across = road.verge - 0.45 if road.sidewalk > 1.2 else road.verge + 0.8
        site.place(kind, along, side * across, size, turn=rng.normal(0.0, 0.1))
    for _ in range(rng.poisson(2)):
        across = int(rng.choice(SIDES)) * (road.verge + rng.uniform(0.5, 2.0))
        site.place("bin", rng.normal(0.0, 30.0), across, (0.58, 0.62, 1.07), turn=rng.uniform(0, 3), private=True)


def _thickets(site: Site, quarter: Quarter, rng: np.random.Generator) -> None:
    """Runs of tall bushes along the backs of gardens and the edges of fields."""
    road = site.road
    for side in SIDES:
        for _ in range(rng.poisson(quarter.thickets)):
            along, off = rng.uniform(-1.0, 0.7) * road.reach, road.verge + rng.uniform(2.5, 28.0)
            stop = min(along + rng.uniform(10.0, 60.0), road.reach)
            while along < stop:
                width = rng.uniform(2.0, 4.5)
                size = (width, width * rng.uniform(0.8, 1.1), width * rng.uniform(0.7, 1.3))
                across = side * (off + size[1] / 2 + rng.normal(0.0, 0.5))
                site.place("bush", along, across, size, turn=rng.normal(0.0, 0.2), margin=0.0, private=True)
                along += width * rng.uniform(1.0, 1.25)


def _wild(site: Site, quarter: Quarter, rng: np.random.Generator) -> None:
    """Trees and bushes of gardens, parks and verges."""
    road = site.road
    spread = 14.0 if quarter.built > 0.5 else 28.0
    for _ in range(rng.poisson(quarter.wild_trees)):
        side, along = int(rng.choice(SIDES)), rng.uniform(-1.0, 1.0) * road.reach
        size, stem = _tree_size(rng)
        across = road.verge + 1.0 + rng.exponential(spread)
        if across < 55.0:
            site.place("tree", along, side * across, size, turn=rng.uniform(0, 3), stem=stem, margin=0.05, private=True)
    for _ in range(rng.poisson(1.2 * quarter.wild_trees)):
        side, along = int(rng.choice(SIDES)), rng.uniform(-0.8, 0.8) * road.reach
        width = rng.uniform(0.8, 3.6)
        across = road.verge + 0.8 + width / 2 + rng.exponential(0.5 * spread)
        size = (width * rng.uniform(0.8, 1.3), width, width * rng.uniform(0.6, 1.0))
        if across < 45.0:
            site.place("bush", along, side * across, size, turn=rng.uniform(0, 3), margin=0.05, private=True)
