"""Generated scans of unseen streets beside simulated and detailed ones, by every sensor: a part of report_generate."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence

import numpy as np

from goals import Goal, ratio
from lidardraft import Pipeline, RangeImage, Sensor, Simulator
from lidardraft.evaluation import score, unseen_streets
from lidardraft.metrics.bev import bev_jsd, bev_mmd
from lidardraft.metrics.sweep import Sweep
from lidardraft.scene.labelling import agrees, label_by_agreement
from lidardraft.scene.sensor import PRESETS
from lidardraft.streets import StreetPair
from markdown_table import Row, table
from scan_scores import scores

SENSOR = PRESETS["hdl64e"]
KINDS = ("simulated", "generated")
OTHERS = 3_000_000  # the seed of streets that no other part has
PART = 4  # one street by another sensor for so many by the first
STARTS = (None, 1.5, 0.5, 0.2)
CALLS = (1, 2, 4, 8, 20)
SEEDS, LAYOUTS, SAMPLED = 4, 5, 24  # at most


def _table_of_beams(name: str, degrees: Sequence[float] | np.ndarray, **fields: float | int) -> Sensor:
    elevations = tuple(np.deg2rad(np.sort(np.asarray(degrees, dtype=float))[::-1]).tolist())
    return Sensor(name=name, elevations=elevations, **fields)  # type: ignore[arg-type]


# Tables unlike those that sensors are sampled with: three blocks; beams that close up downwards; a sector of uneven
# ones.
UNSEEN_SENSORS = (
    _table_of_beams(
        "40 in three blocks",
        [15, 11, 8, 5, 3, *np.arange(2, -6.1, -1 / 3), *range(-7, -15, -1), -19, -25],
        columns=1800,
        mount_height=1.9,
    ),
    _table_of_beams("80, closer downwards", 10 - 35 * np.linspace(0, 1, 80) ** 0.7, columns=1024, mount_height=2.6),
    _table_of_beams(
        "24 uneven, 120 degrees",
        np.linspace(8, -20, 24) + 0.35 * np.sin(np.arange(24) * 2.3),
        columns=400,
        azimuth_start=math.radians(60),
        azimuth_span=math.radians(120),
    ),
)


def compare_on_streets(pipeline: Pipeline, number: int, only: str) -> Iterator[str | Goal]:
    """The table of the first sensor, one row for each sensor, then the goals."""
    rows: dict[str, Row] = {}
    for sensor in (SENSOR, *(one for one in PRESETS.values() if one is not SENSOR), *UNSEEN_SENSORS):
        if only not in f"streets, {sensor.name}":
            continue
        pairs = unseen_streets(number if sensor is SENSOR else max(2, number // PART), sensor=sensor)
        generated = [generate(pipeline, pair) for pair in pairs]
        found = scores_by_kind(pairs, generated)
        if sensor is SENSOR:
            found["scans of other streets"] = _floor(pairs)
            yield f"### Streets, {sensor.name}, {len(pairs)} scans\n\n{table(found)}\n"
            yield _over_the_floor(found)
        rows[f"{sensor.name} ({len(pairs)})"] = _by_sensor(found)
    if rows:
        yield f"### Streets by each sensor: detailed, simulated, generated\n\n{table(rows)}\n"
        yield from _goals(rows)


def generate(pipeline: Pipeline, pair: StreetPair) -> RangeImage:
    """The generated scan of a pair's layout, labelled."""
    assert pair.simulated is not None
    made = pipeline.generate(pair.condition_image, pair.simulated, seed=pair.index)
    return label_by_agreement(made, [pair.simulated, pair.condition_image], pair.layout, pair.pose)


def scores_by_kind(pairs: Sequence[StreetPair], generated: Sequence[RangeImage]) -> dict[str, Row]:
    """`scan_scores.scores` against the detailed scans, and adherence to the condition images: "kept", "kept on
    objects", and the share that is dropped."""
    images = {
        "detailed": [pair.scan for pair in pairs],
        "simulated": [pair.simulated for pair in pairs if pair.simulated is not None],
        "generated": generated,
    }
    sweeps = {kind: [Sweep.by_azimuth(image) for image in some] for kind, some in images.items()}
    casts = [Sweep.by_azimuth(pair.condition_image) for pair in pairs]
    found = [
        {"recorded": recorded, "cast": cast, "simulated": simulated, "generated": made}
        for recorded, cast, simulated, made in zip(sweeps["detailed"], casts, *(sweeps[k] for k in KINDS), strict=True)
    ]
    rows = scores(found, KINDS, firings=True)
    rows = {"detailed": rows.pop("recorded")} | rows
    for kind, some in images.items():
        kept = score(kind, list(pairs), some)
        rows[kind] = {"kept": kept.overall, "kept on objects": kept.objects, "dropped": kept.drop} | rows[kind]
    return rows


def _floor(pairs: Sequence[StreetPair]) -> Row:
    """How far the scans of as many other streets are from those of `pairs`."""
    others = unseen_streets(len(pairs), sensor=SENSOR, seed=OTHERS)
    clouds = [[pair.scan.points() for pair in some] for some in (pairs, others)]
    return {"BEV": bev_jsd(*clouds), "BEV MMD": bev_mmd(*clouds)}


def _over_the_floor(found: dict[str, Row]) -> Goal:
    floor = found["scans of other streets"]
    values = {f"{name}, {kind}": ratio(found[kind][name], floor[name]) for name in floor for kind in KINDS}
    return Goal("BEV JSD and MMD to the streets' own scans / of other streets", values, most=1.5)


_BY_SENSOR = ("kept on objects", "dropped", "holes in 1,000", "lone %")


def _by_sensor(found: dict[str, Row]) -> Row:
    kinds = ("detailed", *KINDS)
    return {f"{name}, {kind}": found[kind][name] for name in _BY_SENSOR for kind in kinds}


def _goals(rows: dict[str, Row]) -> Iterator[Goal]:
    for name, least, most in zip(_BY_SENSOR, (0.95, 0.8, 0.7, 0.7), (1.05, 1.25, 1.3, 1.3), strict=True):
        values = {sensor: ratio(row[f"{name}, generated"], row[f"{name}, detailed"]) for sensor, row in rows.items()}
        yield Goal(f"{name}, generated / detailed", values, least, most)


def compare_sampling(pipeline: Pipeline, number: int) -> Iterator[str | Goal]:
    """Other starts, and more calls."""
    pairs = unseen_streets(min(number, SAMPLED), sensor=SENSOR)
    rows: dict[str, Row] = {}

    def row(start: float | None, calls: int) -> Row:
        name = f"start {'noise' if start is None else f'{start:g}'}, {calls} calls"
        if name not in rows:
            other = Pipeline(pipeline.denoiser, steps=calls, start=start)
            found = scores_by_kind(pairs, [generate(other, pair) for pair in pairs])
            rows.update({kind: found[kind] for kind in ("detailed", "simulated")})
            rows[name] = found["generated"]
        return rows[name]

    few, many = row(pipeline.start, pipeline.steps), row(pipeline.start, max(CALLS))
    for start, calls in itertools.product(STARTS, CALLS):
        row(start, calls)
    yield f"### Starts and calls, {SENSOR.name}, {len(pairs)} streets\n\n{table(rows)}\n"
    values = {name: ratio(few[name], many[name]) for name in few}
    yield Goal(f"{pipeline.steps} calls / {max(CALLS)} calls", values, least=0.95, most=1.05)


def compare_spread(pipeline: Pipeline, number: int) -> Iterator[str | Goal]:
    """How far scans of one layout are from each other, over seeds: the share of firings with a return in either of two
    that do not agree."""
    pairs = unseen_streets(min(number, LAYOUTS), sensor=SENSOR)
    spreads: dict[str, list[float]] = {"simulated": [], "generated": [], "generated from one simulated scan": []}
    for pair in pairs:
        simulated = [
            Simulator(pair.layout, SENSOR, seed=seed).scan(pair.pose, speed=pair.speed, seed=seed).image
            for seed in range(SEEDS)
        ]
        for name, starts in (("generated", simulated), ("generated from one simulated scan", simulated[:1] * SEEDS)):
            made = [pipeline.generate(pair.condition_image, one, seed=k) for k, one in enumerate(starts)]
            spreads[name].append(spread(made))
        spreads["simulated"].append(spread(simulated))
    rows = {name: {"spread": float(np.mean(values))} for name, values in spreads.items()}
    yield f"### Spread over {SEEDS} seeds, {len(pairs)} layouts\n\n{table(rows)}\n"
    value = ratio(rows["generated"]["spread"], rows["simulated"]["spread"])
    yield Goal("spread over seeds, generated / detailed scans of one layout", {SENSOR.name: value}, 0.8, 1.2)


def spread(images: Sequence[RangeImage]) -> float:
    """The mean over all pairs of scans of what does not agree."""
    apart = []
    for first, second in itertools.combinations(images, 2):
        either = np.count_nonzero(first.valid | second.valid)
        apart.append(1 - np.count_nonzero(agrees(first, second)) / max(either, 1))
    return float(np.mean(apart))
