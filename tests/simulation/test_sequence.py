"""Sequences: each column sees what moves where it is then, the rest is one world, and files say what was driven."""

import dataclasses
import itertools
import json
import math
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lidardraft import Layout, Primitive, Raycaster, Scan, Sensor, layout_from_text, surround
from lidardraft.errors import LidarDraftError
from lidardraft.scene.effects import sub_rays
from lidardraft.scene.pose import upright
from lidardraft.scene.scenario import AlongLane, Motion, Scenario, Straight, Track, Walk, Waypoints
from lidardraft.semantics import BY_NAME
from lidardraft.simulation.motion.motions import Ground
from lidardraft.simulation.motion.sequence import SequenceSimulator
from lidardraft.simulation.motion.tracks import Tracks, tracks_of

SMALL = Sensor(name="small", elevations=tuple(np.deg2rad(np.linspace(2, -24, 16)).tolist()), columns=256)
ROAD = Primitive(shape="plane", center=(0, 0, 0), size=(400, 14, 0), label="road", id="road")
HOUSE = Primitive(shape="box", center=(0, 30, 4), size=(200, 4, 8), label="building", id="house_1")


def car(x: float, y: float, *, number: int = 1, yaw: float = 0.0, label: str = "car") -> Primitive:
    size = (4.2, 1.8, 1.5)
    name = f"{label}_{number}"
    return Primitive(
        shape="box", center=(x, y, 0.76), size=size, yaw=yaw, label=label, id=name, instance=number
    )  # fmt: skip


def street(*cars: Primitive, lanes: int = 1) -> Layout:
    """A layout with a straight road of 3.5 m lanes that its source tells, the ego vehicle in the right one."""
    layout = layout_from_text("an empty straight road" if lanes == 1 else "a road with two lanes each way", seed=0)
    kept = tuple(p for p in layout if p.label in ("road", "terrain", "sidewalk"))
    return Layout((*kept, *cars), layout.provenance)


def simulator(layout: Layout, scenario: Scenario, sensor: Sensor = SMALL, **more: object) -> SequenceSimulator:
    return SequenceSimulator(layout, sensor, scenario, detail=False, **{"frames": 4, **more})  # type: ignore[arg-type]


@pytest.mark.parametrize("azimuth_offsets", [(), (0.05, -0.05) * 8])
def test_each_column_sees_what_moves_where_it_is_then(azimuth_offsets: tuple[float, ...]) -> None:
    sensor = dataclasses.replace(SMALL, azimuth_offsets=azimuth_offsets)
    layout = Layout((ROAD, HOUSE, car(12, 4), car(-9, -3, number=2), car(3, -6, number=3)))
    scenario = Scenario(
        Straight(9.0),
        {
            "car_1": Straight(-14.0),
            "car_2": Waypoints(((0.0, -9.0, -3.0, 0.0), (0.4, -3.0, -3.5, 0.9))),
            "car_3": Straight(20.0),
        },
    )
    made = simulator(layout, scenario, sensor)
    rays = sub_rays(sensor, sensor.assumed_model)
    for number in (0, 2):
        cast, time = made.cast(number), made.time(number)
        (speed, turn), pose = made._ego_rate(number), made.pose(number)
        poses = sensor.poses_in_motion(pose, speed * pose[:3, 0], (0, 0, turn))
        seen = set[int]()
        for column in range(0, 256, 3):
            since = sensor.column_times()[column] - sensor.sweep_time / 2
            caster = Raycaster(layout)
            for name, track in made.tracks.actors.items():
                place = track.at(np.array([time]))[0] + since * track.rate(time, sensor.sweep_time)
                caster.move(name, upright(tuple(place[:3]), place[3]))
            truth = caster.scan(rays, poses[column])
            np.testing.assert_allclose(cast.depth[:, column], truth.depth[:, column], atol=2e-4)
            assert (cast.instance[:, column] == truth.instance[:, column]).mean() > 0.99
            seen |= set(truth.instance[:, column].tolist())
        assert seen == {0, 1, 2, 3}


@pytest.mark.parametrize(("speed", "turn"), [(0.0, 2.0), (0.0, -2.0), (2.0, -2.0)])
def test_a_sequence_is_cast_by_an_ego_vehicle_that_turns(speed: float, turn: float) -> None:
    """As another caster sees it from where the track has the vehicle at the time of each column."""
    far = [car(-42, y, number=number, yaw=1.57) for number, y in enumerate(range(-30, 31, 6), start=4)]
    field = dataclasses.replace(ROAD, size=(200, 200, 0))
    layout = Layout((field, car(-9, 0.5), car(-7, -3, number=2), car(3, -6, number=3, yaw=1.0), *far))
    times = np.linspace(0.0, 0.6, 61)
    yaw = turn * times
    bend = np.stack([times, speed / turn * np.sin(yaw), speed / turn * (1 - np.cos(yaw)), yaw], axis=1)
    ego = Waypoints(tuple(map(tuple, bend.tolist())))
    actors = {"car_1": Straight(3.0), "car_2": Straight(-4.0), "car_3": Straight(2.0)}
    actors |= {f"car_{number}": Straight(0.1) for number in range(4, 15)}
    made = simulator(layout, Scenario(ego, actors), hz=10.0)
    rays, cast = sub_rays(SMALL, SMALL.assumed_model), made.cast(3)
    off, truths = np.zeros(cast.depth.shape), np.zeros(cast.depth.shape, int)
    for column, since in enumerate(SMALL.column_times()):
        time, caster = np.array([0.3 + since]), Raycaster(layout)
        for name, track in made.tracks.actors.items():
            x, y, z, looks = track.at(time)[0].tolist()
            caster.move(name, upright((x, y, z), looks))
        x, y, _, looks = made.tracks.ego.at(time)[0].tolist()
        truth = caster.scan(rays, upright((x, y, SMALL.mount_height), looks))
        off[:, column] = np.abs(cast.depth[:, column] - truth.depth[:, column]) / np.maximum(truth.depth[:, column], 1)
        truths[:, column] = truth.instance[:, column]
    assert (off < 2e-3).mean() > 0.995  # but for edges: in a sweep it drives straight on, 5 mm beside the bend
    assert len(np.unique(cast.instance)) >= 12  # of 15: a turn against the head's leaves a gap behind
    assert ((truths > 3) & (cast.instance == 0)).sum() <= 20 * (speed > 0)
    scan = made.frame(3)
    assert scan.turn == pytest.approx(turn)
    for box in scan.boxes():  # and the turn is taken out of its points
        mine = scan.points()[scan.instances() == box.instance]
        assert box.contains(mine, 0.3).all()  # the cars drive up to 0.2 m meanwhile


def test_the_ego_vehicle_leans_as_the_ground_under_its_wheels_does_and_sways() -> None:
    corners = np.array([(x, y, 0.05 * x - 0.02 * y) for x in (-90.0, 90.0) for y in (-40.0, 40.0)])
    slope = Primitive.from_mesh(corners, np.array([(0, 2, 1), (1, 2, 3)]), label="road", id="road")
    up = np.array([-0.05, 0.02, 1.0]) / math.sqrt(1 + 0.05**2 + 0.02**2)
    drive = simulator(Layout((slope,)), Scenario(Waypoints(((0.0, 0.0, 0.0, 0.3), (4.0, 20.0, 6.0, 0.3)))))
    poses = [drive.pose(number) for number in range(4)]
    for pose in poses:
        np.testing.assert_allclose(pose[:3, 2], up, atol=0.015)
        assert math.atan2(pose[1, 0], pose[0, 0]) == pytest.approx(0.3, abs=1e-3)
        below = pose[:3, 3] - SMALL.mount_height * pose[:3, 2]
        assert below[2] == pytest.approx(0.05 * below[0] - 0.02 * below[1], abs=0.01)
    assert 1e-4 < np.ptp([pose[2, 0] for pose in poses]) < 0.02
    points = drive.frame(2).points()  # level in the frame of the sensor
    assert np.median(points[:, 2]) == pytest.approx(-SMALL.mount_height, abs=0.1)
    level = simulator(Layout((ROAD,)), Scenario(Straight(9.0)))
    np.testing.assert_array_equal(level.pose(1)[:3, :3], np.eye(3))


def test_a_car_is_sheared_as_fast_as_it_drives_while_it_is_swept() -> None:
    """On the left its front is swept after its rear: without rolling shutter it would be 4.2 m long."""
    sensor = dataclasses.replace(SMALL, columns=2048, range_sigma=0.0)
    layout = Layout((ROAD, car(0, 8)))
    lengths = []
    for speed in (-20.0, 0.0, 20.0):
        scan = simulator(layout, Scenario(None, {"car_1": Straight(speed)}), sensor, frames=1).frame(0)
        x = scan.points()[scan.instances() == 1, 0]
        lengths.append(float(np.ptp(x)))
    swept = 2 * math.atan(2.1 / 7.1) / math.tau * 0.1  # s, as the head turns clockwise
    assert lengths[1] == pytest.approx(4.2, abs=0.05)
    assert lengths[0] - lengths[1] == pytest.approx(-20.0 * swept, abs=0.06)
    assert lengths[2] - lengths[1] == pytest.approx(20.0 * swept, abs=0.06)


def test_what_stands_is_one_world_and_noise_is_drawn_for_each_frame() -> None:
    crown = Primitive(
        shape="ellipsoid", center=(12, -4, 3), size=(4, 4, 3), label="vegetation", id="tree_1.crown", extinction=0.8
    )
    made = simulator(Layout((ROAD, HOUSE, crown, car(12, 4))), Scenario())
    one, two = made.cast(0), made.cast(3)
    assert all(getattr(one, name).tobytes() == getattr(two, name).tobytes() for name in ("depth", "primitive"))
    assert made.frame(0).image.depth.tobytes() != made.frame(3).image.depth.tobytes()
    assert made.frame(2).image.depth.tobytes() == made.frame(2).image.depth.tobytes()


def test_boxes_follow_with_their_velocities_and_returns_lie_in_them() -> None:
    layout = street(car(12, 0), car(-15, 3.5, number=2, yaw=math.pi))
    made = simulator(layout, Scenario(AlongLane(6.0), {"car_1": AlongLane(8.0), "car_2": AlongLane(10.0)}), hz=5.0)
    scans = list(made)
    assert [scan.time for scan in scans] == pytest.approx([0.05, 0.25, 0.45, 0.65])
    for before, after in itertools.pairwise(scans):
        for one, two in zip(before.boxes(), after.boxes(), strict=True):
            assert (one.id, one.instance) == (two.id, two.instance)
            assert one.velocity is not None
            assert two.velocity is not None
            here, there = (
                scan.pose[:3, :3] @ box.center + scan.pose[:3, 3] for scan, box in ((before, one), (after, two))
            )
            mean = np.add(one.velocity, two.velocity) / 2  # the ego vehicle does not turn
            np.testing.assert_allclose((there - here) / 0.2, mean, atol=0.1)
        points, instances = after.points(), after.instances()
        for box in after.boxes():
            off = (points[instances == box.instance] - box.center) @ upright((0, 0, 0), box.yaw)[:3, :3]
            assert len(off) > 5
            assert (np.abs(off) < np.array(box.size) / 2 + (0.8, 0.2, 0.2)).all()


def test_a_frame_is_saved_and_read_and_leaves_with_its_time(tmp_path: Path) -> None:
    made = simulator(street(car(12, 0)), Scenario(AlongLane(6.0)), hz=5.0)
    scans = list(made)
    scans[1].save(tmp_path / "000001", picture=False)
    read = Scan.load(tmp_path / "000001.bin")
    assert (read.time, read.speed, read.turn) == (scans[1].time, scans[1].speed, scans[1].turn)
    assert read.velocities == scans[1].velocities
    assert [box.velocity for box in read.boxes()] == [box.velocity for box in scans[1].boxes()]
    row = json.loads((tmp_path / "000001.boxes.json").read_text())["boxes"][0]
    assert row["velocity"] == pytest.approx(read.boxes()[0].velocity)
    assert [scan.frame().start for scan in scans] == pytest.approx([0.0, 0.2, 0.4, 0.6])


def test_a_file_of_tracks_moves_everything_again(tmp_path: Path) -> None:
    layout = street(car(12, 0), car(-15, 3.5, number=2, yaw=math.pi), car(40, -6, number=3, label="person"))
    made = simulator(layout, Scenario(), frames=20)
    made.save_tracks(tmp_path)
    again = simulator(layout, Scenario.load(tmp_path / "tracks.json"), frames=20)
    assert np.loadtxt(tmp_path / "times.txt") == pytest.approx([made.time(n) for n in range(20)])
    poses = np.loadtxt(tmp_path / "poses.txt").reshape(-1, 3, 4)
    for number in (0, 9, 19):
        np.testing.assert_allclose(made.pose(number), again.pose(number), atol=2e-3)
        np.testing.assert_allclose(poses[number], made.pose(number)[:3], atol=1e-6)
        one, two = made.frame(number), again.frame(number)
        for box, other in zip(one.boxes(), two.boxes(), strict=True):
            np.testing.assert_allclose(box.center, other.center, atol=5e-3)


@pytest.mark.parametrize("motion", [Walk((14.0, 9.0)), Waypoints(((0, 14, -6), (5, 20, -6))), Straight(2.0)])
def test_a_flash_is_a_sequence_of_one_frame(motion: Motion) -> None:
    person = car(14, -6, label="person")
    flash = dataclasses.replace(SMALL, sweep_time=0.0)
    (scan,) = simulator(street(person), Scenario(Straight(3.0), {"person_1": motion}), flash, frames=1)
    assert scan.speed == pytest.approx(3.0)


def test_the_ego_vehicle_stands_where_nobody_said_that_it_drives_and_it_would_collide() -> None:
    train = dataclasses.replace(car(11.8, 1.4, yaw=0.67, label="train"), size=(26.2, 2.6, 3.7))
    assert not tracks_of(street(train), Scenario(), 5.0).ego.moves()
    with pytest.raises(LidarDraftError, match="ego and train_1 collide"):
        tracks_of(street(train), Scenario(), 5.0, speed=5.0)


def test_who_follows_brakes_for_who_is_ahead() -> None:
    scenario = Scenario(AlongLane(12.0), {"car_1": AlongLane(10.0, later=((1.0, 0.0),))})
    tracks = tracks_of(street(car(25, 0)), scenario, 12.0)
    gap = tracks.actors["car_1"].places[:, 0] - tracks.ego.places[:, 0] - 4.2 / 2 - 4.5 / 2
    assert gap.min() > 0.9
    assert np.ptp(tracks.ego.places[-20:, 0]) < 0.05  # both stand
    assert tracks.ego.places[-1, 0] > 20


def test_the_ego_vehicle_lets_who_crosses_pass() -> None:
    person = Primitive(
        shape="box", center=(35, -4.5, 0.9), size=(0.6, 0.6, 1.8), yaw=1.57, label="person", id="person_1", instance=1
    )
    tracks = tracks_of(street(person), Scenario(AlongLane(9.0), {"person_1": Walk((35.0, 8.0), 1.4, 0.5)}), 14.0)
    crossing = np.abs(tracks.actors["person_1"].places[:, 1]) < 1.0
    assert (tracks.ego.places[crossing, 0] < 35 - 2.25).all()
    assert tracks.ego.places[-1, 0] > 37  # and goes on
    # two seconds before somebody is in the way, 25 m away, 81 / 50 m/s2 are enough; when he is, 8 m away, 5 m/s2
    braking = np.gradient(np.gradient(tracks.ego.places[:, 0], tracks.ego.times), tracks.ego.times)
    assert braking.min() > -3.0


@settings(max_examples=15, deadline=None)
@given(
    gaps=st.lists(st.floats(5.0, 40.0), min_size=1, max_size=6),
    speeds=st.lists(st.floats(0.0, 30.0), min_size=7, max_size=7),
    stop=st.floats(0.0, 6.0),
)
def test_no_queue_collides_or_drives_backwards(gaps: list[float], speeds: list[float], stop: float) -> None:
    cars, x = [], -70.0
    for number, gap in enumerate(gaps, start=1):
        x += gap if abs(x + gap) > 8 else gap + 16
        if x > 75:
            break
        cars.append(car(x, 0, number=number))
    motions = {p.id: AlongLane(speed, later=((stop, 0.0),)) for p, speed in zip(cars, speeds, strict=False)}
    tracks = tracks_of(street(*cars), Scenario(AlongLane(speeds[-1]), motions), 8.0)  # raises where two collide
    for track in [tracks.ego, *tracks.actors.values()]:
        steps = np.diff(track.places[:, 0])
        assert (steps >= -1e-9).all()
        assert np.diff(steps).min(initial=0.0) > -8.5 * 0.05**2


def test_kinds_move_as_they_do() -> None:
    layout = layout_from_text("two parked cars on the right, a bus ahead, people on the left sidewalk, trees", seed=3)
    tracks = tracks_of(layout, Scenario(), 6.0)
    moving = set(tracks.actors)
    assert "bus_1" in moving
    assert not any(name.startswith("tree") for name in moving)
    parked = [p.id for p in layout if p.label == "car"]
    assert len(parked) == 2
    assert not moving & set(parked)
    assert any(name.startswith("person") for name in moving)
    assert tracks.ego.places[-1, 0] > 20


def said_tracks(sentence: str, duration: float = 8.0, **more: float | None) -> tuple[Layout, Tracks]:
    """The tracks of what a sentence alone moves."""
    layout = layout_from_text(sentence, seed=0)
    return layout, tracks_of(layout, Scenario(), duration, **more)


def speeds(track: Track) -> np.ndarray:
    """[m/s] at each step."""
    return np.linalg.norm(np.diff(track.places[:, :2], axis=0), axis=1) / np.diff(track.times)


def test_what_a_sentence_says_of_speeds_is_driven() -> None:
    _, tracks = said_tracks("we drive at 30 km/h, a car 30 m ahead at 36 km/h, a bus behind us at 18 km/h", 2.0)
    assert speeds(tracks.ego)[0] == pytest.approx(30 / 3.6, abs=0.1)
    assert speeds(tracks.actors["car_1"])[0] == pytest.approx(10.0, abs=0.1)
    assert speeds(tracks.actors["bus_1"])[0] == pytest.approx(5.0, abs=0.1)


@pytest.mark.parametrize("sentence", ["a stopped bus ahead", "a parked bus on the right", "a bus ahead is waiting"])
def test_what_a_sentence_lets_stand_stands(sentence: str) -> None:
    assert "bus_1" not in said_tracks(sentence)[1].actors


@pytest.mark.parametrize("speed", [None, 5.0])
def test_a_sentence_stops_the_ego_vehicle_and_speed_overrules_it(speed: float | None) -> None:
    assert said_tracks("we stand behind a bus", speed=speed)[1].ego.moves() == (speed is not None)


def test_who_brakes_stops_and_who_accelerates_gets_faster() -> None:
    braking = speeds(said_tracks("the bus ahead brakes")[1].actors["bus_1"])
    assert braking[0] > 8.0
    assert braking[-1] == 0.0
    assert speeds(said_tracks("we brake")[1].ego)[-1] == 0.0
    faster = speeds(said_tracks("a car 15 m ahead accelerates", 5.0)[1].actors["car_1"])
    assert faster[-1] > faster[0] + 2.0


@pytest.mark.parametrize(
    ("sentence", "one", "other"),
    [
        ("a cyclist overtakes", "bicycle_1", "ego"),
        ("a motorway, we are overtaken by a truck", "truck_1", "ego"),
        ("we drive at 20 km/h, a car overtakes us", "car_1", "ego"),
        ("two lanes each way, a car overtakes a truck 10 m ahead", "car_1", "truck_1"),
    ],
)
def test_who_overtakes_is_faster_and_gets_ahead(sentence: str, one: str, other: str) -> None:
    _, tracks = said_tracks(sentence)
    fast, slow = ({"ego": tracks.ego, **tracks.actors}[name] for name in (one, other))
    assert speeds(fast)[0] > 1.3 * speeds(slow)[0]
    gained = fast.places[:, 0] - slow.places[:, 0]
    assert gained.max() > gained[0] + 3.0


def test_who_overtakes_on_a_road_of_one_lane_returns_to_it() -> None:
    scenario = Scenario(AlongLane(4.0), {"car_1": AlongLane(9.0, overtakes=True)})
    track = tracks_of(street(car(-20, 3.4)), scenario, 12.0).actors["car_1"]
    assert track.places[0, 1] == pytest.approx(3.4)
    assert abs(track.places[-1, 1]) < 1.0
    assert track.places[:, 3].min() < -0.05  # it looks where it goes


def test_people_who_cross_get_to_the_other_side_and_are_let_pass() -> None:
    layout, tracks = said_tracks("a pedestrian crosses the road 20 m ahead from left to right", 12.0)
    track = tracks.actors["person_1"]
    assert track.places[-1, 1] < -1.0 < 0.0 < track.places[0, 1]
    near = np.abs(track.places[:, 1]) < 1.0
    assert (tracks.ego.places[near, 0] < 20 - 2.25).all()
    assert layout.provenance["understood"]


@pytest.mark.parametrize("side", ["left", "right"])
def test_who_turns_leaves_the_road_by_that_side_slowly_and_ends_in_its_lane(side: str) -> None:
    layout, tracks = said_tracks(f"a car 25 m ahead turns {side} at the junction")
    track = tracks.actors["car_1"]
    way = 1 if side == "left" else -1
    assert way * track.places[-1, 1] > 20.0
    assert track.places[-1, 3] == pytest.approx(way * math.pi / 2, abs=0.1)
    assert speeds(track)[0] < 6.0
    _, label = Ground(layout).at(track.places)
    assert set(label.tolist()) == {BY_NAME["road"].id}


def test_the_ego_vehicle_can_turn_and_drives_to_the_junction_first() -> None:
    layout = layout_from_text("an empty crossroads", seed=0)
    tracks = tracks_of(layout, Scenario(AlongLane(10.0, turn="right")), 10.0)
    assert tracks.ego.places[-1, 1] < -15.0
    assert speeds(tracks.ego)[0] > 7.0 > 5.5 > speeds(tracks.ego).min()


def test_who_crosses_the_junction_need_not_give_way_where_the_sentence_has_it() -> None:
    _, tracks = said_tracks("a crossroads with a car crossing from the left")
    assert tracks.actors["car_1"].places[-1, 1] < -10.0 < 0.0 < tracks.actors["car_1"].places[0, 1]


def test_what_a_scenario_says_overrules_a_sentence() -> None:
    layout = layout_from_text("the bus ahead brakes", seed=0)
    tracks = tracks_of(layout, Scenario(None, {"bus_1": AlongLane(9.0)}), 4.0)
    assert speeds(tracks.actors["bus_1"])[0] == pytest.approx(9.0, abs=0.2)
    assert speeds(tracks.actors["bus_1"])[30] > 6.0


def test_the_scenario_of_the_page_is_driven_as_it_says() -> None:
    page = (Path(__file__).parents[2] / "docs" / "how-to" / "scenarios.md").read_text()
    (sentence,) = re.findall(r'--text "(.*?)"', page)
    (text,) = re.findall(r":caption: scenario.json\n(.*?)```", page, flags=re.DOTALL)
    layout = surround(layout_from_text(sentence, seed=0), seed=0)
    tracks = tracks_of(layout, Scenario.from_json(text), 8.0)
    assert {"bus_1", "person_1", "car_1"} == set(tracks.actors)


RIGHT = ((0.0, 10.0, 0.0), (2.0, 20.0, 0.0))


@pytest.mark.parametrize(
    ("scenario", "said"),
    [
        (Scenario(None, {"car_9": Straight(1.0)}), "no object 'car_9'; did you mean 'car_2'"),
        (Scenario(Straight(9.0), {"car_1": Straight(0.0)}), "ego and car_1 collide after"),
        (Scenario(None, {"car_1": Waypoints(((0, 12, 0), (3, 12, 30)))}), "car_1 leaves the road after"),
        (Scenario(Waypoints(((0, 0, 0), (3, -30, 20)))), "ego leaves the road after"),
        (Scenario(None, {"car_2": AlongLane()}), "car_2 stands in no lane"),
        (Scenario(Straight(60.0), {"car_1": Straight(60.0)}), "leaves the road after"),
    ],
)
def test_what_cannot_be_driven_is_one_line(scenario: Scenario, said: str) -> None:
    layout = street(car(12, 0), car(30, -9, number=2))
    with pytest.raises(LidarDraftError, match=said):
        tracks_of(layout, scenario, 10.0)


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"hz": 0}, "hz is 0; it must be a number over 0"),
        ({"hz": math.nan}, "hz is nan"),
        ({"hz": 20}, "hz is 20; a sweep of small takes 0.1 s: at most 10"),
        ({"hz": 0.01, "frames": 20}, "20 frames at 0.01 Hz are 2000 s; a sequence has 1000 s at most"),
        ({"frames": 0}, "frames is 0; it must be a whole number of 1 or more"),
        ({"speed": 3.0}, "the scenario says how the ego vehicle moves"),
    ],
)
def test_rates_that_cannot_be_are_one_line(more: dict[str, object], said: str) -> None:
    with pytest.raises(LidarDraftError, match=said):
        simulator(Layout((ROAD,)), Scenario(Straight(1.0)), **more)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[]", "is not a JSON object"),
        ('{"schema": "lidardraft.scenario/2"}', "schema is 'lidardraft.scenario/2'"),
        ('{"schema": "lidardraft.scenario/1", "cars": {}}', "unknown field 'cars'"),
        ('{"schema": "lidardraft.scenario/1", "ego": {"lane": {"turn": "back"}}}', "ego: turn is 'back'"),
        ('{"schema": "lidardraft.scenario/1", "ego": {"lane": {"overtakes": 1}}}', "ego: overtakes is 1"),
        (
            '{"schema": "lidardraft.scenario/1", "ego": {"fly": {}}}',
            "ego: a motion is straight, lane",
        ),
        ('{"schema": "lidardraft.scenario/1", "ego": {"straight": {}}}', "ego: 'speed' is missing"),
        ('{"schema": "lidardraft.scenario/1", "ego": {"straight": {"speed": "fast"}}}', "ego: speed is 'fast'"),
        (
            '{"schema": "lidardraft.scenario/1", "actors": {"car_1": {"waypoints": [[1, 0, 0], [0.5, 1, 0]]}}}',
            "car_1: waypoints: time 0.5 s follows 1 s; times must run forwards",
        ),
        ('{"schema": "lidardraft.scenario/1", "ego": {"waypoints": [[0, 1, 2], [1, 2]]}}', "all of one length"),
        ('{"schema": "lidardraft.scenario/1", "ego": {"lane": {"later": [[1, -2]]}}}', "later: speed is -2"),
        ('{"schema": "lidardraft.scenario/1", "ego": {"walk": {"to": [1, null]}}}', "ego: to is"),
    ],
)
def test_files_that_are_no_scenario_are_one_line(text: str, said: str) -> None:
    with pytest.raises(LidarDraftError, match=said):
        Scenario.from_json(text)


def test_a_scenario_is_read_as_it_was_written(tmp_path: Path) -> None:
    actors = {
        "bus_1": AlongLane(np.float32(8.0), later=((2.0, 0.0),), gap=3.0, turn="left", overtakes=True, gives_way=False),
        "person_*": Walk((14.0, 5.5), start=1.0),
        "car_3": Waypoints(((0.0, 10.0, 0.0), (2.0, 20.0, 1 / 3))),
        "*": Straight(0.0),
    }
    scenario = Scenario(AlongLane(), actors)
    scenario.save(tmp_path / "scenario.json")
    read = Scenario.load(tmp_path / "scenario.json")
    assert (read.ego, read.actors) == (scenario.ego, actors)
    assert read.of("person_2") == actors["person_*"]
    assert read.of("car_4") == Straight(0.0)
