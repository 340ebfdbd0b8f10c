"""Scans that are changed at random, against what was asked for."""

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest
from box_pairs import SENSOR, noted

from lidardraft.formats.pairs import Pair, write_pairs
from lidardraft.scene.range_image import RangeImage
from lidardraft.semantics import BY_NAME
from lidardraft.training.augmentation import Augmentation, augmented
from lidardraft.training.sources import PairFolder

ROAD, SIDEWALK, BUILDING, VEGETATION, POLE = (
    BY_NAME[name].id for name in ("road", "sidewalk", "building", "vegetation", "pole")
)
STILL = Augmentation(
    **{field.name: 0.0 for field in dataclasses.fields(Augmentation)}
)  # rotated and mirrored all the same


def test_what_is_not_changed_stays_as_it_is(pairs: PairFolder) -> None:
    for seed in range(4):
        scan = augmented(pairs, seed, np.random.default_rng(seed), STILL)
        original = pairs[seed].scan
        ours, theirs = np.linalg.norm(scan.points, axis=1), original.depth[original.valid]
        np.testing.assert_allclose(np.sort(ours), np.sort(theirs), atol=1e-4)
        np.testing.assert_array_equal(np.bincount(scan.label), np.bincount(original.label[original.valid]))
        road = scan.label == ROAD
        np.testing.assert_allclose(scan.points[road, 2], -SENSOR.mount_height, atol=0.1)
        assert scan.intensity is not None


def test_scans_are_changed_as_asked(pairs: PairFolder) -> None:
    def height(**changes: float) -> np.ndarray:
        how = dataclasses.replace(STILL, **changes)
        scans = [augmented(pairs, 0, np.random.default_rng(seed), how) for seed in range(40)]
        return np.array([np.median(scan.points[scan.label == ROAD, 2]) for scan in scans])

    assert height(height=0.2).std() == pytest.approx(0.2, rel=0.5)
    assert height().std() < 0.02
    count = len(augmented(pairs, 0, np.random.default_rng(0), STILL).points)
    dropped = [
        len(augmented(pairs, 0, np.random.default_rng(s), dataclasses.replace(STILL, drop=0.4)).points)
        for s in range(40)
    ]
    assert 0.7 < np.mean(dropped) / count < 0.9
    hilly = augmented(pairs, 0, np.random.default_rng(3), dataclasses.replace(STILL, hills=0.5))
    flat = augmented(pairs, 0, np.random.default_rng(3), STILL)
    moved = np.abs(hilly.points - flat.points)
    far = np.linalg.norm(flat.points, axis=1) > 12
    assert moved[far, 2].max() > 2 * moved[~far, 2].max() > 0  # nothing changes under the sensor
    assert not moved[:, :2].any()
    rows = dataclasses.replace(STILL, drop_rows=1.0)
    assert len(augmented(pairs, 0, np.random.default_rng(1), rows).points) < 0.9 * count
    unknown = [
        augmented(pairs, 0, np.random.default_rng(s), dataclasses.replace(STILL, no_intensity=0.5)) for s in range(40)
    ]
    assert 8 < sum(scan.intensity is None for scan in unknown) < 32


@pytest.fixture
def strips(tmp_path: Path) -> PairFolder:
    """A scan of a quarter road, sidewalk, building and tree each, all 10 m away."""
    flat = np.full(SENSOR.shape, 10, dtype=np.float32)
    label = np.broadcast_to(np.repeat([ROAD, SIDEWALK, BUILDING, VEGETATION], 32).astype(np.uint8), SENSOR.shape)
    instance = np.zeros(SENSOR.shape, dtype=np.uint32)
    scan = RangeImage(sensor=SENSOR, depth=flat, label=label, instance=instance, intensity=flat / 20)
    list(write_pairs(tmp_path / "strips", [(Pair(scan, scan), {})]))
    return PairFolder(tmp_path / "strips")


def test_bare_scans_lack_buildings_plants_or_all_but_the_ground(strips: PairFolder) -> None:
    bare = dataclasses.replace(STILL, bare=1.0)
    left = {frozenset(augmented(strips, 0, np.random.default_rng(seed), bare).label.tolist()) for seed in range(30)}
    assert left == {
        frozenset({ROAD, SIDEWALK, VEGETATION}),
        frozenset({ROAD, SIDEWALK, BUILDING}),
        frozenset({ROAD, SIDEWALK}),
    }


def test_a_scan_of_poles_alone_keeps_them(two: PairFolder) -> None:
    bare = dataclasses.replace(STILL, bare=1.0)
    assert all(len(augmented(two, 1, np.random.default_rng(seed), bare).points) == 16 * 64 for seed in range(10))


def test_sidewalks_are_higher_or_lower_beside_the_road(strips: PairFolder) -> None:
    def rise(seed: int, label: int) -> float:
        level, still = (
            augmented(strips, 0, np.random.default_rng(seed), dataclasses.replace(STILL, levels=levels))
            for levels in (0.1, 0.0)
        )
        return float((level.points - still.points)[level.label == label, 2].mean())

    assert np.std([rise(seed, SIDEWALK) for seed in range(60)]) == pytest.approx(0.1, rel=0.35)
    assert rise(0, ROAD) == 0


def test_surfaces_are_brighter_or_darker_class_by_class(two: PairFolder) -> None:
    def logarithms(**changes: float) -> np.ndarray:
        how = dataclasses.replace(STILL, **changes)
        scans = [augmented(two, 0, np.random.default_rng(seed), how) for seed in range(60)]
        assert all(scan.intensity is not None and scan.intensity.max() <= 1 for scan in scans)
        return np.log([scan.intensity for scan in scans]) - math.log(10 / 20)  # of a road of one intensity

    surface, speckle = logarithms(surface=0.2), logarithms(speckle=0.2)
    assert surface.mean(axis=1).std() == pytest.approx(0.2, rel=0.35)
    assert surface.std(axis=1).max() < 1e-5
    assert speckle.mean(axis=1).std() < 0.02
    assert speckle.std(axis=1) == pytest.approx(0.2, rel=0.1)
    assert np.abs(logarithms()).max() < 0.01


@pytest.fixture
def two(tmp_path: Path) -> PairFolder:
    """A scan that sees a road 10 m away on every ray, and one that sees a pole 5 m away on half of them."""

    def plain(label: int, depth: float, columns: int) -> RangeImage:
        seen = np.broadcast_to(np.arange(128) < columns, SENSOR.shape)
        return RangeImage(
            sensor=SENSOR,
            depth=np.where(seen, depth, 0).astype(np.float32),
            label=np.where(seen, label, 0).astype(np.uint8),
            instance=np.zeros(SENSOR.shape, dtype=np.uint32),
            intensity=np.where(seen, depth / 20, 0).astype(np.float32),
        )

    road, pole = plain(ROAD, 10, 128), plain(POLE, 5, 64)
    list(write_pairs(tmp_path / "two", [(Pair(road, road), {}), (Pair(pole, pole), {})]))
    return PairFolder(tmp_path / "two")


def test_the_scan_of_a_sensor_that_sees_a_sector_stays_in_it(tmp_path: Path) -> None:
    sector = dataclasses.replace(SENSOR, name="sector", azimuth_start=1.5, azimuth_span=1.0)
    list(write_pairs(tmp_path, [noted(seed, sector) for seed in range(3)]))
    folder = PairFolder(tmp_path)
    mirrored = set()
    for seed in range(8):
        points = augmented(folder, 0, np.random.default_rng(seed), STILL).points
        azimuth = np.arctan2(points[:, 1], points[:, 0])
        assert 0.5 <= azimuth.min() <= azimuth.max() <= 1.5
        original = folder[0].scan.depth
        rows = [
            np.array_equal(np.linalg.norm(points, axis=1).round(2), side[side > 0].round(2))
            for side in (original, original[:, ::-1])
        ]
        assert any(rows)  # not torn into two parts
        mirrored.add(rows[1])
    assert mirrored == {False, True}


def test_a_sector_of_a_mixed_scan_is_of_another(two: PairFolder) -> None:
    how = dataclasses.replace(STILL, mix=1.0)
    scans = [augmented(two, 0, np.random.default_rng(seed), how) for seed in range(20)]
    poles = np.array([(scan.label == POLE).sum() for scan in scans]) / (16 * 128)
    assert (poles == 0).any()  # mixed with itself
    assert 0 < poles.max() <= 0.5
    for scan in scans:
        depth = np.linalg.norm(scan.points, axis=1)
        np.testing.assert_allclose(depth, np.where(scan.label == POLE, 5, 10), atol=1e-4)
        assert scan.intensity is not None
        np.testing.assert_allclose(scan.intensity, depth / 20, atol=0.01)


def test_pasted_objects_hide_what_is_behind_them(two: PairFolder) -> None:
    how = dataclasses.replace(STILL, paste=1.0)
    shares = set()
    for seed in range(20):
        over_road = augmented(two, 0, np.random.default_rng(seed), how)
        assert len(over_road.label) == 16 * 128
        assert set(np.unique(over_road.label)) <= {ROAD, POLE}
        shares.add(bool((over_road.label == POLE).any()))
        # the road is nothing that is pasted
        assert set(np.unique(augmented(two, 1, np.random.default_rng(seed), how).label)) == {POLE}
    assert shares == {False, True}
