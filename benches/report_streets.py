"""Procedural streets beside recorded scans, property by property: `make report-streets`.

For each sensor of which there are recordings, and which is a preset: streets scanned with its pattern, measured as the
recordings are, in one table, worst property first. "Recorded vs recorded" is the mean distance between recordings of
two drives or places, "streets vs recorded" that between as many streets and each of them; a ratio of 1 says that
streets differ from a drive as another drive does. Below are the shares of classes beside those of each recording, and
which lie within a factor of two of what the recordings have, from the least to the most. The recordings are looked for
in the folder LIDARDRAFT_DATA or --data. With --text the scans are those of a sentence and its surroundings, a seed
each.
"""

from __future__ import annotations

import argparse
import itertools
import json
import math
import multiprocessing
import os
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

import recordings
from comparison import Comparison, compare
from lidardraft import simulate
from lidardraft.cli.arguments import read_sensor
from lidardraft.metrics import lifelike
from lidardraft.metrics.lifelike import CLASS_SETS, Features, Property
from lidardraft.metrics.sweep import Sweep
from lidardraft.scene.range_image import RangeImage
from lidardraft.scene.sensor import PRESETS, Sensor
from lidardraft.streets import StreetConfig, streets
from recordings import Groups, Recordings
from result_page import write_page
from tables import digits

Pooled = dict[str, dict[str, list[float]]]

READERS: dict[str, Callable[[Path, int], Recordings]] = {
    "hdl64e": recordings.hdl64e,
    "pandar64": recordings.pandar64,
    "vlp32c": recordings.vlp32c,
    "os0-128": recordings.os0_128,
    "os1-32": recordings.os1_32,
}
SEED = 2_000_000  # no training uses it
FAR = 2.0  # ratios over this go to the page
RATIOS_PAGE = (
    "properties of streets whose distance to recordings is more than twice that between recordings of two drives, and"
    " the ratio of both."
)
SHARES_PAGE = (
    "returns by class [%] of a sentence's surroundings, a seed each, in the fields of view and the label sets of the"
    ' recordings. "Within 2 x" is within a factor of two of the recordings, from the least to the most.'
)
POSES = 4  # scans of each street: neighbours are alike, as those of a drive are


def main() -> None:
    """Parse, measure, print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--num", type=int, default=200, help="scans of streets a sensor")
    parser.add_argument("--sensors", default=",".join(READERS), help=f"some of {', '.join(READERS)}")
    parser.add_argument("--data", type=Path, default=Path(os.environ.get("LIDARDRAFT_DATA", "")), help="recordings")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="sensors at a time")
    parser.add_argument("--text", help="a sentence, whose scans take the place of those of streets")
    parser.add_argument("--scan-with", help="the file of a sensor like the one in --sensors, to scan the streets with")
    parser.add_argument("--without", help="a group of recordings to leave out, such as the drive that it is fitted to")
    parser.add_argument("--page", action="store_true", help="write what differs to its page in benches/results")
    parser.add_argument("--json", type=Path, help="write what was measured, pooled by group, to this file")
    given = parser.parse_args()
    names = given.sensors.split(",")
    if not set(names) <= set(READERS) or given.num < POSES or given.jobs < 1:
        parser.error(f"sensors are {', '.join(READERS)}, --num is {POSES} or more, --jobs 1 or more")
    if (given.scan_with or given.without) and len(names) > 1:
        parser.error("--scan-with and --without go with one sensor in --sensors")
    if given.scan_with and (shape := read_sensor(given.scan_with).shape) != PRESETS[names[0]].shape:
        wanted = PRESETS[names[0]].shape
        parser.error(f"{given.scan_with} has {shape[0]} x {shape[1]} pixels; {names[0]} has {wanted[0]} x {wanted[1]}")
    with ProcessPoolExecutor(given.jobs, mp_context=multiprocessing.get_context("spawn")) as pool:
        about = given.data, given.num, given.text, given.scan_with, given.without
        sections = [pool.submit(_section, name, *about) for name in names]
        pooled, rows = {}, []
        for name, section in zip(names, sections, strict=True):
            text, pooled[name], row = section.result()
            rows.append(row)
            print(text, flush=True)
    if given.page:
        if given.text:
            write_page("report_surroundings", SHARES_PAGE, "\n".join(map(composition, pooled.values())))
        else:
            write_page("report_streets", RATIOS_PAGE, "\n".join(["| sensor | property, ratio |", "|---|---|", *rows]))
    if given.json:
        given.json.write_text(json.dumps(pooled))


def _section(
    name: str, folder: Path, num: int, text: str | None, scan_with: str | None, without: str | None
) -> tuple[str, Pooled, str]:
    reason = _missing(name, folder)
    if not reason:
        recorded = READERS[name](folder, PRESETS[name].columns)
        reason = recorded.why
    if reason:
        return f"### {name}\n\nSkipped: {reason}.\n", {}, f"| {name} | skipped: {reason} |"
    if without:
        recorded = without_group(recorded, without)
    comparisons, pooled = report(recorded, read_sensor(scan_with or name), num, text)
    far = [f"{one.name} {digits(one.ratio)}" for one in comparisons if one.ratio > FAR]
    told = markdown(recorded, comparisons, f"{num} scans of {text or 'streets'}") + composition(pooled)
    return told, pooled, f"| {name} | {'; '.join(far)} |"


def composition(pooled: Pooled) -> str:
    """The share of each class [%] in each recording and in the streets, and whether these lie within a factor of two of
    what the recordings have, from the least to the most."""
    counts = {name: np.array(values) for name, values in pooled.get("class counts", {}).items()}
    if not counts:
        return ""
    known = np.sum([values for name, values in counts.items() if name != "streets"], axis=0) > 0
    shares = {name: values * known / max((values * known).sum(), 1.0) for name, values in counts.items()}
    made = shares.pop("streets")
    head = f"| share [%] | {' | '.join(shares)} | streets | within 2 x |"
    lines = ["", head, "|---" + "|---:" * (len(shares) + 2) + "|"]
    for at, name in enumerate(CLASS_SETS):
        if known[at]:
            recorded = [values[at] for values in shares.values()]
            near = min(recorded) / 2 <= made[at] <= 2 * max(recorded)
            cells = [digits(100 * share) for share in (*recorded, made[at])]
            lines.append(f"| {name} | {' | '.join(cells)} | {'yes' if near else 'no'} |")
    return "\n".join(lines) + "\n"


def without_group(recorded: Recordings, left_out: str) -> Recordings:
    """The recordings but for one group; exits where there is none of this name."""
    groups: tuple[dict[str, Any], ...] = (recorded.plain, recorded.labelled, recorded.shares)
    names = list(dict.fromkeys(name for group in groups for name in group))
    if left_out not in names:
        raise SystemExit(f"--without is {left_out!r}; the groups are {', '.join(names)}")
    plain, labelled, shares = ({name: one for name, one in group.items() if name != left_out} for group in groups)
    return replace(recorded, plain=plain, labelled=labelled, shares=shares)


def _missing(name: str, folder: Path) -> str:
    if name not in PRESETS:
        return "no preset of this sensor"
    return "" if folder.name and folder.is_dir() else "no recordings; name their folder in LIDARDRAFT_DATA or --data"


def report(recorded: Recordings, sensor: Sensor, num: int, text: str | None = None) -> tuple[list[Comparison], Pooled]:
    """All comparisons, and what they are of: sums over the sweeps of each group and of the streets, or of the scans of
    a sentence, by property."""
    with_intensity = all(sweep.intensity is not None for sweeps in recorded.plain.values() for sweep in sweeps)
    plain = [one for one in lifelike.PROPERTIES if not (recorded.halves and one.name.startswith("top view"))]
    labelled = list(lifelike.class_properties())
    (plain if with_intensity else labelled).extend(lifelike.INTENSITY_PROPERTIES)
    generated: dict[str, list[np.ndarray]] = {one.name: [] for one in (*plain, *labelled)} | {"class counts": []}
    open_plain = unhidden(recorded.plain, sensor, recorded.fov)
    open_labelled = open_plain if recorded.spherical else unhidden(recorded.labelled, sensor, recorded.fov)
    for number, image in enumerate(_progress(sensor, num, text)):
        image = _in_units(image, recorded.range_step)
        values = _measured(plain, _windowed(Sweep.by_azimuth(image.keep(open_plain)), recorded, number))
        if recorded.labelled:
            seen = image.keep(open_labelled)
            sweep = _windowed(
                Sweep.from_image(_as_labelled(seen)) if recorded.spherical else Sweep.by_azimuth(seen), recorded, number
            )
            values |= {**_measured(labelled, sweep), "class counts": lifelike.class_counts(sweep)}
        for name, value in values.items():
            generated[name].append(value)
    properties = {one.name: (one, recorded.plain) for one in plain}
    properties |= {one.name: (one, recorded.labelled) for one in labelled if recorded.labelled}
    groups = {name: _by_group(sweeps, one) for name, (one, sweeps) in properties.items()}
    found = [compare(properties[name][0], measured, generated[name]) for name, measured in groups.items()]
    if recorded.labelled:
        shares = {
            name: [lifelike.class_counts(sweep) for sweep in sweeps] for name, sweeps in recorded.labelled.items()
        }
        # published shares are those of very many scans
        shares |= {name: [1e6 * lifelike.counts_by_set(share)] * num for name, share in recorded.shares.items()}
        found += [compare(one, shares, generated["class counts"]) for one in share_properties(shares)]
        groups["class counts"] = shares
    pooled = {name: _pooled({**measured, "streets": generated[name]}) for name, measured in groups.items()}
    return sorted(found, key=lambda one: math.inf if math.isnan(one.ratio) else -one.ratio), pooled


def share_properties(groups: Mapping[str, Features]) -> tuple[Property, ...]:
    """The shares of `lifelike.class_counts`: all together (total variation), then each class that a group knows."""
    known = np.sum([np.sum(features, axis=0) for features in groups.values()], axis=0) > 0

    def shares(features: Features) -> np.ndarray:
        counts = np.where(known, np.sum(features, axis=0), 0.0)
        return counts / max(counts.sum(), 1.0)

    def share_of(name: str, at: int) -> Property:
        return Property(
            f"share of {name}",
            lifelike.class_counts,
            lambda first, second: float(abs(shares(first)[at] - shares(second)[at])),
            lambda features: float(shares(features)[at]),
        )

    everything = Property(
        "shares of all classes (total variation)",
        lifelike.class_counts,
        lambda first, second: float(np.abs(shares(first) - shares(second)).sum() / 2),
        lambda _: math.nan,
    )
    return (everything, *(share_of(name, at) for at, name in enumerate(CLASS_SETS) if known[at]))


def unhidden(groups: Groups, sensor: Sensor, fov: float | None) -> np.ndarray:
    """Pixels [H, W] that the recording car leaves open; what its own body hides, no street can show.

    Hidden is a firing that looks down by 5 degrees or more and returned in less than a tenth of the recorded sweeps,
    and a whole row or column without any return. Of half sweeps it is not known.
    """
    sweeps = [sweep.valid for group in groups.values() for sweep in group]
    if not sweeps or (fov is None and sweeps[0].shape != sensor.shape):
        return np.ones(sensor.shape, dtype=bool)
    rate = np.mean(sweeps, axis=0)
    down = np.array(sensor.elevations)[:, None] < math.radians(-5.0)
    shown = ~(down & (rate < 0.1)) & rate.any(axis=0)[None] & rate.any(axis=1)[:, None]
    around = np.zeros(sensor.shape, dtype=bool)
    start = (sensor.columns - shown.shape[1]) // 2 if fov is not None else 0
    around[:, start : start + shown.shape[1]] = shown
    return around


def _in_units(image: RangeImage, step: float) -> RangeImage:
    return replace(image, depth=np.rint(image.depth / np.float32(step)) * np.float32(step)) if step else image


def _progress(sensor: Sensor, num: int, text: str | None) -> Iterator[RangeImage]:
    start = time.monotonic()
    if text is None:
        scans = (pair.scan for pair in streets(seed=SEED, config=StreetConfig(sensor=sensor, poses_per_street=POSES)))
    else:
        scans = (simulate(text, sensor, seed=seed).image for seed in itertools.count())
    for done, scan in enumerate(itertools.islice(scans, num)):
        yield scan
        if (done + 1) % 20 == 0 or done + 1 == num:
            said = f"{sensor.name}: {done + 1} of {num} scans, {time.monotonic() - start:.0f} s"
            print(said, file=sys.stderr, flush=True)


def _measured(properties: list[Property], sweep: Sweep) -> dict[str, np.ndarray]:
    return {one.name: one.measure(sweep) for one in properties}


def _by_group(groups: Groups, measured: Property) -> dict[str, list[np.ndarray]]:
    return {name: [measured.measure(sweep) for sweep in sweeps] for name, sweeps in groups.items()}


def _windowed(sweep: Sweep, recorded: Recordings, number: int) -> Sweep:
    """As much of a sweep of streets as the recordings have; of halves, the left and the right one in turn."""
    columns = sweep.points.shape[1]
    if recorded.halves:
        right = number // 3 % 2  # in an order of its own: `compare` takes sweeps at a stride
        return sweep.part(right * columns // 2, (right + 1) * columns // 2)
    if recorded.fov is None:
        return sweep
    half = round(columns * recorded.fov / (4 * math.pi))
    return sweep.part(columns // 2 - half, columns // 2 + half)


def _as_labelled(image: RangeImage) -> RangeImage:
    """The image in the usual projection of KITTI, as its labelled scans are."""
    valid = image.valid
    intensity = None if image.intensity is None else image.intensity[valid]
    return RangeImage.project(image.points(), PRESETS["hdl64e-linear"], label=image.label[valid], intensity=intensity)


def _pooled(groups: dict[str, list[np.ndarray]]) -> dict[str, list[float]]:
    return {name: np.sum(values, axis=0).tolist() for name, values in groups.items() if len(values)}


def markdown(recorded: Recordings, comparisons: list[Comparison], scans: str) -> str:
    """The table of a sensor, in Markdown."""
    said = [f"{name} ({len(sweeps)})" for name, sweeps in {**recorded.plain, **recorded.labelled}.items()] + list(
        recorded.shares
    )
    text = [f"### {recorded.sensor}", "", f"{scans} beside {', '.join(said)}.", ""]
    text += [
        "| property | recorded | streets | recorded vs recorded | streets vs recorded | ratio |",
        "|---|---:|---:|---:|---:|---:|",
    ]
    for one in comparisons:
        cells = (one.recorded, one.generated, one.recorded_vs_recorded, one.generated_vs_recorded, one.ratio)
        text.append(f"| {one.name} | {' | '.join(digits(value) for value in cells)} |")
    return "\n".join(text) + "\n"


if __name__ == "__main__":
    main()
