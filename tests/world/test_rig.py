"""Rigs: sensors of one vehicle see one moment, each from where it is mounted."""

import dataclasses
import json
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lidardraft
from lidardraft import Layout, Primitive, Scan, Sensor, SensorModel, layout_from_text
from lidardraft.errors import LidarDraftError
from lidardraft.world.rig import Mount, Rig
from lidardraft.world.world import World

SMALL = Sensor(
    name="small", elevations=tuple(np.deg2rad(np.linspace(2, -24, 16)).tolist()), columns=512, range_sigma=0.0
)
SLOW = dataclasses.replace(SMALL, name="slow", sweep_time=0.2)
RIG = Rig({"top": Mount(SMALL, (0.0, 0.0, 1.73, 0.0)), "left": Mount(SLOW, (1.2, 0.9, 0.8, 1.5))})
ROAD = Primitive(shape="plane", center=(0, 0, 0), size=(400, 60, 0), label="road", id="road")
WALL = Primitive(shape="box", center=(25, 0, 3), size=(1, 50, 6), label="building", id="wall", material="concrete")
LAYOUT = layout_from_text("a straight road, a car 20 m ahead and a van on the left", seed=3)


def test_a_rig_is_kept_in_a_file(tmp_path: Path) -> None:
    RIG.save(tmp_path / "rig.json")
    assert Rig.load(tmp_path / "rig.json") == RIG
    rows = json.loads((tmp_path / "rig.json").read_text())
    rows["mounts"]["left"]["spot"] = [1, 2]
    (tmp_path / "rig.json").write_text(json.dumps(rows))
    with pytest.raises(LidarDraftError, match=r"rig.json: left: spot is \[1, 2\]; it must be four finite numbers"):
        Rig.load(tmp_path / "rig.json")
    del rows["mounts"]["left"]["spot"]
    (tmp_path / "rig.json").write_text(json.dumps(rows))
    with pytest.raises(LidarDraftError, match=r"rig.json: left: .*spot"):
        Rig.load(tmp_path / "rig.json")


def test_the_first_sensor_on_its_usual_mount_scans_as_it_does_alone() -> None:
    alone, rig = World(LAYOUT, SMALL, seed=3), World(LAYOUT, RIG, seed=3)
    for world in (alone, rig):
        world.step(0.3)
    one, two = alone.scan(), rig.scans()
    assert list(two) == ["top", "left"]
    assert one.image.depth.tobytes() == two["top"].image.depth.tobytes()
    assert rig.scan("left") is two["left"]
    assert two["top"].time == pytest.approx(0.25)
    assert two["left"].time == pytest.approx(0.2)
    again = World(rig.state(), RIG)
    for name, scan in again.scans().items():
        assert scan.image.depth.tobytes() == two[name].image.depth.tobytes()


def test_sensors_of_a_vehicle_that_turns_agree_on_what_stands() -> None:
    """Each has its own way through the bend, and its points lie on the wall."""
    world = World(Layout((ROAD, WALL)), RIG)
    for k in range(1, 5):
        world.ego.pose = (1.0 * k, 0.3 * k, 0.05 * k)
        world.step(0.1)
    for name, scan in world.scans().items():
        x, y, z, yaw = RIG.mounts[name].spot
        middle = 0.4 - scan.image.sensor.sweep_time / 2
        at = np.array([10.0 * middle, 3.0 * middle, 0.0])
        turn = 0.5 * middle
        cos, sin = math.cos(turn), math.sin(turn)
        mounted = at + np.array([cos * x - sin * y, sin * x + cos * y, z])
        np.testing.assert_allclose(scan.pose[:3, 3], mounted, atol=1e-9)
        assert math.atan2(scan.pose[1, 0], scan.pose[0, 0]) == pytest.approx(turn + yaw)
        assert scan.turn == pytest.approx(0.5)
        points = scan.points()[scan.labels() == 3] @ scan.pose[:3, :3].T + scan.pose[:3, 3]
        front = points[(np.abs(points[:, 1]) < 20) & (points[:, 0] < 24.8)]
        assert len(front) > 200
        assert np.abs(front[:, 0] - 24.5).max() < 0.1


def test_channels_of_a_rig_become_one_data_set(tmp_path: Path) -> None:
    """In nuScenes' tables a sample has a sweep of each channel, whose transforms take its points to the world."""
    world = World(LAYOUT, RIG, seed=3)
    scans: dict[str, list[Scan]] = {"top": [], "left": []}
    for _ in range(2):
        world.step(0.5)
        for name, scan in world.scans().items():
            scan.save(tmp_path / f"{name}_{len(scans[name])}", picture=False)
            scans[name].append(Scan.load(tmp_path / f"{name}_{len(scans[name])}"))
    lidardraft.export(scans, "nuscenes", tmp_path / "out")
    table = {
        path.stem: {row["token"]: row for row in json.loads(path.read_text())}
        for path in (tmp_path / "out" / "v1.0-trainval").glob("*.json")
    }
    assert [row["channel"] for row in table["sensor"].values()] == ["top", "left"]
    assert len(table["sample"]) == 2
    assert len(table["sample_data"]) == 4
    for sample, row in enumerate(table["sample"]):
        sweeps = [data for data in table["sample_data"].values() if data["sample_token"] == row]
        for data in sweeps:
            calibrated = table["calibrated_sensor"][data["calibrated_sensor_token"]]
            scan = scans[table["sensor"][calibrated["sensor_token"]]["channel"]][sample]
            points = np.fromfile(tmp_path / "out" / data["filename"], np.float32).reshape(-1, 5)[:, :3]
            for step in (calibrated, table["ego_pose"][data["ego_pose_token"]]):
                w, x, y, z = step["rotation"]
                points = Rotation.from_quat([x, y, z, w]).apply(points) + step["translation"]
            np.testing.assert_allclose(points, scan.points() @ scan.pose[:3, :3].T + scan.pose[:3, 3], atol=1e-4)
            assert table["ego_pose"][data["ego_pose_token"]]["translation"][2] == pytest.approx(0.0, abs=1e-6)
            linked = table["sample_data"][data["prev"] or data["next"]]
            assert linked["calibrated_sensor_token"] == data["calibrated_sensor_token"]
        found = [each for each in table["sample_annotation"].values() if each["sample_token"] == row]
        counts = [
            dict(zip([box.id for box in scan.boxes()], scan.returns_per_box(), strict=True))
            for scan in (scans[name][sample] for name in scans)
        ]
        assert sorted(each["num_lidar_pts"] for each in found) == sorted(
            sum(c[name] for c in counts) for name in counts[0]
        )


def test_channels_of_a_rig_get_a_folder_each_in_other_formats(tmp_path: Path) -> None:
    world = World(LAYOUT, RIG, seed=3)
    scans = {name: [scan] for name, scan in world.scans().items()}
    lidardraft.export(scans, "pcd", tmp_path / "out")
    assert {path.parent.name for path in (tmp_path / "out").rglob("*.pcd")} == {"top", "left"}
    with pytest.raises(LidarDraftError, match=r"channel is '../top'; it must be a name of letters"):
        lidardraft.export({"../top": scans["top"]}, "pcd", tmp_path / "other")
    with pytest.raises(LidarDraftError, match="the channels have different numbers of scans"):
        lidardraft.export(scans | {"left": scans["left"] * 2}, "nuscenes", tmp_path / "other")
    assert not (tmp_path / "other").exists()


def test_bad_rigs() -> None:
    with pytest.raises(LidarDraftError, match="the rig has no sensors"):
        Rig({})
    with pytest.raises(TypeError, match="sensor is a str; it must be a Sensor"):
        Mount("vlp16", (0, 0, 0, 0))  # type: ignore[arg-type]
    with pytest.raises(LidarDraftError, match=r"model is SensorModel.*; it must be left out: each sensor of a rig"):
        World(LAYOUT, RIG, model=SensorModel())
    with pytest.raises(LidarDraftError, match="channel is 'lef'; it must be one of top, left; did you mean 'left'"):
        World(LAYOUT, RIG).scan("lef")
