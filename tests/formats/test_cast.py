"""Casts of others in .npz files."""

from pathlib import Path

import numpy as np
import pytest

from lidardraft import Sensor
from lidardraft.errors import FormatError
from lidardraft.formats.cast import read_cast

SENSOR = Sensor(name="few", elevations=(0.1, 0.0, -0.1), columns=16)
IMAGES = {"depth": np.full((3, 16), 9.0), "label": np.ones((3, 16), np.int64)}


def test_a_cast_of_any_numbers_is_read(tmp_path: Path) -> None:
    instance = np.arange(48, dtype=np.int16).reshape(3, 16)
    np.savez(tmp_path / "a.npz", **IMAGES, instance=instance, rgb=np.zeros((9, 9, 3)))
    sensor, images = read_cast(tmp_path / "a.npz", SENSOR)
    assert sensor == SENSOR
    assert set(images) == {"depth", "label", "instance"}
    np.testing.assert_array_equal(images["instance"], instance)
    np.testing.assert_array_equal(images["depth"], IMAGES["depth"])


def test_the_sensor_of_the_file_is_the_sensor(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", **IMAGES, sensor=np.array(SENSOR.to_json()))
    assert read_cast(tmp_path / "a.npz")[0] == SENSOR
    assert read_cast(tmp_path / "a.npz", Sensor.preset("vlp16"))[0] == SENSOR


@pytest.mark.parametrize(
    ("images", "message"),
    [
        ({"depth": IMAGES["depth"]}, "'label' is missing"),
        (IMAGES | {"label": np.full((3, 16), "car")}, "label is <U3; it must hold numbers"),
        (IMAGES | {"depth": np.zeros((4, 16))}, r"depth is float64 \(4, 16\); it must be float64 \(3, 16\)"),
    ],
)
def test_what_is_no_cast_is_named(tmp_path: Path, images: dict[str, np.ndarray], message: str) -> None:
    np.savez(tmp_path / "a.npz", **images)
    with pytest.raises(FormatError, match=f"a.npz: {message}"):
        read_cast(tmp_path / "a.npz", SENSOR)


def test_a_cast_without_a_sensor_needs_one(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", **IMAGES)
    with pytest.raises(FormatError, match=r"a\.npz: it does not say by which sensor it is; give one"):
        read_cast(tmp_path / "a.npz")
