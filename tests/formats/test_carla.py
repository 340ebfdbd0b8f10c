"""Clouds of CARLA's semantic LiDAR: its frame, its tags, its files."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from lidardraft import RangeImage
from lidardraft.errors import FormatError, SensorError
from lidardraft.formats.carla import TAGS, TAGS_BEFORE_0_9_14, carla_sensor, read_carla
from lidardraft.scene.materials import MATERIALS
from lidardraft.semantics import BY_NAME

HEADER = """ply
format ascii 1.0
element vertex {count}
property float32 x
property float32 y
property float32 z
property float32 CosAngle
property uint32 ObjIdx
property uint32 ObjTag
end_header
"""
# what CARLA writes of a car ahead on the right, a lane marking and a traffic light that is an actor
ROWS = ["9.0000 2.0000 -1.5000 0.5000 70000 14", "5.0000 0.0000 -2.4000 -0.4000 0 24", "20.0 -3.0 1.0 0.9 31 7"]


def written(path: Path, rows: list[str], header: str = HEADER) -> Path:
    path.write_text(header.format(count=len(rows)) + "".join(f"{row}\n" for row in rows))
    return path


def test_y_points_left_and_tags_become_classes(tmp_path: Path) -> None:
    cloud = read_carla(written(tmp_path / "a.ply", ROWS))
    np.testing.assert_allclose(cloud.points, [[9, -2, -1.5], [5, 0, -2.4], [20, 3, 1]], rtol=1e-6)
    np.testing.assert_allclose(cloud.incidence, [0.5, 0.4, 0.9], rtol=1e-6)
    assert cloud.label.tolist() == [BY_NAME[name].id for name in ("car", "road", "traffic-light")]
    assert cloud.instance.tolist() == [70000, 0, 0]  # of stuff there are no instances
    assert [None if k < 0 else MATERIALS[k].name for k in cloud.materials] == [None, "road-paint", None]


def test_records_of_numpy_are_the_same_cloud(tmp_path: Path) -> None:
    fields = [(name, "<f4") for name in ("x", "y", "z", "CosAngle")] + [("ObjIdx", "<u4"), ("ObjTag", "<u4")]
    np.save(tmp_path / "a.npy", np.array([tuple(map(float, row.split())) for row in ROWS], fields))
    one, two = read_carla(tmp_path / "a.npy"), read_carla(written(tmp_path / "a.ply", ROWS))
    for name in ("points", "incidence", "label", "instance", "materials"):
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name))
    np.save(tmp_path / "b.npy", np.zeros((3, 6), np.float32))
    with pytest.raises(FormatError, match=r"b\.npy: it has no x of one number a hit; CARLA's semantic LiDAR has x y z"):
        read_carla(tmp_path / "b.npy")


def test_the_tags_of_both_numberings_are_the_same_kinds(tmp_path: Path) -> None:
    assert list(TAGS) == list(range(29))
    assert list(TAGS_BEFORE_0_9_14) == list(range(23))
    names = "none building fence other person pole road road sidewalk vegetation car wall traffic-sign none terrain"
    assert [TAGS_BEFORE_0_9_14[tag][0] for tag in range(15)] == names.split()
    assert [TAGS_BEFORE_0_9_14[tag][0] for tag in (18, 22)] == ["traffic-light", "terrain"]
    path = written(tmp_path / "a.ply", ["9 2 -1 0.5 7 10"])
    assert read_carla(path).label.tolist() == [BY_NAME["terrain"].id]
    assert read_carla(path, TAGS_BEFORE_0_9_14).label.tolist() == [BY_NAME["car"].id]


@pytest.mark.parametrize(
    ("rows", "header", "message"),
    [
        (["9 2 -1 0.5 7 29"], HEADER, "hit 0 has tag 29; CARLA has tags 0 to 28"),
        (["9 2 -1 0.5 7 4294967296"], HEADER, "could not convert string '4294967296' to uint32"),
        (["9 2 -1 0.5 7 -1"], HEADER, "-1"),
        (["9 nan -1 0.5 7 1"], HEADER, "hit 0 is not finite"),
        (["9 2 -1 0.5 7 car"], HEADER, "car"),
        (["9 2 -1 0.5 7"], HEADER, "requires 6 columns but 5 were found"),
        (
            ROWS,
            HEADER.replace("CosAngle", "I"),
            "it has no CosAngle of one number a hit",
        ),
        (ROWS, HEADER.replace("ascii", "binary"), "no header of a PLY file"),
        (ROWS, HEADER.replace("vertex", "face"), "the first element must be vertex"),
    ],
)
def test_what_is_no_such_cloud_is_named(tmp_path: Path, rows: list[str], header: str, message: str) -> None:
    with pytest.raises(FormatError, match=f"a.ply: .*{message}"):
        read_carla(written(tmp_path / "a.ply", rows, header))


def test_each_ray_of_the_sensor_has_a_pixel_of_its_own() -> None:
    sensor = carla_sensor(channels=8, upper_fov=5.0, lower_fov=-20.0, points_per_second=8 * 360 * 10, max_range=50.0)
    assert sensor.shape == (8, 360)
    # as CARLA aims: channels from the highest, a turn in equal steps from straight ahead on, clockwise
    elevation, azimuth = np.meshgrid(np.deg2rad(np.linspace(5, -20, 8)), -np.deg2rad(np.arange(360)), indexing="ij")
    towards = [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)]
    points = np.round(10.0 * np.stack(towards, axis=-1).reshape(-1, 3), 4)
    image = RangeImage.project(points, sensor)
    assert image.valid.all()
    assert math.isclose(image.depth.mean(), 10.0, abs_tol=1e-3)


@pytest.mark.parametrize("attribute", [{"channels": 0}, {"channels": -1}, {"rotation_frequency": 0.0}])
def test_a_sensor_of_carla_that_cannot_be(attribute: dict[str, Any]) -> None:
    with pytest.raises(SensorError, match="they must be over 0"):
        carla_sensor(**attribute)
