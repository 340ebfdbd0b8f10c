"""Can a small classifier tell made scans from recorded ones? A two-sample test on crops, by family of features.

Gradient boosting learns to tell crops of made scans from crops of recorded ones (classifier two-sample tests, Lopez-Paz
and Oquab, ICLR 2017) by the features of `crop_features.py`, and is asked about crops of a drive that it has not seen.
The figure is the area under its ROC curve: 0.5 where it guesses, 1 where it is never wrong. The protocol is our own.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from lidardraft.errors import LidarDraftError
from lidardraft.metrics.crop_features import FAMILIES, Features, crop_features
from lidardraft.metrics.sweep import Sweep

ALL = "all"  # families together
_FEWEST = 20  # crops that have a feature


@dataclass(frozen=True, slots=True)
class FeatureGap:
    """What one feature tells alone: the share of pairs of a made and a recorded crop in which the made one has more,
    and the medians of both."""

    made_is_more: float
    recorded: float
    made: float


@dataclass(frozen=True, slots=True)
class TwoSample:
    """`auc` by family, "all" first: the mean over the drives that were left out. `features` tells most first."""

    auc: dict[str, float]
    features: dict[str, FeatureGap]


def two_sample(
    recorded: Mapping[str, Sequence[Sweep]], made: Sequence[Sweep], shown: np.ndarray | None = None
) -> TwoSample:
    """Recorded sweeps by drive against made ones; each drive is left out once, with as large a share of the made ones.

    Of D drives the k-th is left out with the made sweeps k, k + D, ...; those that are alike belong D apart. `shown`
    [H, W] are the pixels that the recording vehicle leaves open (`open_pixels`). Intensity counts where all sweeps have
    it. Range images become sweeps by `Sweep.from_image`. Raises `LidarDraftError` for less than two drives, or less
    made sweeps than drives.
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


def open_pixels(sweeps: Sequence[Sweep]) -> np.ndarray:
    """Pixels [H, W] that a vehicle leaves open, as recorded `sweeps` tell.

    Hidden is a firing that looks down and returns in less than a tenth of them; of the lower three eighths of the
    lasers, which meet the ground near by whatever stands there, also one that returns in less than nine tenths: the
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
    """The AUC on drive `number` and its share of the made crops, of a classifier that has learned from the others."""
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
    """Features that have two values or more; scikit-learn asks for that."""
    known = np.isfinite(table)
    least, most = np.where(known, table, np.inf).min(axis=0), np.where(known, table, -np.inf).max(axis=0)
    varied: np.ndarray = least < most
    return varied


def _gaps(recorded: np.ndarray, made: np.ndarray, names: Sequence[str]) -> dict[str, FeatureGap]:
    from scipy.stats import mannwhitneyu

    found = {}
    for column, name in enumerate(names):
        first, second = (values[np.isfinite(values)] for values in (recorded[:, column], made[:, column]))
        if min(len(first), len(second)) >= _FEWEST:
            more = float(mannwhitneyu(second, first).statistic) / (len(first) * len(second))
            found[name] = FeatureGap(more, float(np.median(first)), float(np.median(second)))
    return found
