"""The quick coarse layouts of streets beside those of the drafting code, on the same scans: Markdown tables.

    python benches/compare_coarse_layouts.py [streets] [--keep FOLDER]

For every class: shapes a scan; length, width and height as shares of those of the nearest object of the class (of what
comes in pieces, and for the solver: in metres); how far the middle is off along and across that object [m], and the
yaw [deg]; how often it is "turned", length and width taken for each other; the share of the scan's pixels of the class
that the cast layout "agrees" with. A cell is the median and the half width of the middle 68 %, of the drafting code
and of its quick imitation. "clusters" is `layout_from_cloud`, with instance numbers or without; "solver"
is `layout_from_spec` on specs with the kinds that the street has; "quick" stands in for them in
`lidardraft.streets`; "possible" is the share of its shapes in sizes that the real code drew too. Below each table
stands what differs by more than `tallies.py` tolerates.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np

from lidardraft.arranging.district import PARKING_STRIP
from lidardraft.drafting.cloud.layout import layout_from_cloud
from lidardraft.drafting.solver.layout import layout_from_spec
from lidardraft.drafting.solver.road_from_spec import road_from_spec
from lidardraft.drafting.solver.scene_spec import ObjectGroup, SceneSpec
from lidardraft.errors import LayoutError
from lidardraft.objects.cars import BODIES
from lidardraft.scene.labelling import agrees
from lidardraft.scene.scanner import Scanner
from lidardraft.scene.shape_table import ShapeTable
from lidardraft.semantics import CLASSES, GROUND
from lidardraft.streets.coarse.coarse_layout import BoxStyle, ClusterStyle, TextStyle, as_boxes, as_clusters, as_text
from lidardraft.streets.pairs import scan_street
from lidardraft.streets.street import Street, StreetConfig, make_street
from tallies import IN_PIECES, Tallies, Tally, add_all, append, drift, new_tallies, read, rows

_NEAREST = 4.0  # m; further than this a shape is of no object


def measure(tallies: Tallies, name: str, coarse: ShapeTable, truth: ShapeTable) -> None:
    """Add the shapes of one layout to those of `name`, compared with the exact ones of the same place."""
    for row in CLASSES[1:]:
        mine, true = np.flatnonzero(coarse.labels == row.id), np.flatnonzero(truth.labels == row.id)
        if row.name in GROUND or not (len(true) or len(mine)):
            continue
        tally = tallies[row.name][name]
        tally.add(count=[len(mine)])
        if not len(mine):
            continue
        sizes = coarse.sizes[mine]
        if row.name in IN_PIECES:
            flat = np.sort(sizes[:, :2], axis=1)
            tally.add(length=flat[:, 1], width=flat[:, 0], height=sizes[:, 2])
        elif len(true):
            _measure_objects(tally, coarse, mine, truth, true, has_front=row.size is not None)


def _measure_objects(
    tally: Tally, coarse: ShapeTable, mine: np.ndarray, truth: ShapeTable, true: np.ndarray, *, has_front: bool
) -> None:
    gap = coarse.centers[mine, None, :2] - truth.centers[None, true, :2]
    distance = np.hypot(gap[..., 0], gap[..., 1])
    nearest = distance.argmin(axis=1)
    near = distance[np.arange(len(mine)), nearest] < _NEAREST
    mine, gap, true = mine[near], gap[np.arange(len(mine)), nearest][near], true[nearest[near]]
    cos, sin = np.cos(truth.yaws[true]), np.sin(truth.yaws[true])
    turn = np.remainder(coarse.yaws[mine] - truth.yaws[true] + math.pi / 2, math.pi) - math.pi / 2
    turned = np.abs(turn) > math.pi / 4
    sizes = coarse.sizes[mine]
    if not has_front:
        # turned by 90 degrees, with length and width exchanged, it is the same box: that is no error
        sizes = np.where(turned[:, None], sizes[:, [1, 0, 2]], sizes)
    ratio = sizes / truth.sizes[true]
    tally.add(
        length=ratio[:, 0],
        width=ratio[:, 1],
        height=ratio[:, 2],
        along=cos * gap[:, 0] + sin * gap[:, 1],
        across=cos * gap[:, 1] - sin * gap[:, 0],
    )
    if not (coarse.shapes[mine] == 2).all():
        square = np.remainder(turn + math.pi / 4, math.pi / 2) - math.pi / 4
        tally.add(yaw=np.rad2deg(square), turned=turned if has_front else [])


def compare_clusters(streets: Iterable[Street], config: StreetConfig) -> Tallies:
    """`layout_from_cloud` and its stand-in on one scan of each street."""
    tallies = new_tallies()
    for street in streets:
        ego, visible, rng = scan_street(street, Scanner.from_layout(street.scene, config.sensor), 0)
        scan, pose = visible.scan, visible.pose
        poses = config.sensor.poses_in_motion(pose, (ego.speed, 0.0, 0.0))
        truth = as_boxes(street.coarse, BoxStyle(relief=True), ego.pose)
        points = scan.points() @ pose[:3, :3].T
        labels = scan.label[scan.valid]
        for numbered in (True, False):
            instances = scan.instance[scan.valid] if numbered else None
            real = layout_from_cloud(points, labels, instances=instances, sensor_height=float(pose[2, 3]))
            quick = as_clusters(street.coarse, ClusterStyle(numbered=numbered), rng, ego.pose, visible)
            suffix = " numbered" if numbered else ""
            for name, coarse in ((f"clusters{suffix}", ShapeTable.from_primitives(real)), (f"quick{suffix}", quick)):
                measure(tallies, name, coarse, truth)
                good = agrees(scan, coarse.scan(config.sensor, poses))
                for label in np.unique(labels):
                    share = good[scan.label == label].mean()
                    tallies[CLASSES[label].name][name].add(agrees=[float(share)])
    return tallies


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


def pooled(name: str, count: int, folder: Path | None, compare: Callable[[Street], Tallies]) -> Tallies:
    """What `compare` finds on streets 0 to `count`; a file of the `folder` keeps it street by street, and goes on."""
    path = folder / f"{name}.jsonl" if folder else None
    known, tallies = read(path) if path else {}, new_tallies()
    for number in range(count):
        if number not in known:
            known[number] = compare(make_street(number, StreetConfig()))
            if path:
                append(path, number, known[number])
        add_all(tallies, known[number])
    return tallies


def main() -> None:
    """Print the tables, and below each what differs."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("streets", type=int, nargs="?", default=200)
    parser.add_argument("--keep", type=Path, help="folder for what was measured of each street; the next run goes on")
    given = parser.parse_args()
    if given.keep:
        given.keep.mkdir(parents=True, exist_ok=True)
    solved = pooled("solver", given.streets, given.keep, lambda street: compare_solver([street]))
    found = pooled("clusters", given.streets, given.keep, lambda street: compare_clusters([street], StreetConfig()))
    objects = {row.name: found[row.name] for row in CLASSES if row.size is not None and row.name in found}
    for tallies, real, quick in (
        (solved, "solver", "quick"),
        (found, "clusters", "quick"),
        (objects, "clusters numbered", "quick numbered"),
    ):
        print(f"{real} / {quick}\n")
        sized = real == "solver"
        print("\n".join(rows(tallies, real, quick, sized=sized)))
        print("\n".join(["", *(f"- {text}" for text in drift(tallies, real, quick, sized=sized)), ""]))


if __name__ == "__main__":
    main()
