"""Traffic keeps rules: lights, signs, turns, people who cross, buses at their stops, cyclists."""

import itertools
import math

import numpy as np
import pytest

from lidardraft import Layout, Primitive, Sensor, layout_from_text, surround
from lidardraft.scene.road import LEFT, Road
from lidardraft.scene.road_network import RoadNetwork
from lidardraft.scene.road_surfaces import road_surfaces
from lidardraft.scene.scenario import AlongLane, Motion, Scenario, Straight, Track, Walk
from lidardraft.scene.street import StreetFrame
from lidardraft.simulation.motion.driving import STEP
from lidardraft.simulation.motion.right_of_way import RightOfWay
from lidardraft.simulation.motion.tracks import tracks_of
from lidardraft.world.state import WorldState
from lidardraft.world.world import World

SMALL = Sensor(name="small", elevations=(0.0, -0.1), columns=64)
STANDS = Scenario(Straight(0.0))
SIZES = {
    "car": (4.2, 1.8, 1.5),
    "bus": (12.0, 2.5, 3.0),
    "bicycle": (1.8, 0.6, 1.7),
    "rider": (0.5, 0.5, 1.8),
    "person": (0.5, 0.5, 1.8),
}


def thing(label: str, x: float, y: float, yaw: float = 0.0, name: str = "", number: int = 1) -> Primitive:
    size = SIZES.get(label, (3.0, 1.5, 2.4))
    return Primitive(
        shape="box", center=(x, y, size[2] / 2 + 0.01), size=size, yaw=yaw,
        label=label, id=name or f"{label}_{number}", instance=number,
    )  # fmt: skip


def layout_of(road: Road, *things: Primitive, **more: bool | tuple[float, ...]) -> Layout:
    """A street with things in it; the ego vehicle in the right lane at x = 0."""
    roads = RoadNetwork(street=StreetFrame(road=road, speed=10.0, **more))  # type: ignore[arg-type]
    return Layout((*road_surfaces(road), *things), roads=roads)


def rules_of(layout: Layout) -> RightOfWay:
    assert layout.roads is not None
    return RightOfWay(layout.roads, layout.roads.ways())


def passed(track: Track, x: float) -> float:
    """When something that drives ahead is at x [s]."""
    return float(np.interp(x, track.places[:, 0], track.times))


def standing(track: Track) -> np.ndarray:
    speeds: np.ndarray = np.hypot(*np.gradient(track.places[:, :2], track.times, axis=0).T)
    return speeds < 0.1


def moved(layout: Layout, duration: float, **actors: Motion) -> dict[str, Track]:
    return dict(tracks_of(layout, Scenario(Straight(0.0), actors), duration).actors)


def test_lights_are_green_for_one_road_at_a_time_and_red_for_all_between() -> None:
    rules = rules_of(layout_of(Road(junction=40.0), lights=True))
    seen = [(rules.is_green(0, time), rules.is_green(1, time)) for time in np.arange(0.0, 120.0, 0.25).tolist()]
    assert set(seen) == {(True, False), (False, True), (False, False)}
    assert all(one == (False, False) or two in (one, (False, False)) for one, two in itertools.pairwise(seen))
    phases = {(round(math.sin(one.heading)), one.phase) for one in rules.passages}
    assert phases == {(0, 0), (1, 1), (-1, 1)}


@pytest.mark.parametrize("start", [8.0, 35.0, 60.0])
def test_cars_go_on_green_and_wait_at_the_line_on_red(start: float) -> None:
    layout = layout_of(Road(junction=100.0, half_length=190.0), thing("car", start, 0.0), lights=True)
    rules, track = rules_of(layout), moved(layout, 50.0)["car_1"]
    line = next(one.line for one in rules.passages if one.phase == 0 and not one.turn) - 190.0
    over = passed(track, line - 2.1)
    assert rules.is_green(0, over) or rules.is_green(0, over - 3.0)
    waits = standing(track)
    assert waits.any() or rules.is_green(0, over)
    assert (track.places[waits, 0] < line - 2.1).all()
    assert track.places[-1, 0] > 100.0


def test_a_side_road_waits_for_a_gap_and_then_goes() -> None:
    road = Road(junction=80.0, half_length=120.0)
    main = [thing("car", x, 0.0, number=number) for number, x in enumerate((60.0, 42.0, 24.0), start=2)]
    side = thing("car", 78.25, 14.0, -math.pi / 2, number=1)
    tracks = moved(layout_of(road, side, *main), 25.0, car_1=AlongLane(8.0))
    waited = standing(tracks["car_1"])
    assert waited.any()
    assert 11.0 < tracks["car_1"].places[waited, 1].min() < 14.0
    last = max(passed(tracks[f"car_{number}"], 80.0) for number in (2, 3, 4))
    crossed = tracks["car_1"].times[int(np.argmax(tracks["car_1"].places[:, 1] < 0.0))]
    assert last < crossed < last + 8.0


def test_who_turns_left_yields_to_who_comes() -> None:
    road = Road(junction=40.0, half_length=120.0)
    comes = thing("car", 78.0, 3.5, math.pi, number=2)
    tracks = moved(layout_of(road, thing("car", 5.0, 0.0), comes), 20.0, car_1=AlongLane(9.0, turn="left"))
    turned = tracks["car_1"].times[int(np.argmax(tracks["car_1"].places[:, 1] > 2.0))]
    gone = tracks["car_2"].times[int(np.argmax(tracks["car_2"].places[:, 0] < 40.0))]
    assert gone < turned
    assert tracks["car_1"].places[-1, 1] > 20.0


def test_nobody_waits_for_ever_where_all_have_to_give_way() -> None:
    road = Road(junction=40.0, half_length=190.0)
    crowd = [thing("car", 41.75, -14.0 - 7 * k, math.pi / 2, number=1 + k) for k in range(3)]
    crowd += [thing("car", 38.25, 17.0 + 7 * k, -math.pi / 2, number=4 + k) for k in range(3)]
    flow = [thing("car", 60.0 + 15 * k, 3.5, math.pi, number=7 + k) for k in range(8)]
    tracks = moved(layout_of(road, *crowd, *flow), 45.0)
    for number in range(1, 15):
        assert math.dist(tracks[f"car_{number}"].places[-1, :2], (40.0, 1.75)) > 15.0


def test_a_side_road_of_a_t_junction_turns_and_a_roundabout_is_driven_through() -> None:
    road = Road(junction=40.0, half_length=120.0, side_roads=(LEFT,))
    track = moved(layout_of(road, thing("car", 38.25, 20.0, -math.pi / 2)), 20.0)["car_1"]
    assert abs(track.places[-1, 0] - 40.0) > 20.0
    assert track.places[:, 1].min() > -1.0
    around = Road(junction=50.0, roundabout_radius=16.0, half_length=120.0)
    track = moved(layout_of(around, thing("car", 5.0, 0.0)), 25.0, car_1=AlongLane(9.0))["car_1"]
    assert track.places[-1, 0] > 75.0
    assert np.hypot(*(track.places[:, :2] - (50.0, 1.75)).T).min() > 8.0


def test_people_wait_for_a_car_and_cross_at_a_zebra_and_a_car_yields() -> None:
    road = Road(sidewalk=3.0, half_length=120.0)
    person = thing("person", 40.0, -3.5, math.pi / 2)
    corner, comes = Road(sidewalk=3.0, half_length=120.0, junction=44.8), thing("car", 10.0, 0.0)
    near = moved(layout_of(corner, person, comes), 20.0, car_1=AlongLane(9.0))
    entered = passed(Track(near["person_1"].times, near["person_1"].places[:, [1, 0, 2, 3]]), -1.0)
    assert passed(near["car_1"], 42.0) < entered
    assert near["person_1"].places[-1, 1] > 5.0
    far = moved(layout_of(road, person, thing("car", 2.0, 0.0), zebras=(40.0,)), 20.0)
    entered = passed(Track(far["person_1"].times, far["person_1"].places[:, [1, 0, 2, 3]]), -1.75)
    assert passed(far["car_1"], 37.9) > entered
    nowhere = moved(layout_of(road, person), 20.0)
    assert "person_1" not in nowhere or nowhere["person_1"].places[:, 1].max() < -1.75


def test_who_crosses_a_road_waits_for_those_who_have_green() -> None:
    road = Road(sidewalk=3.0, half_length=120.0, junction=60.0)
    person, car = thing("person", 52.0, -3.5, math.pi / 2), thing("car", 25.0, 0.0)
    layout = layout_of(road, person, car, lights=True, zebras=(52.0,))
    rules, tracks = rules_of(layout), moved(layout, 40.0)
    track = tracks["person_1"]
    enters = float(track.times[int(np.argmax(track.places[:, 1] > -1.5))])
    assert track.places[-1, 1] > 3.0
    assert not rules.is_green(0, enters) or enters > passed(tracks["car_1"], 54.0)


def test_people_on_the_road_go_around_a_vehicle_that_stands() -> None:
    road = Road(sidewalk=3.0, half_length=120.0)
    people = [thing("person", 20.0 + k, 4.5, -math.pi / 2, number=1 + k) for k in range(3)]
    walks = {f"person_{1 + k}": Walk((20.0 + k, -4.0), crosses=((1e4, 0.0),)) for k in range(3)}
    layout = layout_of(road, thing("bus", 20.0, 0.0), *people)
    tracks = moved(layout, 20.0, bus_1=AlongLane(8.0, start=12.0), **walks)
    for name in walks:
        assert tracks[name].places[-1, 1] < -2.5
        there = tracks[name].places[tracks[name].times < 12.0]
        assert (np.abs(there[:, :2] - (20.0, 0.0)) > (6.0, 1.25)).any(axis=1).all()
    assert tracks["bus_1"].at(np.array([11.9]))[0, 0] == pytest.approx(20.0)


def test_who_meets_a_roundabout_gives_way_where_it_enters() -> None:
    rules = rules_of(layout_of(Road(junction=50.0, roundabout_radius=16.0, half_length=120.0), parked=()))
    pairs = [(one.way, rules.passages[zone.other].way, zone) for one in rules.passages for zone in one.zones]
    merging = [row for row in pairs if max(b - a for a, b in (row[2].own, row[2].theirs)) < 6.01]
    assert merging
    for one, other, zone in merging:
        assert math.dist(one.line.at(zone.own[0]), other.line.at(zone.theirs[0])) < 3.0


def test_a_car_parked_beside_a_lane_does_not_turn_at_the_junction() -> None:
    road = Road(sidewalk=3.0, half_length=120.0, junction=60.0, lane_width=5.0)
    turns = thing("car", 30.0, -1.3, name="coupe_2")  # would, by its name, turn right
    assert not moved(layout_of(road, turns, parked=(LEFT, -LEFT)), 1.0)


@pytest.mark.parametrize("seed", [2, pytest.param(5, marks=pytest.mark.slow)])
def test_the_ego_vehicle_passes_a_crossroads_that_is_crowded_at_the_start(seed: int) -> None:
    sentence = "a busy downtown crossroads with pedestrians crossing"
    layout = surround(layout_from_text(sentence, seed=seed), seed=seed)
    ego = tracks_of(layout, Scenario(), 20.0).ego
    assert float(np.hypot(*np.diff(ego.places[:, :2], axis=0).T).sum()) > 30.0


def test_cars_drive_off_the_map_and_the_ego_vehicle_stops_at_its_edge() -> None:
    layout = layout_of(Road(half_length=60.0), thing("car", 30.0, 0.0))
    tracks = tracks_of(layout, Scenario(), 20.0)
    assert tracks.actors["car_1"].places[-1, 0] > 100.0
    assert 50.0 < tracks.ego.places[-1, 0] < 60.0


def test_a_bus_halts_at_a_shelter_and_goes_on() -> None:
    shelter = thing("other", 60.0, -4.5, name="shelter_1", number=0)
    track = moved(layout_of(Road(half_length=150.0, sidewalk=3.0), thing("bus", 15.0, 0.0), shelter), 30.0)["bus_1"]
    waits = standing(track)
    assert 5.0 < float(waits.sum()) * 0.05 < 12.0
    assert track.places[waits, 0] == pytest.approx(60.0, abs=3.0)
    assert track.places[-1, 0] > 80.0


def test_traffic_begins_without_hard_braking() -> None:
    queue = [thing("car", 10.0 + 12.0 * k, 0.0, number=1 + k) for k in range(6)]
    tracks = moved(layout_of(Road(half_length=300.0), *queue), 5.0, car_6=AlongLane(4.0))
    for number in range(1, 7):
        speeds = np.diff(tracks[f"car_{number}"].places[:, 0]) / STEP
        assert speeds[0] > 3.0
        assert np.diff(speeds).min() / STEP > -3.0


def test_a_cyclist_keeps_right_and_is_passed_where_there_is_room() -> None:
    cyclist = [thing("bicycle", 30.0, 0.0, name="cyclist_1.a"), thing("rider", 30.0, 0.0, name="cyclist_1.b")]
    for width, passes in ((3.6, True), (2.6, False)):
        road = Road(half_length=300.0, lane_width=width)
        tracks = moved(layout_of(road, *cyclist, thing("car", 8.0, 0.0)), 25.0)
        assert tracks["cyclist_1"].places[-1, 1] == pytest.approx(0.7 - width / 2, abs=0.1)
        assert (tracks["car_1"].places[-1, 0] > tracks["cyclist_1"].places[-1, 0]) == passes
        if passes:
            assert abs(tracks["car_1"].places[-1, 1]) < 0.3


def test_rules_of_a_world_are_those_of_a_sequence_and_its_file_goes_on_alike() -> None:
    road = Road(junction=40.0, half_length=120.0, sidewalk=3.0)
    things = [thing("car", 38.25, 20.0, -math.pi / 2), thing("car", 8.0, 0.0, number=2)]
    layout = layout_of(road, *things, thing("person", 20.0, -3.5, math.pi / 2), lights=True, zebras=(20.0,))
    tracks, world = tracks_of(layout, STANDS, 12.0), World(layout, SMALL)
    world.ego.motion = None
    for _ in range(60):
        world.step(0.1)
    again = World(WorldState.from_json(world.state().to_json()), SMALL)
    for name in ("car_1", "car_2", "person_1"):
        there = tracks.actors[name].at(np.array([6.0]))[0]
        assert world[name].pose[:2] == pytest.approx(there[:2].tolist(), abs=0.5)
    for one in (world, again):
        one.step(3.0)
    assert world.state().to_json() == again.state().to_json()
    assert isinstance(world["person_1"].motion, Walk | None)
