"""The roads of layouts: saved and edited streets are driven, roads that were moved by hand, and guesses."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from lidardraft import (
    Box,
    Layout,
    RoadNetwork,
    SequenceSimulator,
    edit,
    layout_from_boxes,
    layout_from_glb,
    layout_from_text,
    street_scan,
    surround,
)
from lidardraft.formats.glb import write_glb
from lidardraft.scene.check import VEHICLE_LABELS
from lidardraft.scene.road import Road
from lidardraft.scene.road_surfaces import road_surfaces
from lidardraft.scene.scenario import Scenario
from lidardraft.scene.sensor import PRESETS
from lidardraft.scene.street import StreetFrame
from lidardraft.simulation.motion.motions import Ground
from lidardraft.simulation.motion.tracks import tracks_of
from lidardraft.simulation.roads import NoStreetError, with_roads
from lidardraft.streets.street import StreetConfig

SENSOR = PRESETS["vlp16"]
CONFIG = StreetConfig(sensor=SENSOR, poses_per_street=1)
GUESSED = "the lanes of its road are guessed from its"


def saved(layout: Layout, folder: Path) -> Layout:
    path = folder / "saved.layout.json"
    layout.save(path)
    return Layout.load(path)


def drivers(layout: Layout) -> list[str]:
    """The vehicles that move within 3 s."""
    tracks = tracks_of(layout, Scenario(), 3.0)
    vehicles = {box.id.partition(".")[0] for box in layout.boxes() if box.label in VEHICLE_LABELS}
    return [name for name in tracks.actors if name in vehicles]


@pytest.mark.parametrize("number", [1, 6, 27, *(pytest.param(number, marks=pytest.mark.slow) for number in (3, 21))])
def test_a_saved_street_is_driven(number: int, tmp_path: Path) -> None:
    """A bend, a roundabout, a car park; a T-junction, one-way."""
    layout = saved(street_scan(number, seed=4, config=CONFIG).layout, tmp_path)
    tracks = tracks_of(layout, Scenario(), 3.0)
    goes = {name: np.hypot(*track.places[:, :2].T) for name, track in tracks.actors.items()}
    moving = [name for name in drivers(layout) if np.ptp(goes[name]) > 2.0 and goes[name].max() < 57.0]
    assert moving
    # on the road, on the ground as it rises and falls
    ground = Ground(layout)
    heights, label = ground.at(np.concatenate([tracks.actors[name].places for name in moving]))
    assert (label == 1).mean() > 0.99
    for name in moving:
        places = tracks.actors[name].places
        over = places[:, 2] - ground.at(places)[0]
        assert np.ptp(over) < 0.12  # the shapes of the ground are coarse
    assert np.ptp(heights) > 0.03
    frames = [scan.image.depth for scan in SequenceSimulator(layout, SENSOR, frames=2, hz=2, seed=1)]
    assert (frames[0] != frames[1]).mean() > 0.3
    assert not with_roads(layout).notes


def test_a_street_is_driven_as_it_was_before_it_was_saved(tmp_path: Path) -> None:
    layout = street_scan(2, seed=4, config=CONFIG).layout
    before, after = (tracks_of(one, Scenario(), 2.0) for one in (layout, saved(layout, tmp_path)))
    assert before.actors.keys() == after.actors.keys()
    for name, track in before.actors.items():
        assert (track.places == after.actors[name].places).all()


def test_an_edited_street_and_one_around_a_sentence_are_driven(tmp_path: Path) -> None:
    layout = street_scan(2, seed=4, config=CONFIG).layout
    before = drivers(layout)
    layout = edit.remove(layout, before[0])
    after = drivers(saved(layout, tmp_path))
    assert before[0] not in after
    assert len(after) >= len(before) - 3
    assert not with_roads(layout).notes
    around = saved(surround(layout_from_text("a street with two trees on the right", seed=1), seed=1), tmp_path)
    assert sum(name.startswith("around/") for name in drivers(around)) > 3


def test_the_limit_is_that_of_the_district(tmp_path: Path) -> None:
    motorway = layout_from_text("a motorway with a truck")
    for layout in (motorway, saved(motorway, tmp_path), surround(motorway)):
        assert layout.roads is not None
        assert {lane.speed for lane in layout.roads.lanes if lane.kind == "driving"} == {130 / 3.6}
    village = surround(layout_from_text("a street in a village, a car"))
    assert village.roads is not None
    assert village.roads.lane("with_0").speed == 30 / 3.6


@pytest.mark.parametrize("change", ["moved", "resized", "removed"])
def test_roads_that_disagree_with_the_shapes_are_guessed_anew(change: str) -> None:
    layout = layout_from_text("a straight road, a car 20 m ahead", seed=1)
    road = layout["road"]
    if change == "moved":
        x, y, z = road.center
        layout = edit.replace(layout, "road", center=(x, y + 1.0, z))
    elif change == "resized":
        layout = edit.replace(layout, "road", size=(road.size[0], 14.0, 0.0))
    else:
        layout = edit.remove(layout, "road")
    told = "road is not where its roads have it: "
    if change == "removed":
        said = f"{told}no street around it: it has no road under the ego vehicle that could be followed"
        with pytest.raises(NoStreetError, match=said):
            with_roads(layout)
        film = SequenceSimulator(layout, SENSOR, frames=1, detail=False)
        assert film.layout.notes[-1] == surround(layout).notes[-1] == said
        assert film.tracks.actors == {}
        return
    found = with_roads(layout)
    assert found.notes[-1] == f"{told}{GUESSED} shapes"
    assert found.roads is not None
    assert found.roads.street is not None
    assert found.roads.street.road.edge == pytest.approx(road.size[1] / 2 if change == "moved" else 7.0)
    assert SequenceSimulator(layout, SENSOR, frames=1, detail=False).layout.notes == found.notes
    whole = surround(layout, seed=1)
    assert found.notes[-1] in whole.notes
    # and what is saved of it is not guessed again
    assert with_roads(whole).notes == whole.notes
    assert with_roads(whole).roads == whole.roads


def test_a_moved_road_of_a_street_is_noticed_as_well() -> None:
    layout = street_scan(2, seed=4, config=CONFIG).layout
    assert with_roads(layout).roads == layout.roads
    x, y, z = layout["road"].center
    moved = edit.replace(layout, "road", center=(x, y, z - 1.0))
    with pytest.raises(NoStreetError):
        with_roads(moved)


def test_what_a_layout_says_nothing_of_is_guessed_with_a_note() -> None:
    boxes = layout_from_boxes([Box("car", "car", 1, (12.0, 0.0, 0.8), (4.4, 1.8, 1.5), 0.0)])
    bare = Layout(tuple(road_surfaces(Road(lanes=2))))
    picture = dataclasses.replace(bare, coverage=(-0.5, 0.5))
    for layout, source in ((boxes, "boxes"), (bare, "shapes"), (picture, "picture")):
        assert with_roads(layout).notes == (f"{GUESSED} {source}",)
        assert f"{GUESSED} {source}" in surround(layout).notes
        assert layout.notes == ()
    assert with_roads(bare).roads is not None
    assert GUESSED not in "".join(with_roads(layout_from_text("a car")).notes)


def test_the_roads_travel_in_a_model(tmp_path: Path) -> None:
    layout = layout_from_text("a crossroads, a car 20 m ahead", seed=2)
    write_glb(tmp_path / "a.glb", layout)
    again = layout_from_glb(tmp_path / "a.glb")
    assert again.roads == layout.roads
    assert with_roads(again).notes == again.notes


def test_a_whole_street_and_a_map_get_no_street_around_them() -> None:
    street = street_scan(0, seed=4, config=CONFIG).layout
    assert surround(street).notes[-1] == "no street around it: it is a whole street already"
    roads = RoadNetwork(lanes=RoadNetwork(street=StreetFrame(road=Road())).lanes)
    surrounded = surround(Layout(tuple(road_surfaces(Road())), roads=roads))
    assert surrounded.notes[-1].startswith("no street around it: its roads are those of a map")


def test_a_map_is_driven() -> None:
    """Lanes of their own in place of those of a street, joined into ways."""
    layout = layout_from_text("a crossroads, a car 20 m ahead", seed=2)
    assert layout.roads is not None
    lanes, junctions = layout.roads.lanes, layout.roads.junctions
    of_map = dataclasses.replace(layout, roads=RoadNetwork(lanes=lanes, junctions=junctions))
    one, two = (tracks_of(given, Scenario(), 3.0) for given in (layout, of_map))
    assert one.actors.keys() == two.actors.keys() != set()
    assert one.ego.places == pytest.approx(two.ego.places, abs=1e-6)
