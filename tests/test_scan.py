"""Scans, and the files that they are saved as."""

from pathlib import Path

import numpy as np
import pytest

from lidardraft import Layout, Primitive, RangeImageBatch, Scan, Sensor, raycast, simulate
from lidardraft.errors import FormatError
from lidardraft.formats import kitti, semantickitti
from lidardraft.scan import SCAN_ENDINGS
from lidardraft.scene import edit

SMALL = Sensor(name="small", elevations=tuple(np.deg2rad(np.linspace(2, -24, 16)).tolist()), columns=128)
LAYOUT = Layout((
    Primitive(shape="plane", center=(0, 0, 0), size=(200, 200, 0), label="road", id="road"),
    Primitive(shape="box", center=(9, 1, 0.8), size=(4, 2, 1.5), label="car", id="car_4", instance=4),
))  # fmt: skip


@pytest.fixture(scope="module")
def scan() -> Scan:
    return simulate(LAYOUT, SMALL, speed=20.0)


def test_the_condition_image_is_cast_from_where_the_scan_was_taken(scan: Scan) -> None:
    assert "condition_image" not in vars(scan)  # it is not cast before it is asked for
    poses = SMALL.poses_in_motion(SMALL.pose(), (20.0, 0.0, 0.0))
    np.testing.assert_array_equal(scan.condition_image.depth, raycast(LAYOUT, SMALL, poses=poses).depth)
    pose = SMALL.pose(x=3.0, yaw=0.4)
    still = simulate(LAYOUT, SMALL, pose=pose)
    np.testing.assert_array_equal(still.condition_image.depth, raycast(LAYOUT, SMALL, pose).depth)


def test_a_scan_is_saved_with_its_sensor(scan: Scan, tmp_path: Path) -> None:
    scan.save(tmp_path / "name.with.dots")
    assert {path.name for path in tmp_path.iterdir()} == {f"name.with.dots{ending}" for ending in SCAN_ENDINGS}
    assert Sensor.load(tmp_path / "name.with.dots.sensor.json") == SMALL
    points, intensity = kitti.read_bin(tmp_path / "name.with.dots.bin")
    np.testing.assert_array_equal(points, scan.points())
    np.testing.assert_array_equal(intensity, scan.intensities())
    label, instance = semantickitti.read_label(tmp_path / "name.with.dots.label", len(points))
    np.testing.assert_array_equal(label, scan.labels())
    np.testing.assert_array_equal(instance, scan.instances())
    assert scan.returns_per_box() == [np.count_nonzero(instance == 4)]
    assert scan.returns_per_box()[0] > 10


def test_a_scan_that_cannot_be_saved_leaves_nothing(scan: Scan, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    for name in ("file/000000", "nowhere/000000"):
        with pytest.raises(FormatError, match=f"{name} cannot be written"):
            scan.save(tmp_path / name)
    (tmp_path / "000000.png").mkdir()
    with pytest.raises(FormatError, match=r"000000\.png cannot be written: it is there, and not a regular file"):
        scan.save(tmp_path / "000000")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["000000.png", "file"]


def test_points_of_a_moving_sensor_lie_in_their_boxes() -> None:
    behind = Primitive(shape="box", center=(-9, 1, 0.8), size=(4, 2, 1.5), label="car", id="car_5", instance=5)
    scan = simulate(edit.add(LAYOUT, behind), SMALL, speed=20.0)
    for box in scan.boxes():
        mine = scan.instances() == box.instance
        points = scan.points()[mine]
        assert len(points) > 10
        assert (np.abs(points - box.center) <= np.array(box.size) / 2 + 0.15).all()
    assert np.abs(scan.image.points()[mine] - points).max() > 0.5  # where the sweep begins and ends


@pytest.mark.parametrize("name", ["image", "layout", "condition_image"])
def test_a_scan_and_what_it_is_made_of_are_shown_in_one_line(scan: Scan, name: str) -> None:
    part = repr(getattr(scan, name))
    assert part in repr(scan) or name == "condition_image"
    assert "16 x 128" in part or "2 shapes" in part
    for shown in (scan, SMALL, RangeImageBatch.empty(SMALL, 3), LAYOUT, getattr(scan, name)):
        assert len(repr(shown)) < 300
        assert "\n" not in repr(shown)
