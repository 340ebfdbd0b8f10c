"""The quick imitation of the solver of sentences beside the solver, kind by kind: a Markdown table.

    python benches/compare_coarse_layouts.py [streets]

For every kind and class: shapes an object; length, width and height [m]; how far the middle is off that of the lane
[m], and the yaw [deg]. A cell is the median and the half width of the middle 68 %, of the solver and of its quick
imitation. "solver" is `layout_from_spec` on specs with the kinds that the street has; "quick" stands in for it in
`lidardraft.streets`; "possible" is the share of its shapes in sizes that the solver drew too. Below the table stands
what differs by more than `tallies.py` tolerates.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterable

import numpy as np

from lidardraft.drafting.solver.layout import layout_from_spec
from lidardraft.drafting.solver.road_from_spec import road_from_spec
from lidardraft.drafting.solver.scene_spec import ObjectGroup, SceneSpec
from lidardraft.errors import LayoutError
from lidardraft.objects.cars import BODIES
from lidardraft.scene.road import PARKING_STRIP
from lidardraft.scene.shape_table import ShapeTable
from lidardraft.semantics import CLASSES
from lidardraft.streets.coarse.coarse_layout import TextStyle, as_text
from lidardraft.streets.street import Street, make_street
from tallies import Tallies, drift, new_tallies, rows

# What the solver calls the kinds of streets.
NAMED = {
    **{body: "van" if body == "van" else "car" for body in BODIES},
    **{kind: kind for kind in ("truck", "bus", "tram", "person", "house", "tree", "bush", "pole", "bin", "bench")},
    "block": "building",
    "bicycle": "bicycle",
    "motorcycle": "motorcycle",
    "lamp": "street-light",
    "sign": "traffic-sign",
    "traffic_light": "traffic-light",
    "hedge": "hedge",
    "fence": "fence",
    "garden_wall": "wall",
}
_MOST = 5  # objects of a kind that surely find room


def compare_solver(streets: Iterable[Street]) -> Tallies:
    """`layout_from_spec` and its stand-in: each kind that a street has, asked for alone on a straight road."""
    tallies = new_tallies()
    for street in streets:
        if street.occupancy.road.curvature:
            continue
        coarse = as_text(street.coarse, TextStyle(), np.eye(4))
        kinds = {placed.id: NAMED[placed.kind] for placed in street.coarse.objects if placed.kind in NAMED}
        middles = [lane.across for lane in street.lanes] + [street.occupancy.road.edge - PARKING_STRIP / 2]
        ego = street.occupancy.road.lane(0)
        for kind in sorted(set(kinds.values())):
            named = [row for row, id in enumerate(coarse.ids) if kinds.get(id.partition(".")[0]) == kind]
            objects = {coarse.ids[row].partition(".")[0] for row in named}
            if not objects:
                continue
            _measure_named(tallies, "quick", kind, coarse, named, len(objects), ego, middles)
            parked = {"heading": "parked"} if kind in ("bicycle", "motorcycle") else {}
            spec = SceneSpec(groups=(ObjectGroup(kind=kind, count=min(len(objects), _MOST), **parked),))
            try:
                solved = ShapeTable.from_primitives(layout_from_spec(spec, seed=street.seed))
            except LayoutError:  # now and then there is no room for as many
                continue
            road = road_from_spec(spec, np.random.default_rng(street.seed))
            theirs = [road.lane(n, d) for n in range(road.lanes) for d in (-1, 1)] + [road.edge - road.parking / 2]
            mine = [row for row, id in enumerate(solved.ids) if id.partition(".")[0].rpartition("_")[0] == kind]
            count = min(len(objects), _MOST)
            _measure_named(tallies, "solver", kind, solved, mine, count, road.lane(road.ego_lane), theirs)
    return tallies


def _measure_named(
    tallies: Tallies,
    by: str,
    kind: str,
    coarse: ShapeTable,
    chosen: list[int],
    objects: int,
    ego: float,
    middles: list[float],
) -> None:
    for label in np.unique(coarse.labels[chosen]):
        tally = tallies[f"{kind}: {CLASSES[label].name}"][by]
        mine = [row for row in chosen if coarse.labels[row] == label]
        length, width, height = coarse.sizes[mine].T
        tally.add(count=[len(mine) / objects], length=length, width=width, height=height)
        if (coarse.shapes[mine] == 0).all():
            off = np.remainder(coarse.yaws[mine] + math.pi / 4, math.pi / 2) - math.pi / 4
            tally.add(yaw=np.rad2deg(off[np.abs(off) < 0.2]))
        if CLASSES[label].name in ("car", "truck", "bus", "train"):
            across = coarse.centers[mine, 1] + ego
            gap = across[:, None] - np.array([*middles, -middles[-1]])
            nearest = gap[np.arange(len(mine)), np.abs(gap).argmin(axis=1)]
            tally.add(across=nearest[np.abs(nearest) < 0.5])


def main() -> None:
    """Print the table, and below it what differs."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("streets", type=int, nargs="?", default=200)
    given = parser.parse_args()
    solved = compare_solver(make_street(seed=number) for number in range(given.streets))
    print("\n".join(rows(solved, "solver", "quick")))
    print("\n".join(["", *(f"- {text}" for text in drift(solved, "solver", "quick")), ""]))


if __name__ == "__main__":
    main()
