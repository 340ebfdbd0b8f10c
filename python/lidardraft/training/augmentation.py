"""Random changes of scans, so that a network does not learn properties that only scans of streets share."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lidardraft.scene.sensor import Sensor
from lidardraft.semantics import BY_NAME, GROUND, NUM_CLASSES
from lidardraft.training.sources import PairFolder

# Classes that are rare in a street and small in an image: pasted from one scan into another.
_PASTED = [
    BY_NAME[name].id
    for name in ("person", "rider", "bicycle", "motorcycle", "truck", "bus", "train", "pole", "traffic-sign")
]
# What a bare scan lacks: buildings, plants, or all but the ground. Context that streets always have is not learned.
_BARED = tuple(
    [BY_NAME[name].id for name in names]
    for names in (("building",), ("vegetation", "trunk"), BY_NAME.keys() - set(GROUND))
)
_BESIDE_ROADS = [BY_NAME[name].id for name in ("sidewalk", "terrain")]
_HILLS = (25.0, 100.0)  # m, shortest and longest wave


@dataclass(frozen=True, kw_only=True)
class Augmentation:
    """The amount of change; the figures are estimates of how far sensors and mounts differ.

    `mix` is the probability that a sector comes from another scan, `paste` that rare objects come from another scan.
    `tilt` [rad] and `height` [m] are standard deviations of the sensor's pose, `hills` [m] that of each of two waves of
    25 to 100 m that bend the ground, `levels` [m] that of the height of sidewalks and terrain beside the road, `beam`
    [rad] that of each beam's elevation. The ranges of a scan scatter by up to
    `noise` [m], with another deviation for each scan. Up to about `drop` of the returns are removed at random, and up
    to `drop_rows` of the beams. `bare` is the probability that all buildings, all plants or all but the ground go.

    Intensities are raised to a power of spread `gamma`, scaled class by class with the spread `surface` and return by
    return with `speckle`, all in natural logarithms. They are unknown with the probability `no_intensity`. Roads of
    PandaSet (Xiao et al., ITSC 2021) have 0.15 to 1.04 of the mean intensity of their scans (5 to 95 %), far more
    spread than a world of few materials.
    """

    mix: float = 0.5
    paste: float = 0.7
    tilt: float = 0.015
    height: float = 0.1
    hills: float = 0.25
    levels: float = 0.03
    beam: float = 0.0015
    noise: float = 0.03
    drop: float = 0.3
    drop_rows: float = 0.1
    bare: float = 0.2
    gamma: float = 0.25
    surface: float = 0.4
    speckle: float = 0.25
    no_intensity: float = 0.3


@dataclass(frozen=True, slots=True, eq=False)
class LabelledPoints:
    """Points f32 [N, 3] in the sensor frame, class ids u8 [N], intensities f32 [N] or None if unknown."""

    points: np.ndarray
    label: np.ndarray
    intensity: np.ndarray | None


def augmented(pairs: PairFolder, i: int, random: np.random.Generator, how: Augmentation) -> LabelledPoints:
    """The scan of pair `i`, rotated, mirrored, mixed with others, and degraded as by another, worse sensor."""
    scan = _rotated(pairs, i, random)
    depth, label, intensity = scan
    if random.random() < how.mix:
        width = depth.shape[1]
        sector = slice(0, int(random.integers(width // 8, width // 2 + 1)))
        for image, source in zip(scan, _another(pairs, random), strict=True):
            image[:, sector] = source[:, sector]
    if random.random() < how.paste:
        for _ in range(2):
            other = _another(pairs, random)
            # The rays are the same, so nearer points hide those behind them, as they would have there.
            nearer = np.isin(other[1], _PASTED) & (other[0] > 0) & ((other[0] < depth) | (depth == 0))
            for image, source in zip(scan, other, strict=True):
                image[nearer] = source[nearer]
    depth[_dropped(depth.shape, random, how)] = 0
    if random.random() < how.bare:
        bared = np.isin(label, _BARED[random.integers(len(_BARED))])
        depth[bared] = 0 if (depth[~bared] > 0).any() else depth[bared]  # a scan keeps some return
    valid = depth > 0
    known = (
        None
        if random.random() < how.no_intensity
        else _with_other_intensities(intensity[valid], label[valid], random, how)
    )
    return LabelledPoints(_displaced(pairs.sensor, depth, label, random, how)[valid], label[valid], known)


def _another(pairs: PairFolder, random: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    return _rotated(pairs, int(random.integers(len(pairs))), random)


def _rotated(pairs: PairFolder, i: int, random: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Depth, label and intensity of a scan, starting at any column if these wrap, mirrored half the time."""
    scan = pairs[i].scan
    assert scan.intensity is not None
    # A rotated sector would be torn apart; its place on the grid is the sensor's.
    columns = scan.sensor.columns if scan.sensor.wraps else 1
    start, mirrored = int(random.integers(columns)), bool(random.random() < 0.5)
    # The mirror image of staggered beams is another sensor.
    step = -1 if mirrored and not any(scan.sensor.azimuth_offsets) else 1
    depth, label, intensity = (
        np.ascontiguousarray(np.roll(image, start, axis=1)[:, ::step])
        for image in (scan.depth, scan.label, scan.intensity)
    )
    return depth, label, intensity


def _dropped(shape: tuple[int, ...], random: np.random.Generator, how: Augmentation) -> np.ndarray:
    """bool [H, W]: the returns to be removed; more in some rows, and whole rows."""
    share = random.uniform(0, how.drop) * random.uniform(0, 2, shape[0])
    share[random.random(shape[0]) < random.uniform(0, how.drop_rows)] = 1
    dropped: np.ndarray = random.random(shape, dtype=np.float32) < share[:, None]
    return dropped


def _with_other_intensities(
    intensity: np.ndarray, label: np.ndarray, random: np.random.Generator, how: Augmentation
) -> np.ndarray:
    """Intensities [N] of surfaces that are a little brighter or darker, to a sensor of another scale."""
    surface = random.normal(0, how.surface, NUM_CLASSES)[label]
    gain = np.exp(surface + how.speckle * random.standard_normal(len(label))).astype(np.float32)
    return np.minimum(intensity ** np.float32(np.exp(random.normal(0, how.gamma))) * gain, np.float32(1))


def _displaced(
    sensor: Sensor, depth: np.ndarray, label: np.ndarray, random: np.random.Generator, how: Augmentation
) -> np.ndarray:
    """The points f32 [H, W, 3] of a depth image, with beams, a pose of the sensor and levels of the ground that are a
    little off."""
    noise = random.standard_normal(depth.shape, dtype=np.float32) * np.float32(random.uniform(0, how.noise))
    points = sensor.pattern.points(np.maximum(depth + noise, np.float32(0.1))).astype(np.float32)
    x, y = points[..., 0], points[..., 1]
    pitch, roll = random.normal(0, how.tilt, 2)
    points[..., 2] += np.hypot(x, y) * random.normal(
        0, how.beam, (len(depth), 1)
    )  # small angles: a shear is a rotation
    points[..., 2] += pitch * x + roll * y + random.normal(0, how.height)
    for ground in _BESIDE_ROADS:
        points[label == ground, 2] += random.normal(0, how.levels)
    for _ in range(2):
        amplitude, length = random.normal(0, how.hills), random.uniform(*_HILLS)
        towards, phase = random.uniform(0, 2 * np.pi, 2)
        along = (np.cos(towards) * x + np.sin(towards) * y) * (2 * np.pi / length)
        points[..., 2] += amplitude * (np.sin(along + phase) - np.sin(phase))  # nothing changes under the sensor
    return points
