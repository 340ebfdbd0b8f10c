"""Road networks: what a planner asks of lanes, what a file of them may hold, and networks that cannot be."""

import itertools
import json
import math
from collections.abc import Callable, Iterator
from functools import cache

import numpy as np
import pytest

from lidardraft import Layout, Raycaster, layout_from_text
from lidardraft.errors import FormatError, LayoutError, UnknownNameError
from lidardraft.scene.lane import Crossing, Junction, Lane, Pavement, Signal
from lidardraft.scene.line import Line
from lidardraft.scene.road import LEFT, RIGHT, PavedArea, Road
from lidardraft.scene.road_network import Drawn, RoadNetwork
from lidardraft.scene.sensor import PRESETS
from lidardraft.scene.street import StreetFrame
from lidardraft.semantics import GROUND
from lidardraft.streets.pairs import sample_viewpoint
from lidardraft.streets.scans import street_scan
from lidardraft.streets.street import StreetConfig, make_street

SENTENCES = (
    "a car ahead",
    "a crossroads with a bus",
    "a T-junction with a car turning left",
    "a roundabout with two cars",
    "a motorway with three lanes and a truck",
    "a left bend with a truck 30 m ahead",
    "a right bend with a crossroads",
    "a quiet one-way street with parked cars on both sides",
    "a parking lot full of cars",
    "a road with two lanes and a median, traffic lights",
)
CONFIG = StreetConfig(sensor=PRESETS["vlp16"], poses_per_street=1)


@cache
def layouts() -> list[Layout]:
    """50 of sentences and 10 of streets."""
    texts = [layout_from_text(sentence, seed=seed) for sentence in SENTENCES for seed in range(5)]
    streets = []
    for number in range(10):
        street = make_street(seed=4, config=CONFIG, number=number)
        ego, _, _ = sample_viewpoint(street, CONFIG.sensor, number)
        streets.append(street.with_roads(Layout(), ego.pose, relief=True))
    return [*texts, *streets]


def networks() -> Iterator[RoadNetwork]:
    for layout in layouts():
        assert layout.roads is not None
        yield layout.roads


def begins(lane: Lane) -> tuple[np.ndarray, float]:
    return lane.line.middle[0], float(lane.line.heading(np.zeros(1))[0])


def ends(lane: Lane) -> tuple[np.ndarray, float]:
    return lane.line.middle[-1], float(lane.line.heading(np.array([lane.line.length]))[0])


def test_places_on_a_lane_are_found_again() -> None:
    rng, alone = np.random.default_rng(1), 0
    for network in networks():
        for lane in network.lanes:
            along, left = rng.uniform(0.0, lane.line.length), rng.uniform(-0.3, 0.3)
            (x, y), (heading,) = (
                lane.line.at(np.array([along]), np.array([left]))[0],
                lane.line.heading(np.array([along])),
            )
            found, on, beside = network.nearest_lane(x, y, yaw=float(heading), kinds=None)
            assert abs(beside) <= abs(left) + 0.02, (lane.id, found.id)
            assert found.line.at(np.array([on]), np.array([beside]))[0] == pytest.approx((x, y), abs=0.1)
            if lane.junction is None and 0.5 < along < lane.line.length - 0.5:
                alone += 1
                assert found is lane, (found.id, lane.id)
                assert (on, beside) == pytest.approx((along, left), abs=0.05)
    assert alone > 400


def test_lanes_meet_their_successors_in_their_direction() -> None:
    pairs = [(lane, after) for network in networks() for lane in network.lanes for after in network.successors(lane)]
    assert len(pairs) > 400
    for lane, after in pairs:
        (end, out), (begin, into) = ends(lane), begins(after)
        assert math.dist(end, begin) < 1e-6
        assert abs(math.remainder(out - into, math.tau)) < 0.25, (lane.id, after.id)


def test_lanes_beside_lead_the_same_way_a_lane_further() -> None:
    beside = 0
    for network in networks():
        for lane in network.lanes:
            for id, sign in ((lane.left, 1), (lane.right, -1)):
                if id is None:
                    continue
                beside += 1
                other = network.lane(id)
                middle = other.line.at(np.array([other.line.length / 2]), np.zeros(1))
                _, (left,) = lane.line.along_across(middle)
                assert left * sign == pytest.approx((lane.width + other.width) / 2, abs=0.1)
                assert lane.id in (other.left, other.right)
    assert beside > 100


def test_a_route_leads_to_whatever_can_be_reached_and_nowhere_else() -> None:
    routed = 0
    for network in networks():
        driven = [lane for lane in network.lanes if lane.kind == "driving"]
        for start in [lane for lane in driven if lane.id.endswith((".in", "_in")) or ".in_" in lane.id][:3]:
            reached, ahead = {start.id}, [start]
            while ahead:
                lane = ahead.pop()
                for id in (*lane.successors, *filter(None, (lane.left, lane.right))):
                    if id not in reached:
                        reached.add(id)
                        ahead.append(network.lane(id))
            for lane in driven:
                if lane.id not in reached:
                    with pytest.raises(LayoutError, match=f"no way leads from lane {start.id} to lane {lane.id}"):
                        network.route(start.id, lane.id)
                    continue
                route = network.route(start.id, lane.id)
                assert (route[0], route[-1]) == (start, lane)
                for one, two in itertools.pairwise(route):
                    assert two.id in (*one.successors, one.left, one.right)
                routed += 1
    assert routed > 300


def test_each_leg_of_a_junction_leads_to_each_other_and_a_roundabout_as_well() -> None:
    for road in (Road(junction=30.0), Road(junction=20.0, roundabout_radius=18.0), Road(curvature=0.01, junction=30.0)):
        network = RoadNetwork(street=StreetFrame(road=road))
        ways_in = ["with_0.in", "against_0.in", "left.in_0", "right.in_0"]
        ways_out = ["against_0.out", "with_0.out", "left.out_0", "right.out_0"]
        for number, start in enumerate(ways_in):
            for end in [*ways_out[:number], *ways_out[number + 1 :]]:
                assert all(lane.junction == "junction" for lane in network.route(start, end)[1:-1])
        assert {lane.id for lane in network.lanes if lane.junction} == set(network.junctions[0].lanes)


def test_turns_lead_to_their_side_and_the_shorter_way_is_taken() -> None:
    network = RoadNetwork(street=StreetFrame(road=Road(lanes=2, junction=30.0)))
    left = network.lane("with_0.in>left.out_0")
    assert (left.turn, left.bend) == ("left", (0.0, left.line.length))
    assert network.lane("with_1.in>right.out_0").turn == "right"
    assert network.lane("with_1.in>with_1.out").turn is None
    assert [lane.id for lane in network.route("with_0.in", "with_1.out")] in (
        ["with_0.in", "with_1.in", "with_1.in>with_1.out", "with_1.out"],
        ["with_0.in", "with_0.in>with_0.out", "with_0.out", "with_1.out"],
    )


def test_the_lanes_of_a_street_say_how_they_are_used() -> None:
    road = Road(lanes=2, junction=30.0, parking=2.0)
    aisles = ((20.0, -10.0, 30.0),)
    network = RoadNetwork(street=StreetFrame(road=road, speed=14.0, parked=(), aisles=aisles, lights=True))
    kinds = {kind: [lane for lane in network.lanes if lane.kind == kind] for kind in ("aisle", "parking", "sidewalk")}
    assert [len(lanes) for lanes in kinds.values()] == [2, 4, 4]
    assert {lane.speed for lane in kinds["aisle"]} == {10 / 3.6}
    assert {lane.width for lane in kinds["parking"]} == {2.0}
    assert {lane.road for lane in network.lanes if lane.id.startswith("left.") and not lane.junction} == {"left"}
    side = network.lane("right.in_0")
    assert side.stop == pytest.approx(road.half_length - road.verge - 2.0)
    assert network.lane("with_0.in").stop is None
    assert len(network.signals) == 8
    for signal in network.signals:
        lane, along, left = network.nearest_lane(*signal.place[:2], yaw=signal.place[2])
        assert (lane.id,) == signal.lanes
        assert abs(left) < 1e-6
        assert 1.0 < lane.line.length - along < 4.0


def test_ways_are_where_lanes_are() -> None:
    """But for a side road: of several lanes it has one way, and at a T-junction that goes on to the far kerb."""
    for network in networks():
        assert network.street is not None
        road = network.street.road
        if road.lanes > 1 or road.parking or (road.junction and (road.curvature or len(road.side_roads) == 1)):
            continue
        for way in network.ways():
            along = np.linspace(1.0, way.line.length - 1.0, 40)
            for x, y in way.line.at(along, np.zeros(40)):
                _, _, left = network.nearest_lane(x, y, kinds=("driving", "aisle"))
                assert abs(left) < 0.8, way.id


def test_heights_and_normals_are_those_of_the_ground() -> None:
    rng, off, turned, steep = np.random.default_rng(2), [], [], 0.0
    for number in range(8):
        layout = street_scan(number, seed=4, config=CONFIG).layout
        network, caster = layout.roads, Raycaster(Layout(tuple(p for p in layout if p.label in GROUND)))
        assert network is not None

        def ground(points: np.ndarray, caster: Raycaster = caster) -> np.ndarray:
            origins = np.column_stack([points, np.full(len(points), 100.0)])
            hits = caster.cast(origins, np.tile((0.0, 0.0, -1.0), (len(points), 1)))
            assert hits.valid.all()
            return 100.0 - hits.distance

        for lane in network.lanes:
            along = rng.uniform(1.0, max(1.0, lane.line.length - 1.0), 3)
            places = lane.line.at(along, np.zeros(3))
            near = np.hypot(*places.T) < 60.0
            for (x, y), s in zip(places[near], along[near], strict=True):
                if lane.kind == "driving":
                    off.append(network.height(x, y) - ground(np.array([[x, y]]))[0])
                    steps = np.array([[3, 0], [-3, 0], [0, 0.5], [0, -0.5]])
                    around = ground(steps + np.array([x, y]))
                    if lane.junction is None:
                        seen = np.array([(around[1] - around[0]) / 6, (around[3] - around[2]), 1.0])
                        turned.append(math.acos(min(1.0, float(seen @ network.normal(x, y) / np.linalg.norm(seen)))))
                        steep = max(steep, math.acos(network.normal(x, y)[2]))
                assert lane.line.height(s) == pytest.approx(network.height(x, y), abs=0.2)
    assert len(off) > 100
    assert np.quantile(np.abs(off), 0.95) < 0.08  # waves are shorter than the pieces of lanes
    assert np.median(turned) < 0.01
    assert steep > 0.03  # what a level road would miss


def test_a_network_is_the_same_after_json_bit_for_bit() -> None:
    for network in (*networks(), bridge()):
        again = RoadNetwork.from_dict(json.loads(json.dumps(network.to_dict())))
        assert again == network
        assert again.to_dict() == network.to_dict()
        for one, two in zip((*network.lanes, *network.ways()), (*again.lanes, *again.ways()), strict=True):
            assert (one.id, one.kind, one.stop, one.successors) == (two.id, two.kind, two.stop, two.successors)
            for name in ("middle", "normals", "along", "heights", "camber"):
                assert (getattr(one.line, name) == getattr(two.line, name)).all()


def test_a_layout_keeps_its_roads() -> None:
    for layout in layouts()[::7]:
        again = Layout.from_json(layout.to_json())
        assert again == layout
        assert again.roads == layout.roads
        assert again.roads is not layout.roads


def lane(id: str, points: object, **more: object) -> Lane:
    fields: dict[str, object] = {"width": 3.5, "speed": 14.0, **more}
    return Lane(id=id, line=Line.through(points), **fields)  # type: ignore[arg-type]


def bridge() -> RoadNetwork:
    """As a reader of maps would build it: a road that passes under a bridge, and a ramp that turns off it."""
    up = np.linspace(0.0, math.pi / 2, 12)
    ramp = np.column_stack([20.0 + 30.0 * np.sin(up), 30.0 * (1.0 - np.cos(up)), up * 2.0])
    return RoadNetwork(
        lanes=(
            lane("under", [(-60.0, 0.0, 0.0), (20.0, 0.0, 0.0)], road="1", successors=("on", "ramp"), right="bus"),
            lane("bus", [(-60.0, -3.5, 0.0), (20.0, -3.5, 0.0)], road="1", left="under"),
            lane("on", [(20.0, 0.0, 0.0), (80.0, 0.0, 0.6)], road="1", junction="exit"),
            lane("ramp", ramp, road="2", turn="left", junction="exit", bend=(0.0, 47.0)),
            lane("over", [(0.0, -50.0, 6.0), (0.0, 50.0, 6.5)], road="3", stop=40.0),
            lane("walk", [(3.0, -50.0, 6.1), (3.0, 50.0, 6.6)], road="3", kind="sidewalk", width=1.5),
        ),
        junctions=(Junction(id="exit", lanes=("on", "ramp")),),
        crossings=(Crossing(id="zebra", place=(-20.0, 0.0, 0.0), size=(4.0, 7.0)),),
        signals=(Signal(id="light", place=(0.0, -10.0, 1.57), lanes=("over",)),),
        paved=(Pavement(place=(0.0, 30.0, 0.0), size=(8.0, 20.0), label="road"),),
        drawn=(Drawn("asphalt", (-60.0, -5.0, 0.0), (80.0, 2.0, 0.6)),),
    )


def test_a_map_has_several_roads_and_levels() -> None:
    network = bridge()
    assert network.nearest_lane(0.2, 0.1, 0.0)[0].id == "under"
    assert network.nearest_lane(0.2, 0.1, 6.0)[0].id == "over"
    assert network.nearest_lane(0.2, 0.1, 6.0, yaw=-0.2)[0].id == "under"
    assert network.nearest_lane(3.0, 10.0, 6.5, kinds=None)[0].id == "walk"
    assert (network.height(0.0, 0.0, 0.0), network.height(0.0, 0.0, 7.0)) == pytest.approx((0.0, 6.25))
    assert network.normal(0.0, 0.0, 7.0) == pytest.approx((0.0, -0.005, 1.0), abs=1e-4)
    assert network.normal(50.0, 0.0) == pytest.approx((-0.01, 0.0, 1.0), abs=1e-3)
    assert [lane.id for lane in network.route("bus", "ramp")] == ["bus", "under", "ramp"]
    ways = {way.id: way for way in network.ways()}
    assert set(ways) == {"way.on", "way.ramp", "way.bus", "way.over"}
    assert ways["way.on"].line.length == pytest.approx(140.0)
    assert ways["way.ramp"].bend == pytest.approx((80.0, 80.0 + network.lane("ramp").line.length))
    assert (ways["way.ramp"].turn, ways["way.over"].stop) == ("left", 40.0)
    with pytest.raises(UnknownNameError, match="no lane has the id 'ovr'; did you mean 'over'"):
        network.lane("ovr")
    with pytest.raises(LayoutError, match="the network has no lane of cycling"):
        network.nearest_lane(0.0, 0.0, kinds=("cycling",))


@pytest.mark.parametrize("network", [bridge, lambda: RoadNetwork(street=StreetFrame(road=Road(curvature=0.01)))])
def test_a_moved_network_is_as_it_was_from_its_new_place(network: Callable[[], RoadNetwork]) -> None:
    here = network()
    there = here.moved((10.0, -4.0, 0.5))
    for one, two in zip(here.lanes, there.lanes, strict=True):
        turn = np.array([[math.cos(0.5), math.sin(0.5)], [-math.sin(0.5), math.cos(0.5)]])
        assert two.line.middle == pytest.approx(one.line.middle @ turn + (10, -4))
        assert two.line.heading(np.array([5.0])) == pytest.approx(one.line.heading(np.array([5.0])) + 0.5)


def of_json(change) -> RoadNetwork:
    fields = json.loads(json.dumps(bridge().to_dict()))
    change(fields)
    return RoadNetwork.from_dict(fields)


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        (lambda f: f["lanes"][2]["line"].update(points=[[20, 3], [80, 0]]), LayoutError, "under ends 3.0 m from its"),
        (lambda f: f["lanes"][0].update(width=-3.0), LayoutError, "lane under: width is -3.0; it must be a number"),
        (lambda f: f["lanes"][0].update(speed=0.0), LayoutError, "lane under: speed is 0.0; it must be a number"),
        (lambda f: f["junctions"][0].update(lanes=[]), LayoutError, "junction exit has no lanes through it"),
        (lambda f: f["lanes"][0].update(successors=["of"]), LayoutError, "under refers to 'of', which the network"),
        (lambda f: f["signals"][0].update(lanes=["ovr"]), LayoutError, "light refers to 'ovr', .*; did you mean"),
        (lambda f: f["lanes"][2].update(junction="exi"), LayoutError, "on refers to 'exi', .*; did you mean 'exit'"),
        (lambda f: f["lanes"][1].update(id="under"), LayoutError, "two lanes have the id 'under'"),
        (lambda f: f["lanes"][0].update(kind="rail"), LayoutError, "lane under: kind is 'rail'; it must be"),
        (lambda f: f["lanes"][0].update(turn="back"), LayoutError, "lane under: turn is 'back'; it must be"),
        (lambda f: f["lanes"][4].update(stop=101.0), LayoutError, "lane over: stop is 101.0; it must be 0 to 100.0 m"),
        (lambda f: f["lanes"][0].update(width="3.5"), FormatError, r"lanes\[0\].width is '3.5'; it must be"),
        (lambda f: f["lanes"][0].update(widht=3.5), FormatError, r"unknown field lanes\[0\].widht"),
        (lambda f: f["lanes"][0].pop("line"), FormatError, r"lanes\[0\].line is missing"),
        (lambda f: f["lanes"][0]["line"].update(points=[[1, 2]]), LayoutError, r"lanes\[0\].line: points has shape"),
        (lambda f: f["lanes"][0]["line"].update(points=[[1, 2], [1, 2]]), LayoutError, "points 0 and 1 are the same"),
        (lambda f: f["lanes"][0]["line"].update(points=[[1, 2], [1, math.nan]]), LayoutError, r"points\[1, 1\] is nan"),
        (lambda f: f["lanes"][0].update(bend=[1.0]), FormatError, r"lanes\[0\].bend is \[1.0\]; it must be a list"),
        (lambda f: f.update(lane=[]), FormatError, "unknown field 'lane'"),
        (lambda f: f.update(lanes={}), FormatError, "lanes is {}; it must be a list"),
        (lambda f: f.update(street={"road": {}}), LayoutError, "the network has a street and other lanes"),
    ],
)  # fmt: skip
def test_a_network_that_cannot_be_gets_one_line(change, error, message) -> None:
    with pytest.raises(error, match=message) as caught:
        of_json(change)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("street", "error", "message"),
    [
        ({"road": {"lanes": 9}}, LayoutError, "lanes is 9; it must be 1 to 6"),
        ({"road": {"lanes": "2"}}, FormatError, "street.road.lanes is '2'; it must be a whole number"),
        ({"road": {}, "place": [0, 0]}, FormatError, "street.place is .*; it must be a list of 3"),
        ({"road": {}, "lights": 1}, FormatError, "street.lights is 1; it must be true or false"),
        ({"road": {"junction": float("inf")}}, FormatError, "street.road.junction is inf; it must be a finite number"),
        ({}, FormatError, "street.road is missing"),
        ({"road": {}, "speed": 0}, LayoutError, "street: speed is 0; it must be over 0 m/s, or null"),
        ({"road": {}, "parked": [2]}, LayoutError, r"street: parked is \(2,\); it must be of 1 \(left\) and -1"),
        ({"road": {}, "ends": [9, 1]}, LayoutError, r"street: ends is \(9, 1\); it must be from less to more"),
        (
            {"road": {}, "relief": [[[0, 0], [1, 0]]]},
            LayoutError,
            "street: relief is of 1 lines; it must be of all",
        ),
    ],
)
def test_a_street_that_cannot_be_gets_one_line(street, error, message) -> None:
    with pytest.raises(error, match=message):
        _ = RoadNetwork.from_dict({"street": street}).lanes


def test_a_street_with_all_that_it_may_have_is_read_back() -> None:
    street = StreetFrame(
        road=Road(junction=20.0, side_roads=(LEFT,), paved_areas=(PavedArea((1.0, 2.0), (9.0, 30.0)),)),
        place=(1.0, 2.0, 0.1),
        lacks=("sidewalk",),
        paved=(Pavement(place=(1.0, 2.0, 3.0), size=(4.0, 5.0), label="road"),),
        ends=(-20.0, 33.0),
        speed=9.0,
        parked=(RIGHT,),
        one_way=True,
        aisles=((20.0, 0.0, 30.0),),
        lights=True,
    )
    network = RoadNetwork(street=street, drawn=())
    again = RoadNetwork.from_dict(json.loads(json.dumps(network.to_dict())))
    assert (again.street, again.drawn) == (street, ())


def test_a_line_follows_what_it_goes_through() -> None:
    arc = np.linspace(0.0, 1.0, 26)
    line = Line.through(50.0 * np.column_stack([np.sin(arc), 1.0 - np.cos(arc), arc / 100]), camber=np.full(26, 0.02))
    assert line.length == pytest.approx(50.0, abs=0.01)
    along, across = np.array([5.0, 30.0, 44.0]), np.array([2.0, -3.0, 0.0])
    assert line.along_across(line.at(along, across))[0] == pytest.approx(along, abs=0.1)
    assert line.along_across(line.at(along, across))[1] == pytest.approx(across, abs=0.02)
    assert line.heading(along) == pytest.approx(along / 50.0, abs=0.01)
    assert line.height(along, across) == pytest.approx(along / 100 + 0.02 * across, abs=0.01)
    # uphill and to the left
    assert line.normal(0.0) == pytest.approx((-0.01, -0.02, 1.0), abs=1e-3)
    behind = np.array([[-4.0, 1.0]])
    assert line.along_across(behind)[0] == pytest.approx(-4.0, abs=0.1)
    assert line.along_across(behind, beyond=False)[0] == 0.0
