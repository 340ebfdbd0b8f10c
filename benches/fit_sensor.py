"""What recordings say of the sensor model: the numbers of docs/sensor-model.md, printed as Markdown.

    python benches/fit_sensor.py FOLDER

FOLDER holds `pandaset/*/*.npz` (xyz, intensity, device, label of PandaSet's frames, near the sensor's frame) and
`pjlab_pandar64/*.pcd` (sweeps with rings), both of a Pandar64, and `ika_vlp32c/*.npy.xz` (images of a VLP-32C).
"""

from __future__ import annotations

import io
import lzma
import struct
import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from lidardraft.scene.materials import MATERIAL_BY_NAME, Material, diffuse_response, leaf_response, response
from lidardraft.scene.sensor_model import MODELS, SensorModel

MODEL = MODELS["pandar64"]
GAIN = 255.0 / MODEL.full_scale  # what a white surface that faces the sensor reads
# Ids of PandaSet's classes and the material that stands for them.
CLASSES = {
    "road": ((7,), "asphalt"),
    "sidewalk": ((11, 12), "paving"),
    "building": ((41,), "plaster"),
    "car": ((13, 14), "mid-paint"),
}
INCIDENCES = (0.02, 0.1, 0.2, 0.3, 0.5, 0.7, 0.9, 1.0)
POWERS = (10.0, 30.0, 100.0, 300.0, 1000.0, 3000.0, 100_000.0)
RANGES = (0.0, 5.0, 10.0, 15.0, 20.0, 30.0, 40.0, 60.0)
NEIGHBOURS = 20
# Lower quartile of the root mean square of noise of standard deviation 1 about a plane through 20 points: that of chi
# of 17 degrees of freedom over its root. The quartile, for walls are not planes everywhere.
QUARTILE = 0.868
COLUMNS = 1800
HEIGHT = 2.0  # m of the sensor over the ground
LONGEST = 8  # columns that a hole in a surface may be wide


def planes(points: np.ndarray, step: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Planes at every `step`-th of points [N, 3]: indices of its points [M, 20], cosine of incidence, noise [m]."""
    chosen = np.arange(0, len(points), step)
    near = cKDTree(points).query(points[chosen], k=NEIGHBOURS)[1]
    offsets = points[near] - points[near].mean(axis=1, keepdims=True)
    values, vectors = np.linalg.eigh(np.einsum("nki,nkj->nij", offsets, offsets))
    rays = points[chosen] / np.linalg.norm(points[chosen], axis=1, keepdims=True)
    cosine = np.abs(np.einsum("ni,ni->n", rays, vectors[:, :, 0]))
    noise = np.sqrt(np.maximum(values[:, 0], 0.0) / (NEIGHBOURS - 3)) / np.maximum(cosine, 1e-3)
    # neighbours along a line say nothing of a plane
    flat = (values[:, 1] > 0.03 * values[:, 2]) & (noise * cosine < 0.05)
    return near[flat], cosine[flat], noise[flat]


def fit_roughness(cosine: np.ndarray, intensity: np.ndarray) -> tuple[float, float]:
    """Intensity of a facing surface and slope spread of Oren and Nayar [rad] that say the medians by incidence best."""
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
    """Range of each ground return [N] and how many columns after it are lost before the next of its like.

    `ranges` [H, W] are distances of returns, 0 where there is none; `ground` says which are of the ground.
    """
    before, lost = [], []
    for row, flat in zip(ranges, ground, strict=True):
        seen = np.flatnonzero(row)
        first, second = row[seen[:-1]], row[seen[1:]]
        width = np.diff(seen) - 1
        alike = (np.abs(first - second) < 0.03 * first + 0.1) & (width <= LONGEST)
        alike &= flat[seen[:-1]] & flat[seen[1:]]
        before.append(first[alike])
        lost.append(width[alike])
    return np.concatenate(before), np.concatenate(lost)


def read_pcd(path: Path) -> dict[str, np.ndarray]:
    """The columns of a PCD file of DATA binary_compressed."""
    content = path.read_bytes()
    end = content.index(b"\n", content.index(b"DATA")) + 1
    header = {line.split()[0]: line.split()[1:] for line in content[:end].decode().splitlines()}
    packed, _ = struct.unpack("<II", content[end : end + 8])
    raw = _unpacked(content[end + 8 : end + 8 + packed])
    columns, start, count = {}, 0, int(header["POINTS"][0])
    for name, kind, size in zip(header["FIELDS"], header["TYPE"], header["SIZE"], strict=True):
        columns[name] = np.frombuffer(raw, f"<{kind.lower()}{size}", count, start)
        start += columns[name].nbytes
    return columns


def _unpacked(packed: bytes) -> bytes:
    """Data compressed with LZF: literals, and references back to what is already there."""
    out, i = bytearray(), 0
    while i < len(packed):
        control = packed[i]
        i += 1
        if control < 32:
            out += packed[i : i + control + 1]
            i += control + 1
            continue
        length = control >> 5
        if length == 7:
            length += packed[i]
            i += 1
        start = len(out) - ((control & 31) << 8) - packed[i] - 1
        i += 1
        for k in range(length + 2):
            out.append(out[start + k])
    return bytes(out)


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
    """Intensity by class and incidence, grain, and range noise, in PandaSet."""
    gathered: dict[str, list[np.ndarray]] = {name: [] for name in CLASSES}
    for path in sorted(folder.glob("pandaset/*/*.npz")):
        frame = np.load(path)
        for name, (ids, _) in CLASSES.items():
            ours = (frame["device"] == 0) & np.isin(frame["label"], ids)
            points, intensity = frame["xyz"][ours].astype(np.float64), frame["intensity"][ours].astype(np.float64)
            near, cosine, noise = planes(points, 7)
            level = intensity[near]
            grain = level.std(axis=1) / np.maximum(level.mean(axis=1), 1.0)
            distance = np.linalg.norm(points[near[:, 0]], axis=1)
            gathered[name].append(np.stack([cosine, noise, np.median(level, axis=1), grain, distance]))
    print("| class | incidence | planes | median | mean | model |\n|---|---|---:|---:|---:|---:|")
    found = {}
    for name, (_, material) in CLASSES.items():
        cosine, noise, intensity, grain, distance = found[name] = np.concatenate(gathered[name], axis=1)
        for low, high in pairwise(INCIDENCES):
            inside = (cosine >= low) & (cosine < high)
            if inside.sum() >= 40:
                said = GAIN * response(MATERIAL_BY_NAME[material], np.median(cosine[inside], keepdims=True))[0]
                median, mean = np.median(intensity[inside]), intensity[inside].mean()
                print(f"| {name} | {low:g} to {high:g} | {inside.sum()} | {median:.0f} | {mean:.0f} | {said:.1f} |")
        facing, roughness = fit_roughness(cosine, intensity)
        fitted = f"{facing:.1f} facing, slopes of {roughness:.2f} rad, grain {np.median(grain):.2f}"
        print(f"| {name} | fit: {fitted} | | | | |")
    cosine, noise, intensity, _, distance = found["building"]
    power = np.maximum(intensity, 0.5) / GAIN / distance**2 / MODEL.faintest
    sigma, jitter, rows = fit_noise(power[cosine > 0.5], noise[cosine > 0.5])
    print("\n| power | range noise [m] | fit |\n|---:|---:|---:|")
    for middle, measured in rows:
        print(f"| {middle:.0f} | {measured:.4f} | {np.sqrt(sigma**2 + jitter**2 / middle):.4f} |")
    print(f"\nrange_sigma {sigma:.4f} m, jitter {jitter:.3f} m")


def report_leaves(folder: Path) -> None:
    """The intensity of leaves, which do not know incidence, in PandaSet."""
    frames = [np.load(path) for path in sorted(folder.glob("pandaset/*/*.npz"))]
    for name, label, said in (("vegetation", 5, leaf_response(MATERIAL_BY_NAME["foliage"])), ("person", 30, 0.40)):
        level = np.concatenate([f["intensity"][(f["device"] == 0) & (f["label"] == label)] for f in frames])
        print(f"\n{name}: median {np.median(level):.0f}, model {GAIN * said:.1f}, quartiles "
              f"{np.quantile(level, 0.25):.0f} to {np.quantile(level, 0.75):.0f}")  # fmt: skip


def report_holes(name: str, found: list[tuple[np.ndarray, np.ndarray]], model: SensorModel) -> None:
    """Share and runs of lost rays on the ground by range, of images' `holes`."""
    before, lost = (np.concatenate(parts) for parts in zip(*found, strict=True))
    print(f"\n| {name}: ground at [m] | rays | lost | model | mean run |\n|---|---:|---:|---:|---:|")
    for low, high in pairwise(RANGES):
        inside = (before >= low) & (before < high)
        rays, gone = inside.sum() + lost[inside].sum(), lost[inside].sum()
        if rays < 1000:
            continue
        distance = before[inside]
        echo = response(MATERIAL_BY_NAME["asphalt"], HEIGHT / np.maximum(distance, HEIGHT))
        said = 1.0 - np.exp(-model.faintest * distance**2 / echo - model.chance)
        run = gone / (lost[inside] > 0).sum()
        print(f"| {low:g} to {high:g} | {rays} | {gone / rays:.4f} | {said.mean():.4f} | {run:.2f} |")


def main(folder: Path) -> None:
    """Print all of it."""
    report_walls(folder)
    report_leaves(folder)
    sweeps = [read_pcd(path) for path in sorted(folder.glob("pjlab_pandar64/*.pcd"))]
    report_holes("Pandar64", [holes(*images(sweep)) for sweep in sweeps if "ring" in sweep], MODEL)
    scans = [
        np.load(io.BytesIO(lzma.decompress(path.read_bytes()))) for path in sorted(folder.glob("ika_vlp32c/*.npy.xz"))
    ]
    # the depth, and the labels of road and sidewalk
    report_holes("VLP-32C", [holes(scan[..., 4], scan[..., 5] <= 1) for scan in scans], MODELS["vlp32c"])


if __name__ == "__main__":
    main(Path(sys.argv[1]))
