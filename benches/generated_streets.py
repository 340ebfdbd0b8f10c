"""Generated scans of unseen streets, and how far they are from each other over seeds: a part of report_generate."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from goals import Goal, ratio
from lidardraft import Pipeline, RangeImage, Sensor, simulate
from lidardraft.evaluation import Scores, evaluate, half_opened, unseen_streets, untrained_weights
from lidardraft.metrics.bev import bev_histogram
from lidardraft.metrics.lifelike import pooled_divergence
from markdown_table import Row, table

SEEDS, STREETS = 8, 3


def compare_on_streets(pipeline: Pipeline, sensor: Sensor, number: int) -> Iterator[str | Goal]:
    """The table of `lidardraft evaluate`, then the goals."""
    rows = {scores.name: numbers(scores) for scores in evaluate(pipeline, unseen_streets(number, sensor=sensor))}
    half = ", half of each open" * pipeline.denoiser.config.completes
    yield f"### Streets, {sensor.name}, {number} scans{half}\n\n{table(rows)}\n"
    yield from completing_goals(rows) if pipeline.denoiser.config.completes else whole_scan_goals(rows)


def numbers(scores: Scores) -> Row:
    """The scores that are one number."""
    return {name: value for name, value in vars(scores).items() if isinstance(value, float)}


def completing_goals(rows: Mapping[str, Row]) -> Iterator[Goal]:
    """What completed halves must reach: nearer to streets than a lawn is, and what was given stays."""
    made, bare = rows["generated"], rows["bare"]
    distances = {name: ratio(made[name], bare[name]) for name in ("range", "height", "bev", "classes")}
    yield Goal("JSD of the open halves, generated / bare", distances, most=0.5)
    kept = {"objects": made["objects"] - rows["simulated"]["objects"]}
    yield Goal("the given halves, generated minus simulated", kept, least=-0.01)


def whole_scan_goals(rows: Mapping[str, Row]) -> Iterator[Goal]:
    """What whole scans must reach: their own layouts are in them, others are not, and they look like streets."""
    made = rows["generated"]
    yield Goal("objects that stand as in their own layout", {"objects": made["objects"]}, least=0.5)
    yield Goal("... as in the layout of another street", {"other": made["other"]}, most=0.1)
    yield Goal("JSD to the streets' own scans", {"bev": made["bev"]}, most=0.14)


def with_untrained(pipeline: Pipeline) -> dict[str, Pipeline]:
    """The pipeline, and one of the same network with random weights."""
    untrained = Pipeline(untrained_weights(pipeline.denoiser), steps=pipeline.steps, langevin=pipeline.langevin)
    return {"generated": pipeline, "untrained": untrained}


def compare_seeds(pipeline: Pipeline, sensor: Sensor, number: int) -> Iterator[str | Goal]:
    """How far the open halves of one street are from each other over seeds, beside those of as many streets.

    The same half is open everywhere, or halves would differ by where they lie.
    """
    pairs = unseen_streets(SEEDS, sensor=sensor)
    (is_open,) = half_opened([pairs[0].scan])
    chosen = pairs[: min(number, STREETS)]

    def mean_spread(scans: Sequence[Sequence[RangeImage]]) -> Row:
        return {"BEV": float(np.mean([spread([scan.keep(is_open) for scan in some]) for some in scans]))}

    rows = {
        "other streets": mean_spread([[pair.scan for pair in pairs]]),
        "simulated": mean_spread(
            [
                [simulate(p.layout, sensor, pose=p.pose, speed=p.speed, seed=seed).image for seed in range(SEEDS)]
                for p in chosen
            ]
        ),
    }
    for name, generator in with_untrained(pipeline).items():
        rows[name] = mean_spread(
            [
                [generator.generate(p.condition_image, p.simulated, is_open, seed=seed) for seed in range(SEEDS)]
                for p in chosen
            ]
        )
    yield f"### BEV distance between {SEEDS} seeds, {len(chosen)} streets, the open half\n\n{table(rows)}\n"
    value = {"BEV": ratio(rows["generated"]["BEV"], rows["other streets"]["BEV"])}
    yield Goal(f"{SEEDS} seeds of one street / {SEEDS} streets", value, least=0.8)


def spread(images: Sequence[RangeImage]) -> float:
    """The mean Jensen-Shannon distance between the top views of two scans."""
    histograms = [bev_histogram(image.points()) for image in images]
    pairs = itertools.combinations(histograms, 2)
    return float(np.mean([pooled_divergence([first], [second]) for first, second in pairs]))
