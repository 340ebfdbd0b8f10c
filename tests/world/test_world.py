"""Worlds: a scan is a function of the state, what stands keeps its surface, and what moves is where it has been."""

import dataclasses
import itertools
import math
import random
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from lidardraft import Layout, Primitive, Scan, Sensor, SequenceSimulator, Simulator, layout_from_text, surround
from lidardraft.cli import main as cli
from lidardraft.errors import LayoutError
from lidardraft.scene.range_image import images_of
from lidardraft.scene.scenario import AlongLane, Scenario, Straight, Walk, Waypoints
from lidardraft.scene.sensor_model import SensorModel
from lidardraft.world.state import WorldState
from lidardraft.world.world import World

SMALL = Sensor(name="small", elevations=tuple(np.deg2rad(np.linspace(2, -24, 16)).tolist()), columns=256)
SENSORS = {
    "turn": SMALL,
    "sector": dataclasses.replace(SMALL, azimuth_start=0.9, azimuth_span=1.8, columns=100),
    "staggered": dataclasses.replace(SMALL, azimuth_offsets=(0.05, -0.05) * 8),
    "one beam": dataclasses.replace(SMALL, elevations=(-0.02,), columns=720),
    "a flash": dataclasses.replace(SMALL, sweep_time=0.0),
}
SENTENCE = "a busy crossroads with a bus, cyclists and pedestrians"
CROSSROADS = layout_from_text(SENTENCE, seed=7)
ROAD = Primitive(shape="plane", center=(0, 0, 0), size=(400, 60, 0), label="road", id="road")


def car(x: float, y: float, *, number: int = 1, yaw: float = 0.0) -> Primitive:
    return Primitive(
        shape="box", center=(x, y, 0.76), size=(4.2, 1.8, 1.5), yaw=yaw,
        label="car", id=f"car_{number}", instance=number,
    )  # fmt: skip


def same(one: Scan, two: Scan) -> bool:
    images = zip(images_of(one.image).items(), images_of(two.image).items(), strict=True)
    return (
        all(name == other and a.tobytes() == b.tobytes() for (name, a), (other, b) in images)
        and one.layout == two.layout
        and one.boxes() == two.boxes()
        and (one.pose == two.pose).all()
        and (one.time, one.seed, one.turn) == (two.time, two.seed, two.turn)
    )


def changed(world: World, chance: random.Random) -> None:
    """One random change, some of which a world refuses."""
    name, x, y = chance.choice([*world.ids, "ego"]), chance.uniform(-30, 30), chance.uniform(-4, 4)
    number, speed = chance.randrange(10**6), chance.choice([0.0, 2.0, 7.0, -1.0])
    match chance.randrange(12):
        case 0:
            world.add(chance.choice(["van", "cyclist", "person", "tree", "bus"]), at=(x, y), yaw=chance.uniform(-3, 3))
        case 1:
            world.add("car", at=(x, y), speed=speed)
        case 2:
            world.add(dataclasses.replace(car(x, y), id=f"mine_{number}.body"), yaw=chance.uniform(-3, 3))
        case 3:
            world.move(name, (x, y), yaw=chance.uniform(-3, 3), speed=speed)
        case 4:
            world.remove(chance.choice([name, "tree_*", "sidewalk*", "car_[12]"]))
        case 5:
            world[name].pose = (x, y, chance.uniform(-3, 3))
        case 6:
            world[name].speed = speed
        case 7:
            world[name].motion = Walk((x, y), 2.0)
        case 8:
            world[name].motion = Waypoints(((world.time, x, y), (world.time + 1.0, x + 4.0, y + 1.0)))
        case 9:
            world.follow(name, behind=chance.choice(["ego", *world.ids]), gap=3.0)
        case 10:
            world.ego.motion = AlongLane(speed=abs(speed))
        case _:
            world.ego.pose = (x, y, chance.uniform(-1, 1))


@pytest.mark.parametrize(
    ("sensor", "policy"),
    list(zip(SENSORS.values(), itertools.cycle(["allow", "stop", "refuse"]), strict=False)),
    ids=SENSORS,
)
def test_a_scan_is_that_of_a_fresh_world_in_the_same_state(sensor: Sensor, policy: str) -> None:
    chance = random.Random(f"{sensor.columns} {policy}")
    world = World(CROSSROADS, sensor, seed=7, collisions=policy)
    states, refused, scanned = [world.state()], 0, 0
    for _ in range(10):
        before = world.state()
        try:
            for _ in range(chance.randrange(3)):
                before = world.state()
                changed(world, chance)
            before = world.state()
            world.step(chance.choice([0.1, 0.05, 0.017, 0.23]))
        except LayoutError:
            assert world.state() is before
            refused += 1
        if chance.random() < 0.1:
            world.restore(chance.choice(states))
        states.append(world.state())
        if chance.random() < 0.5:
            scanned += 1
            fresh = World(WorldState.from_json(world.state().to_json()), sensor, collisions=policy)
            assert same(world.scan(), fresh.scan())
            assert world.boxes() == fresh.boxes()
            assert world.state().to_json() == fresh.state().to_json()
    assert refused < 10
    assert scanned
    world.restore(chance.choice(states))
    fresh = World(WorldState.from_json(world.state().to_json()), sensor)
    world = World(world.state(), sensor)
    for branch in (world, fresh):
        branch.step(0.3)
    assert same(fresh.scan(), world.scan())


def test_a_world_at_rest_is_what_simulate_scans() -> None:
    layout = surround(CROSSROADS, seed=7)
    world = World(layout, SMALL, seed=7)
    for name in (*world.ids, "ego"):
        world[name].motion = None
    world.step(0.3)
    world.move("ego", (0.0, 0.0), yaw=0.0)
    assert not any(actor.past for actor in world.state().actors.values())
    simulator = Simulator(layout, SMALL, seed=7)
    clean, truth = world.cast(), simulator._sweeper.cast(simulator._bodies, (), SMALL.pose(), 7)
    for image in ("depth", "label", "instance", "incidence"):
        assert getattr(clean, image).tobytes() == getattr(truth, image).tobytes()
    observed = simulator._sweeper.observe(truth, simulator._bodies.surfaces, SMALL.pose(), 8)
    assert world.scan().image.intensity.tobytes() == observed.intensity.tobytes()  # of the seed 7 + 1, after one step


def test_what_stands_keeps_its_surface_after_every_edit() -> None:
    world = World(CROSSROADS, SMALL, seed=7)
    for name in (*world.ids, "ego"):
        world[name].motion = None
    world.step(0.2)
    before = world.cast()
    by = {box.instance: box.id for box in world.boxes()}
    name = next(n for n in world.ids if any(by[k].split(".")[0] == n for k in set(before.instance.flat) - {0}))
    world.remove(name)
    van = world.add("van", at=(-15.0, 30.0))
    world.remove(van)
    after = world.cast()
    gone = np.isin(before.instance, [number for number, id in by.items() if id.split(".")[0] == name])
    assert gone.any()
    for image in ("depth", "label", "instance", "incidence"):
        one, two = getattr(before, image), getattr(after, image)
        assert (one[~gone] == two[~gone]).all()


def test_what_stands_reads_the_same_after_every_edit_and_from_every_pose() -> None:
    """But for the noise of the sensor, which is switched off."""
    quiet = dataclasses.replace(SMALL, model=dataclasses.replace(SensorModel.ideal(), texture=0.3))
    world = World(CROSSROADS, quiet, seed=7)
    for name in (*world.ids, "ego"):
        world[name].motion = None
    world.step(0.2)
    before = world.scan().image
    world.remove(world.ids[0])
    after = world.scan().image
    alike = (before.depth == after.depth) & before.valid
    assert alike.mean() > 0.3
    assert (before.intensity[alike] == after.intensity[alike]).all()


def test_a_thing_looks_the_same_in_every_place_and_comes_back() -> None:
    world = World(CROSSROADS, SMALL, seed=7)
    for name in (*world.ids, "ego"):
        world[name].motion = None
    world.step(0.2)
    first, name = world.scan(), world.ids[0]
    x, y, yaw = world[name].pose
    world.move(name, (x + 3.0, y), yaw=yaw + 0.4)
    assert world.scan().image.depth.tobytes() != first.image.depth.tobytes()
    world.move(name, (x, y), yaw=yaw)
    assert same(world.scan(), first)


def test_frames_are_those_of_a_sequence() -> None:
    """But for who would collide, who has to be told from the start there."""
    layout = layout_from_text(
        "a straight road, a car 20 m ahead, a truck 45 m ahead and a van coming the other way", seed=2
    )
    frames = SequenceSimulator(layout, SMALL, Scenario(AlongLane(6.0)), frames=4, hz=10.0, seed=2)
    world = World(layout, SMALL, seed=2)
    world.ego.motion, world.ego.speed = AlongLane(6.0), 6.0
    for number in range(4):
        world.step(0.1)
        scan, frame = world.scan(), frames.frame(number)
        assert scan.time == pytest.approx(frame.time)
        if number:  # of the first, the world knows how everything has moved before
            np.testing.assert_allclose(scan.pose, frame.pose, atol=2e-3)
            for one, two in zip(scan.boxes(), frame.boxes(), strict=True):
                np.testing.assert_allclose(one.center, two.center, atol=0.02)
                np.testing.assert_allclose(one.velocity, two.velocity, atol=0.05)
            close = np.abs(scan.image.depth - frame.image.depth) < 0.2
            assert close.mean() > 0.95


def test_each_column_sees_what_moves_where_it_has_been_then() -> None:
    sensor = dataclasses.replace(SMALL, columns=2048, range_sigma=0.0)
    lengths = []
    for speed in (-20.0, 0.0, 20.0):
        world = World(Layout((ROAD, car(-0.15 * speed, 8))), sensor)
        world.ego.motion = None
        world["car_1"].motion = Straight(speed)
        world.step(0.2)
        scan = world.scan()
        x = scan.points()[scan.instances() == 1, 0]
        lengths.append(float(np.ptp(x)))
        (box,) = scan.boxes()
        assert box.contains(scan.points()[scan.instances() == 1], 0.25 + abs(speed) * 0.05).all()
        assert box.velocity == pytest.approx((speed, 0, 0))
        (now,) = world.boxes()
        assert now.center[0] == pytest.approx(0.05 * speed)
        assert box.center[0] == pytest.approx(now.center[0] - 0.05 * speed)
    swept = 2 * math.atan(2.1 / 7.1) / math.tau * 0.1  # s, as the head turns clockwise
    assert lengths[2] - lengths[0] == pytest.approx(40.0 * swept, abs=0.1)


def test_poses_are_gone_to_evenly_and_ego_and_actor_have_their_motion() -> None:
    world = World(Layout((ROAD, car(12, 4))), SMALL)
    for k in range(1, 4):
        world.ego.pose, world["car_1"].pose = (0.5 * k, 0.1 * k, 0.02 * k), (12.0 - k, 4.0, 0.0)
        world.step(0.1)
    assert world.ego.pose == pytest.approx((1.5, 0.3, 0.06))
    assert world["car_1"].velocity == pytest.approx((-10, 0, 0))
    scan = world.scan()
    assert scan.speed == pytest.approx(math.hypot(5, 1))
    assert scan.turn == pytest.approx(0.2)
    assert scan.pose[:2, 3] == pytest.approx((1.25, 0.25))
    world.step(0.1)
    assert world["car_1"].pose == pytest.approx((9, 4, 0))
    assert world["car_1"].velocity == (0, 0, 0)
    assert world.scan().speed == 0.0


def test_move_places_at_once_and_an_added_thing_moves_as_it_is_told() -> None:
    world = World(Layout((ROAD, car(12, 4))), SMALL)
    world.move("car_1", (20.0, 8.0), yaw=1.0)
    world.step(0.1)
    assert world["car_1"].pose == pytest.approx((20, 8, 1))
    assert world["car_1"].velocity == (0, 0, 0)
    van = world.add("van", at=(30.0, 20.0), yaw=math.pi, speed=6.0)
    assert van == "van_1"
    scan = world.scan()
    assert [box.velocity for box in scan.boxes() if box.id == van] == [pytest.approx((-6, 0, 0))]
    world.step(0.5)
    assert world[van].pose[0] == pytest.approx(27)
    tree = world.add("tree", at=(5.0, 12.0))
    assert {part.id for part in world.layout() if part.id.startswith(tree)} == {f"{tree}.trunk", f"{tree}.crown"}
    assert min(part.center[2] - part.size[2] / 2 for part in world.layout() if part.id.startswith(tree)) == 0.0


def test_people_step_on_kerbs_and_their_velocities_stay_level() -> None:
    curb = Primitive(shape="box", center=(0, 6, 0.06), size=(40, 4, 0.12), label="sidewalk", id="sidewalk")
    person = Primitive(
        shape="box", center=(8, 3.5, 0.9), size=(0.6, 0.6, 1.8), label="person", id="person_1", instance=1
    )
    world = World(Layout((ROAD, curb, person)), SMALL, relief=False)
    world["person_1"].motion = Walk((8.0, 6.0), 1.4)
    rates = []
    for _ in range(20):
        world.step(0.05)
        rates.append(world["person_1"].velocity[2])
        for box in (*world.boxes(), *world.scan().boxes()):
            assert box.velocity is not None
            assert box.velocity[2] == 0.0
    assert max(rates) > 1.0
    assert world.boxes()[0].center[2] == pytest.approx(0.9 + 0.12, abs=1e-3)


@pytest.mark.parametrize("motion", [Walk((8.0, 300.0)), Waypoints(((0.0, 12.0, 4.0), (60.0, 12.0, 300.0)))])
def test_a_motion_that_leaves_the_map_is_reported(motion: Walk | Waypoints) -> None:
    world = World(Layout((ROAD, car(12, 4))), SMALL)
    with pytest.warns(UserWarning, match=r"car_1 goes off the map, to x .*, y 300\.0 m; without ground it keeps"):
        world["car_1"].motion = motion
    for _ in range(4):
        world.step(60.0)
    assert world["car_1"].pose[1] == pytest.approx(300.0)


def test_a_stopped_car_holds_up_those_behind_it() -> None:
    layout = layout_from_text("a straight road, a car 20 m ahead", seed=0)
    world = World(layout, SMALL, seed=0)
    world["car_1"].speed = 0.0
    for _ in range(100):
        world.step(0.1)
    gap = world["car_1"].pose[0] - 2.1 - world.ego.pose[0] - 2.25
    assert 0.5 < gap < 4.0
    assert world.ego.speed < 0.1
    assert not world.collisions


def test_speeds_are_what_they_are_set_to() -> None:
    world = World(Layout((ROAD, car(12, 4))), SMALL)
    world["car_1"].speed = 3.0
    assert world["car_1"].speed == 3.0
    person = world.add("person", at=(10.0, 0.0), yaw=0.2)
    world[person].motion = Walk((15.0, 5.0), 1.0)
    world[person].speed = 2.0
    assert world[person].speed == 2.0
    world.step(0.5)
    assert math.dist(world[person].pose[:2], (10.0, 0.0)) == pytest.approx(1.0)
    assert world["car_1"].velocity == pytest.approx((3, 0, 0))
    layout = layout_from_text("a straight road", seed=0)
    world = World(layout, SMALL, seed=0)
    person = world.add("person", at=(15.0, 0.3), speed=1.5)  # who is no vehicle does not drive
    assert world[person].motion == Straight(1.5)
    van = world.add("van", at=(25.0, 0.3), speed=1.5)
    assert world[van].motion == AlongLane(1.5)


def test_following() -> None:
    layout = layout_from_text("an empty straight road with two lanes each way", seed=0)
    world = World(layout, SMALL, seed=0)
    roads = layout.roads
    assert roads is not None
    lane, _, _ = roads.nearest_lane(0.0, 0.0, yaw=0.0)
    van = world.add("van", at=(20.0, 0.5), speed=5.0)
    world.follow(van, lane=lane.id, gap=3.0)
    car = world.add("car", at=(8.0, 0.0))
    world.follow(car, behind=van, gap=4.0)
    for _ in range(150):
        world.step(0.1)
    assert world[van].pose[1] == pytest.approx(world.ego.pose[1], abs=0.15)  # in the middle of its lane
    assert world[van].pose[0] > world[car].pose[0] > world.ego.pose[0]
    assert not world.collisions


def test_collisions() -> None:
    layout = Layout((ROAD, car(20, 0), car(40, 0.3, number=2)))
    for policy in ("allow", "stop"):
        world = World(layout, SMALL, collisions=policy)
        world.ego.motion, world["car_2"].motion = None, None
        world["car_1"].motion = Straight(10.0)
        world.step(3.0)
        assert [(event.one, event.other) for event in world.collisions] == [("car_1", "car_2")]
        assert world.collisions[0].time == pytest.approx(1.6, abs=0.06)
        x = world["car_1"].pose[0]
        assert x == pytest.approx(50.0) if policy == "allow" else 35.0 < x <= 35.82
        assert world["car_2"].velocity == (0, 0, 0)
    world = World(layout, SMALL, collisions="refuse")
    world["car_1"].motion = Straight(10.0)
    now = world.state()
    with pytest.raises(ValueError, match=r"car_1 runs into car_2 at 1.\d+ s; nothing was changed"):
        world.step(3.0)
    assert world.state() is now
    with pytest.raises(ValueError, match=r"car_2 runs into car_1 at 0\.00 s"):
        world.move("car_2", (21.0, 0.0))
    assert world.state() is now
    with pytest.raises(ValueError, match="van_1 runs into"):
        world.add("van", at=(20.0, 0.0))
    assert world.state() is now
    assert "van_1" not in world
    dragged = World(layout, SMALL)
    for x in (37.0, 38.0, 39.0, 30.0, 38.0):
        dragged.move("car_1", (x, 0.0))
    assert [event.one for event in dragged.collisions] == ["car_1"] * 2  # once each time that they meet
    replayed = World(layout, SMALL)
    replayed["car_1"].motion = Waypoints(((0.0, 20.0, 0.0), (2.0, 30.0, 0.0), (4.0, 40.0, 0.0)))
    for _ in range(50):
        replayed.step(0.1)
    assert replayed["car_1"].pose == pytest.approx((40, 0, 0), abs=1e-6)
    assert replayed["car_1"].motion is None


def test_a_state_is_kept_in_a_file(tmp_path: Path) -> None:
    world = World(surround(CROSSROADS, seed=7), SMALL, seed=7)
    world.add("van", at=(22.0, -3.5), yaw=3.14, speed=6.0)
    world.step(0.3)
    world.ego.pose = (4.0, 0.0, 0.0)
    world.state().save(tmp_path / "a.world.json")
    again = World(WorldState.load(tmp_path / "a.world.json"), SMALL)
    for one in (world, again):
        one.step(0.25)
    assert same(world.scan(), again.scan())
    assert world.state().to_json() == again.state().to_json()


def test_points_boxes_and_ids() -> None:
    world = World(CROSSROADS, SMALL, seed=7)
    world.step(0.1)
    scan = world.scan()
    assert world.points().tobytes() == scan.points().tobytes()
    assert world.scan() is scan
    ids = [box.id.split(".")[0] for box in world.boxes()]
    assert set(ids) <= set(world.ids)
    assert len(ids) == len(scan.boxes())
    for one, two in itertools.pairwise(sorted(box.instance for box in world.boxes())):
        assert one < two


def test_the_page_of_docs_is_true(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its code runs, and ends as it says."""
    page = (Path(__file__).parents[2] / "docs" / "how-to" / "world.md").read_text()
    first, states = (block.split("```")[0] for block in page.split("```python\n")[1:])
    (command,) = re.findall(r"```sh\n(.*)\n```", page)
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    exec(first, names)
    world, scan = names["world"], names["scan"]
    assert world.time == pytest.approx(2.0)
    assert world.ego.pose[0] > 15.0
    assert world["person_3"].pose == pytest.approx((9.0, 2.0, world["person_3"].pose[2]))
    assert not [id for id in world.ids if id.startswith("around/tree_")]
    assert scan.time == pytest.approx(1.95)
    assert scan.speed == pytest.approx(8.0, rel=1e-3)  # on a slope
    assert len(names["boxes"]) == len(scan.boxes())
    exec(states, names)
    assert list(names["again"].rig.mounts) == ["os1-128"]
    assert world.state().time == pytest.approx(3.0)
    assert cli.main(command.split()[1:]) == 0


def test_a_state_of_another_world_brings_its_seed_and_its_weather() -> None:
    rain = layout_from_text("a car 15 m ahead on a rainy night", seed=1)
    assert rain.intent.weather is not None
    worlds = [World(CROSSROADS, SMALL, seed=7), World(CROSSROADS, SMALL, seed=8), World(rain, SMALL, seed=1)]
    for world in worlds:
        world.step(0.2)
    truths = [(world.state(), world.scan()) for world in worlds]
    assert truths[0][1].image.depth.tobytes() != truths[1][1].image.depth.tobytes()
    for world in worlds:
        for state, scan in truths:
            world.restore(state)
            assert same(world.scan(), scan)
