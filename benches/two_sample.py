"""A two-sample test of made and recorded scans: a small classifier on crops, by family of features.

Gradient boosting learns to distinguish crops of made scans from recorded ones (classifier two-sample tests,
Lopez-Paz and Oquab, ICLR 2017). It is tested on crops of an unseen drive. The figure is the area under its ROC curve:
0.5 for guesses, 1 without an error.
The protocol and the features are our own: simple statistics of crops of range images, as in other properties of this
package. They are its returns by range and height (content), firings that return (drop), the scatter of ranges about
smooth surfaces (noise), their steps and bends (shape), and their readings (intensity).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from lidardraft.errors import LidarDraftError
from lidardraft.metrics.profiles import road_level
from lidardraft.metrics.returns import runs
from lidardraft.metrics.surfaces import bends
from lidardraft.metrics.sweep import Sweep

FAMILIES = ("content", "drop", "noise", "shape", "intensity")
CROP_COLUMNS = 128
FARTHEST = 79.0  # m: KITTI's files end at 80
# KITTI's files have millimetres and hundredths. Finer values are rounded to these: the test is not about formats of
# files.
_MILLIMETRES = 3  # decimals
_LEVELS = 100  # of intensity
_RANGES = (0.0, 5.0, 8.0, 12.0, 18.0, 26.0, 38.0, 55.0, 80.0)  # m
_HEIGHTS = (-3.0, -0.5, -0.15, 0.15, 0.4, 1.0, 1.8, 3.0, 5.0, 9.0, 30.0)  # m over the road
_BANDS = 8  # of lasers
_RUNS = {"1": (1, 2), "2 to 4": (2, 5), "5 to 24": (5, 25), "25 and more": (25, 10_000)}  # firings
_NEAR, _FAR = 12.0, 25.0  # m
_SMOOTH = 0.1  # m off the middle of the neighbours
_STEP, _CLEAR = 1.0, 0.3  # m between near and far at an edge, and from both
_GROUND = 0.3  # m over the road
_FEWEST = 30  # returns for a quantile
_BRIGHT = 0.9

Features = dict[str, float]
ALL = "all"  # families together
_FEWEST_CROPS = 20  # crops with a feature


@dataclass(frozen=True, eq=False)
class _Part:
    """Lasers of a crop: depth and height over the road [m], intensity if known, and the mask of firings that the
    vehicle leaves open. Depth is 0 without a return or behind the vehicle."""

    depth: np.ndarray
    height: np.ndarray
    shown: np.ndarray
    intensity: np.ndarray | None

    @property
    def valid(self) -> np.ndarray:
        return self.depth > 0

    def cut(self, rows: slice, columns: slice) -> _Part:
        read = None if self.intensity is None else self.intensity[rows, columns]
        return _Part(self.depth[rows, columns], self.height[rows, columns], self.shown[rows, columns], read)

    def rows(self, start: float, stop: float) -> _Part:
        """The lasers between two shares, from the top."""
        count = len(self.depth)
        return self.cut(slice(round(start * count), round(stop * count)), slice(None))


def crop_features(sweep: Sweep, shown: np.ndarray | None = None) -> list[Features]:
    """The features, "family.name" and value, of each crop of all lasers by 128 columns; NaN with too few returns.

    `shown` [H, W] are the pixels that the vehicle leaves open, by default all. Raises `LidarDraftError` for a sweep
    that is narrower than a crop or has no road.
    """
    height, columns = sweep.depth.shape
    if columns < CROP_COLUMNS:
        raise LidarDraftError(f"the sweep has {columns} columns; a crop has {CROP_COLUMNS}")
    shown = np.ones((height, columns), bool) if shown is None else shown
    if shown.shape != (height, columns):
        raise LidarDraftError(f"the mask is {shown.shape}; the sweep is {(height, columns)}")
    points = np.round(sweep.points.astype(np.float64), _MILLIMETRES)
    distance = np.linalg.norm(points, axis=2)
    depth = np.where(shown & (distance <= FARTHEST), distance, 0.0)
    read = None if sweep.intensity is None else np.rint(sweep.intensity * _LEVELS) / _LEVELS
    whole = _Part(depth, points[..., 2] - road_level(sweep), shown, read)
    starts = range(0, columns - CROP_COLUMNS + 1, CROP_COLUMNS)
    crops = (whole.cut(slice(None), slice(start, start + CROP_COLUMNS)) for start in starts)
    return [dict(_features(crop)) for crop in crops]


def _features(crop: _Part) -> Iterator[tuple[str, float]]:
    yield from _content(crop)
    for band in range(_BANDS):
        part = crop.rows(band / _BANDS, (band + 1) / _BANDS)
        yield f"drop.returns of band {band}", _share(part.valid, part.shown)
    for name, half in (("upper", crop.rows(0.0, 0.5)), ("lower", crop.rows(0.5, 1.0))):
        for measure in (_drop, _noise, _shape, _intensity):
            for feature, value in measure(half):
                yield f"{measure.__name__[1:]}.{feature}, {name}", value
    yield from _ground_noise(crop.rows(0.6, 0.9))


def _content(crop: _Part) -> Iterator[tuple[str, float]]:
    valid = crop.valid
    for name, values, edges in (("range", crop.depth, _RANGES), ("height", crop.height, _HEIGHTS)):
        shares = np.histogram(values[valid], edges)[0] / max(int(valid.sum()), 1)
        for low, share in zip(edges, shares.tolist(), strict=False):
            yield f"content.{name} from {low:g} m", share


def _drop(part: _Part) -> Iterator[tuple[str, float]]:
    valid, lost = part.valid, ~part.valid & part.shown
    lengths = np.diff(runs(lost)[:, 1:], axis=1)
    for name, (least, over) in _RUNS.items():
        yield f"runs of {name}", float(((lengths >= least) & (lengths < over)).sum() / len(valid))
    yield "lost with the laser above", _share(lost[1:] & lost[:-1], lost[1:])
    alone = valid[:, 1:-1] & ~valid[:, :-2] & ~valid[:, 2:]
    yield "alone in the row", float(alone.sum() / max(int(valid.sum()), 1))


def _noise(part: _Part) -> Iterator[tuple[str, float]]:
    bend, inside = bends(part.depth)
    for percent in (10, 25, 50):
        yield f"bend {percent} %", _log_quantile(bend[inside], percent)
    yield "bend near", _log_quantile(bend[inside & (part.depth[:, 1:-1] < _NEAR)], 50)


def _ground_noise(part: _Part) -> Iterator[tuple[str, float]]:
    low = part.valid & (np.abs(part.height) < _GROUND)
    inside = low[:, 2:] & low[:, 1:-1] & low[:, :-2]
    lift = np.abs(part.height[:, 1:-1] - (part.height[:, 2:] + part.height[:, :-2]) / 2)[inside]
    for percent in (25, 50, 90):
        yield f"noise.lift off the ground {percent} %", _log_quantile(lift, percent)


def _shape(part: _Part) -> Iterator[tuple[str, float]]:
    depth, valid = part.depth, part.valid
    step = np.abs(np.diff(depth, axis=1))[valid[:, 1:] & valid[:, :-1]]
    for percent in (10, 25, 50, 75, 90):
        yield f"step {percent} %", _log_quantile(step, percent)
    bend, inside = bends(depth)
    for percent in (75, 90):
        yield f"bend {percent} %", _log_quantile(bend[inside], percent)
    yield "bend far", _log_quantile(bend[inside & (depth[:, 1:-1] > _FAR)], 50)
    across, between = bends(depth.T)
    for percent in (10, 50, 90):
        yield f"bend across lasers {percent} %", _log_quantile(across[between], percent)
    yield "smooth", _share(inside & (bend < _SMOOTH), inside)
    here, sides = depth[:, 1:-1], (depth[:, :-2], depth[:, 2:])
    near, far = np.minimum(*sides), np.maximum(*sides)
    edge = inside & (far - near > _STEP)
    yield "edges", _share(edge, inside)
    yield "hanging at edges", _share(edge & (here > near + _CLEAR) & (here < far - _CLEAR), edge)


def _intensity(part: _Part) -> Iterator[tuple[str, float]]:
    if part.intensity is None:
        return
    read, valid = part.intensity, part.valid
    values, along = read[valid], valid[:, 1:] & valid[:, :-1]
    steps, across = np.abs(np.diff(read, axis=1))[along], valid[1:] & valid[:-1]
    for percent in (10, 50, 90):
        yield f"level {percent} %", _quantile(values, percent)
        yield f"step {percent} %", _quantile(steps, percent)
    yield "zero", float((values == 0).mean()) if len(values) else np.nan
    yield "bright", float((values > _BRIGHT).mean()) if len(values) else np.nan
    yield "spread", float(values.std()) if len(values) else np.nan
    yield "with range", _correlation(values, part.depth[valid])
    yield "with the laser above", _correlation(read[1:][across], read[:-1][across])
    means = [float(row[there].mean()) for row, there in zip(read, valid, strict=True) if there.sum() >= _FEWEST]
    yield "laser to laser", float(np.std(means)) if means else np.nan


def _share(part: np.ndarray, whole: np.ndarray) -> float:
    return float(part.sum() / max(int(whole.sum()), 1))


def _quantile(values: np.ndarray, percent: float) -> float:
    return float(np.percentile(values, percent)) if len(values) >= _FEWEST else np.nan


def _log_quantile(values: np.ndarray, percent: float) -> float:
    return float(np.log10(_quantile(values, percent) + 1e-4))


def _correlation(first: np.ndarray, second: np.ndarray) -> float:
    if len(first) < _FEWEST or not first.std() > 0 or not second.std() > 0:
        return np.nan
    return float(np.corrcoef(first, second)[0, 1])


@dataclass(frozen=True, slots=True)
class FeatureGap:
    """One feature alone: the share of pairs of a made and a recorded crop in which the made one has more, and the
    medians of both."""

    made_is_more: float
    recorded: float
    made: float


@dataclass(frozen=True, slots=True)
class TwoSample:
    """`auc` by family, "all" first: the mean over the drives left out. The most telling of `features` are first."""

    auc: dict[str, float]
    features: dict[str, FeatureGap]


def two_sample(
    recorded: Mapping[str, Sequence[Sweep]], made: Sequence[Sweep], shown: np.ndarray | None = None
) -> TwoSample:
    """The test of recorded sweeps by drive against made ones; each drive is left out once, with its share of these.

    Of D drives the k-th is left out with the made sweeps k, k + D, ...; similar ones belong D apart. `shown` [H, W] is
    the mask of pixels that the recording vehicle leaves open (`shown_pixels`). Intensity counts if all sweeps have it.
    Range images become sweeps by `Sweep.from_image`. Raises `LidarDraftError` for less than two drives, or less made
    sweeps than drives.
    """
    if len(recorded) < 2 or len(made) < len(recorded):
        raise LidarDraftError(
            f"there are {len(recorded)} recorded drives and {len(made)} made sweeps; "
            "it takes two drives, and as many made sweeps as drives"
        )
    drives = [[crop for sweep in sweeps for crop in crop_features(sweep, shown)] for sweeps in recorded.values()]
    parts = [
        [crop for sweep in made[k :: len(drives)] for crop in crop_features(sweep, shown)] for k in range(len(drives))
    ]
    crops = [crop for group in (*drives, *parts) for crop in group]
    common = set.intersection(*(set(crop) for crop in crops))
    names = [name for name in crops[0] if name in common]
    tables = [_table(group, names) for group in drives], [_table(group, names) for group in parts]
    auc = {}
    for family in (ALL, *FAMILIES):
        chosen = [family in (ALL, name.split(".")[0]) for name in names]
        if any(chosen):
            auc[family] = _mean_auc(*([table[:, chosen] for table in group] for group in tables))
    gaps = _gaps(np.vstack(tables[0]), np.vstack(tables[1]), names)
    return TwoSample(auc, dict(sorted(gaps.items(), key=lambda item: -abs(item[1].made_is_more - 0.5))))


def shown_pixels(sweeps: Sequence[Sweep]) -> np.ndarray:
    """The mask [H, W] of pixels that a vehicle leaves open, from recorded `sweeps`.

    A firing that looks down is hidden if it returns in less than a tenth of them. The lower three eighths of the lasers
    meet the near ground in any scene: their firings are hidden if they return in less than nine tenths, as at the
    fringe of the vehicle.
    """
    rate = np.mean([sweep.valid for sweep in sweeps], axis=0)
    laser = np.arange(len(rate))[:, None] / len(rate)
    hidden: np.ndarray = ((rate < 0.1) & (laser > 0.33)) | ((rate < 0.9) & (laser > 0.61))
    return ~hidden


def _table(crops: Sequence[Features], names: Sequence[str]) -> np.ndarray:
    return np.array([[crop[name] for name in names] for crop in crops])


def _mean_auc(recorded: Sequence[np.ndarray], made: Sequence[np.ndarray]) -> float:
    return float(np.mean([_auc_without(number, recorded, made) for number in range(len(recorded))]))


def _auc_without(number: int, recorded: Sequence[np.ndarray], made: Sequence[np.ndarray]) -> float:
    """The AUC on drive `number` and its share of the made crops, of a classifier trained on the others."""
    from sklearn.ensemble import HistGradientBoostingClassifier
    from sklearn.metrics import roc_auc_score

    def without(tables: Sequence[np.ndarray]) -> np.ndarray:
        return np.vstack([table for k, table in enumerate(tables) if k != number])

    known, unknown = (without(recorded), without(made)), (recorded[number], made[number])
    varied = _varied(np.vstack(known))
    # few and shallow trees: there are some hundred crops
    model = HistGradientBoostingClassifier(
        max_iter=100,
        learning_rate=0.08,
        max_leaf_nodes=8,
        l2_regularization=1.0,
        class_weight="balanced",
        random_state=0,
    )
    model.fit(np.vstack(known)[:, varied], np.repeat([0, 1], [len(table) for table in known]))
    told = model.predict_proba(np.vstack(unknown)[:, varied])[:, 1]
    return float(roc_auc_score(np.repeat([0, 1], [len(table) for table in unknown]), told))


def _varied(table: np.ndarray) -> np.ndarray:
    """The mask of features with two values or more, as scikit-learn requires."""
    known = np.isfinite(table)
    least, most = np.where(known, table, np.inf).min(axis=0), np.where(known, table, -np.inf).max(axis=0)
    varied: np.ndarray = least < most
    return varied


def _gaps(recorded: np.ndarray, made: np.ndarray, names: Sequence[str]) -> dict[str, FeatureGap]:
    from scipy.stats import mannwhitneyu

    found = {}
    for column, name in enumerate(names):
        first, second = (values[np.isfinite(values)] for values in (recorded[:, column], made[:, column]))
        if min(len(first), len(second)) >= _FEWEST_CROPS:
            more = float(mannwhitneyu(second, first).statistic) / (len(first) * len(second))
            found[name] = FeatureGap(more, float(np.median(first)), float(np.median(second)))
    return found
