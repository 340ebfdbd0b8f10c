"""Drives through streets: everything moves, what is scanned is what the layouts say, and each call gives the same."""

import dataclasses
import json
import math
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from lidardraft import Scan, Sensor, StreetConfig, StreetMix, export, street_drive
from lidardraft.arranging.street_mix import only
from lidardraft.errors import LidarDraftError
from lidardraft.semantics import BY_NAME
from lidardraft.simulation.motion.sequence import SequenceSimulator

SMALL = Sensor(name="small", elevations=tuple(np.deg2rad(np.linspace(4, -24, 24)).tolist()), columns=512)
CONFIG = StreetConfig(sensor=SMALL, half_length=200.0)
FRAMES = 12


@cache
def drive(number: int) -> SequenceSimulator:
    return street_drive(number, seed=4, config=CONFIG, frames=FRAMES)


@cache
def frame(number: int, of: int) -> Scan:
    return drive(number).frame(of)


def test_the_ego_vehicle_and_others_move() -> None:
    for number in range(3):
        assert drive(number).tracks.actors
        x, y = np.ptp([frame(number, k).pose[:2, 3] for k in (0, FRAMES - 1)], axis=0)
        assert math.hypot(x, y) > 0.5


def test_the_ground_of_the_layout_goes_as_far_as_the_street() -> None:
    for number in range(3):
        assert math.hypot(*drive(number).layout["road"].size[:2]) > 2 * CONFIG.half_length


def test_points_of_things_lie_in_the_boxes_of_the_layout() -> None:
    """Details reach a little over the boxes; what moves is as far from its box as it goes in half a sweep."""
    inside = total = 0
    for number in range(3):
        scan = frame(number, FRAMES // 2)
        points, instances = scan.points(), scan.instances()
        for box in scan.boxes():
            own = points[instances == box.instance]
            assert box.velocity is not None
            inside += int(box.contains(own, 0.15 + 0.05 * math.hypot(*box.velocity)).sum())
            total += len(own)
    assert total > 500
    assert inside > 0.98 * total


def test_wheels_stand_on_the_ground() -> None:
    gaps = []
    for number in range(3):
        scan = frame(number, FRAMES // 2)
        road = scan.points()[scan.labels() == BY_NAME["road"].id]
        for box in scan.boxes():
            near = road[np.hypot(*(road[:, :2] - box.center[:2]).T) < 3.0]  # the road falls by up to 8 %
            if box.label == "car" and len(near) > 5:
                gaps.append(box.center[2] - box.size[2] / 2 - float(np.median(near[:, 2])))
    assert len(gaps) > 2
    assert max(map(abs, gaps)) < 0.25


def test_a_drive_depends_on_seed_and_number_alone() -> None:
    again = street_drive(1, seed=4, config=CONFIG, frames=FRAMES, threads=1)
    assert again.frame(5).image.depth.tobytes() == frame(1, 5).image.depth.tobytes()
    assert again.layout == drive(1).layout
    assert drive(2).layout != drive(1).layout


@pytest.mark.parametrize(
    "name", ["motorway", *(pytest.param(n, marks=pytest.mark.slow) for n in ("village", "school"))]
)
def test_a_district_has_drives(name: str) -> None:
    few = dataclasses.replace(SMALL, name="few", elevations=SMALL.elevations[:8], columns=64)
    config = StreetConfig(sensor=few, half_length=200.0, mix=StreetMix(**only(name)))
    assert street_drive(0, seed=1, config=config, frames=3).layout.intent.district == name


def test_bad_drives_are_refused() -> None:
    with pytest.raises(LidarDraftError, match="number is -1"):
        street_drive(-1, config=CONFIG)
    with pytest.raises(LidarDraftError, match="hz is 0"):
        street_drive(0, config=CONFIG, hz=0)


@pytest.mark.parametrize("number", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_traffic_passes_under_crowns_on_hills_too(number: int) -> None:
    """Here two cars waited for ever at trees whose crowns hang over the lane, and the ego vehicle behind them."""
    few = dataclasses.replace(SMALL, name="few", elevations=SMALL.elevations[:8], columns=64)
    tracks = street_drive(number, seed=2, config=dataclasses.replace(CONFIG, sensor=few), frames=120).tracks
    late = tracks.ego.at(np.array([8.0, 11.5]))[:, :2]
    assert math.dist(*late) > 10.0


def test_drives_of_riders_as_scenes_of_nuscenes(tmp_path: Path) -> None:
    """Velocities are displacements over time, riders and their cycles are one object, scenes have what they are of."""
    config = dataclasses.replace(CONFIG, mix=StreetMix(**only("urban"), riders=6.0))
    drives = [street_drive(number, seed=1, config=config, frames=3) for number in range(2)]
    scans = [list(each) for each in drives]
    export(scans, "nuscenes", tmp_path / "out")
    tables = {path.stem: json.loads(path.read_text()) for path in (tmp_path / "out/v1.0-trainval").iterdir()}
    assert [(scene["description"], scene["nbr_samples"]) for scene in tables["scene"]] == [("urban", 3)] * 2
    times = {row["token"]: row["timestamp"] * 1e-6 for row in tables["sample"]}
    rows = {row["token"]: row for row in tables["sample_annotation"]}
    names = {row["token"]: row["name"] for table in ("attribute", "category") for row in tables[table]}
    kinds, found, speeds = {row["token"]: names[row["category_token"]] for row in tables["instance"]}, set(), {}
    for middle in (row for row in rows.values() if row["prev"] and row["next"]):
        before, after = rows[middle["prev"]], rows[middle["next"]]
        span = times[after["sample_token"]] - times[before["sample_token"]]
        speed = math.dist(after["translation"][:2], before["translation"][:2]) / span
        (said,) = (names[token] for token in middle["attribute_tokens"])
        found.add((kind := kinds[middle["instance_token"]], said))
        speeds.setdefault(said, []).append(speed)
        assert kind.split(".")[0] in ("vehicle", "human")
    assert ("vehicle.bicycle", "cycle.with_rider") in found
    assert min(*speeds["cycle.with_rider"], *speeds["vehicle.moving"]) > 0.2
    assert max(*speeds["cycle.without_rider"], *speeds["vehicle.parked"]) < 1e-6
    known = sorted(math.hypot(*box.velocity[:2]) for each in scans for box in each[1].boxes() if box.label == "car")
    driven = sorted(speeds["vehicle.moving"] + speeds["vehicle.parked"] + speeds.get("vehicle.stopped", []))
    assert driven[-1] == pytest.approx(known[-1], rel=0.02)
