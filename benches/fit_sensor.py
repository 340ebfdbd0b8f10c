"""The sensor model fitted to recordings: the numbers of docs/explanation/sensor-model.md, printed as Markdown.

    python benches/fit_sensor.py FOLDER

FOLDER is `permissive` in the folder of recordings. It holds `pandaset/*/*.npz` (xyz, intensity, device, label of
PandaSet's frames, near the sensor's frame) and
`pjlab_pandar64/*.pcd` (sweeps with rings), both of a Pandar64, `ika_vlp32c/*.npy.xz` (images of a VLP-32C), and
`ouster/*.pcap` (samples of an OS0 and an OS1).
"""

from __future__ import annotations

import io
import itertools
import lzma
import sys
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

import recordings
from lidardraft.calibration import surface_groups
from lidardraft.calibration.beam_table import fit_blocked
from lidardraft.calibration.receiver import bisected, edge_drops
from lidardraft.calibration.street_casts import StreetCasts
from lidardraft.formats.pcd import read_pcd
from lidardraft.metrics.sweep import Sweep
from lidardraft.scene.materials import MATERIAL_BY_NAME, Material, diffuse_response, leaf_response, response
from lidardraft.scene.sensor import PRESETS, Sensor
from lidardraft.scene.sensor_model import MODELS, SensorModel
from lidardraft.semantics import BY_NAME
from lidardraft.streets import StreetConfig, streets

MODEL = MODELS["pandar64"]
ROAD = BY_NAME["road"].id
# Smooth enough for noise to show.
SURFACES = tuple(BY_NAME[name].id for name in ("road", "sidewalk", "building", "car"))
GAIN = 255.0 / MODEL.full_scale  # what a white surface that faces the sensor reads
# Ids of PandaSet's classes and the material that stands for them.
CLASSES = {
    "road": ((7,), "asphalt"),
    "sidewalk": ((11, 12), "paving"),
    "building": ((41,), "plaster"),
    "car": ((13, 14), "mid-paint"),
}
INCIDENCES = (0.02, 0.1, 0.2, 0.3, 0.5, 0.7, 0.9, 1.0)
POWERS = (3.0, 10.0, 30.0, 100.0, 300.0, 1000.0, 3000.0, 100_000.0)
RANGES = (0.0, 5.0, 10.0, 15.0, 20.0, 30.0, 40.0, 60.0)
NEIGHBOURS = 20
COLUMNS = 1800
# Lower quartile of the absolute value of noise of standard deviation 1. The quartile, for not all surfaces are smooth.
QUARTILE = 0.3186
SMOOTH = 2 * np.pi / COLUMNS  # m a firing and metre of range, by which surfaces may slant: 45 degrees, and
FLAT = 0.03  # m, at any range
HEIGHT = 2.0  # m of the sensor over the ground
LONGEST = 8  # columns that a hole in a surface may be wide
STREETS, SEED = 24, 5_000_000  # that edges are held against
EDGE_DROPS = (1e-3, 5.0)
LAGS = (1, 3, 8, 32)  # columns
UNLABELLED = {
    "ground": (surface_groups.LANE, surface_groups.GROUND),
    "high and smooth": (surface_groups.SMOOTH,),
}
LABELLED = {name: (BY_NAME[name].id,) for name in ("road", "sidewalk", "building", "vegetation")}


def planes(points: np.ndarray, step: int) -> tuple[np.ndarray, np.ndarray]:
    """Planes at every `step`-th of points [N, 3]: indices of its points [M, 20], cosine of incidence."""
    chosen = np.arange(0, len(points), step)
    near = cKDTree(points).query(points[chosen], k=NEIGHBOURS)[1]
    offsets = points[near] - points[near].mean(axis=1, keepdims=True)
    values, vectors = np.linalg.eigh(np.einsum("nki,nkj->nij", offsets, offsets))
    rays = points[chosen] / np.linalg.norm(points[chosen], axis=1, keepdims=True)
    cosine = np.abs(np.einsum("ni,ni->n", rays, vectors[:, :, 0]))
    noise = np.sqrt(np.maximum(values[:, 0], 0.0) / (NEIGHBOURS - 3)) / np.maximum(cosine, 1e-3)
    # neighbours along a line do not define a plane
    flat = (values[:, 1] > 0.03 * values[:, 2]) & (noise * cosine < 0.05)
    return near[flat], cosine[flat]


def fit_roughness(cosine: np.ndarray, intensity: np.ndarray) -> tuple[float, float]:
    """Intensity of a facing surface and slope spread of Oren and Nayar [rad] that fit the medians by incidence best."""
    bins = np.digitize(cosine, INCIDENCES)
    filled = [b for b in range(1, len(INCIDENCES)) if (bins == b).sum() >= 40]
    centres = np.array([np.median(cosine[bins == b]) for b in filled])
    medians = np.array([np.median(intensity[bins == b]) for b in filled])
    best = (np.inf, 0.0, 0.0)
    for roughness in np.arange(0.0, 1.55, 0.05):
        shape = diffuse_response(Material("", 1.0, roughness=float(roughness)), centres)
        scale = (shape @ medians) / (shape @ shape)
        best = min(best, (float(np.square(scale * shape - medians).sum()), float(scale), float(roughness)))
    return best[1:]


def fit_noise(power: np.ndarray, noise: np.ndarray) -> tuple[float, float, list[tuple[float, float]]]:
    """`range_sigma` and `jitter` [m] of sigma^2 = range_sigma^2 + jitter^2 / power, and the bins they are fitted to."""
    rows = []
    for low, high in pairwise(POWERS):
        inside = (power >= low) & (power < high)
        if inside.sum() >= 40:
            rows.append((float(np.median(power[inside])), float(np.quantile(noise[inside], 0.25)) / QUARTILE))
    powers, sigmas = np.array(rows).T
    design = np.stack([np.ones_like(powers), 1.0 / powers], axis=1) / sigmas[:, None] ** 2
    solution = np.linalg.lstsq(design, np.ones_like(powers), rcond=None)[0]
    sigma, jitter = np.sqrt(np.maximum(solution, 0.0))
    return float(sigma), float(jitter), rows


def holes(ranges: np.ndarray, ground: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Range of each ground return [N] and how many columns after it are dropped before the next of its like.

    `ranges` [H, W] are distances of returns, 0 where there is none; `ground` is True for those of the ground.
    """
    before, dropped = [], []
    for row, flat in zip(ranges, ground, strict=True):
        seen = np.flatnonzero(row)
        first, second = row[seen[:-1]], row[seen[1:]]
        width = np.diff(seen) - 1
        alike = (np.abs(first - second) < 0.03 * first + 0.1) & (width <= LONGEST)
        alike &= flat[seen[:-1]] & flat[seen[1:]]
        before.append(first[alike])
        dropped.append(width[alike])
    return np.concatenate(before), np.concatenate(dropped)


def images(columns: dict[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Distance of a sweep's returns by ring and column, and which are ground: [64, 1800].

    Each ring's columns start where its returns do.
    """
    x, y, z = (columns[name].astype(np.float64) for name in "xyz")
    finite = np.isfinite(x)
    distance, azimuth = np.sqrt(x * x + y * y + z * z), np.arctan2(y, x) * COLUMNS / (2 * np.pi)
    ranges, heights = np.zeros((2, 64, COLUMNS))
    for ring in range(64):
        ours = finite & (columns["ring"] == ring)
        phase = np.angle(np.exp(2j * np.pi * azimuth[ours]).sum()) / (2 * np.pi)
        column = np.round(azimuth[ours] - phase).astype(int) % COLUMNS
        ranges[ring, column], heights[ring, column] = distance[ours], z[ours]
    return ranges, heights < -HEIGHT + 0.4


def report_walls(folder: Path) -> None:
    """Intensity by class and incidence, and grain, in PandaSet."""
    gathered: dict[str, list[np.ndarray]] = {name: [] for name in CLASSES}
    for path in sorted(folder.glob("pandaset/*/*.npz")):
        frame = np.load(path)
        for name, (ids, _) in CLASSES.items():
            ours = (frame["device"] == 0) & np.isin(frame["label"], ids)
            points, intensity = frame["xyz"][ours].astype(np.float64), frame["intensity"][ours].astype(np.float64)
            near, cosine = planes(points, 7)
            level = intensity[near]
            grain = level.std(axis=1) / np.maximum(level.mean(axis=1), 1.0)
            gathered[name].append(np.stack([cosine, np.median(level, axis=1), grain]))
    print("| class | incidence | planes | median | mean | model |\n|---|---|---:|---:|---:|---:|")
    for name, (_, material) in CLASSES.items():
        cosine, intensity, grain = np.concatenate(gathered[name], axis=1)
        for low, high in pairwise(INCIDENCES):
            inside = (cosine >= low) & (cosine < high)
            if inside.sum() >= 40:
                expected = GAIN * response(MATERIAL_BY_NAME[material], np.median(cosine[inside], keepdims=True))[0]
                median, mean = np.median(intensity[inside]), intensity[inside].mean()
                print(f"| {name} | {low:g} to {high:g} | {inside.sum()} | {median:.0f} | {mean:.0f} | {expected:.1f} |")
        facing, roughness = fit_roughness(cosine, intensity)
        fitted = f"{facing:.1f} facing, slopes of {roughness:.2f} rad, grain {np.median(grain):.2f}"
        print(f"| {name} | fit: {fitted} | | | | |")


def bends(sweep: Sweep, labels: tuple[int, ...] | None) -> tuple[np.ndarray, np.ndarray]:
    """How far returns of smooth pieces of some classes lie off the middle of their neighbours in the row [N], and where
    in the sweep they are: a mask [H, W]."""
    depth = sweep.depth.astype(np.float64)
    before, after = np.roll(depth, 1, axis=1), np.roll(depth, -1, axis=1)
    smooth = (depth > 0) & (before > 0) & (after > 0) & (np.abs(after - before) / 2 < SMOOTH * depth + FLAT)
    smooth[:, [0, -1]] = False
    if labels is not None and sweep.label is not None:
        ours = np.isin(sweep.label, labels)
        smooth &= ours & np.roll(ours, 1, axis=1) & np.roll(ours, -1, axis=1)
    return (depth - (before + after) / 2)[smooth], smooth


def report_noise(name: str, sweeps: list[Sweep], model: SensorModel, labels: tuple[int, ...] | None) -> None:
    """Range noise by power, from the bends in the rows of some classes."""
    rng, found = np.random.default_rng(0), []
    for sweep in sweeps:
        assert sweep.intensity is not None
        off, where = bends(sweep, labels)
        off += rng.uniform(-0.5, 0.5, len(off)) * model.range_step / 2  # its steps would show in the quartiles
        read = np.maximum(sweep.intensity[where], 0.5 / 255)
        response = read / model.knee if model.knee < 1.0 else read * model.full_scale
        found.append((response / sweep.depth[where] ** 2 / model.detection_threshold, np.abs(off) / np.sqrt(1.5)))
    power, noise = (np.concatenate(parts) for parts in zip(*found, strict=True))
    sigma, jitter, rows = fit_noise(power, noise)
    print(f"\n| {name}: power | range noise [m] | fit |\n|---:|---:|---:|")
    for middle, measured in rows:
        print(f"| {middle:.0f} | {measured:.4f} | {np.sqrt(sigma**2 + jitter**2 / middle):.4f} |")
    print(f"\nrange_sigma {sigma:.4f} m, jitter {jitter:.3f} m")


def report_tilts(name: str, sweeps: list[Sweep], elevations: tuple[float, ...]) -> None:
    """How far each laser's points on the road lie from its neighbours', as an angle, by the step between lasers."""
    found: dict[int, list[float]] = {}
    for sweep in sweeps:
        assert sweep.label is not None
        road = (sweep.label == ROAD) & sweep.valid & (sweep.depth < 35.0)
        whole = np.logical_and.reduce([road[i : len(road) - 2 + i, j : road.shape[1] - 4 + j]
                                       for i in range(3) for j in range(5)])  # fmt: skip
        rows, columns = np.nonzero(whole)
        points = np.median([[sweep.points[rows + i, columns + j] for j in range(5)] for i in range(3)], axis=1)
        out, height = np.linalg.norm(points[..., :2], axis=2), points[..., 2]
        share = (out[1] - out[0]) / np.where(out[2] != out[0], out[2] - out[0], np.inf)
        angle = (height[1] - height[0] - share * (height[2] - height[0])) / np.linalg.norm(points[1], axis=1)
        between = (share > 0.15) & (share < 0.85)
        for row, value in zip(rows[between] + 1, angle[between], strict=True):
            found.setdefault(int(row), []).append(float(value))
    steps = -np.diff(elevations)
    print(f"\n| {name}: step to the next laser [degrees] | lasers | off their neighbours [mrad] |\n|---|---:|---:|")
    for low, high in ((0.0, 0.5), (0.5, 10.0)):
        angles = [np.median(values) for row, values in found.items()
                  if len(values) >= 60 and low <= np.rad2deg(min(steps[row - 1], steps[row])) < high]  # fmt: skip
        if angles:
            print(f"| {low:g} to {high:g} | {len(angles)} | {1e3 * np.sqrt(np.mean(np.square(angles))):.2f} |")


def report_leaves(folder: Path) -> None:
    """The intensity of leaves, which do not know incidence, in PandaSet."""
    frames = [np.load(path) for path in sorted(folder.glob("pandaset/*/*.npz"))]
    for name, label, expected in (("vegetation", 5, leaf_response(MATERIAL_BY_NAME["foliage"])), ("person", 30, 0.40)):
        level = np.concatenate([f["intensity"][(f["device"] == 0) & (f["label"] == label)] for f in frames])
        print(f"\n{name}: median {np.median(level):.0f}, model {GAIN * expected:.1f}, quartiles "
              f"{np.quantile(level, 0.25):.0f} to {np.quantile(level, 0.75):.0f}")  # fmt: skip


def report_holes(name: str, found: list[tuple[np.ndarray, np.ndarray]], model: SensorModel) -> None:
    """Share and runs of dropped rays to the ground by range, of images' `holes`."""
    before, dropped = (np.concatenate(parts) for parts in zip(*found, strict=True))
    print(f"\n| {name}: ground at [m] | rays | dropped | model | mean run |\n|---|---:|---:|---:|---:|")
    for low, high in pairwise(RANGES):
        inside = (before >= low) & (before < high)
        rays, drops = inside.sum() + dropped[inside].sum(), dropped[inside].sum()
        if rays < 1000:
            continue
        distance = before[inside]
        echo = response(MATERIAL_BY_NAME["asphalt"], HEIGHT / np.maximum(distance, HEIGHT))
        expected = 1.0 - np.exp(-2.0 * (model.detection_threshold * distance**2 / echo) ** 1.25 - model.drop_exponent)
        run = drops / (dropped[inside] > 0).sum()
        print(f"| {low:g} to {high:g} | {rays} | {drops / rays:.4f} | {expected.mean():.4f} | {run:.2f} |")


def report_edges(places: dict[str, list[Sweep]], sensor: Sensor, model: SensorModel) -> None:
    """Share of the firings between near and far surfaces that are lost, and the `edge_drop` with which streets lose as
    many."""
    casts = StreetCasts.from_sensor(sensor, model, STREETS, seed=SEED)

    def lost(edge_drop: float) -> float:
        return edge_drops(casts.observed(replace(model, edge_drop=edge_drop), sensor.range_sigma))

    print(f"\n| {sensor.name}: edges of | lost | edge_drop |\n|---|---:|---:|")
    found = {place: edge_drops(sweeps) for place, sweeps in places.items()}
    for place, share in found.items():
        print(f"| {place} | {share:.3f} | {bisected(lost, share, EDGE_DROPS):.3f} |")
    print(f"| streets, edge_drop {model.edge_drop:g} | {lost(model.edge_drop):.3f} | |")


def scatter(sweeps: list[Sweep], groups: tuple[int, ...]) -> list[float]:
    """By how much readings of 4 of 255 or more differ from those of the same surface LAGS further on, over their mean;
    of sweeps with labels `groups` are classes, else those of `surface_groups`."""
    differences: list[list[np.ndarray]] = [[] for _ in LAGS]
    for sweep in sweeps:
        assert sweep.intensity is not None
        of = surface_groups.groups_of(sweep, labelled=False) if sweep.label is None else sweep.label
        mine = np.isin(of, groups) & sweep.valid & (sweep.intensity > 3 / 255)
        for lag, found in zip(LAGS, differences, strict=True):
            (depth, one), (further, other) = ((sweep.depth[:, at], sweep.intensity[:, at])
                                              for at in (slice(lag, None), slice(-lag)))  # fmt: skip
            both = mine[:, lag:] & mine[:, :-lag] & (np.abs(depth - further) < 0.03 * depth + 0.1)
            found.append(np.minimum(2 * np.abs(one - other) / np.maximum(one + other, 1e-6), 1.0)[both])
    return [float(np.concatenate(found).mean()) for found in differences]


def street_sweeps(sensor: Sensor) -> list[Sweep]:
    """A scan of each of STREETS streets."""
    pairs = itertools.islice(streets(seed=SEED, config=StreetConfig(sensor=sensor, poses_per_street=1)), STREETS)
    return [Sweep.by_azimuth(pair.scan) for pair in pairs]


def report_scatter(sensor: Sensor, places: dict[str, list[Sweep]]) -> None:
    """How much neighbouring readings differ in recordings and in streets."""
    made = street_sweeps(sensor)
    labelled = all(sweep.label is not None for sweeps in places.values() for sweep in sweeps)
    if not labelled:
        made = [replace(sweep, label=None) for sweep in made]
    lags = f"{' | '.join(map(str, LAGS))} columns on"
    print(f"\n| {sensor.name}: readings of | in | {lags} |\n|---|---|{'---:|' * len(LAGS)}")
    for surface, groups in (LABELLED if labelled else UNLABELLED).items():
        for place, sweeps in (places | {"streets": made}).items():
            print(f"| {surface} | {place} | {' | '.join(f'{value:.3f}' for value in scatter(sweeps, groups))} |")


def report_hidden(name: str, sweeps: list[Sweep], sensor: Sensor) -> None:
    """Print the sectors that the vehicle hides, and those of them without any return [degrees]."""
    for said, height in (("hidden by the vehicle", sensor.mount_height), ("of these without any return", 0.0)):
        lasers = fit_blocked(sweeps, np.array(sensor.elevations), height)
        rows = {row: np.rad2deg(sectors).round(1).tolist() for row, sectors in enumerate(lasers) if sectors}
        print(f"{name}, {said}: {rows}")


def main(folder: Path) -> None:
    """Print all of it."""
    report_walls(folder)
    report_leaves(folder)
    sweeps = [read_pcd(path).columns for path in sorted(folder.glob("pjlab_pandar64/*.pcd"))]
    report_holes("Pandar64", [holes(*images(sweep)) for sweep in sweeps if "ring" in sweep], MODEL)
    scans = [
        np.load(io.BytesIO(lzma.decompress(path.read_bytes()))) for path in sorted(folder.glob("ika_vlp32c/*.npy.xz"))
    ]
    # the depth, and the labels of road and sidewalk
    for name, read in (("pandar64", recordings.pandar64), ("vlp32c", recordings.vlp32c)):
        labelled = [sweep for group in read(folder.parent, COLUMNS).labelled.values() for sweep in group]
        report_noise(name, labelled, MODELS[name], SURFACES)
        report_tilts(name, labelled, PRESETS[name].elevations)
        report_scatter(replace(PRESETS[name], columns=COLUMNS), read(folder.parent, COLUMNS).labelled)
    pandar64 = recordings.pandar64(folder.parent, COLUMNS)
    report_hidden("PandaSet 002", pandar64.labelled["PandaSet 002"], PRESETS["pandar64"])
    pjlab = {"PJLab, all": [sweep for group in pandar64.plain.values() for sweep in group]}
    report_edges(pandar64.plain | pjlab | pandar64.labelled, PRESETS["pandar64"], MODEL)
    for name, read in (("os0-128", recordings.os0_128), ("os1-32", recordings.os1_32)):
        halves = [sweep for group in read(folder.parent, 1024).plain.values() for sweep in group]
        report_noise(name, halves, MODELS[name], None)
        report_scatter(PRESETS[name], read(folder.parent, 1024).plain)
    report_holes("VLP-32C", [holes(scan[..., 4], scan[..., 5] <= 1) for scan in scans], MODELS["vlp32c"])


if __name__ == "__main__":
    main(Path(sys.argv[1]))
