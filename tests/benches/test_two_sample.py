"""Features of crops, by hand."""

import math
from itertools import islice

import numpy as np
import pytest

from lidardraft.errors import LidarDraftError
from lidardraft.metrics.sweep import Sweep
from lidardraft.scene.sensor import PRESETS
from lidardraft.streets import StreetConfig, streets
from two_sample import CROP_COLUMNS, FAMILIES, crop_features, shown_pixels, two_sample

ROAD = -1.7
Drives = dict[str, list[Sweep]]


def sweep_at(distance: float, *, columns: int = CROP_COLUMNS, height: float = ROAD) -> Sweep:
    """Eight lasers at a circle on the road of this radius, all alike."""
    azimuth = (np.arange(columns) + 0.5) / columns * 2 * math.pi
    points = np.zeros((8, columns, 3), np.float32)
    points[..., 0], points[..., 1], points[..., 2] = distance * np.cos(azimuth), distance * np.sin(azimuth), height
    return Sweep(points, None, np.full((8, columns), 0.25, np.float32))


def test_every_crop_has_all_families() -> None:
    crops = crop_features(sweep_at(6.0, columns=2 * CROP_COLUMNS + 5))
    assert len(crops) == 2
    assert [list(crop) for crop in crops] == [list(crops[0])] * 2
    assert {name.split(".")[0] for name in crops[0]} == set(FAMILIES)


def test_content_counts_returns_by_range_and_height() -> None:
    (crop,) = crop_features(sweep_at(6.0))
    assert crop["content.range from 5 m"] == 1.0
    assert crop["content.height from -0.15 m"] == 1.0
    assert sum(value for name, value in crop.items() if name.startswith("content.")) == pytest.approx(2.0)


def test_what_the_vehicle_hides_is_not_dropped() -> None:
    sweep = sweep_at(6.0)
    sweep.points[0, :4], sweep.points[0, 10] = 0.0, 0.0
    sweep.points[1, 10] = 0.0
    shown = np.ones((8, CROP_COLUMNS), bool)
    shown[0, :4] = False
    (all_open,), (masked,) = crop_features(sweep), crop_features(sweep, shown)
    assert all_open["drop.returns of band 0"] == 1 - 5 / CROP_COLUMNS
    assert masked["drop.returns of band 0"] == 1 - 1 / (CROP_COLUMNS - 4)
    assert (all_open["drop.runs of 1, upper"], all_open["drop.runs of 2 to 4, upper"]) == (2 / 4, 1 / 4)
    assert masked["drop.runs of 2 to 4, upper"] == 0.0
    assert masked["drop.lost with the laser above, upper"] == 1.0  # the one of the second laser


def test_what_lies_beyond_the_files_of_kitti_is_no_return() -> None:
    sweep = sweep_at(6.0)
    sweep.points[0] *= 20.0
    (crop,) = crop_features(sweep)
    assert crop["drop.returns of band 0"] == 0.0


def test_noise_is_that_of_neighbours_in_a_row() -> None:
    rng = np.random.default_rng(0)
    sweep = sweep_at(6.0)
    sweep.points[...] *= 1 + rng.normal(scale=0.01 / 6, size=(8, CROP_COLUMNS, 1))
    (crop,) = crop_features(sweep)
    # of normal numbers off the middle of two others, half are below 0.674 times the root of 1.5 of their deviation
    assert 10 ** crop["noise.bend 50 %, lower"] == pytest.approx(0.674 * math.sqrt(1.5) * 0.01, rel=0.2)
    (still,) = crop_features(sweep_at(6.0))
    assert 10 ** still["noise.bend 50 %, lower"] < 1e-3


def test_millimetres_and_hundredths_are_the_format_of_a_file() -> None:
    rng = np.random.default_rng(0)
    sweep = sweep_at(6.0)
    fine = sweep.points * (1 + rng.normal(scale=0.01 / 6, size=(8, CROP_COLUMNS, 1)))
    read = rng.uniform(0.2, 0.4, size=(8, CROP_COLUMNS))
    (given,), (stored,) = (
        crop_features(Sweep(fine, None, read)),
        crop_features(Sweep(fine.round(3), None, read.round(2))),
    )
    assert np.allclose(list(given.values()), list(stored.values()), equal_nan=True, atol=1e-6)


def test_edges_and_what_hangs_at_them() -> None:
    sweep = sweep_at(6.0)
    sweep.points[:, 64:] *= 2.0
    (clean,) = crop_features(sweep)
    sweep.points[:, 63] *= 1.5
    (hanging,) = crop_features(sweep)
    assert clean["shape.hanging at edges, upper"] == 0.0
    # of the three firings with a near and a far neighbour, the middle one is off both
    assert hanging["shape.hanging at edges, upper"] == pytest.approx(1 / 3)


def test_intensity_is_left_out_where_it_is_not_known() -> None:
    sweep = sweep_at(6.0)
    (crop,) = crop_features(Sweep(sweep.points))
    assert not any(name.startswith("intensity.") for name in crop)
    (read,) = crop_features(sweep)
    assert read["intensity.level 50 %, upper"] == 0.25
    assert read["intensity.zero, upper"] == 0.0


def test_a_narrow_sweep_and_a_wrong_mask_are_refused() -> None:
    with pytest.raises(LidarDraftError, match="has 100 columns; a crop has 128"):
        crop_features(sweep_at(6.0, columns=100))
    with pytest.raises(LidarDraftError, match=r"the mask is \(4, 128\); the sweep is \(8, 128\)"):
        crop_features(sweep_at(6.0), np.ones((4, CROP_COLUMNS), bool))


@pytest.fixture(scope="module")
def drives() -> Drives:
    pairs = streets(seed=5, config=StreetConfig(sensor=PRESETS["hdl64e"], poses_per_street=1))
    sweeps = [Sweep.from_image(pair.scan) for pair in islice(pairs, 12)]
    return {"a": sweeps[:3], "b": sweeps[3:6], "more": sweeps[6:]}


@pytest.mark.slow
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
    with pytest.raises(LidarDraftError, match="there are 1 recorded drives and 6 made sweeps"):
        two_sample({"a": drives["a"]}, drives["more"])
    with pytest.raises(LidarDraftError, match="there are 2 recorded drives and 1 made sweeps"):
        two_sample({"a": drives["a"], "b": drives["b"]}, drives["more"][:1])


def test_open_pixels_are_those_that_return() -> None:
    points = np.ones((8, 4, 3), np.float32)
    points[7, 0] = 0.0  # hidden near by
    points[0, 1] = 0.0  # the sky
    half = points.copy()
    half[6, 2] = 0.0  # the fringe, half of the time
    shown = shown_pixels([Sweep(points), Sweep(half)])
    assert sorted(zip(*np.nonzero(~shown), strict=True)) == [(6, 2), (7, 0)]
