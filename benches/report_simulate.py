"""What becomes of a layout, held against the scan that the layout was made from: `make report-simulate`.

    python benches/report_simulate.py [--streets 50] [--generated 0] [--data FOLDER] [--only NAME]

Each labelled recording in FOLDER (by default LIDARDRAFT_DATA) is clustered to a layout, and each street has its coarse
one. From there come four scans: the bare cast; the cast with the sensor model, `simulate(detail=False)`; `simulate` in
detail; and, with `--generated N`, which takes the first N scans of each set alone, that of the packaged weights. A row
is a share of pixels (more is better) or a distance between the sets (less is better). "Near" is within 0.5 m or 5 % of
the recorded range. "IoU": of the pixels where either returns from a class, those where both do, and near.
"""

from __future__ import annotations

import argparse
import dataclasses
import os
from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import islice
from pathlib import Path

import numpy as np

import recordings
from lidardraft import Layout, Pipeline, RangeImage, Sensor, Simulator, layout_from_cloud, raycast
from lidardraft.metrics import lifelike
from lidardraft.metrics.lifelike import CLASS_SETS
from lidardraft.metrics.sweep import Sweep
from lidardraft.scene.labelling import ABSOLUTE_TOLERANCE, RELATIVE_TOLERANCE, label_by_agreement
from lidardraft.scene.sensor import PRESETS
from lidardraft.scene.sensor_model import SensorModel
from lidardraft.semantics import BY_NAME, CLASSES, GROUND
from lidardraft.streets import StreetConfig, streets
from report_streets import by_azimuth, unhidden

SEED = 2_000_000  # no training uses it
NO_OBJECT = [BY_NAME[name].id for name in ("none", *GROUND)]
# which of `CLASS_SETS` a class is of, by its id; of the others each is a set of its own
SETS = {name: [BY_NAME[member].id for member in members] for name, members in CLASS_SETS.items()}
SET_OF = np.array([next((100 + k for k, ids in enumerate(SETS.values()) if row.id in ids), row.id) for row in CLASSES])
_COMPARED = ("range (JSD)", "height over the road (JSD)", "top view (BEV JSD)", "top view (BEV MMD)")
DISTANCES = (
    *(one for one in lifelike.PROPERTIES if one.name in _COMPARED),
    *(one for one in lifelike.class_properties() if one.name in {f"intensity of {name} (JSD)" for name in CLASS_SETS}),
)
FEWEST = 200  # returns of which a class has rows
EQUAL = 0.005  # differences that are none
BOTH = "returns of either that both have"
BETTER_IF_MORE = (BOTH, "drop precision", "drop recall")

Render = Callable[[RangeImage], Sweep]
Table = dict[str, dict[str, float]]  # by row, then by column
Counts = dict[str, np.ndarray]  # by row: part and whole


@dataclass(frozen=True)
class Case:
    """A recorded scan, the layout of it, and the sensor's pose and speed [m/s] as it was taken."""

    recorded: Sweep
    layout: Layout
    sensor: Sensor
    pose: np.ndarray
    speed: float = 0.0


@dataclass(frozen=True)
class CaseSet:
    """Cases of one sensor; `render` puts a scan on the grid of the recorded ones.

    `shown` are the pixels that the recording car leaves open. On a grid of `firings` a pixel without a return is a
    dropped one.
    """

    cases: list[Case]
    render: Render
    shown: np.ndarray
    firings: bool


def recorded_sets(folder: Path) -> Iterator[tuple[str, Callable[[], CaseSet]]]:
    """The sets of recordings, by name."""
    kitti, nuscenes = PRESETS["hdl64e-linear"], recordings.NUSCENES_GRID
    yield "KITTI, HDL-64E", lambda: _clustered(recordings.kitti_images(folder), PRESETS["hdl64e"], grid=kitti)
    yield "nuScenes, HDL-32E", lambda: _clustered(recordings.nuscenes_images(folder), PRESETS["hdl32e"], grid=nuscenes)
    yield "PandaSet, Pandar64", lambda: _clustered_groups(recordings.pandar64(folder, 1800), PRESETS["pandar64"])
    yield "ika, VLP-32C", lambda: _clustered_groups(recordings.vlp32c(folder, 1800), PRESETS["vlp32c"])


def street_set(number: int, sensor: Sensor = PRESETS["hdl64e"]) -> CaseSet:
    """Scans of streets, and their coarse layouts."""
    pairs = islice(streets(SEED, StreetConfig(sensor=sensor, poses_per_street=1)), number)
    cases = [Case(by_azimuth(pair.scan), pair.layout, sensor, pair.pose, pair.speed) for pair in pairs]
    return CaseSet(cases, by_azimuth, np.ones(sensor.shape, dtype=bool), firings=True)


def _clustered_groups(found: recordings.Recordings, sensor: Sensor) -> CaseSet:
    sweeps = [sweep for group in found.labelled.values() for sweep in group]
    return _clustered(sweeps, sensor, fov=found.fov)


def _clustered(sweeps: list[Sweep], sensor: Sensor, grid: Sensor | None = None, fov: float | None = None) -> CaseSet:
    cases = [Case(sweep, _layout(sweep, sensor), sensor, sensor.pose()) for sweep in sweeps]
    columns = sensor.columns
    shown = unhidden({"": sweeps}, grid or sensor, fov)
    if fov is not None and sweeps:
        start = (columns - sweeps[0].points.shape[1]) // 2
        window = start, start + sweeps[0].points.shape[1]
        return CaseSet(cases, lambda image: by_azimuth(image).part(*window), shown[:, slice(*window)], firings=True)
    render = by_azimuth if grid is None else partial(_projected, grid=grid)
    return CaseSet(cases, render, shown, firings=grid is None)


def _layout(sweep: Sweep, sensor: Sensor) -> Layout:
    assert sweep.label is not None
    seen = sweep.valid & (sweep.label > 0)
    return layout_from_cloud(sweep.points[seen], sweep.label[seen], sensor_height=sensor.mount_height)


def _projected(image: RangeImage, grid: Sensor) -> Sweep:
    values = {name: getattr(image, name) for name in ("label", "intensity")}
    seen = {name: value[image.valid] for name, value in values.items() if value is not None}
    return Sweep.from_image(RangeImage.project(image.points(), grid, **seen))


def scans_of(case: Case, seed: int, pipeline: Pipeline | None) -> dict[str, RangeImage]:
    """The scans that a layout becomes, by what makes them; each seed has a unit of the sensor."""
    sensor, pose = case.sensor, case.pose
    model = replace(SensorModel.from_sensor(sensor), unit=seed)

    def simulated(detail: bool) -> RangeImage:
        simulator = Simulator(case.layout, sensor, seed=seed, model=model, detail=detail)
        return simulator.scan(pose, speed=case.speed, seed=seed).image

    poses = sensor.poses_in_motion(pose, case.speed * pose[:3, 0])
    scans = {"cast": raycast(case.layout, sensor, poses=poses), "+ sensor model": simulated(False)}
    scans["simulated"] = simulated(True)
    if pipeline is not None:
        *_, made = pipeline.denoising(scans["cast"], seed=seed)
        scans["generated"] = label_by_agreement(made, [scans["simulated"], scans["cast"]], case.layout, pose)
    return scans


def _shown(sweep: Sweep, shown: np.ndarray) -> Sweep:
    return dataclasses.replace(sweep, points=np.where(shown[..., None], sweep.points, np.float32(0)))


def shares(recorded: Sweep, made: Sweep, cast: Sweep, firings: bool) -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
    """Each row's name, the pixels that count for it, and those of them that are right."""
    assert recorded.label is not None
    assert made.label is not None
    both = recorded.valid & made.valid
    tolerance = np.maximum(ABSOLUTE_TOLERANCE, RELATIVE_TOLERANCE * recorded.depth)
    near = both & (np.abs(made.depth - recorded.depth) <= tolerance)
    known = recorded.valid & (recorded.label > 0)
    yield "near", recorded.valid, near
    yield "near, of the same class", known, near & (SET_OF[made.label] == SET_OF[recorded.label])
    yield "near, on objects", known & ~np.isin(recorded.label, NO_OBJECT), near
    for name, ids in SETS.items():
        here, there = (sweep.valid & np.isin(sweep.label, ids) for sweep in (recorded, made))
        yield f"near, on {name}", here, near
        yield f"IoU of {name}", here | there, here & there & near
    yield BOTH, recorded.valid | made.valid, both
    if firings:
        lost, dropped = cast.valid & ~recorded.valid, cast.valid & ~made.valid
        yield "dropped in recording", cast.valid, lost
        yield "dropped", cast.valid, dropped
        yield "drop precision", dropped, lost
        yield "drop recall", lost, dropped


def report(cases: CaseSet, pipeline: Pipeline | None = None) -> Table:
    """The table of a set; "generated" is left out without a pipeline."""
    counts: dict[str, Counts] = defaultdict(lambda: defaultdict(lambda: np.zeros(2)))
    features: dict[str, dict[str, list[np.ndarray]]] = defaultdict(lambda: defaultdict(list))
    for number, case in enumerate(cases.cases):
        made = scans_of(case, number, pipeline)
        sweeps = {name: _shown(cases.render(image), cases.shown) for name, image in made.items()}
        recorded = _shown(case.recorded, cases.shown)
        for name, sweep in sweeps.items():
            for row, of, right in shares(recorded, sweep, sweeps["cast"], cases.firings):
                counts[name][row] += np.count_nonzero(of & right), np.count_nonzero(of)
        for name, sweep in {"recorded": recorded, **sweeps}.items():
            for one in DISTANCES:
                if sweep.intensity is not None or not one.name.startswith("intensity"):
                    features[name][one.name].append(one.measure(sweep))
    table: Table = defaultdict(dict)
    for name, found in counts.items():
        for row, (part, whole) in found.items():
            # a class has rows where it was recorded often enough
            returns = found[row.replace("IoU of", "near, on")][1]
            if whole and (returns >= FEWEST or row.startswith("drop")):
                table[row][name] = float(part / whole)
    for one in DISTANCES:
        truth = features["recorded"][one.name]
        for name in counts:
            mine = features[name][one.name]
            counted = one.name.startswith("top view") or np.sum(truth) >= FEWEST
            if mine and counted:
                table[one.name][name] = one.distance(truth, mine)
    return table


def losses(table: Table) -> dict[str, float]:
    """By how much the simulated scan is worse than the cast with the sensor model, by row; below 0, better."""
    found = {}
    for row, cells in table.items():
        if not row.startswith("dropped") and {"+ sensor model", "simulated"} <= set(cells):
            more = cells["simulated"] - cells["+ sensor model"]
            found[row] = -more if row in BETTER_IF_MORE or row.startswith(("near", "IoU")) else more
    return found


def markdown(table: Table) -> str:
    """The table, and what is worse in it."""
    columns = list(dict.fromkeys(name for cells in table.values() for name in cells))
    lines = [f"| | {' | '.join(columns)} |", f"|---|{'---:|' * len(columns)}"]
    for row, cells in table.items():
        lines.append(f"| {row} | {' | '.join(f'{cells[c]:.3g}' if c in cells else '-' for c in columns)} |")
    loss = losses(table)
    worse = [f"{row} by {value:.3f}" for row, value in loss.items() if value > EQUAL]
    better = sum(value < -EQUAL for value in loss.values())
    said = f"Simulated beside cast and sensor model, of {len(loss)} rows: {better} better, {len(worse)} worse"
    return "\n".join([*lines, "", f"{said} ({', '.join(worse)})." if worse else f"{said}."])


def summary(tables: dict[str, Table]) -> str:
    """All sets in one table: the cast with the sensor model -> the simulated scan."""
    rows = dict.fromkeys(row for table in tables.values() for row in losses(table))
    lines = [f"| | {' | '.join(tables)} |", f"|---|{'---|' * len(tables)}"]
    for row in rows:
        pairs = [
            (table.get(row, {}).get("+ sensor model"), table.get(row, {}).get("simulated")) for table in tables.values()
        ]
        cells = ["" if a is None or b is None else f"{_digits(a)} → {_digits(b)}" for a, b in pairs]
        lines.append(f"| {row} | {' | '.join(cells)} |")
    return "\n".join(lines)


def _digits(value: float) -> str:
    return f"{value:.2f}" if value >= 0.1 else f"{value:.2g}"


def main() -> None:
    """Print all tables."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--streets", type=int, default=50, metavar="N", help="how many streets (default 50)")
    parser.add_argument("--generated", type=int, default=0, metavar="N", help="the first N scans alone, generated too")
    parser.add_argument("--data", type=Path, default=os.environ.get("LIDARDRAFT_DATA"), metavar="FOLDER")
    parser.add_argument("--only", default="", metavar="NAME", help="sets whose names hold this")
    given = parser.parse_args()
    pipeline = Pipeline.from_pretrained() if given.generated else None
    sets = list(recorded_sets(given.data)) if given.data is not None else []
    tables = {}
    for name, make in [*sets, ("streets, HDL-64E", partial(street_set, given.streets))]:
        if given.only not in name:
            continue
        cases = make()
        cases = replace(cases, cases=cases.cases[: given.generated or None])
        if cases.cases:
            tables[name] = report(cases, pipeline)
            print(f"### {name}, {len(cases.cases)} scans\n\n{markdown(tables[name])}\n", flush=True)
    print(summary(tables))


if __name__ == "__main__":
    main()
