"""Scans, and the files that they are saved as."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from lidardraft import Layout, Primitive, RangeImageBatch, RecordedScan, Scan, Sensor, raycast, simulate
from lidardraft.errors import FormatError, SensorError
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
    with pytest.raises(FormatError, match=r"000000\.png cannot be written: it exists and is not a regular file"):
        scan.save(tmp_path / "000000")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["000000.png", "file"]


def test_an_earlier_scan_of_a_name_is_replaced_whole(scan: Scan, tmp_path: Path) -> None:
    name, others = tmp_path / "000000", ("000000.txt", "000000.bin.png", "000001.png")
    for other in others:
        (tmp_path / other).write_text("mine")

    def endings() -> set[str]:
        return {path.name.removeprefix("000000") for path in tmp_path.iterdir() if path.name not in others}

    (tmp_path / "000000.png").write_text("a picture of mine")
    scan.save(name, picture=False)  # over no scan
    assert (tmp_path / "000000.png").read_text() == "a picture of mine"
    scan.save(name)
    scan.save(name, picture=False)
    assert endings() == set(SCAN_ENDINGS) - {".png"}
    scan.save(name)
    RecordedScan.from_points(scan.points(), SMALL).save(name)
    assert endings() == set(SCAN_ENDINGS) - {".png", ".layout.json"}
    scan.save(name)
    replace(scan, layout=Layout()).save(name)  # of which nobody knows the objects
    assert endings() == set(SCAN_ENDINGS) - {".boxes.json"}
    assert all((tmp_path / other).read_text() == "mine" for other in others)


def test_an_image_without_intensity_is_not_saved_as_a_scan(tmp_path: Path) -> None:
    bare = Scan(image=raycast(LAYOUT, SMALL), layout=LAYOUT, pose=SMALL.pose(), seed=0)
    said = "no intensity in the image; `simulate` and `observe_cast` give one, `Scan.from_points` takes one"
    for refused in (bare.intensities, bare.frame, lambda: bare.save(tmp_path / "a")):
        with pytest.raises(SensorError, match=said):
            refused()
    assert not list(tmp_path.iterdir())
    assert '["intensity", ' not in bare.html()
    assert bare.picture().shape == (712, 1400, 3)  # with two range images


@pytest.mark.parametrize(
    "motion", [{"turn": 0.5}, {"turn": 0.5, "time": 1.0}, {"speed": 9.0, "heading": (0.0, 0.6, -0.8)}, {"time": 2.0}]
)
def test_a_motion_goes_through_a_file(scan: Scan, motion: dict[str, Any], tmp_path: Path) -> None:
    moving = replace(scan, **({"speed": 3.0} | motion))
    moving.save(tmp_path / "a", picture=False)
    loaded = Scan.load(tmp_path / "a")
    assert {name: getattr(loaded, name) for name in motion} == motion
    np.testing.assert_array_equal(loaded.poses(), moving.poses())
    np.testing.assert_array_equal(loaded.points(), moving.points())
    along = motion.get("heading", (1.0, 0.0, 0.0))
    moved = moving.poses()[-1, :3, 3] - SMALL.pose()[:3, 3]
    np.testing.assert_allclose(moved, np.multiply(along, moving.speed * 0.1 * (127 / 128 - 0.5)), atol=1e-12)


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
