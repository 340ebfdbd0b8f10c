"""The classifier: sure of what differs, at a loss with what is alike."""

from itertools import islice

import numpy as np
import pytest

from lidardraft.errors import LidarDraftError
from lidardraft.metrics.crop_features import FAMILIES
from lidardraft.metrics.sweep import Sweep
from lidardraft.metrics.two_sample import open_pixels, two_sample
from lidardraft.scene.sensor import PRESETS
from lidardraft.streets import StreetConfig, streets

Drives = dict[str, list[Sweep]]


@pytest.fixture(scope="module")
def drives() -> Drives:
    pairs = streets(5, StreetConfig(sensor=PRESETS["hdl64e"], poses_per_street=1))
    sweeps = [Sweep.from_image(pair.scan) for pair in islice(pairs, 16)]
    return {"a": sweeps[:4], "b": sweeps[4:8], "more": sweeps[8:]}


def test_streets_are_not_told_from_streets(drives: Drives) -> None:
    found = two_sample({"a": drives["a"], "b": drives["b"]}, drives["more"])
    assert list(found.auc) == ["all", *FAMILIES]
    assert all(0.2 < value < 0.8 for value in found.auc.values())


def test_what_differs_is_found_and_the_rest_is_not(drives: Drives) -> None:
    dim = [Sweep(s.points, None, s.intensity * np.float32(0.3)) for s in drives["more"] if s.intensity is not None]
    found = two_sample({"a": drives["a"], "b": drives["b"]}, dim)
    assert found.auc["intensity"] > 0.95
    assert found.auc["all"] > 0.9
    assert found.auc["noise"] < 0.8
    name, gap = next(iter(found.features.items()))
    assert name.startswith("intensity.")
    assert gap.made_is_more < 0.1
    assert gap.made < gap.recorded


def test_intensity_counts_where_all_have_it(drives: Drives) -> None:
    blank = [Sweep(sweep.points) for sweep in drives["more"]]
    found = two_sample({"a": drives["a"], "b": drives["b"]}, blank)
    assert "intensity" not in found.auc


def test_one_drive_or_too_few_sweeps_are_refused(drives: Drives) -> None:
    with pytest.raises(LidarDraftError, match="there are 1 recorded drives and 8 made sweeps"):
        two_sample({"a": drives["a"]}, drives["more"])
    with pytest.raises(LidarDraftError, match="there are 2 recorded drives and 1 made sweeps"):
        two_sample({"a": drives["a"], "b": drives["b"]}, drives["more"][:1])


def test_open_pixels_are_those_that_return() -> None:
    points = np.ones((8, 4, 3), np.float32)
    points[7, 0] = 0.0  # hidden near by
    points[0, 1] = 0.0  # the sky
    half = points.copy()
    half[6, 2] = 0.0  # the fringe, half of the time
    shown = open_pixels([Sweep(points), Sweep(half)])
    assert sorted(zip(*np.nonzero(~shown), strict=True)) == [(6, 2), (7, 0)]
