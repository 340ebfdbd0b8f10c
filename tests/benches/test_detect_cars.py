"""The detector of cars: its score by hand, and a detector that is told the truth."""

import numpy as np
import pytest
import torch

from evidence import (
    CELL,
    CELLS,
    REACH,
    Detector,
    Scene,
    average_precision,
    found_cars,
    loss_of,
    targets,
    trained_detector,
    view_from_above,
)

CARS = np.array([[10.2, -3.1, 4.4, 1.8, 0.3], [-20.0, 14.9, 4.0, 1.7, 3.0]], np.float32)


def test_precision_by_hand() -> None:
    cars = [np.array([[0.0, 0.0], [10.0, 0.0]]), np.array([[5.0, 5.0]])]
    found = [np.array([[0.3, 0.0, 0.9], [0.1, 0.0, 0.8], [40.0, 0.0, 0.7]]), np.array([[5.0, 5.4, 0.6]])]
    # hit, taken already, nothing there, hit: recalls up to 1/3 with precision 1, up to 2/3 with 2/4
    assert average_precision(found, cars, 0.5) == pytest.approx((34 * 1.0 + 33 * 0.5) / 101)
    assert average_precision(found, cars, 0.35) == pytest.approx(34 / 101)
    assert average_precision([np.empty((0, 3))] * 2, cars, 4.0) == 0.0


def test_a_network_that_says_the_targets_finds_the_cars() -> None:
    heat, cells, rest = targets(CARS)
    said = torch.zeros(1, 7, CELLS, CELLS)
    said[0, 0] = torch.logit(torch.from_numpy(heat), 1e-3)
    said[0, 1:, cells[:, 0], cells[:, 1]] = torch.from_numpy(rest).T
    found = found_cars(lambda _: said, Scene(np.zeros((1, 3), np.float32), CARS))  # type: ignore[arg-type]
    np.testing.assert_allclose(sorted(found[:2, :2].tolist()), sorted(CARS[:, :2].tolist()), atol=1e-4)
    assert loss_of(said, [CARS]) < loss_of(torch.zeros_like(said), [CARS]) / 50


def test_points_lie_where_cars_do_however_the_scene_is_turned() -> None:
    points = np.column_stack([CARS[:, :2], np.ones(2)]).astype(np.float32)
    turned = Scene(points, CARS).turned(1.1, mirrored=True, scale=1.05)
    np.testing.assert_allclose(turned.points[:, :2], turned.cars[:, :2], atol=1e-5)
    y, x = np.nonzero(view_from_above(turned.points).sum(axis=0))
    places = sorted(zip(x.tolist(), y.tolist(), strict=True))
    assert places == sorted(map(tuple, ((turned.cars[:, :2] + REACH) / CELL).astype(int).tolist()))


def test_a_detector_learns() -> None:
    rng = np.random.default_rng(0)
    points = np.concatenate([np.array([*car[:2], 0.8]) + rng.normal(size=(200, 3)) * 0.5 for car in CARS])
    scene = Scene(points.astype(np.float32), CARS)
    before = loss_of(Detector()(torch.from_numpy(view_from_above(scene.points))[None]), [CARS])
    after = loss_of(trained_detector([[scene]], 6, 0)(torch.from_numpy(view_from_above(scene.points))[None]), [CARS])
    assert after < 0.7 * before
