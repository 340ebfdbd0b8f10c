"""The lifelikeness of generated scans: properties of sweeps, and their distances between generated and recorded ones.

Each property has a measure of one sweep, and a distance between two sets of sweeps. The definitions are our own.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from lidardraft.metrics import profiles, returns, surfaces
from lidardraft.metrics.comparisons import bev_histogram, histogram_mmd
from lidardraft.metrics.profiles import jensen_shannon, wasserstein
from lidardraft.metrics.sweep import Sweep
from lidardraft.semantics import BY_NAME

Features = Sequence[np.ndarray]
_FEWEST = 50.0  # firings or returns for a mean

# Sets of classes that sensors' labels can distinguish.
CLASS_SETS: dict[str, tuple[str, ...]] = {
    "road": ("road",),
    "sidewalk": ("sidewalk",),
    "terrain": ("terrain",),
    "building": ("building",),
    "fence": ("fence", "wall"),
    "vegetation": ("vegetation",),
    "trunk": ("trunk",),
    "pole": ("pole",),
    "sign": ("traffic-sign", "traffic-light"),
    "car": ("car",),
    "truck": ("truck", "bus", "train"),
    "person": ("person", "rider"),
    "two-wheeler": ("bicycle", "motorcycle"),
}


@dataclass(frozen=True)
class Property:
    """A property: its measure of a sweep, the distance of two sets of measurements, and one number for a set."""

    name: str
    measure: Callable[[Sweep], np.ndarray]
    distance: Callable[[Features, Features], float]
    summary: Callable[[Features], float]


def mean_known(values: Sequence[float]) -> float:
    """The mean of all values that are not NaN; NaN without any."""
    known = [value for value in values if not math.isnan(value)]
    return float(np.mean(known)) if known else math.nan


def pooled_divergence(first: Features, second: Features) -> float:
    """Jensen-Shannon distance of the summed histograms; NaN if one is empty."""
    p, q = np.sum(first, axis=0), np.sum(second, axis=0)
    return jensen_shannon(p, q) if p.sum() > 0 and q.sum() > 0 else math.nan


def mean_difference(first: Features, second: Features) -> float:
    """Mean absolute difference of the pooled means (sums and counts [K, 2]) of the bins in both."""
    p, q = np.sum(first, axis=0), np.sum(second, axis=0)
    both = (p[:, 1] >= _FEWEST) & (q[:, 1] >= _FEWEST)
    return float(np.abs(p[both, 0] / p[both, 1] - q[both, 0] / q[both, 1]).mean()) if both.any() else math.nan


def value_difference(first: Features, second: Features) -> float:
    """Earth mover's distance of one number a sweep."""
    samples = [np.array([value for value in features if not np.isnan(value)]) for features in (first, second)]
    return wasserstein(*samples) if all(len(sample) for sample in samples) else math.nan


def _median_of(centres: np.ndarray) -> Callable[[Features], float]:
    def median(features: Features) -> float:
        below = np.cumsum(np.sum(features, axis=0))
        return float(centres[np.searchsorted(below, below[-1] / 2)]) if below[-1] > 0 else math.nan

    return median


def _mean_of_bins(features: Features) -> float:
    total = np.sum(features, axis=0)
    filled = total[:, 1] >= _FEWEST
    return float((total[filled, 0] / total[filled, 1]).mean()) if filled.any() else math.nan


def _mean_value(features: Features) -> float:
    return mean_known([float(value) for value in features])


def _middles(borders: np.ndarray) -> np.ndarray:
    return np.concatenate([(borders[1:-1] + borders[:-2]) / 2, borders[-2:-1]])


def _histogram_property(name: str, measure: Callable[[Sweep], np.ndarray], borders: np.ndarray) -> Property:
    return Property(name, measure, pooled_divergence, _median_of(_middles(borders)))


def _top_view(sweep: Sweep) -> np.ndarray:
    return bev_histogram(sweep.points[sweep.valid])


def _nothing(_: Features) -> float:
    return math.nan


PROPERTIES: tuple[Property, ...] = (
    Property("return rate", lambda sweep: sweep.valid.mean(), value_difference, _mean_value),
    Property("return rate by laser", returns.returns_by_row, mean_difference, _mean_of_bins),
    Property("return rate on surfaces by range", returns.returns_by_range, mean_difference, _mean_of_bins),
    _histogram_property("runs of dropped firings (JSD)", returns.hole_lengths, returns.RUN_EDGES),
    _histogram_property("range (JSD)", profiles.range_histogram, profiles.RANGE_BINS),
    _histogram_property("height over the road (JSD)", profiles.height_histogram, profiles.HEIGHT_BINS),
    Property("top view (BEV JSD)", _top_view, pooled_divergence, _nothing),
    Property("top view (BEV MMD)", _top_view, lambda p, q: histogram_mmd(np.stack(p), np.stack(q)), _nothing),
    Property("edges with a mixed pixel", lambda s: np.float64(surfaces.mixed_share(s)), value_difference, _mean_value),
    _histogram_property("steps between firings (JSD)", surfaces.range_steps, surfaces.STEP_EDGES),
    _histogram_property("bends between firings (JSD)", surfaces.range_bends, surfaces.STEP_EDGES),
)

_INTENSITY_BORDERS = np.arange(profiles.INTENSITY_BINS + 1) / profiles.INTENSITY_BINS
INTENSITY_PROPERTIES: tuple[Property, ...] = (
    _histogram_property("intensity (JSD)", profiles.intensity_histogram, _INTENSITY_BORDERS),
    Property("intensity by range", profiles.intensity_by_range, mean_difference, _mean_of_bins),
    Property("intensity by laser", profiles.intensity_by_row, mean_difference, _mean_of_bins),
)


def class_properties() -> tuple[Property, ...]:
    """Properties of labelled sweeps: intensity by class, its fall with range on two surfaces, roughness by class."""
    found = []
    for name, members in CLASS_SETS.items():
        ids = tuple(BY_NAME[member].id for member in members)
        intensity, roughness = (
            partial(m, labels=ids) for m in (profiles.intensity_histogram, surfaces.residual_histogram)
        )
        found.append(_histogram_property(f"intensity of {name} (JSD)", intensity, _INTENSITY_BORDERS))
        if name in ("road", "building", "vegetation", "car"):
            by_range = partial(profiles.intensity_by_range, labels=ids)
            found.append(Property(f"intensity of {name} by range", by_range, mean_difference, _mean_of_bins))
        if name in ("road", "sidewalk", "terrain", "building", "fence", "vegetation", "car"):
            roughness = partial(surfaces.residual_histogram, labels=ids)
            found.append(_histogram_property(f"roughness of {name} (JSD)", roughness, surfaces.RESIDUAL_EDGES))
    return tuple(found)


def class_counts(sweep: Sweep) -> np.ndarray:
    """Returns by set of classes, f64 [len(CLASS_SETS)]; returns in no set are not counted."""
    assert sweep.label is not None
    return counts_by_set(np.bincount(sweep.label[sweep.valid], minlength=len(BY_NAME)).astype(np.float64))


def counts_by_set(counts: np.ndarray) -> np.ndarray:
    """Counts by class id, summed by set of classes."""
    return np.array([sum(counts[BY_NAME[member].id] for member in members) for members in CLASS_SETS.values()])
