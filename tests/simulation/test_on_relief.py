"""Layouts on their relief, by an independent look at both: the plan stays, and objects keep their height."""

import dataclasses
import math
import re

import numpy as np
import pytest

from lidardraft import (
    Box,
    Layout,
    Primitive,
    Sensor,
    Simulator,
    World,
    edit,
    layout_from_boxes,
    layout_from_text,
    on_relief,
    raycast,
    simulate,
    surround,
)
from lidardraft.drafting.solver.layout import layout_from_spec
from lidardraft.errors import LayoutError, LidarDraftError
from lidardraft.scene.check import check, objects
from lidardraft.scene.layout import object_of
from lidardraft.scene.relief import Relief
from lidardraft.scene.road import Road
from lidardraft.scene.sensor import PRESETS
from lidardraft.semantics import BY_NAME, GROUND
from lidardraft.simulation.motion.motions import Ground
from lidardraft.simulation.motion.sequence import SequenceSimulator
from lidardraft.world.state import WorldState
from random_spec import random_spec

SENSOR = Sensor(name="fine", elevations=tuple(np.deg2rad(np.linspace(3, -20, 40)).tolist()), columns=720)
SENTENCES = (
    "a country road with a bus on the left and a fence on the right",
    "a crossroads, a car 20 m ahead and two people on the right sidewalk",
    "a car comes towards us around a bend",
    "a roundabout with three cars",
)


def street(sentence: str, seed: int = 3) -> Layout:
    return surround(layout_from_text(sentence, seed=seed), seed=seed)


def relief_of(layout: Layout) -> Relief:
    assert layout.roads is not None
    assert layout.roads.relief is not None
    return layout.roads.relief


def test_ground_is_cut_where_it_bends_and_stays_as_far_over_other_ground() -> None:
    rng = np.random.default_rng(0)
    x, y = np.sort(rng.uniform(-90, 90, 30)), np.sort(rng.uniform(-60, 60, 20))
    relief = Relief(x, y, rng.normal(0.0, 0.4, (30, 20)), (3.0, -2.0, 0.7))
    assert Relief.read(relief.written(), "relief").written() == relief.written()
    for primitive in street(SENTENCES[2]):
        if primitive.label in GROUND:
            laid = on_relief(_alone(primitive, relief))[primitive.id]
            flat = Ground(Layout((primitive,)))
            places = rng.uniform(-100.0, 100.0, (400, 2))
            height, label = Ground(Layout((laid,))).at(places)
            level, as_before = flat.at(places)
            assert np.array_equal(label > 0, as_before > 0)
            seen = label > 0
            np.testing.assert_allclose(height[seen], (level + relief.at(places))[seen], atol=1e-4)


def _alone(primitive, relief: Relief) -> Layout:
    roads = street(SENTENCES[0]).roads
    assert roads is not None
    return Layout((primitive,), roads=roads.but(relief=relief))


def test_what_is_no_relief_is_refused() -> None:
    for x, heights, message in (
        ([0.0, 1.0, 1.0], np.zeros((3, 2)), "relief: x has 3 lines; it must have two or more that increase"),
        ([0.0, 1.0], np.zeros((3, 2)), r"heights are \(3, 2\); they must be 2 by 2"),
        ([0.0, math.nan], np.zeros((2, 2)), "must be finite"),
    ):
        with pytest.raises(LayoutError, match=message):
            Relief(x, [0.0, 1.0], heights)
    layout = street(SENTENCES[0])
    with pytest.raises(LidarDraftError, match="heights"):
        Layout.from_json(layout.to_json().replace('"heights": [[', '"heights": [[[], ', 1))


@pytest.mark.parametrize("sentence", SENTENCES)
def test_the_plan_stays_and_things_stand_on_the_ground(sentence: str) -> None:
    level = street(sentence)
    hilly = on_relief(level)
    assert on_relief(hilly) is hilly
    assert Layout.from_json(level.to_json()) == level
    assert Layout.from_json(hilly.to_json()).primitives == hilly.primitives
    assert np.ptp(relief_of(level).heights) > 0.5
    assert abs(relief_of(level).at(np.zeros((1, 2)))[0]) < 1e-9
    ground = Ground(hilly)
    before, after = objects(level), objects(hilly)
    assert before.keys() == after.keys()
    for name, parts in after.items():
        same = [part for part in parts if ".piece_" not in part.id]
        if len(same) == len(parts) and parts[0].label not in ("wall", "fence", "vegetation"):
            plans = ([(p.id, p.center[:2], p.size, p.yaw) for p in some] for some in (before[name], parts))
            assert next(plans) == next(plans)
        bottom = min(part.center[2] - part.size[2] / 2 for part in parts)
        feet = np.array([p.center for p in parts if p.center[2] - p.size[2] / 2 < bottom + 0.01])
        over = bottom - float(ground.at(feet.mean(axis=0)[None])[0][0])
        was = min(p.center[2] - p.size[2] / 2 for p in before[name])
        was -= float(Ground(level).at(feet.mean(axis=0)[None])[0][0])
        is_building = any(part.label == "building" for part in parts)
        assert over - was < 0.05
        assert over - was > (-3.0 if is_building else -0.05), name


@pytest.mark.parametrize("sentence", SENTENCES[:2])
def test_boxes_are_around_their_returns_and_off_it_lies_level(sentence: str) -> None:
    layout = street(sentence)
    simulator = Simulator(layout, SENSOR, seed=3)
    scan = simulator.scan(seed=3)
    points, instances = scan.points(), scan.image.instance[scan.image.depth > 0]
    for box in scan.boxes():
        own = points[instances == box.instance]
        if len(own) > 30:
            assert box.contains(own, margin=0.3).mean() > 0.97, box.id


def test_without_relief_all_lies_level_and_bare_layouts_are_scanned_as_they_are() -> None:
    layout = street(SENTENCES[0])
    roads = layout.roads
    assert roads is not None
    level = simulate(layout, SENSOR, seed=3, relief=False)
    assert level.layout.primitives == layout.primitives
    bare = edit.remove(layout, "around/*")
    without = dataclasses.replace(bare, roads=roads.but(relief=None))
    for one, other in ((bare, without), (layout_from_text(SENTENCES[0], seed=3), None)):
        scans = [simulate(one, SENSOR, seed=3, relief=False), simulate(other or one, SENSOR, seed=3)]
        assert len({scan.image.depth.tobytes() for scan in scans}) == 1
    casts = [raycast(each, SENSOR).depth.tobytes() for each in (bare, without)]
    assert casts[0] == casts[1]
    with pytest.raises(TypeError, match="relief is a int; it must be a bool"):
        simulate(layout, SENSOR, relief=1)  # type: ignore[arg-type]


def test_layouts_that_say_how_their_ground_lies_have_no_relief() -> None:
    boxes = layout_from_boxes([Box("car_1", "car", 1, (14.0, 0.0, 0.8), (4.2, 1.8, 1.6), 0.0)])
    plane = Primitive(shape="plane", center=(0, 0, -0.3), size=(300, 300, 0), label="terrain", id="ground", open=True)
    road = Primitive(shape="plane", center=(0, 0, 0), size=(200, 7, 0), label="road", id="road")
    for layout in (boxes, Layout((plane,), {}, (-0.6, 0.6)), Layout((dataclasses.replace(plane, open=False), road))):
        whole = surround(layout, seed=1)
        assert len(whole) > 50
        assert whole.roads is not None
        assert whole.roads.relief is None


@pytest.mark.parametrize(
    "numbers", [range(4), *(pytest.param(range(n, n + 100), marks=pytest.mark.slow) for n in range(0, 1000, 100))]
)
def test_random_specs_pass_all_checks_on_their_relief(numbers: range) -> None:
    for number in numbers:
        try:
            level = surround(
                layout_from_spec(random_spec(np.random.default_rng([7, number])), seed=number), seed=number
            )
        except LayoutError:
            continue
        before = {finding.message for finding in check(level)}
        found = [one for one in check(on_relief(level)) if re.sub(r"\.piece_\d+", "", one.message) not in before]
        # on slopes buildings stand in the ground, and crowns and bushes may meet
        assert [one for one in found if not all(id.startswith("around/") for id in one.ids)] == [], number
        assert [one for one in found if one.check not in ("overlap", "grounded")] == [], number


def test_what_drives_and_walks_follows_the_ground() -> None:
    layout = street("a country road, a car 20 m ahead and a car coming towards us")
    drive = SequenceSimulator(layout, SENSOR, frames=30, hz=10.0, seed=3)
    ground = Ground(drive.layout)
    assert np.ptp([drive.pose(number)[2, 3] for number in range(30)]) > 0.01
    for number in (0, 20):
        pose = drive.pose(number)
        below = float(ground.at(pose[None, :3, 3])[0][0])
        assert pose[2, 3] - SENSOR.mount_height == pytest.approx(below, abs=0.03)
        for id in ("car_1", "car_2"):
            part = drive.frame(number).layout[id]
            over = part.center[2] - part.size[2] / 2 - float(ground.at(np.array([part.center]))[0][0])
            assert over == pytest.approx(0.0, abs=0.06)


def test_kerbs_of_a_street_have_a_height_of_their_own_and_land_behind_sidewalks_no_step() -> None:
    kerbs = set()
    for seed in range(4):
        layout = street("a street in a town", seed=seed)
        assert layout.roads is not None
        assert layout.roads.street is not None
        road, ground = layout.roads.street.road, Ground(on_relief(layout))
        along = np.linspace(-30.0, 30.0, 41)

        def heights(across: float, road: Road = road, along: np.ndarray = along, ground: Ground = ground) -> np.ndarray:
            return ground.at(np.array([road.at(s, across)[:2] for s in along.tolist()]))[0]

        kerb = heights(road.edge + 0.01) - heights(road.edge - 0.04)
        assert np.ptp(kerb) < 0.01
        assert 0.0 <= kerb.min() <= kerb.max() < 0.125
        kerbs.add(round(float(kerb[0]), 3))
        for side in (-1, 1):
            behind = heights(side * (road.verge + 0.2)) - heights(side * (road.verge - 0.05))
            assert np.abs(behind).max() < 0.15
    assert len(kerbs) == 4


def test_a_world_stands_on_the_relief_of_its_layout_and_keeps_it() -> None:
    layout = street(SENTENCES[0])
    world = World(layout, SENSOR, seed=3)
    assert {part.id: part for part in world.layout()}.keys() >= {p.id for p in on_relief(layout)}
    assert all(world.layout()[part.id] == part for part in on_relief(layout).primitives[:40])
    again = World(WorldState.from_json(world.state().to_json()), SENSOR)
    assert again.scan().image.depth.tobytes() == world.scan().image.depth.tobytes()
    ground = Ground(world.layout())
    name = world.add("van", (12.0, 30.0))
    body = [part for part in world.layout() if object_of(part) == name]
    bottom = min(part.center[2] - part.size[2] / 2 for part in body)
    assert bottom == pytest.approx(float(ground.at(np.array([(12.0, 30.0)]))[0][0]), abs=1e-3)
    assert World(layout, SENSOR, seed=3, relief=False).layout().primitives == layout.primitives
    with pytest.raises(LayoutError, match="relief is False; it must be left out"):
        World(world.state(), SENSOR, relief=False)


@pytest.mark.parametrize("name", ["hdl64e", "os1-128", "vlp16"])
def test_every_sensor_sees_the_road_at_its_mount_and_slopes_ahead(name: str) -> None:
    scan = simulate(SENTENCES[1], PRESETS[name], seed=5)
    points = scan.points() + np.array([0.0, 0.0, PRESETS[name].mount_height])
    road = points[scan.labels() == BY_NAME["road"].id]
    near = np.hypot(road[:, 0], road[:, 1]) < 8.0
    assert abs(np.median(road[near, 2])) < 0.06
    assert np.abs(road[:, 2]).max() > 0.1
