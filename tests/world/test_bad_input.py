"""What a world refuses: one line each, and it is as it was before the call."""

import dataclasses
import json
import math
import threading
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from lidardraft import Layout, Primitive, Sensor, layout_from_text
from lidardraft.errors import LidarDraftError
from lidardraft.scene.scenario import AlongLane, Straight, Waypoints
from lidardraft.world.state import WorldState
from lidardraft.world.world import World

FEW = Sensor(name="few", elevations=(0.02, -0.1, -0.2), columns=64)
LAYOUT = layout_from_text("a straight road, a car 20 m ahead, a van on the left and two trees", seed=3)
BOX = Primitive(shape="box", center=(9, 30, 1), size=(4, 2, 2), label="car", id="box")


@pytest.fixture(scope="module")
def world() -> World:
    return World(LAYOUT, FEW, seed=3)


def posed(world: World, id: str, pose: object) -> None:
    world[id].pose = pose  # type: ignore[assignment]


def sped(world: World, id: str, speed: object) -> None:
    world[id].speed = speed  # type: ignore[assignment]


def told(world: World, id: str, motion: object) -> None:
    world[id].motion = motion  # type: ignore[assignment]


EITHER = "car_1 follows a lane or somebody; give one of lane and behind"
CASES: dict[str, tuple[Callable[[World], object], str]] = {
    "an unknown id": (lambda w: w["car_2x"], "the world has no object 'car_2x'; did you mean 'car_1'?"),
    "an id of another type": (lambda w: w[3], "the world has no object 3"),  # type: ignore[index]
    "move of an unknown": (lambda w: w.move("cra_1", (1, 2)), "the world has no object 'cra_1'; did you mean 'car_1'?"),
    "remove of nothing": (lambda w: w.remove("tres_*"), "the world has no object 'tres_*'"),
    "remove of the ego": (lambda w: w.remove("ego"), "the ego vehicle cannot be removed"),
    "a step of 0": (lambda w: w.step(0), "seconds is 0; it must be a number over 0, and 60 at most"),
    "a step of NaN": (lambda w: w.step(math.nan), "seconds is nan; it must be a number over 0, and 60 at most"),
    "a step back": (lambda w: w.step(-0.1), "seconds is -0.1; it must be a number over 0, and 60 at most"),
    "a step of a text": (
        lambda w: w.step("1"),  # type: ignore[arg-type]
        "seconds is '1'; it must be a number over 0, and 60 at most",
    ),
    "off the map": (
        lambda w: w.move("car_1", (1e5, 0)),
        "car_1: x 100000.0, y 0.0 m is off the map; there is no ground",
    ),
    "added off the map": (
        lambda w: w.add("van", at=(0, 1e5)),
        "van_2: x 0.0, y 100000.0 m is off the map; there is no ground",
    ),
    "a pose off the map": (
        lambda w: posed(w, "ego", (1e5, 0, 0)),
        "ego: x 100000.0, y 0.0 m is off the map; there is no ground",
    ),
    "a pose of two": (lambda w: posed(w, "ego", (1, 2)), "ego: pose is (1, 2); it must be 3 finite numbers"),
    "a pose of NaN": (
        lambda w: posed(w, "car_1", (1, math.nan, 0)),
        "car_1: pose is (1, nan, 0); it must be 3 finite numbers",
    ),
    "a place of NaN": (lambda w: w.move("car_1", (math.nan, 0)), "to is (nan, 0); it must be 2 finite numbers"),
    "a yaw of NaN": (lambda w: w.move("car_1", (1, 0), yaw=math.nan), "yaw is (nan,); it must be a finite number"),
    "a speed of NaN": (lambda w: sped(w, "car_1", math.nan), "car_1: speed is nan; it must be -150 to 150 m/s"),
    "a speed of light": (lambda w: sped(w, "car_1", 3e8), "car_1: speed is 300000000.0; it must be -150 to 150 m/s"),
    "a motion of none": (lambda w: told(w, "car_1", "fast"), "motion is a str; it must be a "),
    "a lane of none": (
        lambda w: told(w, "tree_1", AlongLane(3.0)),
        "tree_1 stands in no lane that it could drive along",
    ),
    "ground": (lambda w: w.move("road", (1, 2)), "road is ground, which others stand on; it cannot be moved"),
    "a kind": (lambda w: w.add("vann"), "'vann' is no object that can be inserted; it must be one of "),
    "a taken id": (lambda w: w.add("van", at=(9, 9), id="car_1"), "id is 'car_1', which another object has; give `id`"),
    "the ego's id": (lambda w: w.add("van", at=(9, 9), id="ego"), "id is 'ego', which another object has; give `id`"),
    "nothing": (lambda w: w.add([]), "what is added holds 0 objects; add one"),
    "two": (lambda w: w.add(LAYOUT), "terrain: label is 'terrain'; it must be that of an object, not of the ground"),
    "no shapes": (lambda w: w.add([1]), "a shape is a int; it must be a Primitive"),  # type: ignore[list-item]
    "follow both": (lambda w: w.follow("car_1", lane="a", behind="ego"), EITHER),
    "follow none": (lambda w: w.follow("car_1"), EITHER),
    "follow a tree": (
        lambda w: w.follow("car_1", behind="tree_1"),
        "behind is 'tree_1'; it must be another object that stands in a lane",
    ),
    "follow from beside": (
        lambda w: w.follow("tree_1", behind="ego"),
        "tree_1 does not stand in the lane of ego behind ego and look",
    ),
    "an unknown lane": (lambda w: w.follow("car_1", lane="lane_99"), "no lane has the id 'lane_99'"),
    "a gap below 0": (lambda w: w.follow("car_1", behind="ego", gap=-1.0), "gap is -1.0; it must be 0 to 100000 m"),
    "another's state": (lambda w: w.restore(3), "state is a int; it must be a WorldState"),  # type: ignore[arg-type]
}


@pytest.mark.parametrize("case", CASES)
def test_bad_input_is_one_line_and_changes_nothing(world: World, case: str) -> None:
    call, line = CASES[case]
    before, ids = world.state(), world.ids
    with pytest.raises((LidarDraftError, TypeError)) as error:
        call(world)
    assert line in str(error.value)
    assert "\n" not in str(error.value)
    assert world.state() is before
    assert world.ids == ids


def test_what_failed_leaves_no_name_behind(world: World) -> None:
    world.restore(world.state())
    with pytest.raises(LidarDraftError):
        world.add("bus", at=(1e6, 0.0))
    before = world.state()
    assert world.add("bus", at=(30.0, 20.0)) == "bus_1"
    world.restore(before)


def test_arguments_of_a_world() -> None:
    with pytest.raises(LidarDraftError, match="collisions is 'ignore'; it must be one of allow, refuse, stop"):
        World(LAYOUT, FEW, collisions="ignore")
    with pytest.raises(TypeError, match="sensor is a str; it must be a Sensor"):
        World(LAYOUT, "vlp16")  # type: ignore[arg-type]
    with pytest.raises(LidarDraftError, match="an object of the layout is called 'ego'"):
        World(Layout((*LAYOUT, dataclasses.replace(BOX, id="ego.body"))), FEW)
    state = World(LAYOUT, FEW, seed=3).state()
    with pytest.raises(LidarDraftError, match="seed is 4; it must be 3, that of the state"):
        World(state, FEW, seed=4)
    many = tuple(dataclasses.replace(BOX, id=f"box_{k}", center=(k, 30, 1)) for k in range(10_000))
    with pytest.raises(LidarDraftError, match="10001 objects; a world has 5000 at most"):
        World(Layout((LAYOUT["road"], *many)), FEW)


def test_one_thread_at_a_time() -> None:
    world = World(LAYOUT, FEW, seed=3)
    thread = threading.Thread(target=world.step, args=(20.0,))
    thread.start()
    while not world._lock.locked():
        pass
    with pytest.raises(LidarDraftError, match="another thread uses this world; give each one of its own"):
        world.move("car_1", (20.0, 0.0))
    thread.join()
    assert world.time == 20.0


BROKEN: dict[str, tuple[Callable[[dict[str, object]], object], str]] = {
    "schema": (lambda d: d.update(schema="lidardraft.layout/2"), "schema"),
    "no things": (lambda d: d.pop("things"), "things"),
    "no ego": (lambda d: d["things"].pop("ego"), "things has no 'ego'"),  # type: ignore[attr-defined]
    "a spot": (lambda d: d["things"]["car_1"].update(spot=[1, 2]), "spot"),  # type: ignore[index]
    "a layout that is gone": (
        lambda d: d["things"]["car_1"].update(batch=7),  # type: ignore[index]
        "the state has 'car_1' of its layout 7",
    ),
    "a way": (
        lambda d: d["things"]["car_1"]["drive"].update(way=99),  # type: ignore[index]
        "the state has 'car_1' on no lane",
    ),
    "a motion": (
        lambda d: d["scenario"]["actors"].pop("car_1"),  # type: ignore[index]
        "the state has 'car_1' on no lane",
    ),
    "a time": (lambda d: d.update(time=None), "time is None"),
}  # fmt: skip


@pytest.mark.parametrize("case", BROKEN)
def test_broken_states(case: str, tmp_path: Path) -> None:
    change, line = BROKEN[case]
    world = World(LAYOUT, FEW, seed=3)
    document = json.loads(world.state().to_json())
    change(document)
    (tmp_path / "a.json").write_text(json.dumps(document))
    before = world.state()
    with pytest.raises(LidarDraftError) as error:
        world.restore(WorldState.load(tmp_path / "a.json"))
    assert line in str(error.value)
    assert world.state() is before
    world.step(0.1)


def test_numbers_of_numpy_and_shapes_of_a_model() -> None:
    world = World(LAYOUT, FEW, seed=3)
    world.step(np.float32(0.1))
    world["car_1"].pose = np.array([21.0, 0.0, 0.0])  # type: ignore[assignment]
    world.step(np.float64(0.1))
    assert world["car_1"].pose == pytest.approx((21, 0, 0))
    body, roof = BOX, dataclasses.replace(BOX, id="roof", center=(9, 30, 2.2), size=(2, 1.8, 0.4))
    id = world.add([body, roof], at=(12.0, 25.0), id="model", yaw=0.5, speed=np.float64(2.0))
    assert world[id].pose == pytest.approx((12, 25, 0.5))
    parts = [part for part in world.layout() if part.id.startswith("model")]
    assert [part.id for part in parts] == ["model", "model.1"]
    assert parts[0].center[2] == pytest.approx(1.0, abs=0.2)
    assert len({part.instance for part in parts}) == 1
    world[id].motion = Straight(0.0)
    assert world[id].motion is None


def test_misspelt_commands_and_way_points_elsewhere_are_refused() -> None:
    world = World(LAYOUT, FEW, seed=3)
    name = next(iter(world.ids))
    with pytest.raises(AttributeError):
        world.ego.posee = (1.0, 0.0, 0.0)  # type: ignore[attr-defined]
    x, y, _ = world[name].pose
    with pytest.raises(LidarDraftError, match=r"its way-points are 9\.0 m away at 0\.00 s; move it first"):
        world[name].motion = Waypoints(((0.0, x, y + 9.0), (1.0, x, y + 9.0)))


def test_who_follows_is_behind() -> None:
    world = World(layout_from_text("a car 20 m ahead, a bus 40 m ahead", seed=3), FEW, seed=3)
    world["bus_1"].motion = None
    world.follow("car_1", behind="bus_1")
    for _ in range(200):
        world.step(0.1)
    assert world["bus_1"].pose[0] - world["car_1"].pose[0] > (world["bus_1"].size[0] + world["car_1"].size[0]) / 2
    with pytest.raises(LidarDraftError, match="bus_1 does not stand in the lane of car_1 behind car_1"):
        world.follow("bus_1", behind="car_1")
    with pytest.raises(LidarDraftError, match="behind is 'car_1'; it must be another object that stands in a lane"):
        world.follow("car_1", behind="car_1")
