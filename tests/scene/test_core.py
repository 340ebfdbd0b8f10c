"""The border of the compiled core: what it refuses, and in which words."""

from typing import Any

import numpy as np
import pytest

from lidardraft import _core
from lidardraft.errors import LayoutError, SensorError

PATTERN: dict[str, Any] = {
    "elevations": np.array([0.1, -0.1]),
    "azimuth_offsets": np.zeros(2),
    "origin_heights": np.zeros(2),
    "columns": 8,
    "azimuth_start": np.pi,
    "azimuth_span": 2 * np.pi,
    "min_range": 0.5,
    "max_range": 100.0,
}
BALL: dict[str, Any] = {
    "shapes": np.array([1], np.uint8),
    "centers": np.array([[10.0, 0.0, 0.0]]),
    "sizes": np.array([[2.0, 2.0, 2.0]]),
    "yaws": np.zeros(1),
    "labels": np.array([13], np.uint8),
    "instances": np.array([4], np.uint32),
    "meshes": [],
}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"elevations": np.array([-0.1, 0.1])}, "elevation"),
        ({"elevations": np.array([2.0, 0.0])}, "elevation"),
        ({"elevations": np.array([np.nan, 0.0])}, "elevation"),
        ({"elevations": np.array([])}, "beam"),
        ({"azimuth_offsets": np.zeros(3)}, "3"),
        ({"columns": 0}, "column"),
        ({"azimuth_span": 7.0}, "span"),
        ({"min_range": 5.0, "max_range": 5.0}, "range"),
        ({"max_range": np.inf}, "range"),
    ],
)
def test_patterns_that_cannot_be(change: dict[str, Any], said: str) -> None:
    with pytest.raises(SensorError, match=said):
        _core.SensorPattern(**{**PATTERN, **change})


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"sizes": np.array([[2.0, 0.0, 2.0]])}, "size"),
        ({"sizes": np.array([[2.0, -1.0, 2.0]])}, "size"),
        ({"centers": np.array([[np.nan, 0.0, 0.0]])}, "center"),
        ({"yaws": np.array([np.inf])}, "yaw"),
        ({"shapes": np.array([9], np.uint8)}, "9"),
        ({"labels": np.zeros(2, np.uint8)}, "2"),
        ({"shapes": np.array([4], np.uint8)}, "mesh"),
    ],
)
def test_scenes_that_cannot_be(change: dict[str, Any], said: str) -> None:
    with pytest.raises(LayoutError, match=said):
        _core.Scene(**{**BALL, **change})


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("centers", np.zeros((1, 3), np.float32)),
        ("labels", np.zeros(1, np.int64)),
        ("instances", np.zeros(1, np.int32)),
    ],
)
def test_other_dtypes_are_refused(name: str, values: np.ndarray) -> None:
    with pytest.raises(TypeError, match=name):
        _core.Scene(**{**BALL, name: values})


def test_fortran_order_is_refused() -> None:
    with pytest.raises(TypeError, match="centers"):
        _core.Scene(**{**BALL, "centers": np.asfortranarray(np.zeros((2, 3)))})


@pytest.mark.parametrize(
    "pose",
    [np.diag([1.0, 1, 2, 1]), np.diag([1.0, 1, -1, 1]), np.full((4, 4), np.nan), np.eye(4)[[0, 1, 3, 2]]],
    ids=["stretched", "mirrored", "nan", "shuffled"],
)
def test_poses_that_are_not_rigid(pose: np.ndarray) -> None:
    with pytest.raises(LayoutError, match="world_from_sensor"):
        _core.Scene(**BALL).scan(_core.SensorPattern(**PATTERN), pose)


def test_a_scan_says_what_was_hit_and_what_was_not() -> None:
    pattern = {
        **PATTERN,
        "elevations": np.array([0.001, -0.3]),
        "azimuth_start": 0.02,
        "azimuth_span": 0.04,
        "columns": 1,
    }
    depth, label, instance, primitive, incidence = _core.Scene(**BALL).scan(_core.SensorPattern(**pattern), np.eye(4))
    assert depth[0, 0] == pytest.approx(9.0, abs=1e-3)
    assert (label[0, 0], instance[0, 0], primitive[0, 0]) == (13, 4, 0)
    assert incidence[0, 0] == pytest.approx(1.0, abs=1e-3)
    assert (depth[1, 0], label[1, 0], instance[1, 0], primitive[1, 0], incidence[1, 0]) == (0, 0, 0, -1, 0)
