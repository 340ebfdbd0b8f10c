"""`Scan.from_points`: a scan of points of one's own has the right value in every field, and says what is left out."""

import math
import re
from typing import Any

import numpy as np
import pytest

from lidardraft import Layout, LayoutError, Primitive, Scan, Sensor, simulate

FEW = Sensor(name="few", elevations=(0.1, 0.0, -0.1), columns=8, max_range=50.0)
SECTOR = Sensor(name="sector", elevations=(0.1, 0.0, -0.1, -0.2), columns=90, azimuth_start=0.7, azimuth_span=1.4)
SENSORS = [
    Sensor.preset("vlp16"),
    Sensor.preset("os1-32"),  # whose beams start ahead of the axis and look aside
    SECTOR,
    Sensor(name="one beam", elevations=(-0.1,), columns=360),
]
ROAD = Primitive(shape="plane", center=(0, 0, 0), size=(90, 90, 0), label="road", id="road")
CAR = Primitive(shape="box", center=(9, 0, 1), size=(4, 2, 2), label="car", id="car_1", instance=7)


def test_the_points_of_a_scan_become_that_scan() -> None:
    for sensor in SENSORS:
        scan = simulate(Layout((ROAD, CAR)), sensor, seed=1)
        known: dict[str, Any] = {"label": scan.labels(), "instance": scan.instances(), "intensity": scan.intensities()}
        order = np.random.default_rng(0).permutation(len(scan.points()))
        shuffled = {name: values[order] for name, values in known.items()}
        made = Scan.from_points(scan.points()[order], sensor, **shuffled, layout=scan.layout, pose=scan.pose)
        assert len(order) > 50, sensor
        np.testing.assert_allclose(made.image.depth, scan.image.depth, atol=1e-4, err_msg=sensor.name)
        for name in known:
            np.testing.assert_array_equal(getattr(made.image, name), getattr(scan.image, name), err_msg=sensor.name)
        assert made.boxes() == scan.boxes()
        assert made.returns_per_box() == scan.returns_per_box()
        assert made.notes == ()


def at(azimuth: float, elevation: float, distance: float) -> list[float]:
    """A point in the frame of a sensor; angles in degrees."""
    a, e = math.radians(azimuth), math.radians(elevation)
    return [distance * math.cos(e) * math.cos(a), distance * math.cos(e) * math.sin(a), distance * math.sin(e)]


def test_the_nearest_point_has_a_pixel_and_the_others_are_counted() -> None:
    points = np.array([at(20, 0, 12.0), at(25, 1, 10.0), at(-100, 6, 20.0), at(20, 60, 9.0), at(0, 0, 90.0)])
    message = "3 of 5 points are left out: 1 share a pixel of few with a nearer one, 2 out of sight"
    with pytest.warns(UserWarning, match=f"^{re.escape(message)}$") as caught:
        scan = Scan.from_points(
            points,
            FEW,
            label=np.array([1, 13, 3, 2, 2]),
            instance=np.array([0, 5, 0, 0, 0]),
            intensity=np.array([0.1, 0.2, 0.3, 0.4, 0.5]),
        )
    assert [warning.filename for warning in caught] == [__file__]
    assert scan.notes == (message,)
    # column w looks to 180 - 45 (w + 1/2) degrees
    assert np.argwhere(scan.image.valid).tolist() == [[0, 6], [1, 3]]
    np.testing.assert_allclose(scan.image.depth[scan.image.valid], [20.0, 10.0], rtol=1e-6)
    assert scan.labels().tolist() == [3, 13]
    assert scan.instances().tolist() == [0, 5]
    np.testing.assert_allclose(scan.intensities(), [0.3, 0.2])
    assert scan.points()[1] == pytest.approx(at(22.5, 0, 10.0))  # in the middle of its pixel
    np.testing.assert_array_equal(scan.pose, FEW.pose())
    assert scan.layout == Layout()
    assert (scan.seed, scan.speed, scan.turn, scan.time) == (0, 0.0, 0.0, None)


def test_points_alone_are_enough() -> None:
    pose = FEW.pose(x=3.0, yaw=0.5)
    scan = Scan.from_points([at(20, 0, 12.0)], FEW, pose=pose)  # type: ignore[arg-type]
    assert scan.labels().tolist() == scan.instances().tolist() == [0]
    assert scan.image.intensity is None
    np.testing.assert_array_equal(scan.pose, pose)
    assert Scan.from_points(np.zeros((0, 3)), FEW).image.valid.sum() == 0


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"intensity": [255.0]}, "intensity holds 0 to 255; it must be 0 to 1, as by a division by 255"),
        ({"intensity": [1.0, 7.0], "points": [[5.0, 0, 0], [6.0, 0, 0]]}, "intensity holds 0 to 7; it must be 0 to 1"),
        ({"intensity": [-0.5]}, "intensity holds -0.5 to 0; it must be 0 to 1"),
        ({"intensity": [math.nan]}, "an intensity is not finite"),
        ({"label": [99]}, "label holds 99; it must be whole numbers of 0 to 20"),
        ({"label": [1.5]}, r"label holds 1\.5; it must be whole numbers of 0 to 20"),
        ({"instance": [math.nan]}, "instance holds nan; it must be whole numbers of 0 to 4294967295"),
        ({"instance": [1, 2]}, "instance has 2 values for 1 points"),
        ({"points": [[1.0, math.inf, 0.0]]}, "point 0 is not finite"),
        ({"points": [1.0, 2.0, 3.0]}, r"points have shape \(3,\); they must be \[N, 3\]"),
        ({"pose": np.eye(3)}, "pose"),
    ],
)
def test_values_that_do_not_fit_are_one_line(changes: dict[str, Any], message: str) -> None:
    arguments: dict[str, Any] = {"points": [at(20, 0, 12.0)], "sensor": FEW, **changes}
    with pytest.raises(LayoutError, match=message):
        Scan.from_points(**arguments)


def test_the_sensor_is_a_sensor_and_the_layout_a_layout() -> None:
    with pytest.raises(TypeError, match="sensor is a str; it must be a Sensor"):
        Scan.from_points(np.zeros((1, 3)), "hdl64e")  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="layout is a str; it must be a Layout"):
        Scan.from_points(np.zeros((1, 3)), FEW, layout="a car")  # type: ignore[arg-type]
