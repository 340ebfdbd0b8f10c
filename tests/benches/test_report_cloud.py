"""The report of layouts of recordings, on made ones."""

import math

import numpy as np
import pytest

from lidardraft import layout_from_cloud, layout_from_text, raycast
from lidardraft.drafting.cloud.clustering import FittedBox
from lidardraft.metrics.sweep import Sweep
from lidardraft.scene.sensor import PRESETS
from lidardraft.semantics import BY_NAME
from markdown_table import table
from object_labels import LabelledBoxes, iou, recovered
from report_cloud import Group, by_class, is_near, measure

SENSOR = PRESETS["hdl64e"]
CAR = BY_NAME["car"].id


@pytest.fixture(scope="module")
def group() -> Group:
    layout = layout_from_text("two cars ahead, trees on the left and a building on the right", seed=3)
    sweep = Sweep.by_azimuth(raycast(layout, SENSOR))
    return Group([sweep], SENSOR, Sweep.by_azimuth, np.ones(SENSOR.shape, dtype=bool))


def test_the_layout_of_a_cast_comes_near_it(group: Group) -> None:
    row = measure(group, "fine")
    assert row["near"] > 0.97
    assert 0.9 < row["near on objects"] < row["near"]
    assert row["holes"] == 0.0
    assert row["empty"] < 0.02
    assert abs(row["along rays"] - row["near"]) < 0.02
    assert measure(group, "objects")["primitives"] < row["primitives"]


def test_classes_are_told_apart_and_add_up(group: Group) -> None:
    rows = by_class(group, "fine")
    assert sum(cells["of all returns"] for cells in rows.values()) == pytest.approx(1.0)
    for cells in rows.values():
        assert sum(cells[name] for name in ("near", "empty", "too near", "too far")) == pytest.approx(1.0)
    assert rows["car"]["primitives"] == 2
    assert "| car | " in table(rows)


def test_near_is_half_a_metre_or_a_twentieth() -> None:
    recorded = np.array([2.0, 2.0, 40.0, 40.0, 5.0])
    cast = np.array([2.4, 1.4, 41.9, 42.1, 0.0])
    np.testing.assert_array_equal(is_near(recorded, cast), [True, False, True, False, False])


def box(x: float, y: float, length: float = 4.0, width: float = 2.0, yaw: float = 0.0) -> FittedBox:
    return FittedBox(center=np.array([x, y, 0.0]), size=np.array([length, width, 1.5]), yaw=yaw)


@pytest.mark.parametrize(
    ("other", "expected"),
    [
        (box(0, 0), 1.0),
        (box(2, 0), 1 / 3),
        (box(0, 0, 2.0, 4.0, math.pi / 2), 1.0),
        (box(0, 0, 4.0, 2.0, math.pi / 2), 4 / 12),
        (box(30, 0), 0.0),
    ],
)
def test_intersection_over_union_from_above(other: FittedBox, expected: float) -> None:
    assert iou(box(0, 0), other) == pytest.approx(expected, abs=0.02)


def test_a_car_is_found_where_its_points_make_a_box() -> None:
    side = [[x, 6.0, z] for x in np.arange(8, 12.2, 0.1) for z in np.arange(-1.6, -0.3, 0.1)]
    back = [[8.0, y, z] for y in np.arange(6, 7.8, 0.1) for z in np.arange(-1.6, -0.3, 0.1)]
    points = np.array(side + back)
    cars = [FittedBox(center=np.array([10.1, 6.9, -0.95]), size=np.array([4.2, 1.8, 1.5]), yaw=math.pi)]
    frame = LabelledBoxes(points, np.full(len(points), CAR, dtype=np.uint8), cars, 1.73)
    assert recovered(frame, layout_from_cloud(points, frame.labels)) == (1, 1)
    assert recovered(frame, layout_from_cloud(points, np.full(len(points), BY_NAME["building"].id))) == (1, 0)
    assert recovered(frame, layout_from_cloud(points, frame.labels), least_points=10_000) == (0, 0)
